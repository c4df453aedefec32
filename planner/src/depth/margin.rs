//! The height margin: how far the tip of the tool can be below its commanded height, as a sum of named terms.
//!
//! Implements SR-16.

use keepout_kernel::{LatticeError, Length};
use serde::{Deserialize, Serialize};

use crate::machine::{MachineProfile, ZProfile};
use crate::margin::MarginError;
use crate::units::{length_up_from_mm, mm};

/// One source of error that the height margin covers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum HeightTermKind {
    /// Rounding of heights to the lattice.
    LatticeRounding,
    /// The controller's step: the tool goes, and is found, to half a step.
    StepResolution,
    /// The last digit of the controller's position report.
    ReportResolution,
    /// The controller's 32-bit arithmetic.
    Arithmetic,
    /// The axis leaves its commanded height in motion.
    FollowingError,
    /// The axis does not return to the same height.
    Repeatability,
    /// The height of the tip was measured: the tool's length is one number, with this error.
    ToolLength,
}

impl HeightTermKind {
    /// The name, as tables have it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::LatticeRounding => "lattice rounding",
            Self::StepResolution => "controller resolution: step",
            Self::ReportResolution => "controller resolution: report",
            Self::Arithmetic => "controller arithmetic",
            Self::FollowingError => "following error",
            Self::Repeatability => "repeatability",
            Self::ToolLength => "tool length",
        }
    }

    fn is_resolution(self) -> bool {
        matches!(self, Self::StepResolution | Self::ReportResolution)
    }
}

/// Term of the height margin.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct HeightTerm {
    /// What it covers.
    pub kind: HeightTermKind,
    /// Its size, mm.
    pub mm: f64,
}

/// The height margin as the sum of its terms.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HeightBudget {
    /// The terms.
    pub terms: Vec<HeightTerm>,
}

/// Rounding of a top and of a commanded height, each to half a lattice unit, and of a place on a ramp.
const LATTICE_MM: f64 = 0.000_03;
/// Error of a height of 1 m as a 32-bit float, in and out.
const FLOAT_MM: f64 = 0.000_1;
/// Largest error of a tool's length, mm.
const TOOL_LENGTH_MAX_MM: f64 = 10.0;

impl HeightBudget {
    /// The height margin of a machine with this third axis. `tool_length_mm` is the error of the tool's length.
    ///
    /// # Errors
    /// [`MarginError::ToolLength`] when that error is negative, not finite, or larger than 10 mm.
    pub fn of(machine: &MachineProfile, z: &ZProfile, tool_length_mm: f64) -> Result<Self, MarginError> {
        if !(0.0..=TOOL_LENGTH_MAX_MM).contains(&tool_length_mm) {
            return Err(MarginError::ToolLength { asked: tool_length_mm });
        }
        let term = |kind, mm| HeightTerm { kind, mm };
        let terms = vec![
            term(HeightTermKind::LatticeRounding, LATTICE_MM),
            // Half a step for the commanded height, and half a step for the reported one.
            term(HeightTermKind::StepResolution, 1.0 / z.steps_per_mm),
            term(HeightTermKind::ReportResolution, machine.report_digit_mm / 2.0),
            term(HeightTermKind::Arithmetic, FLOAT_MM),
            term(HeightTermKind::FollowingError, z.following_error_mm),
            term(HeightTermKind::Repeatability, z.repeatability_mm),
            term(HeightTermKind::ToolLength, tool_length_mm),
        ];
        Ok(Self { terms })
    }

    /// Checks that the terms are those of [`HeightBudget::of`] for the machine, whatever the tool's length.
    ///
    /// # Errors
    /// [`MarginError::ForeignHeight`] for the first term that differs.
    pub fn check(&self, machine: &MachineProfile, z: &ZProfile) -> Result<(), MarginError> {
        let stated = self.terms.iter().find(|term| term.kind == HeightTermKind::ToolLength);
        let due = Self::of(machine, z, stated.map_or(0.0, |term| term.mm))?.terms;
        let wrong = (0..due.len().max(self.terms.len())).find(|&i| self.terms.get(i) != due.get(i));
        let kind = wrong.and_then(|i| due.get(i).or(self.terms.get(i))).map(|term| term.kind);
        kind.map_or(Ok(()), |kind| Err(MarginError::ForeignHeight { kind }))
    }

    /// Sum of the terms, rounded up to the lattice.
    ///
    /// # Errors
    /// [`LatticeError`] when a term is negative, not a number, or too large.
    pub fn total(&self) -> Result<Length, LatticeError> {
        let terms = self.terms.iter().map(|term| length_up_from_mm(term.mm));
        terms.into_iter().try_fold(Length::ZERO, |sum, term| sum.plus(term?))
    }

    /// Largest distance of a reported height from the commanded one.
    ///
    /// # Errors
    /// As [`HeightBudget::total`].
    pub fn resolution(&self) -> Result<Length, LatticeError> {
        let terms = self.terms.iter().filter(|term| term.kind.is_resolution());
        length_up_from_mm(terms.map(|term| term.mm).sum())
    }
}

impl std::fmt::Display for HeightBudget {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for term in &self.terms {
            writeln!(f, "  {:<32} {:>9.5} mm", term.kind.name(), term.mm)?;
        }
        let total = self.total().map_or(f64::NAN, |total| mm(total.units()));
        write!(f, "  {:<32} {total:>9.5} mm", "height margin")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // Evidence for SR-16.
    #[test]
    fn steps_are_those_of_the_third_axis() {
        let z = ZProfile { steps_per_mm: 125.0, ..ZProfile::simulated() };
        let budget = HeightBudget::of(&MachineProfile::simulated(), &z, 0.0).unwrap();
        let step = budget.terms.iter().find(|term| term.kind == HeightTermKind::StepResolution).unwrap();
        assert!((step.mm - 0.008).abs() < 1e-9, "half a step, commanded and reported: {}", step.mm);
    }

    #[test]
    fn terms_add_up_and_changed_ones_are_refused() {
        let (machine, z) = (MachineProfile::simulated(), ZProfile::simulated());
        let budget = HeightBudget::of(&machine, &z, 0.02).unwrap();
        let sum: f64 = budget.terms.iter().map(|term| term.mm).sum();
        let total = mm(budget.total().unwrap().units());
        assert!(total >= sum && total - sum < 0.000_1, "{total} {sum}");
        assert!(budget.resolution().unwrap() < budget.total().unwrap());
        assert_eq!(budget.check(&machine, &z), Ok(()));
        for index in 0..budget.terms.len() {
            let mut other = budget.clone();
            other.terms[index].mm += 0.001;
            let is_length = other.terms[index].kind == HeightTermKind::ToolLength;
            assert_eq!(other.check(&machine, &z).is_ok(), is_length, "{other}");
            other.terms.remove(index);
            assert!(other.check(&machine, &z).is_err(), "{other}");
        }
        for wrong in [-0.1, f64::NAN, 11.0] {
            assert!(HeightBudget::of(&machine, &z, wrong).is_err(), "{wrong}");
        }
    }
}
