//! SVG pictures like the paper's Figs. 11 to 21: contour error over time, and magnified around circles and
//! corners.

use keepout_drives::Axes;
use keepout_drives::metrics::{Moment, figure};
use keepout_planner::report::chart::{round_above, sheet};
use keepout_planner::report::element::{Element, Lines, background, points, polyline, text};

use super::comparison::{ControllerEntry, Row};
use super::scenario::PathShape;

/// Side of a panel.
const SIDE: f64 = 190.0;
/// Space between panels.
const GAP: f64 = 44.0;
/// Height of the text above a panel.
const HEAD: f64 = 34.0;
/// Number of panels side by side.
const COLUMNS: usize = 6;
/// Approximate largest number of points of a curve.
const POINTS: usize = 700;
/// Height of a panel of errors over time.
const TIME_HEIGHT: f64 = 90.0;
/// Height of the words below a panel.
const FOOT: f64 = 16.0;

/// The scale of all panels of a picture.
struct Scale {
    /// Largest error that the panels of errors over time show, µm.
    division: f64,
    /// Half the side of a panel of a corner, pulses.
    reach: f64,
}

impl Scale {
    fn of(row: &Row, shown: &[&ControllerEntry]) -> Self {
        let largest = |of: fn(&Moment) -> f64| {
            let moments = shown.iter().flat_map(|entry| entry.outcome.in_motion());
            moments.map(of).fold(0.0, f64::max)
        };
        let worst = largest(|moment| moment.contour_error.abs());
        // Half the panel shows three times the error.
        let reach = (3.0 * worst.max(largest(|moment| moment.overshoot))).max(1.0);
        Self { division: division(worst * row.um()), reach }
    }
}

/// Picture of a row: one panel per controller, all with one scale. Runs that diverge are missing.
#[must_use]
pub fn svg(row: &Row) -> String {
    let shown: Vec<&ControllerEntry> =
        row.entries.iter().filter(|entry| entry.outcome.figures.contour.max < 1e6).collect();
    let columns = shown.len().clamp(1, COLUMNS);
    let with_path = !matches!(row.scenario.path, PathShape::Line { .. });
    let panel_height = HEAD + TIME_HEIGHT + FOOT + if with_path { SIDE + FOOT } else { 0.0 };
    let scale = Scale::of(row, &shown);
    let lines = shown.len().div_ceil(COLUMNS).max(1);
    let (width, height) =
        (count(columns) * (SIDE + GAP) + GAP, count(lines) * (panel_height + GAP) + GAP + 22.0);
    let title = format!("{}: {}, {} m/min", row.scenario.name, row.scenario.title, row.scenario.feed_m_min);
    let mut body = Lines::default();
    body.draw(&[background("#fff")]);
    body.draw(&[text((GAP, 26.0), 0, title).set("font-size", 15)]);
    for (number, entry) in shown.into_iter().enumerate() {
        let x = GAP + count(number % COLUMNS) * (SIDE + GAP);
        let y = GAP + 22.0 + count(number / COLUMNS) * (panel_height + GAP);
        let place = format_args!("translate({x:.1} {y:.1})");
        let drawn = panel(row, entry, &scale, with_path.then_some(number));
        body.draw(&[Element::new("g").set("transform", place).lines(&drawn)]);
    }
    sheet((width, height), 11, &body)
}

#[expect(clippy::cast_precision_loss, reason = "a count of panels or points")]
fn count(number: usize) -> f64 {
    number as f64
}

/// The panel of a controller. `path` is its number if it shows the path, too.
fn panel(row: &Row, entry: &ControllerEntry, scale: &Scale, path: Option<usize>) -> Lines {
    let contour = entry.outcome.figures.contour.times(row.um());
    let errors = format!("RMS {} · max {} µm", figure(contour.rms), figure(contour.max));
    let mut body = Lines::default();
    body.draw(&[Element::new("text").set("y", 11).text(entry.name())]);
    body.draw(&[Element::new("text").set("y", 25).fill("#555").text(errors)]);
    let moments = entry.outcome.in_motion();
    over_time(&mut body, moments, row.um(), scale.division);
    if let Some(number) = path {
        let drawn = match row.scenario.path {
            PathShape::Corner { .. } => at_corner(row, moments, scale.reach, number),
            _ => magnified(row, moments, scale.division),
        };
        let place = format_args!("translate(0 {:.1})", HEAD + TIME_HEIGHT + FOOT);
        body.draw(&[Element::new("g").set("transform", place).lines(&drawn)]);
    }
    body
}

/// Smallest round step that is not below the error, µm.
fn division(max: f64) -> f64 {
    round_above(max.max(1e-4))
}

/// Every nth moment, so that a curve has about [`POINTS`] points.
fn thinned(moments: &[Moment]) -> impl Iterator<Item = &Moment> {
    moments.iter().step_by(moments.len().div_ceil(POINTS).max(1))
}

fn curve(at: impl Iterator<Item = (f64, f64)>, (colour, width): (&str, f64)) -> Element {
    polyline(&points(at, 1)).outline(colour, width)
}

/// Words below a panel whose lower edge is at `y`.
fn note(y: f64, words: &str) -> Element {
    label((0.0, y + 11.0), "start", words)
}

/// Small words.
fn label((x, y): (f64, f64), anchor: &str, words: &str) -> Element {
    let place = Element::new("text").fixed("x", x, 1).fixed("y", y, 1).set("text-anchor", anchor);
    place.fill("#555").set("font-size", 9).text(words)
}

/// Colour and width of the line of a curve.
const CURVE: (&str, f64) = ("#b03020", 1.1);
/// Colour and width of the line of a path.
const PATH: (&str, f64) = ("#888", 0.8);

/// Draws the contour error over time.
fn over_time(body: &mut Lines, moments: &[Moment], um: f64, division: f64) {
    let (top, middle) = (HEAD, HEAD + TIME_HEIGHT / 2.0);
    let last = moments.last().map_or(1.0, |moment| moment.at_s.max(1e-9));
    let axis = Element::new("line").set("y1", middle).set("x2", SIDE).set("y2", middle);
    let frame = Element::new("rect").set("y", top).set("width", SIDE).set("height", TIME_HEIGHT);
    body.draw(&[frame.fill("none").set("stroke", "#ccc")]);
    body.draw(&[axis.stroke(PATH.0, PATH.1)]);
    let bottom = top + TIME_HEIGHT;
    for (y, value) in
        [(top + 8.0, plain(division)), (middle + 3.0, "0 µm".into()), (bottom, plain(-division))]
    {
        body.draw(&[label((-4.0, y), "end", &value)]);
    }
    body.draw(&[note(bottom, "0 s"), label((SIDE, bottom + 11.0), "end", &format!("{last:.2} s"))]);
    let at = |moment: &Moment| {
        (moment.at_s / last * SIDE, middle - moment.contour_error * um / division * TIME_HEIGHT / 2.0 * 0.95)
    };
    body.draw(&[curve(thinned(moments).map(at), CURVE)]);
}

/// `value` without trailing zeros.
fn plain(value: f64) -> String {
    let text = format!("{value:.4}");
    text.trim_end_matches('0').trim_end_matches('.').into()
}

/// Draws a closed path, with the errors magnified across it.
fn magnified(row: &Row, moments: &[Moment], division: f64) -> Lines {
    let path = &row.task.path;
    let length = path.length();
    let along = |share: f64| path.at(share * length).map(|(_, foot)| foot.point);
    let outline: Vec<Axes> = (0..=240).filter_map(|i| along(f64::from(i) / 240.0)).collect();
    let (low, high) =
        outline.iter().fold((Axes::repeat(f64::MAX), Axes::repeat(f64::MIN)), |(low, high), point| {
            (low.inf(point), high.sup(point))
        });
    let size = (high - low).max().max(1.0);
    // The outline takes two thirds of the panel. One division of the error takes 14 % of it.
    let scale = SIDE * 0.66 / size;
    let centre = (low + high) / 2.0;
    let place = |point: Axes| {
        let off = (point - centre) * scale;
        (SIDE / 2.0 + off.x, SIDE / 2.0 - off.y)
    };
    let mut body = Lines::default();
    body.draw(&[curve(outline.iter().map(|&point| place(point)), PATH)]);
    let across = round_below(SIDE * 0.14 / (division / row.um()) / scale);
    let shown = thinned(moments).map(|moment| {
        let number = path.at(0.0).map_or(0, |(number, _)| number);
        let foot = path.nearest(moment.position, nearest_piece(row, moment, number));
        place(foot.point + keepout_drives::path::left_of(foot.tangent) * moment.contour_error * across)
    });
    body.draw(&[curve(shown, CURVE)]);
    body.draw(&[note(SIDE, &format!("errors across the path × {across:.0}"))]);
    body
}

/// The largest of 1, 2, 5, 10, 20 and so on that is not above the value. At least 1.
fn round_below(value: f64) -> f64 {
    let power = 10_f64.powf(value.max(1.0).log10().floor());
    [5.0, 2.0].into_iter().map(|digit| digit * power).find(|&round| round <= value).unwrap_or(power)
}

/// Number of the piece that the reference is on.
fn nearest_piece(row: &Row, moment: &Moment, first: usize) -> usize {
    let pieces = row.task.path.pieces();
    let distance =
        |number: &usize| (pieces[*number].nearest(moment.reference).point - moment.reference).norm();
    if pieces.len() == 1 {
        return first;
    }
    (0..pieces.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(first)
}

/// Draws the corner. `reach` is half the side of the panel, pulses.
fn at_corner(row: &Row, moments: &[Moment], reach: f64, number: usize) -> Lines {
    let mut body = Lines::default();
    let Some(tip) = row.task.path.pieces().get(1).map(|piece| piece.at(0.0).point) else { return body };
    let scale = SIDE / 2.0 / reach;
    let place = |point: Axes| {
        let off = (point - tip) * scale;
        (SIDE / 2.0 + off.x, SIDE / 2.0 - off.y)
    };
    let clip = format!("corner-{}-{number}", row.scenario.name);
    let frame = Element::new("rect").set("width", SIDE).set("height", SIDE);
    body.draw(&[Element::new("clipPath").set("id", &clip).with(&frame)]);
    body.draw(&[frame.fill("none").set("stroke", "#ccc")]);
    let mut curves = Lines::default();
    let ends = row.task.path.pieces().iter().flat_map(|piece| [piece.at(0.0), piece.at(piece.length())]);
    curves.draw(&[curve(ends.map(|foot| place(foot.point)), PATH)]);
    let near = moments.iter().filter(|moment| (moment.position - tip).amax() <= 2.0 * reach);
    curves.draw(&[curve(near.map(|moment| place(moment.position)), CURVE)]);
    body.draw(&[Element::new("g").set("clip-path", format_args!("url(#{clip})")).lines(&curves)]);
    body.draw(&[note(SIDE, &format!("{} µm from edge to edge", figure(2.0 * reach * row.um())))]);
    body
}

#[cfg(test)]
mod tests {
    use keepout_drives::controllers::kind::Kind;
    use keepout_drives::profile::DriveProfile;

    use super::*;
    use crate::koren_lo::comparison::ModelError;
    use crate::koren_lo::scenario::DriveScenario;

    /// Each shape gives a picture with one panel per controller, and without NaN or infinity.
    #[test]
    fn pictures_have_a_panel_for_each_controller() {
        for name in ["S1", "S6", "E1"] {
            let rows = DriveScenario::built_in().unwrap();
            let scenario = rows.iter().find(|row| row.name == name).unwrap();
            let mut row = Row::new(scenario, &DriveProfile::load(&scenario.machine).unwrap());
            let kinds = [Kind::P, Kind::Pid, Kind::Ccc];
            row.entries = kinds.into_iter().filter_map(|kind| row.entry(kind, ModelError::NONE)).collect();
            let picture = svg(&row);
            assert_eq!(picture.matches("RMS").count(), 3);
            assert!(!picture.contains("NaN") && !picture.contains("inf"));
            assert_eq!(picture.matches("<g").count(), picture.matches("</g>").count());
        }
    }

    #[test]
    fn magnifications_are_round_and_not_above_the_value() {
        assert_eq!([0.3, 1.9, 4.0, 169_697.0].map(round_below), [1.0, 1.0, 2.0, 100_000.0]);
    }

    #[test]
    fn divisions_are_round_and_not_below_the_error() {
        assert_eq!([0.032, 2.8, 11.9, 566.0].map(|max| plain(division(max))), ["0.05", "5", "20", "1000"]);
    }
}
