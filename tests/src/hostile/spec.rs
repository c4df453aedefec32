//! The specification of a session, from a seed.

use std::time::Duration;

use fastrand::Rng;
use keepout_executor::supervisor::Abilities;
use keepout_sim::Quirks;
use keepout_sim::faults::{ByteDamage, Rates};

use super::operator::Style;

/// A fault that the simulation injects.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum HostileFault {
    /// The line delays chunks by up to 10 s.
    Delay,
    /// The line loses chunks.
    Loss,
    /// The line delivers chunks twice.
    Doubling,
    /// The line changes the order of chunks.
    Swap,
    /// The line damages bytes to the host. Any byte can result.
    DamageToHost,
    /// The line damages bytes to the controller. A checksum, or else the controller itself, can detect the
    /// damage.
    DamageToController,
    /// The line adds noise.
    Noise,
    /// The line replaces some replies by earlier ones.
    Lie,
    /// The controller resets.
    Reset,
    /// The controller raises an alarm.
    Alarm,
    /// The drives lose steps, within the margin.
    LostSteps,
    /// Someone pulls the cable and puts it back.
    PortLoss,
    /// The program stands still for a while.
    Stall,
    /// The clock jumps ahead.
    Clock,
    /// The planner proposes wrong contours.
    Planner,
    /// The baud rate is wrong for a while: only garbage arrives.
    Baud,
    /// The line alters one digit to the controller, once. Without a checksum nothing notices it, and it can gouge
    /// the part: docs/safety/assumptions.md excludes it.
    AlteredDigit,
}

impl HostileFault {
    /// All faults that must not gouge the part.
    pub const ALL: [Self; 16] = [
        Self::Delay,
        Self::Loss,
        Self::Doubling,
        Self::Swap,
        Self::DamageToHost,
        Self::DamageToController,
        Self::Noise,
        Self::Lie,
        Self::Reset,
        Self::Alarm,
        Self::LostSteps,
        Self::PortLoss,
        Self::Stall,
        Self::Clock,
        Self::Planner,
        Self::Baud,
    ];
}

/// A session. Its seed determines all of it, unless the search for a smaller session removes parts.
#[derive(Clone, Debug, PartialEq)]
pub struct Spec {
    /// The seed of the session. The drawing has another seed.
    pub seed: u64,
    /// The injected faults.
    pub faults: Vec<HostileFault>,
    /// The operator's style of jogging.
    pub style: Style,
    /// Whether the operator arms the cycle.
    pub automatic: bool,
    /// Duration of the session.
    pub limit: Duration,
    /// Baud rate.
    pub baud: u32,
    /// Delay of the line each way.
    pub latency: Duration,
    /// Whether the tool begins inside the jogging clearance.
    pub begins_inside: bool,
    /// Whether the session simulates the feed drives, which follow late and with an error. They take a
    /// thousand times the time of the rest. So one session in a thousand has them, and `--driven` gives them
    /// to all.
    pub driven: bool,
    /// Whether the operator steers at the panel, whose screens are hostile, too.
    pub at_panel: bool,
    /// Behaviour of the controller that real controllers show, too.
    pub quirks: Quirks,
    /// Whether resets are power failures.
    pub power_fails: bool,
    /// Whether a GRBL controller is the second model, which another author wrote from the documentation.
    pub second_model: bool,
}

impl Spec {
    /// The session of this seed.
    #[must_use]
    pub fn of(seed: u64) -> Self {
        let mut random = Rng::with_seed(seed);
        let count = [0, 1, 1, 1, 2, 2, 3, 5][random.usize(0..8)];
        let mut faults = HostileFault::ALL.to_vec();
        random.shuffle(&mut faults);
        faults.truncate(count);
        let automatic = random.u8(0..3) == 0;
        let limit = if automatic { random.u64(20..80) } else { random.u64(6..40) };
        // From 1 ms to 3 s. The distribution favours short delays.
        let mut other = Rng::with_seed(seed ^ 0x9012_c5a1);
        let (quirks, power_fails) = (quirks(&faults, &mut other), other.bool());
        let latency = Duration::from_secs_f64(0.001 * 3000.0_f64.powf(random.f64() * random.f64()));
        Self {
            seed,
            faults,
            style: Style::ALL[random.usize(0..Style::ALL.len())],
            automatic,
            limit: Duration::from_secs(limit),
            baud: [9600, 38_400, 115_200][random.usize(0..3)],
            latency,
            begins_inside: random.u8(0..16) == 0,
            driven: seed.is_multiple_of(1000),
            at_panel: false,
            quirks,
            power_fails,
            second_model: false,
        }
    }

    fn has(&self, fault: HostileFault) -> bool {
        self.faults.contains(&fault)
    }

    /// Whether the session has the fault.
    #[must_use]
    pub fn suffers(&self, fault: HostileFault) -> bool {
        self.has(fault)
    }

    /// The fault rates of one direction of the line.
    #[must_use]
    pub fn rates(&self, to_host: bool, abilities: Abilities) -> Rates {
        let Abilities { checked, queues, .. } = abilities;
        let mut random = Rng::with_seed(self.seed ^ if to_host { 0x51 } else { 0xa7 });
        // Logarithmic, over a factor of about 300.
        let mut chance = |most: f64| most * 10.0_f64.powf(-2.5 * random.f64());
        let mut rates = Rates::default();
        let mut set = |fault, rate: &mut f64, most| {
            let value = chance(most);
            if self.has(fault) {
                *rate = value;
            }
        };
        // On a controller with a queue and unnumbered acknowledgements, Keepout counts the acknowledgements.
        // A line that duplicates, and also loses or reorders, within one round trip defeats the count. We
        // assume that no line does both, see docs/safety/assumptions.md.
        let counts = checked || !queues || !self.suffers(HostileFault::Doubling);
        set(HostileFault::Delay, &mut rates.delay, 0.2);
        set(HostileFault::Loss, &mut rates.loss, if counts { 0.05 } else { 0.0 });
        set(HostileFault::Doubling, &mut rates.doubling, 0.05);
        set(HostileFault::Swap, &mut rates.swap, if counts { 0.1 } else { 0.0 });
        set(HostileFault::Noise, &mut rates.noise, 0.02);
        if to_host {
            set(HostileFault::Lie, &mut rates.lie, if counts { 0.2 } else { 0.0 });
        }
        let damage = if to_host { HostileFault::DamageToHost } else { HostileFault::DamageToController };
        set(damage, &mut rates.damage, 0.005);
        rates.kind = match (checked, to_host) {
            // Zaber's checksum has one byte. Two damaged bytes can cancel in it, without detection: see
            // docs/safety/assumptions.md.
            (true, _) => ByteDamage::One,
            (false, true) => ByteDamage::Any,
            (false, false) => ByteDamage::Detectable,
        };
        rates.delay_max = Duration::from_secs(10);
        if !to_host && self.has(HostileFault::AlteredDigit) {
            rates = Rates { damage: chance(0.03), kind: ByteDamage::Digit, ..rates };
        }
        rates
    }
}

/// Startup lines of the controller. A session refuses lines that change the meaning of later lines, or start
/// a motion. It accepts the last pair.
const STARTUP: [[&str; 2]; 6] =
    [["G20", ""], ["G91", ""], ["G55", "G80"], ["G80", "G1F500"], ["", "G92X1"], ["G17G21", "G80"]];

/// The controller's deviations from the plainest one. A session without faults has no quirk that ends it.
fn quirks(faults: &[HostileFault], random: &mut Rng) -> Quirks {
    let startup = if faults.contains(&HostileFault::Reset) && random.u8(0..4) == 0 {
        STARTUP[random.usize(0..STARTUP.len())]
    } else {
        ["", ""]
    };
    let resets = faults.contains(&HostileFault::Reset);
    Quirks {
        plain_hold: random.bool(),
        idle_delay: Duration::from_millis([0, 25][random.usize(0..2)]),
        startup: startup.map(str::to_owned),
        silent_reset: random.bool(),
        wakes_unlocked: resets && random.u8(0..4) == 0,
        stops_run_away: random.u8(0..4) != 0,
    }
}
