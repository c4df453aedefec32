//! A profile as a drawing. The importer must read the same profile from it.

use std::fmt::Write as _;

use keepout_kernel::curve::sweep;
use keepout_kernel::exact::bezier::Bezier;
use keepout_kernel::{Curve, Point, Turn};
use keepout_planner::profile::{Profile, ProfileEdge, ProfileLoop};
use keepout_planner::units::mm;

/// The profile as DXF text, in millimetres with all digits. Each run of lines and arcs becomes an
/// LWPOLYLINE, closed if it is a whole loop. Each curve that edges stand for becomes a SPLINE of one
/// segment. The order is that of the loops.
#[must_use]
pub fn dxf(profile: &Profile) -> String {
    let mut text =
        String::from("0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n4\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n");
    for each in &profile.loops {
        outline(each, &mut text);
    }
    text.push_str("0\nENDSEC\n0\nEOF\n");
    text
}

/// The runs of lines and arcs between the curves that edges stand for.
pub fn runs(each: &ProfileLoop) -> impl Iterator<Item = &[ProfileEdge]> {
    let ends = each.sources.iter().map(|source| source.end);
    let begins = each.sources.iter().map(|source| source.first).chain([each.edges.len()]);
    std::iter::once(0).chain(ends).zip(begins).map(|(from, to)| &each.edges[from..to])
}

fn outline(each: &ProfileLoop, text: &mut String) {
    let mut sources = each.sources.iter();
    for run in runs(each) {
        polyline(run, each.sources.is_empty(), text);
        sources.next().into_iter().for_each(|source| spline(&source.curve, text));
    }
}

fn polyline(run: &[ProfileEdge], closed: bool, text: &mut String) {
    let Some(last) = run.last() else { return };
    let corners = run.len() + usize::from(!closed);
    let _ = write!(text, "0\nLWPOLYLINE\n8\n0\n90\n{corners}\n70\n{}\n", u8::from(closed));
    for edge in run {
        let _ = write!(text, "{}42\n{:?}\n", at(edge.curve.from()), bulge(&edge.curve));
    }
    if !closed {
        text.push_str(&at(last.curve.to()));
    }
}

fn bulge(curve: &Curve) -> f64 {
    match curve {
        Curve::Line(_) => 0.0,
        Curve::Arc(arc) => {
            let size = (sweep(arc) / 4.0).tan();
            if arc.turn() == Turn::CounterClockwise { size } else { -size }
        }
    }
}

fn spline(curve: &Bezier, text: &mut String) {
    let count = curve.control().len();
    let _ =
        write!(text, "0\nSPLINE\n8\n0\n70\n4\n71\n{}\n72\n{}\n73\n{count}\n74\n0\n", count - 1, 2 * count);
    for knot in [0, 1] {
        (0..count).for_each(|_| _ = writeln!(text, "40\n{knot}"));
    }
    for (&point, &weight) in curve.control().iter().zip(curve.weights()) {
        let _ = write!(text, "41\n{:?}\n{}", share(weight), at(point));
    }
}

/// A weight as a share of the largest, 2^40: exact.
#[expect(clippy::cast_precision_loss, reason = "weights have 41 bits")]
fn share(weight: u64) -> f64 {
    weight as f64 / (1_u64 << 40) as f64
}

/// A point with all its digits.
fn at(point: Point) -> String {
    format!("10\n{:.5}\n20\n{:.5}\n", mm(point.x.units()), mm(point.y.units()))
}
