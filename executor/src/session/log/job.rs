//! Contouring jobs as text: `ok LEG;LEG;…|UNREACHED,…|TANGENTIAL|PROGRESS|RECUT` or `no REASON`.
//!
//! A leg is `PASS.INDEX FROM TO X Y:MOTION,MOTION,…` with the motions on the loop and its entry (`-` when there is none),
//! `-:…` for a way. Each motion is `l X Y` to the next point or `a X Y CX CY +` around a centre, counter-clockwise or `-`
//! clockwise; `m X Y` says where the next begins, when that is not where the one before ends; all in lattice units. Progress is `FINISHED,…/PARTIAL,…`, a partial loop `PASS.INDEX X Y X Y` with its entry
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
    let _ = write!(text, "|{}|", job.tangential);
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
        push_point(text, each.resume_point);
    }
}

pub(super) fn parse_progress(text: &str) -> Option<Progress> {
    let (finished, partial) = text.split_once('/')?;
    let partial = partial.split(',').filter(|each| !each.is_empty()).map(|each| {
        let mut fields = each.split(' ');
        Some(PartialLoop {
            number: number(fields.next()?)?,
            entry: point(&mut fields)?,
            resume_point: point(&mut fields)?,
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
            match leg.entry {
                Some(entry) => push_point(text, entry),
                None => text.push('-'),
            }
        }
        None => text.push('-'),
    }
    text.push(':');
    let mut at = None;
    for (index, curve) in leg.curves.iter().enumerate() {
        text.push_str(if index > 0 { "," } else { "" });
        if at != Some(curve.from()) {
            text.push_str("m ");
            push_point(text, curve.from());
            text.push(',');
        }
        push_curve(text, curve);
        at = Some(curve.to());
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
            text.push_str(if arc.turn() == Turn::CounterClockwise { " +" } else { " -" });
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
    let unreached = numbers(field()?)?;
    let tangential = field()?.parse().ok()?;
    let before = parse_progress(field()?)?;
    let recut_mm = field()?.parse().ok()?;
    Some(Ok(ContourJob { legs, unreached, tangential, before, recut_mm }))
}

fn number(text: &str) -> Option<LoopNumber> {
    let (pass, index) = text.split_once('.')?;
    Some(LoopNumber { pass: pass.parse().ok()?, index: index.parse().ok()? })
}

fn leg(text: &str) -> Option<Leg> {
    let (cuts, motions) = text.split_once(':')?;
    let mut fields = cuts.split(' ').peekable();
    let cuts = fields.next()?;
    let cuts = if cuts == "-" { None } else { Some(number(cuts)?) };
    let (on_loop, entry) = match cuts {
        Some(_) => {
            let on_loop = fields.next()?.parse().ok()?..fields.next()?.parse().ok()?;
            let none = fields.peek() == Some(&"-");
            (on_loop, if none { None } else { Some(point(&mut fields)?) })
        }
        None => (0..0, None),
    };
    let mut from = Point::ORIGIN;
    let mut curves = Vec::new();
    for motion in motions.split(',').filter(|motion| !motion.is_empty()) {
        if let Some(begins) = motion.strip_prefix("m ") {
            from = point(&mut begins.split(' '))?;
            continue;
        }
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
            let turn = if fields.next()? == "+" { Turn::CounterClockwise } else { Turn::Clockwise };
            Arc::new(from, to, centre, turn).ok().map(Curve::Arc)
        }
        _ => None,
    }
}

pub(super) fn point<'a>(fields: &mut impl Iterator<Item = &'a str>) -> Option<Point> {
    let mut number = || fields.next()?.parse::<i64>().ok();
    Point::from_units(number()?, number()?).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(random: &mut fastrand::Rng) -> Point {
        let mut units = || random.i64(-(1 << 28)..1 << 28);
        Point::from_units(units(), units()).unwrap()
    }

    fn numbered(random: &mut fastrand::Rng) -> LoopNumber {
        LoopNumber { pass: random.usize(0..3), index: random.usize(0..1000) }
    }

    /// A motion from `from`: a line, or a quarter of a circle either way round.
    fn motion(from: Point, random: &mut fastrand::Rng) -> Curve {
        let r = random.i64(1..1 << 20);
        let (x, y) = (i64::from(from.x.units()), i64::from(from.y.units()));
        let at = |dx: i64, dy: i64| Point::from_units(x + dx, y + dy).unwrap();
        match random.u8(0..3) {
            0 => Curve::Line(Segment { from, to: place(random) }),
            1 => Curve::Arc(Arc::new(from, at(-r, r), at(-r, 0), Turn::CounterClockwise).unwrap()),
            _ => Curve::Arc(Arc::new(from, at(r, -r), at(0, -r), Turn::Clockwise).unwrap()),
        }
    }

    fn any_leg(random: &mut fastrand::Rng) -> Leg {
        let mut at = place(random);
        let mut curves = Vec::new();
        for _ in 0..random.usize(0..6) {
            // Now and then one begins elsewhere, as it must not.
            at = if random.u8(0..8) == 0 { place(random) } else { at };
            let curve = motion(at, random);
            at = curve.to();
            curves.push(curve);
        }
        let cuts = random.bool().then(|| numbered(random));
        let (first, last) = (random.usize(0..9), random.usize(0..9));
        Leg {
            cuts,
            curves,
            on_loop: if cuts.is_some() { first..last } else { 0..0 },
            entry: cuts.and_then(|_| (random.u8(0..4) > 0).then(|| place(random))),
        }
    }

    fn any_job(random: &mut fastrand::Rng) -> ContourJob {
        let several = |random: &mut fastrand::Rng| vec![(); random.usize(0..4)];
        let numbers = |random: &mut fastrand::Rng| -> Vec<LoopNumber> {
            several(random).iter().map(|()| numbered(random)).collect()
        };
        let partial = several(random).into_iter().map(|()| PartialLoop {
            number: numbered(random),
            entry: place(random),
            resume_point: place(random),
        });
        let partial = partial.collect();
        ContourJob {
            legs: several(random).iter().map(|()| any_leg(random)).collect(),
            unreached: numbers(random),
            tangential: random.usize(..),
            before: Progress { finished: numbers(random), partial },
            recut_mm: f64::from_bits(random.u64(..) & !(1 << 62)),
        }
    }

    #[test]
    fn jobs_are_read_as_they_were_written() {
        let mut random = fastrand::Rng::with_seed(3);
        let mut text = String::new();
        for round in 0..20_000 {
            let job = Ok(any_job(&mut random));
            text.clear();
            push(&mut text, &job);
            assert_eq!(parse(&text), Some(job), "round {round}: {text}");
            assert!(!text.contains(['\t', '\n']), "{text}");
        }
        for reason in ["", "no way", "a\tb\nc \\x20 {é} |;,:", "\u{1f600}"] {
            text.clear();
            let job = Err(reason.to_string());
            push(&mut text, &job);
            assert_eq!(parse(&text), Some(job), "{text}");
        }
    }

    #[test]
    fn reading_is_total() {
        let mut random = fastrand::Rng::with_seed(4);
        for _ in 0..20_000 {
            let mut text = String::new();
            push(&mut text, &Ok(any_job(&mut random)));
            let mut bytes = text.into_bytes();
            for _ in 0..random.usize(1..4) {
                let index = random.usize(0..bytes.len());
                bytes[index] = b"0123456789-,;:|/ malok.+"[random.usize(0..24)];
            }
            let _ = parse(std::str::from_utf8(&bytes).unwrap());
        }
    }
}
