//! Inputs of the operator, and events that a controller or a port can cause, from any bytes.

use arbitrary::{Arbitrary, Result, Unstructured};
use keepout_executor::supervisor::{
    Event, Limits, Mode, OperatorCommand, OperatorInput, Reply, Report, Unfit, text,
};
use keepout_kernel::{Curve, Height, Point, Segment, Vector};
use keepout_planner::Mm2;
use keepout_planner::job::{ContourJob, JobError};

/// Greatest number of a contour that the operator crosses to. The plate has two.
const CONTOURS: usize = 3;

/// An input of the operator, and perhaps a command. With `depths` they move the third axis, too.
pub fn input(depths: bool, u: &mut Unstructured<'_>) -> Result<(OperatorInput, Option<OperatorCommand>)> {
    // No stick or wheel gives the values at the ends of the range.
    let share = |u: &mut Unstructured<'_>| {
        Ok(match i8::arbitrary(u)? {
            i8::MIN => f64::NAN,
            -127 => f64::NEG_INFINITY,
            126 => 1e308,
            i8::MAX => f64::INFINITY,
            usual => f64::from(usual) / 100.0,
        })
    };
    let velocity = Mm2::new(share(u)?, share(u)?);
    let turned_mm = if u.int_in_range(0..=7_u8)? == 0 { Mm2::new(share(u)?, share(u)?) } else { Mm2::ZERO };
    let command = match u.int_in_range(0..=31_u8)? {
        0 => Some(OperatorCommand::FeedHold),
        1 | 2 => Some(OperatorCommand::CycleStart),
        3 => Some(OperatorCommand::Recover),
        4 => Some(OperatorCommand::Stop),
        5 => Some(OperatorCommand::Feed { percent: 30 }),
        6 => Some(OperatorCommand::Feed { percent: u8::MAX }),
        _ => None,
    };
    let armed = u.int_in_range(0..=2_u8)? == 0;
    let input = OperatorInput { velocity, turned_mm, armed, ..OperatorInput::default() };
    if !depths {
        return Ok((input, command));
    }
    let (up, turned_up_mm) = match u.int_in_range(0..=3_u8)? {
        0 => (share(u)?, 0.0),
        1 => (0.0, share(u)?),
        _ => (0.0, 0.0),
    };
    // A lift begins after the motion in the plane has ended, so it often comes alone.
    let velocity = if up != 0.0 && bool::arbitrary(u)? { Mm2::ZERO } else { velocity };
    let command = match u.int_in_range(0..=15_u8)? {
        0 => Some(OperatorCommand::Raise),
        1 | 2 => Some(OperatorCommand::Cross { contour: u.int_in_range(0..=CONTOURS)? }),
        3..=5 => Some(OperatorCommand::Spindle { runs: bool::arbitrary(u)? }),
        _ => command,
    };
    Ok((OperatorInput { velocity, up, turned_up_mm, ..input }, command))
}

/// Changes a contour job: an error, a motion to another place or height, a motion left out, or no change.
pub fn forge(job: &mut std::result::Result<ContourJob, JobError>, u: &mut Unstructured<'_>) -> Result<()> {
    let what = u.int_in_range(0..=7_u8)?;
    let Ok(legs) = job.as_mut().map(|job| &mut job.legs) else { return Ok(()) };
    let which = if legs.is_empty() { 0 } else { u.choose_index(legs.len())? };
    let Some(leg) = legs.get_mut(which).filter(|leg| !leg.curves.is_empty()) else { return Ok(()) };
    let (curves, heights) = (&mut leg.curves, &mut leg.heights);
    let at = u.choose_index(curves.len())?;
    match what {
        0 => *job = Err(JobError::Failed),
        1 => drop(curves.remove(at)),
        2 => curves.swap(0, at),
        3 | 4 => {
            let from = curves[at].from();
            let (dx, dy) = (i32::from(i16::arbitrary(u)?) << 6, i32::from(i16::arbitrary(u)?) << 6);
            let Ok(to) = from.translated(Vector { dx, dy }) else { return Ok(()) };
            curves[at] = Curve::Line(Segment { from, to });
            // The following motions go on from there, or are left out.
            if what == 3 {
                curves.truncate(at + 1);
            }
        }
        5 | 6 if !heights.is_empty() => {
            let at = u.choose_index(heights.len())?;
            let by = i64::from(i16::arbitrary(u)?) << 5;
            heights[at] = Height::from_units(i64::from(heights[at].units()) + by).unwrap_or(heights[at]);
        }
        _ => {}
    }
    Ok(())
}

/// Any event that a controller's reply or the port can cause.
pub fn false_event(depths: bool, u: &mut Unstructured<'_>) -> Result<Event> {
    const MODES: [Mode; 7] =
        [Mode::Idle, Mode::Moving, Mode::Slowing, Mode::Held, Mode::Homing, Mode::Alarm, Mode::Other];
    let reply = match u.int_in_range(0..=39_u8)? {
        36 => Reply::NotHomed,
        37 => Reply::Displaced,
        38 => Reply::Unfit(Unfit { name: "$32", value: 1.0, needed: "0" }),
        39 => Reply::Message(text("a message")),
        0..=8 | 20..=28 => {
            let place = (i64::from(i32::arbitrary(u)? >> 6), i64::from(i32::arbitrary(u)? >> 6));
            let height = if depths { i64::from(i32::arbitrary(u)? >> 11) } else { 0 };
            let height = Height::from_units(height).unwrap_or(Height::ZERO);
            let position = Point::from_units(place.0, place.1).ok().map(|point| point.at_height(height));
            Reply::Report(Report {
                mode: *u.choose(&MODES)?,
                position: position.filter(|_| u.int_in_range(0..=7_u8).is_ok_and(|chosen| chosen > 0)),
                queued: Option::<u8>::arbitrary(u)?.map(usize::from),
                waiting: Option::<bool>::arbitrary(u)?,
            })
        }
        9 | 10 | 29 | 30 => Reply::Accepted,
        11 | 31 => Reply::Refused { code: 8, meaning: "", transient: bool::arbitrary(u)? },
        12 | 32 => Reply::Restarted,
        13 | 33 => Reply::Alarm { code: 1, meaning: "" },
        14 | 34 => Reply::Homed,
        15 | 35 => Reply::Armed,
        16 => Reply::Prepared(Limits::of(f64::from(u8::arbitrary(u)?), f64::from(u8::arbitrary(u)?))),
        17 if depths && bool::arbitrary(u)? => Reply::SpindleSwitched,
        17 => Reply::Garbled(text("?")),
        18 => return Ok(Event::PortLost(text("pulled"))),
        _ => return Ok(Event::PortFound),
    };
    Ok(Event::Reply(reply))
}
