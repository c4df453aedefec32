//! The gate between the browsers and the operator's input: it takes what the holder of the control lease sends, in
//! order and in time.
//!
//! Implements SR-28.
//!
//! An input counts only while it is fresh. It expires [`INPUT_LIVES`] after it arrived. An input that a stalled network
//! delivers late does not count: each message repeats the time stamp of the last state that the client has seen, and
//! [`DELAY_MAX`] beyond the least round trip of this client it is too late.

use std::time::Duration;

use arrayvec::ArrayVec;
use keepout_executor::supervisor::{OperatorCommand, OperatorInput};
use keepout_guard::Time;
use keepout_planner::Mm2;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::lease::ClientId;

/// Time after which an input no longer counts.
pub const INPUT_LIVES: Duration = Duration::from_millis(200);
/// Greatest delay of a message beyond the least round trip of its client.
pub const DELAY_MAX: Duration = Duration::from_millis(200);
/// Greatest round trip of any message that moves the tool.
pub const ROUND_TRIP_MAX: Duration = Duration::from_secs(2);
/// Most commands that wait for the session.
const COMMANDS_MAX: usize = 8;
/// Greatest way of the tool for one message, by step buttons, mm.
const STEP_MAX_MM: f64 = 10.0;

/// Where a message stands in its client's order.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MessageOrder {
    /// Number of the message. Each is greater than the one before.
    pub sequence: u64,
    /// Time stamp of the last state that the client has seen, µs.
    pub seen_us: u64,
}

/// The jog input of a client.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Steer {
    /// Whether the person holds the enabling control.
    pub held: bool,
    /// Jog velocity as a share of full speed.
    pub velocity: Mm2,
    /// Speed along the third axis as a share of its full speed, upward when positive.
    pub up: f64,
    /// Steps in the plane, mm.
    pub step_mm: Mm2,
    /// Steps along the third axis, mm.
    pub step_up_mm: f64,
    /// Whether the cycle is armed.
    pub armed: bool,
}

/// Why a message of a client does not count.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum GateRefusal {
    /// The client does not hold the control lease.
    #[error("another screen has control")]
    NotHolder,
    /// Its number is not greater than the one before, or its time stamp is impossible.
    #[error("a message came twice or out of order")]
    OutOfOrder,
    /// It was under way for too long.
    #[error("a message came too late: the connection stalls")]
    Late,
    /// Too many commands wait.
    #[error("too many commands at once")]
    TooMany,
}

/// What a client has sent.
#[derive(Clone, Copy, Debug)]
struct Sender {
    client: ClientId,
    sequence: Option<u64>,
    seen_us: u64,
    least: Option<Duration>,
}

/// The gate.
#[derive(Clone, Debug, Default)]
pub struct Gate {
    sender: Option<Sender>,
    /// The holder has let go since it got the gate, and since the tool last moved by itself. Before, nothing that it
    /// holds counts.
    released: bool,
    input: Option<(Steer, Time)>,
    /// Steps that the session has not taken, in the plane and upward.
    steps: (Mm2, f64),
    commands: ArrayVec<OperatorCommand, COMMANDS_MAX>,
}

impl Gate {
    /// Gives the gate to another holder of the lease. What the one before sent no longer counts.
    pub fn open_for(&mut self, holder: Option<ClientId>) {
        if self.sender.map(|sender| sender.client) != holder {
            let sender = |client| Sender { client, sequence: None, seen_us: 0, least: None };
            *self = Self { sender: holder.map(sender), ..Self::default() };
        }
    }

    /// The tool moves by itself now. What is held meanwhile does not count after it.
    pub fn require_release(&mut self) {
        self.released = false;
        self.input = None;
        self.steps = (Mm2::ZERO, 0.0);
    }

    /// Takes a jog input.
    ///
    /// # Errors
    /// [`GateRefusal`] when it does not count. The input before it then stays, until it expires.
    pub fn steer(
        &mut self,
        client: ClientId,
        order: MessageOrder,
        steer: Steer,
        now: Time,
    ) -> Result<(), GateRefusal> {
        self.in_order(client, order, now)?;
        let finite = |value: f64| if value.is_finite() { value } else { 0.0 };
        self.released |= !steer.held;
        let steer = Steer { held: steer.held && self.released, ..steer };
        if steer.held {
            let step = |value: f64| finite(value).clamp(-STEP_MAX_MM, STEP_MAX_MM);
            let (plane, up) = self.steps;
            self.steps =
                (plane + Mm2::new(step(steer.step_mm.x), step(steer.step_mm.y)), up + step(steer.step_up_mm));
        } else {
            self.steps = (Mm2::ZERO, 0.0);
        }
        self.input = Some((steer, now));
        Ok(())
    }

    /// Takes a command. A feed hold counts from every client and at any age.
    ///
    /// # Errors
    /// [`GateRefusal`] when it does not count.
    pub fn command(
        &mut self,
        client: ClientId,
        order: MessageOrder,
        command: OperatorCommand,
        now: Time,
    ) -> Result<(), GateRefusal> {
        let checked = self.in_order(client, order, now);
        if command != OperatorCommand::FeedHold {
            checked?;
        }
        if command == OperatorCommand::FeedHold {
            // The hold also drops the commands before it.
            self.commands.clear();
            self.input = None;
            self.steps = (Mm2::ZERO, 0.0);
        }
        self.commands.try_push(command).map_err(|_| GateRefusal::TooMany)
    }

    /// Checks that a message is the holder's, newer than all before it, and not late.
    fn in_order(&mut self, client: ClientId, order: MessageOrder, now: Time) -> Result<(), GateRefusal> {
        let sender = self.sender.as_mut().filter(|sender| sender.client == client);
        let sender = sender.ok_or(GateRefusal::NotHolder)?;
        let newer = sender.sequence.is_none_or(|last| order.sequence > last);
        if !newer || order.seen_us < sender.seen_us || order.seen_us > now.micros() {
            return Err(GateRefusal::OutOfOrder);
        }
        (sender.sequence, sender.seen_us) = (Some(order.sequence), order.seen_us);
        let round_trip = now.since(Time::from_micros(order.seen_us));
        let least = sender.least.map_or(round_trip, |least| least.min(round_trip));
        sender.least = Some(least);
        if round_trip > ROUND_TRIP_MAX || round_trip > least + DELAY_MAX {
            return Err(GateRefusal::Late);
        }
        Ok(())
    }

    /// The operator's input at `now`. Steps count once.
    pub fn input(&mut self, now: Time) -> OperatorInput {
        let steps = std::mem::take(&mut self.steps);
        let fresh = self.input.filter(|(_, at)| now.since(*at) <= INPUT_LIVES);
        self.input = fresh;
        let Some((steer, _)) = fresh else { return OperatorInput::default() };
        if !steer.held {
            return OperatorInput { armed: steer.armed, ..OperatorInput::default() };
        }
        OperatorInput {
            velocity: steer.velocity,
            turned_mm: steps.0,
            up: steer.up,
            turned_up_mm: steps.1,
            armed: steer.armed,
        }
        .finite()
    }

    /// The next command.
    pub fn next_command(&mut self) -> Option<OperatorCommand> {
        self.commands.pop_at(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ONE: ClientId = ClientId(1);
    const PUSH: Steer = Steer {
        held: true,
        velocity: Mm2::new(1.0, 0.0),
        up: 0.0,
        step_mm: Mm2::ZERO,
        step_up_mm: 0.0,
        armed: false,
    };

    fn at(ms: u64) -> Time {
        Time::ZERO.after(Duration::from_millis(ms))
    }

    fn order(sequence: u64, seen_ms: u64) -> MessageOrder {
        MessageOrder { sequence, seen_us: seen_ms * 1000 }
    }

    fn gate() -> Gate {
        let mut gate = Gate::default();
        gate.open_for(Some(ONE));
        gate.steer(ONE, order(0, 0), Steer::default(), at(20)).unwrap();
        gate
    }

    // Evidence for SR-28.
    #[test]
    fn what_is_held_counts_only_after_it_was_let_go() {
        let mut gate = Gate::default();
        gate.open_for(Some(ONE));
        gate.steer(ONE, order(1, 0), PUSH, at(1)).unwrap();
        assert!(!moves(gate.input(at(2))), "a finger that was down before the connection");
        gate.steer(ONE, order(2, 0), Steer::default(), at(3)).unwrap();
        gate.steer(ONE, order(3, 0), PUSH, at(4)).unwrap();
        assert!(moves(gate.input(at(5))));
        gate.require_release();
        assert!(!moves(gate.input(at(6))));
        gate.steer(ONE, order(4, 0), PUSH, at(7)).unwrap();
        assert!(!moves(gate.input(at(8))), "a finger that was down before the contour ended");
        gate.steer(ONE, order(5, 0), Steer::default(), at(9)).unwrap();
        gate.steer(ONE, order(6, 0), PUSH, at(10)).unwrap();
        assert!(moves(gate.input(at(11))));
    }

    fn moves(input: OperatorInput) -> bool {
        input.velocity != Mm2::ZERO || input.turns() || input.up != 0.0
    }

    #[test]
    fn input_expires_and_release_stops_at_once() {
        let mut gate = gate();
        gate.steer(ONE, order(1, 1000), PUSH, at(1010)).unwrap();
        assert!(moves(gate.input(at(1210))) && !moves(gate.input(at(1211))));
        gate.steer(ONE, order(2, 1200), PUSH, at(1220)).unwrap();
        gate.steer(ONE, order(3, 1210), Steer { held: false, ..PUSH }, at(1221)).unwrap();
        assert!(!moves(gate.input(at(1222))));
    }

    // Evidence for SR-28.
    #[test]
    fn repeated_reordered_late_and_foreign_messages_do_not_count() {
        let mut gate = gate();
        let mut steer =
            |client, sequence, seen, now| gate.steer(client, order(sequence, seen), PUSH, at(now));
        assert_eq!(steer(ONE, 5, 1000, 1020), Ok(()));
        assert_eq!(steer(ONE, 5, 1000, 1020), Err(GateRefusal::OutOfOrder), "repeated");
        assert_eq!(steer(ONE, 4, 1010, 1030), Err(GateRefusal::OutOfOrder), "an earlier one");
        assert_eq!(steer(ONE, 6, 999, 1030), Err(GateRefusal::OutOfOrder), "it has seen less than before");
        assert_eq!(steer(ONE, 6, 5000, 1030), Err(GateRefusal::OutOfOrder), "it has seen the future");
        assert_eq!(steer(ClientId(2), 9, 1020, 1030), Err(GateRefusal::NotHolder));
        // The least round trip is 20 ms.
        assert_eq!(steer(ONE, 7, 1100, 1320), Ok(()));
        assert_eq!(steer(ONE, 8, 1100, 1321), Err(GateRefusal::Late));
    }

    // Evidence for SR-28.
    /// A stall delivers a push and its release late. The tool does not move.
    #[test]
    fn messages_from_a_stall_move_nothing() {
        let mut gate = gate();
        gate.steer(ONE, order(1, 1000), PUSH, at(1020)).unwrap();
        assert!(moves(gate.input(at(1030))));
        assert!(!moves(gate.input(at(1400))), "the stall");
        for sequence in 2..20 {
            assert_eq!(gate.steer(ONE, order(sequence, 1000), PUSH, at(1900)), Err(GateRefusal::Late));
            assert!(!moves(gate.input(at(1900))));
        }
        gate.steer(ONE, order(20, 1890), PUSH, at(1910)).unwrap();
        assert!(moves(gate.input(at(1911))), "a fresh one counts again");
    }

    #[test]
    fn steps_count_once_and_only_while_held() {
        let mut gate = gate();
        let step = Steer { velocity: Mm2::ZERO, step_mm: Mm2::new(0.1, 0.0), step_up_mm: -1.0, ..PUSH };
        gate.steer(ONE, order(1, 0), step, at(1)).unwrap();
        gate.steer(ONE, order(2, 0), step, at(2)).unwrap();
        let input = gate.input(at(3));
        assert_eq!((input.turned_mm, input.turned_up_mm), (Mm2::new(0.2, 0.0), -2.0));
        assert!(!moves(gate.input(at(4))));
        gate.steer(ONE, order(3, 0), step, at(5)).unwrap();
        gate.steer(ONE, order(4, 0), Steer { held: false, ..step }, at(6)).unwrap();
        assert!(!moves(gate.input(at(7))));
        let wild = Steer { step_mm: Mm2::new(f64::NAN, 1e300), up: f64::INFINITY, ..step };
        gate.steer(ONE, order(5, 0), wild, at(8)).unwrap();
        let input = gate.input(at(9));
        assert_eq!((input.turned_mm, input.up), (Mm2::new(0.0, STEP_MAX_MM), 0.0));
    }

    #[test]
    fn feed_hold_counts_from_everyone_and_ends_what_was_asked_before() {
        let mut gate = gate();
        gate.command(ONE, order(1, 0), OperatorCommand::Raise, at(1)).unwrap();
        gate.steer(ONE, order(2, 0), PUSH, at(1)).unwrap();
        gate.command(ClientId(7), order(0, 99_999), OperatorCommand::FeedHold, at(2)).unwrap();
        assert!(!moves(gate.input(at(3))));
        assert_eq!(gate.next_command(), Some(OperatorCommand::FeedHold));
        assert_eq!(gate.next_command(), None);
        let foreign = gate.command(ClientId(7), order(1, 0), OperatorCommand::CycleStart, at(4));
        assert_eq!(foreign, Err(GateRefusal::NotHolder));
        for _ in 0..COMMANDS_MAX {
            let number = gate.sender.and_then(|sender| sender.sequence).unwrap_or(0) + 1;
            gate.command(ONE, order(number, 0), OperatorCommand::Raise, at(5)).unwrap();
        }
        assert_eq!(gate.command(ONE, order(99, 0), OperatorCommand::Raise, at(5)), Err(GateRefusal::TooMany));
    }

    #[test]
    fn another_holder_starts_from_nothing() {
        let mut gate = gate();
        gate.steer(ONE, order(1, 0), PUSH, at(1)).unwrap();
        gate.open_for(Some(ClientId(2)));
        assert!(!moves(gate.input(at(2))));
        assert_eq!(gate.steer(ONE, order(2, 0), PUSH, at(3)), Err(GateRefusal::NotHolder));
        gate.steer(ClientId(2), order(1, 0), Steer::default(), at(3)).unwrap();
        gate.steer(ClientId(2), order(2, 0), PUSH, at(3)).unwrap();
        gate.open_for(Some(ClientId(2)));
        assert!(moves(gate.input(at(4))), "the same holder stays");
        gate.open_for(None);
        assert!(!moves(gate.input(at(5))));
    }
}
