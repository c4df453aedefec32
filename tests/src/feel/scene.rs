//! Machine tables, drawings and sessions.

use std::time::Duration;

use keepout_executor::dialect::DialectName;
use keepout_executor::session::{Going, NoEventLog, nearest_wall};
use keepout_executor::supervisor::PreparedPlan;
use keepout_planner::Mm2;
use keepout_planner::machine::MachineProfile;
use keepout_planner::request::PlanRequest;
use keepout_planner::units::{mm, point_from_mm};
use keepout_sim::session::{SimRun, run_simulated};

use super::hand::{Hand, Pushes, Timed};
use super::trace::Trace;

/// Width of the bar, mm.
const BAR_MM: f64 = 10.0;
/// Half of the bar's length, mm.
pub(super) const BAR_END_MM: f64 = 130.0;
/// Start of the tool along the bar, mm.
pub(super) const START_MM: f64 = -110.0;
/// Jogging clearance of the default tool, about, mm.
const TOOL_MM: f64 = 3.2;

/// A machine table of 300 mm × 300 mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MachineTable {
    /// Its name.
    pub name: &'static str,
    /// Top speed of an axis, mm/min.
    pub feed_mm_min: f64,
    /// Acceleration of an axis, mm/s².
    pub acceleration_mm_s2: f64,
}

impl MachineTable {
    /// All tables.
    pub const ALL: [Self; 4] = [
        Self { name: "A", feed_mm_min: 5000.0, acceleration_mm_s2: 500.0 },
        Self { name: "B", feed_mm_min: 5000.0, acceleration_mm_s2: 50.0 },
        Self { name: "C", feed_mm_min: 12_000.0, acceleration_mm_s2: 2000.0 },
        Self { name: "K", feed_mm_min: 500.0, acceleration_mm_s2: 100.0 },
    ];

    /// Top speed, mm/s.
    #[must_use]
    pub fn speed_mm_s(&self) -> f64 {
        self.feed_mm_min / 60.0
    }

    fn machine(&self) -> MachineProfile {
        MachineProfile {
            travel_mm: [300.0, 300.0],
            max_rate_mm_s: self.speed_mm_s(),
            acceleration_mm_s2: self.acceleration_mm_s2,
            repeatability_mm: 0.0,
            ..MachineProfile::simulated()
        }
    }
}

/// The place of the tool at the release of the stick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReleasePlace {
    /// Sliding along the wall.
    Sliding,
    /// Far from any wall.
    Far,
}

/// A part with a smooth wall. The radii are those of the tool centre's path at the jogging clearance, about,
/// mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WallShape {
    /// A straight bar at this angle, degrees.
    Bar(f64),
    /// A disc: a convex wall.
    Convex(f64),
    /// A round hole in a plate: a concave wall.
    Concave(f64),
    /// An ellipse of these half axes: convex, and of changing curvature, like a spline.
    Ellipse(f64, f64),
    /// An elliptic hole.
    EllipticHole(f64, f64),
}

impl WallShape {
    /// Curved walls.
    pub const CURVES: [Self; 8] = [
        Self::Convex(10.0),
        Self::Convex(30.0),
        Self::Convex(100.0),
        Self::Concave(10.0),
        Self::Concave(30.0),
        Self::Concave(100.0),
        Self::Ellipse(60.0, 25.0),
        Self::EllipticHole(60.0, 25.0),
    ];

    /// A place at this height above the wall.
    pub(super) fn start_mm(self, height_mm: f64) -> Mm2 {
        match self {
            Self::Bar(angle) => Mm2::new(START_MM, BAR_MM / 2.0 + height_mm).turned(angle.to_radians()),
            Self::Convex(r) => Mm2::new(0.0, r - TOOL_MM + height_mm),
            Self::Ellipse(_, b) => Mm2::new(0.0, b + height_mm),
            Self::Concave(r) => Mm2::new(0.0, r + TOOL_MM - height_mm),
            Self::EllipticHole(_, b) => Mm2::new(0.0, b - height_mm),
        }
    }

    fn drawing(self) -> String {
        let rectangle = |half: Mm2, angle: f64| {
            let corners = [-half, Mm2::new(half.x, -half.y), half, Mm2::new(-half.x, half.y)];
            let corner = |at: Mm2| {
                let Mm2 { x, y } = at.turned(angle.to_radians());
                format!("10\n{x}\n20\n{y}\n")
            };
            format!("0\nLWPOLYLINE\n8\n0\n90\n4\n70\n1\n{}", corners.map(corner).concat())
        };
        let circle = |r: f64| format!("0\nCIRCLE\n8\n0\n10\n0\n20\n0\n40\n{r}\n");
        let ellipse = |a: f64, b: f64| {
            format!(
                "0\nELLIPSE\n8\n0\n10\n0\n20\n0\n11\n{a}\n21\n0\n40\n{}\n41\n0\n42\n{}\n",
                b / a,
                std::f64::consts::TAU
            )
        };
        let plate = || rectangle(Mm2::new(130.0, 130.0), 0.0);
        let entities = match self {
            Self::Bar(angle) => rectangle(Mm2::new(BAR_END_MM, BAR_MM / 2.0), angle),
            Self::Convex(r) => circle(r - TOOL_MM),
            Self::Concave(r) => plate() + &circle(r + TOOL_MM),
            Self::Ellipse(a, b) => ellipse(a, b),
            Self::EllipticHole(a, b) => plate() + &ellipse(a, b),
        };
        format!(
            "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n4\n0\nENDSEC\n\
             0\nSECTION\n2\nENTITIES\n{entities}0\nENDSEC\n0\nEOF\n"
        )
    }
}

/// A part on a machine table, and the serial line to it.
pub(super) struct Scene {
    work: PreparedPlan,
    run: SimRun,
}

impl Scene {
    pub(super) fn of(
        table: &MachineTable,
        shape: WallShape,
        language: DialectName,
        delay_ms: u64,
    ) -> Result<Self, String> {
        let machine = table.machine();
        let plan = PlanRequest::default().plan("feel", shape.drawing().as_bytes(), &machine, &mut |_| {});
        let run = SimRun {
            machine,
            servo: None,
            dialect: language,
            latency: Duration::from_millis(delay_ms),
            limit: Duration::from_secs(900),
            ..SimRun::default()
        };
        Ok(Self { work: PreparedPlan::new(plan.map_err(|error| error.to_string())?), run })
    }

    /// The jogging clearance, mm.
    pub(super) fn limit_mm(&self) -> f64 {
        mm(self.work.plan.roughing.units())
    }

    /// Height above the jogging clearance, mm.
    pub(super) fn height_mm(&self, at: Mm2) -> f64 {
        let wall = point_from_mm(at).ok().and_then(|point| nearest_wall(&self.work.plan, point.in_plane()));
        wall.map_or(f64::INFINITY, |wall| wall.distance(at) - self.limit_mm())
    }

    /// Runs a session, and returns the true positions of the tool.
    pub(super) fn trace(&self, start: Mm2, hand: Hand) -> Result<Trace, String> {
        let start = point_from_mm(start).map_err(|error| error.to_string())?;
        let run = SimRun { start: Some(start), ..self.run.clone() };
        let operator = Box::new(Timed { hand, began: None, over: false });
        let work = self.work.clone();
        let result = run_simulated(work, &run, operator, Box::new(NoEventLog), &mut |_, _, _| Going::On);
        let result = result.map_err(|error| error.to_string())?;
        if let Some(fault) = result.facts.outcome.fault().map(String::from) {
            return Err(fault);
        }
        match result.facts.deepest_mm {
            Some(deepest) if deepest > 0.0 => Err(format!("the tool was {deepest} mm in the part")),
            _ => Ok(Trace::of(&result.samples)),
        }
    }

    /// Runs a session, and returns the true positions and the times of the pushes or releases.
    pub(super) fn trace_of_pushes(&self, start: Mm2, pushes: Pushes) -> Result<(Trace, Vec<f64>), String> {
        let times = pushes.times.clone();
        let trace = self.trace(start, Hand::Pushes(pushes))?;
        let times = times.lock().map_err(|error| error.to_string())?.clone();
        Ok((trace, times))
    }
}
