//! The meeting place of the browsers and the session: the lease, the gate, and the state of the session.
//!
//! Implements SR-28.
//!
//! The session loop never waits here. It writes its state to a slot, and reads the gate only when no other thread just
//! holds it; otherwise it keeps the input of the round before, which expires by itself.

#[cfg(test)]
mod stall;

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use keepout_executor::operator::{Operator, OperatorView};
use keepout_executor::supervisor::{OperatorCommand, OperatorInput, Phase, Supervisor};
use keepout_guard::Time;

use crate::gate::{Gate, GateRefusal, INPUT_LIVES};
use crate::latest::Latest;
use crate::lease::{ClientId, Lease, LeaseAnswer};
use crate::protocol::{Control, PanelAction};
use crate::snapshot::{SessionState, seconds_left};

/// Time without anybody at the controls after which a contour is held.
pub const UNATTENDED: Duration = Duration::from_secs(10);

/// The meeting place. Clones share it.
#[derive(Clone, Debug)]
pub struct Hub(Arc<Shared>);

/// Where the time of a panel comes from.
#[derive(Debug)]
enum PanelClock {
    Real(Instant),
    /// A simulation tells the time, µs.
    Told(Arc<AtomicU64>),
}

#[derive(Debug)]
struct Shared {
    clock: PanelClock,
    control: Mutex<ControlDesk>,
    session: Latest<Option<(SessionState, Time)>>,
}

/// The lease and the gate, which change together.
#[derive(Debug, Default)]
struct ControlDesk {
    lease: Lease,
    gate: Gate,
    /// When the holder of the lease was last heard.
    attended: Time,
    next_client: u64,
}

impl Default for Hub {
    fn default() -> Self {
        Self::at(PanelClock::Real(Instant::now()))
    }
}

impl Hub {
    fn at(clock: PanelClock) -> Self {
        let control = Mutex::new(ControlDesk::default());
        Self(Arc::new(Shared { clock, control, session: Latest::new(None) }))
    }

    /// A hub of a simulation, which tells the time, µs.
    #[must_use]
    pub fn told(micros: Arc<AtomicU64>) -> Self {
        Self::at(PanelClock::Told(micros))
    }

    /// The time since the panel began.
    #[must_use]
    pub fn now(&self) -> Time {
        match &self.0.clock {
            PanelClock::Real(began) => Time::ZERO.after(began.elapsed()),
            PanelClock::Told(micros) => Time::from_micros(micros.load(Ordering::Relaxed)),
        }
    }

    fn desk(&self) -> MutexGuard<'_, ControlDesk> {
        self.0.control.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A new client. It takes control if nobody has it.
    #[must_use]
    pub fn join(&self, now: Time) -> ClientId {
        let mut desk = self.desk();
        desk.next_client += 1;
        let client = ClientId(desk.next_client);
        if desk.lease.holder().is_none() {
            desk.take(client, now);
        }
        client
    }

    /// A client is gone: what it sent no longer counts.
    pub fn leave(&self, client: ClientId) {
        self.desk().leave(client);
    }

    /// Does what a client asks for.
    ///
    /// # Errors
    /// [`GateRefusal`] when a jog input or a command does not count.
    pub fn act(&self, client: ClientId, action: PanelAction, now: Time) -> Result<(), GateRefusal> {
        self.desk().act(client, action, now)
    }

    /// Who has control, as a client sees it.
    #[must_use]
    pub fn control_of(&self, client: ClientId, now: Time) -> Control {
        let desk = self.desk();
        match desk.lease.holder() {
            None => Control::Free,
            Some(holder) if holder == client => Control::Mine { asked: desk.lease.request(now).is_some() },
            Some(_) => Control::Other { asking: desk.lease.request(now) == Some(client) },
        }
    }

    /// Shows a session to the browsers.
    #[must_use]
    pub fn window(&self) -> SessionWindow {
        SessionWindow { hub: self.clone(), due: Time::ZERO, left: (None, Time::ZERO) }
    }

    /// Takes note that no session runs.
    pub fn session_ended(&self) {
        // The session's thread has ended, so only a reader can hold the slot, for one copy.
        while !self.0.session.put(None) {
            std::thread::yield_now();
        }
    }

    /// The state of the session and its age. `None` without a session.
    #[must_use]
    pub fn session(&self) -> Option<(SessionState, Duration)> {
        let (state, written) = self.0.session.get().flatten()?;
        Some((state, self.now().since(written)))
    }

    /// The operator of a session: whoever holds the lease.
    #[must_use]
    pub fn operator(&self) -> PanelOperator {
        PanelOperator {
            hub: self.clone(),
            last: (OperatorInput::default(), Time::ZERO),
            command: None,
            attended: self.now(),
            holds: false,
        }
    }
}

impl ControlDesk {
    fn take(&mut self, client: ClientId, now: Time) {
        if self.lease.take(client, now) == LeaseAnswer::Granted {
            self.attended = now;
            self.gate.open_for(Some(client));
        }
    }

    fn leave(&mut self, client: ClientId) {
        self.lease.leave(client);
        self.gate.open_for(self.lease.holder());
    }

    fn act(&mut self, client: ClientId, action: PanelAction, now: Time) -> Result<(), GateRefusal> {
        self.lease.heard(client, now);
        if self.lease.is_held_by(client) {
            self.attended = now;
        }
        match action {
            PanelAction::Alive {} => Ok(()),
            PanelAction::Steer { order, steer } => self.gate.steer(client, order, steer, now),
            PanelAction::Command { order, command } => self.gate.command(client, order, command, now),
            PanelAction::TakeControl {} => {
                self.take(client, now);
                Ok(())
            }
            PanelAction::GiveControl {} => {
                self.leave(client);
                Ok(())
            }
            PanelAction::Answer { consents } => {
                self.lease.answer(client, consents, now);
                self.gate.open_for(self.lease.holder());
                Ok(())
            }
        }
    }
}

/// Time between two states of a session.
const SHOWN_EVERY: Duration = Duration::from_millis(20);
/// Time between two estimates of the time left.
const ESTIMATED_EVERY: Duration = Duration::from_millis(500);

/// Shows one session to the browsers. The session loop owns it.
#[derive(Debug)]
pub struct SessionWindow {
    hub: Hub,
    due: Time,
    /// The time that the rest of the contour takes, s, and when it was estimated.
    left: (Option<f64>, Time),
}

impl SessionWindow {
    /// Shows the state, at most fifty times a second. The session loop calls it after every round.
    pub fn show(&mut self, supervisor: &Supervisor) {
        let now = self.hub.now();
        if now < self.due {
            return;
        }
        self.due = now.after(SHOWN_EVERY);
        if now.since(self.left.1) >= ESTIMATED_EVERY {
            self.left = (seconds_left(supervisor), now);
        }
        self.hub.0.session.put(Some((SessionState::of(supervisor, self.left.0), now)));
    }
}

/// The operator of a session: the client that holds the lease.
#[derive(Debug)]
pub struct PanelOperator {
    hub: Hub,
    /// The last input, and when it was read.
    last: (OperatorInput, Time),
    command: Option<OperatorCommand>,
    /// When the holder of the lease was last heard, as far as this is known.
    attended: Time,
    /// The contour was held because nobody was at the controls.
    holds: bool,
}

impl PanelOperator {
    /// A feed hold, once, when nobody is at the controls while a contour is cut. A panel that stalls counts as nobody:
    /// its feed hold would not arrive.
    fn hold_when_alone(&mut self, phase: Phase, now: Time) {
        let holds = phase == Phase::Contouring && now.since(self.attended) > UNATTENDED;
        if holds && !self.holds {
            self.command = self.command.or(Some(OperatorCommand::FeedHold));
        }
        self.holds = holds;
    }
}

impl Operator for PanelOperator {
    fn input(&mut self, view: &OperatorView, _now: Time) -> OperatorInput {
        let now = self.hub.now();
        let read = if let Ok(mut desk) = self.hub.0.control.try_lock() {
            // Without a phase that is steered, the tool moves by itself or rests.
            if !view.phase.is_steered() {
                desk.gate.require_release();
            }
            self.last = (desk.gate.input(now), now);
            self.command = desk.gate.next_command();
            self.attended = desk.attended;
            true
        } else {
            false
        };
        self.hold_when_alone(view.phase, now);
        let (input, at) = self.last;
        if read {
            return input;
        }
        // A browser's thread is just here. The steps of the round before were counted then.
        if now.since(at) > INPUT_LIVES || !view.phase.is_steered() {
            return OperatorInput::default();
        }
        OperatorInput { turned_mm: keepout_planner::Mm2::ZERO, turned_up_mm: 0.0, ..input }
    }

    fn command(&mut self) -> Option<OperatorCommand> {
        self.command.take()
    }
}

#[cfg(test)]
mod tests {
    use keepout_planner::{Box2, Mm2};

    use super::*;
    use crate::gate::{MessageOrder, Steer};

    fn view(phase: Phase) -> OperatorView {
        OperatorView {
            position_mm: None,
            height_mm: None,
            wall_mm: None,
            part_box: Box2 { low: Mm2::ZERO, high: Mm2::ZERO },
            end_mm: None,
            unacknowledged: 0,
            spindle_runs: false,
            phase,
            contoured: false,
        }
    }

    fn push(hub: &Hub, client: ClientId, sequence: u64) -> Result<(), GateRefusal> {
        let now = hub.now();
        let order = MessageOrder { sequence: 2 * sequence, seen_us: now.micros() };
        let steer = Steer::default();
        hub.act(client, PanelAction::Steer { order, steer }, now)?;
        let order = MessageOrder { sequence: 2 * sequence + 1, seen_us: now.micros() };
        let steer = Steer { held: true, velocity: Mm2::new(1.0, 0.0), ..Steer::default() };
        hub.act(client, PanelAction::Steer { order, steer }, now)
    }

    fn moves(operator: &mut PanelOperator) -> bool {
        operator.input(&view(Phase::Manual), Time::ZERO).velocity != Mm2::ZERO
    }

    #[test]
    fn first_client_steers_and_the_second_watches_until_the_first_is_gone() {
        let hub = Hub::default();
        let (one, two) = (hub.join(hub.now()), hub.join(hub.now()));
        let mut operator = hub.operator();
        push(&hub, one, 1).unwrap();
        assert!(moves(&mut operator));
        assert_eq!(push(&hub, two, 1), Err(GateRefusal::NotHolder));
        assert_eq!(hub.control_of(two, hub.now()), Control::Other { asking: false });
        hub.leave(one);
        assert!(!moves(&mut operator), "a socket that is gone stops the tool");
        assert_eq!(hub.control_of(two, hub.now()), Control::Free);
        hub.act(two, PanelAction::TakeControl {}, hub.now()).unwrap();
        push(&hub, two, 2).unwrap();
        assert!(moves(&mut operator));
    }

    // Evidence for SR-28.
    /// A thread that keeps the desk busy for long stops the tool, and the session loop does not wait for it.
    #[test]
    fn stalled_panel_stops_the_tool_and_not_the_session() {
        let hub = Hub::default();
        let client = hub.join(hub.now());
        let mut operator = hub.operator();
        push(&hub, client, 1).unwrap();
        assert!(moves(&mut operator));
        let stalled = hub.clone();
        let desk = stalled.desk();
        assert!(moves(&mut operator), "the input of the round before counts while it is fresh");
        std::thread::sleep(INPUT_LIVES + Duration::from_millis(5));
        assert!(!moves(&mut operator));
        drop(desk);
        push(&hub, client, 2).unwrap();
        assert!(moves(&mut operator));
    }

    #[test]
    fn contour_is_held_once_when_nobody_is_at_the_controls() {
        let clock = Arc::new(AtomicU64::new(0));
        let hub = Hub::told(Arc::clone(&clock));
        let client = hub.join(hub.now());
        let mut operator = hub.operator();
        let held = |operator: &mut PanelOperator| {
            operator.input(&view(Phase::Contouring), Time::ZERO);
            operator.command()
        };
        assert_eq!(held(&mut operator), None);
        hub.leave(client);
        let later = |seconds: u64| clock.store(seconds * 1_000_000, Ordering::Relaxed);
        later(10);
        assert_eq!(held(&mut operator), None);
        later(11);
        assert_eq!(held(&mut operator), Some(OperatorCommand::FeedHold));
        assert_eq!(held(&mut operator), None, "once");
        let back = hub.join(hub.now());
        assert_eq!(held(&mut operator), None);
        hub.leave(back);
        assert_eq!(held(&mut operator), None, "somebody was there just now");
    }
}
