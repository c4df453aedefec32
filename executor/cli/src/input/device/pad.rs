//! The state of a device, from its events.

use std::collections::BTreeSet;

use keepout_executor::supervisor::OperatorCommand;

use super::map::{Action, Mapping};
use crate::input::handwheel::Handwheel;

/// An event, as the device says it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RawEvent {
    /// An absolute axis stands at a value.
    Axis {
        /// Its code.
        code: u16,
        /// Where it stands, in the device's own units.
        value: i32,
    },
    /// A button went down or up.
    Button {
        /// Its code.
        code: u16,
        /// Down.
        down: bool,
    },
    /// A dial was turned.
    Turned {
        /// Its code.
        code: u16,
        /// By so many pulses.
        pulses: i32,
    },
    /// What was said since the last report belongs together, and is so now (`SYN_REPORT`).
    Report,
    /// Events were lost (`SYN_DROPPED`): nothing is known until the device is asked for its whole state.
    Dropped,
}

/// The values that an axis takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AxisRange {
    /// Least value.
    pub low: i32,
    /// Largest value.
    pub high: i32,
}

impl AxisRange {
    /// The value as a share of the throw from the middle, −1 to 1; `None` when the range is empty.
    #[must_use]
    pub fn share(self, value: i32) -> Option<f64> {
        let (low, high) = (f64::from(self.low), f64::from(self.high));
        let half = (high - low) / 2.0;
        (half > 0.0).then(|| ((f64::from(value) - f64::midpoint(low, high)) / half).clamp(-1.0, 1.0))
    }
}

/// The whole state of a device at a moment.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Snapshot {
    /// The stick's axes x and y with their ranges and values; `None` for a device without a stick.
    pub axes: Option<[(AxisRange, i32); 2]>,
    /// Buttons that are down.
    pub buttons: BTreeSet<u16>,
}

/// Asks that are kept until they are taken.
const ASKS_MAX: usize = 8;

/// What is known of a device: reports take effect as a whole; after lost events nothing is known until
/// [`Self::resynchronise`].
#[derive(Clone, Debug, PartialEq)]
pub struct Pad {
    mapping: Mapping,
    state: Snapshot,
    open: Vec<RawEvent>,
    in_step: bool,
    automatic: bool,
    asks: Vec<OperatorCommand>,
    wheel: Handwheel,
}

/// Events of one report that are kept; a device that says more is asked for its whole state instead.
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
            automatic: false,
            asks: Vec::new(),
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

    /// Nothing is known any more: lost events, or the device is gone. Automatic mode is off.
    pub fn lose(&mut self) {
        self.in_step = false;
        self.automatic = false;
        self.open.clear();
        self.wheel.forget();
    }

    /// Whether the state is known.
    #[must_use]
    pub fn in_step(&self) -> bool {
        self.in_step
    }

    /// Takes the device's whole state. A button that is found down was not necessarily pressed for its action, so none
    /// is begun.
    pub fn resynchronise(&mut self, snapshot: Snapshot) {
        self.open.clear();
        self.state = snapshot;
        self.in_step = true;
    }

    /// The stick's raw axes, −1 to 1, up is +y; zero when they are not known or there is no stick.
    #[must_use]
    pub fn axes(&self) -> (f64, f64) {
        let Some([x, y]) = self.state.axes.filter(|_| self.in_step) else { return (0.0, 0.0) };
        let share = |(range, value): (AxisRange, i32)| range.share(value).unwrap_or(0.0);
        // A stick pushed away says less in y; in the drawing that is up.
        (share(x), -share(y))
    }

    /// Whether a dead-man button is held, for certain.
    #[must_use]
    pub fn dead_man(&self) -> bool {
        self.in_step && self.mapping.dead_men().any(|code| self.state.buttons.contains(&code))
    }

    /// Whether automatic mode is on.
    #[must_use]
    pub fn automatic(&self) -> bool {
        self.automatic
    }

    /// What was asked for since this was last called, in order.
    pub fn take_asks(&mut self) -> Vec<OperatorCommand> {
        std::mem::take(&mut self.asks)
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
            Action::DeadMan => {}
            Action::Automatic => self.automatic = !self.automatic,
            Action::OperatorCommand(ask) if self.asks.len() < ASKS_MAX => self.asks.push(ask),
            Action::OperatorCommand(_) => {}
            Action::WheelAxis => self.wheel.swap_axis(),
            Action::WheelStep => self.wheel.set_step(self.wheel.step().next()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::input::handwheel::{StepSize, WheelAxis};

    const TL: u16 = 0x136;
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
    fn a_report_counts_as_a_whole_and_up_is_plus_y() {
        let mut pad = pad();
        feed(&mut pad, &[RawEvent::Axis { code: 0, value: 32767 }, button(TL, true)]);
        assert!(pad.axes().0.abs() < 1e-4 && !pad.dead_man(), "not before the report");
        feed(&mut pad, &[RawEvent::Axis { code: 1, value: -32768 }, RawEvent::Report]);
        assert_eq!(pad.axes(), (1.0, 1.0));
        assert!(pad.dead_man());
        feed(&mut pad, &[button(TL, false), RawEvent::Report]);
        assert!(!pad.dead_man());
    }

    #[test]
    fn ranges_of_all_kinds_become_shares() {
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
    fn after_lost_events_nothing_is_known_until_the_state_is_read() {
        let mut pad = pad();
        feed(&mut pad, &[RawEvent::Axis { code: 0, value: 32767 }, button(TL, true), button(START, true)]);
        feed(&mut pad, &[RawEvent::Report]);
        assert!(pad.dead_man() && pad.automatic());
        feed(&mut pad, &[RawEvent::Dropped]);
        assert!(!pad.in_step() && !pad.dead_man() && !pad.automatic());
        assert_eq!(pad.axes(), (0.0, 0.0));
        // What is left of the torn report counts for nothing.
        feed(&mut pad, &[button(TL, true), button(EAST, true), RawEvent::Report]);
        assert!(!pad.dead_man() && pad.take_asks().is_empty());
        let range = AxisRange { low: 0, high: 200 };
        pad.resynchronise(Snapshot {
            axes: Some([(range, 150), (range, 100)]),
            buttons: BTreeSet::from([TL, EAST]),
        });
        assert_eq!(pad.axes(), (0.5, 0.0));
        assert!(pad.dead_man() && pad.take_asks().is_empty());
    }

    #[test]
    fn buttons_act_once_per_press() {
        let mut pad = pad();
        let presses = [button(EAST, true), RawEvent::Report, button(EAST, true), RawEvent::Report];
        feed(&mut pad, &presses);
        assert_eq!(pad.take_asks(), [OperatorCommand::FeedHold], "a repeated event is no second press");
        feed(&mut pad, &[button(EAST, false), RawEvent::Report]);
        feed(&mut pad, &presses);
        assert_eq!(pad.take_asks(), [OperatorCommand::FeedHold]);
        for _ in 0..100 {
            feed(&mut pad, &[button(EAST, false), button(EAST, true), RawEvent::Report]);
        }
        assert_eq!(pad.take_asks().len(), ASKS_MAX);
    }

    #[test]
    fn the_dial_turns_the_wheel() {
        let mut pad = pad();
        let turned = |pulses| RawEvent::Turned { code: 7, pulses };
        feed(&mut pad, &[turned(2), RawEvent::Report, button(0x100, true), button(0x101, true)]);
        feed(&mut pad, &[RawEvent::Report, turned(-1), RawEvent::Turned { code: 0, pulses: 9 }]);
        feed(&mut pad, &[RawEvent::Report]);
        assert_eq!((pad.wheel().axis(), pad.wheel().step()), (WheelAxis::Y, StepSize::Millimetre));
        assert_eq!(pad.wheel().take_mm(), (0.2, -1.0));
    }

    #[test]
    fn a_device_that_never_reports_is_out_of_step_rather_than_out_of_memory() {
        let mut pad = pad();
        (0..10_000).for_each(|value| pad.take(RawEvent::Axis { code: 0, value }));
        assert!(!pad.in_step() && pad.open.is_empty());
    }

    #[test]
    fn whatever_the_device_says_the_axes_are_bounded_and_a_dead_man_is_certain() {
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
            let (x, y) = pad.axes();
            assert!(x.abs() <= 1.0 && y.abs() <= 1.0);
            assert!(pad.in_step() || !pad.dead_man() && !pad.automatic() && (x, y) == (0.0, 0.0));
            let (dx, dy) = pad.wheel().take_mm();
            assert!(dx.abs() <= 10.0 && dy.abs() <= 10.0);
            if !pad.in_step() && random.u8(0..5) == 0 {
                let range = AxisRange { low: random.i32(..), high: random.i32(..) };
                let axes = Some([(range, random.i32(..)); 2]);
                pad.resynchronise(Snapshot { axes, buttons: BTreeSet::from([TL]) });
            }
        }
    }
}
