//! Touch-off in the program: the operator jogs to places that the drawing shows, and takes them. The program reads the
//! machine's own position.
//!
//! The place of the part is unknown meanwhile, so nothing is protected. The session's plan is a small square far beyond
//! the machine's travel: the guard keeps the tool within the travel, and the speed is low.

use std::io::IsTerminal;
use std::time::Duration;

use clap::ValueEnum;
use keepout_executor::dialect::{DialectConfig, DialectName};
use keepout_executor::operator::Panel;
use keepout_executor::session::serial::Serial;
use keepout_executor::session::{Going, NoEventLog, RealClock, SessionSetup};
use keepout_executor::supervisor::{Options, Phase, PreparedPlan, Supervisor};
use keepout_guard::Time;
use keepout_kernel::exact::segment::Window;
use keepout_kernel::{Curve, Vector};
use keepout_planner::Mm2;
use keepout_planner::align::ProbePoint;
use keepout_planner::contour::{ContourName, ContourShape};
use keepout_planner::machine::MachineProfile;
use keepout_planner::profile::{MachinedSide, Profile, ProfileLoop};
use keepout_planner::request::PlanRequest;
use keepout_planner::units::{along_mm, point_from_mm, point_mm};

use super::CliError;
use super::shown_unit::ShownUnit;
use super::store::StoredMachine;
use crate::input::Keyboard;

/// Places that the operator touches.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum TakeMethod {
    /// Two touches of one straight edge, and one of another: offset and rotation.
    Edges,
    /// The tool's centre on two points of the drawing: offset and rotation.
    Points,
    /// Three touches of the wall of one or two round holes: their centres give offset and rotation.
    Hole,
}

/// Fastest jog while the place of the part is unknown, mm/s.
const SPEED_MM_S: f64 = 10.0;
/// Place of the session's square, beyond every travel, mm.
const BEYOND_MM: f64 = 5200.0;
/// Least angle between two edges that measure both axes, degrees.
const ACROSS_DEG: f64 = 30.0;
/// Least angle between two curves at a corner, degrees.
const CORNER_DEG: f64 = 15.0;
/// Touches of a hole's wall.
const TOUCHES: usize = 3;
/// Longest time from the take key until the tool rests at a known position.
const SETTLES_WITHIN: Duration = Duration::from_millis(500);
/// Time between two lines with the position.
const SHOWN_EVERY: Duration = Duration::from_millis(100);

/// A place to touch.
struct Place {
    /// Text for the operator.
    words: String,
    drawing_mm: Mm2,
}

/// The places that the operator took.
#[derive(Clone, Debug, Default)]
pub struct Taken {
    pub points: Vec<ProbePoint>,
    pub edges: Vec<ProbePoint>,
}

/// Lets the operator take places of a part. `side`: the side from which edges are touched.
pub fn take(
    method: TakeMethod,
    (profile, side): (&Profile, MachinedSide),
    machine: &StoredMachine,
    home: bool,
    unit: ShownUnit,
) -> Result<Taken, CliError> {
    if !std::io::stdin().is_terminal() {
        let reason = "the places are taken at a terminal, and the input is not a terminal. A script gives --point or \
                      --edge.";
        return Err(CliError::Argument(reason.into()));
    }
    if machine.port.is_empty() {
        let reason = "the simulated machine has no port to jog at. Give --point or --edge, or use a machine with a \
                      port: `keepout simulate` makes such a port, and `keepout machine new` stores the machine.";
        return Err(CliError::Argument(reason.into()));
    }
    let places = places(method, profile, side)?;
    eprintln!(
        "THE PLACE OF THE PART IS UNKNOWN: nothing is protected yet. The fastest jog is {}.",
        unit.speed(SPEED_MM_S)
    );
    eprintln!("s: steps · arrows: jog · 1-4: speed · t: take the place · SPACE: stop · q: give up");
    let machine_mm = jogged(&places, machine, home, unit)?;
    let each = places.iter().zip(machine_mm);
    let touches: Vec<ProbePoint> =
        each.map(|(place, machine_mm)| ProbePoint { drawing_mm: place.drawing_mm, machine_mm }).collect();
    Ok(match method {
        TakeMethod::Edges => Taken { edges: touches, ..Taken::default() },
        TakeMethod::Points => Taken { points: touches, ..Taken::default() },
        TakeMethod::Hole => {
            let centre = |touches: &[ProbePoint]| {
                let at: Vec<Mm2> = touches.iter().map(|touch| touch.machine_mm).collect();
                let centre = centre_of(at[0], at[1], at[2]).ok_or_else(|| {
                    let reason = "the three touches of a hole lie on one line. Start again, and touch places far \
                                  apart on its wall";
                    CliError::Argument(reason.into())
                })?;
                Ok::<_, CliError>(ProbePoint { drawing_mm: touches[0].drawing_mm, machine_mm: centre })
            };
            Taken {
                points: touches.chunks_exact(TOUCHES).map(centre).collect::<Result<_, _>>()?,
                ..Taken::default()
            }
        }
    })
}

/// The centre of the circle through three points.
fn centre_of(a: Mm2, b: Mm2, c: Mm2) -> Option<Mm2> {
    let (u, v) = (b - a, c - a);
    let across = 2.0 * u.cross(v);
    let (uu, vv) = (u.dot(u), v.dot(v));
    let off = Mm2::new(v.y * uu - u.y * vv, u.x * vv - v.x * uu);
    (across.abs() > 1e-9).then(|| a + off / across)
}

/// The places of the drawing for a method.
fn places(method: TakeMethod, profile: &Profile, side: MachinedSide) -> Result<Vec<Place>, CliError> {
    match method {
        TakeMethod::Edges => edges(profile),
        TakeMethod::Points => corners(profile),
        TakeMethod::Hole => holes(profile, side),
    }
}

fn edges(profile: &Profile) -> Result<Vec<Place>, CliError> {
    let curves = profile.loops.iter().flat_map(|each| &each.edges).map(|edge| edge.curve);
    let mut lines: Vec<(Mm2, Mm2)> = curves
        .filter_map(|curve| match curve {
            Curve::Line(line) => Some((point_mm(line.from), point_mm(line.to))),
            Curve::Arc(_) => None,
        })
        .collect();
    lines.sort_by(|a, b| b.0.distance(b.1).total_cmp(&a.0.distance(a.1)));
    let none = || {
        let reason =
            "the drawing has no two straight edges across each other: align by --take points or --take hole";
        CliError::Argument(reason.into())
    };
    let &(a, b) = lines.first().ok_or_else(none)?;
    let along = a.direction_to(b);
    let across =
        |line: &&(Mm2, Mm2)| along.cross(line.0.direction_to(line.1)).abs() >= ACROSS_DEG.to_radians().sin();
    let &(c, d) = lines.iter().find(across).ok_or_else(none)?;
    let place =
        |words: &str, drawing_mm: Mm2| Place { words: format!("{words} near {drawing_mm}"), drawing_mm };
    Ok(vec![
        place("touch the long edge", a + (b - a) * 0.15),
        place("touch the same edge", a + (b - a) * 0.85),
        place("touch the edge across it", c.midpoint(d)),
    ])
}

fn corners(profile: &Profile) -> Result<Vec<Place>, CliError> {
    let ends: Vec<Mm2> = profile.loops.iter().flat_map(corners_of).collect();
    let farthest =
        |from: Mm2| ends.iter().copied().max_by(|a, b| a.distance(from).total_cmp(&b.distance(from)));
    let pair = ends.first().and_then(|&first| farthest(first)).and_then(|one| Some((one, farthest(one)?)));
    let (one, other) = pair.ok_or_else(|| {
        CliError::Argument(
            "the drawing has no corner to bring the tool to: align by --take edges or --take hole".into(),
        )
    })?;
    let place = |drawing_mm: Mm2| Place {
        words: format!("bring the tool's centre to the corner at {drawing_mm}"),
        drawing_mm,
    };
    Ok(vec![place(one), place(other)])
}

/// The corners of a contour. A line that runs into an arc without a bend has none there.
fn corners_of(each: &ProfileLoop) -> Vec<Mm2> {
    let curves: Vec<Curve> = each.edges.iter().map(|edge| edge.curve).collect();
    let before = curves.iter().cycle().skip(curves.len().saturating_sub(1));
    let bends = |(before, curve): &(&Curve, &Curve)| {
        let (arrives, leaves) = (along_mm(before, 1.0).1, along_mm(curve, 0.0).1);
        arrives.cross(leaves).atan2(arrives.dot(leaves)).abs() >= CORNER_DEG.to_radians()
    };
    before.zip(&curves).filter(bends).map(|(_, curve)| point_mm(curve.from())).collect()
}

fn holes(profile: &Profile, side: MachinedSide) -> Result<Vec<Place>, CliError> {
    let round = |(number, each): (usize, &ProfileLoop)| {
        let name = ContourName::of(number + 1, each, 1, side.into(), 0.0);
        matches!(name.shape, ContourShape::Circle { .. }).then_some(name)
    };
    let holes: Vec<ContourName> = profile.loops.iter().enumerate().filter_map(round).collect();
    let first = holes.first().ok_or_else(|| {
        CliError::Argument("the drawing has no round hole: align by --take edges or --take points".into())
    })?;
    let off = |name: &&ContourName| name.middle_mm.distance(first.middle_mm);
    let other = holes.iter().max_by(|a, b| off(a).total_cmp(&off(b))).filter(|other| off(other) > 1.0);
    let each = |name: &ContourName| {
        let drawing_mm = name.middle_mm;
        let words = format!("touch the wall of the hole at {drawing_mm}, at three places far apart");
        (0..TOUCHES).map(move |_| Place { words: words.clone(), drawing_mm }).collect::<Vec<_>>()
    };
    Ok([Some(first), other].into_iter().flatten().flat_map(each).collect())
}

/// The plan of a session that protects nothing but the travel.
fn nothing_to_protect(machine: &MachineProfile) -> Result<PreparedPlan, CliError> {
    let corner = |dx: f64, dy: f64| format!("10\n{}\n20\n{}\n", BEYOND_MM + dx, BEYOND_MM + dy);
    let corners: String =
        [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0)].into_iter().map(|(x, y)| corner(x, y)).collect();
    let drawing =
        format!("0\nSECTION\n2\nENTITIES\n0\nLWPOLYLINE\n8\n0\n70\n1\n{corners}0\nENDSEC\n0\nEOF\n");
    let slow = MachineProfile { max_rate_mm_s: machine.max_rate_mm_s.min(SPEED_MM_S), ..machine.clone() };
    let mut request = PlanRequest::default();
    request.job.tool_diameter_mm = 1.0;
    let plan = request.plan("touch-off", drawing.as_bytes(), &slow, &mut |_| {});
    let plan = plan.map_err(|source| CliError::PlanRequest { path: "touch-off".into(), source })?;
    Ok(PreparedPlan::new(plan))
}

/// The machine coordinates of the places, as the operator takes them.
fn jogged(
    places: &[Place],
    machine: &StoredMachine,
    home: bool,
    unit: ShownUnit,
) -> Result<Vec<Mm2>, CliError> {
    let StoredMachine { port, dialect, baud, profile, .. } = machine;
    let dialect = DialectName::named(dialect).map_err(|error| CliError::Argument(error.to_string()))?;
    let off =
        |source: keepout_kernel::LatticeError| CliError::Argument(format!("the machine's travel: {source}"));
    let corner = point_from_mm(Mm2::new(-profile.travel_mm[0], -profile.travel_mm[1])).map_err(off)?;
    let zero = point_from_mm(Mm2::ZERO).map_err(off)?;
    let options = Options {
        feed_mm_min: 100,
        home,
        travel: Window::of(corner).including(zero),
        answer_within: Duration::from_secs(5),
        baud: *baud,
        progress: keepout_planner::job::Progress::default(),
    };
    let work = nothing_to_protect(profile)?;
    let config = DialectConfig::of(profile, Vector { dx: 0, dy: 0 });
    let setup = SessionSetup { work, options, dialect, config };
    let serial = Serial::open(port, *baud)?;
    let panel = Panel::default();
    let keyboard = Box::new(Keyboard::open(panel.clone())?);
    let mut session = setup.session(serial, keyboard, Box::new(NoEventLog));
    let mut taking = Taking {
        places,
        unit,
        panel,
        taken: Vec::new(),
        seen: 0,
        asked: None,
        told: None,
        shown: (String::new(), Time::ZERO),
    };
    let outcome = session.run(&mut RealClock::default(), Duration::from_secs(100_000), |session, now| {
        taking.watch(session.supervisor(), now)
    });
    crate::input::terminal::restore();
    eprintln!();
    let outcome = outcome?;
    if let Some(fault) = outcome.fault() {
        return Err(CliError::Stopped(fault.to_string()));
    }
    if taking.taken.len() < places.len() {
        return Err(CliError::Argument(
            "ended before every place was taken: no alignment was written. Start again.".into(),
        ));
    }
    Ok(taking.taken)
}

/// The places that are taken, and what the operator sees.
struct Taking<'a> {
    places: &'a [Place],
    unit: ShownUnit,
    panel: Panel,
    taken: Vec<Mm2>,
    /// Number of take keys that were read.
    seen: usize,
    /// Time of a take key whose place is not taken yet.
    asked: Option<Time>,
    told: Option<usize>,
    /// The last line with the position, and its time.
    shown: (String, Time),
}

impl Taking<'_> {
    fn watch(&mut self, supervisor: &Supervisor, now: Time) -> Going {
        let ready = matches!(supervisor.phase(), Phase::Manual | Phase::Sliding);
        let count = self.taken.len();
        let rests = ready && supervisor.is_at_rest() && supervisor.guard().in_position();
        if rests && self.told != Some(count) {
            self.told = Some(count);
            if let Some(place) = self.places.get(count) {
                self.line(&format!(
                    "place {} of {}: {}. Press t there.",
                    count + 1,
                    self.places.len(),
                    place.words
                ));
            }
        }
        let position = supervisor.position().map(point_mm);
        self.show(position, now);
        if self.panel.taken() > self.seen {
            self.seen = self.panel.taken();
            self.asked = Some(now);
        }
        if let Some(asked) = self.asked {
            match position.filter(|_| rests) {
                Some(at) => {
                    self.asked = None;
                    self.taken.push(at);
                    self.line(&format!(
                        "taken {} of {}: machine position {at}",
                        count + 1,
                        self.places.len()
                    ));
                }
                None if now.since(asked) < SETTLES_WITHIN => {}
                None => {
                    self.asked = None;
                    self.line(if ready {
                        "not taken: the machine moves. Let it come to rest, and press t again."
                    } else {
                        "not taken: the session is not ready. Press t when it is."
                    });
                }
            }
        }
        if self.taken.len() == self.places.len() { Going::Halt } else { Going::On }
    }

    /// Shows the position and the speed or step, in one line that is written anew while they change.
    fn show(&mut self, position: Option<Mm2>, now: Time) {
        let Some(Mm2 { x, y }) = position else { return };
        let (x, y, symbol) = (self.unit.figure(x), self.unit.figure(y), self.unit.symbol());
        let line = format!("x {x:>9}  y {y:>9} {symbol}, machine coordinates  {}", self.panel.status());
        let (last, then) = &self.shown;
        if *last != line && (last.is_empty() || now.since(*then) >= SHOWN_EVERY) {
            Self::write(&format!("{CLEARED}{line}"));
            self.shown = (line, now);
        }
    }

    /// Writes a line above the one with the position.
    fn line(&mut self, text: &str) {
        // The terminal is in raw mode.
        Self::write(&format!("{CLEARED}{text}\r\n"));
        self.shown.0.clear();
    }

    fn write(text: &str) {
        let _ = std::io::Write::write_all(&mut std::io::stderr(), text.as_bytes());
    }
}

/// Returns to the first column, and clears the line.
const CLEARED: &str = "\r\x1b[K";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn centre_of_three_touches_is_that_of_their_circle() {
        let at = |angle: f64| Mm2::new(-200.0, -150.0) + Mm2::unit(angle) * 2.0;
        let centre = centre_of(at(0.1), at(2.0), at(4.4)).unwrap();
        assert!(centre.distance(Mm2::new(-200.0, -150.0)) < 1e-9, "{centre}");
        assert!(centre_of(Mm2::ZERO, Mm2::new(1.0, 1.0), Mm2::new(2.0, 2.0)).is_none());
    }

    #[test]
    fn session_without_a_part_leaves_the_whole_travel_free() {
        let work = nothing_to_protect(&MachineProfile::simulated()).unwrap();
        for (x, y) in [(-1.0, -1.0), (-400.0, -350.0), (-200.0, -175.0)] {
            let at = point_from_mm(Mm2::new(x, y)).unwrap();
            assert!(work.part().free_point(at, work.plan.roughing).is_ok());
        }
        assert!(work.plan.plan.machine.max_rate_mm_s <= SPEED_MM_S);
    }
}
