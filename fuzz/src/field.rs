//! Inputs for queries of the kernel: corners and points, on grids on which they coincide.

use arbitrary::{Arbitrary, Result, Unstructured};
use keepout_kernel::Segment;
use keepout_proofs::families::at;
use keepout_proofs::properties::Xy;

/// Largest number of corners of a ring, and of edges of a soup.
pub const CORNERS_MAX: usize = 40;

/// A field of coordinates: half its side, and the grid of the coordinates, so that points coincide.
#[derive(Clone, Copy, Debug)]
pub struct Field {
    /// Half its side.
    pub half: i64,
    grid: i64,
}

impl<'a> Arbitrary<'a> for Field {
    fn arbitrary(u: &mut Unstructured<'a>) -> Result<Self> {
        let half = 1_i64 << u.int_in_range(2..=29_u8)?;
        let grid = (1_i64 << u.int_in_range(0..=29_u8)?).min(half);
        Ok(Self { half, grid: if bool::arbitrary(u)? { grid } else { 1 } })
    }
}

impl Field {
    pub fn point(self, u: &mut Unstructured<'_>) -> Result<Xy> {
        let most = self.half / self.grid;
        let mut coordinate = || -> Result<i64> { Ok(u.int_in_range(-most..=most)? * self.grid) };
        Ok((coordinate()?, coordinate()?))
    }

    /// A point beside some corner, or anywhere.
    pub fn beside(self, corners: &[Xy], u: &mut Unstructured<'_>) -> Result<Xy> {
        if corners.is_empty() || bool::arbitrary(u)? {
            return self.point(u);
        }
        let (x, y) = *u.choose(corners)?;
        Ok((x + i64::from(i16::arbitrary(u)?), y + i64::from(i8::arbitrary(u)?)))
    }

    pub fn radius(self, u: &mut Unstructured<'_>) -> Result<i64> {
        let most = if bool::arbitrary(u)? { self.half } else { 64 };
        u.int_in_range(0..=most)
    }

    /// A ring around a centre, or through any points; simple or not.
    pub fn ring(self, u: &mut Unstructured<'_>) -> Result<Vec<Xy>> {
        let count = u.int_in_range(3..=CORNERS_MAX)?;
        if bool::arbitrary(u)? {
            return (0..count).map(|_| self.point(u)).collect();
        }
        let centre = self.point(u)?;
        // Sometimes small compared with the queries, so that motions and triangles go round all of it.
        let widest = if count % 4 == 3 { self.half >> 4 } else { self.half };
        let radius = |u: &mut Unstructured<'_>| Ok(widest * i64::from(u.int_in_range(1..=64_u8)?) / 64);
        (0..count).map(|k| Ok(around(centre, k, count, radius(u)?))).collect()
    }
}

#[expect(clippy::cast_precision_loss, reason = "few corners, and radii of 30 bits")]
fn around((x, y): Xy, k: usize, count: usize, radius: i64) -> Xy {
    let (sine, cosine) = (std::f64::consts::TAU * k as f64 / count as f64).sin_cos();
    let unit = |c: f64| keepout_kernel::curve::nearest_unit(c * radius as f64);
    (x + unit(cosine), y + unit(sine))
}

/// The segment from `a` to `b`.
pub fn segment(a: Xy, b: Xy) -> Segment {
    Segment { from: at(a), to: at(b) }
}
