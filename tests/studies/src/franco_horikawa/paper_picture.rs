//! Attempts and roughing passes with the paper's controller, as pictures like Fig. 8.

use keepout_planner::profile::MachinedSide;
use keepout_planner::report::element::{Lines, circle, path};
use keepout_planner::report::view::{Mark, Sign, View, page, polyline_of};
use keepout_planner::{Box2, Mm2};

use super::invasion::prohibited;
use super::roughing::RoughingPass;
use super::scenario::{MachinedProfile, Reported, StudyError};

/// Space around the tolerance, mm.
const SPACE_MM: f64 = 3.0;
// Colours that differ for people who confuse red and green (Okabe and Ito, 2008).
const PART: &str = "#b9bec9";
const INVASION: &str = "#f0e442";
const TOLERANCE: &str = "#fbf6cf";
const STOPPED: &str = "#0072b2";
const INVADED: &str = "#b45309";
const FINISHED: &str = "#1d2025";

/// The path of an attempt, and whether the tool invaded the part.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnAttempt {
    /// Path of the tool's centre, mm.
    pub points_mm: Vec<Mm2>,
    /// Whether the tool entered the part.
    pub invades: bool,
}

/// The part, and where the paper's controller stops the tool, for a tool of a diameter and a tolerance.
struct Scenery<'a> {
    shape: &'a MachinedProfile,
    diameter_mm: f64,
    tolerance_mm: f64,
    /// The paper's construction of the region that the tool's centre must not enter.
    prohibited: Vec<Mm2>,
}

impl<'a> Scenery<'a> {
    fn new(shape: &'a MachinedProfile, diameter_mm: f64, tolerance_mm: f64) -> Result<Self, StudyError> {
        let prohibited = prohibited(&shape.corners, diameter_mm / 2.0, shape.side())
            .map_err(|source| StudyError::Radius { name: shape.name.clone(), source })?;
        Ok(Self { shape, diameter_mm, tolerance_mm, prohibited })
    }

    /// View of the part and of the ways of the tool.
    fn view(&self, ways: impl Iterator<Item = Mm2>) -> View {
        let shown = Box2::around(self.shape.corners.iter().copied().chain(ways)).unwrap_or_default();
        View::of(shown.grown(self.diameter_mm / 2.0 + self.tolerance_mm + SPACE_MM))
    }

    fn draw(&self, body: &mut Lines, view: &View) {
        let outline = |corners: &[Mm2]| polyline_of(corners, view) + "Z";
        let profile = outline(&self.shape.corners);
        // A wide line around a polygon is the region within half its width. What is drawn later hides the inner half.
        let around = |outline: &str, by_mm: f64, colour: &str| {
            let line = path(outline).outline(colour, format_args!("{:.1}", 2.0 * by_mm * view.scale));
            line.set("stroke-linejoin", "round")
        };
        let part = match self.shape.side() {
            MachinedSide::Inside => path(view.everything() + &profile).set("fill-rule", "evenodd"),
            MachinedSide::Outside => path(&profile),
        };
        let band = around(&outline(&self.prohibited), self.tolerance_mm, TOLERANCE);
        body.draw(&[band, around(&profile, self.diameter_mm / 2.0, INVASION)]);
        body.draw(&[part.fill(PART), path(&profile).outline("#333", 1.2)]);
    }

    fn legend(&self) -> Vec<Sign> {
        let Self { shape, diameter_mm, tolerance_mm, .. } = self;
        let invasion = format!("invasion: here the tool of Ø {diameter_mm} mm cuts into the part");
        let seen = format!("tolerance T = {tolerance_mm} mm: the controller stops a tool that it sees here");
        vec![
            Sign::new(PART, Mark::Area, format!("the part: {}", shape.title)),
            Sign::new(INVASION, Mark::Area, invasion),
            Sign::new(TOLERANCE, Mark::Area, seen),
        ]
    }
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
    let tolerance_mm = reported.tolerance_mm;
    let scenery = Scenery::new(shape, diameter_mm, tolerance_mm)?;
    let view = scenery.view(attempts.iter().flat_map(|attempt| attempt.points_mm.iter().copied()));
    let mut body = Lines::default();
    scenery.draw(&mut body, &view);
    for attempt in attempts {
        let colour = if attempt.invades { INVADED } else { STOPPED };
        body.draw(&[path(polyline_of(&attempt.points_mm, &view)).outline(colour, 1)]);
        if let Some(&last) = attempt.points_mm.last() {
            body.draw(&[circle(view.xy(last), 1, 3).fill(colour)]);
        }
    }
    let invaded = attempts.iter().filter(|attempt| attempt.invades).count();
    let stopped = format!("attempts without an invasion: {}. A dot is the end", attempts.len() - invaded);
    let mut legend = scenery.legend();
    legend.push(Sign::new(STOPPED, Mark::Line, stopped));
    if invaded > 0 {
        legend.push(Sign::new(INVADED, Mark::Line, format!("attempts with an invasion: {invaded}")));
    }
    let title = format!("The paper's controller, V = {} mm/s, T = {tolerance_mm} mm", reported.feed_mm_s);
    Ok(page(&view, &title, &legend, &body))
}

/// Draws a roughing pass all round `shape` with the paper's controller: its path, and the finishing path "a" along the
/// profile "b".
///
/// # Errors
/// [`StudyError`] if the paper's construction of the prohibited region fails.
pub fn pass_svg(
    shape: &MachinedProfile,
    pass: &RoughingPass,
    diameter_mm: f64,
    roughing: &[Mm2],
) -> Result<String, StudyError> {
    let scenery = Scenery::new(shape, diameter_mm, pass.tolerance_mm)?;
    let view = scenery.view(roughing.iter().copied());
    let mut body = Lines::default();
    scenery.draw(&mut body, &view);
    let invades = |at: &Mm2| shape.clearance(*at) < diameter_mm / 2.0;
    // Neighbouring pieces share a point, so that the line has no gaps.
    let mut begin = 0;
    for piece in roughing.chunk_by(|a, b| invades(a) == invades(b)) {
        let points = &roughing[begin..(begin + piece.len() + 1).min(roughing.len())];
        let (colour, width) = if invades(&piece[0]) { (INVADED, 2.0) } else { (STOPPED, 1.0) };
        body.draw(&[path(polyline_of(points, &view)).outline(colour, width)]);
        begin += piece.len();
    }
    let finishing = polyline_of(&scenery.prohibited, &view) + "Z";
    body.draw(&[path(finishing).outline(FINISHED, 1.5).set("stroke-dasharray", "6 3")]);
    let mut legend = scenery.legend();
    let all = format!("path of roughing: {} approaches", pass.approaches);
    legend.push(Sign::new(STOPPED, Mark::Line, all));
    if pass.invasions > 0 {
        legend.push(Sign::new(INVADED, Mark::Line, format!("invasions on the path: {}", pass.invasions)));
    }
    legend.push(Sign::new(
        FINISHED,
        Mark::Dash,
        "a: the path of finishing, by the paper's construction".to_string(),
    ));
    let speed = pass.speed_mm_s;
    let title = format!("The paper's controller all round, V = {speed} mm/s, T = {} mm", pass.tolerance_mm);
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
