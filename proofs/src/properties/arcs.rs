//! Arcs, their chords, swept arcs and Bézier curves, in whole numbers. The checks visit every lattice point
//! of the ring that an arc stands for.

use keepout_kernel::exact::arc::{ArcChords, ArcError, RADIUS_MIN};
use keepout_kernel::exact::bezier::{Bezier, WEIGHTS};
use keepout_kernel::exact::ring::Piece;
use keepout_kernel::exact::segment::{Orientation, distance_2, orientation};
use keepout_kernel::exact::swept_arc::SweptArc;
use keepout_kernel::offset::{PATH_CHORD_ERROR, certify_path};
use keepout_kernel::{Arc, Curve, Length, Point, ProhibitedRegion, Region, Ring, Segment, Side, Turn};

use super::Xy;
use crate::draw::Draw;
use crate::families::{at, length};
use crate::oracle::{self, Big, Wide};
use crate::property::{passed_over, properties};

properties! {
    "arcs and curves", "kernel/src/exact/arc.rs, swept_arc.rs, bezier.rs";
    // Evidence for SR-02.
    arcs_are_believed_exactly_when_their_ends_fit |d| {
        let [from, to] = around(d);
        arcs_are_believed_exactly_when_their_ends_fit(from, to, d.coin())
    }
        => "an arc is accepted exactly when its ends differ, its radius is in range and its end lies \
            between ρ − 1 and ρ + 2 from the centre";
        random 200_000;
    chords_leave_their_arc_by_no_more_than_the_chord_error |d| {
        let [from, middle, to] = around(d);
        chords_leave_their_arc_by_no_more_than_the_chord_error(from, middle, to, d.coin())
    }
        => "chord-error bound of a chain: every point of the ring ρ − 1 … ρ + 2 between the rays to a \
            chord's ends is within the bound of the chord";
        random 600_000;
    chords_go_forward_and_are_short |d| {
        let [from, middle, to] = around(d);
        chords_go_forward_and_are_short(from, middle, to, d.coin())
    }
        => "a chain is accepted exactly when it begins and ends with the arc, and each chord ends on the \
            circle, leads forward and is no longer than ρ";
        random 200_000;
    what_is_clear_of_a_swept_arc_is_clear_of_its_ring |d| {
        let ([from, to], chord) = (around(d), [near(d), near(d)]);
        let far = chord.map(|p| square(p).isqrt()).into_iter().fold(0, i64::max);
        let t = if d.coin() { d.int(0, 200) } else { ((square(from).isqrt() - far).abs() + d.int(-6, 6)).max(0) };
        let centre = if d.coin() { (0, 0) } else { (d.int(-90_000, 90_000), d.int(-90_000, 90_000)) };
        what_is_clear_of_a_swept_arc_is_clear_of_its_ring(centre, [from, to], d.coin(), chord, t)
    }
        => "a chord that is reported clear of an arc is farther than t from every point of the arc's \
            ring; the arc's box holds these points";
        random 10_000;
    what_touches_a_piece_of_an_arc_is_near |d|
        what_touches_a_piece_of_an_arc_is_near(d.int(5, 8000), d.int(0, 8000), d.int(0, 1000), d.coin())
        => "a chord square to the ray through the middle of an arc's piece, at distance t from the arc, is near at t";
        random 20_000;
    weights_and_counts_are_checked |d|
        weights_and_counts_are_checked(d.int(0, 20), d.int(0, 20), (1 << d.int(0, 41)) + d.int(-1, 1))
        => "control points and weights make a curve exactly when there are 2 to 16 of each and the \
            weights are in range";
        random 20_000;
    what_follows_a_line_is_within_the_chord_error |d|
        what_follows_a_line_is_within_the_chord_error(
            [small(d), small(d), small(d)],
            [d.int(0, 16), d.int(0, 16), d.int(0, 16)],
            d.int(0, 60),
        )
        => "a quadratic curve that is reported to follow a line is within the chord-error bound of it at \
            sixteenths of its range, exactly";
        random 20_000;
    ring_edges_carry_both_chord_errors |d|
        ring_edges_carry_both_chord_errors(d.int(100, 100_000), d.int(0, 1000), d.int(0, 1000))
        => "the edges of an arc in a ring have the sum of two bounds: of the chords to the arc, and of the arc to \
            the true curve";
        random 5_000;
    certified_paths_keep_the_threshold_and_the_chord_error |d| {
        let threshold = d.int(0, 300);
        let away = threshold + PATH_CHORD_ERROR + d.int(-PATH_CHORD_ERROR - 3, 3);
        certified_paths_keep_the_threshold_and_the_chord_error(threshold, away.max(1))
    }
        => "a line beside a wall is certified exactly when it is farther than the threshold and the chord error of \
            paths together";
        random 20_000;
    chains_that_run_past_the_end_are_refused |d|
        chains_that_run_past_the_end_are_refused([small(d), small(d)], d.int(1, 60), d.int(2, 9))
        => "a chain that runs on beyond the end of its curve by more than the chord-error bound, and comes back, \
            is refused";
        random 20_000;
}

/// `N` points about the origin, mostly on one circle. Its radius is 64 to 86 units, the smallest radii of
/// arcs.
fn around<D: Draw, const N: usize>(d: &mut D) -> [Xy; N] {
    let r = RADIUS_MIN + d.int(0, 22);
    std::array::from_fn(|_| {
        let x = d.int(-r, r);
        let off = if d.one_of(3) == 0 { d.int(-2, 3) } else { 0 };
        let y = (r * r - x * x).max(0).isqrt() + off;
        let (x, y) = if d.coin() { (x, y) } else { (x, -y) };
        if d.coin() { (x, y) } else { (y, x) }
    })
}

fn near<D: Draw>(d: &mut D) -> Xy {
    let reach = [4, 60, 300][d.one_of(3)];
    (d.int(-reach, reach), d.int(-reach, reach))
}

fn small<D: Draw>(d: &mut D) -> Xy {
    (d.int(-100, 100), d.int(-100, 100))
}

fn turn(left: bool) -> Turn {
    if left { Turn::CounterClockwise } else { Turn::Clockwise }
}

fn square(p: Xy) -> i64 {
    p.0 * p.0 + p.1 * p.1
}

fn arcs_are_believed_exactly_when_their_ends_fit(from: Xy, to: Xy, left: bool) {
    let made = Arc::new(at(from), at(to), Point::ORIGIN, turn(left));
    let rho = square(from).isqrt();
    let fits = ((rho - 1).pow(2)..=(rho + 2).pow(2)).contains(&square(to));
    let truth = from != to && rho >= RADIUS_MIN && fits;
    assert_eq!(made.is_ok(), truth, "{from:?} {to:?} {made:?}");
    if let Ok(arc) = made {
        assert_eq!(i64::from(arc.radius().units()), rho);
        assert_eq!((arc.from(), arc.to(), arc.turn()), (at(from), at(to), turn(left)));
        let back = arc.reversed();
        let far = square(to).isqrt();
        let backward = ((far - 1).pow(2)..=(far + 2).pow(2)).contains(&square(from)) && far >= RADIUS_MIN;
        assert_eq!(back.is_ok(), backward, "{from:?} {to:?} reversed");
    }
}

/// Points of the ring from ρ − 1 to ρ + 2 between the rays to two points less than half a turn apart.
fn ring_between(rho: i64, a: Xy, b: Xy, left: bool) -> impl Iterator<Item = Xy> {
    let ahead = move |p: Xy, q: Xy| {
        let side = p.0 * q.1 - p.1 * q.0;
        if left { side >= 0 } else { side <= 0 }
    };
    let reach = rho + 2;
    (-reach..=reach).flat_map(move |x| {
        let outer = ((rho + 2).pow(2) - x * x).max(0).isqrt();
        let inner = ((rho - 1).pow(2) - x * x).max(0).isqrt();
        let band = (inner..=outer).chain((inner..=outer).map(|y| -y));
        band.map(move |y| (x, y)).filter(move |&p| {
            ((rho - 1).pow(2)..=(rho + 2).pow(2)).contains(&square(p)) && ahead(a, p) && ahead(p, b)
        })
    })
}

fn chords_leave_their_arc_by_no_more_than_the_chord_error(from: Xy, middle: Xy, to: Xy, left: bool) {
    let Ok(arc) = Arc::new(at(from), at(to), Point::ORIGIN, turn(left)) else { return passed_over() };
    let Ok(chords) = ArcChords::check(&arc, vec![at(from), at(middle), at(to)]) else { return passed_over() };
    let rho = i64::from(arc.radius().units());
    let chord_error = i64::from(chords.chord_error().units());
    // A coarse upper bound: the chord-error bound never exceeds ρ.
    assert!(chord_error <= rho, "{from:?} {middle:?} {to:?}");
    for (a, b) in [(from, middle), (middle, to)] {
        let chord = Segment { from: at(a), to: at(b) };
        for p in ring_between(rho, a, b, left) {
            assert!(
                !chord.near_point(at(p), chords.chord_error()).is_clear(),
                "{from:?} {middle:?} {to:?} {p:?} {chord_error}"
            );
        }
    }
}

fn chords_go_forward_and_are_short(from: Xy, middle: Xy, to: Xy, left: bool) {
    let Ok(arc) = Arc::new(at(from), at(to), Point::ORIGIN, turn(left)) else { return passed_over() };
    let rho = i64::from(arc.radius().units());
    let good = |a: Xy, b: Xy| {
        let on = ((rho - 2).pow(2)..=(rho + 3).pow(2)).contains(&square(b));
        let forward = if left { Orientation::Left } else { Orientation::Right };
        on && orientation(Point::ORIGIN, at(a), at(b)) == forward && distance_2(at(a), at(b)) <= rho * rho
    };
    let check = |points: Vec<Point>| ArcChords::check(&arc, points);
    let truth = good(from, middle) && good(middle, to);
    assert_eq!(check(vec![at(from), at(middle), at(to)]).is_ok(), truth, "{from:?} {middle:?} {to:?} {left}");
    assert_eq!(check(vec![at(from), at(to)]).is_ok(), good(from, to), "{from:?} {to:?} {left}");
    if middle != to {
        assert_eq!(check(vec![at(from), at(middle)]), Err(ArcError::Ends));
    }
    if middle != from {
        assert_eq!(check(vec![at(middle), at(to)]), Err(ArcError::Ends));
    }
    assert_eq!(check(vec![at(from)]), Err(ArcError::Ends));
}

/// All coordinates but the centre's are relative to the centre.
fn what_is_clear_of_a_swept_arc_is_clear_of_its_ring(
    centre: Xy,
    [from, to]: [Xy; 2],
    left: bool,
    chord: [Xy; 2],
    t: i64,
) {
    let at = |p: Xy| at((p.0 + centre.0, p.1 + centre.1));
    let Ok(arc) = Arc::new(at(from), at(to), at((0, 0)), turn(left)) else { return passed_over() };
    let Some(swept) = SweptArc::of(&arc) else { return passed_over() };
    let chord = Segment { from: at(chord[0]), to: at(chord[1]) };
    let clear = swept.near_chord(chord, length(t)).is_clear();
    let (rho, box_of) = (i64::from(arc.radius().units()), swept.bounds());
    // The arc is split into quarter turns from its beginning.
    let mut at_point = from;
    let ahead = |p: Xy, q: Xy| if left { p.0 * q.1 - p.1 * q.0 > 0 } else { p.0 * q.1 - p.1 * q.0 < 0 };
    for _ in 0..4 {
        let quarter = if left { (-at_point.1, at_point.0) } else { (at_point.1, -at_point.0) };
        let last = ahead(at_point, to) && (to == quarter || ahead(to, quarter));
        let end = if last { to } else { quarter };
        for p in ring_between(rho, at_point, end, left) {
            assert!(box_of.holds(at(p)), "{arc:?} {p:?} outside {box_of:?}");
            assert!(!clear || chord.near_point(at(p), length(t)).is_clear(), "{arc:?} {chord:?} {t}: {p:?}");
        }
        if last {
            return;
        }
        at_point = quarter;
    }
}

/// A quarter of the circle of radius 13 `k`, in two pieces of 45°. The point (12 k, 5 k) is on it, at 22.6°.
fn what_touches_a_piece_of_an_arc_is_near(k: i64, out: i64, half: i64, left: bool) {
    let ends = [(13 * k, 0), (0, 13 * k)];
    let [from, to] = if left { ends } else { [ends[1], ends[0]] };
    let arc = Arc::new(at(from), at(to), at((0, 0)), turn(left)).expect("a quarter of a circle");
    let Some(swept) = SweptArc::of(&arc) else { return passed_over() };
    let foot = (12 * (k + out), 5 * (k + out));
    let end = |sign: i64| at((foot.0 - sign * 5 * half, foot.1 + sign * 12 * half));
    let chord = Segment { from: end(1), to: end(-1) };
    assert!(!swept.near_chord(chord, length(13 * out)).is_clear(), "{k} {out} {half} {left}");
}

fn weights_and_counts_are_checked(points: i64, weights: i64, weight: i64) {
    let count = |n: i64| usize::try_from(n).unwrap_or(0);
    let weight = u64::try_from(weight).unwrap_or(0);
    let control = vec![Point::ORIGIN; count(points)];
    let made = Bezier::new(control, vec![weight; count(weights)]);
    let fits = (2..=16).contains(&points) && weights == points && (WEIGHTS.0..=WEIGHTS.1).contains(&weight);
    assert_eq!(made.is_ok(), fits, "{points} {weights} {weight}");
}

fn what_follows_a_line_is_within_the_chord_error(control: [Xy; 3], bits: [i64; 3], chord_error: i64) {
    let weights = bits.map(|bits| 1_u64 << (24 + bits));
    let Ok(curve) = Bezier::new(control.map(at).to_vec(), weights.to_vec()) else { return passed_over() };
    let line = Curve::Line(Segment { from: at(control[0]), to: at(control[2]) });
    let Ok(within) = Length::from_units(chord_error) else { return passed_over() };
    if curve.follows(&[line], within).is_err() {
        return passed_over();
    }
    for k in 0..=16_i64 {
        let bernstein = [(16 - k) * (16 - k), 2 * k * (16 - k), k * k];
        let mass: Vec<Wide> =
            bernstein.iter().zip(weights).map(|(&b, w)| Wide::from(b) * Wide::from(w)).collect();
        let all: Wide = mass.iter().sum();
        let sum =
            |of: fn(Xy) -> i64| mass.iter().zip(control).map(|(m, p)| m * Wide::from(of(p))).sum::<Wide>();
        // All coordinates are multiplied by the sum of weights, so that the curve's point is whole.
        let place = Big { x: sum(|p| p.0), y: sum(|p| p.1) };
        let end = |p: Xy| Big { x: &all * Wide::from(p.0), y: &all * Wide::from(p.1) };
        let reach = &all * Wide::from(chord_error);
        let (d, n) = oracle::point_segment_distance_2(&place, &end(control[0]), &end(control[2]));
        assert!(d <= &reach * &reach * n, "{control:?} {bits:?} {chord_error} at {k}/16");
    }
}

/// A straight curve from one point to the other. The chain's first line is `times` as long, and its second leads back
/// to the end.
fn chains_that_run_past_the_end_are_refused([from, to]: [Xy; 2], chord_error: i64, times: i64) {
    let Ok(curve) = Bezier::new(vec![at(from), at(to)], vec![WEIGHTS.0; 2]) else { return passed_over() };
    let past = (from.0 + (to.0 - from.0) * times, from.1 + (to.1 - from.1) * times);
    let line = |from: Xy, to: Xy| Curve::Line(Segment { from: at(from), to: at(to) });
    if distance_2(at(past), at(to)) <= chord_error * chord_error {
        return passed_over();
    }
    assert!(curve.follows(&[line(from, to)], length(chord_error)).is_ok(), "{from:?} {to:?} {chord_error}");
    let astray = curve.follows(&[line(from, past), line(past, to)], length(chord_error));
    assert!(astray.is_err(), "{from:?} {to:?} {chord_error}: past the end to {past:?}");
}

/// A half disc: an arc of half a turn, and its diameter.
fn ring_edges_carry_both_chord_errors(radius: i64, own: i64, bound: i64) {
    let (east, north, west) = (at((radius, 0)), at((0, radius)), at((-radius, 0)));
    let Ok(quarters) = [(east, north), (north, west)]
        .map(|(from, to)| {
            let arc = Arc::new(from, to, at((0, 0)), Turn::CounterClockwise).map_err(drop)?;
            let points = Curve::Arc(arc).chord_points(length(bound.max(10))).map_err(drop)?;
            ArcChords::check(&arc, points).map_err(drop)
        })
        .into_iter()
        .collect::<Result<Vec<ArcChords>, ()>>()
    else {
        return passed_over();
    };
    let arcs = quarters.iter().map(|chords| Piece::Arc { chords: chords.clone(), chord_error: length(own) });
    let diameter = Piece::Line { segment: Segment { from: west, to: east }, chord_error: Length::ZERO };
    let ring = Ring::from_pieces(&arcs.chain([diameter]).collect::<Vec<_>>()).expect("it is simple");
    let region = Region::new(vec![ring]).expect("one ring");
    let part = ProhibitedRegion::new(region, Side::Outside).expect("few edges");
    for edge in part.edges() {
        let of = |chords: &&ArcChords| chords.segments().any(|chord| chord == edge.chord);
        let expected =
            quarters.iter().find(of).map_or(0, |chords| i64::from(chords.chord_error().units()) + own);
        assert_eq!(i64::from(edge.chord_error.units()), expected, "{radius} {own} {bound}: {edge:?}");
    }
}

fn certified_paths_keep_the_threshold_and_the_chord_error(threshold: i64, away: i64) {
    let corners = [(0, 0), (9000, 0), (9000, 5000), (0, 5000)].map(at).to_vec();
    let region = Region::new(vec![Ring::new(corners).expect("a rectangle")]).expect("one ring");
    let part = ProhibitedRegion::new(region, Side::Outside).expect("few edges");
    let line = Curve::Line(Segment { from: at((3000, -away)), to: at((6000, -away)) });
    let certified = certify_path(&part, length(threshold), &[line]).is_ok();
    assert_eq!(certified, away > threshold + PATH_CHORD_ERROR, "{threshold} {away}");
}
