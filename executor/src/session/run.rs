//! The loop that feeds the supervisor.

use std::time::{Duration, Instant};

use keepout_kernel::Point;
use keepout_planner::plan::CertifiedPlan;
use keepout_planner::units::{nearest_on_mm, point_mm};

use super::log::{Log, LogError};
use crate::link::dialect::Grbl;
use crate::link::port::Port;
use crate::operator::{Operator, Seen};
use crate::supervisor::guard::Motion;
use crate::supervisor::{Command, Event, Phase, Supervisor, log_point};
use crate::time::Time;

/// Where time comes from.
pub trait Clock {
    /// The time now.
    fn now(&mut self) -> Time;
    /// Waits until about the next millisecond.
    fn wait(&mut self);
}

/// The machine's clock.
#[derive(Debug)]
pub struct RealClock {
    began: Instant,
}

impl Default for RealClock {
    fn default() -> Self {
        Self { began: Instant::now() }
    }
}

impl Clock for RealClock {
    fn now(&mut self) -> Time {
        Time::ZERO.after(self.began.elapsed())
    }

    fn wait(&mut self) {
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// A clock that moves only when waited for.
#[derive(Debug, Default)]
pub struct VirtualClock {
    now: Time,
}

impl Clock for VirtualClock {
    fn now(&mut self) -> Time {
        self.now
    }

    fn wait(&mut self) {
        self.now = self.now.after(Duration::from_millis(1));
    }
}

/// Time between two wishes of the operator.
const WISH_EVERY: Duration = Duration::from_millis(10);
/// After the time is over, the machine comes to rest within this.
const REST_WITHIN: Duration = Duration::from_secs(10);
/// Time between two flushes of the log.
const FLUSH_EVERY: Duration = Duration::from_millis(500);

/// How a session ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// As the operator wanted.
    Done,
    /// By a fault; the supervisor says which.
    Faulted,
    /// The time that was allowed is over.
    OutOfTime,
}

/// A session under way.
pub struct Session<'a, P: Port> {
    /// The supervisor.
    pub supervisor: Supervisor,
    dialect: Grbl,
    port: P,
    operator: Box<dyn Operator + Send + 'a>,
    log: Log,
    wish_due: Time,
    flush_due: Time,
}

impl<'a, P: Port> Session<'a, P> {
    /// Puts a session together.
    pub fn new(
        supervisor: Supervisor,
        dialect: Grbl,
        port: P,
        operator: Box<dyn Operator + Send + 'a>,
        log: Log,
    ) -> Self {
        Self { supervisor, dialect, port, operator, log, wish_due: Time::ZERO, flush_due: Time::ZERO }
    }

    /// The port.
    pub fn port(&mut self) -> &mut P {
        &mut self.port
    }

    /// Reads and forgets what the machine still says.
    pub fn drain(&mut self, now: Time) {
        let _ = self.port.read(&mut Vec::new(), now);
    }

    /// Runs until the end; after `limit` the machine is brought to rest. `watch` is called after every round.
    ///
    /// # Errors
    /// [`LogError`] when the log can not be written on; the machine is stopped first.
    pub fn run(
        &mut self,
        clock: &mut impl Clock,
        limit: Duration,
        mut watch: impl FnMut(&mut Self, Time),
    ) -> Result<Ended, LogError> {
        let mut over: Option<Time> = None;
        loop {
            let now = clock.now();
            if over.is_none() && now.since(Time::ZERO) >= limit {
                over = Some(now);
                let commands = self.supervisor.halt();
                self.send(&commands, now)?;
            }
            if let Err(error) = self.round(now) {
                // Without a log nothing may go on: what is in flight ends at its certified target, or sooner.
                for command in [Command::Cancel, Command::Hold] {
                    let _ = self.dialect.encode(&command).map(|bytes| self.port.write(&bytes, now));
                }
                return Err(error);
            }
            watch(self, now);
            let ended = match self.supervisor.phase() {
                Phase::Faulted => Some(Ended::Faulted),
                Phase::Done if over.is_some() => Some(Ended::OutOfTime),
                Phase::Done => Some(Ended::Done),
                _ if over.is_some_and(|over| now.since(over) > REST_WITHIN) => Some(Ended::OutOfTime),
                _ => None,
            };
            if let Some(ended) = ended {
                self.log.line(now, "end", &format!("{ended:?}"))?;
                self.log.flush()?;
                return Ok(ended);
            }
            clock.wait();
        }
    }

    /// One round: replies in, the operator's wish, a tick; commands out.
    fn round(&mut self, now: Time) -> Result<(), LogError> {
        let mut bytes = Vec::new();
        if let Err(error) = self.port.read(&mut bytes, now) {
            self.feed(Event::PortLost(error.to_string()), now)?;
        }
        for reply in self.dialect.decode(&bytes) {
            self.log.line(now, "reply", &format!("{reply:?}"))?;
            self.feed(Event::Reply(reply), now)?;
        }
        if now >= self.wish_due {
            self.wish_due = now.after(WISH_EVERY);
            let seen = self.seen();
            let wish = self.operator.wish(&seen, now);
            self.feed(Event::Operator(wish), now)?;
        } else {
            self.feed(Event::Tick, now)?;
        }
        if now >= self.flush_due {
            self.flush_due = now.after(FLUSH_EVERY);
            self.log.flush()?;
        }
        Ok(())
    }

    fn feed(&mut self, event: Event, now: Time) -> Result<(), LogError> {
        let before = self.supervisor.phase();
        let commands = self.supervisor.step(event, now);
        self.send(&commands, now)?;
        let after = self.supervisor.phase();
        if after != before {
            let text =
                self.supervisor.fault().map_or(format!("{after:?}"), |fault| format!("{after:?}: {fault}"));
            self.log.line(now, "phase", &text)?;
        }
        Ok(())
    }

    /// Sends commands; when one can not be sent, nothing after it is, but what the supervisor then wants: to stop.
    fn send(&mut self, commands: &[Command], now: Time) -> Result<(), LogError> {
        for command in commands {
            self.log_command(command, now)?;
            let sent = match self.dialect.encode(command) {
                Ok(bytes) => self.port.write(&bytes, now).map_err(|error| error.to_string()),
                Err(error) => Err(format!("a target is off the lattice in machine coordinates: {error}")),
            };
            if let Err(reason) = sent {
                for last in self.supervisor.step(Event::PortLost(reason), now) {
                    if let Ok(bytes) = self.dialect.encode(&last) {
                        let _ = self.port.write(&bytes, now);
                    }
                }
                return Ok(());
            }
        }
        Ok(())
    }

    fn log_command(&mut self, command: &Command, now: Time) -> Result<(), LogError> {
        match command {
            Command::Query => Ok(()),
            Command::Move(certified) => {
                let kind = if matches!(certified.motion(), Motion::Jog { .. }) { "jog" } else { "contour" };
                let in_flight: Vec<String> = self.supervisor.guard().in_flight().map(log_point).collect();
                let text =
                    format!("{} certified with {{{}}}", log_point(certified.target()), in_flight.join(" "));
                self.log.line(now, kind, &text)
            }
            other => self.log.line(now, "command", &format!("{other:?}")),
        }
    }

    fn seen(&self) -> Seen {
        let plan = self.supervisor.plan();
        let position_mm = self.supervisor.position().map(point_mm);
        let (low, high) = plan.part_box();
        let ((x0, y0), (x1, y1)) = (point_mm(low), point_mm(high));
        Seen {
            position_mm,
            wall_mm: self.supervisor.position().and_then(|position| nearest_wall(plan, position)),
            part_box_mm: (x0, y0, x1, y1),
            phase: self.supervisor.phase(),
            contoured: !self.supervisor.finished().is_empty(),
        }
    }
}

/// The nearest point of the part, for the operator's eye.
fn nearest_wall(plan: &CertifiedPlan, position: Point) -> Option<(f64, f64)> {
    let nearest = plan.part.index().nearest(position, None)?;
    let chord = plan.part.edges().get(nearest.edge)?.chord;
    Some(nearest_on_mm(point_mm(position), point_mm(chord.from), point_mm(chord.to)))
}
