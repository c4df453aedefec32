//! The reach of the tool: how much of each contour it cuts, and where it leaves rest material.

use keepout_kernel::curve::nearest_unit;
use keepout_kernel::index::{CheckedIndex, Edge, build};
use keepout_kernel::offset::Outline;
use keepout_kernel::{Curve, Length, Point, Segment, UNITS_PER_MM};
use rayon::prelude::*;

use crate::Mm2;
use crate::finish::FinishingLoop;
use crate::units::{along_mm, point_from_mm};

/// Rest material thinner than this does not count as a length of contour, mm. So the corners between the facets
/// of a curve do not count.
pub const THIN_MM: f64 = 0.01;
/// Distance between two places at which the search looks, mm. It finds the end of a stretch by bisection.
const STEP_MM: f64 = 0.5;
/// Least number of stretches of an edge.
const STRETCHES_MIN: f64 = 2.0;
/// Steps of a bisection.
const HALVINGS: usize = 12;
/// Chord-error bound of the toolpath's chords (0.2 µm).
const CHORD_ERROR: Length = Length::small(20);

/// Reach of the tool along a contour.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reach {
    /// Length of the contour, mm.
    pub length_mm: f64,
    /// Length beside which rest material stays, mm.
    pub left_mm: f64,
    /// Middle of the longest such stretch of an edge.
    pub left_at: Option<Mm2>,
}

impl Reach {
    /// Whether the tool cuts no part of the contour.
    #[must_use]
    pub fn is_none(&self) -> bool {
        self.left_mm >= self.length_mm
    }

    /// Whether the tool cuts the whole contour.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.left_mm <= 0.0
    }
}

/// The reach along each contour of the profile. The centre runs along `loops`, `d` lattice units from the profile.
#[must_use]
pub fn reaches(profile: &[Outline], loops: &[FinishingLoop], d: f64) -> Vec<Reach> {
    let curves = loops.iter().flat_map(|each| &each.curves);
    let chords = curves.flat_map(|curve| {
        let points = curve.chord_points(CHORD_ERROR).unwrap_or_else(|_| vec![curve.from(), curve.to()]);
        let pairs: Vec<Segment> =
            points.windows(2).map(|pair| Segment { from: pair[0], to: pair[1] }).collect();
        pairs
    });
    let edges = chords.map(|chord| Edge { chord, chord_error: Length::ZERO }).collect();
    let index = build::build(edges).ok();
    let within = nearest_unit(d + THIN_MM * f64::from(UNITS_PER_MM));
    let within = Length::from_units(within).unwrap_or(Length::ZERO);
    let reach = |outline| PathSearch { index: index.as_ref(), within, nearby: None }.reach(outline);
    profile.par_iter().map(reach).collect()
}

/// Search for the chords of the toolpath along one contour.
struct PathSearch<'a> {
    /// `None` for an empty toolpath.
    index: Option<&'a CheckedIndex>,
    /// Largest distance of the centre from a cut place of the profile.
    within: Length,
    /// The chord that the last search found.
    nearby: Option<Edge>,
}

impl PathSearch<'_> {
    fn reach(&mut self, outline: &Outline) -> Reach {
        let mut reach = Reach::default();
        let mut longest = 0.0;
        for curve in &outline.curves {
            let length_mm = curve.length() / f64::from(UNITS_PER_MM);
            let left = self.left(curve, length_mm);
            reach.length_mm += length_mm;
            for (from, to) in left {
                let stretch_mm = (to - from) * length_mm;
                reach.left_mm += stretch_mm;
                if stretch_mm > longest {
                    longest = stretch_mm;
                    reach.left_at = Some(along_mm(curve, f64::midpoint(from, to)).0);
                }
            }
        }
        // The sums of the shares may differ in the last digit.
        reach.left_mm = reach.left_mm.min(reach.length_mm);
        if reach.length_mm - reach.left_mm < 1e-9 * reach.length_mm {
            reach.left_mm = reach.length_mm;
        }
        reach
    }

    /// The stretches of a curve that stay uncut, as shares of its length.
    fn left(&mut self, curve: &Curve, length_mm: f64) -> Vec<(f64, f64)> {
        let count = (length_mm / STEP_MM).ceil().max(STRETCHES_MIN);
        let mut stretches: Vec<(f64, f64)> = Vec::new();
        let mut k = 0.0;
        let (mut before, mut begin) = (self.is_cut(curve, 0.0), 0.0);
        while k < count {
            let (from, to) = (k / count, (k + 1.0) / count);
            let here = self.is_cut(curve, to);
            if before != here {
                let turn = self.turn(curve, (from, to), before);
                if before {
                    begin = turn;
                } else {
                    stretches.push((begin, turn));
                }
            }
            before = here;
            k += 1.0;
        }
        if !before {
            stretches.push((begin, 1.0));
        }
        stretches
    }

    /// The share between two at which the reach changes. `before`: whether the first is cut.
    fn turn(&mut self, curve: &Curve, (mut from, mut to): (f64, f64), before: bool) -> f64 {
        for _ in 0..HALVINGS {
            let middle = f64::midpoint(from, to);
            if self.is_cut(curve, middle) == before { from = middle } else { to = middle }
        }
        f64::midpoint(from, to)
    }

    fn is_cut(&mut self, curve: &Curve, share: f64) -> bool {
        let at = point_from_mm(along_mm(curve, share).0).unwrap_or(Point::ORIGIN);
        let is_near = |edge: &Edge| !edge.near_point(at, self.within).is_clear();
        let found = || self.index?.near_point(at, self.within).copied();
        self.nearby = self.nearby.filter(is_near).or_else(found);
        self.nearby.is_some()
    }
}
