//! The margin M: the largest distance of the tool from its assumed place, as a sum of named terms.
//!
//! Implements SR-16.
//!
//! The uncertainty of the alignment ([`crate::align`]) is not a term: path and part come from one
//! drawing, and shift together.

use std::f64::consts::SQRT_2;

use keepout_kernel::Length;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::depth::HeightTermKind;
use crate::machine::MachineProfile;
use crate::text_file::shown;
use crate::units::{length_up_from_mm, mm};

/// One source of error that the margin covers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "&'static str", try_from = "String")]
pub enum TermKind {
    /// Rounding of the drawing, the path and the arc centres to the lattice.
    LatticeRounding,
    /// Arcs are certified as chords.
    ChordError,
    /// The controller's step: the tool goes, and is found, to half a step.
    StepResolution,
    /// The last digit of the controller's position report.
    ReportResolution,
    /// The controller's 32-bit arithmetic.
    Arithmetic,
    /// The controller cuts arcs as chords.
    ControllerArcs,
    /// The drawing was turned and moved.
    Placement,
    /// The drives leave the path.
    ContourError,
    /// The machine does not return to the same place.
    Repeatability,
    /// The last two together, where the whole margin was given.
    OwnErrors,
}

impl TermKind {
    const ALL: [Self; 10] = [
        Self::LatticeRounding,
        Self::ChordError,
        Self::StepResolution,
        Self::ReportResolution,
        Self::Arithmetic,
        Self::ControllerArcs,
        Self::Placement,
        Self::ContourError,
        Self::Repeatability,
        Self::OwnErrors,
    ];

    /// The name, as tables and plan files have it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::LatticeRounding => "lattice rounding",
            Self::ChordError => "chord-error bound",
            Self::StepResolution => "controller resolution: step",
            Self::ReportResolution => "controller resolution: report",
            Self::Arithmetic => "controller arithmetic",
            Self::ControllerArcs => "controller arcs",
            Self::Placement => "work offset and rotation",
            Self::ContourError => "contour error",
            Self::Repeatability => "repeatability",
            Self::OwnErrors => "contour error and repeatability",
        }
    }

    /// Whether a report can be off by it.
    #[must_use]
    pub fn is_resolution(self) -> bool {
        matches!(self, Self::StepResolution | Self::ReportResolution)
    }
}

impl From<TermKind> for &'static str {
    fn from(kind: TermKind) -> Self {
        kind.name()
    }
}

impl TryFrom<String> for TermKind {
    type Error = String;

    fn try_from(name: String) -> Result<Self, String> {
        let known = Self::ALL.into_iter().find(|kind| kind.name() == name);
        known.ok_or_else(|| format!("the margin has no term \"{}\"", shown(&name)))
    }
}

/// Term of the margin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MarginTerm {
    /// What it covers.
    #[serde(rename = "name")]
    pub kind: TermKind,
    /// Its size, mm.
    pub mm: f64,
    /// Source of the figure.
    pub source: String,
}

/// The margin as the sum of its terms.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Budget {
    /// The terms.
    pub terms: Vec<MarginTerm>,
}

/// Reason why a margin is refused.
#[derive(Debug, Error, PartialEq)]
pub enum MarginError {
    /// The requested margin is less than rounding and the controller need.
    #[error(
        "--margin-mm {asked} is less than the {least:.5} mm that rounding and the controller's \
         resolution need. Give at least that much, plus the machine's own error."
    )]
    TooSmall {
        /// The requested margin, mm.
        asked: f64,
        /// The least accepted margin, mm.
        least: f64,
    },
    /// The requested margin is out of range.
    #[error("--margin-mm {asked} is out of range. Give a length below 1000 mm.")]
    NoLength {
        /// The requested margin, mm.
        asked: f64,
    },
    /// The error of the tool's length is out of range.
    #[error("--tool-length-error-mm {asked} is out of range. Give a length from 0 to 10 mm.")]
    ToolLength {
        /// The requested error, mm.
        asked: f64,
    },
    /// A plan's height margin does not fit its machine.
    #[error(
        "the height margin's term \"{}\" does not fit the plan's machine: make the plan again from the drawing",
        kind.name()
    )]
    ForeignHeight {
        /// The term.
        kind: HeightTermKind,
    },
    /// A plan's margin does not fit its machine.
    #[error(
        "the margin's term \"{}\" does not fit the plan's machine: make the plan again from the drawing",
        kind.name()
    )]
    Foreign {
        /// The term.
        kind: TermKind,
    },
}

/// Source of the machine's own errors when the whole margin was given.
const GIVEN_SOURCE: &str = "the rest of --margin-mm";
/// Rounding of a drawing's point, a path's point and an arc's centre, each to about a lattice unit.
const LATTICE_MM: f64 = 0.000_04;
/// Error of a coordinate of 1 m as a 32-bit float, in and out, on both axes.
const FLOAT_MM: f64 = 0.000_1;
/// Error of a point up to 10 m from the origin, after rotation and translation. Sine, cosine, two
/// products and two sums round by 2^-53 of it each, together less than 1e-11 mm. The term is one lattice
/// unit.
const PLACED_MM: f64 = 0.000_01;
/// Chord error of the certified arcs of a path: 0.1 µm.
const CHORD_MM: f64 = 0.000_1;

fn term(kind: TermKind, mm: f64, source: &str) -> MarginTerm {
    MarginTerm { kind, mm, source: source.into() }
}

/// Terms for rounding and for the controller's resolution.
fn rounding(machine: &MachineProfile, placed: bool) -> Vec<MarginTerm> {
    // Half a step for the commanded position, and half a step for the reported one.
    let steps = SQRT_2 / machine.steps_per_mm;
    let half_digit = machine.report_digit_mm * SQRT_2 / 2.0;
    let mut terms = vec![
        term(TermKind::LatticeRounding, LATTICE_MM, "drawing, path and arc centres on the 10 nm lattice"),
        term(TermKind::ChordError, CHORD_MM, "arcs certified as chords"),
        term(TermKind::StepResolution, steps, "half a step on both axes, commanded and reported"),
        term(TermKind::ReportResolution, half_digit, "half the last digit on both axes"),
        term(TermKind::Arithmetic, FLOAT_MM, "32-bit floats on a table of a metre"),
        // GRBL rounds the number of chords down. A chord can then span twice the angle, and leave the arc
        // four times as far.
        term(TermKind::ControllerArcs, 4.0 * machine.arc_tolerance_mm, "four times the arc tolerance ($12)"),
    ];
    if placed {
        terms.push(term(TermKind::Placement, PLACED_MM, "sine, cosine and sums in 64-bit floats"));
    }
    terms
}

/// Terms for the machine's own errors.
fn own_errors(machine: &MachineProfile) -> [MarginTerm; 2] {
    let source = machine.contour_error_source.to_string();
    [
        term(TermKind::ContourError, machine.contour_error_mm, &source),
        term(TermKind::Repeatability, machine.repeatability_mm, "machine profile"),
    ]
}

impl Budget {
    /// The margin of `machine`. `placed` states that the drawing was turned or moved. `total_mm` replaces
    /// the machine's own errors by its remainder after rounding and resolution.
    ///
    /// # Errors
    /// [`MarginError`] when `total_mm` is out of range, or less than rounding and resolution.
    pub fn of(machine: &MachineProfile, total_mm: Option<f64>, placed: bool) -> Result<Self, MarginError> {
        let mut terms = rounding(machine, placed);
        let least: f64 = terms.iter().map(|term| term.mm).sum();
        match total_mm {
            None => terms.extend(own_errors(machine)),
            Some(asked) if !(asked.is_finite() && asked < 1000.0) => {
                return Err(MarginError::NoLength { asked });
            }
            Some(asked) if asked < least => return Err(MarginError::TooSmall { asked, least }),
            Some(asked) => terms.push(term(TermKind::OwnErrors, asked - least, GIVEN_SOURCE)),
        }
        Ok(Self { terms })
    }

    /// Checks that the terms are those of [`Budget::of`] for `machine`. A plan file can state any term,
    /// and guard and executor find terms by name.
    ///
    /// # Errors
    /// [`MarginError::Foreign`] for the first term that differs.
    pub fn check(&self, machine: &MachineProfile, placed: bool) -> Result<(), MarginError> {
        let mut due = rounding(machine, placed);
        match self.terms.get(due.len()) {
            Some(last) if last.kind == TermKind::OwnErrors && last.mm >= 0.0 => {
                due.push(term(TermKind::OwnErrors, last.mm, GIVEN_SOURCE));
            }
            _ => due.extend(own_errors(machine)),
        }
        let wrong = (0..due.len().max(self.terms.len())).find(|&i| self.terms.get(i) != due.get(i));
        let kind = wrong.and_then(|i| due.get(i).or(self.terms.get(i))).map(|term| term.kind);
        kind.map_or(Ok(()), |kind| Err(MarginError::Foreign { kind }))
    }

    /// Sum of the terms, rounded up to the lattice.
    ///
    /// # Errors
    /// [`keepout_kernel::LatticeError`] when a term is negative, not a number, or too large.
    pub fn total(&self) -> Result<Length, keepout_kernel::LatticeError> {
        self.terms
            .iter()
            .map(|term| length_up_from_mm(term.mm))
            .try_fold(Length::ZERO, |sum, term| sum.plus(term?))
    }
}

impl Budget {
    /// Largest distance of a reported position from the commanded one: the controller's resolution.
    ///
    /// # Errors
    /// [`keepout_kernel::LatticeError`] when a term is negative, not a number, or too large.
    pub fn resolution(&self) -> Result<Length, keepout_kernel::LatticeError> {
        let terms = self.terms.iter().filter(|term| term.kind.is_resolution());
        length_up_from_mm(terms.map(|term| term.mm).sum())
    }

    /// Least stock to leave for jogging: twice the resolution. The place of a stopped tool is known only
    /// to the resolution, and the next motion begins at that place; see the executor's guard.
    ///
    /// # Errors
    /// As [`Budget::resolution`].
    pub fn stopping(&self) -> Result<Length, keepout_kernel::LatticeError> {
        let resolution = self.resolution()?;
        resolution.plus(resolution)
    }
}

impl std::fmt::Display for Budget {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for term in &self.terms {
            writeln!(f, "  {:<32} {:>9.5} mm   {}", term.kind.name(), term.mm, term.source)?;
        }
        let total = self.total().map_or(f64::NAN, |total| mm(total.units()));
        write!(f, "  {:<32} {total:>9.5} mm", "margin M")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::ContourErrorSource;

    #[test]
    fn terms_add_up_and_round_up() {
        let budget = Budget::of(&MachineProfile::simulated(), None, false).unwrap();
        let sum: f64 = budget.terms.iter().map(|term| term.mm).sum();
        let total = mm(budget.total().unwrap().units());
        assert!(total >= sum && total - sum < 0.000_1, "{total} {sum}");
    }

    // Evidence for SR-16.
    #[test]
    fn terms_are_those_of_the_machine() {
        let machine = MachineProfile {
            steps_per_mm: 250.0,
            report_digit_mm: 0.01,
            arc_tolerance_mm: 0.003,
            ..MachineProfile::simulated()
        };
        let budget = Budget::of(&machine, None, false).unwrap();
        let due = [
            // Half a step on each axis, of the commanded and of the reported position.
            (TermKind::StepResolution, 2.0 * (0.002_f64 * 0.002 + 0.002 * 0.002).sqrt()),
            // Half a digit on each axis.
            (TermKind::ReportResolution, (0.005_f64 * 0.005 + 0.005 * 0.005).sqrt()),
            // GRBL halves the number of chords: four times their sagitta.
            (TermKind::ControllerArcs, 0.012),
        ];
        for (kind, mm) in due {
            let term = budget.terms.iter().find(|term| term.kind == kind).unwrap();
            assert!((term.mm - mm).abs() < 1e-9, "{}: {} and not {mm}", kind.name(), term.mm);
        }
    }

    #[test]
    fn contour_error_names_its_source() {
        let source = ContourErrorSource::Measured("circular test of 22 May".into());
        let machine = MachineProfile { contour_error_source: source, ..MachineProfile::simulated() };
        let source = "measured: circular test of 22 May";
        let budget = Budget::of(&machine, None, false).unwrap();
        let term = budget.terms.iter().find(|term| term.kind == TermKind::ContourError).unwrap();
        assert_eq!((term.source.as_str(), term.mm), (source, machine.contour_error_mm));
        assert!(budget.to_string().contains(source));
    }

    #[test]
    fn requested_margin_is_met_or_refused() {
        let machine = MachineProfile::simulated();
        let total = Budget::of(&machine, Some(0.05), false).unwrap().total().unwrap();
        assert!((mm(total.units()) - 0.05).abs() < 1e-4);
        assert!(matches!(Budget::of(&machine, Some(0.001), true), Err(MarginError::TooSmall { .. })));
        assert!(matches!(Budget::of(&machine, Some(f64::NAN), false), Err(MarginError::NoLength { .. })));
    }

    // Evidence for SR-16, SR-20.
    #[test]
    fn changed_terms_are_refused() {
        let machine = MachineProfile::simulated();
        for (total_mm, placed) in [(None, false), (Some(0.05), false), (None, true)] {
            let budget = Budget::of(&machine, total_mm, placed).unwrap();
            assert_eq!(budget.check(&machine, placed), Ok(()));
            assert!(budget.check(&machine, !placed).is_err());
            let other_digit = MachineProfile { report_digit_mm: 0.01, ..machine.clone() };
            assert!(budget.check(&other_digit, placed).is_err());
            for index in 0..budget.terms.len() {
                let changed = |change: &dyn Fn(&mut Vec<MarginTerm>)| {
                    let mut other = budget.clone();
                    change(&mut other.terms);
                    assert!(other.check(&machine, placed).is_err(), "{other}");
                };
                changed(&|terms| drop(terms.remove(index)));
                changed(&|terms| terms[index].mm = f64::NAN);
                changed(&|terms| terms[index].mm = -1.0);
                let other = [TermKind::Placement, TermKind::Repeatability];
                let other = if budget.terms[index].kind == other[0] { other[1] } else { other[0] };
                changed(&|terms| terms[index].kind = other);
                changed(&|terms| terms[index].source.push('\n'));
                changed(&|terms| terms.insert(index, terms[index].clone()));
            }
        }
    }
}
