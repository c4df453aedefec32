//! Attempts with the paper's controller, as a picture like Fig. 8.

use keepout_planner::profile::MachinedSide;
use keepout_planner::report::chart::{round_steps, sheet};
use keepout_planner::report::element::{Element, Lines, background, circle, path, points, polyline, text};
use keepout_planner::{Box2, Mm2};

use super::invasion::prohibited;
use super::scenario::{MachinedProfile, Reported, StudyError};

/// Width of the picture, pixels.
const WIDTH: f64 = 900.0;
/// Space around the drawing, pixels.
const MARGIN: f64 = 24.0;
/// Height of a line of the legend.
const ROW: f64 = 20.0;
// Colours that differ for people who confuse red and green (Okabe and Ito, 2008).
const PART: &str = "#b9bec9";
const INVASION: &str = "#f0e442";
const TOLERANCE: &str = "#fbf6cf";
const STOPPED: &str = "#0072b2";
const INVADED: &str = "#d55e00";

/// The path of an attempt, and whether the tool invaded the part.
#[derive(Clone, Debug, PartialEq)]
pub struct DrawnAttempt {
    /// Path of the tool's centre, mm.
    pub points_mm: Vec<Mm2>,
    /// Whether the tool entered the part.
    pub invades: bool,
}

/// The drawing's coordinates on the picture.
struct Field {
    shown: Box2,
    scale: f64,
}

impl Field {
    fn of(corners: &[Mm2], attempts: &[DrawnAttempt], around_mm: f64) -> Self {
        let all = corners.iter().chain(attempts.iter().flat_map(|attempt| &attempt.points_mm));
        let at = |point: &Mm2| Box2 { low: *point, high: *point };
        let box_of_all = all.map(at).reduce(Box2::union).unwrap_or(Box2 { low: Mm2::ZERO, high: Mm2::ZERO });
        let shown = box_of_all.grown(around_mm);
        Self { shown, scale: (WIDTH - 2.0 * MARGIN) / (shown.high.x - shown.low.x) }
    }

    fn height(&self) -> f64 {
        self.scale * (self.shown.high.y - self.shown.low.y)
    }

    fn xy(&self, at: Mm2) -> (f64, f64) {
        (MARGIN + self.scale * (at.x - self.shown.low.x), MARGIN + self.scale * (self.shown.high.y - at.y))
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
    let (radius, tolerance) = (diameter_mm / 2.0, reported.tolerance_mm);
    let prohibited = prohibited(&shape.corners, radius, shape.side())
        .map_err(|source| StudyError::Radius { name: shape.name.clone(), source })?;
    let field = Field::of(&shape.corners, attempts, radius + tolerance + 3.0);
    let mut body = Lines::default();
    body.draw(&[background("#fff")]);
    body.draw(&[Element::new("clipPath").set("id", "field").with(&frame(&field))]);
    let mut inside = Lines::default();
    let outline = |corners: &[Mm2]| {
        let outline = points(corners.iter().map(|&corner| field.xy(corner)), 1);
        Element::new("polygon").set("points", outline.trim_end())
    };
    // A wide line around a polygon is the region within half its width. What is drawn later hides the inner half.
    let around = |corners: &[Mm2], by_mm: f64, colour: &str| {
        let line = outline(corners).outline(colour, format_args!("{:.1}", 2.0 * by_mm * field.scale));
        line.set("stroke-linejoin", "round")
    };
    inside.draw(&[around(&prohibited, tolerance, TOLERANCE), around(&shape.corners, radius, INVASION)]);
    inside.draw(&[match shape.side() {
        MachinedSide::Inside => {
            let hole = points(shape.corners.iter().map(|&corner| field.xy(corner)), 1);
            let all =
                format_args!("M0 0H{WIDTH}V{:.1}H0ZM{}Z", field.height() + 2.0 * MARGIN, hole.trim_end());
            path(all).fill(PART).set("fill-rule", "evenodd")
        }
        MachinedSide::Outside => outline(&shape.corners).fill(PART),
    }]);
    inside.draw(&[outline(&shape.corners).outline("#333", 1.2)]);
    for attempt in attempts {
        let colour = if attempt.invades { INVADED } else { STOPPED };
        let way = points(attempt.points_mm.iter().map(|&point| field.xy(point)), 1);
        inside.draw(&[polyline(way.trim_end()).outline(colour, 1)]);
        if let Some(&last) = attempt.points_mm.last() {
            inside.draw(&[circle(field.xy(last), 1, 3).fill(colour)]);
        }
    }
    body.draw(&[Element::new("g").set("clip-path", "url(#field)").lines(&inside)]);
    body.draw(&[frame(&field).fill("none").set("stroke", "#9aa0a8")]);
    let invaded = attempts.iter().filter(|attempt| attempt.invades).count();
    let mut entries = vec![
        (PART, format!("the part: {}", shape.title)),
        (INVASION, format!("invasion: here the tool of Ø {diameter_mm} mm cuts into the part")),
        (TOLERANCE, format!("tolerance T = {tolerance} mm: the controller stops a tool that it sees here")),
        (STOPPED, format!("attempts without an invasion: {}. A dot is the end", attempts.len() - invaded)),
    ];
    if invaded > 0 {
        entries.push((INVADED, format!("attempts with an invasion: {invaded}")));
    }
    let title = format!("The paper's controller, V = {} mm/s, T = {tolerance} mm", reported.feed_mm_s);
    legend(&mut body, &field, &title, &entries);
    let height = field.height() + 3.0 * MARGIN + 6.0 + entries.iter().map(|_| ROW).sum::<f64>();
    Ok(sheet((WIDTH, height), 13, &body))
}

fn frame(field: &Field) -> Element {
    let corner = Element::new("rect").set("x", MARGIN).set("y", MARGIN);
    corner.fixed("width", WIDTH - 2.0 * MARGIN, 1).fixed("height", field.height(), 1)
}

/// Draws the title, the scale and the legend below the field.
fn legend(body: &mut Lines, field: &Field, title: &str, entries: &[(&str, String)]) {
    let mut y = field.height() + 2.0 * MARGIN + 6.0;
    let wanted = 160.0 / field.scale;
    let step = round_steps(wanted).into_iter().rfind(|&step| step <= wanted).unwrap_or(wanted);
    let from = WIDTH - MARGIN - step * field.scale;
    let bar = format_args!("M{from:.1} {:.1}v10m0 -5h{:.1}m0 -5v10", y - 10.0, step * field.scale);
    let length = text((from - 8.0, y), 1, format_args!("{step} mm")).set("text-anchor", "end");
    body.draw(&[text((MARGIN, y), 1, title).bold(16), path(bar).outline("#111", 1.5), length]);
    for (colour, words) in entries {
        y += ROW;
        let mark = Element::new("rect").set("x", MARGIN).fixed("y", y - 11.0, 1);
        let mark = mark.set("width", 30).set("height", 13).fill(colour).stroke("#777", 0.5);
        body.draw(&[mark, text((MARGIN + 40.0, y), 1, words)]);
    }
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
