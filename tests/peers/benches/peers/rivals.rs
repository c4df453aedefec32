//! The peers. Each is built as its documentation recommends, and answers the same queries, in `f64`
//! millimetres unless stated.

use bvh::aabb::{Aabb, Bounded};
use bvh::bounding_hierarchy::BHShape;
use bvh::bvh::Bvh;
use bvh::point_query::PointDistance;
use geo::{Distance, Euclidean};
use nalgebra::Point2;
use parry2d_f64::math::{Pose, Vector};
use parry2d_f64::query::{PointQuery, ShapeCastOptions};
use parry2d_f64::shape::{Ball, Capsule, Polyline};
use rstar::RTree;
use rstar::primitives::Line;
use static_aabb2d_index::{Control, StaticAABB2DIndex, StaticAABB2DIndexBuilder};

pub type Xy = (f64, f64);

/// Segments in millimetres.
pub type Segments = [(Xy, Xy)];

fn minus(a: Xy, b: Xy) -> Xy {
    (a.0 - b.0, a.1 - b.1)
}

fn dot(a: Xy, b: Xy) -> f64 {
    a.0 * b.0 + a.1 * b.1
}

/// Squared distance from a point to a segment.
pub fn distance_2(p: Xy, (a, b): (Xy, Xy)) -> f64 {
    let (d, w) = (minus(b, a), minus(p, a));
    let t = (dot(w, d) / dot(d, d)).clamp(0.0, 1.0);
    let off = (w.0 - t * d.0, w.1 - t * d.1);
    dot(off, off)
}

fn segments_distance_2(a: (Xy, Xy), b: (Xy, Xy)) -> f64 {
    let cross = |o: Xy, p: Xy, q: Xy| (p.0 - o.0) * (q.1 - o.1) - (p.1 - o.1) * (q.0 - o.0);
    if cross(a.0, a.1, b.0) * cross(a.0, a.1, b.1) < 0.0 && cross(b.0, b.1, a.0) * cross(b.0, b.1, a.1) < 0.0
    {
        return 0.0;
    }
    distance_2(a.0, b).min(distance_2(a.1, b)).min(distance_2(b.0, a)).min(distance_2(b.1, a))
}

/// parry2d in `f64`.
pub struct Parry(Polyline);

impl Parry {
    pub fn build(segments: &Segments) -> Self {
        let (points, indices) = joined(segments);
        Self(Polyline::new(points.iter().map(|&(x, y)| Vector::new(x, y)).collect(), Some(indices)))
    }
    pub fn nearest(&self, p: Xy) -> f64 {
        let at = Vector::new(p.0, p.1);
        (self.0.project_local_point(at, true).point - at).length()
    }
    pub fn nearest_within(&self, p: Xy, bound: f64) -> Option<f64> {
        let at = Vector::new(p.0, p.1);
        Some((self.0.project_local_point_with_max_dist(at, true, bound)?.point - at).length())
    }
    pub fn meets_ball(&self, p: Xy, r: f64) -> bool {
        let ball = Pose::from_translation(Vector::new(p.0, p.1));
        parry2d_f64::query::intersection_test(&Pose::IDENTITY, &self.0, &ball, &Ball::new(r))
            .is_ok_and(|i| i.intersecting)
    }
    pub fn meets_capsule(&self, (a, b): (Xy, Xy), r: f64) -> bool {
        let capsule = Capsule::new(Vector::new(a.0, a.1), Vector::new(b.0, b.1), r);
        parry2d_f64::query::intersection_test(&Pose::IDENTITY, &self.0, &Pose::IDENTITY, &capsule)
            .is_ok_and(|i| i.intersecting)
    }
    /// Share of the motion until the disc meets a segment. 1 without a contact.
    pub fn cast(&self, (a, b): (Xy, Xy), r: f64) -> f64 {
        let from = Pose::from_translation(Vector::new(a.0, a.1));
        let velocity = Vector::new(b.0 - a.0, b.1 - a.1);
        let options = ShapeCastOptions::with_max_time_of_impact(1.0);
        let zero = Vector::new(0.0, 0.0);
        let cast = parry2d_f64::query::cast_shapes(
            &from,
            velocity,
            &Ball::new(r),
            &Pose::IDENTITY,
            zero,
            &self.0,
            options,
        );
        cast.ok().flatten().map_or(1.0, |hit| hit.time_of_impact)
    }
}

/// parry2d in `f32`.
pub struct Parry32(parry2d::shape::Polyline);

impl Parry32 {
    pub fn build(segments: &Segments) -> Self {
        let (points, indices) = joined(segments);
        let points = points.iter().map(|&(x, y)| parry2d::math::Vector::new(x as f32, y as f32)).collect();
        Self(parry2d::shape::Polyline::new(points, Some(indices)))
    }
    pub fn cast(&self, (a, b): (Xy, Xy), r: f64) -> f64 {
        use parry2d::math::{Pose, Vector};
        let from = Pose::from_translation(Vector::new(a.0 as f32, a.1 as f32));
        let velocity = Vector::new((b.0 - a.0) as f32, (b.1 - a.1) as f32);
        let options = parry2d::query::ShapeCastOptions::with_max_time_of_impact(1.0);
        let ball = parry2d::shape::Ball::new(r as f32);
        let zero = Vector::new(0.0, 0.0);
        let cast =
            parry2d::query::cast_shapes(&from, velocity, &ball, &Pose::IDENTITY, zero, &self.0, options);
        cast.ok().flatten().map_or(1.0, |hit| f64::from(hit.time_of_impact))
    }
}

/// Vertices and index pairs of rings. The rings are consecutive segments.
fn joined(segments: &Segments) -> (Vec<Xy>, Vec<[u32; 2]>) {
    let points: Vec<Xy> = segments.iter().map(|segment| segment.0).collect();
    let mut indices = Vec::with_capacity(points.len());
    let mut ring = 0;
    for (i, segment) in segments.iter().enumerate() {
        let next = if segment.1 == points[ring] { ring } else { i + 1 };
        indices.push([i as u32, next as u32]);
        if next == ring {
            ring = i + 1;
        }
    }
    (points, indices)
}

/// rstar.
pub struct Rstar(RTree<Line<[f64; 2]>>);

impl Rstar {
    pub fn build(segments: &Segments) -> Self {
        Self(RTree::bulk_load(segments.iter().map(|&(a, b)| Line::new([a.0, a.1], [b.0, b.1])).collect()))
    }
    pub fn nearest(&self, p: Xy) -> f64 {
        self.0.nearest_neighbor_with_distance_2([p.0, p.1]).map_or(f64::NAN, |(_, d_2)| d_2.sqrt())
    }
    pub fn is_clear(&self, p: Xy, r: f64) -> bool {
        self.0.locate_within_distance([p.0, p.1], r * r).next().is_none()
    }
}

/// A segment for bvh.
pub struct Leaf {
    segment: (Xy, Xy),
    node: usize,
}

impl Bounded<f64, 2> for Leaf {
    fn aabb(&self) -> Aabb<f64, 2> {
        let (a, b) = self.segment;
        Aabb::with_bounds(Point2::new(a.0.min(b.0), a.1.min(b.1)), Point2::new(a.0.max(b.0), a.1.max(b.1)))
    }
}

impl BHShape<f64, 2> for Leaf {
    fn set_bh_node_index(&mut self, index: usize) {
        self.node = index;
    }
    fn bh_node_index(&self) -> usize {
        self.node
    }
}

impl PointDistance<f64, 2> for Leaf {
    fn distance_squared(&self, p: Point2<f64>) -> f64 {
        distance_2((p.x, p.y), self.segment)
    }
}

/// bvh.
pub struct BvhTree(Bvh<f64, 2>, Vec<Leaf>);

impl BvhTree {
    pub fn build(segments: &Segments) -> Self {
        let mut leaves: Vec<Leaf> = segments.iter().map(|&segment| Leaf { segment, node: 0 }).collect();
        let tree = Bvh::build(&mut leaves);
        Self(tree, leaves)
    }
    pub fn nearest(&self, p: Xy) -> f64 {
        self.0.nearest_to(Point2::new(p.0, p.1), &self.1).map_or(f64::NAN, |(_, distance)| distance)
    }
}

/// `static_aabb2d_index`, together with the segments.
pub struct Static(StaticAABB2DIndex<f64>, Vec<(Xy, Xy)>);

impl Static {
    pub fn build(segments: &Segments) -> Self {
        let mut builder = StaticAABB2DIndexBuilder::new(segments.len());
        for &(a, b) in segments {
            builder.add(a.0.min(b.0), a.1.min(b.1), a.0.max(b.0), a.1.max(b.1));
        }
        Self(builder.build().expect("all segments were added"), segments.to_vec())
    }
    pub fn is_clear(&self, p: Xy, r: f64) -> bool {
        let mut visit = |i: usize| {
            if distance_2(p, self.1[i]) <= r * r { Control::Break(()) } else { Control::Continue }
        };
        !matches!(self.0.visit_query(p.0 - r, p.1 - r, p.0 + r, p.1 + r, &mut visit), Control::Break(()))
    }
    pub fn motion_is_clear(&self, motion: (Xy, Xy), r: f64) -> bool {
        let (a, b) = motion;
        let mut visit = |i: usize| {
            if segments_distance_2(motion, self.1[i]) <= r * r {
                Control::Break(())
            } else {
                Control::Continue
            }
        };
        let low = (a.0.min(b.0) - r, a.1.min(b.1) - r);
        let high = (a.0.max(b.0) + r, a.1.max(b.1) + r);
        !matches!(self.0.visit_query(low.0, low.1, high.0, high.1, &mut visit), Control::Break(()))
    }
}

/// geo, which searches all segments.
pub struct Geo(geo::MultiLineString<f64>);

impl Geo {
    pub fn build(segments: &Segments) -> Self {
        let line = |&(a, b): &(Xy, Xy)| geo::LineString::from(vec![a, b]);
        Self(geo::MultiLineString::new(segments.iter().map(line).collect()))
    }
    pub fn nearest(&self, p: Xy) -> f64 {
        Euclidean.distance(&geo::Point::new(p.0, p.1), &self.0)
    }
}
