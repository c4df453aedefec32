//! The worlds of the sessions: a drawing, a tool, a machine, a certified plan.

use std::path::PathBuf;
use std::sync::Arc;

use fastrand::Rng;
use keepout_executor::dialect::DialectName;
use keepout_executor::session::{TablePlacement, place_on_table};
use keepout_executor::supervisor::PreparedPlan;
use keepout_kernel::{Height, Length, Levels, Point};
use keepout_planner::depth::{DepthParameters, EntryMove, FaceChoice, FaceDepth};
use keepout_planner::machine::{MachineProfile, ZProfile};
use keepout_planner::plan::{Cut, PassParameters, PlanParameters};
use keepout_planner::profile::MachinedSide;
use keepout_planner::request::PlanRequest;
use keepout_planner::units::{length_up_from_mm, mm, point_from_mm, vector_mm};
use keepout_planner::{Box2, Mm2};

use super::drawing::random_drawing;

/// A plan, and the data that all sessions in it share.
pub struct HostileWorld {
    /// Its seed.
    pub seed: u64,
    /// The drawing's name.
    pub name: String,
    /// The controller's dialect.
    pub language: DialectName,
    /// The machine.
    pub machine: MachineProfile,
    /// The plan.
    pub work: PreparedPlan,
    /// The part, prepared for the collision monitor.
    pub levels: Arc<Levels>,
    /// The place of the drawing on the machine.
    pub place: TablePlacement,
    /// The monitor's least clearance while jogging: tool radius plus stock to leave.
    pub by_hand: Length,
    /// A tool with more clearance than this has left the stock to leave for certain.
    pub outside: Length,
    /// Start places outside the jogging clearance.
    pub starts: Vec<Point>,
    /// Start places inside the jogging clearance, but not in the part.
    pub inside: Vec<Point>,
}

/// The source of the worlds.
#[derive(Clone, Debug, Default)]
pub struct Worlds {
    /// Real drawings. The other worlds have random drawings.
    pub real: Vec<PathBuf>,
    /// The dialects of the controllers.
    pub languages: Vec<DialectName>,
    /// Whether all drawings have depths.
    pub three_axes: bool,
}

/// One world in this many has a real drawing, if there are real drawings.
const REAL_EVERY: u64 = 8;
/// Count of start places that the search wants.
const PLACES: usize = 24;

impl Worlds {
    /// The world of this seed. `None` if its drawing gives no plan, or does not fit its machine.
    #[must_use]
    pub fn world(&self, seed: u64) -> Option<HostileWorld> {
        let mut random = Rng::with_seed(seed);
        let language = self.languages.get(random.usize(0..self.languages.len().max(1)))?.clone();
        let real = !self.real.is_empty() && seed.is_multiple_of(REAL_EVERY);
        let (name, bytes) = if real {
            let path = &self.real[random.usize(0..self.real.len())];
            (path.file_name()?.to_string_lossy().into_owned(), std::fs::read(path).ok()?)
        } else {
            (format!("random {seed}"), random_drawing(&mut random).into_bytes())
        };
        let mut machine = machine(&mut random);
        let mut request = request(&mut random);
        // From another source, so that the worlds of two axes are the same as ever.
        let mut of_depth = Rng::with_seed(seed ^ 0xdee9);
        if self.three_axes && !language.has_third_axis() {
            return None;
        }
        if language.has_third_axis() && (of_depth.bool() || self.three_axes) {
            machine.z = Some(ZProfile {
                steps_per_mm: [80.0, 400.0, 1600.0][of_depth.usize(0..3)],
                repeatability_mm: [0.0, 0.004, 0.02][of_depth.usize(0..3)],
                ..ZProfile::simulated()
            });
            request.job.depth = Some(depth(&mut of_depth));
        }
        let mut planned = request.plan(&name, &bytes, &machine, &mut |_| {});
        if let (Err(_), Some(depth)) = (&planned, &mut request.job.depth) {
            // The drawing may have no second contour.
            depth.faces.clear();
            planned = request.plan(&name, &bytes, &machine, &mut |_| {});
        }
        let plan = planned.ok()?;
        // A huge drawing would take the time of many sessions.
        if plan.part.edges().len() > 20_000 {
            return None;
        }
        let place = place_on_table(&plan, &machine, None).ok()?;
        let by_hand = Length::from_units(
            i64::from(plan.plan.tool_radius.units()) + i64::from(plan.plan.stock_to_leave.units()),
        )
        .ok()?;
        let margin = plan.roughing.units() - by_hand.units();
        let outside = Length::from_units(i64::from(plan.roughing.units()) + i64::from(margin)).ok()?;
        let radius = plan.plan.tool_radius;
        let work = PreparedPlan::new(plan);
        let mut world = HostileWorld {
            seed,
            name,
            language,
            machine,
            levels: Arc::new(work.levels().prepared(&[outside, by_hand, radius])),
            work,
            place,
            by_hand,
            outside,
            starts: Vec::new(),
            inside: Vec::new(),
        };
        world.look_for_places(&mut random);
        (!world.starts.is_empty()).then_some(world)
    }
}

impl HostileWorld {
    /// A height to start from at a place of the machine, mm, drawing coordinates: from the deepest pass to the end of
    /// travel. Below a pocket's floor the part stands where its outline is air: there the tool starts above it.
    #[must_use]
    pub fn start_height(&self, at_mm: Mm2, random: &mut Rng) -> Height {
        let (Some(relief), Some([_, highest])) = (&self.work.plan.plan.relief, self.place.heights()) else {
            return Height::ZERO;
        };
        let units = random.i32(relief.deepest.units()..=highest.units());
        let height = Height::from_units(i64::from(units)).unwrap_or(highest);
        let at = point_from_mm(at_mm - vector_mm(self.place.offset));
        let stands = at.is_ok_and(|at| self.levels.at(height).holds(at));
        if stands { highest } else { height }
    }

    /// The machine's height where the drawing's height is zero.
    #[must_use]
    pub fn zero_height(&self) -> Height {
        self.place.z.map_or(Height::ZERO, |z| z.zero)
    }

    /// Searches start places in the part's box and around it.
    fn look_for_places(&mut self, random: &mut Rng) {
        let plan = &self.work.plan;
        let Box2 { low, high } = plan.part_box();
        let reach = 4.0 * mm(plan.roughing.units());
        let finishing = length_up_from_mm(mm(plan.finishing.units()) + 0.002).unwrap_or(plan.finishing);
        for _ in 0..4000 {
            if self.starts.len() >= PLACES && self.inside.len() >= 4 {
                return;
            }
            let within = |low: f64, high: f64, t: f64| low - reach + (high - low + 2.0 * reach) * t;
            let place = Mm2::new(within(low.x, high.x, random.f64()), within(low.y, high.y, random.f64()));
            let Ok(point) = point_from_mm(place) else { continue };
            if !self.place.travel.holds(point) {
                continue;
            }
            if plan.part.free_point(point, plan.roughing).is_ok() {
                if self.starts.len() < PLACES {
                    self.starts.push(point);
                }
            } else if plan.part.free_point(point, finishing).is_ok() {
                self.inside.push(point);
            }
        }
    }
}

fn machine(random: &mut Rng) -> MachineProfile {
    let simulated = MachineProfile::simulated();
    MachineProfile {
        max_rate_mm_s: [20.0, 60.0, 200.0][random.usize(0..3)],
        acceleration_mm_s2: [100.0, 500.0, 3000.0][random.usize(0..3)],
        steps_per_mm: [80.0, 200.0, 400.0, 2000.0][random.usize(0..4)],
        repeatability_mm: [0.0, 0.004, 0.02][random.usize(0..3)],
        spindle_rpm: [None, Some(10_000)][random.usize(0..2)],
        ..simulated
    }
}

/// Heights of a job: a part of one to three depths, with a pocket, clamps and a table in some.
fn depth(random: &mut Rng) -> DepthParameters {
    let thickness_mm = 2.0 + 8.0 * random.f64();
    let pocket = || FaceDepth { of: FaceChoice::Contour(2), depth_mm: Some(thickness_mm / 2.0) };
    DepthParameters {
        faces: random.bool().then(pocket).into_iter().collect(),
        step_down_mm: [None, Some(thickness_mm / 3.0)][random.usize(0..2)],
        table_mm: [None, Some(1.0)][random.usize(0..2)],
        clamps_mm: [None, Some(3.0)][random.usize(0..2)],
        entry: [EntryMove::Plunge, EntryMove::Ramp { slope: 0.2 }][random.usize(0..2)],
        tool_length_error_mm: [0.02, 0.1][random.usize(0..2)],
        ..DepthParameters::of(thickness_mm)
    }
}

fn request(random: &mut Rng) -> PlanRequest {
    let tool_diameter_mm = [1.0, 2.0, 3.0, 6.0, 10.0][random.usize(0..5)];
    let passes = match random.u8(0..4) {
        0 => vec![PassParameters { stock_to_leave_mm: 0.1, feed_mm_min: None }, PassParameters::default()],
        // Non-interpolated axes cannot follow slanted walls closer than this.
        1 => vec![PassParameters { stock_to_leave_mm: 0.05, feed_mm_min: None }],
        _ => Vec::new(),
    };
    let job = PlanParameters {
        tool_diameter_mm,
        stock_to_leave_mm: [0.15, 0.2, 0.5, 2.0][random.usize(0..4)],
        side: if random.u8(0..3) == 0 { MachinedSide::Inside } else { MachinedSide::Outside },
        passes,
        cut: if random.bool() { Cut::Climb } else { Cut::Conventional },
        ..PlanParameters::default()
    };
    PlanRequest { job, ..PlanRequest::default() }
}
