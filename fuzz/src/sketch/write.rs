//! A structured drawing as DXF text.

use std::fmt::Write as _;

use super::shape::{Corner, SketchOutline};
use super::spoil::{Spoilt, SpoiltEdge, spoilt};
use super::{Nest, Sketch, SketchFigure, ZONES};

/// The drawing. An outline in blocks has a block of its own for each level.
pub fn dxf(sketch: &Sketch) -> String {
    let mut text = String::from("0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1015\n");
    if let Some(units) = sketch.units {
        let _ = write!(text, "9\n$INSUNITS\n70\n{units}\n");
    }
    text.push_str("0\nENDSEC\n0\nSECTION\n2\nBLOCKS\n");
    for (number, figure) in sketch.outlines.iter().enumerate() {
        for level in 0..figure.nest.len() {
            let _ = write!(text, "0\nBLOCK\n8\n0\n2\nB{number}_{level}\n70\n0\n10\n0\n20\n0\n");
            match level.checked_sub(1) {
                None => entities(figure, &mut text),
                Some(below) => insert(&figure.nest[below], &format!("B{number}_{below}"), &mut text),
            }
            text.push_str("0\nENDBLK\n8\n0\n");
        }
    }
    text.push_str("0\nENDSEC\n0\nSECTION\n2\nENTITIES\n");
    for (number, figure) in sketch.outlines.iter().enumerate() {
        match figure.nest.len().checked_sub(1) {
            None => entities(figure, &mut text),
            Some(top) => insert(&figure.nest[top], &format!("B{number}_{top}"), &mut text),
        }
    }
    text.push_str("0\nENDSEC\n0\nEOF\n");
    text
}

fn insert(nest: &Nest, name: &str, text: &mut String) {
    let Nest { at, scale, degrees, array: (columns, rows, spacing) } = nest;
    let _ = write!(
        text,
        "0\nINSERT\n8\n0\n2\n{name}\n10\n{:?}\n20\n{:?}\n41\n{:?}\n42\n{:?}\n",
        at.0, at.1, scale.0, scale.1
    );
    let _ = write!(text, "50\n{degrees:?}\n70\n{columns}\n71\n{rows}\n44\n{spacing:?}\n45\n{spacing:?}\n");
}

fn entities(figure: &SketchFigure, text: &mut String) {
    let layer = if figure.zone { ZONES } else { "0" };
    match spoilt(&figure.outline, &figure.spoilt) {
        Spoilt::Edges(edges) if figure.loose => {
            // The edges are out of order, and not all in one direction.
            let count = edges.len();
            let step = if count.is_multiple_of(7) { 1 } else { 7 };
            (0..count).for_each(|k| single(&edges[k * step % count], layer, text));
        }
        Spoilt::Edges(edges) => polylines(&edges, layer, text),
        Spoilt::Whole(outline, often) => (0..often).for_each(|_| whole(&outline, layer, text)),
    }
}

/// A line or an arc as a separate entity. A line runs toward greater x, and an arc counter-clockwise, so
/// some edges run backwards.
fn single(edge: &SpoiltEdge, layer: &str, text: &mut String) {
    let (a, b) = (edge.from.at, edge.to);
    if edge.from.bulge == 0.0 {
        let (a, b) = if a.0 < b.0 { (a, b) } else { (b, a) };
        let _ =
            write!(text, "0\nLINE\n8\n{layer}\n10\n{:?}\n20\n{:?}\n11\n{:?}\n21\n{:?}\n", a.0, a.1, b.0, b.1);
        return;
    }
    let bulge = edge.from.bulge;
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let off = (1.0 - bulge * bulge) / (4.0 * bulge);
    let centre = (f64::midpoint(a.0, b.0) - dy * off, f64::midpoint(a.1, b.1) + dx * off);
    let degrees = |p: (f64, f64)| (p.1 - centre.1).atan2(p.0 - centre.0).to_degrees();
    let (start, end) = if bulge > 0.0 { (degrees(a), degrees(b)) } else { (degrees(b), degrees(a)) };
    let radius = (a.0 - centre.0).hypot(a.1 - centre.1);
    arc(centre, radius, Some((start, end)), layer, text);
}

fn arc(centre: (f64, f64), radius: f64, range: Option<(f64, f64)>, layer: &str, text: &mut String) {
    let name = if range.is_some() { "ARC" } else { "CIRCLE" };
    let _ = write!(text, "0\n{name}\n8\n{layer}\n10\n{:?}\n20\n{:?}\n40\n{radius:?}\n", centre.0, centre.1);
    if let Some((start, end)) = range {
        let _ = write!(text, "50\n{start:?}\n51\n{end:?}\n");
    }
}

/// Writes runs of connected edges as polylines. A run with an even number of edges becomes an LWPOLYLINE,
/// any other run a POLYLINE.
fn polylines(edges: &[SpoiltEdge], layer: &str, text: &mut String) {
    for run in edges.chunk_by(|one, next| one.to == next.from.at) {
        let closed = run.last().map(|last| last.to) == run.first().map(|first| first.from.at);
        let end = run.last().map(|last| Corner { at: last.to, bulge: 0.0 });
        let corners: Vec<Corner> = run.iter().map(|edge| edge.from).chain(end.filter(|_| !closed)).collect();
        let _ = if run.len().is_multiple_of(2) {
            write!(text, "0\nLWPOLYLINE\n8\n{layer}\n90\n{}\n70\n{}\n", corners.len(), u8::from(closed))
        } else {
            write!(text, "0\nPOLYLINE\n8\n{layer}\n66\n1\n70\n{}\n", u8::from(closed))
        };
        for Corner { at, bulge } in corners {
            if !run.len().is_multiple_of(2) {
                text.push_str("0\nVERTEX\n8\n0\n");
            }
            let _ = write!(text, "10\n{:?}\n20\n{:?}\n42\n{bulge:?}\n", at.0, at.1);
        }
        if !run.len().is_multiple_of(2) {
            text.push_str("0\nSEQEND\n8\n0\n");
        }
    }
}

fn whole(outline: &SketchOutline, layer: &str, text: &mut String) {
    match outline {
        SketchOutline::Corners(_) => {}
        SketchOutline::Round { centre, axis, range, circle: true, .. } => {
            let full = (range.1 - range.0 - std::f64::consts::TAU).abs() < 1e-12;
            let degrees = (range.0.to_degrees(), range.1.to_degrees());
            arc(*centre, axis.0, (!full).then_some(degrees), layer, text);
        }
        SketchOutline::Round { centre, axis, ratio, range, .. } => {
            let _ = write!(
                text,
                "0\nELLIPSE\n8\n{layer}\n10\n{:?}\n20\n{:?}\n11\n{:?}\n21\n{:?}\n",
                centre.0, centre.1, axis.0, axis.1
            );
            let _ = write!(text, "40\n{ratio:?}\n41\n{:?}\n42\n{:?}\n", range.0, range.1);
        }
        SketchOutline::Spline { degree, knots, points, weights } => {
            let (k, p) = (knots.len(), points.len());
            let _ = write!(text, "0\nSPLINE\n8\n{layer}\n70\n0\n71\n{degree}\n72\n{k}\n73\n{p}\n74\n0\n");
            knots.iter().for_each(|knot| _ = write!(text, "40\n{knot:?}\n"));
            weights.iter().for_each(|weight| _ = write!(text, "41\n{weight:?}\n"));
            points.iter().for_each(|(x, y)| _ = write!(text, "10\n{x:?}\n20\n{y:?}\n"));
        }
    }
}
