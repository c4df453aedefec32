//! Touch-off in the program: the operator jogs to places that the drawing shows, and takes them. The program reads the
//! machine's own position.
//!
//! The place of the part is unknown meanwhile, so nothing is protected. The session's plan is a small square far beyond
//! the machine's travel: the guard keeps the tool within the travel, and the speed is low.

use std::io::IsTerminal;
use std::time::Duration;

use keepout_executor::dialect::DialectName;
use keepout_executor::operator::Panel;
use keepout_executor::session::serial::Serial;
use keepout_executor::session::{Going, NoEventLog, PlacedZ, RealClock, SessionSetup, TablePlacement};
use keepout_executor::supervisor::{Options, PreparedPlan, Supervisor};
use keepout_guard::Time;
use keepout_kernel::exact::segment::Window;
use keepout_kernel::{Height, LatticeError, Vector};
use keepout_planner::align::ProbePoint;
use keepout_planner::depth::{DepthParameters, EntryMove};
use keepout_planner::machine::{MachineProfile, ZProfile};
use keepout_planner::profile::{MachinedSide, Profile};
use keepout_planner::request::PlanRequest;
use keepout_planner::units::{height_from_mm, length_up_from_mm, point_from_mm};
use keepout_planner::{Mm2, Mm3};

use super::CliError;
use super::shown_unit::ShownUnit;
use super::store::StoredMachine;
use super::taken::{SAFE_MM, SpindleStands, TakeOutcome, TakenPlaces, on_machine, rests};
pub use super::touch_places::TakeMethod;
use super::touch_places::{TOUCHES, TouchPlace, places};
use crate::input::Keyboard;

/// Fastest jog while the place of the part is unknown, mm/s.
const SPEED_MM_S: f64 = 10.0;
/// Place of the session's square, beyond every travel, mm.
const BEYOND_MM: f64 = 5200.0;
/// Time between two lines with the position.
const SHOWN_EVERY: Duration = Duration::from_millis(100);

/// The places that the operator took.
#[derive(Clone, Debug, Default)]
pub struct Taken {
    pub points: Vec<ProbePoint>,
    pub edges: Vec<ProbePoint>,
    /// Machine coordinate of the tool's tip at the top, mm.
    pub tip_mm: Option<f64>,
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
    let climbs = climbs(machine)?;
    if method == TakeMethod::Top && !climbs {
        let reason =
            "the machine has two axes, so the height of the part is not needed: leave out --take top";
        return Err(CliError::Argument(reason.into()));
    }
    let axis = if climbs { "+ -: up, down · " } else { "" };
    eprintln!("s: steps · arrows: jog · {axis}1-4: speed · t: take the place · SPACE: stop · q: give up");
    if climbs {
        eprintln!("THE SPINDLE MUST STAND.");
    }
    let taken = jogged(&places, machine, (home, climbs), unit)?;
    touched(method, &places, &taken)
}

/// The probe points of the places that were taken for a method.
pub fn touched(method: TakeMethod, places: &[TouchPlace], taken: &[Mm3]) -> Result<Taken, CliError> {
    let each = places.iter().zip(taken);
    let touch = |(place, at): (&TouchPlace, &Mm3)| {
        Some(ProbePoint { drawing_mm: place.drawing_mm?, machine_mm: at.plane() })
    };
    let touches: Vec<ProbePoint> = each.filter_map(touch).collect();
    Ok(match method {
        TakeMethod::Top => Taken { tip_mm: taken.first().map(|at| at.z), ..Taken::default() },
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

/// Whether the machine moves a third axis.
pub fn climbs(machine: &StoredMachine) -> Result<bool, CliError> {
    Ok(machine.profile.z.is_some() && dialect(machine)?.has_third_axis())
}

fn dialect(machine: &StoredMachine) -> Result<DialectName, CliError> {
    DialectName::named(&machine.dialect).map_err(|error| CliError::Argument(error.to_string()))
}

/// The plan of a session that protects nothing but the travel. `climbs`: whether it moves the third axis.
fn nothing_to_protect(machine: &MachineProfile, climbs: bool) -> Result<PreparedPlan, CliError> {
    let corner = |dx: f64, dy: f64| format!("10\n{}\n20\n{}\n", BEYOND_MM + dx, BEYOND_MM + dy);
    let corners: String =
        [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0)].into_iter().map(|(x, y)| corner(x, y)).collect();
    let drawing =
        format!("0\nSECTION\n2\nENTITIES\n0\nLWPOLYLINE\n8\n0\n70\n1\n{corners}0\nENDSEC\n0\nEOF\n");
    let mut slow = MachineProfile { max_rate_mm_s: machine.max_rate_mm_s.min(SPEED_MM_S), ..machine.clone() };
    let mut request = PlanRequest::default();
    request.job.tool_diameter_mm = 1.0;
    if let Some(z) = slow.z.as_mut().filter(|_| climbs) {
        z.max_rate_mm_s = z.max_rate_mm_s.min(SPEED_MM_S);
        // The part is as thick as the travel leaves, so the floor below it is near the end of travel.
        request.job.depth = Some(DepthParameters {
            overcut_mm: 0.0,
            safe_mm: SAFE_MM,
            tool_length_error_mm: 0.0,
            step_down_mm: Some(z.travel_mm),
            entry: EntryMove::Plunge,
            ..DepthParameters::of(z.travel_mm - 2.0 * SAFE_MM)
        });
    }
    let plan = request.plan("touch-off", drawing.as_bytes(), &slow, &mut |_| {});
    let plan = plan.map_err(|source| CliError::PlanRequest { path: "touch-off".into(), source })?;
    Ok(PreparedPlan::new(plan))
}

/// The session in which the operator touches places. Nothing but the travel is protected.
pub fn touch_session(machine: &StoredMachine, home: bool) -> Result<SessionSetup, CliError> {
    let StoredMachine { baud, profile, .. } = machine;
    let (dialect, climbs) = (dialect(machine)?, climbs(machine)?);
    let work = nothing_to_protect(profile, climbs)?;
    let place = whole_travel(profile, climbs)
        .map_err(|source| CliError::Argument(format!("the machine's travel: {source}")))?;
    place.moved_by(&dialect)?;
    let options = Options {
        feed_mm_min: 100,
        home,
        travel: place.travel,
        heights: place.heights(),
        answer_within: Duration::from_secs(5),
        baud: *baud,
        progress: keepout_planner::job::Progress::default(),
    };
    let config = place.config(profile);
    Ok(SessionSetup { work, options, dialect, config })
}

/// The machine coordinates of the places, as the operator takes them.
fn jogged(
    places: &[TouchPlace],
    machine: &StoredMachine,
    (home, climbs): (bool, bool),
    unit: ShownUnit,
) -> Result<Vec<Mm3>, CliError> {
    let setup = touch_session(machine, home)?;
    let serial = Serial::open(&machine.port, machine.baud)?;
    let panel = Panel::default();
    let keyboard = Keyboard::open(panel.clone())?;
    let operator = Box::new(SpindleStands::new(keyboard, climbs));
    let mut session = setup.session(serial, operator, Box::new(NoEventLog));
    let mut taking = Taking {
        places,
        unit,
        panel,
        taken: TakenPlaces::default(),
        seen: 0,
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
    if taking.taken.taken.len() < places.len() {
        return Err(CliError::Argument(
            "ended before every place was taken: no alignment was written. Start again.".into(),
        ));
    }
    Ok(taking.taken.taken)
}

/// The whole travel of a machine, in its own coordinates. Height zero of the plan is below the end of travel.
fn whole_travel(profile: &MachineProfile, climbs: bool) -> Result<TablePlacement, LatticeError> {
    let corner = point_from_mm(Mm2::new(-profile.travel_mm[0], -profile.travel_mm[1]))?;
    let travel = Window::of(corner).including(point_from_mm(Mm2::ZERO)?);
    let place_z = |z: &ZProfile| {
        let highest = height_from_mm(SAFE_MM)?;
        let zero = Height::from_units(-i64::from(highest.units()))?;
        Ok(PlacedZ { zero, travel: [highest.lowered(length_up_from_mm(z.travel_mm)?), highest] })
    };
    let z = profile.z.as_ref().filter(|_| climbs).map(place_z).transpose()?;
    Ok(TablePlacement { offset: Vector { dx: 0, dy: 0 }, travel, z })
}

/// The places that are taken, and what the operator sees.
struct Taking<'a> {
    places: &'a [TouchPlace],
    unit: ShownUnit,
    panel: Panel,
    taken: TakenPlaces,
    /// Number of take keys that were read.
    seen: usize,
    told: Option<usize>,
    /// The last line with the position, and its time.
    shown: (String, Time),
}

impl Taking<'_> {
    fn watch(&mut self, supervisor: &Supervisor, now: Time) -> Going {
        let count = self.taken.taken.len();
        if rests(supervisor) && self.told != Some(count) {
            self.told = Some(count);
            if let Some(place) = self.places.get(count) {
                let at = place.drawing_mm.map_or(String::new(), |at| format!(" {}", self.unit.place(at)));
                let (number, all, words) = (count + 1, self.places.len(), place.words);
                self.line(&format!("place {number} of {all}: {words}{at}. Press t there."));
            }
        }
        let climbs = supervisor.height_mm().is_some();
        self.show(on_machine(supervisor), climbs, now);
        let key = self.panel.taken() > self.seen;
        self.seen = self.panel.taken();
        match self.taken.watch(supervisor, key, now) {
            TakeOutcome::Nothing => {}
            TakeOutcome::Refused(reason) => self.line(reason),
            TakeOutcome::Taken(at) => {
                let place = self.unit.place(at.plane());
                let height = if climbs { format!(", z {}", self.unit.length(at.z)) } else { String::new() };
                let (number, all) = (count + 1, self.places.len());
                self.line(&format!("taken {number} of {all}: machine position {place}{height}"));
            }
        }
        if self.taken.taken.len() == self.places.len() { Going::Halt } else { Going::On }
    }

    /// Shows the position and the speed or step in one line. When they change, a new text replaces the line.
    fn show(&mut self, position: Option<Mm3>, climbs: bool, now: Time) {
        let Some(Mm3 { x, y, z }) = position else { return };
        let (x, y, symbol) = (self.unit.figure(x), self.unit.figure(y), self.unit.symbol());
        let z = if climbs { format!("  z {:>9}", self.unit.figure(z)) } else { String::new() };
        let line = format!("x {x:>9}  y {y:>9}{z} {symbol}, machine coordinates  {}", self.panel.status());
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
    use keepout_planner::units::mm;

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
        let work = nothing_to_protect(&MachineProfile::simulated(), false).unwrap();
        for (x, y) in [(-1.0, -1.0), (-400.0, -350.0), (-200.0, -175.0)] {
            let at = point_from_mm(Mm2::new(x, y)).unwrap();
            assert!(work.plan.part.free_point(at, work.plan.roughing).is_ok());
        }
        assert!(work.plan.plan.machine.max_rate_mm_s <= SPEED_MM_S);
    }

    #[test]
    fn session_with_a_third_axis_leaves_its_travel_free() {
        let machine = MachineProfile::simulated_three_axes();
        let work = nothing_to_protect(&machine, true).unwrap();
        let place = whole_travel(&machine, true).unwrap();
        let ([lowest, highest], travel_mm) = (place.heights().unwrap(), machine.z.unwrap().travel_mm);
        assert!((mm(highest.units()) - mm(lowest.units()) - travel_mm).abs() < 1e-9);
        let at = point_from_mm(Mm2::new(-200.0, -175.0)).unwrap();
        let free = |height: Height| work.plan.levels.at(height).free_point(at, work.plan.roughing).is_ok();
        // Near the lower end of travel is the floor of the session's plan.
        let near = lowest.raised(length_up_from_mm(2.0 * SAFE_MM + 0.1).unwrap());
        assert!(free(highest) && free(Height::ZERO) && free(near));
    }
}
