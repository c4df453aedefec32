//! The picture of a circular test.

use keepout_planner::report::chart::{round_above, round_below};
use keepout_planner::report::element::{Element, Lines, circle, line, path, text};
use keepout_planner::report::view::{Mark, Sign, View, page, polyline_of};
use keepout_planner::{Box2, Mm2};

use super::{CircularTest, largest};
use crate::Axes;

// Colours that differ for people who confuse red and green (Okabe and Ito, 2008).
const MEASURED: &str = "#0072b2";
const FARTHEST: &str = "#b45309";
const NOMINAL: &str = "#333333";
const RING: &str = "#9aa0a8";
const NUMBERS: &str = "#5a6069";
/// Size of the largest deviation in the picture, as a share of the radius.
const SHOWN: f64 = 0.25;
/// Least deviation that is magnified to that size, mm.
const LEAST_MM: f64 = 1e-5;
/// Direction of the numbers at the rings, degrees.
const NUMBERS_DEG: f64 = 50.0;
/// Space around the rings, as a share of the radius.
const SPACE: f64 = 0.12;

/// Draws the points about the centre, with magnified deviations, rings at round deviations, and the two largest.
pub(super) fn svg(test: &CircularTest, name: &str) -> String {
    let radius = test.radius_mm;
    let most = largest(test.deviations_mm).max(LEAST_MM);
    let magnified = round_below(SHOWN * radius / most);
    // The ring nearest to the largest deviation from above.
    let ring_mm = round_above(most);
    let shown = |deviation: f64| radius + magnified * deviation;
    let reach = shown(ring_mm.max(most)) + SPACE * radius;
    let view = View::of(Box2 { low: Mm2::new(-reach, -reach), high: Mm2::new(reach, reach) });
    let at =
        |direction: Axes, distance: f64| view.xy(Mm2::new(direction.x * distance, direction.y * distance));
    let mut body = Lines::default();
    for direction in [Axes::new(1.0, 0.0), Axes::new(0.0, 1.0)] {
        let axis = line(at(direction, -reach), at(direction, reach), 1);
        body.draw(&[axis.stroke(RING, 0.7)]);
    }
    for share in [-1.0, -0.5, 0.5, 1.0] {
        let ring =
            circle(at(Axes::zeros(), 0.0), 1, format_args!("{:.1}", shown(share * ring_mm) * view.scale));
        body.draw(&[ring.outline(RING, 0.7).set("stroke-dasharray", "4 4")]);
        body.draw(&[label(at(turned(NUMBERS_DEG), shown(share * ring_mm)), &um(share * ring_mm), NUMBERS)]);
    }
    let nominal = circle(at(Axes::zeros(), 0.0), 1, format_args!("{:.1}", radius * view.scale));
    body.draw(&[nominal.outline(NOMINAL, 1.5)]);
    let way: Vec<Mm2> = test
        .points_mm
        .iter()
        .map(|point| point * (shown(point.norm() - radius) / point.norm().max(f64::MIN_POSITIVE)))
        .map(|point| Mm2::new(point.x, point.y))
        .collect();
    body.draw(&[path(polyline_of(&way, &view)).outline(MEASURED, 1.6)]);
    for (deviation, direction_deg) in test.deviations_mm.into_iter().zip(test.directions_deg) {
        let direction = turned(direction_deg);
        body.draw(&[circle(at(direction, shown(deviation)), 1, 5).fill(FARTHEST)]);
        // Inside the circle there is room for the number.
        body.draw(&[label(at(direction, 0.5 * radius), &um(deviation), FARTHEST)]);
        body.draw(&[
            line(at(direction, 0.57 * radius), at(direction, shown(deviation)), 1).stroke(FARTHEST, 0.7)
        ]);
    }
    let measured = format!(
        "{} points, deviations × {magnified}; a ring is {} from the next",
        test.points_mm.len(),
        um(0.5 * ring_mm).trim_start_matches('+')
    );
    let [most, least] = test.deviations_mm.map(um);
    let legend = [
        Sign::new(NOMINAL, Mark::Line, format!("the circle of {radius} mm about the centre of the points")),
        Sign::new(MEASURED, Mark::Line, measured),
        Sign::new(FARTHEST, Mark::Line, format!("farthest out {most}, farthest in {least}")),
    ];
    page(&view, &format!("Circular test {name}"), &legend, &body)
}

/// A deviation with its sign.
fn um(mm: f64) -> String {
    let um = mm * 1000.0;
    if um.abs() < 100.0 { format!("{um:+.1} µm") } else { format!("{um:+.0} µm") }
}

fn turned(direction_deg: f64) -> Axes {
    let (sin, cos) = direction_deg.to_radians().sin_cos();
    Axes::new(cos, sin)
}

fn label((x, y): (f64, f64), words: &str, colour: &str) -> Element {
    let label = text((x, y + 4.0), 1, words).fill(colour).set("text-anchor", "middle");
    label.stroke("#ffffff", 3).set("paint-order", "stroke")
}

#[cfg(test)]
mod tests {
    use crate::ballbar::CircularTest;
    use crate::number_table::NumberTable;

    fn drawn(oval_mm: f64) -> String {
        let points: String = (0..360)
            .map(|angle| {
                format!("{angle},{}\n", 50.0 + oval_mm * (2.0 * f64::from(angle).to_radians()).cos())
            })
            .collect();
        let table = NumberTable::parse("ball.csv", &format!("angle_deg,radius_mm\n{points}")).unwrap();
        CircularTest::of("ball.csv", &table, 50.0).unwrap().svg("ball.csv")
    }

    #[test]
    fn picture_states_magnification_rings_and_extremes() {
        let svg = drawn(0.008);
        for words in
            ["× 1000", "farthest out +8.0 µm, farthest in -8.0 µm", "+10.0 µm", "-5.0 µm", "360 points"]
        {
            assert!(svg.contains(words), "{words}: {svg}");
        }
    }

    #[test]
    fn perfect_circle_is_drawn() {
        let svg = drawn(0.0);
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    }
}
