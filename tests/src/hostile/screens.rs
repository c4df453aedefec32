//! Hostile screens: browsers between the operator and the session that lie, flood, stall and replay.

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use fastrand::Rng;
use keepout_executor::operator::{Operator, OperatorView};
use keepout_executor::supervisor::{OperatorCommand, OperatorInput};
use keepout_guard::Time;
use keepout_panel::hub::{Hub, PanelOperator};
use keepout_panel::lease::ClientId;
use keepout_panel::protocol::PanelAction;

use super::operator::Hostile;

/// Number of screens.
const SCREENS: usize = 3;
/// Most texts that a screen remembers, and that wait in its network.
const TEXTS_MAX: usize = 64;

/// What a screen does with what its person wants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Manner {
    /// It sends what the person wants.
    Honest,
    /// It sends far more than that, says that it is held, and counts as it likes.
    Lies,
    /// It sends as much as the server lets through.
    Floods,
    /// Its network keeps all back for a while, and then delivers all at once.
    Stalls,
    /// It sends again what it sent before.
    Replays,
}

impl Manner {
    const ALL: [Self; 5] = [Self::Honest, Self::Lies, Self::Floods, Self::Stalls, Self::Replays];
}

/// A screen, with what is under way from it.
#[derive(Debug)]
struct Screen {
    client: ClientId,
    manner: Manner,
    until: Time,
    sequence: u64,
    /// Time stamp of the last state that it has seen, and its delay.
    delay: Duration,
    sent: VecDeque<String>,
    under_way: VecDeque<(Time, String)>,
}

/// An operator whose screens are hostile.
pub struct HostileScreens {
    person: Hostile,
    clock: Arc<AtomicU64>,
    hub: Hub,
    operator: PanelOperator,
    screens: Vec<Screen>,
    random: Rng,
}

impl HostileScreens {
    /// Screens before a person, from a seed.
    #[must_use]
    pub fn new(person: Hostile, seed: u64) -> Self {
        let mut random = Rng::with_seed(seed);
        let clock = Arc::new(AtomicU64::new(0));
        let hub = Hub::told(Arc::clone(&clock));
        let screen = |_| Screen {
            client: hub.join(Time::ZERO),
            manner: Manner::Honest,
            until: Time::ZERO,
            sequence: 0,
            delay: Duration::from_millis(random.u64(0..300)),
            sent: VecDeque::new(),
            under_way: VecDeque::new(),
        };
        let screens = (0..SCREENS).map(screen).collect();
        Self { person, operator: hub.operator(), clock, hub, screens, random }
    }

    /// Each screen sends what its manner makes of the wish.
    fn send(&mut self, wish: OperatorInput, command: Option<OperatorCommand>, now: Time) {
        let random = &mut self.random;
        for screen in &mut self.screens {
            if now >= screen.until {
                screen.until = now.after(Duration::from_millis(random.u64(100..4000)));
                screen.manner = Manner::ALL[random.usize(0..Manner::ALL.len())];
            }
            let texts = screen.texts(wish, command, now, random);
            let arrives = match screen.manner {
                Manner::Stalls => screen.until,
                _ => now.after(screen.delay / 2),
            };
            for text in texts {
                screen.sent.push_back(text.clone());
                screen.under_way.push_back((arrives, text));
            }
            while screen.sent.len() > TEXTS_MAX {
                screen.sent.pop_front();
            }
            while screen.under_way.len() > 4 * TEXTS_MAX {
                screen.under_way.pop_front();
            }
        }
        if random.u8(0..200) == 0 {
            // A socket is lost, and opened again.
            let screen = &mut self.screens[random.usize(0..SCREENS)];
            self.hub.leave(screen.client);
            screen.client = self.hub.join(now);
            screen.sequence = 0;
        }
    }

    /// What has arrived by now reaches the hub.
    fn deliver(&mut self, now: Time) {
        for screen in &mut self.screens {
            while screen.under_way.front().is_some_and(|(arrives, _)| *arrives <= now) {
                let Some((_, text)) = screen.under_way.pop_front() else { break };
                if let Ok(action) = PanelAction::parse(&text) {
                    let _ = self.hub.act(screen.client, action, now);
                }
            }
        }
    }
}

impl Screen {
    fn texts(
        &mut self,
        wish: OperatorInput,
        command: Option<OperatorCommand>,
        now: Time,
        random: &mut Rng,
    ) -> Vec<String> {
        let mut texts = Vec::new();
        if self.manner == Manner::Replays && !self.sent.is_empty() {
            let again = (0..4).map(|_| self.sent[random.usize(0..self.sent.len())].clone());
            texts.extend(again);
        }
        let count = if self.manner == Manner::Floods { 20 } else { 1 };
        for _ in 0..count {
            texts.push(self.steer(wish, now, random));
        }
        if let Some(command) = command {
            texts.push(self.command(command, now));
        }
        if self.manner == Manner::Lies {
            let commands = [
                OperatorCommand::FeedHold,
                OperatorCommand::CycleStart,
                OperatorCommand::Raise,
                OperatorCommand::Cross { contour: random.usize(0..9) },
                OperatorCommand::Spindle { runs: true },
                OperatorCommand::Recover,
                OperatorCommand::Feed { percent: random.u8(..) },
            ];
            if random.u8(0..20) == 0 {
                texts.push(self.command(commands[random.usize(0..commands.len())], now));
            }
        }
        let control = match random.u8(0..60) {
            0 | 1 => "take_control\"",
            2 => "give_control\"",
            3 => "answer\",\"consents\":true",
            4 => "answer\",\"consents\":false",
            _ => "alive\"",
        };
        texts.push(format!("{{\"type\":\"{control}}}"));
        texts
    }

    fn order(&mut self, now: Time) -> String {
        self.sequence += 1;
        // An honest screen has seen the state of half its delay ago; a liar claims to see all at once.
        let seen = if self.manner == Manner::Lies { Duration::ZERO } else { self.delay / 2 };
        let seen_us = now.micros().saturating_sub(u64::try_from(seen.as_micros()).unwrap_or(0));
        format!("{{\"sequence\":{},\"seen_us\":{seen_us}}}", self.sequence)
    }

    fn steer(&mut self, wish: OperatorInput, now: Time, random: &mut Rng) -> String {
        let mut factor = 1.0;
        let mut held = wish.velocity.length() > 0.0 || wish.turns() || wish.up != 0.0;
        if self.manner == Manner::Lies {
            factor = [1.0, -1.0, 1e3, 1e300][random.usize(0..4)];
            held = random.u8(0..8) != 0;
        } else if random.u8(0..20) == 0 {
            // The person lets go for a moment.
            held = false;
        }
        let number = |value: f64| format!("{:e}", (value * factor).clamp(-1e308, 1e308));
        let [x, y, up] = [wish.velocity.x, wish.velocity.y, wish.up].map(number);
        let [dx, dy, dz] = [wish.turned_mm.x, wish.turned_mm.y, wish.turned_up_mm].map(number);
        format!(
            "{{\"type\":\"steer\",\"order\":{},\"steer\":{{\"held\":{held},\"velocity\":[{x},{y}],\"up\":{up},\
             \"step_mm\":[{dx},{dy}],\"step_up_mm\":{dz},\"armed\":{}}}}}",
            self.order(now),
            wish.armed
        )
    }

    fn command(&mut self, command: OperatorCommand, now: Time) -> String {
        let word = serde_json::to_string(&command).unwrap_or_default();
        format!("{{\"type\":\"command\",\"order\":{},\"command\":{word}}}", self.order(now))
    }
}

impl Operator for HostileScreens {
    fn input(&mut self, view: &OperatorView, now: Time) -> OperatorInput {
        self.clock.store(now.micros(), Ordering::Relaxed);
        let wish = self.person.input(view, now);
        let command = self.person.command();
        self.send(wish, command, now);
        self.deliver(now);
        self.operator.input(view, now)
    }

    fn command(&mut self) -> Option<OperatorCommand> {
        self.operator.command()
    }

    fn every(&self) -> Duration {
        self.person.every()
    }
}

#[cfg(test)]
mod tests {
    use keepout_executor::supervisor::Phase;
    use keepout_planner::{Box2, Mm2};

    use super::super::operator::Style;
    use super::*;

    /// Hostile screens do move the tool and give commands: else the simulation would show nothing.
    #[test]
    fn screens_move_the_tool() {
        let mut screens = HostileScreens::new(Hostile::new(Style::Wheels, true, 1), 2);
        let view = OperatorView {
            position_mm: Some(Mm2::new(-20.0, 10.0)),
            height_mm: Some(1.0),
            wall_mm: Some(Mm2::new(0.0, 10.0)),
            part_box: Box2 { low: Mm2::ZERO, high: Mm2::new(100.0, 60.0) },
            end_mm: None,
            unacknowledged: 0,
            spindle_runs: true,
            phase: Phase::Manual,
            contoured: false,
        };
        let (mut moves, mut commands) = (0, 0);
        for ms in (0..60_000).step_by(20) {
            let input = screens.input(&view, Time::ZERO.after(Duration::from_millis(ms)));
            moves += u32::from(input.turns() || input.velocity != Mm2::ZERO || input.up != 0.0);
            commands += u32::from(screens.command().is_some());
        }
        assert!(moves > 500 && commands > 20, "{moves} moves, {commands} commands");
        assert!(moves < 2500, "{moves} of 3000 rounds: nothing is ever refused");
    }
}
