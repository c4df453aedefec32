//! The margin M: how far the tool can be from where the plan believes it is, term by term.
//!
//! How well it is known where the workpiece lies ([`crate::align`]) is no term: path and part are one drawing, and shift
//! together.

use std::f64::consts::SQRT_2;

use keepout_kernel::Length;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::machine::MachineProfile;
use crate::text_file::shown;
use crate::units::{length_up_from_mm, mm};

/// One named term of the margin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Term {
    /// Its name.
    pub name: String,
    /// Its size in mm.
    pub mm: f64,
    /// Where the figure comes from.
    pub source: String,
}

/// The margin, as the sum of its terms.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Budget {
    /// The terms.
    pub terms: Vec<Term>,
}

/// Why a margin is refused.
#[derive(Debug, Error, PartialEq)]
pub enum MarginError {
    /// The margin asked for is less than what rounding and the controller need.
    #[error(
        "--margin-mm {asked} is less than the {least:.5} mm that rounding and the controller's resolution need. Give at least that much, plus the machine's own error."
    )]
    TooSmall {
        /// What was asked for, mm.
        asked: f64,
        /// The least that is accepted, mm.
        least: f64,
    },
    /// It is no length.
    #[error("--margin-mm {asked} is no length of this machine")]
    NoLength {
        /// What was asked for, mm.
        asked: f64,
    },
    /// A plan's margin is not that of its machine.
    #[error(
        "the margin's term \"{name}\" is not what the plan's machine needs: make the plan again from the drawing"
    )]
    Foreign {
        /// The term's name.
        name: String,
    },
}

/// The term that stands for the machine's own errors when the whole margin was asked for.
const ORDERED: &str = "contour error and repeatability";
const ORDERED_SOURCE: &str = "the rest of --margin-mm";
/// How the names of the terms begin that a report can be off by.
const RESOLUTION: &str = "controller resolution";
/// A drawing's point, a path's point and an arc's centre are each met to within about a lattice unit.
const LATTICE_MM: f64 = 0.000_04;
/// A coordinate of 1 m as a 32-bit float, in and out, on both axes.
const FLOAT_MM: f64 = 0.000_1;
/// A point up to 10 m from the origin, turned and moved: sine, cosine, two products and two sums round by 2^-53 of that
/// each, together less than 1e-11 mm. One lattice unit stands for it.
const PLACED_MM: f64 = 0.000_01;
/// A path's arcs are certified as chords within 0.1 µm of them.
const CHORD_MM: f64 = 0.000_1;

fn term(name: &str, mm: f64, source: &str) -> Term {
    Term { name: name.into(), mm, source: source.into() }
}

/// What rounding and the controller's resolution need.
fn rounding(machine: &MachineProfile, placed: bool) -> Vec<Term> {
    // Half a step each for where the tool goes and for where a report finds it.
    let steps = SQRT_2 / machine.steps_per_mm;
    let half_digit = machine.report_digit_mm * SQRT_2 / 2.0;
    let mut terms = vec![
        term("lattice rounding", LATTICE_MM, "drawing, path and arc centres on the 10 nm lattice"),
        term("chord slack", CHORD_MM, "arcs certified as chords"),
        term(&format!("{RESOLUTION}: step"), steps, "half a step on both axes, commanded and reported"),
        term(&format!("{RESOLUTION}: report"), half_digit, "half the last digit on both axes"),
        term("controller arithmetic", FLOAT_MM, "32-bit floats on a table of a metre"),
        // GRBL rounds the number of chords down: one can turn twice the angle, and leave the arc four times as far.
        term("controller arcs", 4.0 * machine.arc_tolerance_mm, "four times the arc tolerance ($12)"),
    ];
    if placed {
        terms.push(term("work offset and rotation", PLACED_MM, "sine, cosine and sums in 64-bit floats"));
    }
    terms
}

/// The machine's own errors.
fn own_errors(machine: &MachineProfile) -> [Term; 2] {
    let source = machine.contour_error_source.as_deref().unwrap_or("machine profile");
    [
        term("contour error", machine.contour_error_mm, source),
        term("repeatability", machine.repeatability_mm, "machine profile"),
    ]
}

impl Budget {
    /// The margin of `machine`, for a drawing that was `placed` (turned and moved) or not. `total_mm` replaces the machine's
    /// own errors by what it leaves for them.
    ///
    /// # Errors
    /// [`MarginError`] when `total_mm` is no length or less than rounding and resolution.
    pub fn of(machine: &MachineProfile, total_mm: Option<f64>, placed: bool) -> Result<Self, MarginError> {
        let mut terms = rounding(machine, placed);
        let least: f64 = terms.iter().map(|term| term.mm).sum();
        match total_mm {
            None => terms.extend(own_errors(machine)),
            Some(asked) if !(asked.is_finite() && asked < 1000.0) => {
                return Err(MarginError::NoLength { asked });
            }
            Some(asked) if asked < least => return Err(MarginError::TooSmall { asked, least }),
            Some(asked) => terms.push(term(ORDERED, asked - least, ORDERED_SOURCE)),
        }
        Ok(Self { terms })
    }

    /// Checks that it is one that [`Budget::of`] makes for `machine`: a plan file can say anything, and guard and executor look terms
    /// up by their names.
    ///
    /// # Errors
    /// [`MarginError::Foreign`] naming the first term that is not.
    pub fn check(&self, machine: &MachineProfile, placed: bool) -> Result<(), MarginError> {
        let mut due = rounding(machine, placed);
        match self.terms.get(due.len()) {
            Some(last) if last.name == ORDERED && last.mm >= 0.0 => {
                due.push(term(ORDERED, last.mm, ORDERED_SOURCE));
            }
            _ => due.extend(own_errors(machine)),
        }
        let wrong = (0..due.len().max(self.terms.len())).find(|&i| self.terms.get(i) != due.get(i));
        let name = wrong.and_then(|i| due.get(i).or(self.terms.get(i))).map(|term| shown(&term.name));
        name.map_or(Ok(()), |name| Err(MarginError::Foreign { name }))
    }

    /// The sum of the terms, rounded up to the lattice.
    ///
    /// # Errors
    /// [`keepout_kernel::LatticeError`] when a term is negative, no number or too large.
    pub fn total(&self) -> Result<Length, keepout_kernel::LatticeError> {
        self.terms
            .iter()
            .map(|term| length_up_from_mm(term.mm))
            .try_fold(Length::ZERO, |sum, term| sum.plus(term?))
    }
}

impl Budget {
    /// How far a reported position can be from the commanded one: the controller's resolution.
    ///
    /// # Errors
    /// [`keepout_kernel::LatticeError`] when a term is negative, no number or too large.
    pub fn resolution(&self) -> Result<Length, keepout_kernel::LatticeError> {
        let terms = self.terms.iter().filter(|term| term.name.starts_with(RESOLUTION));
        length_up_from_mm(terms.map(|term| term.mm).sum())
    }

    /// The least that steering by hand keeps beyond the margin: where a tool stopped is known to the resolution only, and what
    /// it is sent from there begins at that place. Twice the resolution, see the executor's guard.
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
            writeln!(f, "  {:<32} {:>9.5} mm   {}", term.name, term.mm, term.source)?;
        }
        let total = self.total().map_or(f64::NAN, |total| mm(total.units()));
        write!(f, "  {:<32} {total:>9.5} mm", "margin M")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terms_add_up_and_round_up() {
        let budget = Budget::of(&MachineProfile::simulated(), None, false).unwrap();
        let sum: f64 = budget.terms.iter().map(|term| term.mm).sum();
        let total = mm(budget.total().unwrap().units());
        assert!(total >= sum && total - sum < 0.000_1, "{total} {sum}");
    }

    #[test]
    fn contour_error_names_where_it_comes_from() {
        let source = "servo budget: these drives, 900 mm/min";
        let machine =
            MachineProfile { contour_error_source: Some(source.into()), ..MachineProfile::simulated() };
        let budget = Budget::of(&machine, None, false).unwrap();
        let term = budget.terms.iter().find(|term| term.name == "contour error").unwrap();
        assert_eq!((term.source.as_str(), term.mm), (source, machine.contour_error_mm));
        assert!(budget.to_string().contains(source));
    }

    #[test]
    fn margin_asked_for_is_met_and_not_undercut() {
        let machine = MachineProfile::simulated();
        let total = Budget::of(&machine, Some(0.05), false).unwrap().total().unwrap();
        assert!((mm(total.units()) - 0.05).abs() < 1e-4);
        assert!(matches!(Budget::of(&machine, Some(0.001), true), Err(MarginError::TooSmall { .. })));
        assert!(matches!(Budget::of(&machine, Some(f64::NAN), false), Err(MarginError::NoLength { .. })));
    }

    #[test]
    fn a_margin_of_other_terms_is_noticed() {
        let machine = MachineProfile::simulated();
        for (total_mm, placed) in [(None, false), (Some(0.05), false), (None, true)] {
            let budget = Budget::of(&machine, total_mm, placed).unwrap();
            assert_eq!(budget.check(&machine, placed), Ok(()));
            assert!(budget.check(&machine, !placed).is_err());
            let simplified = MachineProfile { report_digit_mm: 0.01, ..machine.clone() };
            assert!(budget.check(&simplified, placed).is_err());
            for index in 0..budget.terms.len() {
                let changed = |change: &dyn Fn(&mut Vec<Term>)| {
                    let mut other = budget.clone();
                    change(&mut other.terms);
                    assert!(other.check(&machine, placed).is_err(), "{other}");
                };
                changed(&|terms| drop(terms.remove(index)));
                changed(&|terms| terms[index].mm = f64::NAN);
                changed(&|terms| terms[index].mm = -1.0);
                changed(&|terms| terms[index].name.push('s'));
                changed(&|terms| terms[index].source.push('\n'));
                changed(&|terms| terms.insert(index, terms[index].clone()));
            }
        }
    }
}
