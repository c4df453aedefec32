//! The nesting of contours: which contour lies in which other.

use std::ops::ControlFlow;

use keepout_kernel::exact::segment::Window;
use keepout_kernel::index::{Edge, build};
use keepout_kernel::{Length, Point, Segment};

use crate::Mm2;
use crate::select::ContourPolygon;
use crate::units::point_from_mm;

/// Nesting of contours that do not cross.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Nesting {
    /// For each contour, the smallest contour around it.
    pub parents: Vec<Option<usize>>,
    /// For each contour, the number of contours around it.
    pub depths: Vec<usize>,
}

impl Nesting {
    /// The nesting of the first corners.
    #[must_use]
    pub fn of(outlines: &[ContourPolygon]) -> Self {
        // An index of the diagonals of the boxes leaves few outlines to test for each corner.
        let point = |p: Mm2| point_from_mm(p).unwrap_or(Point::ORIGIN);
        let diagonal = |outline: &ContourPolygon| Segment {
            from: point(outline.bounds.low),
            to: point(outline.bounds.high),
        };
        let edge =
            |outline: &ContourPolygon| Edge { chord: diagonal(outline), chord_error: Length::small(2) };
        let index = build::build(outlines.iter().map(edge).collect()).ok();
        let mut nesting = Self::default();
        for (i, outline) in outlines.iter().enumerate() {
            let (mut depth, mut parent) = (0, None);
            if let (Some(index), Some(&corner)) = (&index, outline.points.first()) {
                let _ = index.visit(Window::of(point(corner)), |j, _| {
                    if j != i && outlines[j].holds(corner) {
                        depth += 1;
                        let smaller = |&up: &usize| outlines[up].area_mm2 <= outlines[j].area_mm2;
                        parent = parent.filter(smaller).or(Some(j));
                    }
                    ControlFlow::<()>::Continue(())
                });
            }
            nesting.depths.push(depth);
            nesting.parents.push(parent);
        }
        nesting
    }
}
