//! The small plan in the view: the part's outline, the trail and the tool.

use super::canvas::Canvas;

/// The part's outline, with fewer points for a screen.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ScreenOutline {
    polylines: Vec<Vec<(f64, f64)>>,
    low: (f64, f64),
    high: (f64, f64),
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
    pub fn new(polylines: &[Vec<(f64, f64)>]) -> Self {
        let finite = |point: &&(f64, f64)| point.0.is_finite() && point.1.is_finite();
        let (mut low, mut high) = ((f64::MAX, f64::MAX), (f64::MIN, f64::MIN));
        for &(x, y) in polylines.iter().flatten().filter(finite) {
            low = (low.0.min(x), low.1.min(y));
            high = (high.0.max(x), high.1.max(y));
        }
        if low.0 > high.0 {
            return Self::default();
        }
        let detail = (high.0 - low.0).max(high.1 - low.1) * DETAIL;
        let thinned = |line: &Vec<(f64, f64)>| {
            let mut kept: Vec<(f64, f64)> = Vec::new();
            let mut last = None;
            for &point in line.iter().filter(finite) {
                let near = |at: &(f64, f64)| (at.0 - point.0).hypot(at.1 - point.1) < detail;
                last = Some(point);
                if !kept.last().is_some_and(near) {
                    kept.push(point);
                }
            }
            kept.extend(last.filter(|last| kept.last() != Some(last)));
            kept
        };
        Self { polylines: polylines.iter().map(thinned).collect(), low, high }
    }

    /// The box that the picture shows. It contains `place`, unless `place` lies outside the widest picture.
    fn frame(&self, place: Option<(f64, f64)>) -> ((f64, f64), (f64, f64)) {
        let size = (self.high.0 - self.low.0).max(self.high.1 - self.low.1).max(1e-3);
        let middle = (f64::midpoint(self.low.0, self.high.0), f64::midpoint(self.low.1, self.high.1));
        let half = (
            (self.high.0 - self.low.0) / 2.0 + size * AROUND,
            (self.high.1 - self.low.1) / 2.0 + size * AROUND,
        );
        let frame = |half: (f64, f64)| {
            ((middle.0 - half.0, middle.1 - half.1), (middle.0 + half.0, middle.1 + half.1))
        };
        let Some((x, y)) = place else { return frame(half) };
        let mut wide = half;
        for _ in 0..WIDER_MAX {
            if (x - middle.0).abs() <= wide.0 && (y - middle.1).abs() <= wide.1 {
                return frame(wide);
            }
            wide = (wide.0 * WIDER, wide.1 * WIDER);
        }
        frame(half)
    }
}

/// Draws outline, trail and tool into `columns` × `lines` characters.
pub fn plan(
    outline: &ScreenOutline,
    trail: &[(f64, f64)],
    tool: Option<((f64, f64), f64)>,
    columns: usize,
    lines: usize,
) -> Vec<String> {
    let mut canvas = Canvas::new(columns, lines);
    let (width, height) = canvas.dots();
    let (low, high) = outline.frame(tool.map(|tool| tool.0));
    let scale = (width / (high.0 - low.0)).min(height / (high.1 - low.1));
    let middle = (f64::midpoint(low.0, high.0), f64::midpoint(low.1, high.1));
    let place =
        |(x, y): (f64, f64)| (width / 2.0 + (x - middle.0) * scale, height / 2.0 - (y - middle.1) * scale);
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
        ScreenOutline::new(&[vec![(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0), (0.0, 0.0)]])
    }

    #[test]
    fn tool_is_always_in_the_picture() {
        for at in
            [(5.0, 5.0), (-3.0, 5.0), (500.0, -400.0), (1e9, 1e9), (f64::NAN, 0.0), (f64::MAX, f64::MIN)]
        {
            let lines = plan(&square(), &[], Some((at, 1.0)), 20, 10);
            assert!(lines.iter().all(|line| line.chars().count() == 20));
            assert!(lines.concat().contains('●') || at.0.is_nan(), "{at:?}");
        }
    }

    #[test]
    fn large_outline_keeps_few_points() {
        let ring: Vec<(f64, f64)> = (0..1_000_000)
            .map(|i| f64::from(i) * 1e-5)
            .map(|turn| (50.0 * turn.cos(), 50.0 * turn.sin()))
            .collect();
        let outline = ScreenOutline::new(&[ring, vec![(f64::NAN, 0.0), (0.0, f64::INFINITY)], Vec::new()]);
        assert!(outline.polylines[0].len() < 6000);
        assert!(ScreenOutline::new(&[]) == ScreenOutline::default());
        assert_eq!(plan(&ScreenOutline::default(), &[(0.0, 0.0)], None, 3, 2).len(), 2);
    }
}
