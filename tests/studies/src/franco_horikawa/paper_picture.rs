//! Attempts with the paper's controller, as a picture like Fig. 8.

use keepout_planner::profile::MachinedSide;
use keepout_planner::report::element::{Lines, circle, path};
use keepout_planner::report::view::{Mark, Sign, View, page, polyline_of};
use keepout_planner::{Box2, Mm2};

use super::invasion::prohibited;
use super::scenario::{MachinedProfile, Reported, StudyError};

/// Space around the tolerance, mm.
const SPACE_MM: f64 = 3.0;
// Colours that differ for people who confuse red and green (Okabe and Ito, 2008).
const PART: &str = "#b9bec9";
const INVASION: &str = "#f0e442";
const TOLERANCE: &str = "#fbf6cf";
const STOPPED: &str = "#0072b2";
const INVADED: &str = "#b45309";

/// The path of an attempt, and whether the tool invaded the part.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnAttempt {
    /// Path of the tool's centre, mm.
    pub points_mm: Vec<Mm2>,
    /// Whether the tool entered the part.
    pub invades: bool,
}

/// Draws attempts at `shape` with the paper's controller in the setting of `reported`, for a tool of this diameter.
///
/// # Errors
/// [`StudyError`] if the paper's construction of the prohibited region fails.
pub fn svg(
    shape: &MachinedProfile,
    reported: &Reported,
    diameter_mm: f64,
    attempts: &[DrawnAttempt],
) -> Result<String, StudyError> {
    let (radius, tolerance) = (diameter_mm / 2.0, reported.tolerance_mm);
    let prohibited = prohibited(&shape.corners, radius, shape.side())
        .map_err(|source| StudyError::Radius { name: shape.name.clone(), source })?;
    let ways = attempts.iter().flat_map(|attempt| &attempt.points_mm);
    let shown = Box2::around(shape.corners.iter().chain(ways).copied()).unwrap_or_default();
    let view = View::of(shown.grown(radius + tolerance + SPACE_MM));
    let outline = |corners: &[Mm2]| polyline_of(corners, &view) + "Z";
    let profile = outline(&shape.corners);
    // A wide line around a polygon is the region within half its width. What is drawn later hides the inner half.
    let around = |outline: &str, by_mm: f64, colour: &str| {
        let line = path(outline).outline(colour, format_args!("{:.1}", 2.0 * by_mm * view.scale));
        line.set("stroke-linejoin", "round")
    };
    let part = match shape.side() {
        MachinedSide::Inside => path(view.everything() + &profile).set("fill-rule", "evenodd"),
        MachinedSide::Outside => path(&profile),
    };
    let mut body = Lines::default();
    body.draw(&[around(&outline(&prohibited), tolerance, TOLERANCE), around(&profile, radius, INVASION)]);
    body.draw(&[part.fill(PART), path(&profile).outline("#333", 1.2)]);
    for attempt in attempts {
        let colour = if attempt.invades { INVADED } else { STOPPED };
        body.draw(&[path(polyline_of(&attempt.points_mm, &view)).outline(colour, 1)]);
        if let Some(&last) = attempt.points_mm.last() {
            body.draw(&[circle(view.xy(last), 1, 3).fill(colour)]);
        }
    }
    let invaded = attempts.iter().filter(|attempt| attempt.invades).count();
    let stopped = format!("attempts without an invasion: {}. A dot is the end", attempts.len() - invaded);
    let invasion = format!("invasion: here the tool of Ø {diameter_mm} mm cuts into the part");
    let seen = format!("tolerance T = {tolerance} mm: the controller stops a tool that it sees here");
    let mut legend = vec![
        Sign::new(PART, Mark::Area, format!("the part: {}", shape.title)),
        Sign::new(INVASION, Mark::Area, invasion),
        Sign::new(TOLERANCE, Mark::Area, seen),
        Sign::new(STOPPED, Mark::Line, stopped),
    ];
    if invaded > 0 {
        legend.push(Sign::new(INVADED, Mark::Line, format!("attempts with an invasion: {invaded}")));
    }
    let title = format!("The paper's controller, V = {} mm/s, T = {tolerance} mm", reported.feed_mm_s);
    Ok(page(&view, &title, &legend, &body))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::franco_horikawa::scenario::Scenarios;

    #[test]
    fn attempts_with_an_invasion_differ_from_the_others() {
        let scenarios = Scenarios::built_in().unwrap();
        let row = &scenarios.row[0];
        let shape = scenarios.shape(&row.profile).unwrap();
        let at = |x: f64, invades| DrawnAttempt { points_mm: vec![Mm2::new(x, 90.0)], invades };
        let drawn = |attempts: &[DrawnAttempt]| svg(shape, row, 6.0, attempts).unwrap();
        let both = drawn(&[at(0.0, false), at(5.0, true), at(9.0, false)]);
        assert!(both.contains("without an invasion: 2.") && both.contains("with an invasion: 1<"), "{both}");
        assert_eq!(both.matches(INVADED).count(), 3, "a way, a dot and a mark of the legend: {both}");
        assert!(!drawn(&[at(0.0, false)]).contains(INVADED));
    }
}
