//! Structured drawings: outlines of many shapes, with the faults of real files, and a plan request for
//! them.

mod shape;
mod spoil;
mod truth;
mod write;

use arbitrary::{Arbitrary, Result, Unstructured};
use keepout_planner::Mm2;
use keepout_planner::plan::{Cut, PassParameters, PlanParameters};
use keepout_planner::profile::MachinedSide;
use keepout_planner::request::PlanRequest;
pub use shape::{OutlineShape, SketchOutline};
pub use spoil::OutlineFault;

use crate::import;

/// The layer of clamps.
const ZONES: &str = "CLAMPS";
/// Largest number of outlines of a drawing.
const OUTLINES_MAX: u32 = 4;

/// A drawing and a plan request for it.
#[derive(Clone, Debug, PartialEq)]
pub struct Sketch {
    /// The value of `$INSUNITS`, when it is stated.
    pub units: Option<u8>,
    /// The outlines.
    pub outlines: Vec<SketchFigure>,
    /// The plan request.
    pub order: PlanRequest,
}

/// An outline, its faults, and its form in the file.
#[derive(Clone, Debug, PartialEq)]
pub struct SketchFigure {
    /// The outline without faults.
    pub outline: SketchOutline,
    /// Its faults: family, place and size.
    pub spoilt: Vec<(OutlineFault, u8, f64)>,
    /// Separate entities for the edges, in another order, some backwards. Otherwise one polyline.
    pub loose: bool,
    /// Blocks around it.
    pub nest: Vec<Nest>,
    /// The outline is a clamp and not the part.
    pub zone: bool,
}

/// A block insertion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nest {
    /// The insertion point.
    pub at: (f64, f64),
    /// Scale along x and y; negative ones mirror.
    pub scale: (f64, f64),
    /// Rotation, degrees.
    pub degrees: f64,
    /// Columns and rows of an array, and their spacing.
    pub array: (u8, u8, f64),
}

impl Sketch {
    /// The drawing as DXF text.
    #[must_use]
    pub fn dxf(&self) -> String {
        write::dxf(self)
    }

    /// The families of its faults.
    pub fn families(&self) -> impl Iterator<Item = OutlineFault> + '_ {
        let nested = self.outlines.iter().any(|figure| !figure.nest.is_empty());
        let spoilt = self.outlines.iter().flat_map(|figure| figure.spoilt.iter().map(|each| each.0));
        spoilt.chain(nested.then_some(OutlineFault::Blocks))
    }
}

/// Reads a structured drawing and a plan request from any bytes. The result is a typed error, or contours
/// at the places where they were drawn, and a plan whose certificates hold.
///
/// # Panics
/// As [`import::dxf_import`], and when a curve lies elsewhere than it was drawn.
pub fn drawing(bytes: &[u8]) {
    let Ok(sketch) = Sketch::arbitrary(&mut Unstructured::new(bytes)) else { return };
    let dxf = sketch.dxf();
    let drawn = keepout_planner::drawing::import(dxf.as_bytes(), &sketch.order.choice);
    // Copies of long splines at the finest `--curve-mm` become hundreds of thousands of edges.
    if drawn.is_ok_and(|drawn| drawn.curves.len() > import::CURVES_MAX) {
        return;
    }
    if let Some((part, zones)) = import::check_request(dxf.as_bytes(), &sketch.order) {
        truth::compare(&sketch, false, &part);
        truth::compare(&sketch, true, &zones);
    }
}

impl<'a> Arbitrary<'a> for Sketch {
    fn arbitrary(u: &mut Unstructured<'a>) -> Result<Self> {
        let units = *u.choose(&[Some(4), Some(4), Some(4), None, Some(1), Some(6), Some(20)])?;
        let count = u.int_in_range(1..=OUTLINES_MAX)?;
        let mut order = order(u)?;
        let mut outlines = (0..count).map(|_| SketchFigure::arbitrary(u)).collect::<Result<Vec<_>>>()?;
        // Read last, so that older inputs keep their meaning.
        for figure in &mut outlines {
            figure.zone = u.int_in_range(0..=7_u8)? == 7;
        }
        order.keep_out_layers.extend(outlines.iter().any(|figure| figure.zone).then(|| ZONES.into()));
        order.job.margin_mm = *u.choose(&[None, None, None, Some(0.02), Some(1.0), Some(0.0005)])?;
        Ok(Self { units, outlines, order })
    }
}

impl<'a> Arbitrary<'a> for SketchFigure {
    fn arbitrary(u: &mut Unstructured<'a>) -> Result<Self> {
        let (loose, wrong) = (bool::arbitrary(u)?, u.int_in_range(0..=3_u8)?);
        let depth = *u.choose(&[0, 0, 0, 0, 1, 1, 2, 3])?;
        let outline = SketchOutline::arbitrary(u)?;
        let spoilt = (0..wrong)
            .map(|_| Ok((*u.choose(&OutlineFault::OF_OUTLINES)?, u8::arbitrary(u)?, number(u)?)))
            .collect::<Result<_>>()?;
        let nest = (0..depth).map(|_| Nest::arbitrary(u)).collect::<Result<_>>()?;
        Ok(Self { outline, spoilt, loose, nest, zone: false })
    }
}

impl<'a> Arbitrary<'a> for Nest {
    fn arbitrary(u: &mut Unstructured<'a>) -> Result<Self> {
        const SCALES: [f64; 8] = [1.0, -1.0, 2.0, 0.5, -0.1, 1e-4, 1e3, 0.0];
        const DEGREES: [f64; 6] = [0.0, 90.0, 180.0, 30.0, 45.000_000_1, -720.0];
        let x = *u.choose(&SCALES)?;
        let y = if bool::arbitrary(u)? { x } else { *u.choose(&SCALES)? };
        let array = (*u.choose(&[0, 1, 1, 2])?, *u.choose(&[0, 1, 1, 3])?, number(u)?);
        Ok(Self { at: (number(u)?, number(u)?), scale: (x, y), degrees: *u.choose(&DEGREES)?, array })
    }
}

/// A number as in drawings: mostly of a part's size and with few digits, sometimes any number.
pub(crate) fn number(u: &mut Unstructured<'_>) -> Result<f64> {
    const SIZES: [f64; 8] = [1.0, 0.01, 0.01, 0.1, 0.001, 1e-6, 100.0, 1e-9];
    let kind = u.int_in_range(0..=15_u8)?;
    Ok(match kind {
        0 => f64::arbitrary(u)?,
        1 => *u.choose(&[0.0, -0.0, 5_368.709_12, -5_368.709_13, 1e-5, 5e-6, 0.01, 1e9, f64::EPSILON])?,
        _ => f64::from(i16::arbitrary(u)?) * SIZES[usize::from(kind) % SIZES.len()],
    })
}

fn order(u: &mut Unstructured<'_>) -> Result<PlanRequest> {
    let passes = match u.int_in_range(0..=5_u8)? {
        0 => vec![(0.1, Some(900)), (0.0, None)],
        1 => vec![(0.2, None), (0.1, None), (0.0, Some(60))],
        _ => vec![],
    };
    let pass = |(stock_to_leave_mm, feed_mm_min)| PassParameters { stock_to_leave_mm, feed_mm_min };
    let job = PlanParameters {
        tool_diameter_mm: *u.choose(&[6.0, 3.0, 0.5, 0.1, 0.01, 20.0, 80.0, 500.0])?,
        stock_to_leave_mm: *u.choose(&[0.2, 0.0, 1.0, 0.01])?,
        side: if bool::arbitrary(u)? { MachinedSide::Inside } else { MachinedSide::Outside },
        passes: passes.into_iter().map(pass).collect(),
        cut: if bool::arbitrary(u)? { Cut::Climb } else { Cut::Conventional },
        ..PlanParameters::default()
    };
    let mut order = PlanRequest { job, ..PlanRequest::default() };
    order.join_mm = *u.choose(&[0.01, 0.01, 0.0, 0.5, 0.001])?;
    order.curve_mm = *u.choose(&[0.001, 0.01, 0.0001, 1.0])?;
    if u.int_in_range(0..=7_u8)? == 0 {
        order.choice.placed = Some((number(u)?, Mm2::new(number(u)?, number(u)?)));
    }
    Ok(order)
}
