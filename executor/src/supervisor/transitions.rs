//! The whole transition table: for every state and every kind of event, the next phase and the commands.
//!
//! A test compares the table with `transitions.txt`. `KEEPOUT_WRITE_TRANSITIONS=1` writes that file again.
//! Read the file before you commit it.

use std::fmt::Write as _;
use std::time::Duration;

use keepout_guard::{Interpolation, OnCancel, Refusal};
use keepout_kernel::Point;
use keepout_kernel::exact::segment::Window;
use keepout_planner::Mm2;
use keepout_planner::job::ContourJob;
use keepout_planner::job::JobError;
use keepout_planner::machine::{ControllerProfile, MachineProfile, ZProfile};
use keepout_planner::request::PlanRequest;
use keepout_planner::units::{mm, point_from_mm};

use super::state::Run;
use super::*;

pub(super) const ABILITIES: Abilities = Abilities {
    interpolation: Interpolation::Linear,
    contours: Interpolation::Linear,
    arcs: true,
    queues: true,
    on_cancel: OnCancel::KeepsPath,
    checked: true,
    spindle: false,
};
/// Points outside and inside the jogging clearance of the bracket, mm.
const CLEAR: Mm2 = Mm2::new(-30.0, -30.0);
const NEAR: Mm2 = Mm2::new(-3.1, 20.0);
pub(super) const NOW: Time = Time::from_micros(10_000_000);

pub(super) fn work() -> PreparedPlan {
    work_on(&MachineProfile::simulated())
}

fn work_on(machine: &MachineProfile) -> PreparedPlan {
    let bytes = include_bytes!("../../cli/drawings/bracket.dxf");
    PreparedPlan::new(PlanRequest::default().plan("bracket", bytes, machine, &mut |_| {}).unwrap())
}

fn at(mm: Mm2) -> Point {
    point_from_mm(mm).unwrap()
}

fn report(mode: Mode) -> Event {
    let report = Report { mode, position: Some(at(CLEAR).in_plane()), queued: Some(0), waiting: Some(false) };
    Event::Reply(Reply::Report(report))
}

fn run() -> Run {
    Run::new(ContourJob::default(), Vec::new(), Progress::default())
}

pub(super) type Made = (&'static str, fn() -> State);

/// Every state. The tool is outside the jogging clearance, except in Retracting.
pub(super) const STATES: [Made; 15] = [
    ("Connecting", || State::Connecting { garbled: None }),
    ("Preparing", || State::Preparing),
    ("Homing", || State::Homing),
    ("Arming", || State::Arming),
    ("Locating", || State::Locating { seen: None }),
    ("Manual", || State::Manual(JogPlanner::default())),
    ("Sliding", || State::Sliding(JogPlanner::default())),
    ("Retracting", || State::Retracting(JogPlanner::default())),
    ("Touching, asked", || State::Touching(Touch::Asked { in_place: false })),
    ("Touching, certifying", || State::Touching(Touch::Certifying(Box::new(run())))),
    ("Contouring", || State::Contouring(run())),
    ("Holding", || State::Holding(run())),
    ("Stopping", || State::Stopping { aborted: false, rested: false, stale: 0 }),
    ("Done", || State::Done),
    ("Faulted", || State::Faulted { fault: Fault::PortLost(text("unplugged")), warned: false }),
];

fn command(command: OperatorCommand) -> Event {
    Event::Command(command)
}

fn input(velocity: Mm2) -> Event {
    Event::Input(OperatorInput { velocity, ..OperatorInput::default() })
}

type Happens = (&'static str, fn() -> Event);

/// Every kind of event.
const EVENTS: [Happens; 31] = [
    ("report: idle", || report(Mode::Idle)),
    ("report: moving", || report(Mode::Moving)),
    ("report: slowing", || report(Mode::Slowing)),
    ("report: held", || report(Mode::Held)),
    ("report: homing", || report(Mode::Homing)),
    ("report: alarm", || report(Mode::Alarm)),
    ("report: other", || report(Mode::Other)),
    ("accepted", || Event::Reply(Reply::Accepted)),
    ("refused", || Event::Reply(Reply::Refused { code: 15, meaning: "", transient: false })),
    ("refused for now", || Event::Reply(Reply::Refused { code: 8, meaning: "", transient: true })),
    ("alarm", || Event::Reply(Reply::Alarm { code: 1, meaning: "" })),
    ("prepared", || Event::Reply(Reply::Prepared(Limits::of(100.0, 500.0)))),
    ("unfit", || Event::Reply(Reply::Unfit(Unfit { name: "$22", value: 0.0, needed: "1" }))),
    ("homed", || Event::Reply(Reply::Homed)),
    ("armed", || Event::Reply(Reply::Armed)),
    ("restarted", || Event::Reply(Reply::Restarted)),
    ("not homed", || Event::Reply(Reply::NotHomed)),
    ("displaced", || Event::Reply(Reply::Displaced)),
    ("message", || Event::Reply(Reply::Message(text("hello")))),
    ("garbled", || Event::Reply(Reply::Garbled(text("#")))),
    ("no wish", || input(Mm2::ZERO)),
    ("a push", || input(Mm2::new(-1.0, 0.0))),
    ("ask: pause", || command(OperatorCommand::FeedHold)),
    ("ask: resume", || command(OperatorCommand::CycleStart)),
    ("ask: recover", || command(OperatorCommand::Recover)),
    ("ask: slower", || command(OperatorCommand::Feed { percent: 50 })),
    ("ask: quit", || command(OperatorCommand::Stop)),
    ("tick", || Event::Tick),
    ("no job", || Event::Job(Box::new(Err(JobError::Failed)))),
    ("port lost", || Event::PortLost(text("unplugged"))),
    ("not sent", || Event::NotSent(EncodeError::NoArcs)),
];

pub(super) fn supervisor(work: &PreparedPlan, name: &str, state: State) -> Supervisor {
    let travel = Window::of(at(Mm2::new(-200.0, -200.0))).including(at(Mm2::new(200.0, 200.0)));
    let options = Options {
        feed_mm_min: 900,
        home: false,
        travel,
        heights: None,
        answer_within: Duration::from_secs(5),
        baud: 115_200,
        progress: Progress::default(),
    };
    let mut supervisor = Supervisor::new(work.clone(), options, ABILITIES);
    if !["Connecting", "Preparing", "Homing", "Arming", "Locating", "Faulted"].contains(&name) {
        supervisor.guard.locate(at(if name == "Retracting" { NEAR } else { CLEAR }).in_plane()).unwrap();
    }
    supervisor.state = state;
    supervisor.polling.answer_now(NOW);
    supervisor.start_step_at = NOW;
    supervisor.operation.input.replace(OperatorInput::default(), NOW);
    // The next report answers this query.
    supervisor.query(NOW, &mut Vec::new());
    supervisor
}

fn sent(commands: &[Command]) -> String {
    let names = commands.iter().map(|command| match command {
        Command::Move(certified) => match certified.motion() {
            keepout_guard::Motion::Jog { .. } => "Jog".into(),
            keepout_guard::Motion::Contour { .. } => "Contour".into(),
        },
        Command::Cancel(_) => "Cancel".into(),
        other => format!("{other:?}"),
    });
    names.collect::<Vec<String>>().join(" ")
}

#[test]
fn transition_table_agrees_with_its_snapshot() {
    let work = work();
    let mut table = String::new();
    for (name, state) in STATES {
        let _ = writeln!(table, "{name}");
        for (what, event) in EVENTS {
            let mut supervisor = supervisor(&work, name, state());
            let before = supervisor.phase();
            let mut commands = Vec::new();
            supervisor.step(event(), NOW, &mut commands);
            let after = supervisor.phase();
            if after == before && commands.is_empty() {
                continue;
            }
            let line = format!("  {what:<16} -> {after:?}  {}", sent(&commands));
            let _ = writeln!(table, "{}", line.trim_end());
        }
    }
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/src/supervisor/transitions.txt");
    if std::env::var_os("KEEPOUT_WRITE_TRANSITIONS").is_some() {
        std::fs::write(path, &table).unwrap();
    }
    let known = std::fs::read_to_string(path).unwrap();
    assert_eq!(table, known, "the table changed: KEEPOUT_WRITE_TRANSITIONS=1 writes it again");
}

// Evidence for SR-22.
#[test]
fn silence_is_a_fault_in_every_state_that_waits_for_the_controller() {
    let work = work();
    for (name, state) in STATES {
        let mut supervisor = supervisor(&work, name, state());
        let late = NOW.after(Duration::from_secs(100));
        supervisor.step(Event::Tick, late, &mut Vec::new());
        let over = ["Done", "Faulted"].contains(&name);
        assert_eq!(supervisor.fault().is_some(), !over || name == "Faulted", "{name}");
    }
}

// Evidence for SR-22.
#[test]
fn after_a_fault_nothing_moves_before_the_operator_recovers() {
    let work = work();
    let faults = ["alarm", "displaced", "port lost", "not sent"];
    for (name, state) in STATES {
        let over = name == "Done";
        let phase = if over { Phase::Done } else { Phase::Faulted };
        for (what, fault) in EVENTS.iter().filter(|(event, _)| faults.contains(event)) {
            let mut supervisor = supervisor(&work, name, state());
            let mut commands = Vec::new();
            supervisor.step(fault(), NOW, &mut commands);
            assert_eq!(supervisor.phase(), phase, "{name}: {what}");
            assert!(over || supervisor.guard.end().is_none(), "{name}: {what}");
            let others = EVENTS.iter().filter(|(next, _)| !["ask: recover", "ask: quit"].contains(next));
            others.for_each(|(_, next)| supervisor.step(next(), NOW, &mut commands));
            assert_eq!(supervisor.phase(), phase, "{name}: {what}");
            assert!(!commands.iter().any(|command| matches!(command, Command::Move(_))), "{name}: {what}");
        }
    }
}

// Evidence for SR-24.
#[test]
fn each_contour_needs_the_cycle_armed_anew() {
    let work = work();
    let mut supervisor = supervisor(&work, "Manual", State::Manual(JogPlanner::default()));
    // At the wall: 5 µm outside the jogging clearance.
    let wall = Mm2::new(-(mm(work.plan.roughing.units()) + 0.005), 20.0);
    supervisor.guard.locate(at(wall).in_plane()).unwrap();
    let arms = |supervisor: &mut Supervisor, armed: bool| {
        let input = OperatorInput { armed, ..OperatorInput::default() };
        supervisor.step(Event::Input(input), NOW, &mut Vec::new());
        supervisor.step(Event::Tick, NOW, &mut Vec::new());
    };
    arms(&mut supervisor, false);
    assert!(!supervisor.wants_job(), "nobody has armed it");
    supervisor.step(command(OperatorCommand::CycleStart), NOW, &mut Vec::new());
    assert!(!supervisor.wants_job(), "there is nothing to go on with");
    arms(&mut supervisor, true);
    assert!(supervisor.wants_job() && !supervisor.is_armed());
    // There is no job, and the switch is still on.
    supervisor.step(Event::Job(Box::new(Err(JobError::Failed))), NOW, &mut Vec::new());
    arms(&mut supervisor, true);
    assert!(!supervisor.wants_job(), "the start has used it up");
    arms(&mut supervisor, false);
    arms(&mut supervisor, true);
    assert!(supervisor.wants_job());
}

// Evidence for SR-24.
#[test]
fn a_fault_ends_the_arming() {
    let work = work();
    let mut supervisor = supervisor(&work, "Manual", State::Manual(JogPlanner::default()));
    let armed = || Event::Input(OperatorInput { armed: true, ..OperatorInput::default() });
    let step = |supervisor: &mut Supervisor, event| supervisor.step(event, NOW, &mut Vec::new());
    step(&mut supervisor, armed());
    assert!(supervisor.is_armed(), "away from the wall it stays armed");
    step(&mut supervisor, Event::NotSent(EncodeError::NoArcs));
    assert_eq!(supervisor.phase(), Phase::Faulted);
    step(&mut supervisor, command(OperatorCommand::Recover));
    step(&mut supervisor, command(OperatorCommand::Recover));
    assert!(supervisor.phase() != Phase::Faulted && !supervisor.is_armed());
    step(&mut supervisor, armed());
    assert!(!supervisor.is_armed(), "the switch is still on");
}

/// A machine with incomplete homing must be homed again after any fault.
#[test]
fn homing_is_owed_until_the_tool_is_located() {
    let work = work();
    let refused = || Event::Reply(Reply::Refused { code: 15, meaning: "", transient: false });
    let prepared = || Event::Reply(Reply::Prepared(Limits::of(100.0, 500.0)));
    let start = [
        prepared as fn() -> Event,
        || Event::Reply(Reply::Homed),
        || Event::Reply(Reply::Armed),
        || report(Mode::Idle),
    ];
    for steps in 0..=start.len() {
        let mut supervisor = supervisor(&work, "Preparing", State::Preparing);
        supervisor.homes = true;
        let mut commands = Vec::new();
        let mut step = |supervisor: &mut Supervisor, event| supervisor.step(event, NOW, &mut commands);
        start[..steps].iter().for_each(|event| step(&mut supervisor, event()));
        let located = supervisor.phase() == Phase::Manual;
        assert_eq!(located, steps == start.len());
        step(&mut supervisor, refused());
        // The operator commands it twice, because the tool must be raised first, and releases the key in
        // between.
        for _ in 0..2 {
            step(&mut supervisor, command(OperatorCommand::Recover));
            step(&mut supervisor, input(Mm2::ZERO));
        }
        step(&mut supervisor, report(Mode::Idle));
        step(&mut supervisor, prepared());
        let homes = matches!(supervisor.state, State::Homing);
        assert_eq!(homes, !located, "{steps} steps: {:?}", supervisor.phase());
    }
}

/// A measured departure from the path overrides the dialect. A measurement without a departure has no effect.
#[test]
fn profile_weakens_what_a_cancel_does_and_never_strengthens_it() {
    for (measured, stated, assumed) in [
        (Some(false), OnCancel::KeepsPath, OnCancel::MayStray),
        (Some(false), OnCancel::NotOffered, OnCancel::NotOffered),
        (Some(true), OnCancel::MayStray, OnCancel::MayStray),
        (Some(true), OnCancel::KeepsPath, OnCancel::KeepsPath),
        (None, OnCancel::KeepsPath, OnCancel::KeepsPath),
    ] {
        let controller =
            Some(ControllerProfile { keeps_path_on_cancel: measured, ..ControllerProfile::default() });
        let work = work_on(&MachineProfile { controller, ..MachineProfile::simulated() });
        let mut supervisor = supervisor(&work, "Preparing", State::Preparing);
        supervisor.abilities.on_cancel = stated;
        let prepared = Event::Reply(Reply::Prepared(Limits::of(100.0, 500.0)));
        supervisor.step(prepared, NOW, &mut Vec::new());
        assert_eq!(supervisor.guard().on_cancel(), assumed, "{measured:?} {stated:?}");
    }
}

// Evidence for SR-11.
/// An axis that hardly brakes has no stopping distance on the lattice.
#[test]
fn stopping_distance_follows_the_weakest_axis() {
    let weak = ZProfile { acceleration_mm_s2: 1e-3, ..ZProfile::simulated() };
    for (z, stops) in [(None, true), (Some(ZProfile::simulated()), true), (Some(weak), false)] {
        let work = work_on(&MachineProfile { z, ..MachineProfile::simulated() });
        let mut supervisor = supervisor(&work, "Preparing", State::Preparing);
        supervisor.abilities.on_cancel = OnCancel::MayStray;
        supervisor.step(Event::Reply(Reply::Prepared(Limits::UNLIMITED)), NOW, &mut Vec::new());
        supervisor.guard.locate(at(CLEAR).in_plane()).unwrap();
        supervisor.guard.jog(at(CLEAR - Mm2::new(5.0, 0.0)).in_plane(), 600).unwrap();
        let cancel = supervisor.guard.cancel();
        assert_eq!(cancel.is_ok(), stops, "{cancel:?}");
        assert!(stops || cancel == Err(Refusal::StoppingUnknown), "{cancel:?}");
    }
}
