//! The machine of Koren & Lo with other sampling periods and encoders, and the paths of the comparison.

use keepout_drives::controllers::kind::Kind;
use keepout_drives::controllers::selection::Environment;
use keepout_drives::metrics::Spread;
use keepout_drives::path::Path;
use keepout_drives::profile::{DriveProfile, DriveProfileError, Uncertainty};
use keepout_drives::reference::{Ramp, Reference};
use keepout_drives::run::{Cutting, Task};
use keepout_drives::tuning::{TunedGains, TuningError, tune};
use keepout_planner::machine::MachineProfile;
use keepout_planner::request::PlanRequest;

use crate::koren_lo::finishing::loops;
use crate::koren_lo::scenario::PathShape;

/// Feed of all runs, mm/s: 0.9 m/min.
pub const FEED_MM_S: f64 = 15.0;
/// Sampling periods, s.
pub const PERIODS_S: [f64; 4] = [0.001, 0.002, 0.004, 0.01];
/// Lengths of a pulse, µm.
pub const PULSES_UM: [f64; 2] = [0.1, 10.0];
/// Acceleration and jerk of the references, mm/s² and mm/s³.
const RAMP: [f64; 2] = [500.0, 5000.0];
/// Largest command, mm/s.
const LIMIT_MM_S: f64 = 200.0;

/// A sampling period with an encoder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Variant {
    /// T, s.
    pub period_s: f64,
    /// Length of a pulse, µm.
    pub pulse_um: f64,
}

impl Variant {
    /// All of them.
    #[must_use]
    pub fn all() -> Vec<Self> {
        PULSES_UM
            .into_iter()
            .flat_map(|pulse_um| PERIODS_S.map(|period_s| Self { period_s, pulse_um }))
            .collect()
    }

    /// "4 ms, 10 µm".
    #[must_use]
    pub fn name(&self) -> String {
        format!("{} ms, {} µm", self.period_s * 1000.0, self.pulse_um)
    }

    /// The machine of Table 1 with sticking friction, this period and this encoder. Commands are whole bits.
    ///
    /// # Errors
    /// Only if the built-in profile is invalid.
    pub fn machine(&self) -> Result<DriveProfile, DriveProfileError> {
        let mut machine = DriveProfile::load("koren-lo-table-1")?;
        let scale = 1000.0 / self.pulse_um / machine.pulses_per_mm;
        machine.period_s = self.period_s;
        machine.pulses_per_mm *= scale;
        machine.whole_numbers = true;
        machine.limit_bits = Some(LIMIT_MM_S * machine.pulses_per_mm / (machine.x.gain * scale));
        for axis in [&mut machine.x, &mut machine.y] {
            axis.gain *= scale;
        }
        let gains = &mut machine.gains;
        gains.proportional /= scale;
        for law in [&mut gains.pid, &mut gains.cross_coupling] {
            law.proportional /= scale;
            law.integral /= scale;
            law.derivative /= scale;
        }
        Ok(machine)
    }

    /// The gains of `kind` by the tuner. The selection has those of the controller that it chooses.
    ///
    /// # Errors
    /// [`TuningError`] if no gains keep the margins.
    pub fn tuned(&self, machine: &DriveProfile, kind: Kind) -> Result<TunedGains, TuningError> {
        tune(machine, kind, FEED_MM_S, &mut |_, _| {})
    }
}

/// A path of the comparison, in mm.
#[derive(Clone, Debug, PartialEq)]
pub struct ScoringPath {
    /// Short name.
    pub name: &'static str,
    shape: PathShape,
}

/// The paths: none of them is a path of the tuner.
///
/// # Panics
/// If a drawing of the repository cannot be planned.
#[must_use]
pub fn paths() -> Vec<ScoringPath> {
    let contour = |name: &'static str, bytes: &[u8]| {
        let planned = PlanRequest::default().plan(name, bytes, &MachineProfile::simulated(), &mut |_| {});
        let plan = planned.unwrap_or_else(|error| panic!("{name}: {error}"));
        ScoringPath { name, shape: PathShape::Given(loops(&plan.plan).swap_remove(0).pieces) }
    };
    vec![
        ScoringPath {
            name: "circle",
            shape: PathShape::Circle { radius_mm: 20.0, counter_clockwise: false, turns: 1 },
        },
        ScoringPath { name: "corner", shape: PathShape::Corner { leg_mm: 20.0, angle_deg: 90.0 } },
        ScoringPath { name: "sharp", shape: PathShape::Corner { leg_mm: 20.0, angle_deg: -150.0 } },
        ScoringPath { name: "spiral", shape: PathShape::Spiral { radii_mm: [5.0, 15.0], turns: 1 } },
        contour("bracket", include_bytes!("../../../../executor/cli/drawings/bracket.dxf")),
        contour("splines", include_bytes!("../../../drawings/spline_periodic.dxf")),
    ]
}

/// How a controller did on a path, µm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Score {
    /// RMS contour error until the drives rest, with drives that are 5 % wrong and a command half a sample late.
    pub rms_um: f64,
    /// The largest of these errors with drives that are 20 % wrong and a command one sample late: the worst of the
    /// signs.
    pub worst_um: f64,
}

/// Signs of the errors: gain and time constant of X, then of Y.
const SIGNS: [[f64; 4]; 4] =
    [[1.0, -1.0, 1.0, -1.0], [1.0, -1.0, -1.0, 1.0], [-1.0, 1.0, -1.0, 1.0], [1.0, 1.0, 1.0, 1.0]];

/// Runs a controller on a path.
#[must_use]
pub fn score(machine: &DriveProfile, kind: Kind, path: &ScoringPath) -> Option<Score> {
    let scale = machine.pulses_per_mm;
    let path: Path = path.shape.path(scale);
    let feed = FEED_MM_S * scale;
    let [acceleration, jerk] = RAMP.map(|limit| limit * scale);
    let reference =
        Reference::along(&path, feed, machine.period_s, Ramp::LimitedJerk { acceleration, jerk }).samples;
    let cutting = machine.cutting().map(|cutting| Cutting { up_to_feed: feed, ..cutting });
    let task = Task { plant: machine.plant(), path, feed, reference, cutting };
    let run = |share: f64, signs: [f64; 4], late: f64| -> Option<Spread> {
        let mut setting = machine.setting(Environment::of(&task, share));
        let off = Uncertainty { gain: share, time_constant: share, delay_samples: 0.0 };
        setting.belief = setting.belief.off_by(off, signs);
        let outcome = task.later(late).run(kind.built(&setting)?.as_mut());
        Some(Spread::of(outcome.moments.iter().map(|moment| moment.contour_error)).times(machine.um()))
    };
    let rms_um = run(0.05, [1.0, -1.0, -1.0, 1.0], 0.5)?.rms;
    let mut worst_um = 0.0_f64;
    for signs in SIGNS {
        let found = run(0.2, signs, 1.0)?.max;
        worst_um = if found.is_finite() { worst_um.max(found) } else { f64::INFINITY };
    }
    Some(Score { rms_um, worst_um })
}
