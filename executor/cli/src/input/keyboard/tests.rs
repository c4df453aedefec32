use super::*;

const RIGHT: Key = Key::Jog(1, 0);
const UP: Key = Key::Jog(0, 1);

fn ms(millis: u64) -> Time {
    Time::from_micros(millis * 1000)
}

fn velocity(keys: &mut Keys, at: u64) -> Mm2 {
    keys.input(Phase::Manual, ms(at)).velocity
}

fn fast(releases: bool) -> Keys {
    let mut keys = Keys::new(releases);
    keys.take(Key::Character('4'), Stroke::Down, ms(0));
    keys
}

// Evidence for SR-21.
#[test]
fn push_outlasts_its_last_key_event_by_150_ms() {
    let mut keys = fast(false);
    keys.take(RIGHT, Stroke::Down, ms(100));
    assert_eq!(velocity(&mut keys, 100), Mm2::new(1.0, 0.0));
    assert_eq!(velocity(&mut keys, 249), Mm2::new(1.0, 0.0));
    assert_eq!(velocity(&mut keys, 250), Mm2::ZERO);
    for at in (300..2000).step_by(30) {
        keys.take(RIGHT, Stroke::Down, ms(at));
        assert_eq!(velocity(&mut keys, at + 29), Mm2::new(1.0, 0.0));
    }
    assert_eq!(velocity(&mut keys, 2150), Mm2::ZERO);
}

#[test]
fn press_that_is_read_late_does_not_move() {
    let mut keys = fast(false);
    keys.take(RIGHT, Stroke::Down, ms(100));
    assert_eq!(velocity(&mut keys, 5000), Mm2::ZERO);
}

#[test]
fn opposite_keys_cancel_and_diagonals_are_no_faster() {
    let mut keys = fast(false);
    keys.take(RIGHT, Stroke::Down, ms(0));
    keys.take(UP, Stroke::Down, ms(10));
    let Mm2 { x, y } = velocity(&mut keys, 20);
    assert!((x.hypot(y) - 1.0).abs() < 1e-12 && x == y);
    keys.take(Key::Jog(-1, 0), Stroke::Down, ms(20));
    assert_eq!(velocity(&mut keys, 30), Mm2::new(0.0, 1.0));
    keys.take(Key::Jog(1, 1), Stroke::Down, ms(400));
    assert!((velocity(&mut keys, 401).x - 0.5_f64.sqrt()).abs() < 1e-12);
}

// Evidence for SR-21.
#[test]
fn with_release_events_a_key_moves_until_its_release_or_a_missing_repeat() {
    let mut keys = fast(true);
    keys.take(RIGHT, Stroke::Down, ms(0));
    assert_eq!(velocity(&mut keys, 500), Mm2::new(1.0, 0.0), "before the first repeat");
    (500..3000).step_by(30).for_each(|at| keys.take(RIGHT, Stroke::Repeat, ms(at)));
    assert_eq!(velocity(&mut keys, 3050), Mm2::new(1.0, 0.0));
    keys.take(RIGHT, Stroke::Up, ms(3060));
    assert_eq!(velocity(&mut keys, 3060), Mm2::ZERO);
    keys.take(RIGHT, Stroke::Repeat, ms(3070));
    assert_eq!(velocity(&mut keys, 3070), Mm2::ZERO, "a repeat without a press does not move");
    keys.take(RIGHT, Stroke::Down, ms(4000));
    keys.take(RIGHT, Stroke::Repeat, ms(4690));
    assert_eq!(velocity(&mut keys, 4830), Mm2::new(1.0, 0.0));
    assert_eq!(velocity(&mut keys, 4841), Mm2::ZERO, "the connection is lost");
}

#[test]
fn with_release_events_an_earlier_held_key_keeps_moving() {
    let mut keys = fast(true);
    keys.take(RIGHT, Stroke::Down, ms(0));
    keys.take(UP, Stroke::Down, ms(100));
    (600..2000).step_by(30).for_each(|at| keys.take(UP, Stroke::Repeat, ms(at)));
    let Mm2 { x, y } = velocity(&mut keys, 2010);
    assert!(x > 0.7 && y > 0.7);
    keys.take(UP, Stroke::Up, ms(2020));
    assert_eq!(velocity(&mut keys, 2030), Mm2::new(1.0, 0.0));
    assert_eq!(velocity(&mut keys, 2800), Mm2::ZERO, "no key event for too long");
}

// Evidence for SR-24.
#[test]
fn contact_start_disarms_the_cycle() {
    let mut keys = Keys::new(false);
    keys.take(Key::Character('a'), Stroke::Down, ms(0));
    assert!(keys.input(Phase::Manual, ms(1)).armed && keys.status().contains("ARMED"));
    keys.input(Phase::Touching, ms(2));
    assert!(!keys.input(Phase::Manual, ms(3)).armed && !keys.status().contains("ARMED"));
}

#[test]
fn question_mark_explains_the_keys() {
    let mut keys = Keys::new(false);
    keys.take(Key::Character('?'), Stroke::Down, ms(0));
    assert!(keys.help());
    keys.take(Key::Character('h'), Stroke::Down, ms(1));
    assert!(!keys.help());
}

#[test]
fn steps_are_counted_and_bounded() {
    let mut keys = Keys::new(false);
    for key in ['s', '2'] {
        keys.take(Key::Character(key), Stroke::Down, ms(0));
    }
    keys.take(RIGHT, Stroke::Down, ms(1));
    keys.take(RIGHT, Stroke::Down, ms(2));
    keys.take(Key::Jog(0, -1), Stroke::Down, ms(3));
    let input = keys.input(Phase::Manual, ms(10));
    assert_eq!((input.velocity, input.turned_mm), (Mm2::ZERO, Mm2::new(0.02, -0.01)));
    assert_eq!(keys.input(Phase::Manual, ms(20)).turned_mm, Mm2::ZERO);
    (0..1000).for_each(|_| keys.take(RIGHT, Stroke::Down, ms(30)));
    assert_eq!(keys.input(Phase::Manual, ms(40)).turned_mm, Mm2::new(0.1, 0.0));
    assert_eq!(keys.status(), "step 0.01 mm");
}

#[test]
fn space_stops_at_once_until_the_next_key() {
    for releases in [false, true] {
        let mut keys = fast(releases);
        keys.take(RIGHT, Stroke::Down, ms(0));
        keys.take(Key::Character(' '), Stroke::Down, ms(10));
        assert!(keys.stopped() && velocity(&mut keys, 11) == Mm2::ZERO);
        keys.take(RIGHT, Stroke::Repeat, ms(20));
        keys.take(RIGHT, Stroke::Up, ms(25));
        assert!(keys.stopped() && velocity(&mut keys, 26) == Mm2::ZERO);
        assert_eq!(keys.command(), None);
        keys.input(Phase::Contouring, ms(27));
        assert_eq!(keys.command(), Some(OperatorCommand::FeedHold));
        keys.take(UP, Stroke::Down, ms(30));
        assert!(!keys.stopped() && velocity(&mut keys, 31) == Mm2::new(0.0, 1.0));
    }
}

#[test]
fn plus_and_minus_move_the_third_axis_and_c_crosses() {
    let mut keys = fast(false);
    keys.take(Key::Lift(-1), Stroke::Down, ms(0));
    keys.take(RIGHT, Stroke::Down, ms(10));
    let input = keys.input(Phase::Manual, ms(20));
    assert_eq!((input.velocity, input.up), (Mm2::new(1.0, 0.0), -1.0));
    assert_eq!(keys.input(Phase::Manual, ms(170)).up, 0.0);
    let mut stated = false;
    for key in ['c', '1', '2', '\n', 'u', 'm', 'm', 'c', '3', 'p', '\n', 'c', '\n'] {
        keys.take(Key::Character(key), Stroke::Down, ms(200));
        keys.see_spindle(key == 'm' && !std::mem::replace(&mut stated, key == 'm'));
    }
    let given: Vec<_> = std::iter::from_fn(|| keys.command()).collect();
    let spindle = |runs| OperatorCommand::Spindle { runs };
    let cross = OperatorCommand::Cross { contour: 12 };
    assert_eq!(
        given,
        [cross, OperatorCommand::Raise, spindle(true), spindle(false), OperatorCommand::FeedHold]
    );
    keys.take(Key::Character('s'), Stroke::Down, ms(300));
    keys.take(Key::Lift(1), Stroke::Down, ms(301));
    assert_eq!(keys.input(Phase::Manual, ms(302)).turned_up_mm, 0.1);
}

#[test]
fn each_command_key_gives_one_command_and_quit_is_never_dropped() {
    let mut keys = Keys::new(false);
    for key in ['p', 'p', 'f', 'a'] {
        keys.take(Key::Character(key), Stroke::Down, ms(0));
    }
    let given: Vec<_> = (0..4).map(|_| keys.command()).collect();
    let (hold, recover) = (Some(OperatorCommand::FeedHold), Some(OperatorCommand::Recover));
    assert_eq!(given, [hold, hold, recover, None]);
    assert!(keys.input(Phase::Manual, ms(60)).armed);
    (0..100).for_each(|_| keys.take(Key::Character('p'), Stroke::Down, ms(65)));
    keys.take(Key::Interrupt, Stroke::Down, ms(70));
    let given: Vec<_> = std::iter::from_fn(|| keys.command()).collect();
    assert_eq!((given.len(), given.last()), (COMMANDS_MAX, Some(&OperatorCommand::Stop)));
}
