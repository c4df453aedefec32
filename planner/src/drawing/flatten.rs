//! Turns entities into curves: expands inserts of blocks, rotates planes, and projects all onto the xy plane.

use std::sync::Arc;

use super::entity::{Boundary, Entity, Hidden, Insert, Polyline, Shape, Vec3};
use super::file::{DxfFile, folded};
use super::import::EntityFilter;
use super::placement::Placement;
use super::unseen::Unseen;
use super::{
    Drawing, DrawingError, LeftOutCurve, LeftOutReason, Origin, PolylineChain, RawCurve, entity_curves,
    spline,
};

/// Largest depth of blocks within blocks.
const DEPTH_MAX: usize = 32;
/// Largest number of visits to entities. Each insert of a block counts again: nested arrays multiply. The
/// fuzzer uses lower limits, which reveal the same faults.
const VISITS_MAX: usize = if cfg!(fuzzing) { 100_000 } else { 20_000_000 };
/// Largest number of curves of a drawing.
pub const CURVES_MAX: usize = if cfg!(fuzzing) { 10_000 } else { 2_000_000 };

/// Largest number of curves kept of those that are left out.
const ASIDE_MAX: usize = 20_000;

/// Turns the entities of a file into the curves of a drawing.
pub struct Flattener<'a> {
    file: &'a DxfFile,
    filter: &'a EntityFilter,
    /// The drawing with the curves so far.
    pub drawing: Drawing,
    /// What the view from above does not show.
    pub unseen: Unseen,
    visits: usize,
    /// The blocks whose inserts are being expanded, by the numbers of their names.
    open: Vec<u32>,
}

/// The placement and the properties that an entity inherits from the insert of its block.
#[derive(Clone)]
struct InsertContext {
    placement: Placement,
    /// Layer and line type of the insert.
    layer: Option<u32>,
    line_type: Option<u32>,
    /// The layer that gives the insert its line type, if the insert has no line type of its own.
    line_layer: Option<u32>,
    block: Option<Arc<str>>,
}

impl<'a> Flattener<'a> {
    /// A flattener whose drawing has no curves yet.
    #[must_use]
    pub fn new(file: &'a DxfFile, filter: &'a EntityFilter, unit: String) -> Self {
        let drawing = Drawing { unit, ..Drawing::default() };
        Self { file, filter, drawing, unseen: Unseen::default(), visits: 0, open: Vec::new() }
    }

    /// Takes all entities of the file.
    ///
    /// # Errors
    /// [`DrawingError`], which names the entity.
    pub fn run(&mut self, placement: Placement) -> Result<(), DrawingError> {
        let context =
            InsertContext { placement, layer: None, line_type: None, line_layer: None, block: None };
        self.entities(&self.file.entities, &context)
    }

    fn entities(&mut self, entities: &[Entity], context: &InsertContext) -> Result<(), DrawingError> {
        for entity in entities {
            self.visit(entity, context, "entity")?;
            self.entity(entity, context)?;
        }
        Ok(())
    }

    /// Counts a visit, and refuses it above the limits.
    fn visit(
        &mut self,
        entity: &Entity,
        context: &InsertContext,
        kind: &'static str,
    ) -> Result<(), DrawingError> {
        self.visits += 1;
        if self.visits <= VISITS_MAX && self.drawing.curves.len() <= CURVES_MAX {
            return Ok(());
        }
        Err(self.too_many(entity, context, kind))
    }

    fn too_many(&self, entity: &Entity, context: &InsertContext, kind: &'static str) -> DrawingError {
        DrawingError::TooMany { origin: Box::new(self.origin(entity, context, kind)) }
    }

    fn leave_out(&mut self, why: String) {
        *self.drawing.left_out.entry(why).or_default() += 1;
    }

    fn layer_of(&self, entity: &Entity, context: &InsertContext) -> u32 {
        match context.layer {
            Some(outer) if &**self.file.names.get(entity.layer) == "0" => outer,
            _ => entity.layer,
        }
    }

    fn origin(&self, entity: &Entity, context: &InsertContext, kind: &'static str) -> Origin {
        let layer = self.file.names.get(self.layer_of(entity, context)).clone();
        Origin { kind, handle: entity.handle, at: entity.at, layer, block: context.block.clone() }
    }

    fn entity(&mut self, entity: &Entity, context: &InsertContext) -> Result<(), DrawingError> {
        if entity.hidden == Some(Hidden::Paper) {
            self.leave_out("in paper space".into());
            return Ok(());
        }
        let kind = match kind_of(&entity.shape, self.filter) {
            Ok(kind) => kind,
            Err(why) => {
                self.leave_out(why);
                return Ok(());
            }
        };
        let layer = self.layer_of(entity, context);
        let names = &self.file.names;
        let by_block = |number: u32| names.get(number).eq_ignore_ascii_case("BYBLOCK");
        // An entity of line type BYBLOCK has the line type of its insert.
        let (line_type, line_layer) = match entity.line_type {
            Some(number) if by_block(number) => (context.line_type, context.line_layer.unwrap_or(layer)),
            own => (own, layer),
        };
        let is_insert = matches!(entity.shape, Shape::Insert(_));
        let hidden = entity.hidden.is_some();
        if let Some(why) = self.filter.hides(self.file, layer, (line_type, line_layer), hidden, is_insert) {
            self.leave_out(why.to_string());
            if !is_insert {
                self.set_aside(entity, context, kind, why);
            }
            return Ok(());
        }
        if let Shape::Insert(insert) = &entity.shape {
            return self.insert(entity, insert, (layer, line_type, line_layer), context);
        }
        let name = self.file.names.get(layer);
        if !self.drawing.layers.contains_key(name) {
            self.drawing.layers.insert(name.clone(), 0);
        }
        if self.filter.is_other_layer(name) {
            return Ok(());
        }
        if !self.filter.takes_layer(name) {
            self.leave_out("on layers that are not selected".into());
            let why = LeftOutReason::Layer(name.clone());
            self.set_aside(entity, context, kind, why);
            return Ok(());
        }
        let origin = self.origin(entity, context, kind);
        let before = self.drawing.curves.len();
        let number = u32::try_from(self.drawing.origins.len()).unwrap_or(u32::MAX);
        self.drawing.origins.push(origin);
        self.shape(&entity.shape, entity.normal, &context.placement, number)?;
        let taken = self.drawing.curves.len() - before;
        if taken == 0 {
            self.leave_out(format!("{kind} without size"));
        }
        let unplotted = self.file.is_unplotted(name) && self.filter.layers.is_empty();
        self.unseen.look(entity, &context.placement, (taken, unplotted.then_some(name)));
        if let Some(count) = self.drawing.layers.get_mut(name) {
            *count += taken;
        }
        Ok(())
    }

    /// Keeps the curves of an entity that is left out, for the pictures and for the check of what surrounds the
    /// part. An entity without readable curves has none.
    fn set_aside(
        &mut self,
        entity: &Entity,
        context: &InsertContext,
        kind: &'static str,
        reason: LeftOutReason,
    ) {
        if self.drawing.aside.len() >= ASIDE_MAX {
            return;
        }
        let drawing = &self.drawing;
        let (curves, runs, origins) = (drawing.curves.len(), drawing.runs.len(), drawing.origins.len());
        let number = u32::try_from(origins).unwrap_or(u32::MAX);
        let origin = self.origin(entity, context, kind);
        self.drawing.origins.push(origin);
        let read = self.shape(&entity.shape, entity.normal, &context.placement, number);
        let drawing = &mut self.drawing;
        let taken = drawing.curves.split_off(curves);
        drawing.runs.truncate(runs);
        drawing.origins.truncate(origins);
        if read.is_ok() {
            let left_out =
                |curve| LeftOutCurve { points: entity_curves::points_of(&curve), reason: reason.clone() };
            drawing.aside.extend(taken.into_iter().map(left_out));
        }
    }

    fn insert(
        &mut self,
        entity: &Entity,
        insert: &Insert,
        (layer, line_type, line_layer): (u32, Option<u32>, u32),
        context: &InsertContext,
    ) -> Result<(), DrawingError> {
        let origin = |problem| DrawingError::BadEntity {
            origin: Box::new(self.origin(entity, context, "INSERT")),
            problem,
        };
        let file = self.file;
        let name = file.names.get(insert.block);
        let Some(block) = file.blocks.get(&folded(name)) else {
            self.leave_out(format!("insert of block \"{name}\", which the file does not define"));
            return Ok(());
        };
        if block.external {
            self.leave_out(format!("insert of \"{name}\", which is another file"));
            return Ok(());
        }
        if self.open.contains(&insert.block) {
            return Err(origin("the block that it inserts contains itself"));
        }
        if self.open.len() >= DEPTH_MAX {
            return Err(origin("blocks are nested more than 32 deep"));
        }
        let (columns, rows) = insert.count;
        // An array that exceeds the limit is refused before it is expanded.
        let sets = usize::try_from(columns.saturating_mul(rows)).unwrap_or(usize::MAX);
        if sets.saturating_mul(1 + block.entities.len()) > VISITS_MAX.saturating_sub(self.visits) {
            return Err(self.too_many(entity, context, "INSERT"));
        }
        self.open.push(insert.block);
        let (mut row, mut r) = (0, 0.0);
        while row < rows {
            let (mut column, mut c) = (0, 0.0);
            while column < columns {
                let inner = InsertContext {
                    placement: context.placement.inserted(insert, entity.normal, block.base, (c, r)),
                    layer: Some(layer),
                    line_type,
                    line_layer: Some(line_layer),
                    block: Some(name.clone()),
                };
                // An empty block counts as a visit, too. So even an array of empty blocks reaches the limit.
                self.visit(entity, context, "INSERT")?;
                self.entities(&block.entities, &inner)?;
                (column, c) = (column + 1, c + 1.0);
            }
            (row, r) = (row + 1, r + 1.0);
        }
        self.open.pop();
        Ok(())
    }

    fn shape(
        &mut self,
        shape: &Shape,
        normal: Vec3,
        placement: &Placement,
        origin: u32,
    ) -> Result<(), DrawingError> {
        let first = self.drawing.curves.len();
        let out = &mut self.drawing.curves;
        let plane = placement.in_plane(normal);
        let mut closed = false;
        let mut problem = None;
        match shape {
            Shape::Line { from, to } => {
                let (from, to) = (placement.seen(*from), placement.seen(*to));
                if from != to {
                    out.push(RawCurve::Line { from, to });
                }
            }
            Shape::Arc { centre, radius, angles } => {
                closed = angles.is_none();
                problem = entity_curves::arc(&plane, *centre, *radius, *angles, out).err();
            }
            Shape::Ellipse(ellipse) => {
                // The ellipse of a hatch is in the hatch's plane, that of an entity is in space. The caller
                // passes the fitting placement.
                problem = entity_curves::ellipse(placement, ellipse, normal, out).err();
            }
            Shape::Polyline(line) => {
                closed = line.closed;
                entity_curves::polyline(if line.planar { &plane } else { placement }, line, out);
            }
            Shape::Spline(spline) => problem = spline::pieces(spline, placement, out).err(),
            Shape::Hatch(paths) => return self.hatch(paths, &plane, origin),
            Shape::Solid(corners) => {
                closed = true;
                let vertices = corners.iter().map(|&corner| (corner, 0.0)).collect();
                let line = Polyline { vertices, closed, planar: true, width: 0.0, kind: "SOLID" };
                entity_curves::polyline(&plane, &line, out);
            }
            Shape::Insert(_) | Shape::Other(_) => {}
        }
        self.finish(first, closed, origin, problem)
    }

    fn hatch(&mut self, paths: &[Boundary], plane: &Placement, origin: u32) -> Result<(), DrawingError> {
        const UP: Vec3 = [0.0, 0.0, 1.0];
        for path in paths {
            match path {
                Boundary::Polyline(vertices) => {
                    let vertices = vertices.clone();
                    let line = Polyline { vertices, closed: true, planar: true, width: 0.0, kind: "HATCH" };
                    self.shape(&Shape::Polyline(Box::new(line)), UP, plane, origin)?;
                }
                Boundary::Edges(edges) => {
                    edges.iter().try_for_each(|edge| self.shape(edge, UP, plane, origin))?;
                }
            }
        }
        Ok(())
    }

    /// Checks the curves from `first` on, and makes a polyline chain of them.
    fn finish(
        &mut self,
        first: usize,
        closed: bool,
        origin: u32,
        problem: Option<&'static str>,
    ) -> Result<(), DrawingError> {
        let taken = &self.drawing.curves[first..];
        let finite = taken.iter().all(RawCurve::is_finite);
        let problem = problem
            .or_else(|| (!finite).then_some("a coordinate, radius or angle is too large or is not a number"));
        if let Some(problem) = problem {
            let origin = Box::new(self.drawing.origins[origin as usize].clone());
            return Err(DrawingError::BadEntity { origin, problem });
        }
        if !taken.is_empty() {
            let closed = closed || taken.len() > 1 && taken[0].from() == taken[taken.len() - 1].to();
            self.drawing.runs.push(PolylineChain { first, end: self.drawing.curves.len(), closed, origin });
        }
        Ok(())
    }
}

/// The name of an entity that the filter takes, or the reason why it does not.
fn kind_of(shape: &Shape, filter: &EntityFilter) -> Result<&'static str, String> {
    match shape {
        Shape::Hatch(_) if !filter.hatches => {
            Err("hatch (its boundaries can be taken with --with hatch)".into())
        }
        Shape::Solid(_) if !filter.solids => {
            Err("solid or trace (its outline can be taken with --with solid)".into())
        }
        shape => name_of(shape).map_err(|what| format!("{what} (no profile)")),
    }
}

/// The DXF name of an entity, or the common name of an entity that can not bound a part.
pub(super) fn name_of(shape: &Shape) -> Result<&'static str, &'static str> {
    Ok(match shape {
        Shape::Other(what) => return Err(what),
        Shape::Line { .. } => "LINE",
        Shape::Arc { angles: Some(_), .. } => "ARC",
        Shape::Arc { .. } => "CIRCLE",
        Shape::Ellipse(_) => "ELLIPSE",
        Shape::Polyline(line) => line.kind,
        Shape::Spline(_) => "SPLINE",
        Shape::Insert(_) => "INSERT",
        Shape::Hatch(_) => "HATCH",
        Shape::Solid(_) => "SOLID",
    })
}
