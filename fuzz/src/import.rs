//! Import of drawings from bytes.

use keepout_kernel::{Curve, Length, Point};
use keepout_planner::Mm2;
use keepout_planner::drawing::{Chained, Drawing, DrawingError, EntityFilter, census, import};
use keepout_planner::finish::PathRefusal::{Elsewhere, WrongSpace, WrongWay};
use keepout_planner::machine::MachineProfile;
use keepout_planner::plan::PlanError;
use keepout_planner::plan_file;
use keepout_planner::profile::{MachinedSide, Profile, ProfileEdge, ProfileError, ProfileLoop};
use keepout_planner::request::{PlanRequest, PlanRequestError};

use crate::{export, oracle, small};

/// Drawings with more curves than this are imported and not planned. This saves time for other inputs.
pub(crate) const CURVES_MAX: usize = 400;
/// Largest distance of an arc's centre from its place before writing and reading, lattice units. Each step
/// puts it on the lattice.
const CENTRE_MAX: i64 = 4;

/// Reads any bytes as a drawing. The result is a typed error, or contours that are valid or reported as
/// invalid. Valid contours come back from a drawing made of them. A plan over them holds its certificates,
/// also after storage, and by an independent check.
///
/// # Panics
/// When one of these does not hold.
pub fn dxf_import(bytes: &[u8]) {
    check_request(bytes, &PlanRequest::default());
    if bytes.len() < TWO_REQUESTS_BELOW {
        check_request(bytes, &particular(bytes));
        // A drawing that cannot be read cannot be counted, either.
        let read = !matches!(import(bytes, &EntityFilter::default()), Err(DrawingError::Damaged(_)));
        assert_eq!(census(bytes).is_ok(), read, "counted and not read, or the other way");
    }
}

/// Longer drawings get one plan request only.
const TWO_REQUESTS_BELOW: usize = 4_000;

/// A plan request with many options.
fn particular(bytes: &[u8]) -> PlanRequest {
    // A requested layer must be in the drawing.
    let has =
        |layer: &&str| bytes.windows(layer.len() + 2).any(|part| part == format!("8\n{layer}").as_bytes());
    let choice = EntityFilter {
        layers: Vec::new(),
        without: Some("WITHOUT").filter(has).map(Into::into).into_iter().collect(),
        unit: Some("in".into()),
        line_types: vec!["DASHED".into()],
        hatches: true,
        solids: true,
        placed: Some((12.5, Mm2::new(30.0, -20.0))),
        ..EntityFilter::default()
    };
    let keep_out_layers = Some("CLAMPS").filter(has).map(Into::into).into_iter().collect();
    let travel_layer = Some("TABLE").filter(has).map(Into::into);
    PlanRequest { choice, keep_out_layers, travel_layer, ..PlanRequest::default() }
}

/// Runs [`dxf_import`] with a plan request. Returns the part and the zones, if the importer read them and
/// they are not too large.
///
/// # Panics
/// As [`dxf_import`].
pub fn check_request(bytes: &[u8], request: &PlanRequest) -> Option<(Chained, Chained)> {
    let (drawing, chained) = match request.contours(bytes) {
        Ok(read) => read,
        Err(error) => {
            check_message(&error.to_string());
            return None;
        }
    };
    let zones = zones(bytes, request)?;
    if drawing.curves.len().max(edges(&chained.profile)).max(edges(&zones.profile)) > CURVES_MAX {
        return None;
    }
    tells_all(&drawing, &chained);
    for read in [&chained, &zones] {
        is_valid(read, request);
    }
    plans(bytes, request);
    Some((chained, zones))
}

/// Checks that contours bound a part and come back, or that the errors are named. Edges that stand for a
/// curve always follow it.
fn is_valid(read: &Chained, request: &PlanRequest) {
    match read.profile.part(MachinedSide::Outside, &Profile::default()) {
        Ok(_) if read.problems.is_empty() => comes_back(&read.profile, request),
        Ok(_) => {}
        Err(error) => {
            assert!(!matches!(error, ProfileError::Curve { .. }), "{error}");
            check_message(&error.to_string());
        }
    }
}

/// The contours on the keep-out layers; empty without such layers.
fn zones(bytes: &[u8], request: &PlanRequest) -> Option<Chained> {
    if request.keep_out_layers.is_empty() {
        return Some(Chained::default());
    }
    let choice = EntityFilter { layers: request.keep_out_layers.clone(), ..request.choice.clone() };
    let zones = PlanRequest {
        choice,
        join_mm: request.join_mm,
        curve_mm: request.curve_mm,
        ..PlanRequest::default()
    };
    zones.contours(bytes).ok().map(|(_, zones)| zones)
}

/// The number of edges.
pub(crate) fn edges(profile: &Profile) -> usize {
    profile.loops.iter().map(|each| each.edges.len()).sum()
}

/// Checks that a message for a person is neither empty nor too long.
pub(crate) fn check_message(message: &str) {
    assert!(!message.is_empty() && message.len() < 4000, "{} bytes: {message:.200}", message.len());
}

fn tells_all(drawing: &Drawing, chained: &Chained) {
    chained.repairs.iter().for_each(|repair| check_message(&repair.to_string()));
    chained.problems.iter().for_each(|problem| check_message(&problem.to_string()));
    let inspection = keepout_planner::inspect::inspect(drawing, chained, &EntityFilter::default());
    assert_eq!(inspection.contours.len(), chained.profile.loops.len());
}

/// Readers drop an isolated entity no longer than rounding (10 units), and join ends that near.
const ROUNDING: f64 = 12.0;

/// Whether a reader can distinguish the profile's entities. Ends of different ones are equal or farther
/// apart than rounding, and no entity is shorter. Closed polylines can always be distinguished.
fn is_distinguishable(profile: &Profile) -> bool {
    let mixed = || profile.loops.iter().filter(|each| !each.sources.is_empty());
    let runs = mixed().flat_map(export::runs);
    let of_sources =
        |each: &ProfileLoop| each.sources.iter().map(|source| source.first..source.end).collect::<Vec<_>>();
    let sources = mixed().flat_map(|each| of_sources(each).into_iter().map(|range| &each.edges[range]));
    let entities: Vec<&[ProfileEdge]> = runs.chain(sources).filter(|entity| !entity.is_empty()).collect();
    let length = |entity: &&[ProfileEdge]| entity.iter().map(|edge| edge.curve.length()).sum::<f64>();
    let ends: Vec<Point> = entities
        .iter()
        .flat_map(|entity| [entity[0].curve.from(), entity[entity.len() - 1].curve.to()])
        .collect();
    let apart = |(k, one): (usize, &Point)| {
        ends[k + 1..].iter().all(|other| {
            let d = one.minus(*other);
            one == other || f64::from(d.dx).hypot(f64::from(d.dy)) > ROUNDING
        })
    };
    entities.iter().all(|entity| length(entity) > ROUNDING) && ends.iter().enumerate().all(apart)
}

fn comes_back(profile: &Profile, request: &PlanRequest) {
    if !is_distinguishable(profile) {
        return;
    }
    let text = export::dxf(profile);
    let again = PlanRequest { join_mm: 0.0, curve_mm: request.curve_mm, ..PlanRequest::default() };
    let (_, chained) = again.contours(text.as_bytes()).unwrap_or_else(|error| panic!("{error}\n{text}"));
    let (found, problems) = (&chained.profile, &chained.problems);
    assert!(problems.is_empty(), "{problems:?}\n{text}");
    assert_eq!(found.loops.len(), profile.loops.len(), "contours\n{text}");
    for (found, given) in found.loops.iter().zip(&profile.loops) {
        let same = same_loop(found, given);
        assert!(same, "{given:?}\nbecame\n{found:?}\nby\n{text}");
    }
}

/// Whether two loops are the same except for rounded centres. An arc of half a circle may have become two
/// arcs. An arc that is flatter than the lattice may have become a line.
fn same_loop(found: &ProfileLoop, given: &ProfileLoop) -> bool {
    let mut curves: Vec<_> = found.sources.iter().map(|source| &source.curve).collect();
    let same_sources = given.sources.iter().all(|source| {
        let place = curves.iter().position(|curve| **curve == source.curve);
        place.map(|place| curves.swap_remove(place)).is_some()
    });
    same_sources && curves.is_empty() && (0..found.edges.len()).any(|first| same_from(found, first, given))
}

/// Whether the edges are the same when reading of the found loop begins at `first`.
fn same_from(found: &ProfileLoop, first: usize, given: &ProfileLoop) -> bool {
    let mut left = found.edges.iter().cycle().skip(first).take(found.edges.len()).peekable();
    let same = given.edges.iter().all(|edge| {
        let Some(one) = left.next() else { return false };
        let begins = one.curve.from() == edge.curve.from()
            && one.chord_error == edge.chord_error
            && alike(&one.curve, &edge.curve);
        let ends = one.curve.to() == edge.curve.to();
        let second = left
            .next_if(|next| !ends && next.curve.to() == edge.curve.to() && alike(&next.curve, &edge.curve));
        begins && (ends || second.is_some())
    });
    same && left.next().is_none()
}

fn alike(found: &Curve, given: &Curve) -> bool {
    match (found, given) {
        (Curve::Line(_), Curve::Line(_)) => true,
        (Curve::Arc(one), Curve::Arc(other)) => {
            one.turn() == other.turn() && near(one.centre(), other.centre())
        }
        (Curve::Line(_), Curve::Arc(arc)) => {
            let (chord, radius) = (arc.from().minus(arc.to()), f64::from(arc.radius().units()));
            let half = f64::from(chord.dx).hypot(f64::from(chord.dy)) / 2.0;
            half * half / (2.0 * radius) < 2.0
        }
        (Curve::Arc(_), Curve::Line(_)) => false,
    }
}

fn near(one: Point, other: Point) -> bool {
    let apart = one.minus(other);
    i64::from(apart.dx).abs().max(i64::from(apart.dy).abs()) <= CENTRE_MAX
}

/// Whether a proposed path is in a wrong place. It may come too near or leave something out, which is a
/// reported limit. It must never be elsewhere.
fn is_misplaced(error: &PlanRequestError) -> bool {
    let PlanRequestError::Plan(PlanError::Pass { refusal, .. }) = error else { return false };
    matches!(refusal, Elsewhere { .. } | WrongWay { .. } | WrongSpace { .. })
}

fn plans(bytes: &[u8], request: &PlanRequest) {
    let certified = match request.plan("fuzz", bytes, &MachineProfile::simulated(), &mut |_| {}) {
        Ok(certified) => certified,
        Err(error) => {
            assert!(!is_misplaced(&error), "what was proposed is refused: {error}");
            return check_message(&error.to_string());
        }
    };
    oracle::watch(&certified, Some(&request.job));
    small::adds_up(&certified.plan.machine, &certified.plan.budget, request.job.margin_mm);
    let stored = plan_file::encode(&certified.plan).expect("a plan in memory can be written");
    let again = plan_file::decode(&stored).expect("what was written can be read");
    assert_eq!(again, certified.plan, "the plan changed in its file");
    let again = again.certify().expect("what was certified is certified again");
    assert_eq!(again.certified_motions, certified.certified_motions);
    assert!(again.roughing >= again.finishing && again.finishing > Length::ZERO);
}
