//! Entities in the coordinates of the file: the geometry of those that can bound a part, and the kind of
//! every other.

use super::damage::{Damage, FilePlace};
use super::tags::Tag;

/// A point or vector of the file.
pub type Vec3 = [f64; 3];

/// An entity.
#[derive(Clone, Debug)]
pub struct Entity {
    /// The place where it begins in the file.
    pub at: FilePlace,
    /// Its handle, or 0 if it has no handle.
    pub handle: u64,
    /// Number of its layer's name.
    pub layer: u32,
    /// Number of its line type's name; `None` for the line type of its layer.
    pub line_type: Option<u32>,
    /// The reason why it is hidden, if it is.
    pub hidden: Option<Hidden>,
    /// The normal of its own plane.
    pub normal: Vec3,
    /// Its geometry.
    pub shape: Shape,
}

/// Reasons why an entity is hidden.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hidden {
    /// It is in paper space.
    Paper,
    /// It is invisible.
    Invisible,
}

/// The geometry of an entity. Angles are in degrees, as in the file; parameters of an ellipse are in radians.
#[derive(Clone, Debug)]
pub enum Shape {
    /// LINE.
    Line {
        /// Start point.
        from: Vec3,
        /// End point.
        to: Vec3,
    },
    /// ARC, counter-clockwise in its own plane; a CIRCLE has no angles.
    Arc {
        /// Centre in its own plane.
        centre: Vec3,
        /// Radius.
        radius: f64,
        /// First and last angle, degrees.
        angles: Option<(f64, f64)>,
    },
    /// ELLIPSE.
    Ellipse(Box<Ellipse>),
    /// LWPOLYLINE and POLYLINE.
    Polyline(Box<Polyline>),
    /// SPLINE.
    Spline(Box<Spline>),
    /// INSERT.
    Insert(Box<Insert>),
    /// The boundaries of a HATCH.
    Hatch(Vec<Boundary>),
    /// The corners of a SOLID or TRACE, in order around it.
    Solid(Vec<Vec3>),
    /// Any entity that can not bound a part, by its common name.
    Other(&'static str),
}

/// An ellipse, or an arc of an ellipse.
#[derive(Clone, Copy, Debug)]
pub struct Ellipse {
    /// Its centre.
    pub centre: Vec3,
    /// The larger half axis, a vector from the centre.
    pub major: Vec3,
    /// Ratio of the smaller half axis to the larger.
    pub ratio: f64,
    /// First and last parameter, radians.
    pub range: (f64, f64),
}

/// Vertices with bulges.
#[derive(Clone, Debug)]
pub struct Polyline {
    /// The vertices, and the bulge of the edge that begins at each.
    pub vertices: Vec<(Vec3, f64)>,
    /// Whether the last vertex joins the first.
    pub closed: bool,
    /// Whether the vertices are in the polyline's own plane.
    pub planar: bool,
    /// The largest width of its edges.
    pub width: f64,
    /// The name of its entity type in the file.
    pub kind: &'static str,
}

/// A VERTEX of a POLYLINE.
#[derive(Clone, Copy, Debug)]
pub struct Vertex {
    /// Its place.
    pub at: Vec3,
    /// The bulge of the edge that begins at it.
    pub bulge: f64,
    /// The larger width of that edge.
    pub width: f64,
    /// Its flags.
    pub flags: i64,
}

/// A rational B-spline.
#[derive(Clone, Debug, Default)]
pub struct Spline {
    /// The degree.
    pub degree: i64,
    /// Whether the file states that it is closed.
    pub closed: bool,
    /// Knots; may be empty.
    pub knots: Vec<f64>,
    /// Control points.
    pub control: Vec<Vec3>,
    /// Weights; if empty, every weight is one.
    pub weights: Vec<f64>,
    /// Fit points, which the spline passes through. They are used only without control points.
    pub fit: Vec<Vec3>,
    /// Start and end tangent of a spline of fit points.
    pub tangents: (Option<Vec3>, Option<Vec3>),
}

/// An insert of a block (a block reference).
#[derive(Clone, Debug)]
pub struct Insert {
    /// Number of the block's name.
    pub block: u32,
    /// The insertion point, where the block's base point lies.
    pub at: Vec3,
    /// Scale along the block's axes.
    pub scale: Vec3,
    /// Rotation, degrees.
    pub rotation: f64,
    /// Number of columns and of rows.
    pub count: (i64, i64),
    /// Spacing of columns and of rows.
    pub spacing: (f64, f64),
}

/// A boundary path of a hatch, in the hatch's own plane.
#[derive(Clone, Debug)]
pub enum Boundary {
    /// A closed polyline.
    Polyline(Vec<(Vec3, f64)>),
    /// Edges, end to end.
    Edges(Vec<Shape>),
}

/// The groups of one entity.
#[derive(Clone, Copy, Debug)]
pub struct Fields<'t, 'a> {
    tags: &'t [Tag<'a>],
}

impl<'t, 'a> Fields<'t, 'a> {
    /// The entity's groups before its extended data and embedded objects.
    #[must_use]
    pub fn new(tags: &'t [Tag<'a>]) -> Self {
        let end = tags.iter().position(|tag| tag.code >= 1000 || tag.code == 101).unwrap_or(tags.len());
        Self { tags: &tags[..end] }
    }

    /// The first group of this code.
    #[must_use]
    pub fn find(&self, code: i16) -> Option<&'t Tag<'a>> {
        self.tags.iter().find(|tag| tag.code == code)
    }

    /// The value of the group as a number, or the default.
    ///
    /// # Errors
    /// [`Damage::Number`].
    pub fn real(&self, code: i16, default: f64) -> Result<f64, Damage> {
        self.find(code).map_or(Ok(default), Tag::real)
    }

    /// The value of the group as an integer, or the default.
    ///
    /// # Errors
    /// [`Damage::Number`].
    pub fn integer(&self, code: i16, default: i64) -> Result<i64, Damage> {
        self.find(code).map_or(Ok(default), Tag::integer)
    }

    /// The point whose x has this code; y and z have the codes 10 and 20 higher.
    ///
    /// # Errors
    /// [`Damage::Number`].
    pub fn point(&self, code: i16, default: Vec3) -> Result<Vec3, Damage> {
        Ok([
            self.real(code, default[0])?,
            self.real(code + 10, default[1])?,
            self.real(code + 20, default[2])?,
        ])
    }

    /// Checks that the entity has these groups.
    ///
    /// # Errors
    /// [`Damage::Missing`] for the first missing group.
    pub fn has(&self, codes: &[i16]) -> Result<(), Damage> {
        let missing = codes.iter().find(|code| self.find(**code).is_none());
        let at = self.tags.last().map_or(FilePlace::Line(0), |tag| tag.at);
        missing.map_or(Ok(()), |&code| Err(Damage::Missing { at, code }))
    }

    /// The value of the group as text; empty without the group.
    #[must_use]
    pub fn text(&self, code: i16) -> &'a [u8] {
        self.find(code).map_or(b"", Tag::text)
    }

    fn reals(&self, code: i16) -> Result<Vec<f64>, Damage> {
        self.tags.iter().filter(|tag| tag.code == code).map(Tag::real).collect()
    }

    /// The largest value of the groups of this code, at least `least`. Damaged groups do not count.
    #[must_use]
    pub fn largest(&self, code: i16, least: f64) -> f64 {
        let values = self.tags.iter().filter(|tag| tag.code == code).filter_map(|tag| tag.real().ok());
        values.filter(|value| value.is_finite()).fold(least, f64::max)
    }

    /// A list of points; each begins with its x, which has this code.
    fn points(&self, code: i16) -> Result<Vec<Vec3>, Damage> {
        let mut points: Vec<Vec3> = Vec::new();
        for tag in self.tags {
            if tag.code == code {
                points.push([tag.real()?, 0.0, 0.0]);
            } else if let Some(last) = points.last_mut() {
                if tag.code == code + 10 {
                    last[1] = tag.real()?;
                } else if tag.code == code + 20 {
                    last[2] = tag.real()?;
                }
            }
        }
        Ok(points)
    }
}

/// The shape of an entity that has no sub-entities: every kind except POLYLINE. `name` gives each block name
/// a number.
///
/// # Errors
/// [`Damage`] with the place.
pub fn shape_of(
    kind: &[u8],
    fields: Fields<'_, '_>,
    name: &mut dyn FnMut(&[u8]) -> u32,
) -> Result<Shape, Damage> {
    const NONE: Vec3 = [0.0; 3];
    Ok(match kind {
        b"LINE" | b"3DLINE" => {
            fields.has(&[10, 20, 11, 21])?;
            Shape::Line { from: fields.point(10, NONE)?, to: fields.point(11, NONE)? }
        }
        b"ARC" | b"CIRCLE" => {
            fields.has(&[10, 20, 40])?;
            let angles = match kind {
                b"ARC" => Some((fields.real(50, 0.0)?, fields.real(51, 360.0)?)),
                _ => None,
            };
            Shape::Arc { centre: fields.point(10, NONE)?, radius: fields.real(40, 0.0)?, angles }
        }
        b"ELLIPSE" => Shape::Ellipse(Box::new(Ellipse {
            centre: fields.point(10, NONE)?,
            major: fields.point(11, NONE)?,
            ratio: fields.real(40, 1.0)?,
            range: (fields.real(41, 0.0)?, fields.real(42, std::f64::consts::TAU)?),
        })),
        b"LWPOLYLINE" => Shape::Polyline(Box::new(light_polyline(fields)?)),
        b"SPLINE" => Shape::Spline(Box::new(spline(fields)?)),
        b"INSERT" => Shape::Insert(Box::new(Insert {
            block: name(fields.text(2)),
            at: fields.point(10, NONE)?,
            scale: [fields.real(41, 1.0)?, fields.real(42, 1.0)?, fields.real(43, 1.0)?],
            rotation: fields.real(50, 0.0)?,
            count: (fields.integer(70, 1)?.max(1), fields.integer(71, 1)?.max(1)),
            spacing: (fields.real(44, 0.0)?, fields.real(45, 0.0)?),
        })),
        b"HATCH" => Shape::Hatch(super::hatch::boundaries(fields.tags)?),
        b"SOLID" | b"TRACE" => {
            let corner = |code| fields.point(code, NONE);
            // The file swaps the third and the fourth corner. A triangle repeats the third.
            let fourth = if fields.find(13).is_some() { corner(13)? } else { corner(12)? };
            Shape::Solid(vec![corner(10)?, corner(11)?, fourth, corner(12)?])
        }
        b"TEXT" | b"MTEXT" | b"RTEXT" | b"ARCALIGNEDTEXT" => Shape::Other("text"),
        b"ATTRIB" | b"ATTDEF" => Shape::Other("attribute"),
        b"DIMENSION" | b"ARC_DIMENSION" | b"LARGE_RADIAL_DIMENSION" => Shape::Other("dimension"),
        b"POINT" => Shape::Other("point"),
        b"LEADER" | b"MLEADER" | b"MULTILEADER" | b"TOLERANCE" => Shape::Other("leader or tolerance"),
        b"XLINE" | b"RAY" => Shape::Other("construction line without end"),
        b"MLINE" => Shape::Other("multiline"),
        b"3DFACE" | b"3DSOLID" | b"BODY" | b"REGION" | b"SURFACE" | b"MESH" | b"HELIX" => {
            Shape::Other("solid, surface or mesh")
        }
        b"IMAGE" | b"WIPEOUT" | b"OLEFRAME" | b"OLE2FRAME" | b"PDFUNDERLAY" | b"DWFUNDERLAY"
        | b"DGNUNDERLAY" => Shape::Other("picture or cover"),
        b"VIEWPORT" => Shape::Other("viewport"),
        b"SEQEND" | b"VERTEX" => Shape::Other("vertex without a polyline"),
        _ => Shape::Other("entity of another kind"),
    })
}

fn light_polyline(fields: Fields<'_, '_>) -> Result<Polyline, Damage> {
    let elevation = fields.real(38, 0.0)?;
    let mut vertices: Vec<(Vec3, f64)> = Vec::new();
    for tag in fields.tags {
        match (tag.code, vertices.last_mut()) {
            (10, _) => vertices.push(([tag.real()?, 0.0, elevation], 0.0)),
            (20, Some((at, _))) => at[1] = tag.real()?,
            (42, Some((_, bulge))) => *bulge = tag.real()?,
            _ => {}
        }
    }
    let closed = fields.integer(70, 0)? & 1 != 0;
    let width = [40, 41, 43].into_iter().fold(0.0, |most, code| fields.largest(code, most));
    Ok(Polyline { vertices, closed, planar: true, width, kind: "LWPOLYLINE" })
}

/// A polyline from its own groups and the groups of its vertices; `None` for meshes.
///
/// # Errors
/// [`Damage::Number`].
pub fn polyline(fields: Fields<'_, '_>, vertices: &[Vertex]) -> Result<Option<Polyline>, Damage> {
    const MESHES: i64 = 16 | 64;
    const IN_SPACE: i64 = 8;
    const SPLINE_FRAME: i64 = 16;
    let flags = fields.integer(70, 0)?;
    if flags & MESHES != 0 {
        return Ok(None);
    }
    let elevation = fields.real(30, 0.0)?;
    let planar = flags & IN_SPACE == 0;
    let kept = vertices.iter().filter(|vertex| vertex.flags & SPLINE_FRAME == 0);
    let placed = |vertex: &Vertex| {
        let [x, y, z] = vertex.at;
        if planar { ([x, y, elevation], vertex.bulge) } else { ([x, y, z], 0.0) }
    };
    let width = [40, 41].into_iter().fold(0.0, |most, code| fields.largest(code, most));
    Ok(Some(Polyline {
        vertices: kept.map(placed).collect(),
        closed: flags & 1 != 0,
        planar,
        width: vertices.iter().map(|vertex| vertex.width).fold(width, f64::max),
        kind: "POLYLINE",
    }))
}

fn spline(fields: Fields<'_, '_>) -> Result<Spline, Damage> {
    let tangent = |code| fields.find(code).map(|_| fields.point(code, [0.0; 3])).transpose();
    Ok(Spline {
        degree: fields.integer(71, 3)?,
        closed: fields.integer(70, 0)? & 1 != 0,
        knots: fields.reals(40)?,
        control: fields.points(10)?,
        weights: fields.reals(41)?,
        fit: fields.points(11)?,
        tangents: (tangent(12)?, tangent(13)?),
    })
}
