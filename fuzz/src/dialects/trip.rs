//! Motions there and back: a dialect, and the simulated controller that speaks it.

use std::sync::{Arc as Shared, OnceLock};
use std::time::Duration;

use arbitrary::{Arbitrary, Result, Unstructured};
use keepout_executor::dialect::{Description, Dialect, DialectConfig, DialectName, DialectZ};
use keepout_executor::supervisor::{Command, Mode, Reply};
use keepout_guard::{Certified, ContourMotion, Time};
use keepout_kernel::curve::fit_arc;
use keepout_kernel::{Arc, Curve, Height, Place, Point, Turn, Vec2, Vector};
use keepout_planner::machine::{MachineProfile, ZProfile};
use keepout_planner::units::{mm, vector_mm};
use keepout_planner::{Mm2, Mm3};
use keepout_sim::{SimSettings, SimulatedController, speaking};

use super::{contour, description, jog, straight};
use crate::oracle::{self, UNIT, xy};

/// A description with a third axis.
fn three_axes() -> Shared<Description> {
    static ONE: OnceLock<Shared<Description>> = OnceLock::new();
    let text = include_str!("../../../executor/sim/tests/described/three-axes.toml");
    Shared::clone(ONE.get_or_init(|| Shared::new(Description::of(text).expect("it is one of ours"))))
}

/// About a quarter of a circle from `from` to `to`, with the centre beside the middle. `left` chooses the
/// direction.
fn bend_to(from: Point, to: Point, left: bool) -> Option<Arc> {
    let (a, b) = (xy(from), xy(to));
    let (dx, dy) = ((b.0 - a.0) / 2.0, (b.1 - a.1) / 2.0);
    let (nx, ny) = if left { (-dy, dx) } else { (dy, -dx) };
    fit_arc(
        from,
        to,
        Vec2::new(a.0 + dx + nx, a.1 + dy + ny),
        if left { Turn::CounterClockwise } else { Turn::Clockwise },
    )
    .ok()
}

/// Reads a dialect, a position on the table, whether a third axis moves, garbage before the session, and motions.
/// Each motion arrives at its target, in height too, and the controller reports that position.
///
/// # Panics
/// When a motion arrives elsewhere, or a report differs.
pub fn round_trip(bytes: &[u8]) {
    let _ = round_trip_of(&mut Unstructured::new(bytes));
}

fn round_trip_of(u: &mut Unstructured<'_>) -> Result<()> {
    let described = |description| DialectName::Described { file: "described".into(), description };
    let name = match u.int_in_range(0..=8_usize)? {
        which @ 0..=3 => DialectName::named(DialectName::NAMES[which]).expect("it is built in"),
        8 => described(three_axes()),
        other => described(description(other)),
    };
    let climbs = name.needs_third_axis() || name.has_third_axis() && bool::arbitrary(u)?;
    let reach = 15_000_000;
    let offset = Vector { dx: -u.int_in_range(reach..=2 * reach)?, dy: -u.int_in_range(reach..=2 * reach)? };
    let zero = Height::from_units(-u.int_in_range(1_000_000..=4_000_000_i64)?).expect("it is small");
    let mut trip = Trip::begin(&name, offset, climbs.then_some(zero));
    for _ in 0..u.int_in_range(0..=12_u8)? {
        trip.receives_garbage(u8::arbitrary(u)?);
    }
    trip.sets_out();
    let mut from = Point::ORIGIN.in_plane();
    for _ in 0..u.int_in_range(1..=3_u8)? {
        let (x, y) = (u.int_in_range(0..=9_000_000_i64)?, u.int_in_range(0..=9_000_000_i64)?);
        let (to, feed) = (Point::from_units(x, y).expect("it is small"), u.int_in_range(60..=12_000_u32)?);
        let height = if climbs { u.int_in_range(-4_000_000..=900_000_i64)? } else { 0 };
        let to = to.at_height(Height::from_units(height).expect("it is small"));
        let way = to.point.minus(from.point);
        if way.dx.abs().max(way.dy.abs()) < 2000 {
            continue;
        }
        // The lowest bit makes a jog. The two bits above make one in four of the other motions an arc.
        let kind = u8::arbitrary(u)?;
        let bent = (kind & 7 == 2).then(|| bend_to(from.point, to.point, kind & 8 == 0)).flatten();
        let bent = bent.filter(|_| trip.dialect.abilities().arcs);
        // The supervisor sends a ramp along an arc as chords, because a line with all words of both is too long.
        let to = if bent.is_some() { to.point.at_height(from.height) } else { to };
        let motion = match (bent, kind & 1) {
            (Some(arc), _) => {
                let heights = [from.height; 2];
                contour(ContourMotion { curve: Curve::Arc(arc), heights, feed_mm_min: feed })
            }
            (None, 1) => jog(from, to),
            (None, _) => straight(from, to, feed),
        };
        trip.goes(motion, to, offset, bent);
        from = to;
    }
    Ok(())
}

/// A dialect and the simulated controller that speaks it, with a perfect link.
struct Trip {
    dialect: Box<dyn Dialect>,
    controller: Box<dyn SimulatedController>,
    /// The machine's height of the drawing's height zero. `None`: the third axis does not move.
    zero: Option<Height>,
    now: Time,
    bytes: Vec<u8>,
}

impl Trip {
    fn begin(name: &DialectName, offset: Vector, zero: Option<Height>) -> Self {
        let simulated = MachineProfile::simulated();
        let third_axis = zero.map(|zero| (zero, ZProfile::simulated()));
        let machine = MachineProfile { z: third_axis.as_ref().map(|(_, z)| z.clone()), ..simulated };
        let stated = |(zero, z): (Height, ZProfile)| DialectZ {
            zero,
            steps_per_mm: z.steps_per_mm,
            travel_mm: Some(z.travel_mm),
        };
        let config = DialectConfig { z: third_axis.map(stated), ..DialectConfig::of(&machine, offset) };
        let up_mm = zero.map_or(0.0, |zero| mm(zero.units()));
        let settings = SimSettings {
            work_offset_mm: Mm2::new(-30.0, -20.0).at_height(if zero.is_some() { -7.0 } else { 0.0 }),
            ..SimSettings::of(machine, vector_mm(offset).at_height(up_mm))
        };
        let controller = speaking(name, settings);
        let dialect = name.dialect(config);
        Self { dialect, controller, zero, now: Time::ZERO, bytes: Vec::new() }
    }

    /// Decodes a garbage byte before the session. The output that it causes is lost.
    fn receives_garbage(&mut self, byte: u8) {
        let _ = self.dialect.decode(byte, &mut Vec::new());
    }

    fn sets_out(&mut self) {
        self.dialect.reset();
        self.say(&Command::Query, |reply| matches!(reply, Reply::Report(_)));
        self.say(&Command::Prepare, |reply| matches!(reply, Reply::Prepared(..)));
        self.say(&Command::Arm, |reply| matches!(reply, Reply::Armed));
        let known = |reply: &Reply| matches!(reply, Reply::Report(report) if report.position.is_some());
        for _ in 0..3 {
            if known(&self.say(&Command::Query, |reply| matches!(reply, Reply::Report(_)))) {
                return;
            }
        }
        panic!("no report states the position of the tool");
    }

    fn goes(&mut self, certified: Certified, to: Place, offset: Vector, bent: Option<Arc>) {
        self.say(&Command::Move(certified), |reply| *reply == Reply::Accepted);
        let report = loop {
            match self.say(&Command::Query, |reply| matches!(reply, Reply::Report(_))) {
                Reply::Report(report) if report.mode == Mode::Idle => break report,
                _ => {}
            }
        };
        let mut samples = Vec::new();
        self.controller.take_samples(&mut samples);
        let Mm3 { x, y, z } = samples.last().expect("it has moved").position_mm;
        let half_step_mm = 0.5 / MachineProfile::simulated().steps_per_mm + 2e-5;
        let machine = to.point.translated(offset).expect("it is small");
        let off = (x - mm(machine.x.units())).abs().max((y - mm(machine.y.units())).abs());
        assert!(off <= half_step_mm, "{off} mm from {to:?} by {:?}", self.controller);
        let half_step_z_mm = 0.5 / ZProfile::simulated().steps_per_mm + 2e-5;
        if let Some(zero) = self.zero {
            let off = (z - mm(to.height.units()) - mm(zero.units())).abs();
            assert!(off <= half_step_z_mm, "{off} mm above or below {to:?} by {:?}", self.controller);
        }
        if let Some(arc) = bent {
            let arc = Curve::Arc(arc);
            // The margin's share for arcs.
            let most_mm = 4.0 * MachineProfile::simulated().arc_tolerance_mm + 2.0 * half_step_mm;
            for Mm3 { x, y, .. } in samples.iter().map(|sample| sample.position_mm) {
                let place = ((x - mm(offset.dx)) * UNIT, (y - mm(offset.dy)) * UNIT);
                let off = oracle::distance(place, [&arc].into_iter()) / UNIT;
                assert!(off <= most_mm, "{off} mm beside {arc:?} at {place:?}");
            }
        }
        let reported = report.position.expect("it is armed");
        let way = reported.point.minus(to.point);
        let off = mm(way.dx).abs().max(mm(way.dy).abs());
        assert!(off <= 4.0 * half_step_mm, "reported {off} mm from {to:?}");
        let off = (mm(reported.height.units()) - mm(to.height.units())).abs();
        assert!(
            self.zero.is_none() || off <= 4.0 * half_step_z_mm,
            "reported {off} mm above or below {to:?}"
        );
    }

    /// Sends a command and decodes replies until the wanted one.
    fn say(&mut self, command: &Command, wanted: impl Fn(&Reply) -> bool) -> Reply {
        self.dialect.encode(command, &mut self.bytes).expect("it is on the lattice");
        for _ in 0..200_000 {
            std::mem::take(&mut self.bytes).into_iter().for_each(|byte| self.controller.receive(byte));
            let next = self.controller.next_event().min(self.now.after(Duration::from_millis(20)));
            self.now = next.max(self.now.after(Duration::from_millis(1)));
            self.controller.advance(self.now);
            let mut heard = Vec::new();
            self.controller.transmit(&mut heard);
            for byte in heard {
                let Some(reply) = self.dialect.decode(byte, &mut self.bytes) else { continue };
                assert!(
                    !matches!(reply, Reply::Garbled(_) | Reply::Refused { .. }),
                    "{command:?}: {reply:?}"
                );
                if wanted(&reply) {
                    return reply;
                }
            }
        }
        panic!("no answer to {command:?}");
    }
}
