//! An order: what a person decides about a drawing and a job, and the way from there to a certified plan.

use keepout_kernel::exact::segment::Window;
use thiserror::Error;

use crate::drawing::{
    CURVE_MM, Chained, Drawing, DrawingError, DxfFile, EntityFilter, JOIN_MM, Repair, chain, curves_of, read,
};
use crate::machine::MachineProfile;
use crate::plan::{CertifiedPlan, Plan, PlanError, PlanGeometry, PlanParameters, Provenance, Remark};
use crate::plan_file;
use crate::profile::Profile;
use crate::select::{SelectError, Selection};
use crate::text_file::shown;

/// What a person decides.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanRequest {
    /// What is taken from the drawing.
    pub choice: EntityFilter,
    /// Gaps up to this are closed, mm.
    pub join_mm: f64,
    /// Splines and ellipses become arcs and lines within this, mm.
    pub curve_mm: f64,
    /// Which contours make the part.
    pub selection: Selection,
    /// Layers whose closed contours the tool keeps out of besides the part: clamps, a vice.
    pub keep_out_layers: Vec<String>,
    /// The layer of a rectangle that the tool's centre stays in.
    pub travel_layer: Option<String>,
    /// Tool, side, stocks_to_leave, passes.
    pub job: PlanParameters,
}

impl Default for PlanRequest {
    fn default() -> Self {
        Self {
            choice: EntityFilter::default(),
            join_mm: JOIN_MM,
            curve_mm: CURVE_MM,
            selection: Selection::default(),
            keep_out_layers: Vec::new(),
            travel_layer: None,
            job: PlanParameters::default(),
        }
    }
}

/// Why there is no plan.
#[derive(Debug, Error)]
pub enum PlanRequestError {
    /// The drawing can not be used.
    #[error(transparent)]
    Drawing(#[from] DrawingError),
    /// The selection leaves nothing.
    #[error(transparent)]
    Select(#[from] SelectError),
    /// The machine's travel is drawn as something else than a rectangle.
    #[error(
        "layer \"{layer}\" must hold the machine's travel and nothing else: one rectangle along the axes, after turning. It holds {count} closed contours."
    )]
    Stroke {
        /// The layer.
        layer: String,
        /// Its closed contours.
        count: usize,
    },
    /// No plan can be made of it.
    #[error(transparent)]
    Plan(#[from] PlanError),
}

/// A stage on the way to a plan, for those who wait.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// The file is read.
    Reading,
    /// Curves are joined.
    Joining,
    /// The part's contours are checked.
    Checking,
    /// The finishing path is sought.
    Offsetting,
    /// The finishing path is certified.
    Certifying,
}

impl Stage {
    /// The number of stages.
    pub const COUNT: u64 = 5;

    /// How many come before.
    #[must_use]
    pub fn number(self) -> u64 {
        match self {
            Self::Reading => 0,
            Self::Joining => 1,
            Self::Checking => 2,
            Self::Offsetting => 3,
            Self::Certifying => 4,
        }
    }
}

impl std::fmt::Display for Stage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Reading => "reading the drawing",
            Self::Joining => "joining curves to contours",
            Self::Checking => "checking the contours",
            Self::Offsetting => "seeking the finishing path",
            Self::Certifying => "certifying the finishing path",
        })
    }
}

impl PlanRequest {
    /// The drawing's contours, chained and not yet selected.
    ///
    /// # Errors
    /// [`DrawingError`].
    pub fn contours(&self, bytes: &[u8]) -> Result<(Drawing, Chained), DrawingError> {
        let drawing = curves_of(&read(bytes)?, &self.part_choice())?;
        let chained = chain(&drawing, self.join_mm, self.curve_mm)?;
        Ok((drawing, chained))
    }

    /// What is taken for the part: not the layers that say something else.
    fn part_choice(&self) -> EntityFilter {
        let mut choice = self.choice.clone();
        choice.without.extend(self.keep_out_layers.iter().chain(&self.travel_layer).cloned());
        choice
    }

    /// The closed contours on layers that are no part's; what was repaired there is told with what they are.
    fn closed_on(
        &self,
        file: &DxfFile,
        (layers, what): (&[String], &str),
        remarks: &mut Vec<Remark>,
    ) -> Result<Profile, DrawingError> {
        let choice = EntityFilter { layers: layers.to_vec(), ..self.choice.clone() };
        let drawing = curves_of(file, &choice)?;
        let chained = chain(&drawing, self.join_mm, self.curve_mm)?.closed()?;
        remarks.extend(chained.repairs.iter().map(repaired).map(|remark| of(what, remark)));
        Ok(chained.profile)
    }

    fn zones(&self, file: &DxfFile, remarks: &mut Vec<Remark>) -> Result<Profile, DrawingError> {
        if self.keep_out_layers.is_empty() {
            Ok(Profile::default())
        } else {
            self.closed_on(file, (&self.keep_out_layers, "zone"), remarks)
        }
    }

    fn travel(&self, file: &DxfFile, remarks: &mut Vec<Remark>) -> Result<Option<Window>, PlanRequestError> {
        let Some(layer) = &self.travel_layer else { return Ok(None) };
        let profile = self.closed_on(file, (std::slice::from_ref(layer), "machine's travel"), remarks)?;
        let rectangle = match &profile.loops[..] {
            [only] => only.rectangle(),
            _ => None,
        };
        let wrong = || PlanRequestError::Stroke { layer: layer.clone(), count: profile.loops.len() };
        Ok(Some(rectangle.ok_or_else(wrong)?))
    }

    /// Drawing bytes to certified plan; `stage` is told what is being done.
    ///
    /// # Errors
    /// [`PlanRequestError`] with place and remedy.
    pub fn plan(
        &self,
        name: &str,
        bytes: &[u8],
        machine: &MachineProfile,
        stage: &mut dyn FnMut(Stage),
    ) -> Result<CertifiedPlan, PlanRequestError> {
        stage(Stage::Reading);
        let file = read(bytes).map_err(DrawingError::from)?;
        let drawing = curves_of(&file, &self.part_choice())?;
        stage(Stage::Joining);
        let chained = chain(&drawing, self.join_mm, self.curve_mm)?;
        let left_out = drawing.left_out.iter().map(|(why, count)| format!("left out: {count} {why}"));
        let mut remarks: Vec<Remark> = chained.repairs.iter().map(repaired).collect();
        remarks.extend(drawing.remarks.iter().cloned().chain(left_out).map(Remark::from));
        let shapes = PlanGeometry {
            profile: self.selection.apply(chained, &mut remarks)?,
            zones: self.zones(&file, &mut remarks)?,
            travel: self.travel(&file, &mut remarks)?,
        };
        for remark in &mut remarks {
            remark.text = shown(&remark.text);
        }
        let provenance = Provenance {
            name: shown(name),
            hash: plan_file::hash(bytes),
            unit: shown(&drawing.unit),
            remarks,
            placed: self.choice.placed,
        };
        Ok(Plan::make(provenance, shapes, &self.job, machine, stage)?)
    }
}

fn repaired(repair: &Repair) -> Remark {
    Remark { at: Some(repair.at()), text: repair.to_string() }
}

/// A remark about something else than the part.
fn of(what: &str, remark: Remark) -> Remark {
    Remark { text: format!("{what}: {}", remark.text), ..remark }
}
