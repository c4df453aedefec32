//! Contouring jobs as text: `ok LEG;LEG;…|UNREACHED,…|PROGRESS|RECUT` or `no REASON`.
//!
//! A leg is `PASS.INDEX FROM TO X Y:MOTION,MOTION,…` with the motions on the loop and its entry, `-:…` for a way. The first
//! motion begins at a point `X Y`; each is `l X Y` to the next point or `a X Y CX CY +` around a centre, counter-clockwise or
//! `-` clockwise; all in lattice units. Progress is `FINISHED,…/PARTIAL,…`, a partial loop `PASS.INDEX X Y X Y` with its entry
//! and the last point that was cut.

use std::fmt::Write as _;

use keepout_kernel::{Arc, Curve, Point, Segment, Turn};
use keepout_planner::job::{ContourJob, Leg, LoopNumber, PartialLoop, Progress};

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
        push_number(text, index, *each);
    }
    text.push('|');
    push_progress(text, &job.before);
    let _ = write!(text, "|{:?}", job.recut_mm);
}

/// A loop's number, behind a comma unless it is the first of a list.
fn push_number(text: &mut String, index: usize, LoopNumber { pass, index: number }: LoopNumber) {
    let comma = if index > 0 { "," } else { "" };
    let _ = write!(text, "{comma}{pass}.{number}");
}

pub(super) fn push_progress(text: &mut String, progress: &Progress) {
    for (index, each) in progress.finished.iter().enumerate() {
        push_number(text, index, *each);
    }
    text.push('/');
    for (index, each) in progress.partial.iter().enumerate() {
        push_number(text, index, each.number);
        text.push(' ');
        push_point(text, each.entry);
        text.push(' ');
        push_point(text, each.cut_to);
    }
}

pub(super) fn parse_progress(text: &str) -> Option<Progress> {
    let (finished, partial) = text.split_once('/')?;
    let partial = partial.split(',').filter(|each| !each.is_empty()).map(|each| {
        let mut fields = each.split(' ');
        Some(PartialLoop {
            number: number(fields.next()?)?,
            entry: point(&mut fields)?,
            cut_to: point(&mut fields)?,
        })
    });
    Some(Progress { finished: numbers(finished)?, partial: partial.collect::<Option<_>>()? })
}

fn numbers(text: &str) -> Option<Vec<LoopNumber>> {
    text.split(',').filter(|each| !each.is_empty()).map(number).collect()
}

fn push_leg(text: &mut String, leg: &Leg) {
    match leg.cuts {
        Some(LoopNumber { pass, index }) => {
            let _ = write!(text, "{pass}.{index} {} {} ", leg.on_loop.start, leg.on_loop.end);
            push_point(text, leg.entry.unwrap_or(Point::ORIGIN));
        }
        None => text.push('-'),
    }
    text.push(':');
    if let Some(first) = leg.curves.first() {
        push_point(text, first.from());
    }
    for curve in &leg.curves {
        text.push(',');
        push_curve(text, curve);
    }
}

/// A motion without where it begins.
pub(super) fn push_curve(text: &mut String, curve: &Curve) {
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

pub(super) fn push_point(text: &mut String, point: Point) {
    let _ = write!(text, "{} {}", point.x.units(), point.y.units());
}

pub(super) fn parse(text: &str) -> Option<Result<ContourJob, String>> {
    if let Some(reason) = text.strip_prefix("no ") {
        return Some(Err(String::from_utf8(super::line::unescaped(reason)?).ok()?));
    }
    let mut fields = text.strip_prefix("ok ")?.split('|');
    let mut field = || fields.next();
    let legs = field()?.split(';').filter(|leg| !leg.is_empty()).map(leg).collect::<Option<_>>()?;
    let (unreached, before) = (numbers(field()?)?, parse_progress(field()?)?);
    let recut_mm = field()?.parse().ok()?;
    Some(Ok(ContourJob { legs, unreached, before, recut_mm, ..ContourJob::default() }))
}

fn number(text: &str) -> Option<LoopNumber> {
    let (pass, index) = text.split_once('.')?;
    Some(LoopNumber { pass: pass.parse().ok()?, index: index.parse().ok()? })
}

fn leg(text: &str) -> Option<Leg> {
    let (cuts, motions) = text.split_once(':')?;
    let mut fields = cuts.split(' ');
    let cuts = fields.next()?;
    let cuts = if cuts == "-" { None } else { Some(number(cuts)?) };
    let (on_loop, entry) = match cuts {
        Some(_) => (fields.next()?.parse().ok()?..fields.next()?.parse().ok()?, Some(point(&mut fields)?)),
        None => (0..0, None),
    };
    let mut motions = motions.split(',');
    let mut from = point(&mut motions.next()?.split(' '))?;
    let mut curves = Vec::new();
    for motion in motions {
        let curve = curve(from, motion)?;
        from = curve.to();
        curves.push(curve);
    }
    Some(Leg { cuts, curves, on_loop, entry })
}

pub(super) fn curve(from: Point, text: &str) -> Option<Curve> {
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

pub(super) fn point<'a>(fields: &mut impl Iterator<Item = &'a str>) -> Option<Point> {
    let mut number = || fields.next()?.parse::<i64>().ok();
    Point::from_units(number()?, number()?).ok()
}
