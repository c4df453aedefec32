//! The small plan in the view: the part's outline, the trail and the tool.

use super::canvas::Canvas;
use keepout_planner::{Box2, Mm2};

/// The part's outline, with fewer points for a screen.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ScreenOutline {
    polylines: Vec<Vec<Mm2>>,
    bounds: Box2,
}

/// Least distance between two kept points, as a share of the outline's size.
const DETAIL: f64 = 1.0 / 1000.0;
/// Border around the outline, as a share of the outline's size.
const AROUND: f64 = 0.12;
/// Factor by which the picture widens when the tool leaves it. Steps keep the picture still between two
/// changes.
const WIDER: f64 = 1.5;
/// Most steps of widening.
const WIDER_MAX: u32 = 12;

impl ScreenOutline {
    /// The outline of these polylines, mm. A closed polyline ends where it begins. Drops points that are not
    /// finite.
    pub fn new(polylines: &[Vec<Mm2>]) -> Self {
        let points = polylines.iter().flatten().copied().filter(|point| point.is_finite());
        let Some(bounds) = Box2::around(points) else { return Self::default() };
        let detail = bounds.longer_side() * DETAIL;
        let thinned = |line: &Vec<Mm2>| {
            let mut kept: Vec<Mm2> = Vec::new();
            let mut last = None;
            for &point in line.iter().filter(|point| point.is_finite()) {
                let near = |at: &Mm2| at.distance(point) < detail;
                last = Some(point);
                if !kept.last().is_some_and(near) {
                    kept.push(point);
                }
            }
            kept.extend(last.filter(|last| kept.last() != Some(last)));
            kept
        };
        Self { polylines: polylines.iter().map(thinned).collect(), bounds }
    }

    /// The box that the picture shows. It contains `place`, unless `place` lies outside the widest picture.
    fn frame(&self, place: Option<Mm2>) -> Box2 {
        let (size, middle) = (self.bounds.longer_side().max(1e-3), self.bounds.middle());
        let half = self.bounds.size() / 2.0 + Mm2::new(size, size) * AROUND;
        let frame = |half: Mm2| Box2 { low: middle - half, high: middle + half };
        let Some(place) = place else { return frame(half) };
        let mut wide = half;
        for _ in 0..WIDER_MAX {
            if frame(wide).holds(place) {
                return frame(wide);
            }
            wide = wide * WIDER;
        }
        frame(half)
    }
}

/// Draws outline, trail and tool into `columns` × `lines` characters.
pub fn plan(
    outline: &ScreenOutline,
    trail: &[Mm2],
    tool: Option<(Mm2, f64)>,
    columns: usize,
    lines: usize,
) -> Vec<String> {
    let mut canvas = Canvas::new(columns, lines);
    let (width, height) = canvas.dots();
    let frame = outline.frame(tool.map(|tool| tool.0));
    let scale = (width / frame.size().x).min(height / frame.size().y);
    let middle = frame.middle();
    let place =
        |Mm2 { x, y }: Mm2| (width / 2.0 + (x - middle.x) * scale, height / 2.0 - (y - middle.y) * scale);
    for polyline in &outline.polylines {
        for pair in polyline.windows(2) {
            canvas.line(place(pair[0]), place(pair[1]));
        }
    }
    // Every other dot only, so that the trail does not look like an outline.
    let mut last = (f64::MIN, f64::MIN);
    for at in trail.iter().map(|&at| place(at)) {
        if (at.0 - last.0).abs().max((at.1 - last.1).abs()) >= 2.0 {
            canvas.dot(at);
            last = at;
        }
    }
    if let Some((at, radius_mm)) = tool {
        draw_tool(&mut canvas, place(at), radius_mm * scale);
    }
    canvas.text()
}

/// Draws the tool's circle if it is large enough to see, and marks the centre.
fn draw_tool(canvas: &mut Canvas, at: (f64, f64), radius: f64) {
    let (width, height) = canvas.dots();
    if (3.0..1000.0).contains(&radius) {
        for step in 0..32 {
            let point = |step: i32| {
                let turn = std::f64::consts::TAU * f64::from(step) / 32.0;
                (at.0 + radius * turn.cos(), at.1 + radius * turn.sin())
            };
            canvas.line(point(step), point(step + 1));
        }
    }
    // Outside the widest picture, the mark stands at the edge.
    let inside = |value: f64, size: f64| value.min(size - 1.0).max(0.0);
    canvas.mark((inside(at.0, width), inside(at.1, height)), '●');
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> ScreenOutline {
        ScreenOutline::new(&[[(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0), (0.0, 0.0)]
            .map(Mm2::from)
            .to_vec()])
    }

    #[test]
    fn tool_is_always_in_the_picture() {
        for at in
            [(5.0, 5.0), (-3.0, 5.0), (500.0, -400.0), (1e9, 1e9), (f64::NAN, 0.0), (f64::MAX, f64::MIN)]
        {
            let lines = plan(&square(), &[], Some((at.into(), 1.0)), 20, 10);
            assert!(lines.iter().all(|line| line.chars().count() == 20));
            assert!(lines.concat().contains('●') || at.0.is_nan(), "{at:?}");
        }
    }

    #[test]
    fn large_outline_keeps_few_points() {
        let ring: Vec<Mm2> =
            (0..1_000_000).map(|i| f64::from(i) * 1e-5).map(|turn| Mm2::unit(turn) * 50.0).collect();
        let outline = ScreenOutline::new(&[
            ring,
            vec![Mm2::new(f64::NAN, 0.0), Mm2::new(0.0, f64::INFINITY)],
            Vec::new(),
        ]);
        assert!(outline.polylines[0].len() < 6000);
        assert!(ScreenOutline::new(&[]) == ScreenOutline::default());
        assert_eq!(plan(&ScreenOutline::default(), &[Mm2::ZERO], None, 3, 2).len(), 2);
    }
}
