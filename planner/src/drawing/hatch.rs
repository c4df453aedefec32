//! The boundaries of a HATCH. The meaning of its groups depends on their order.

use super::damage::Damage;
use super::entity::{Boundary, Ellipse, Shape, Spline, Vec3};
use super::tags::Tag;

/// The boundary paths of a hatch, from its groups.
///
/// # Errors
/// [`Damage::Number`].
pub fn boundaries(tags: &[Tag<'_>]) -> Result<Vec<Boundary>, Damage> {
    let begin = tags.iter().position(|tag| tag.code == 91).map_or(tags.len(), |at| at + 1);
    let mut reader = Reader { tags: &tags[begin..] };
    let mut paths = Vec::new();
    while let Some(flags) = reader.take(92) {
        paths.push(if flags.integer()? & 2 != 0 { reader.polyline()? } else { reader.edges()? });
        // The handles of the path's source objects follow. The reader does not need them.
        while reader.tags.first().is_some_and(|tag| matches!(tag.code, 97 | 330)) {
            reader.tags = &reader.tags[1..];
        }
    }
    Ok(paths)
}

struct Reader<'t, 'a> {
    tags: &'t [Tag<'a>],
}

impl<'t, 'a> Reader<'t, 'a> {
    /// The next group, if it has this code.
    fn take(&mut self, code: i16) -> Option<&'t Tag<'a>> {
        let (tag, rest) = self.tags.split_first()?;
        (tag.code == code).then(|| {
            self.tags = rest;
            tag
        })
    }

    fn real(&mut self, code: i16) -> Result<f64, Damage> {
        self.take(code).map_or(Ok(0.0), Tag::real)
    }

    fn integer(&mut self, code: i16) -> Result<i64, Damage> {
        self.take(code).map_or(Ok(0), Tag::integer)
    }

    fn point(&mut self, code: i16) -> Result<Vec3, Damage> {
        Ok([self.real(code)?, self.real(code + 10)?, 0.0])
    }

    fn polyline(&mut self) -> Result<Boundary, Damage> {
        let (_bulges, _closed, _count) = (self.integer(72)?, self.integer(73)?, self.integer(93)?);
        let mut vertices = Vec::new();
        while self.tags.first().is_some_and(|tag| tag.code == 10) {
            vertices.push((self.point(10)?, self.real(42)?));
        }
        Ok(Boundary::Polyline(vertices))
    }

    fn edges(&mut self) -> Result<Boundary, Damage> {
        let _count = self.integer(93)?;
        let mut edges = Vec::new();
        while let Some(kind) = self.take(72) {
            edges.push(match kind.integer()? {
                1 => Shape::Line { from: self.point(10)?, to: self.point(11)? },
                2 => self.arc()?,
                3 => self.ellipse()?,
                4 => self.spline()?,
                _ => break,
            });
        }
        Ok(Boundary::Edges(edges))
    }

    fn arc(&mut self) -> Result<Shape, Damage> {
        let (centre, radius) = (self.point(10)?, self.real(40)?);
        let (start, end) = (self.real(50)?, self.real(51)?);
        let forwards = self.integer(73)? != 0;
        // The file gives the angles of clockwise arcs mirrored.
        let angles = if forwards { (start, end) } else { (-end, -start) };
        Ok(Shape::Arc { centre, radius, angles: Some(angles) })
    }

    fn ellipse(&mut self) -> Result<Shape, Damage> {
        let (centre, major, ratio) = (self.point(10)?, self.point(11)?, self.real(40)?);
        let (start, end) = (self.real(50)?, self.real(51)?);
        let (start, end) = if self.integer(73)? != 0 { (start, end) } else { (-end, -start) };
        let range = (parameter(start.to_radians(), ratio), parameter(end.to_radians(), ratio));
        Ok(Shape::Ellipse(Box::new(Ellipse { centre, major, ratio, range })))
    }

    fn spline(&mut self) -> Result<Shape, Damage> {
        let degree = self.integer(94)?;
        let (_rational, closed) = (self.integer(73)?, self.integer(74)? != 0);
        let (_knots, _points) = (self.integer(95)?, self.integer(96)?);
        let mut spline = Spline { degree, closed, ..Spline::default() };
        while let Some(knot) = self.take(40) {
            spline.knots.push(knot.real()?);
        }
        while self.tags.first().is_some_and(|tag| tag.code == 10) {
            spline.control.push(self.point(10)?);
            if let Some(weight) = self.take(42) {
                spline.weights.push(weight.real()?);
            }
        }
        // Newer files give the number of fit points, often 0. In other files this group may be the number of
        // the path's source objects.
        if self.take(97).is_some() {
            while self.tags.first().is_some_and(|tag| tag.code == 11) {
                spline.fit.push(self.point(11)?);
            }
            for code in [12, 22, 13, 23] {
                self.take(code);
            }
        }
        Ok(Shape::Spline(Box::new(spline)))
    }
}

/// The parameter of the point of an ellipse at a polar angle, in the same full turn as the angle.
fn parameter(angle: f64, ratio: f64) -> f64 {
    let (sin, cos) = angle.sin_cos();
    angle + (sin / ratio).atan2(cos) - sin.atan2(cos)
}
