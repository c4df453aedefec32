//! Alignment: probe points recover the position of a workpiece; contradictory or ambiguous ones are refused.
#![expect(clippy::unwrap_used, reason = "a test helper may panic")]

use std::path::Path;

use keepout_planner::Mm2;
use keepout_planner::align::file::{AlignmentFile, AlignmentFileError};
use keepout_planner::align::{Alignment, AlignmentError, PartEdges, ProbePoint, ProbePoints, align};
use keepout_planner::machine::MachineProfile;
use keepout_planner::profile::{MachinedSide, Profile};
use keepout_planner::request::PlanRequest;
use proptest::prelude::{Strategy, proptest};

/// The bracket: 0 to 100 by 0 to 60 mm, with further edges.
const BRACKET: &[u8] = include_bytes!("../../executor/cli/drawings/bracket.dxf");

fn part() -> PartEdges {
    drawn(BRACKET)
}

fn drawn(bytes: &[u8]) -> PartEdges {
    let (_, chained) = PlanRequest::default().contours(bytes).unwrap();
    PartEdges::of(&Profile { loops: chained.profile.loops }, MachinedSide::Outside).unwrap()
}

/// A square of 80 mm, one corner at (10, 20), drawn as R10 lines.
fn square() -> PartEdges {
    let corners = [(10, 20), (90, 20), (90, 100), (10, 100), (10, 20)];
    let line = |pair: &[(i32, i32)]| {
        let ((x0, y0), (x1, y1)) = (pair[0], pair[1]);
        format!("0\nLINE\n8\n0\n10\n{x0}\n20\n{y0}\n11\n{x1}\n21\n{y1}\n")
    };
    let lines: String = corners.windows(2).map(line).collect();
    let text = format!(
        "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n4\n0\nENDSEC\n\
         0\nSECTION\n2\nENTITIES\n{lines}0\nENDSEC\n0\nEOF\n"
    );
    drawn(text.as_bytes())
}

fn probe_points(points: Vec<ProbePoint>, edges: Vec<ProbePoint>) -> ProbePoints {
    ProbePoints { points, edges, probe_diameter_mm: 6.0, probe_error_mm: 0.005, tolerance_mm: 0.05 }
}

/// The true position of a workpiece.
#[derive(Clone, Copy, Debug)]
struct Truth {
    degrees: f64,
    origin: Mm2,
}

impl Truth {
    fn machine(&self, Mm2 { x, y }: Mm2) -> Mm2 {
        let (sin, cos) = self.degrees.to_radians().sin_cos();
        Mm2::new(x * cos - y * sin + self.origin.x, x * sin + y * cos + self.origin.y)
    }

    fn point(&self, drawing_mm: Mm2) -> ProbePoint {
        ProbePoint { drawing_mm, machine_mm: self.machine(drawing_mm) }
    }

    /// A probe point on the edge through `at`. The probe of 6 mm touches the edge there, and the user states
    /// the approximate place `near`.
    fn probed(&self, at: Mm2, outward: Mm2, near: Mm2) -> ProbePoint {
        let centre = at + outward * 3.0;
        ProbePoint { drawing_mm: near, machine_mm: self.machine(centre) }
    }

    /// Two probe points on the square's lower edge and one on its left edge.
    fn three_edges(&self) -> Vec<ProbePoint> {
        vec![
            self.probed(Mm2::new(15.0, 20.0), Mm2::new(0.0, -1.0), Mm2::new(16.0, 19.0)),
            self.probed(Mm2::new(85.0, 20.0), Mm2::new(0.0, -1.0), Mm2::new(80.0, 21.0)),
            self.probed(Mm2::new(10.0, 70.0), Mm2::new(-1.0, 0.0), Mm2::new(10.5, 60.0)),
        ]
    }

    fn is_met_by(&self, found: &Alignment, part: &PartEdges, within: f64) {
        for corner in part.corners_mm() {
            let (a, b) = (self.machine(corner), found.machine_mm(corner));
            let off = a.distance(b);
            assert!(off < within, "{off} mm off at {corner:?}: {found:?}");
        }
    }
}

fn truth() -> impl Strategy<Value = Truth> {
    let coordinate = || -400.0..400.0_f64;
    let turned = (-180.0..180.0_f64, coordinate(), coordinate());
    turned.prop_map(|(degrees, x, y)| Truth { degrees, origin: Mm2::new(x, y) })
}

/// Errors of six coordinates, mm. The x and y errors of a point together are at most 5 µm.
fn errors() -> impl Strategy<Value = Vec<f64>> {
    proptest::collection::vec(-0.0035..0.0035_f64, 6)
}

fn disturbed(mut points: Vec<ProbePoint>, errors: &[f64]) -> Vec<ProbePoint> {
    for (point, error) in points.iter_mut().zip(errors.chunks(2)) {
        point.machine_mm.x += error[0];
        point.machine_mm.y += error[1];
    }
    points
}

proptest! {
    #[test]
    fn alignment_from_points_is_within_its_uncertainty(truth in truth(), errors in errors()) {
        let part = part();
        let points: Vec<ProbePoint> =
            [(0.0, 0.0), (100.0, 5.0), (40.0, 60.0)].map(|point| truth.point(point.into())).to_vec();
        let exact = align(&part, &probe_points(points.clone(), vec![])).unwrap();
        truth.is_met_by(&exact, &part, 0.001);
        assert!(exact.turned && exact.residual_mm() < 1e-6 && !exact.poor);
        let found = align(&part, &probe_points(disturbed(points, &errors), vec![])).unwrap();
        truth.is_met_by(&found, &part, found.uncertainty_mm);
    }

    #[test]
    fn three_edge_points_of_a_turned_square_give_its_alignment(truth in truth(), errors in errors()) {
        let part = square();
        let exact = align(&part, &probe_points(vec![], truth.three_edges())).unwrap();
        truth.is_met_by(&exact, &part, 0.001);
        let off = (exact.rotation_deg - truth.degrees).rem_euclid(360.0);
        assert!(off.min(360.0 - off) < 1e-6);
        let found = align(&part, &probe_points(vec![], disturbed(truth.three_edges(), &errors))).unwrap();
        truth.is_met_by(&found, &part, found.uncertainty_mm);
    }

    #[test]
    fn one_point_or_two_edges_give_an_offset(x in -400.0..400.0_f64, y in -400.0..400.0_f64) {
        let (truth, part) = (Truth { degrees: 0.0, origin: Mm2::new(x, y) }, square());
        let found = align(&part, &probe_points(vec![truth.point(Mm2::new(50.0, 50.0))], vec![])).unwrap();
        truth.is_met_by(&found, &part, 0.001);
        assert!(!found.turned && found.rotation_deg == 0.0);
        let [_, lower, left] = truth.three_edges()[..] else { panic!() };
        let found = align(&part, &probe_points(vec![], vec![lower, left])).unwrap();
        truth.is_met_by(&found, &part, 0.001);
        assert!(!found.turned && (found.uncertainty_mm - 0.010_75).abs() < 1e-6, "{found:?}");
    }
}

/// The stated uncertainty is a bound, and not far above the worst case: some errors of 5 µm come to more than
/// 60 % of it.
#[test]
fn errors_reach_most_of_the_stated_uncertainty() {
    let (truth, part) = (Truth { degrees: 30.0, origin: Mm2::new(-200.0, -100.0) }, square());
    let stated = align(&part, &probe_points(vec![], truth.three_edges())).unwrap().uncertainty_mm;
    let mut worst: f64 = 0.0;
    for signs in 0..8_u8 {
        let mut edges = truth.three_edges();
        for (k, point) in edges.iter_mut().enumerate() {
            let sign = if signs >> k & 1 == 1 { 0.005 } else { -0.005 };
            let outward: Mm2 = if k < 2 { Mm2::new(0.0, -1.0) } else { Mm2::new(-1.0, 0.0) };
            let turned = Truth { origin: Mm2::ZERO, ..truth }.machine(outward);
            point.machine_mm.x += turned.x * sign;
            point.machine_mm.y += turned.y * sign;
        }
        let found = align(&part, &probe_points(vec![], edges)).unwrap();
        for corner in part.corners_mm() {
            let (a, b) = (truth.machine(corner), found.machine_mm(corner));
            worst = worst.max(a.distance(b));
        }
    }
    assert!(worst <= stated && worst > 0.6 * stated, "{worst} of {stated}");
}

// Evidence for SR-26, SR-29.
#[test]
fn alignment_of_another_rotation_or_version_is_refused() {
    let file = |version: u32, degrees: f64, residual: f64| {
        let text = format!(
            "version = {version}\nrotation_deg = {degrees}\norigin_mm = [10.0, 20.0]\ndrawing = \"bracket.dxf\"\n\
             method = \"points\"\ntouches = 2\nrotation_measured = true\nresidual_mm = {residual}\n\
             probe_error_mm = 0.005\nuncertainty_mm = 0.01\n"
        );
        AlignmentFile::parse(Path::new("setup.toml"), &text)
    };
    let turned = |degrees: f64, by: Mm2| {
        let mut request = PlanRequest::default();
        request.choice.placed = Some((degrees, by));
        request.plan("bracket", BRACKET, &MachineProfile::simulated(), &mut |_| {}).unwrap().plan
    };
    let measured = file(1, 30.0, 0.01).unwrap();
    assert_eq!(measured.origin_for(&turned(30.0, Mm2::ZERO)).unwrap(), Mm2::new(10.0, 20.0));
    let plain = measured.origin_for(&turned(0.0, Mm2::ZERO)).unwrap_err();
    assert!(matches!(plain, AlignmentFileError::Turned { .. }), "{plain}");
    let moved = measured.origin_for(&turned(30.0, Mm2::new(1.0, 0.0))).unwrap_err();
    assert!(matches!(moved, AlignmentFileError::Moved { .. }), "{moved}");
    let newer = file(2, 30.0, 0.01).unwrap_err();
    assert!(matches!(newer, AlignmentFileError::Version { found: 2, .. }), "{newer}");
    for (degrees, residual) in [(400.0, 0.01), (30.0, -0.01), (f64::NAN, 0.01), (30.0, f64::INFINITY)] {
        assert!(file(1, degrees, residual).is_err(), "{degrees} {residual}");
    }
}

// Evidence for SR-26.
#[test]
fn contradictory_or_too_few_probe_points_are_refused() {
    let (truth, part) = (Truth { degrees: -7.0, origin: Mm2::new(-200.0, -100.0) }, square());
    let refused = |points: Vec<ProbePoint>, edges: Vec<ProbePoint>| {
        align(&part, &probe_points(points, edges)).unwrap_err()
    };
    let point = |x, y| truth.point(Mm2 { x, y });
    assert_eq!(refused(vec![], vec![]), AlignmentError::TooFew);
    assert_eq!(refused(vec![], vec![truth.three_edges()[0]]), AlignmentError::TooFew);
    let mut far = point(90.0, 100.0);
    far.machine_mm.x += 0.2;
    let error = refused(vec![point(10.0, 20.0), far], vec![]);
    assert!(matches!(error, AlignmentError::Distance { first: 1, second: 2, .. }), "{error}");
    assert!(error.to_string().contains("steps per mm"), "{error}");
    let mut edges = truth.three_edges();
    edges.push(truth.probed(Mm2::new(10.0, 30.0), Mm2::new(-1.0, 0.0), Mm2::new(9.0, 35.0)));
    align(&part, &probe_points(vec![], edges.clone())).unwrap();
    edges[3].machine_mm.x -= 0.5;
    assert!(matches!(refused(vec![], edges), AlignmentError::Residual { .. }));
    let same = vec![point(10.0, 20.0), point(10.0, 20.0)];
    assert_eq!(refused(same, vec![]), AlignmentError::Undetermined);
    let near = vec![point(10.0, 20.0), point(11.0, 20.0)];
    let error = refused(near, vec![]);
    assert!(matches!(error, AlignmentError::Degenerate { .. }), "{error}");
    assert!(error.to_string().contains("probe points are 1.00 mm apart"), "{error}");
    let fair = align(&part, &probe_points(vec![point(10.0, 20.0), point(25.0, 20.0)], vec![])).unwrap();
    assert!(fair.poor, "{fair:?}");
}

#[test]
fn ambiguous_or_wrong_edge_points_are_refused() {
    let (truth, part) = (Truth { degrees: 12.0, origin: Mm2::new(50.0, -100.0) }, square());
    let refused = |edges: Vec<ProbePoint>| align(&part, &probe_points(vec![], edges)).unwrap_err();
    let [first, second, third] = truth.three_edges()[..] else { panic!() };
    let parallel = truth.probed(Mm2::new(40.0, 100.0), Mm2::new(0.0, 1.0), Mm2::new(40.0, 101.0));
    assert_eq!(refused(vec![first, second, parallel]), AlignmentError::Undetermined);
    let corner = ProbePoint { drawing_mm: Mm2::new(10.0, 20.0), ..third };
    let error = refused(vec![first, second, corner]);
    assert!(matches!(error, AlignmentError::WhichEdge { .. }), "{error}");
    let alike = ProbePoint { drawing_mm: first.drawing_mm, ..second };
    assert!(matches!(refused(vec![first, alike, third]), AlignmentError::WhichEnd { .. }));
    // The user confuses the two ends: the part would be turned by 180°, and the third point would lie beyond
    // the end of the left edge.
    let swapped = vec![
        ProbePoint { drawing_mm: second.drawing_mm, ..first },
        ProbePoint { drawing_mm: first.drawing_mm, ..second },
        third,
    ];
    assert!(matches!(refused(swapped), AlignmentError::BeyondEdge { .. }));
    let bare = ProbePoints { probe_diameter_mm: 0.0, ..probe_points(vec![], truth.three_edges()) };
    let error = align(&part, &bare).unwrap_err();
    assert!(error.to_string().contains("probe diameter"), "{error}");
}
