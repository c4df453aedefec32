//! Controllers that answer garbage, wrongly or not at all: the session stops and states the reason.
#![expect(clippy::unwrap_used, reason = "a helper of a test may stop it")]

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use keepout_executor::dialect::{DialectConfig, DialectName};
use keepout_executor::operator::{Operator, OperatorView};
use keepout_executor::session::port::{Port, PortError};
use keepout_executor::session::{
    Clock, Going, NoEventLog, Session, SessionSetup, VirtualClock, place_on_table,
};
use keepout_executor::supervisor::{Fault, Notice, OperatorCommand, OperatorInput, Options, PreparedPlan};
use keepout_guard::Time;
use keepout_planner::Mm2;
use keepout_planner::job::Progress;
use keepout_planner::machine::MachineProfile;
use keepout_planner::plan::CertifiedPlan;
use keepout_planner::request::PlanRequest;
use keepout_sim::operator;

/// Longest duration of a session.
const SESSION: Duration = Duration::from_secs(300);

/// A controller that answers each write by `rule`.
struct Scripted<F: FnMut(&[u8]) -> Vec<u8>> {
    rule: F,
    pending: Vec<u8>,
    written: Vec<u8>,
    lost_at: Option<Time>,
}

impl<F: FnMut(&[u8]) -> Vec<u8>> Port for Scripted<F> {
    fn write(&mut self, bytes: &[u8], _now: Time) -> Result<(), PortError> {
        self.written.extend(bytes);
        self.pending.extend((self.rule)(bytes));
        Ok(())
    }

    fn read(&mut self, into: &mut Vec<u8>, now: Time) -> Result<(), PortError> {
        if self.lost_at.is_some_and(|at| now >= at) {
            return Err(PortError::Lost { name: "test".into(), reason: "unplugged".into() });
        }
        into.append(&mut self.pending);
        Ok(())
    }
}

fn plan() -> CertifiedPlan {
    let bytes = include_bytes!("../../cli/drawings/bracket.dxf");
    PlanRequest::default().plan("bracket", bytes, &MachineProfile::simulated(), &mut |_| {}).unwrap()
}

fn setup(home: bool) -> SessionSetup {
    let plan = plan();
    let place = place_on_table(&plan, &MachineProfile::simulated(), None).unwrap();
    let options = Options {
        feed_mm_min: 600,
        home,
        travel: place.travel,
        heights: place.heights(),
        answer_within: Duration::from_secs(3),
        baud: 115_200,
        progress: Progress::default(),
    };
    let config = DialectConfig {
        offset: place.offset,
        steps_per_mm: 400.0,
        arc_tolerance_mm: 0.0005,
        travel_mm: Some([400.0, 350.0]),
        z: None,
        spindle_rpm: None,
    };
    SessionSetup { work: PreparedPlan::new(plan), options, dialect: DialectName::Grbl, config }
}

/// Runs a session that a fault must end before its time is over.
fn faulted<P: Port>(mut session: Session<'_, P>) -> (Fault, Session<'_, P>) {
    let mut clock = VirtualClock::default();
    let ended = session.run(&mut clock, SESSION, |_, _| Going::On).unwrap();
    assert!(ended.fault().is_some(), "{ended}");
    assert!(clock.now() < Time::ZERO.after(SESSION), "the fault comes, and does not end the session");
    (*session.supervisor().fault().unwrap(), session)
}

fn fault_of(rule: impl FnMut(&[u8]) -> Vec<u8>, home: bool, lost_at: Option<Time>) -> (Fault, Vec<u8>) {
    let port = Scripted { rule, pending: Vec::new(), written: Vec::new(), lost_at };
    let operator = operator::named("wall", 60.0, 1).unwrap();
    let (fault, mut session) = faulted(setup(home).session(port, operator, Box::new(NoEventLog)));
    let written = session.port().unwrap().written.clone();
    (fault, written)
}

/// Jogs, and gives Stop at each input while a jog is not acknowledged.
struct Stopping {
    given: Arc<AtomicBool>,
}

impl Operator for Stopping {
    fn input(&mut self, view: &OperatorView, _now: Time) -> OperatorInput {
        self.given.fetch_or(view.unacknowledged > 0, Ordering::Relaxed);
        OperatorInput { velocity: Mm2::new(-1.0, 0.0), ..OperatorInput::default() }
    }

    fn command(&mut self) -> Option<OperatorCommand> {
        self.given.load(Ordering::Relaxed).then_some(OperatorCommand::Stop)
    }
}

/// Answers like an idle GRBL; `jog` answers the jogs.
fn grbl(mut jog: impl FnMut(u32) -> Vec<u8>) -> impl FnMut(&[u8]) -> Vec<u8> {
    let mut jogs = 0;
    move |bytes: &[u8]| {
        if bytes == b"?" {
            b"<Idle|MPos:-10.000,-10.000,0.000|Bf:15,128|FS:0,0|WCO:-5.000,0.000,0.000>\r\n".to_vec()
        } else if bytes == b"$$\n" {
            b"$10=3\r\n$12=0.001\r\n$13=0\r\n$22=1\r\n$100=400.000\r\n$101=400.000\r\n$110=6000.000\r\n\
              $111=6000.000\r\nok\r\n"
                .to_vec()
        } else if bytes.ends_with(b"$#\n") {
            b"ok\r\nok\r\n[G54:-5.000,0.000,0.000]\r\n[G92:0.000,0.000,0.000]\r\nok\r\n".to_vec()
        } else if bytes == b"$I\n" {
            b"[VER:1.1h.20190830:]\r\n[OPT:V,15,128]\r\nok\r\n".to_vec()
        } else if bytes == b"$N\n" {
            b"$N0=\r\n$N1=G80\r\nok\r\n".to_vec()
        } else if bytes.starts_with(b"$J=") {
            jogs += 1;
            jog(jogs)
        } else if bytes.ends_with(b"\n") {
            b"ok\r\n".repeat(bytes.iter().filter(|&&byte| byte == b'\n').count())
        } else {
            Vec::new()
        }
    }
}

#[test]
fn silent_controller_stops_the_session() {
    let (fault, written) = fault_of(|_| Vec::new(), false, None);
    assert!(matches!(fault, Fault::Silent { .. }), "{fault}");
    assert!(!written.windows(3).any(|bytes| bytes == b"$J="), "no jog goes out without a position");
}

#[test]
fn garbage_stops_the_session() {
    let mut noise = 0_u8;
    let (fault, _) = fault_of(
        move |_| {
            noise = noise.wrapping_mul(75).wrapping_add(74);
            vec![noise, 0xfe, b'?', b'\n']
        },
        false,
        None,
    );
    assert!(matches!(fault, Fault::Garbled { .. }), "{fault}");
}

#[test]
fn garbage_while_moving_stops_the_session_without_a_cancel() {
    let (fault, written) = fault_of(grbl(|_| b"o\xffk\r\n".to_vec()), false, None);
    assert!(matches!(fault, Fault::Garbled { .. }), "{fault}");
    let last = written.split(|&byte| byte == b'\n').rev().find(|line| !line.is_empty());
    let last = String::from_utf8_lossy(last.unwrap());
    assert!(
        last.contains("$J="),
        "no bytes follow the jog, because a cancel or a hold could run away: {last}"
    );
}

#[test]
fn stated_motion_without_a_change_of_position_is_told() {
    let moves = Arc::new(AtomicBool::new(false));
    let stalled = Arc::clone(&moves);
    let mut controller = grbl(move |_| {
        moves.store(true, Ordering::Relaxed);
        b"ok\r\n".to_vec()
    });
    let rule = move |bytes: &[u8]| {
        if bytes == b"?" && stalled.load(Ordering::Relaxed) {
            return b"<Jog|MPos:-10.000,-10.000,0.000|Bf:14,128|FS:600,0>\r\n".to_vec();
        }
        controller(bytes)
    };
    let port = Scripted { rule, pending: Vec::new(), written: Vec::new(), lost_at: None };
    let operator = operator::named("wall", 60.0, 1).unwrap();
    let mut session = setup(false).session(port, operator, Box::new(NoEventLog));
    session.run(&mut VirtualClock::default(), Duration::from_secs(20), |_, _| Going::On).unwrap();
    let notices = session.supervisor().notices();
    assert_eq!(notices.iter().filter(|notice| **notice == Notice::StandsStill).count(), 1, "{notices:?}");
}

#[test]
fn rejections_alarms_and_resets_stop_the_session() {
    let (fault, _) = fault_of(grbl(|_| b"error:15\r\n".to_vec()), false, None);
    assert!(matches!(fault, Fault::Refused { code: 15, .. }), "{fault}");
    let (fault, _) = fault_of(grbl(|_| b"ALARM:1\r\n".to_vec()), false, None);
    assert!(matches!(fault, Fault::Alarm { code: 1, .. }), "{fault}");
    let (fault, _) = fault_of(grbl(|_| b"\r\nGrbl 1.1h ['$' for help]\r\n".to_vec()), false, None);
    assert_eq!(fault, Fault::WasReset);
}

#[test]
fn lost_acknowledgements_stop_the_session() {
    let mut inner = grbl(|_| Vec::new());
    let unanswered =
        move |bytes: &[u8]| if bytes.starts_with(b"\x90G21") { b"ok\r\n".to_vec() } else { inner(bytes) };
    assert_eq!(fault_of(unanswered, false, None).0, Fault::LineLost);
    assert_eq!(fault_of(grbl(|_| Vec::new()), false, None).0, Fault::LineLost);
}

#[test]
fn error_8_is_retried_a_limited_number_of_times() {
    let twice = |jog: u32| if jog <= 2 { b"error:8\r\n".to_vec() } else { b"error:15\r\n".to_vec() };
    assert!(matches!(fault_of(grbl(twice), false, None).0, Fault::Refused { code: 15, .. }));
    assert!(matches!(
        fault_of(grbl(|_| b"error:8\r\n".to_vec()), false, None).0,
        Fault::Refused { code: 8, .. }
    ));
}

#[test]
fn unfit_controllers_are_rejected() {
    for (from, to, name) in [
        ("$13=0", "$13=1", "$13"),
        ("$100=400.000", "$100=80.000", "$100"),
        ("$10=3", "$10=1", "$10"),
        ("$12=0.001", "$12=0.005", "$12"),
        ("$N1=G80", "$N1=", "$N"),
        ("|Bf:15,128", "|Bf:15,128|Ov:150,100,100", "feed override"),
        ("[G54:-5.000,0.000,0.000]", "[G54:-5.000,0.000,0.000:0.00]", "G54 rotation"),
    ] {
        let mut inner = grbl(|_| Vec::new());
        let other =
            move |bytes: &[u8]| String::from_utf8(inner(bytes)).unwrap().replace(from, to).into_bytes();
        assert!(matches!(fault_of(other, false, None).0, Fault::Unfit(unfit) if unfit.name == name));
    }
}

#[test]
fn surplus_acknowledgement_stops_the_session() {
    let (fault, _) = fault_of(grbl(|_| b"ok\r\nok\r\n".to_vec()), false, None);
    assert!(matches!(fault, Fault::Guard(_)), "{fault}");
}

#[test]
fn position_outside_certified_motions_stops_the_session() {
    let mut moved = false;
    let mut inner = grbl(|_| b"ok\r\n".to_vec());
    let (fault, _) = fault_of(
        move |bytes| {
            moved |= bytes.starts_with(b"$J=");
            if moved && bytes == b"?" {
                return b"<Jog|MPos:-10.000,-300.000,0.000|Bf:14,128|FS:0,0>\r\n".to_vec();
            }
            inner(bytes)
        },
        false,
        None,
    );
    assert!(matches!(fault, Fault::Guard(_)), "{fault}");
}

#[test]
fn start_is_refused_unhomed_without_homing_or_inside_the_part() {
    let alarm =
        |bytes: &[u8]| if bytes == b"?" { b"<Alarm|MPos:0.000,0.000,0.000>\r\n".to_vec() } else { vec![] };
    assert_eq!(fault_of(alarm, false, None).0, Fault::NotHomed);
    let mut inner = grbl(|_| Vec::new());
    let unhomed = move |bytes: &[u8]| {
        let text = String::from_utf8(inner(bytes)).unwrap();
        text.replace("$22=1", "$22=0").into_bytes()
    };
    assert!(matches!(fault_of(unhomed, false, None).0, Fault::Unfit(_)));
    let mut inner = grbl(|_| Vec::new());
    let inside = move |bytes: &[u8]| {
        let text = String::from_utf8(inner(bytes)).unwrap();
        text.replace("-10.000,-10.000", "-230.000,-190.000").into_bytes()
    };
    assert!(matches!(fault_of(inside, false, None).0, Fault::InsidePart { .. }));
}

#[test]
fn port_lost_while_moving_stops_the_session() {
    let (fault, _) = fault_of(grbl(|_| b"ok\r\n".to_vec()), false, Some(Time::from_micros(2_000_000)));
    assert!(matches!(fault, Fault::PortLost(_)), "{fault}");
}

/// An operator who can recover has given Stop: the fault ends the session and does not wait for Recover.
#[test]
fn fault_after_stop_ends_a_session_that_can_recover() {
    let given = Arc::new(AtomicBool::new(false));
    let (stopped, mut inner) = (Arc::clone(&given), grbl(|_| Vec::new()));
    let rule = move |bytes: &[u8]| {
        if stopped.load(Ordering::Relaxed) { b"ALARM:1\r\n".to_vec() } else { inner(bytes) }
    };
    let port = Scripted { rule, pending: Vec::new(), written: Vec::new(), lost_at: None };
    let operator = Box::new(Stopping { given });
    let session = setup(false).session(port, operator, Box::new(NoEventLog));
    let lost = || Err(PortError::Lost { name: "test".into(), reason: "unplugged".into() });
    let (fault, _) = faulted(session.recovering(Box::new(lost)));
    assert!(matches!(fault, Fault::Alarm { .. }), "{fault}");
}
