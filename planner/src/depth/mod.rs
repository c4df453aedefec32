//! The third axis of a plan: the heights of the part, the depth passes, and how the tool enters the stock.
//!
//! Implements SR-20.
//!
//! Height zero is the top of the part, and of the stock. The contours of the drawing divide the plane into faces.
//! Material stands up to height zero, and openings go through, unless a depth is given for a contour: then the face
//! just inside that contour lies so far below the top. So a depth makes a pocket, a step or a lower island.

mod faces;
mod margin;
mod passes;

use keepout_kernel::{
    Height, HeightField, LatticeError, Length, Levels, LevelsError, ProhibitedRegion, Side,
};
use serde::{Deserialize, Serialize};
use thiserror::Error;

pub use self::margin::{HeightBudget, HeightTerm, HeightTermKind};
pub(crate) use self::passes::{HeightBand, chosen};
use crate::machine::{MachineProfile, ZProfile};
use crate::margin::MarginError;
use crate::units::{length_up_from_mm, mm};

/// The third axis of a job, as the user chooses it.
#[derive(Clone, Debug, PartialEq)]
pub struct DepthParameters {
    /// Thickness of the part, mm.
    pub thickness_mm: f64,
    /// Depths of faces that neither stand at the top nor go through.
    pub faces: Vec<FaceDepth>,
    /// Greatest depth of one pass, mm. `None` means half the tool's diameter.
    pub step_down_mm: Option<f64>,
    /// How far through cuts go below the part, mm.
    pub overcut_mm: f64,
    /// Height at which the tool crosses, above the top of the part, mm.
    pub safe_mm: f64,
    /// Height of the clamps above the top of the part, mm: the top of every keep-out zone.
    pub clamps_mm: Option<f64>,
    /// Distance of the table below the top of the part, mm. `None` means just below the deepest cut.
    pub table_mm: Option<f64>,
    /// How the tool enters the stock.
    pub entry: EntryMove,
    /// Error of the tool's length, mm.
    pub tool_length_error_mm: f64,
}

impl DepthParameters {
    /// A part of this thickness without pockets.
    #[must_use]
    pub fn of(thickness_mm: f64) -> Self {
        Self {
            thickness_mm,
            faces: Vec::new(),
            step_down_mm: None,
            overcut_mm: 0.5,
            safe_mm: 5.0,
            clamps_mm: None,
            table_mm: None,
            entry: EntryMove::default(),
            tool_length_error_mm: 0.02,
        }
    }
}

/// The depth of the face just inside some contours.
#[derive(Clone, Debug, PartialEq)]
pub struct FaceDepth {
    /// The contours.
    pub of: FaceChoice,
    /// Depth below the top of the part, mm. `None`: the face goes through.
    pub depth_mm: Option<f64>,
}

/// The contours for which a depth is given.
#[derive(Clone, Debug, PartialEq)]
pub enum FaceChoice {
    /// The contour with this number in the drawing.
    Contour(usize),
    /// The contours that begin on this layer.
    Layer(String),
}

/// How the tool enters stock that is not open yet.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum EntryMove {
    /// Straight down: only for a tool that cuts at its centre.
    Plunge,
    /// Down along the contour, a helix in a hole, with this many mm down per mm of way.
    Ramp {
        /// The slope.
        slope: f64,
    },
}

impl EntryMove {
    /// Accepted slopes of a ramp.
    pub const SLOPES: std::ops::RangeInclusive<f64> = 0.001..=1.0;
}

impl Default for EntryMove {
    /// A ramp of 3°.
    fn default() -> Self {
        Self::Ramp { slope: 0.05 }
    }
}

/// Reason why a job has no heights.
#[derive(Debug, Error)]
pub enum DepthError {
    /// The machine has two axes.
    #[error("the machine profile has no third axis: add a [z] table to it, or plan without --thickness-mm")]
    TwoAxes,
    /// A figure is out of range.
    #[error("{what} is {value_mm} mm: it must be {needed}")]
    Figure {
        /// The figure.
        what: &'static str,
        /// Its value, mm.
        value_mm: f64,
        /// What it must be.
        needed: &'static str,
    },
    /// No contour has the number.
    #[error("the part has no contour {number}: `keepout inspect` lists the contours")]
    NoContour {
        /// The number.
        number: usize,
    },
    /// No contour is on the layer.
    #[error("no contour of the part begins on layer \"{layer}\": `keepout inspect` lists the layers")]
    NoLayer {
        /// The layer.
        layer: String,
    },
    /// Keep-out zones have no height.
    #[error("the drawing has keep-out zones: state the height of the clamps with --clamp-height-mm")]
    NoClampHeight,
    /// The tool would cross below the clamps.
    #[error(
        "the tool crosses {safe_mm} mm above the part, and the clamps stand {clamps_mm} mm above it: \
         raise --safe-height-mm to at least {least_mm:.3}"
    )]
    SafeTooLow {
        /// The crossing height, mm.
        safe_mm: f64,
        /// Height of the clamps, mm.
        clamps_mm: f64,
        /// Least crossing height, mm.
        least_mm: f64,
    },
    /// The heights need more travel than the machine has.
    #[error(
        "the job needs {needed_mm:.1} mm of travel in z, the machine has {has_mm:.1} mm: \
         lower --safe-height-mm, or use a longer axis"
    )]
    Travel {
        /// Travel needed, mm.
        needed_mm: f64,
        /// Travel of the axis, mm.
        has_mm: f64,
    },
    /// A through cut would reach the table.
    #[error(
        "through cuts end {deepest_mm:.3} mm below the top of the part, and the table is {table_mm} mm below it: \
         lower --overcut-mm, or put a board under the part and state --table-mm"
    )]
    Table {
        /// The deepest cut, mm.
        deepest_mm: f64,
        /// Distance of the table, mm.
        table_mm: f64,
    },
    /// The height margin fails.
    #[error(transparent)]
    Margin(#[from] MarginError),
    /// A length is off the lattice.
    #[error("a height is off the lattice: {0}")]
    Lattice(#[from] LatticeError),
    /// The part has no levels.
    #[error("the part has no levels: {0}")]
    Levels(#[from] LevelsError),
    /// The heights of a plan do not fit its contours.
    #[error("the plan's heights do not fit it: {0}. Make the plan again from the drawing.")]
    Foreign(&'static str),
}

/// The heights of a plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Relief {
    /// Thickness of the part.
    #[serde(with = "crate::stored")]
    pub thickness: Length,
    /// The top of the face just inside each contour, in the order of the profile; `None`: through.
    #[serde(with = "heights")]
    pub tops: Vec<Option<Height>>,
    /// Top of every keep-out zone.
    #[serde(with = "crate::stored")]
    pub clamps: Height,
    /// Height of the table.
    #[serde(with = "crate::stored")]
    pub floor: Height,
    /// Height at which the tool crosses.
    #[serde(with = "crate::stored")]
    pub safe: Height,
    /// Where through cuts end.
    #[serde(with = "crate::stored")]
    pub deepest: Height,
    /// Greatest depth of one pass.
    #[serde(with = "crate::stored")]
    pub step_down: Length,
    /// How the tool enters the stock.
    pub entry: EntryMove,
    /// The height margin.
    pub budget: HeightBudget,
}

/// Heights that may be missing, as a list.
mod heights {
    use keepout_kernel::Height;
    use serde::de::Error as _;
    use serde::{Deserialize as _, Deserializer, Serialize as _, Serializer};

    pub fn serialize<S: Serializer>(tops: &[Option<Height>], serializer: S) -> Result<S::Ok, S::Error> {
        tops.iter().map(|top| top.map(Height::units)).collect::<Vec<_>>().serialize(serializer)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<Option<Height>>, D::Error> {
        let tops = Vec::<Option<i32>>::deserialize(deserializer)?;
        let height = |units: Option<i32>| units.map(|units| Height::from_units(units.into())).transpose();
        tops.into_iter().map(height).collect::<Result<_, _>>().map_err(D::Error::custom)
    }
}

/// Greatest thickness, depth and height, mm.
const HEIGHT_MAX_MM: f64 = 2000.0;

fn figure(what: &'static str, value_mm: f64, least: f64) -> Result<Length, DepthError> {
    if (least..=HEIGHT_MAX_MM).contains(&value_mm) {
        Ok(length_up_from_mm(value_mm)?)
    } else {
        let needed = if least > 0.0 { "more than 0 and at most 2000" } else { "from 0 to 2000" };
        Err(DepthError::Figure { what, value_mm, needed })
    }
}

/// The least size of a positive figure, mm.
const LEAST_MM: f64 = 0.01;

impl Relief {
    /// The heights of a part. Numbers and layers name its contours.
    ///
    /// # Errors
    /// [`DepthError`] with the figure and the remedy.
    pub fn of(
        job: &DepthParameters,
        (numbers, layers): (&[usize], &[std::sync::Arc<str>]),
        part: &ProhibitedRegion,
        machine: &MachineProfile,
        tool_radius: Length,
    ) -> Result<Self, DepthError> {
        let z = machine.z.as_ref().ok_or(DepthError::TwoAxes)?;
        let budget = HeightBudget::of(machine, z, job.tool_length_error_mm)?;
        let margin = budget.total()?;
        let thickness = figure("--thickness-mm", job.thickness_mm, LEAST_MM)?;
        let overcut = figure("--overcut-mm", job.overcut_mm, 0.0)?;
        let step_down = match job.step_down_mm {
            Some(step) => figure("--step-down-mm", step, LEAST_MM)?,
            None => tool_radius,
        };
        if let EntryMove::Ramp { slope } = job.entry
            && !EntryMove::SLOPES.contains(&slope)
        {
            let needed = "from 0.001 to 1 per mm of way";
            return Err(DepthError::Figure { what: "the slope of a ramp", value_mm: slope, needed });
        }
        let mut tops = standing_tops(part);
        for face in &job.faces {
            face.apply(&mut tops, numbers, layers, thickness)?;
        }
        let clamps = match (part.zones().is_empty(), job.clamps_mm) {
            (true, _) => Height::ZERO,
            (false, Some(height)) => Height::ZERO.raised(figure("--clamp-height-mm", height, 0.0)?),
            (false, None) => return Err(DepthError::NoClampHeight),
        };
        let safe = Height::ZERO.raised(figure("--safe-height-mm", job.safe_mm, LEAST_MM)?);
        let deepest = Height::ZERO.lowered(thickness).lowered(overcut);
        let below = deepest.lowered(margin);
        let floor = match job.table_mm {
            Some(table) => Height::ZERO.lowered(figure("--table-mm", table, LEAST_MM)?),
            None => below,
        };
        let relief =
            Self { thickness, tops, clamps, floor, safe, deepest, step_down, entry: job.entry, budget };
        relief.check(part, machine)?;
        Ok(relief)
    }

    /// Checks the heights against each other, the part and the machine.
    ///
    /// # Errors
    /// [`DepthError`] for the first one that fails.
    pub fn check(&self, part: &ProhibitedRegion, machine: &MachineProfile) -> Result<(), DepthError> {
        let z: &ZProfile = machine.z.as_ref().ok_or(DepthError::TwoAxes)?;
        self.budget.check(machine, z)?;
        let margin = self.budget.total()?;
        let depth_mm = |height: Height| -mm(height.units());
        if self.tops.len() != part.region().rings().len() {
            return Err(DepthError::Foreign("it has not one top for each contour"));
        }
        let bottom = Height::ZERO.lowered(self.thickness);
        let between = |top: &Option<Height>| top.is_none_or(|top| bottom <= top && top <= Height::ZERO);
        if !self.tops.iter().all(between) || self.deepest > bottom || self.step_down == Length::ZERO {
            return Err(DepthError::Foreign("a face is above the top or below the bottom"));
        }
        if self.clamps < Height::ZERO {
            return Err(DepthError::Foreign("a clamp ends below the top"));
        }
        if let EntryMove::Ramp { slope } = self.entry
            && !EntryMove::SLOPES.contains(&slope)
        {
            return Err(DepthError::Foreign("its ramps have an impossible slope"));
        }
        let highest = if part.zones().is_empty() { Height::ZERO } else { self.clamps.max(Height::ZERO) };
        if self.safe < highest.raised(margin) {
            return Err(DepthError::SafeTooLow {
                safe_mm: mm(self.safe.units()),
                clamps_mm: mm(self.clamps.units()),
                least_mm: mm(highest.raised(margin).units()),
            });
        }
        if self.deepest.lowered(margin) < self.floor {
            return Err(DepthError::Table {
                deepest_mm: depth_mm(self.deepest.lowered(margin)),
                table_mm: depth_mm(self.floor),
            });
        }
        let needed_mm = mm(self.safe.units()) + depth_mm(self.deepest);
        if needed_mm > z.travel_mm {
            return Err(DepthError::Travel { needed_mm, has_mm: z.travel_mm });
        }
        Ok(())
    }

    /// The levels of the part.
    ///
    /// # Errors
    /// [`DepthError::Levels`], never for a part that was checked.
    pub fn levels(&self, part: &ProhibitedRegion) -> Result<Levels, DepthError> {
        let field = HeightField {
            outlines: part.region().clone(),
            tops: self.tops.clone(),
            around: around(part.side()),
            zones: part.zones().iter().map(|zone| (zone.clone(), self.clamps)).collect(),
            floor: Some(self.floor),
        };
        Ok(Levels::new(&field)?)
    }
}

/// The top of the material around all contours. A part that is machined from outside has none there.
pub(crate) fn around(side: Side) -> Option<Height> {
    (side == Side::Inside).then_some(Height::ZERO)
}

/// The tops without given depths: material stands at height zero, openings go through.
fn standing_tops(part: &ProhibitedRegion) -> Vec<Option<Height>> {
    let depths = part.region().depths();
    let material = |depth: usize| depth.is_multiple_of(2) == (part.side() == Side::Outside);
    depths.into_iter().map(|depth| material(depth).then_some(Height::ZERO)).collect()
}
