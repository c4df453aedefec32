//! Curves that are left out, and the check that they do not surround the part.
//!
//! Implements SR-27.
//!
//! A curve that is left out may be the part's own outline: it does not close, or it has a line type with gaps. Its
//! holes would then become the part, and its material would become air. So such a curve around the part is a
//! problem, unless the user states that it bounds no contour.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use thiserror::Error;

use crate::Mm2;
use crate::drawing::{EntityFilter, LeftOutCurve, LeftOutReason, OpenChain};
use crate::select::ContourPolygon;
use crate::units::point_mm;

/// Directions in which the check looks from the middle of a contour.
const DIRECTIONS: usize = 180;
/// Curves surround a contour if they are seen in at least this share of the directions.
const SURROUNDED: f64 = 0.6;
/// Largest number of contours that the check looks at, the largest first.
const CONTOURS_MAX: usize = 24;
/// Least distance within which an end lies on a contour, mm.
const ON_CONTOUR_MM: f64 = 0.02;

/// Curves that are left out surround or border the part.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum Surround {
    /// Curves with gapped line types, or on other layers.
    #[error("{}", surrounding(reason, *at, *count))]
    Around {
        /// Why the curves are left out.
        reason: LeftOutReason,
        /// A place on the curves.
        at: Mm2,
        /// Number of curves left out for this reason.
        count: usize,
    },
    /// An open chain begins and ends on a contour, so it may add to the part, or take from it.
    #[error(
        "an open curve that is left out begins and ends on a contour, at {from} and {to}: it may be a part of the \
         outline. Trim the contour in the CAD system so that the two form one, or delete the curve."
    )]
    Borders {
        /// Its first end.
        from: Mm2,
        /// Its last end.
        to: Mm2,
    },
}

impl Surround {
    /// A place of the curves.
    #[must_use]
    pub fn at(&self) -> Mm2 {
        match *self {
            Self::Around { at, .. } => at,
            Self::Borders { from, .. } => from,
        }
    }
}

fn surrounding(reason: &LeftOutReason, at: Mm2, count: usize) -> String {
    let (what, remedy) = match reason {
        LeftOutReason::LineType(name) => (
            format!("{count} curves with gaps (line type {name})"),
            format!(
                "Take them with --line-type {name}. If they are no contour, state that with --without-line-type \
                 {name}."
            ),
        ),
        LeftOutReason::Layer(name) => (
            format!("{count} curves on layer \"{name}\""),
            format!(
                "Take them with --layer \"{name}\". If they are no contour, such as a drawing frame, state that \
                 with --without-layer \"{name}\"."
            ),
        ),
        LeftOutReason::Hidden => (
            format!("{count} hidden curves"),
            "Show them in the CAD system if they belong to the part, or delete them.".into(),
        ),
        LeftOutReason::Open => (
            format!("{count} chains of open curves"),
            "Close them: `keepout inspect` lists the gaps. If they are no contour, put them on another layer and \
             leave that out with --without-layer."
                .into(),
        ),
    };
    format!(
        "{what} surround the contours that remain, one of them near {at}, and are left out. If they are the part's \
         outline, part and air would be swapped. {remedy}"
    )
}

/// The curves of open chains as curves that are left out.
#[must_use]
pub fn of_chains(open: &[OpenChain]) -> Vec<LeftOutCurve> {
    open.iter()
        .map(|chain| LeftOutCurve {
            points: crate::profile::corners(chain.curves.iter(), keepout_kernel::Length::small(250))
                .into_iter()
                .chain(chain.curves.last().map(keepout_kernel::Curve::to))
                .map(point_mm)
                .collect(),
            reason: LeftOutReason::Open,
        })
        .collect()
}

/// The curves that are left out and surround or border contours, which have these depths. A reason that the user
/// gave by name is none, and neither is a curve that the user hid.
#[must_use]
pub fn surrounds(
    outlines: &[ContourPolygon],
    depths: &[usize],
    left_out: &[LeftOutCurve],
    filter: &EntityFilter,
) -> Vec<Surround> {
    let mut outer: Vec<&ContourPolygon> =
        outlines.iter().zip(depths).filter(|(_, depth)| **depth == 0).map(|(outline, _)| outline).collect();
    outer.sort_by(|a, b| b.area_mm2.total_cmp(&a.area_mm2));
    outer.truncate(CONTOURS_MAX);
    let mut groups: BTreeMap<&LeftOutReason, Vec<&LeftOutCurve>> = BTreeMap::new();
    for curve in left_out.iter().filter(|curve| !is_stated(&curve.reason, filter)) {
        groups.entry(&curve.reason).or_default().push(curve);
    }
    let around = groups.iter().filter(|(_, curves)| outer.iter().any(|outline| is_around(outline, curves)));
    let mut found: Vec<Surround> = around
        .map(|(reason, curves)| Surround::Around {
            reason: (*reason).clone(),
            at: curves.first().and_then(|curve| curve.points.first()).copied().unwrap_or_default(),
            count: curves.len(),
        })
        .collect();
    if found.is_empty() {
        found.extend(groups.get(&LeftOutReason::Open).and_then(|chains| bordering(outlines, chains)));
    }
    found
}

/// Whether the user stated that curves left out for this reason bound no contour.
fn is_stated(reason: &LeftOutReason, filter: &EntityFilter) -> bool {
    match reason {
        LeftOutReason::Hidden => true,
        LeftOutReason::LineType(name) => {
            filter.without_line_types.iter().any(|stated| stated.eq_ignore_ascii_case(name))
        }
        LeftOutReason::Layer(name) => filter.leaves_out_layer(name),
        LeftOutReason::Open => false,
    }
}

/// Whether curves outside a contour are seen from its middle in most directions.
fn is_around(outline: &ContourPolygon, curves: &[&LeftOutCurve]) -> bool {
    let middle = outline.bounds.middle();
    let mut seen = [false; DIRECTIONS];
    for pair in curves.iter().flat_map(|curve| curve.points.windows(2)) {
        if !outline.holds(pair[0].midpoint(pair[1])) {
            mark(&mut seen, pair[0] - middle, pair[1] - middle);
        }
    }
    let count = seen.iter().filter(|seen| **seen).count();
    let enough = SURROUNDED * f64::from(u32::try_from(DIRECTIONS).unwrap_or(u32::MAX));
    f64::from(u32::try_from(count).unwrap_or(0)) >= enough
}

/// Marks the directions in which a segment is seen from the origin.
fn mark(seen: &mut [bool; DIRECTIONS], from: Mm2, to: Mm2) {
    let turn = from.cross(to).atan2(from.dot(to));
    let count = i32::try_from(DIRECTIONS).unwrap_or(i32::MAX);
    let direction = |angle: f64| (angle / TAU * f64::from(count)).floor();
    let (first, last) = (from.angle().min(from.angle() + turn), from.angle().max(from.angle() + turn));
    let mut k = direction(first);
    while k <= direction(last) {
        let index = keepout_kernel::curve::round_down(k).rem_euclid(i64::from(count));
        if let Some(seen) = usize::try_from(index).ok().and_then(|index| seen.get_mut(index)) {
            *seen = true;
        }
        k += 1.0;
    }
}

/// An open chain with both ends on contours.
fn bordering(outlines: &[ContourPolygon], chains: &[&LeftOutCurve]) -> Option<Surround> {
    let on_contour = |at: Mm2| {
        outlines.iter().filter(|outline| outline.bounds.grown(ON_CONTOUR_MM).holds(at)).any(|outline| {
            let closing = [outline.points.last(), outline.points.first()];
            at.distance_to_path(&outline.points) <= ON_CONTOUR_MM
                || matches!(closing, [Some(&a), Some(&b)] if at.distance(at.nearest_on(a, b)) <= ON_CONTOUR_MM)
        })
    };
    chains.iter().find_map(|chain| {
        let (&from, &to) = (chain.points.first()?, chain.points.last()?);
        let apart = from.distance(to) > ON_CONTOUR_MM;
        (apart && on_contour(from) && on_contour(to)).then_some(Surround::Borders { from, to })
    })
}
