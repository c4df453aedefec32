//! Contouring jobs as text: `ok LEG;LEG;…|UNREACHED,…` or `no REASON`.
//!
//! A leg is `PASS.INDEX:MOTION,MOTION,…`, `-:…` for a way. The first motion begins at a point `X Y`; each is `l X Y` to the
//! next point or `a X Y CX CY +` around a centre, counter-clockwise or `-` clockwise; all in lattice units.

use std::fmt::Write as _;

use keepout_kernel::{Arc, Curve, Point, Segment, Turn};
use keepout_planner::job::{ContourJob, Leg, LoopNumber};

pub(super) fn push(text: &mut String, job: &Result<ContourJob, String>) {
    let job = match job {
        Ok(job) => job,
        Err(reason) => {
            let _ = write!(text, "no {}", reason.escape_default());
            return;
        }
    };
    text.push_str("ok ");
    for (index, leg) in job.legs.iter().enumerate() {
        if index > 0 {
            text.push(';');
        }
        push_leg(text, leg);
    }
    text.push('|');
    for (index, each) in job.unreached.iter().enumerate() {
        let comma = if index > 0 { "," } else { "" };
        let _ = write!(text, "{comma}{}.{}", each.pass, each.index);
    }
}

fn push_leg(text: &mut String, leg: &Leg) {
    match leg.cuts {
        Some(LoopNumber { pass, index }) => {
            let _ = write!(text, "{pass}.{index}:");
        }
        None => text.push_str("-:"),
    }
    if let Some(first) = leg.curves.first() {
        push_point(text, first.from());
    }
    for curve in &leg.curves {
        text.push(',');
        match curve {
            Curve::Line(line) => {
                text.push_str("l ");
                push_point(text, line.to);
            }
            Curve::Arc(arc) => {
                text.push_str("a ");
                push_point(text, arc.to());
                text.push(' ');
                push_point(text, arc.centre());
                text.push_str(if arc.turn() == Turn::Left { " +" } else { " -" });
            }
        }
    }
}

fn push_point(text: &mut String, point: Point) {
    let _ = write!(text, "{} {}", point.x.units(), point.y.units());
}

pub(super) fn parse(text: &str) -> Option<Result<ContourJob, String>> {
    if let Some(reason) = text.strip_prefix("no ") {
        return Some(Err(String::from_utf8(super::line::unescaped(reason)?).ok()?));
    }
    let (legs, unreached) = text.strip_prefix("ok ")?.split_once('|')?;
    let legs = legs.split(';').filter(|leg| !leg.is_empty()).map(leg).collect::<Option<_>>()?;
    let unreached =
        unreached.split(',').filter(|each| !each.is_empty()).map(number).collect::<Option<_>>()?;
    Some(Ok(ContourJob { legs, unreached, ..ContourJob::default() }))
}

fn number(text: &str) -> Option<LoopNumber> {
    let (pass, index) = text.split_once('.')?;
    Some(LoopNumber { pass: pass.parse().ok()?, index: index.parse().ok()? })
}

fn leg(text: &str) -> Option<Leg> {
    let (cuts, motions) = text.split_once(':')?;
    let cuts = if cuts == "-" { None } else { Some(number(cuts)?) };
    let mut motions = motions.split(',');
    let mut from = point(&mut motions.next()?.split(' '))?;
    let mut curves = Vec::new();
    for motion in motions {
        let curve = curve(from, motion)?;
        from = curve.to();
        curves.push(curve);
    }
    Some(Leg { cuts, curves })
}

fn curve(from: Point, text: &str) -> Option<Curve> {
    let mut fields = text.split(' ');
    let kind = fields.next()?;
    let to = point(&mut fields)?;
    match kind {
        "l" => Some(Curve::Line(Segment { from, to })),
        "a" => {
            let centre = point(&mut fields)?;
            let turn = if fields.next()? == "+" { Turn::Left } else { Turn::Right };
            Arc::new(from, to, centre, turn).ok().map(Curve::Arc)
        }
        _ => None,
    }
}

fn point<'a>(fields: &mut impl Iterator<Item = &'a str>) -> Option<Point> {
    let mut number = || fields.next()?.parse::<i64>().ok();
    Point::from_units(number()?, number()?).ok()
}
