//! The geometry of Figs. 4 to 6, drawn from what the functions of [`super::invasion`] compute.

use std::fmt::Write as _;

use keepout_planner::Mm2;
use keepout_planner::profile::MachinedSide;
use keepout_planner::report::chart::sheet;
use keepout_planner::report::element::{Lines, background, circle, line, path, text};

use super::invasion::{
    Classified, Intervals, PointMatrix, angle_sum_deg, filter_very_close, is_above, prohibited, setback_mm,
    turn_rad,
};

/// Size of a panel, pixels.
const PANEL: (f64, f64) = (330.0, 290.0);
/// Pixels for a millimetre.
const SCALE: f64 = 5.0;
const INK: &str = "#1d2025";
const PART: &str = "#b9bec9";
const PATH: &str = "#0072b2";
const FOUND: &str = "#b45309";

/// A panel of the picture: its column and row, and what it has drawn.
struct Panel<'a> {
    body: &'a mut Lines,
    left: f64,
    top: f64,
}

impl<'a> Panel<'a> {
    /// A panel with its title and one line of explanation.
    fn new(body: &'a mut Lines, (column, row): (u32, u32), title: &str, says: &str) -> Self {
        let (left, top) = (PANEL.0 * f64::from(column), PANEL.1 * f64::from(row));
        let title = text((left + 12.0, top + 20.0), 0, title).set("font-weight", "bold");
        body.draw(&[title, text((left + 12.0, top + 38.0), 0, says)]);
        Self { body, left, top }
    }

    fn xy(&self, at: Mm2) -> (f64, f64) {
        (self.left + 30.0 + at.x * SCALE, self.top + PANEL.1 - 22.0 - at.y * SCALE)
    }

    fn route(&self, corners: &[Mm2]) -> String {
        let mut route = String::new();
        for (number, &corner) in corners.iter().enumerate() {
            let (x, y) = self.xy(corner);
            let _ = write!(route, "{}{x:.1} {y:.1}", if number == 0 { 'M' } else { 'L' });
        }
        route
    }

    fn part(&mut self, corners: &[Mm2]) {
        let route = self.route(corners) + "Z";
        self.body.draw(&[path(route).fill(PART).stroke(INK, 1)]);
    }

    fn way(&mut self, corners: &[Mm2], colour: &str, width: f64) {
        let route = self.route(corners);
        self.body.draw(&[path(route).outline(colour, width)]);
    }

    fn dot(&mut self, at: Mm2, colour: &str, radius: f64) {
        let at = self.xy(at);
        self.body.draw(&[circle(at, 1, radius).fill(colour)]);
    }

    fn ring(&mut self, at: Mm2, radius_mm: f64, colour: &str) {
        let at = self.xy(at);
        self.body.draw(&[circle(at, 1, radius_mm * SCALE).outline(colour, 1.2)]);
    }

    fn link(&mut self, from: Mm2, to: Mm2, colour: &str) {
        let (from, to) = (self.xy(from), self.xy(to));
        self.body.draw(&[line(from, to, 1).stroke(colour, 1).set("stroke-dasharray", "3 3")]);
    }

    fn name(&mut self, at: Mm2, (dx, dy): (f64, f64), name: &str) {
        let (x, y) = self.xy(at);
        // A white edge keeps words readable on lines.
        let word = text((x + dx, y + dy), 1, name).set("paint-order", "stroke");
        self.body.draw(&[word.fill(INK).stroke("#fff", 3).set("stroke-linejoin", "round")]);
    }
}

/// The picture.
#[must_use]
pub fn svg() -> String {
    let mut body = Lines::default();
    body.draw(&[background("#fff")]);
    points(&mut body);
    angles(&mut body);
    intervals(&mut body);
    very_close(&mut body);
    above_and_below(&mut body);
    sheet((3.0 * PANEL.0, 2.0 * PANEL.1), 12, &body)
}

/// Fig. 4 (a), eq. (1).
fn points(body: &mut Lines) {
    let profile = [(4.0, 4.0), (50.0, 8.0), (46.0, 26.0), (8.0, 22.0)].map(Mm2::from);
    let (tool, tolerance_mm, spacing_mm) = (Mm2::new(24.0, 30.0), 9.0, 4.0);
    let matrix = PointMatrix::new(&profile, spacing_mm);
    let points = matrix.map(|matrix| matrix.points().to_vec()).unwrap_or_default();
    let near = points.iter().filter(|point| point.distance(tool) <= tolerance_mm).count();
    let says =
        format!("E = {spacing_mm} mm, T = {tolerance_mm} mm: {near} of {} points are near", points.len());
    let mut panel = Panel::new(body, (0, 0), "Fig. 4 (a), eq. (1): points of the profile", &says);
    panel.part(&profile);
    for point in points {
        let colour = if point.distance(tool) <= tolerance_mm { FOUND } else { INK };
        panel.dot(point, colour, 2.2);
    }
    panel.ring(tool, tolerance_mm, FOUND);
    panel.dot(tool, PATH, 3.5);
    panel.name(tool, (6.0, -4.0), "Pf");
}

/// Fig. 4 (b).
fn angles(body: &mut Lines) {
    let triangle = [(6.0, 6.0), (52.0, 10.0), (26.0, 36.0)].map(Mm2::from);
    let (out, within) = (Mm2::new(48.0, 32.0), Mm2::new(27.0, 16.0));
    let sum = |at: Mm2| angle_sum_deg(at, triangle);
    let says = format!("P4 outside: {:.0}°. Inside: {:.0}°", sum(out), sum(within));
    let mut panel = Panel::new(body, (1, 0), "Fig. 4 (b): the sum of angles", &says);
    panel.part(&triangle);
    for (at, colour) in [(out, PATH), (within, FOUND)] {
        triangle.iter().for_each(|&corner| panel.link(at, corner, colour));
        panel.dot(at, colour, 3.5);
    }
    panel.name(out, (6.0, -4.0), "P4");
    for (number, (corner, by)) in
        triangle.into_iter().zip([(-18.0, 4.0), (6.0, 4.0), (-6.0, -8.0)]).enumerate()
    {
        panel.name(corner, by, &format!("P{}", number + 1));
    }
}

/// Fig. 4 (c), eq. (2).
fn intervals(body: &mut Lines) {
    let profile = [(6.0, 26.0), (26.0, 36.0), (48.0, 28.0), (44.0, 6.0), (12.0, 4.0)].map(Mm2::from);
    let tool = Mm2::new(17.0, 38.0);
    let selected: Vec<(usize, f64)> = Intervals::new(&profile, Classified::ByX).selected(tool).collect();
    let distances: Vec<String> = selected.iter().map(|(_, far)| format!("{far:.1}")).collect();
    let says = format!("the x interval holds Pf: d = {} mm", distances.join(", "));
    let mut panel = Panel::new(body, (2, 0), "Fig. 4 (c), eq. (2): segments by intervals", &says);
    panel.part(&profile);
    for (number, _) in selected {
        let (from, to) = (profile[number], profile[(number + 1) % profile.len()]);
        panel.way(&[from, to], FOUND, 3.0);
        panel.link(tool, tool.nearest_on(from, to), FOUND);
    }
    panel.link(Mm2::new(tool.x, 0.0), Mm2::new(tool.x, 42.0), PATH);
    panel.dot(tool, PATH, 3.5);
    panel.name(tool, (6.0, -4.0), "Pf");
    let by = [(-20.0, 4.0), (-4.0, -8.0), (6.0, 0.0), (6.0, 8.0), (-16.0, 14.0)];
    for (number, (corner, by)) in profile.into_iter().zip(by).enumerate() {
        panel.name(corner, by, &format!("P{}", number + 1));
    }
}

/// Fig. 5 (a), eqs. (3) and (4).
fn very_close(body: &mut Lines) {
    let radius_mm = 6.0;
    let profile = [(4.0, 6.0), (28.0, 26.0), (29.6, 26.0), (52.0, 8.0)].map(Mm2::from);
    let kept = filter_very_close(&profile, radius_mm);
    let (setback, apart) = (
        setback_mm(radius_mm, turn_rad(profile[1], profile[2], profile[3])),
        profile[1].distance(profile[2]),
    );
    let kept_or = if kept.len() < profile.len() { "one is removed" } else { "both stay" };
    let says = format!("d = {setback:.1} mm, |AB| = {apart:.1} mm: {kept_or}");
    let mut panel = Panel::new(body, (0, 1), "Fig. 5 (a), eqs. (3), (4): very close points", &says);
    panel.part(&profile);
    panel.way(&kept, PATH, 2.0);
    for (corner, name) in profile[1..].iter().zip(["A", "B", "C"]) {
        let removed = !kept.contains(corner);
        panel.dot(*corner, if removed { FOUND } else { INK }, 3.0);
        panel.name(*corner, if name == "A" { (-14.0, -6.0) } else { (6.0, -6.0) }, name);
    }
}

/// Figs. 5 (b) and 6, eqs. (5) to (13).
fn above_and_below(body: &mut Lines) {
    let radius_mm = 6.0;
    // The route of the part, clockwise, with the tool on its left.
    let profiles = [
        [(4.0, 4.0), (6.0, 18.0), (28.0, 28.0), (50.0, 14.0), (48.0, 4.0)],
        [(4.0, 4.0), (6.0, 28.0), (28.0, 14.0), (50.0, 26.0), (48.0, 4.0)],
    ];
    for (column, corners) in (1..).zip(profiles) {
        let profile = corners.map(Mm2::from);
        let [_, a, b, c, _] = profile;
        let above = is_above(a, b, c);
        let (title, says) = if above {
            ("Fig. 6 (a), eqs. (5) to (11): B above AC", "B' = B + R·Ppd + d·Ppl")
        } else {
            ("Fig. 6 (b), eqs. (12), (13): B below AC", "B' = B + R·Ppd − d·Ppl")
        };
        let mut panel = Panel::new(body, (column, 1), title, says);
        panel.part(&profile);
        panel.link(a, c, INK);
        let enlarged = prohibited(&profile, radius_mm, MachinedSide::Outside).unwrap_or_default();
        let near = |corner: Mm2| {
            let by_distance =
                |one: &Mm2, other: &Mm2| corner.distance(*one).total_cmp(&corner.distance(*other));
            enlarged.iter().copied().min_by(by_distance).unwrap_or(corner)
        };
        let route = [a, b, c].map(near);
        panel.way(&route, PATH, 2.0);
        panel.ring(route[1], radius_mm, PATH);
        panel.link(b, route[1], PATH);
        for (corner, name, by) in [(a, "A", (-16.0, 4.0)), (b, "B", (-4.0, 16.0)), (c, "C", (6.0, 6.0))] {
            panel.dot(corner, INK, 3.0);
            panel.name(corner, by, name);
        }
        panel.dot(route[1], PATH, 3.0);
        panel.name(route[1], (6.0, -6.0), "B'");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The words of the panels state what the functions find, and the cases are those of the paper's figures.
    #[test]
    fn panels_show_the_cases_of_the_figures() {
        let svg = svg();
        assert!(
            svg.contains("Inside: 360°") && svg.contains("one is removed") && svg.contains("B above AC"),
            "{svg}"
        );
        assert!(svg.contains("B below AC") && !svg.contains("NaN"));
        assert_eq!(svg.matches("font-weight").count(), 6);
        // Two segments hold the tool in their x interval, as P1P2 and P4P5 in the paper.
        assert_eq!(svg.matches(&format!("stroke=\"{FOUND}\" stroke-width=\"3\"")).count(), 2, "{svg}");
    }
}
