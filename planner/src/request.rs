//! A plan request: the user's choices for a drawing and a job, and the steps to a certified plan.

use keepout_kernel::exact::segment::Window;
use thiserror::Error;

use crate::drawing::{
    CURVE_MM, Chained, Drawing, DrawingError, DxfFile, EntityFilter, JOIN_MM, NO_END, Repair, chain,
    curves_of, read,
};
use crate::machine::MachineProfile;
use crate::plan::{CertifiedPlan, Plan, PlanError, PlanGeometry, PlanParameters, Provenance, Remark};
use crate::profile::Profile;
use crate::select::{SelectError, Selection};
use crate::sha256;
use crate::text_file::shown;

/// The user's choices for a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanRequest {
    /// Filter of the drawing's entities.
    pub choice: EntityFilter,
    /// Largest gap that is closed, mm.
    pub join_mm: f64,
    /// Largest distance of the arcs and lines from the splines and ellipses that they replace, mm.
    pub curve_mm: f64,
    /// Contours that make the part.
    pub selection: Selection,
    /// Layers with closed contours that are keep-out zones: clamps, a vice.
    pub keep_out_layers: Vec<String>,
    /// Layer with a rectangle in which the tool's centre must stay.
    pub travel_layer: Option<String>,
    /// Tool, side, stock to leave, passes.
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

/// Reason why a request gives no plan.
#[derive(Debug, Error)]
pub enum PlanRequestError {
    /// The drawing cannot be used.
    #[error(transparent)]
    Drawing(#[from] DrawingError),
    /// The selection fails.
    #[error(transparent)]
    Select(#[from] SelectError),
    /// The layer of the machine's travel does not hold one rectangle.
    #[error(
        "layer \"{layer}\" must hold the machine's travel and nothing else: one rectangle along the axes, \
         after turning. It holds {count} closed contours."
    )]
    Travel {
        /// The layer.
        layer: String,
        /// Number of its closed contours.
        count: usize,
    },
    /// Planning fails.
    #[error(transparent)]
    Plan(#[from] PlanError),
}

/// A stage on the way to a plan, for a progress display.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Reads the file.
    Reading,
    /// Joins curves.
    Joining,
    /// Checks the part's contours.
    Checking,
    /// Computes the finishing toolpath.
    Offsetting,
    /// Certifies the finishing toolpath.
    Certifying,
}

impl Stage {
    /// Number of stages.
    pub const COUNT: u64 = 5;

    /// Number of stages before this one.
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
            Self::Offsetting => "computing the finishing toolpath",
            Self::Certifying => "certifying the finishing toolpath",
        })
    }
}

impl PlanRequest {
    /// Contours of the drawing, chained and not yet selected.
    ///
    /// # Errors
    /// [`DrawingError`].
    pub fn contours(&self, bytes: &[u8]) -> Result<(Drawing, Chained), DrawingError> {
        let drawing = curves_of(&read(bytes)?, &self.part_choice())?;
        let chained = chain(&drawing, self.join_mm, self.curve_mm)?;
        Ok((drawing, chained))
    }

    /// Entity filter of the part: it leaves out the layers of zones and travel.
    fn part_choice(&self) -> EntityFilter {
        let other_layers = self.keep_out_layers.iter().chain(&self.travel_layer).cloned().collect();
        EntityFilter { other_layers, ..self.choice.clone() }
    }

    /// Closed contours on layers that do not belong to the part. Remarks about repairs there begin with
    /// `what`.
    fn closed_on(
        &self,
        file: &DxfFile,
        (layers, what): (&[String], &str),
        remarks: &mut Vec<Remark>,
    ) -> Result<Profile, DrawingError> {
        // A layer that is named twice is protected.
        let choice = EntityFilter { layers: layers.to_vec(), without: Vec::new(), ..self.choice.clone() };
        let drawing = curves_of(file, &choice)?;
        let chained = chain(&drawing, self.join_mm, self.curve_mm)?.closed()?;
        remarks.extend(chained.repairs.iter().map(repaired).map(|remark| of(what, remark)));
        // The part has the remark on the whole file.
        let own = drawing.remarks.into_iter().filter(|text| text != NO_END);
        remarks.extend(own.map(|text| of(what, text.into())));
        Ok(chained.profile)
    }

    fn zones(&self, file: &DxfFile, remarks: &mut Vec<Remark>) -> Result<Profile, DrawingError> {
        if self.keep_out_layers.is_empty() {
            Ok(Profile::default())
        } else {
            self.closed_on(file, (&self.keep_out_layers, "keep-out zone"), remarks)
        }
    }

    fn travel(&self, file: &DxfFile, remarks: &mut Vec<Remark>) -> Result<Option<Window>, PlanRequestError> {
        let Some(layer) = &self.travel_layer else { return Ok(None) };
        let profile = self.closed_on(file, (std::slice::from_ref(layer), "machine's travel"), remarks)?;
        let rectangle = match &profile.loops[..] {
            [only] => only.rectangle(),
            _ => None,
        };
        let wrong = || PlanRequestError::Travel { layer: layer.clone(), count: profile.loops.len() };
        Ok(Some(rectangle.ok_or_else(wrong)?))
    }

    /// Makes a certified plan from the bytes of a drawing. It calls `stage` at the start of each stage.
    ///
    /// # Errors
    /// [`PlanRequestError`] with the place and a remedy.
    pub fn plan(
        &self,
        name: &str,
        bytes: &[u8],
        machine: &MachineProfile,
        stage: &mut dyn FnMut(Stage),
    ) -> Result<CertifiedPlan, PlanRequestError> {
        stage(Stage::Reading);
        let file = read(bytes).map_err(DrawingError::from)?;
        let choice = self.part_choice();
        let drawing = curves_of(&file, &choice)?;
        stage(Stage::Joining);
        let chained = chain(&drawing, self.join_mm, self.curve_mm)?;
        let left_out = drawing.left_out.iter().map(|(why, count)| format!("left out: {count} {why}"));
        let mut remarks: Vec<Remark> = chained.repairs.iter().map(repaired).collect();
        remarks.extend(drawing.remarks.iter().cloned().chain(left_out).map(Remark::from));
        let selected = self.selection.apply(chained, (&drawing, &choice), &mut remarks)?;
        let shapes = PlanGeometry {
            profile: selected.profile,
            zones: self.zones(&file, &mut remarks)?,
            travel: self.travel(&file, &mut remarks)?,
            layers: selected.layers,
        };
        for remark in &mut remarks {
            remark.text = shown(&remark.text);
        }
        let provenance = Provenance {
            name: shown(name),
            hash: sha256::hash(bytes),
            unit: shown(&drawing.unit),
            remarks,
            placed: self.choice.placed,
            numbers: selected.numbers,
            left_out: selected.left_out,
        };
        Ok(Plan::make(provenance, shapes, &self.job, machine, stage)?)
    }
}

fn repaired(repair: &Repair) -> Remark {
    Remark { at: Some(repair.at()), text: repair.to_string() }
}

/// A remark about a contour that is not the part's.
fn of(what: &str, remark: Remark) -> Remark {
    Remark { text: format!("{what}: {}", remark.text), ..remark }
}
