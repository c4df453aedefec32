//! The state of a device, from its events.

use std::collections::BTreeSet;

use keepout_executor::supervisor::OperatorCommand;
use keepout_planner::Mm2;

use super::map::{Action, Lift, Mapping};
use crate::input::handwheel::Handwheel;

/// An event of a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RawEvent {
    /// An absolute axis changed its value.
    Axis {
        /// Its code.
        code: u16,
        /// The new value, in the device's own units.
        value: i32,
    },
    /// A button went down or up.
    Button {
        /// Its code.
        code: u16,
        /// Whether the button is down.
        down: bool,
    },
    /// A dial was turned.
    Turned {
        /// Its code.
        code: u16,
        /// Number of pulses, with its sign.
        pulses: i32,
    },
    /// End of a report: the events since the last one take effect together (`SYN_REPORT`).
    Report,
    /// Events were lost (`SYN_DROPPED`). The state is unknown until it is read from the device.
    Dropped,
}

/// Range of an axis, in the device's own units.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AxisRange {
    /// Least value.
    pub low: i32,
    /// Largest value.
    pub high: i32,
}

impl AxisRange {
    /// The value as a share of the throw from the centre, −1 to 1. `None` if the range is empty.
    #[must_use]
    pub fn share(self, value: i32) -> Option<f64> {
        let (low, high) = (f64::from(self.low), f64::from(self.high));
        let half = (high - low) / 2.0;
        (half > 0.0).then(|| ((f64::from(value) - f64::midpoint(low, high)) / half).clamp(-1.0, 1.0))
    }
}

/// The whole state of a device at one time.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Snapshot {
    /// The stick's axes x and y, with their ranges and values. `None` for a device without a stick.
    pub axes: Option<[(AxisRange, i32); 2]>,
    /// Codes of the buttons that are down.
    pub buttons: BTreeSet<u16>,
}

/// Most commands that are kept until a reading takes them.
const COMMANDS_MAX: usize = 8;

/// State of a device, from its events. Each report takes effect as a whole. After lost events the state is
/// unknown until [`Self::resynchronise`].
#[derive(Clone, Debug, PartialEq)]
pub struct Pad {
    mapping: Mapping,
    state: Snapshot,
    /// Events of the unfinished report.
    open: Vec<RawEvent>,
    /// Whether the state is known.
    in_step: bool,
    armed: bool,
    commands: Vec<OperatorCommand>,
    wheel: Handwheel,
}

/// Share of full speed of the buttons that move the third axis.
const LIFT_SHARE: f64 = 0.3;

/// Most events of one report. If a device sends more, its whole state is read instead.
const REPORT_MAX: usize = 256;

impl Pad {
    /// A device whose state is not known yet.
    #[must_use]
    pub fn new(mapping: Mapping) -> Self {
        Self {
            mapping,
            state: Snapshot::default(),
            open: Vec::new(),
            in_step: false,
            armed: false,
            commands: Vec::new(),
            wheel: Handwheel::default(),
        }
    }

    /// Takes an event.
    pub fn take(&mut self, event: RawEvent) {
        match event {
            RawEvent::Dropped => self.lose(),
            RawEvent::Report => {
                for event in std::mem::take(&mut self.open) {
                    self.apply(event);
                }
            }
            _ if !self.in_step => {}
            _ if self.open.len() >= REPORT_MAX => self.lose(),
            event => self.open.push(event),
        }
    }

    /// Marks the state as unknown, after lost events or an unplugged device. Disarms the cycle.
    pub fn lose(&mut self) {
        self.in_step = false;
        self.armed = false;
        self.open.clear();
        self.wheel.forget();
    }

    /// Whether the state is known.
    #[must_use]
    pub fn in_step(&self) -> bool {
        self.in_step
    }

    /// Takes the device's whole state. A button that is already down starts no action, because the operator
    /// may have pressed it before.
    pub fn resynchronise(&mut self, snapshot: Snapshot) {
        self.open.clear();
        self.state = snapshot;
        self.in_step = true;
    }

    /// The stick's raw axes, −1 to 1. Up is +y. Zero if the state is unknown, or if the device has no stick.
    #[must_use]
    pub fn axes(&self) -> Mm2 {
        let Some([x, y]) = self.state.axes.filter(|_| self.in_step) else { return Mm2::ZERO };
        let share = |(range, value): (AxisRange, i32)| range.share(value).unwrap_or(0.0);
        // A stick that is pushed away has a smaller y value. In the drawing this direction is +y.
        Mm2::new(share(x), -share(y))
    }

    /// Whether a dead-man button is held. False if the state is unknown.
    #[must_use]
    pub fn dead_man(&self) -> bool {
        self.holds(Action::DeadMan)
    }

    /// Speed along the third axis that the held buttons ask for, as a share of full speed, upward. Zero if the
    /// state is unknown.
    #[must_use]
    pub fn up(&self) -> f64 {
        let held = |lift| if self.holds(Action::Lift(lift)) { LIFT_SHARE } else { 0.0 };
        held(Lift::Up) - held(Lift::Down)
    }

    fn holds(&self, action: Action) -> bool {
        self.in_step && self.mapping.with(action).any(|code| self.state.buttons.contains(&code))
    }

    /// Whether the cycle is armed.
    #[must_use]
    pub fn armed(&self) -> bool {
        self.armed
    }

    /// Disarms the cycle.
    pub fn disarm(&mut self) {
        self.armed = false;
    }

    /// Takes the commands since the last call, in order.
    pub fn take_commands(&mut self) -> Vec<OperatorCommand> {
        std::mem::take(&mut self.commands)
    }

    /// The handwheel.
    pub fn wheel(&mut self) -> &mut Handwheel {
        &mut self.wheel
    }

    fn apply(&mut self, event: RawEvent) {
        match event {
            RawEvent::Axis { code, value } => {
                let Some(axes) = &mut self.state.axes else { return };
                let index = [self.mapping.axes.0, self.mapping.axes.1].iter().position(|&axis| axis == code);
                if let Some(index) = index {
                    axes[index].1 = value;
                }
            }
            RawEvent::Button { code, down: false } => {
                self.state.buttons.remove(&code);
            }
            RawEvent::Button { code, down: true } => {
                if let Some(action) = self.mapping.action(code)
                    && self.state.buttons.insert(code)
                {
                    self.press(action);
                }
            }
            RawEvent::Turned { code, pulses } if self.mapping.wheels.contains(&code) => {
                self.wheel.turn(pulses);
            }
            RawEvent::Turned { .. } | RawEvent::Report | RawEvent::Dropped => {}
        }
    }

    fn press(&mut self, action: Action) {
        match action {
            Action::DeadMan | Action::Lift(_) => {}
            Action::Arm => self.armed = !self.armed,
            Action::OperatorCommand(command) if self.commands.len() < COMMANDS_MAX => {
                self.commands.push(command);
            }
            Action::OperatorCommand(_) => {}
            Action::WheelAxis => self.wheel.next_axis(),
            Action::WheelStep => self.wheel.set_step(self.wheel.step().next()),
        }
    }
}

#[cfg(test)]
mod tests {
    use keepout_planner::Mm3;

    use super::*;
    use crate::input::handwheel::{StepSize, WheelAxis};

    const TL: u16 = 0x136;
    const TL2: u16 = 0x138;
    const TR2: u16 = 0x139;
    const START: u16 = 0x13b;
    const EAST: u16 = 0x131;

    fn pad() -> Pad {
        let range = AxisRange { low: -32768, high: 32767 };
        let mut pad = Pad::new(Mapping::default());
        pad.resynchronise(Snapshot { axes: Some([(range, 0); 2]), buttons: BTreeSet::new() });
        pad
    }

    fn feed(pad: &mut Pad, events: &[RawEvent]) {
        events.iter().for_each(|&event| pad.take(event));
    }

    fn button(code: u16, down: bool) -> RawEvent {
        RawEvent::Button { code, down }
    }

    #[test]
    fn lower_shoulders_move_the_third_axis_while_they_are_held() {
        let mut pad = pad();
        let mut press = |code, down| {
            pad.take(RawEvent::Button { code, down });
            pad.take(RawEvent::Report);
            pad.up()
        };
        assert_eq!(press(TL2, true), -LIFT_SHARE);
        assert_eq!(press(TR2, true), 0.0, "both");
        assert_eq!(press(TL2, false), LIFT_SHARE);
        assert_eq!(press(TR2, false), 0.0);
        press(TR2, true);
        pad.lose();
        assert_eq!(pad.up(), 0.0);
    }

    #[test]
    fn report_takes_effect_as_a_whole_and_up_is_plus_y() {
        let mut pad = pad();
        feed(&mut pad, &[RawEvent::Axis { code: 0, value: 32767 }, button(TL, true)]);
        assert!(pad.axes().x.abs() < 1e-4 && !pad.dead_man(), "not before the report");
        feed(&mut pad, &[RawEvent::Axis { code: 1, value: -32768 }, RawEvent::Report]);
        assert_eq!(pad.axes(), Mm2::new(1.0, 1.0));
        assert!(pad.dead_man());
        feed(&mut pad, &[button(TL, false), RawEvent::Report]);
        assert!(!pad.dead_man());
    }

    #[test]
    fn every_axis_range_becomes_a_share() {
        for (low, high) in [(0, 255), (-127, 127), (0, 1023), (i32::MIN, i32::MAX), (100, 101)] {
            let range = AxisRange { low, high };
            assert_eq!(range.share(low), Some(-1.0));
            assert_eq!(range.share(high), Some(1.0));
            let middle = i32::try_from(i64::midpoint(low.into(), high.into())).unwrap();
            assert!(range.share(middle).unwrap().abs() <= 1.0);
        }
        assert_eq!(AxisRange { low: 5, high: 5 }.share(5), None);
        assert_eq!(AxisRange { low: 5, high: -5 }.share(5), None);
        assert_eq!(AxisRange { low: 0, high: 255 }.share(i32::MAX), Some(1.0));
    }

    #[test]
    fn after_lost_events_the_state_is_unknown_until_it_is_read() {
        let mut pad = pad();
        feed(&mut pad, &[RawEvent::Axis { code: 0, value: 32767 }, button(TL, true), button(START, true)]);
        feed(&mut pad, &[RawEvent::Report]);
        assert!(pad.dead_man() && pad.armed());
        feed(&mut pad, &[RawEvent::Dropped]);
        assert!(!pad.in_step() && !pad.dead_man() && !pad.armed());
        assert_eq!(pad.axes(), Mm2::ZERO);
        // The rest of the torn report has no effect.
        feed(&mut pad, &[button(TL, true), button(EAST, true), RawEvent::Report]);
        assert!(!pad.dead_man() && pad.take_commands().is_empty());
        let range = AxisRange { low: 0, high: 200 };
        pad.resynchronise(Snapshot {
            axes: Some([(range, 150), (range, 100)]),
            buttons: BTreeSet::from([TL, EAST]),
        });
        assert_eq!(pad.axes(), Mm2::new(0.5, 0.0));
        assert!(pad.dead_man() && pad.take_commands().is_empty());
    }

    #[test]
    fn buttons_act_once_per_press() {
        let mut pad = pad();
        let presses = [button(EAST, true), RawEvent::Report, button(EAST, true), RawEvent::Report];
        feed(&mut pad, &presses);
        assert_eq!(pad.take_commands(), [OperatorCommand::FeedHold], "a repeated event is no second press");
        feed(&mut pad, &[button(EAST, false), RawEvent::Report]);
        feed(&mut pad, &presses);
        assert_eq!(pad.take_commands(), [OperatorCommand::FeedHold]);
        for _ in 0..100 {
            feed(&mut pad, &[button(EAST, false), button(EAST, true), RawEvent::Report]);
        }
        assert_eq!(pad.take_commands().len(), COMMANDS_MAX);
    }

    #[test]
    fn dial_pulses_turn_the_handwheel() {
        let mut pad = pad();
        let turned = |pulses| RawEvent::Turned { code: 7, pulses };
        feed(&mut pad, &[turned(2), RawEvent::Report, button(0x100, true), button(0x101, true)]);
        feed(&mut pad, &[RawEvent::Report, turned(-1), RawEvent::Turned { code: 0, pulses: 9 }]);
        feed(&mut pad, &[RawEvent::Report]);
        assert_eq!((pad.wheel().axis(), pad.wheel().step()), (WheelAxis::Y, StepSize::Millimetre));
        assert_eq!(pad.wheel().take_mm(), Mm3::new(0.2, -1.0, 0.0));
    }

    #[test]
    fn events_without_a_report_are_bounded_and_make_the_state_unknown() {
        let mut pad = pad();
        (0..10_000).for_each(|value| pad.take(RawEvent::Axis { code: 0, value }));
        assert!(!pad.in_step() && pad.open.is_empty());
    }

    #[test]
    fn any_events_give_bounded_axes_and_an_unknown_state_releases_the_dead_man_button() {
        let mut random = fastrand::Rng::with_seed(11);
        let mut pad = pad();
        for _ in 0..20_000 {
            pad.take(match random.u8(0..40) {
                0 => RawEvent::Dropped,
                1..=10 => RawEvent::Report,
                11..=20 => RawEvent::Button { code: random.u16(0x100..0x140), down: random.bool() },
                21..=30 => RawEvent::Turned { code: random.u16(0..12), pulses: random.i32(..) },
                _ => RawEvent::Axis { code: random.u16(0..4), value: random.i32(..) },
            });
            let Mm2 { x, y } = pad.axes();
            assert!(x.abs() <= 1.0 && y.abs() <= 1.0);
            assert!(pad.in_step() || !pad.dead_man() && !pad.armed() && (x, y) == (0.0, 0.0));
            let Mm3 { x: dx, y: dy, z: dz } = pad.wheel().take_mm();
            assert!(dx.abs() <= 10.0 && dy.abs() <= 10.0 && dz.abs() <= 10.0);
            assert!(pad.up().abs() <= LIFT_SHARE && (pad.in_step() || pad.up() == 0.0));
            if !pad.in_step() && random.u8(0..5) == 0 {
                let range = AxisRange { low: random.i32(..), high: random.i32(..) };
                let axes = Some([(range, random.i32(..)); 2]);
                pad.resynchronise(Snapshot { axes, buttons: BTreeSet::from([TL]) });
            }
        }
    }
}
