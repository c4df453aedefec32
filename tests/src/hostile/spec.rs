//! What a session is made of, from a seed.

use std::time::Duration;

use fastrand::Rng;
use keepout_executor::supervisor::Abilities;
use keepout_sim::Quirks;
use keepout_sim::faults::{Damage, Rates};

use super::operator::Style;

/// Something that goes wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Fault {
    /// Pieces are held up, up to 10 s.
    Delay,
    /// Pieces are lost.
    Loss,
    /// Pieces arrive twice.
    Doubling,
    /// Pieces change places.
    Swap,
    /// Bytes to the host are damaged, into anything.
    DamageToHost,
    /// Bytes to the controller are damaged: into anything behind a checksum, else into what the controller refuses.
    DamageToController,
    /// Noise.
    Noise,
    /// An answer is replaced by an earlier one, now and then.
    Lie,
    /// The controller is reset.
    Reset,
    /// The controller raises an alarm.
    Alarm,
    /// Steps are lost, within the margin.
    LostSteps,
    /// The cable is pulled and put back.
    PortLoss,
    /// The program stands still for a while.
    Stall,
    /// The clock jumps ahead.
    Clock,
    /// The planner proposes contours that are wrong.
    Planner,
    /// The wrong baud rate for a while: nothing but rubbish.
    Baud,
}

impl Fault {
    /// The whole menu.
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

/// A session: everything about it follows from its seed and what was left out of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Spec {
    /// The seed of all but the drawing.
    pub seed: u64,
    /// What goes wrong in it.
    pub faults: Vec<Fault>,
    /// How the operator steers.
    pub style: Style,
    /// Whether the operator lets the contour be cut.
    pub automatic: bool,
    /// How long it lasts.
    pub limit: Duration,
    /// Baud rate.
    pub baud: u32,
    /// Delay each way.
    pub latency: Duration,
    /// Whether the tool begins nearer than roughing allows.
    pub begins_inside: bool,
    /// Whether the tool is moved by feed drives, which follow late and never quite. They cost a thousand times what the rest
    /// does: one session in a thousand has them, and `--driven` gives them to all.
    pub driven: bool,
    /// What the controller does that controllers in use were seen to do.
    pub quirks: Quirks,
    /// Resets are power failures.
    pub power_fails: bool,
}

impl Spec {
    /// The session of this seed.
    #[must_use]
    pub fn of(seed: u64) -> Self {
        let mut random = Rng::with_seed(seed);
        let count = [0, 1, 1, 1, 2, 2, 3, 5][random.usize(0..8)];
        let mut faults = Fault::ALL.to_vec();
        random.shuffle(&mut faults);
        faults.truncate(count);
        let automatic = random.u8(0..3) == 0;
        let limit = if automatic { random.u64(20..80) } else { random.u64(6..40) };
        // From 1 ms to 3 s, as many short ones as long.
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
            quirks,
            power_fails,
        }
    }

    fn has(&self, fault: Fault) -> bool {
        self.faults.contains(&fault)
    }

    /// Whether the fault is in it.
    #[must_use]
    pub fn suffers(&self, fault: Fault) -> bool {
        self.has(fault)
    }

    /// The rates of one direction's faults.
    #[must_use]
    pub fn rates(&self, to_host: bool, abilities: Abilities) -> Rates {
        let Abilities { checked, queues, .. } = abilities;
        let mut random = Rng::with_seed(self.seed ^ if to_host { 0x51 } else { 0xa7 });
        // From rare to often.
        let mut chance = |most: f64| most * 10.0_f64.powf(-2.5 * random.f64());
        let mut rates = Rates::default();
        let mut set = |fault, rate: &mut f64, most| {
            let value = chance(most);
            if self.has(fault) {
                *rate = value;
            }
        };
        // Where contours are queued and acknowledgements carry no number these are counted. What is repeated and also lost or
        // reordered within one round trip defeats that; that no line does both is assumed, see docs/safety/assumptions.md.
        let counts = checked || !queues || !self.suffers(Fault::Doubling);
        set(Fault::Delay, &mut rates.delay, 0.2);
        set(Fault::Loss, &mut rates.loss, if counts { 0.05 } else { 0.0 });
        set(Fault::Doubling, &mut rates.doubling, 0.05);
        set(Fault::Swap, &mut rates.swap, if counts { 0.1 } else { 0.0 });
        set(Fault::Noise, &mut rates.noise, 0.02);
        if to_host {
            set(Fault::Lie, &mut rates.lie, if counts { 0.2 } else { 0.0 });
        }
        let damage = if to_host { Fault::DamageToHost } else { Fault::DamageToController };
        set(damage, &mut rates.damage, 0.005);
        rates.kind = match (checked, to_host) {
            // Two damaged bytes can cancel in Zaber's sum, which is one byte, and then nobody can tell: see docs/safety/assumptions.md.
            (true, _) => Damage::One,
            (false, true) => Damage::Any,
            (false, false) => Damage::Detectable,
        };
        rates.delay_max = Duration::from_secs(10);
        rates
    }
}

/// Startup lines that a session refuses, each of which would change what later lines mean or start something; one that it does not.
const STARTUP: [[&str; 2]; 6] =
    [["G20", ""], ["G91", ""], ["G55", "G80"], ["G80", "G1F500"], ["", "G92X1"], ["G17G21", "G80"]];

/// How the controller differs from the plainest one. A session in which nothing goes wrong has no quirk that ends it.
fn quirks(faults: &[Fault], random: &mut Rng) -> Quirks {
    let startup = if faults.contains(&Fault::Reset) && random.u8(0..4) == 0 {
        STARTUP[random.usize(0..STARTUP.len())]
    } else {
        ["", ""]
    };
    let resets = faults.contains(&Fault::Reset);
    Quirks {
        plain_hold: random.bool(),
        idle_delay: Duration::from_millis([0, 25][random.usize(0..2)]),
        startup: startup.map(str::to_owned),
        silent_reset: random.bool(),
        wakes_unlocked: resets && random.u8(0..4) == 0,
        stops_run_away: random.u8(0..4) != 0,
    }
}
