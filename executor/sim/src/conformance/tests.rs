//! Conformance of the simulated controllers, with each quirk on and off, in virtual time.

use std::path::Path;
use std::sync::OnceLock;
use std::time::Duration;

use keepout_executor::dialect::DialectName;
use keepout_planner::Mm2;
use keepout_planner::machine::MachineProfile;

use super::scenario::{CANCEL, HOLD};
use super::*;
use crate::Quirks;

fn setting(language: DialectName, quirks: Quirks) -> SimulatedBench {
    let setup = Setup::of(language, MachineProfile::simulated());
    SimulatedBench { setup, at: Mm2::new(-200.0, -150.0), baud: 115_200, quirks }
}

fn all(language: &DialectName) -> Vec<Scenario> {
    let blocks = if *language == DialectName::Grbl { 15 } else { 100 };
    scenarios(&setting(language.clone(), Quirks::default()).setup.frame(blocks))
}

fn played(language: &DialectName, quirks: Quirks, choose: fn(&Scenario) -> bool) -> Recording {
    let scenarios: Vec<Scenario> = all(language).into_iter().filter(choose).collect();
    assert!(!scenarios.is_empty());
    simulate(&setting(language.clone(), quirks), &scenarios).unwrap()
}

/// All scenarios, at GRBL or at grblHAL without quirks.
fn whole(language: &DialectName) -> &'static Recording {
    static GRBL: OnceLock<Recording> = OnceLock::new();
    static HAL: OnceLock<Recording> = OnceLock::new();
    let cell = if *language == DialectName::Grbl { &GRBL } else { &HAL };
    cell.get_or_init(|| played(language, Quirks::default(), |_| true))
}

fn cancels(scenario: &Scenario) -> bool {
    scenario.name.starts_with("cancel of 3 jogs at 90")
}

fn stops(scenario: &Scenario) -> bool {
    scenario.steps.iter().any(|step| matches!(step, Step::Realtime(CANCEL | HOLD)))
}

#[test]
fn grbl_keeps_its_path_and_its_figures_are_found() {
    let found = Findings::of(whole(&DialectName::Grbl));
    println!("{found}");
    assert_eq!(found.keeps_path_on_cancel(), Some(true));
    assert!(found.cancels > 100);
    assert_eq!((found.planner_blocks, found.receive_buffer), (Some(15), Some(128)));
    assert_eq!((found.discards_lines, found.hold_stops_jog), (Some(false), Some(true)));
    assert!(found.idle_delay < Duration::from_millis(10), "{:?}", found.idle_delay);
    assert!(found.firmware.contains("1.1h"));
    for error in ["error:22", "error:16", "error:3", "error:21", "error:20", "error:1", "error:15", "ALARM:3"]
    {
        assert!(found.errors.contains(error), "{error}: {:?}", found.errors);
    }
    for state in ["Idle", "Jog", "Run", "Hold:0", "Hold:1", "Alarm"] {
        assert!(found.states.contains(state), "{state}: {:?}", found.states);
    }
}

#[test]
fn fast_hold_of_grblhal_is_found_and_plain_hold_keeps_the_path() {
    let found = Findings::of(whole(&DialectName::GrblHal));
    println!("{found}");
    assert_eq!(found.keeps_path_on_cancel(), Some(false));
    assert!(found.largest_deviation_mm > 0.1);
    assert_eq!((found.planner_blocks, found.receive_buffer), (Some(100), Some(1024)));
    assert_eq!((found.discards_lines, found.hold_stops_jog), (Some(true), Some(false)));
    let plain = Quirks { plain_hold: true, ..Quirks::default() };
    let plain = played(&DialectName::GrblHal, plain, |scenario| scenario.name.starts_with("cancel"));
    let found = Findings::of(&plain);
    assert_eq!(found.keeps_path_on_cancel(), Some(true), "{found}");
    let fast =
        played(&DialectName::GrblHal, Quirks::default(), |scenario| scenario.name.starts_with("cancel"));
    let differences = compare(&fast, &plain);
    println!("{}", table(&differences, ["fast hold", "plain hold"], 99));
    let strays = |each: &&Difference| each.aspect == Aspect::Distance;
    assert_eq!(differences.iter().filter(strays).count(), 12, "one for each scenario with a junction");
}

#[test]
fn idle_delay_is_found() {
    let ends = |scenario: &Scenario| scenario.name == "ends of motions";
    let slow = Quirks { idle_delay: Duration::from_millis(25), ..Quirks::default() };
    let moves =
        |each: &Scenario| each.care == Care::Harmless || stops(each) && !each.name.starts_with("low queue");
    let found = Findings::of(&played(&DialectName::Grbl, slow.clone(), moves));
    assert_eq!(found.keeps_path_on_cancel(), Some(true), "{found}");
    assert!((20..=30).contains(&found.idle_delay.as_millis()), "{found}");
    let slow = played(&DialectName::Grbl, slow, ends);
    let delay = Findings::of(&slow).idle_delay;
    assert!((20..=30).contains(&delay.as_millis()), "{delay:?}");
    let differences = compare(&played(&DialectName::Grbl, Quirks::default(), ends), &slow);
    let aspects: Vec<Aspect> = differences.iter().map(|each| each.aspect).collect();
    assert_eq!(aspects, [Aspect::Answer], "{differences:?}");
}

#[test]
fn equal_controllers_do_not_differ() {
    for language in [DialectName::Grbl, DialectName::GrblHal] {
        let again = played(&language, Quirks::default(), cancels);
        let same = played(&language, Quirks::default(), cancels);
        assert_eq!(compare(&again, &same), []);
    }
}

#[test]
fn startup_lines_and_silent_resets_are_found() {
    let resets = |scenario: &Scenario| ["startup lines", "reset at rest"].contains(&scenario.name.as_str());
    let usual = played(&DialectName::Grbl, Quirks::default(), resets);
    let inches = Quirks { startup: ["G20".into(), String::new()], ..Quirks::default() };
    let differences = compare(&usual, &played(&DialectName::Grbl, inches, resets));
    let found: Vec<_> = differences.iter().map(|each| (each.scenario.as_str(), each.aspect)).collect();
    assert_eq!(found, [("startup lines", Aspect::Replies), ("reset at rest", Aspect::Replies)]);
    assert!(differences[0].second.contains("$N0=G20") && differences[1].second.contains(">G20:ok"));
    let silent = Quirks { silent_reset: true, ..Quirks::default() };
    let differences = compare(&usual, &played(&DialectName::Grbl, silent, resets));
    let [only] = &differences[..] else { panic!("{differences:?}") };
    assert!(only.first.contains("greeting") && only.second.contains("none"), "{only:?}");
}

#[test]
fn scenarios_for_machines_contain_no_hold_or_cancel() {
    for language in [DialectName::Grbl, DialectName::GrblHal] {
        let scenarios = all(&language);
        let harmless = |each: &&Scenario| each.care == Care::Harmless;
        assert!(scenarios.iter().filter(|each| stops(each)).count() > 50);
        assert!(!scenarios.iter().filter(harmless).any(stops));
        assert!(scenarios.iter().filter(harmless).count() > 30);
    }
}

/// Both firmwares send 65,535 steps when a stop ends at the end of a block, at some slopes of the next one.
#[test]
fn stops_that_run_away_are_found() {
    let low = |scenario: &Scenario| scenario.name.starts_with("low queue");
    for language in [DialectName::Grbl, DialectName::GrblHal] {
        let sound = Findings::of(&played(&language, Quirks { plain_hold: true, ..Quirks::default() }, low));
        assert!(sound.cancels > 10 && sound.largest_stop_mm < 10.0, "{sound}");
        let quirks = Quirks { plain_hold: true, stops_run_away: true, ..Quirks::default() };
        let found = Findings::of(&played(&language, quirks, low));
        assert!(found.largest_stop_mm > 100.0, "{found}");
    }
}

#[test]
fn models_of_grbl_and_grblhal_differ_as_documented() {
    let scenarios: Vec<Scenario> = all(&DialectName::Grbl);
    let chosen: Vec<Scenario> = scenarios
        .into_iter()
        .filter(|each| each.name.starts_with("hold in jog") || each.name.starts_with("refill"))
        .collect();
    let [grbl, hal] = [DialectName::Grbl, DialectName::GrblHal]
        .map(|language| simulate(&setting(language, Quirks::default()), &chosen).unwrap());
    let differences = compare(&grbl, &hal);
    assert!(
        differences.iter().any(|each| each.aspect == Aspect::Stop),
        "{}",
        table(&differences, ["grbl", "hal"], 99)
    );
}

#[test]
fn recordings_survive_their_file_and_damage_is_named_by_line() {
    let recording = played(&DialectName::Grbl, Quirks::default(), cancels);
    let text = write(&recording);
    assert_eq!(read(text.as_bytes(), Path::new("test")).unwrap(), recording);
    let lines: Vec<&str> = text.lines().collect();
    let with = |index: usize, line: &str| {
        let mut lines = lines.clone();
        lines[index] = line;
        read((lines.join("\n") + "\n").as_bytes(), Path::new("test")).map_err(|error| error.to_string())
    };
    for (index, line, expected) in [
        (0, "keepout-log 1", "not a conformance recording"),
        (0, "keepout-conformance 1 dialect=grbl digit_mm=0.1 step_mm=0.1", "version 1"),
        (0, r#"{"keepout_conformance":9,"dialect":"grbl","digit_mm":0.1,"step_mm":0.1}"#, "version 9"),
        (0, r#"{"keepout_conformance":3,"dialect":"grbl","digit_mm":-1.0,"step_mm":0.1}"#, "line 1"),
        (5, r#"{"at_us":5,"what":"nothing"}"#, "line 6"),
        (5, r#"{"at_us":-5,"what":{"sent":"?"}}"#, "line 6"),
        (5, r#"{"at_us":99999999,"what":{"tool":{"at":[null,0.0],"kind":"jog"}}}"#, "line 6"),
        (5, r#"{"at_us":99999999,"what":{"sent":"\u0100"}}"#, "line 6"),
        (7, r#"{"at_us":0,"what":{"sent":"?"}}"#, "line 8: its time"),
    ] {
        let error = with(index, line).expect_err(line);
        assert!(error.contains(expected), "{line}: {error}");
    }
    let long = format!("5 s {}", "x".repeat(5000));
    assert!(with(5, &long).expect_err("long").contains("line 6: longer"));
    let mut random = fastrand::Rng::with_seed(4);
    let start = text.len().min(4000);
    for _ in 0..2000 {
        let mut bytes = text.as_bytes()[..start].to_vec();
        for _ in 0..random.usize(1..5) {
            let at = random.usize(0..bytes.len());
            bytes[at] = random.u8(..);
        }
        if let Ok(read) = read(bytes.as_slice(), Path::new("test")) {
            let _ = (Findings::of(&read), compare(&read, &recording));
        }
    }
}

#[test]
fn scenarios_are_refused_outside_travel_box_and_dialect() {
    let refusal = |setting: &SimulatedBench| match simulate(setting, &[]) {
        Err(error) => error.to_string(),
        Ok(_) => panic!("the set-up was accepted"),
    };
    let corner = SimulatedBench { at: Mm2::new(-1.0, -1.0), ..setting(DialectName::Grbl, Quirks::default()) };
    assert!(refusal(&corner).contains("leaves the machine's travel"));
    assert!(refusal(&setting(DialectName::Zaber, Quirks::default())).contains("zaber has no conformance"));
    let outside = Step::Jog { to: Mm2::new(11.0, 0.0), feed: 600 };
    let scenario = Scenario { name: "far".into(), care: Care::Harmless, steps: vec![outside] };
    let refused = simulate(&setting(DialectName::Grbl, Quirks::default()), &[scenario]);
    assert!(matches!(refused, Err(RecordError::OutsideBox { .. })));
    for language in [DialectName::Grbl, DialectName::GrblHal] {
        for scenario in all(&language).iter().filter(|each| each.care == Care::Harmless) {
            for step in &scenario.steps {
                let stores =
                    matches!(step, Step::Line(line) if line.contains('=') && !line.starts_with("$J="));
                assert!(!stores && *step != Step::Realtime(0x18), "{}", scenario.name);
            }
        }
    }
}
