//! The panel's socket: browsers that lie, repeat, reorder and stall, and the session that asks for the operator's
//! input. What moves the tool is a fresh input of the holder of the lease, who let go before.

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use arbitrary::{Arbitrary, Result, Unstructured};
use keepout_executor::operator::{Operator, OperatorView};
use keepout_executor::supervisor::{OperatorCommand, OperatorInput, Phase};
use keepout_guard::Time;
use keepout_panel::gate::{DELAY_MAX, INPUT_LIVES, MessageOrder, ROUND_TRIP_MAX, Steer};
use keepout_panel::hub::{Hub, PanelOperator, UNATTENDED};
use keepout_panel::lease::{ClientId, REQUEST_STANDS, SILENCE};
use keepout_panel::protocol::{Control, MESSAGE_MAX, PanelAction};
use keepout_planner::{Box2, Mm2};

use crate::import::check_message;
use crate::sketch::number;

/// Most steps of one input.
const STEPS_MAX: usize = 300;
/// Most browsers at once.
const BROWSERS_MAX: usize = 4;
/// Most commands that wait for the session.
const COMMANDS_MAX: usize = 8;
/// Longest step, mm.
const STEP_MM: f64 = 10.0;

/// A browser, and what the oracle remembers of it.
#[derive(Clone, Copy, Debug)]
struct Browser {
    id: ClientId,
    heard: Time,
    asked: Option<Time>,
    /// The greatest number and time stamp of its messages since it has control, and its least round trip.
    last: Option<(u64, u64)>,
    least: Option<Duration>,
}

/// The conversation, and what counts of it by the oracle.
struct Talk {
    clock: Arc<AtomicU64>,
    hub: Hub,
    operator: PanelOperator,
    browsers: Vec<Browser>,
    holder: Option<ClientId>,
    released: bool,
    /// The last input that counts, and when it came.
    input: Option<(Steer, Time)>,
    /// Number of steps since the session asked.
    steps: u32,
    commands: VecDeque<OperatorCommand>,
    attended: Time,
}

/// Lets browsers send any messages, in any order and at any time. Only the holder of the lease moves the tool, only
/// while its last input is fresh, and only after it let go. Nothing counts twice. Control changes hands by consent, by
/// silence or by leaving. A feed hold counts from everyone.
///
/// # Panics
/// When one of these does not hold.
pub fn panel(bytes: &[u8]) {
    let clock = Arc::new(AtomicU64::new(0));
    let hub = Hub::told(Arc::clone(&clock));
    let mut talk = Talk {
        operator: hub.operator(),
        clock,
        hub,
        browsers: Vec::new(),
        holder: None,
        released: false,
        input: None,
        steps: 0,
        commands: VecDeque::new(),
        attended: Time::ZERO,
    };
    let mut u = Unstructured::new(bytes);
    for _ in 0..STEPS_MAX {
        if u.is_empty() || talk.step(&mut u).is_err() {
            break;
        }
    }
}

impl Talk {
    fn now(&self) -> Time {
        Time::from_micros(self.clock.load(Ordering::Relaxed))
    }

    fn step(&mut self, u: &mut Unstructured<'_>) -> Result<()> {
        match u.int_in_range(0..=15_u8)? {
            0 => self.join(),
            1 => self.leave(u)?,
            2 => {
                let ms = [1, 20, 100, 199, 200, 201, 500, 1999, 3001, 16_000][u.choose_index(10)?];
                self.clock.fetch_add(1000 * ms + u64::from(u8::arbitrary(u)?), Ordering::Relaxed);
            }
            3 => {
                let length = u.int_in_range(0..=200_usize)?.min(u.len());
                let text = String::from_utf8_lossy(u.bytes(length)?).into_owned();
                self.says(u, &text)?;
            }
            4 => {
                let actions = [
                    r#"{"type":"alive"}"#,
                    r#"{"type":"take_control"}"#,
                    r#"{"type":"give_control"}"#,
                    r#"{"type":"answer","consents":true}"#,
                    r#"{"type":"answer","consents":false}"#,
                ];
                let text = *u.choose(&actions)?;
                self.says(u, text)?;
            }
            5..8 => self.commands(u)?,
            8..12 => self.steers(u)?,
            _ => self.asks(u)?,
        }
        self.one_holds();
        Ok(())
    }

    fn join(&mut self) {
        if self.browsers.len() < BROWSERS_MAX {
            let now = self.now();
            let id = self.hub.join(now);
            self.browsers.push(Browser { id, heard: now, asked: None, last: None, least: None });
            if self.holder.is_none() {
                self.hands_over(Some(id));
                self.attended = now;
            }
        }
    }

    fn leave(&mut self, u: &mut Unstructured<'_>) -> Result<()> {
        if self.browsers.is_empty() {
            return Ok(());
        }
        let gone = self.browsers.remove(u.choose_index(self.browsers.len())?);
        self.hub.leave(gone.id);
        if self.holder == Some(gone.id) {
            self.hands_over(None);
        }
        Ok(())
    }

    /// What a message's order can be: mostly the next one, in time.
    fn order(&self, u: &mut Unstructured<'_>, browser: usize) -> Result<MessageOrder> {
        let (sequence, seen_us) = self.browsers[browser].last.unwrap_or((0, 0));
        let now = self.now().micros();
        Ok(MessageOrder {
            sequence: match u.int_in_range(0..=7_u8)? {
                0 => sequence,
                1 => sequence.wrapping_sub(1),
                2 => u64::arbitrary(u)?,
                _ => sequence.saturating_add(1),
            },
            seen_us: match u.int_in_range(0..=7_u8)? {
                0 => seen_us,
                1 => u64::arbitrary(u)?,
                2 => now.saturating_sub(u64::from(u16::arbitrary(u)?) * 40),
                3 => now + 1,
                _ => now.max(seen_us),
            },
        })
    }

    fn steers(&mut self, u: &mut Unstructured<'_>) -> Result<()> {
        if self.browsers.is_empty() {
            return Ok(());
        }
        let browser = u.choose_index(self.browsers.len())?;
        let MessageOrder { sequence, seen_us } = self.order(u, browser)?;
        let (held, armed) = (u.ratio(3, 4)?, bool::arbitrary(u)?);
        let mut any = || -> Result<f64> { if u.ratio(1, 2)? { Ok(0.5) } else { number(u) } };
        let numbers = [any()?, any()?, any()?, any()?, any()?, any()?];
        // JSON has no word for what is not finite.
        let [x, y, up, dx, dy, dz] = numbers.map(|value| if value.is_finite() { value } else { 1e300 });
        let text = format!(
            "{{\"type\":\"steer\",\"order\":{{\"sequence\":{sequence},\"seen_us\":{seen_us}}},\
             \"steer\":{{\"held\":{held},\"velocity\":[{x:e},{y:e}],\"up\":{up:e},\
             \"step_mm\":[{dx:e},{dy:e}],\"step_up_mm\":{dz:e},\"armed\":{armed}}}}}"
        );
        assert!(text.len() <= MESSAGE_MAX, "{text}");
        assert!(matches!(PanelAction::parse(&text), Ok(PanelAction::Steer { .. })), "{text}");
        self.said(browser, &text);
        Ok(())
    }

    fn commands(&mut self, u: &mut Unstructured<'_>) -> Result<()> {
        if self.browsers.is_empty() {
            return Ok(());
        }
        let browser = u.choose_index(self.browsers.len())?;
        let MessageOrder { sequence, seen_us } = self.order(u, browser)?;
        let words = [
            "\"feed_hold\"",
            "\"cycle_start\"",
            "\"recover\"",
            "\"raise\"",
            r#"{"cross":{"contour":2}}"#,
            r#"{"spindle":{"runs":true}}"#,
        ];
        let command = *u.choose(&words)?;
        let text = format!(
            "{{\"type\":\"command\",\"order\":{{\"sequence\":{sequence},\"seen_us\":{seen_us}}},\"command\":{command}}}"
        );
        assert!(matches!(PanelAction::parse(&text), Ok(PanelAction::Command { .. })), "{text}");
        self.said(browser, &text);
        Ok(())
    }

    fn says(&mut self, u: &mut Unstructured<'_>, text: &str) -> Result<()> {
        if !self.browsers.is_empty() {
            let browser = u.choose_index(self.browsers.len())?;
            self.said(browser, text);
        }
        Ok(())
    }

    /// A browser sends a text.
    fn said(&mut self, browser: usize, text: &str) {
        let action = match PanelAction::parse(text) {
            Ok(action) => action,
            Err(error) => return check_message(&error.to_string()),
        };
        let (now, id) = (self.now(), self.browsers[browser].id);
        let silent = self.holder_silent(now);
        self.browsers[browser].heard = now;
        if self.holder == Some(id) {
            self.attended = now;
        }
        let done = self.hub.act(id, action, now).is_ok();
        match action {
            PanelAction::Alive {} => assert!(done),
            PanelAction::Steer { order, steer } => {
                let counts = self.counts(browser, order, now);
                assert_eq!(done, counts, "{order:?} at {now:?}");
                if counts {
                    self.released |= !steer.held;
                    let steer = Steer { held: steer.held && self.released, ..steer };
                    self.steps = if steer.held { self.steps + 1 } else { 0 };
                    self.input = Some((steer, now));
                }
            }
            PanelAction::Command { order, command } => {
                let holds = command == OperatorCommand::FeedHold;
                let counts = self.counts(browser, order, now) || holds;
                if holds {
                    (self.input, self.steps) = (None, 0);
                    self.commands.clear();
                }
                let room = self.commands.len() < COMMANDS_MAX;
                assert_eq!(done, counts && room, "{command:?} at {now:?}");
                if done {
                    self.commands.push_back(command);
                }
            }
            PanelAction::TakeControl {} if self.holder == Some(id) => {}
            PanelAction::TakeControl {} if silent => {
                self.hands_over(Some(id));
                self.attended = now;
            }
            PanelAction::TakeControl {} => {
                // A later request takes the place of an earlier one.
                self.browsers.iter_mut().for_each(|browser| browser.asked = None);
                self.browsers[browser].asked = Some(now);
            }
            PanelAction::GiveControl {} => {
                self.browsers[browser].asked = None;
                if self.holder == Some(id) {
                    self.hands_over(None);
                }
            }
            PanelAction::Answer { consents } if self.holder == Some(id) => self.answered(consents, now),
            PanelAction::Answer { .. } => {}
        }
    }

    /// The holder answers the one that asks.
    fn answered(&mut self, consents: bool, now: Time) {
        let stands =
            |browser: &&Browser| browser.asked.is_some_and(|asked| now.since(asked) <= REQUEST_STANDS);
        let asks = self.browsers.iter().find(stands).map(|browser| browser.id);
        self.browsers.iter_mut().for_each(|browser| browser.asked = None);
        if consents && let Some(asks) = asks {
            self.hands_over(Some(asks));
            // It takes the lease now, so it is heard now.
            self.browsers
                .iter_mut()
                .filter(|browser| browser.id == asks)
                .for_each(|browser| browser.heard = now);
        }
    }

    fn holder_silent(&self, now: Time) -> bool {
        let holder = self.browsers.iter().find(|browser| Some(browser.id) == self.holder);
        holder.is_none_or(|holder| now.since(holder.heard) > SILENCE)
    }

    /// Another browser has control, or none: nothing of before counts.
    fn hands_over(&mut self, to: Option<ClientId>) {
        if self.holder == to {
            return;
        }
        (self.holder, self.released, self.input, self.steps) = (to, false, None, 0);
        self.commands.clear();
        for browser in self.browsers.iter_mut().filter(|browser| Some(browser.id) == to) {
            (browser.last, browser.least, browser.asked) = (None, None, None);
            browser.heard = self.hub.now();
        }
    }

    /// Whether a message counts: it is the holder's, newer than all before, and in time.
    fn counts(&mut self, browser: usize, order: MessageOrder, now: Time) -> bool {
        let browser = &mut self.browsers[browser];
        if Some(browser.id) != self.holder {
            return false;
        }
        let (newer, seen) = browser.last.map_or((true, 0), |(last, seen)| (order.sequence > last, seen));
        if !newer || order.seen_us < seen || order.seen_us > now.micros() {
            return false;
        }
        browser.last = Some((order.sequence, order.seen_us));
        let trip = Duration::from_micros(now.micros() - order.seen_us);
        let least = browser.least.map_or(trip, |least| least.min(trip));
        browser.least = Some(least);
        trip <= ROUND_TRIP_MAX && trip <= least + DELAY_MAX
    }

    /// The session asks for the input.
    fn asks(&mut self, u: &mut Unstructured<'_>) -> Result<()> {
        let phases = [
            Phase::Manual,
            Phase::Manual,
            Phase::Sliding,
            Phase::Retracting,
            Phase::Contouring,
            Phase::Holding,
            Phase::Faulted,
        ];
        let phase = *u.choose(&phases)?;
        let now = self.now();
        if !phase.is_steered() {
            (self.released, self.input, self.steps) = (false, None, 0);
        }
        let input = self.operator.input(&view(phase), now);
        let fresh = self.input.filter(|(_, at)| now.since(*at) <= INPUT_LIVES);
        let expected = fresh.map_or(Steer::default(), |(steer, _)| steer);
        let steer =
            if expected.held { expected } else { Steer { armed: expected.armed, ..Steer::default() } };
        let moves = OperatorInput { velocity: steer.velocity, up: steer.up, armed: steer.armed, ..input };
        assert_eq!(input, moves.finite(), "{:?} at {now:?}", self.input);
        let turned = [input.turned_mm.x, input.turned_mm.y, input.turned_up_mm];
        let most = if expected.held { STEP_MM * f64::from(self.steps) } else { 0.0 };
        assert!(turned.iter().all(|turn| turn.abs() <= most), "{turned:?} of {} steps", self.steps);
        (self.input, self.steps) = (fresh, 0);
        let command = self.operator.command();
        let alone = now.since(self.attended) > UNATTENDED && phase == Phase::Contouring;
        match self.commands.pop_front() {
            Some(sent) => assert_eq!(command, Some(sent)),
            None => assert!(
                command.is_none() || alone && command == Some(OperatorCommand::FeedHold),
                "{command:?} was never sent"
            ),
        }
        Ok(())
    }

    /// One browser has control at most, and it is the one that the oracle knows.
    fn one_holds(&self) {
        for browser in &self.browsers {
            let control = self.hub.control_of(browser.id, self.now());
            let holds = matches!(control, Control::Mine { .. });
            assert_eq!(holds, self.holder == Some(browser.id), "{control:?}");
        }
    }
}

/// What an operator sees of a session in a phase, without a position.
pub(crate) fn view(phase: Phase) -> OperatorView {
    OperatorView {
        position_mm: None,
        height_mm: None,
        wall_mm: None,
        part_box: Box2 { low: Mm2::ZERO, high: Mm2::new(100.0, 60.0) },
        end_mm: None,
        unacknowledged: 0,
        spindle_runs: false,
        phase,
        contoured: false,
    }
}
