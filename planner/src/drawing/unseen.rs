//! Remarks about properties of entities that the view from above does not show.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::entity::{Entity, Shape, Vec3};
use super::placement::{Placement, unit};
use crate::contour::short;

/// Smallest rise that counts as a slope, mm.
const RISE_MM: f64 = 1e-3;
/// Smallest horizontal component of a unit normal that counts as a tilt.
const TILT: f64 = 1e-6;

/// Counts of the entities that are taken in a way that the drafter may not expect.
#[derive(Debug, Default)]
pub struct Unseen {
    /// Number of polylines with a width, and the largest width, mm.
    wide: (usize, f64),
    /// Number of sloped lines and curves, and the largest rise, mm.
    sloped: (usize, f64),
    /// Number of entities in a tilted plane.
    tilted: usize,
    /// Number of curves on each layer that is not plotted.
    unplotted: BTreeMap<Arc<str>, usize>,
}

impl Unseen {
    /// Looks at an entity of which `curves` curves are taken, and its layer if that is not plotted.
    pub fn look(
        &mut self,
        entity: &Entity,
        placement: &Placement,
        (curves, unplotted): (usize, Option<&Arc<str>>),
    ) {
        if curves == 0 {
            return;
        }
        if let Some(layer) = unplotted {
            *self.unplotted.entry(layer.clone()).or_default() += curves;
        }
        let normal = entity.normal;
        match &entity.shape {
            Shape::Line { from, to } => self.slope(placement, [*from, *to].into_iter()),
            Shape::Spline(spline) => {
                self.slope(placement, spline.control.iter().chain(&spline.fit).copied());
            }
            Shape::Polyline(line) => {
                if line.width > 0.0 {
                    let width = placement.vector([line.width, 0.0, 0.0]);
                    let width_mm = width[0].hypot(width[1]).hypot(width[2]);
                    self.wide = (self.wide.0 + 1, self.wide.1.max(width_mm));
                }
                if line.planar {
                    self.tilt(placement, normal);
                } else {
                    self.slope(placement, line.vertices.iter().map(|(at, _)| *at));
                }
            }
            Shape::Arc { .. } | Shape::Ellipse(_) | Shape::Hatch(_) | Shape::Solid(_) => {
                self.tilt(placement, normal);
            }
            Shape::Insert(_) | Shape::Other(_) => {}
        }
    }

    fn slope(&mut self, placement: &Placement, points: impl Iterator<Item = Vec3>) {
        let heights = points.map(|point| placement.point(point)[2]);
        let (low, high) =
            heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), z| (low.min(z), high.max(z)));
        if high - low > RISE_MM {
            self.sloped = (self.sloped.0 + 1, self.sloped.1.max(high - low));
        }
    }

    fn tilt(&mut self, placement: &Placement, normal: Vec3) {
        let normal = unit(placement.in_plane(normal).vector([0.0, 0.0, 1.0]));
        if normal.is_some_and(|[x, y, _]| x.hypot(y) > TILT) {
            self.tilted += 1;
        }
    }

    /// The remarks for the user.
    #[must_use]
    pub fn remarks(&self) -> Vec<String> {
        let mut remarks = Vec::new();
        if let (count @ 1.., width_mm) = self.wide {
            remarks.push(format!(
                "polylines with a width: {count}, up to {} mm wide. The contour is the line in their middle, without \
                 the width",
                short(width_mm)
            ));
        }
        if let (count @ 1.., rise_mm) = self.sloped {
            remarks.push(format!(
                "sloped lines or curves: {count}, by up to {} mm in height. The contour is their view from above",
                short(rise_mm)
            ));
        }
        if self.tilted > 0 {
            remarks.push(format!(
                "circles, arcs or polylines in tilted planes: {}. The contour is their view from above, such as an \
                 ellipse for a circle",
                self.tilted
            ));
        }
        remarks.extend(self.unplotted.iter().map(|(layer, count)| {
            format!(
                "layer \"{layer}\" is not plotted, but its curves ({count}) are taken. --without-layer \"{layer}\" \
                 leaves them out"
            )
        }));
        remarks
    }
}
