//! Joins curves end to end into closed loops on the lattice, and lists the repairs and the problems.

use std::collections::HashSet;
use std::f64::consts::TAU;

use keepout_kernel::curve::half_circle_parts;
use keepout_kernel::exact::bezier::Bezier;
use keepout_kernel::{ArcView, Curve, Point, Turn, UNITS_PER_MM, Vec2, Vector};

use super::fit::{BezierFault, on_lattice};
use super::follow::{BOUNDS, follow};
use super::join::{Joiner, distance_mm};
use super::placement::elliptic_beziers;
use super::{
    Drawing, DrawingError, Origin, Problem, RawBezier, RawCurve, Repair, doubled, overlap, repeated, untangle,
};
use crate::profile::Profile;
use crate::units::{length_up_from_mm, point_from_mm};

/// Default of the joining tolerance: the largest gap that is closed, mm.
pub const JOIN_MM: f64 = 0.01;

/// Largest radius of an arc, mm. A larger arc becomes Bézier curves, because its centre would leave the
/// lattice.
const RADIUS_MAX_MM: f64 = 2000.0;

/// A chain of curves that does not close.
#[derive(Clone, Debug, PartialEq)]
pub struct OpenChain {
    /// The curves.
    pub curves: Vec<Curve>,
    /// The entity of the first curve.
    pub origin: Origin,
}

/// The closed loops of a drawing, with the repairs and the remaining problems.
#[derive(Clone, Debug, Default)]
pub struct Chained {
    /// The loops.
    pub profile: Profile,
    /// The layer of each loop's first curve.
    pub layers: Vec<std::sync::Arc<str>>,
    /// The repairs, in no particular order.
    pub repairs: Vec<Repair>,
    /// The problems.
    pub problems: Vec<Problem>,
    /// The chains that stay open.
    pub open: Vec<OpenChain>,
    /// The joining tolerance that closes all gaps, if all problems are gaps.
    pub gaps: Option<Gaps>,
}

/// Gaps that one joining tolerance closes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gaps {
    /// Number of loose ends.
    pub ends: usize,
    /// The largest gap, mm.
    pub largest_mm: f64,
    /// A joining tolerance that closes all of them without another problem, mm.
    pub join_mm: f64,
}

impl std::fmt::Display for Gaps {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { ends, largest_mm, join_mm } = self;
        write!(
            f,
            "All {ends} loose ends have another within {largest_mm:.3} mm: --join-mm {join_mm} closes all gaps."
        )
    }
}

/// Largest gap for which the program proposes a joining tolerance, mm.
const PROPOSED_MAX_MM: f64 = 2.0;

impl Chained {
    /// Returns the loops if there is no problem.
    ///
    /// # Errors
    /// [`DrawingError::Problems`] with all problems.
    pub fn closed(self) -> Result<Self, DrawingError> {
        if self.problems.is_empty() {
            Ok(self)
        } else {
            Err(DrawingError::Problems { problems: self.problems, gaps: self.gaps })
        }
    }
}

/// A curve between two lattice points. Repairs may still move its ends.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    pub from: Point,
    pub to: Point,
    pub bend: Bend,
    /// The entity it comes from.
    pub origin: u32,
    /// Whether that entity is a closed contour by itself.
    pub whole: bool,
    /// The ends that its start and its end are joined to.
    pub joined: [Option<End>; 2],
}

#[derive(Clone, Debug)]
pub(super) enum Bend {
    Straight,
    /// An arc of at most half a turn: its centre in lattice units, its direction of turn, and the vector from
    /// its start to its end as drawn.
    Round(Vec2, Turn, Vector),
    Free(Box<Bezier>),
}

/// An end of a piece: the index of the piece, and 0 for its start or 1 for its end.
pub(super) type End = (usize, usize);

impl Piece {
    pub fn end(&self, which: usize) -> Point {
        if which == 0 { self.from } else { self.to }
    }

    pub fn length_mm(&self) -> f64 {
        let chord = distance_mm(self.from, self.to);
        match &self.bend {
            Bend::Straight => chord,
            Bend::Round(centre, turn, _) => {
                let arc = ArcView::between(Vec2::from(self.from), Vec2::from(self.to), *centre, *turn);
                // A repair may have joined both ends. Such an arc has no length.
                arc.radius / f64::from(UNITS_PER_MM) * arc.angle_to(Vec2::from(self.to))
            }
            Bend::Free(curve) => curve.control().windows(2).map(|pair| distance_mm(pair[0], pair[1])).sum(),
        }
    }
}

/// Joins the drawing's curves into closed loops.
///
/// Ends up to `join_mm` apart are moved together. Each gap above rounding (0.1 µm) is listed as a repair.
/// Lines and arcs within `curve_mm` replace splines and ellipses.
///
/// # Errors
/// [`DrawingError::OffLattice`] and [`DrawingError::BadEntity`] with the entity;
/// [`DrawingError::CurveBound`].
pub fn chain(drawing: &Drawing, join_mm: f64, curve_mm: f64) -> Result<Chained, DrawingError> {
    let chained = chain_within(drawing, join_mm, curve_mm)?;
    let gaps = gaps(drawing, &chained.problems, curve_mm);
    Ok(Chained { gaps, ..chained })
}

/// The joining tolerance that closes all gaps, if there is one.
fn gaps(drawing: &Drawing, problems: &[Problem], curve_mm: f64) -> Option<Gaps> {
    let gap_mm = |problem: &Problem| match problem {
        Problem::Open { gap_mm, .. } => *gap_mm,
        Problem::Tee { .. } | Problem::Branch { .. } => None,
    };
    let all: Option<Vec<f64>> = problems.iter().map(gap_mm).collect();
    let largest_mm = all?.into_iter().reduce(f64::max).filter(|largest| *largest <= PROPOSED_MAX_MM)?;
    let digit = 10_f64.powf((largest_mm * 1.02).log10().floor() - 1.0);
    // A decimal such as 0.11 has no exact binary fraction, so its text gives it.
    let join_mm = format!("{:.6}", (largest_mm * 1.02 / digit).ceil() * digit).parse().ok()?;
    let closed = chain_within(drawing, join_mm, curve_mm).is_ok_and(|chained| chained.problems.is_empty());
    closed.then_some(Gaps { ends: problems.len(), largest_mm, join_mm })
}

fn chain_within(drawing: &Drawing, join_mm: f64, curve_mm: f64) -> Result<Chained, DrawingError> {
    let bound = length_up_from_mm(curve_mm).ok().filter(|bound| BOUNDS.contains(bound));
    let bound = bound.ok_or(DrawingError::CurveBound { curve_mm })?;
    let mut chained = Chained::default();
    let mut pieces = Vec::with_capacity(drawing.curves.len());
    let mut zero: Option<(Point, usize)> = None;
    for polyline in &drawing.runs {
        let first = pieces.len();
        for curve in &drawing.curves[polyline.first..polyline.end] {
            lattice_pieces(curve, polyline.origin, drawing, &mut pieces, &mut zero)?;
        }
        let last = pieces.len().saturating_sub(1);
        for i in first..last {
            pieces[i].joined[1] = Some((i + 1, 0));
            pieces[i + 1].joined[0] = Some((i, 1));
        }
        if polyline.closed && first < pieces.len() && pieces[first].from == pieces[last].to {
            pieces[first].joined[0] = Some((last, 1));
            pieces[last].joined[1] = Some((first, 0));
            pieces[first..].iter_mut().for_each(|piece| piece.whole = true);
        }
    }
    if let Some((at, count)) = zero {
        chained.repairs.push(Repair::ZeroLength { at, count });
    }
    repeated::drop_duplicates(&mut pieces, &mut chained.repairs);
    let mut joiner = Joiner::new(pieces, join_mm);
    joiner.drop_specks(&mut chained.repairs);
    joiner.coincident();
    overlap::merge(&mut joiner, &mut chained.repairs);
    joiner.close_gaps(&mut chained.repairs);
    joiner.drop_tiny(&mut chained.repairs);
    joiner.problems(&drawing.origins, &mut chained.problems);
    follow(&joiner, bound, &drawing.origins, &mut chained)?;
    untangle::untangle(&mut chained, join_mm);
    doubled::drop_contours(&mut chained, join_mm);
    doubled::drop_chains(&mut chained, join_mm);
    Ok(chained)
}

fn lattice_pieces(
    curve: &RawCurve,
    origin: u32,
    drawing: &Drawing,
    pieces: &mut Vec<Piece>,
    zero: &mut Option<(Point, usize)>,
) -> Result<(), DrawingError> {
    let named = || Box::new(drawing.origins[origin as usize].clone());
    let off = |source| DrawingError::OffLattice { origin: named(), source, bounds: drawing.bounds() };
    let on_lattice_point = |p| point_from_mm(p).map_err(off);
    let free_bend = |raw: &RawBezier| {
        on_lattice(raw).map(|curve| Bend::Free(Box::new(curve))).map_err(|fault| match fault {
            BezierFault::OffLattice(source) => off(source),
            BezierFault::Uneven => DrawingError::BadEntity {
                origin: named(),
                problem: "its weights differ by more than a factor of 2^16",
            },
        })
    };
    let mut push = |from: Point, to: Point, bend: Bend| {
        let turns_back = matches!(&bend, Bend::Free(curve) if curve.control().iter().any(|&p| p != from));
        if from != to || turns_back {
            pieces.push(Piece { from, to, bend, origin, whole: false, joined: [None; 2] });
        } else {
            zero.get_or_insert((from, 0)).1 += 1;
        }
    };
    match curve {
        RawCurve::Line { from, to } => push(on_lattice_point(*from)?, on_lattice_point(*to)?, Bend::Straight),
        &RawCurve::Arc { arc, from, to } => {
            if arc.radius > RADIUS_MAX_MM || point_from_mm(arc.centre.into()).is_err() {
                let mut flat = Vec::new();
                let at = |angle| arc.at_angle(angle).into();
                elliptic_beziers(&at, arc.centre.into(), (arc.start, arc.sweep), TAU / 8.0, &mut flat);
                flat.first_mut().into_iter().for_each(|first| first.set_from(from));
                flat.last_mut().into_iter().for_each(|last| last.set_to(to));
                return flat
                    .iter()
                    .try_for_each(|piece| lattice_pieces(piece, origin, drawing, pieces, zero));
            }
            let count = half_circle_parts(arc.sweep.abs());
            let scale = f64::from(UNITS_PER_MM);
            let centre = arc.centre * scale;
            let mut begin = from;
            for k in 1..=count {
                let end = if k == count { to } else { arc.at(f64::from(k) / f64::from(count)).into() };
                let (a, b) = (on_lattice_point(begin)?, on_lattice_point(end)?);
                push(a, b, Bend::Round(centre, arc.turn(), b.minus(a)));
                begin = end;
            }
        }
        RawCurve::Bezier(raw) => {
            let bend = free_bend(raw)?;
            push(on_lattice_point(curve.from())?, on_lattice_point(curve.to())?, bend);
        }
    }
    Ok(())
}

/// Removes pieces. The ends that were joined to them become loose.
pub(super) fn remove(pieces: &mut Vec<Piece>, gone: &HashSet<usize>) {
    let mut number = vec![usize::MAX; pieces.len()];
    let mut next = 0;
    for (i, number) in number.iter_mut().enumerate() {
        if !gone.contains(&i) {
            *number = next;
            next += 1;
        }
    }
    let mut index = 0;
    pieces.retain_mut(|piece| {
        let stays = number[index] != usize::MAX;
        index += 1;
        for joint in &mut piece.joined {
            *joint = joint
                .and_then(|(other, which)| Some((number[other], which)).filter(|(n, _)| *n != usize::MAX));
        }
        stays
    });
}
