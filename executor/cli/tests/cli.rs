//! Tests of the command line: results, messages, exit codes, and files that are whole or absent.
#![expect(clippy::unwrap_used, reason = "a helper of a test may stop it")]

mod support;

use std::path::Path;

use support::{bracket, code, complaint, folder, keepout};

fn drawing(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/drawings").join(name).display().to_string()
}

fn files(folder: &Path) -> Vec<String> {
    let names = std::fs::read_dir(folder).unwrap();
    names.map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned()).collect()
}

fn planned(folder: &Path) -> String {
    let plan = folder.join("part.plan").display().to_string();
    let output = keepout(&["plan", &bracket(), "--tool-diameter", "6", "-o", &plan]);
    assert_eq!(code(&output), 0, "{}", complaint(&output));
    plan
}

// Evidence for SR-23.
#[test]
fn plan_is_verified_drawn_and_run() {
    let folder = folder("whole");
    let plan = planned(&folder);
    let verified = keepout(&["verify", &plan]);
    let text = String::from_utf8_lossy(&verified.stdout).into_owned();
    assert!(code(&verified) == 0 && text.contains("proved") && text.contains("margin M"), "{text}");
    let picture = folder.join("part.svg").display().to_string();
    assert_eq!(code(&keepout(&["show", &plan, "-o", &picture])), 0);
    assert!(std::fs::read_to_string(&picture).unwrap().ends_with("</svg>\n"));
    let (log, report) = (folder.join("run.log"), folder.join("run.html"));
    let run = keepout(&[
        "run",
        &plan,
        "--machine",
        "sim-fast",
        "--operator",
        "wall",
        "--jog-s",
        "10",
        "--log",
        &log.display().to_string(),
        "--report",
        &report.display().to_string(),
    ]);
    let text = String::from_utf8_lossy(&run.stdout).into_owned();
    assert!(code(&run) == 9 && text.contains("incomplete: 1 of 3 contours cut"), "{text}");
    assert!(text.contains("deepest gouge                        0.00000 mm"), "{text}");
    let page = std::fs::read_to_string(report).unwrap();
    assert!(page.contains("<svg") && page.contains("closest approach"));
    assert!(std::fs::read_to_string(log).unwrap().lines().count() > 50);
}

#[test]
fn job_runs_over_a_pty_in_real_time() {
    let folder = folder("pty");
    let plan = planned(&folder);
    let run = keepout(&[
        "run",
        &plan,
        "--machine",
        "sim",
        "--baud",
        "115200",
        "--operator",
        "wall",
        "--jog-s",
        "3",
        "--feed-mm-min",
        "6000",
    ]);
    let text = String::from_utf8_lossy(&run.stdout).into_owned();
    assert!(code(&run) == 9, "{text}{}", complaint(&run));
    assert!(
        text.contains("pty") && text.contains("deepest gouge                        0.00000 mm"),
        "{text}"
    );
}

#[test]
fn script_operates_a_run_and_its_faults_are_named() {
    let folder = folder("script");
    let plan = planned(&folder);
    let script = folder.join("hand.txt");
    std::fs::write(&script, "0 -1 -1\n1.5 -1 -0.2\n3 -0.3 -0.3 auto\n").unwrap();
    let script = script.display().to_string();
    let run = keepout(&["run", &plan, "--machine", "sim-fast", "--operator", &script, "--limit-s", "120"]);
    assert!([0, 9].contains(&code(&run)), "{}", complaint(&run));
    assert!(String::from_utf8_lossy(&run.stdout).contains("deepest gouge                        0.00000 mm"));
    std::fs::write(&script, "0 -1\n").unwrap();
    let run = keepout(&["run", &plan, "--machine", "sim-fast", "--operator", &script]);
    assert!(code(&run) == 2 && complaint(&run).contains("script line 1"), "{}", complaint(&run));
    let run = keepout(&["run", &plan, "--operator", "nobody"]);
    assert!(
        code(&run) == 2 && complaint(&run).contains("calm, random, wall, reversal"),
        "{}",
        complaint(&run)
    );
}

#[test]
fn bad_drawings_and_parameters_have_exit_codes_and_write_no_file() {
    let folder = folder("bad");
    let plan = folder.join("x.plan").display().to_string();
    let attempt = |file: &str, more: &[&str]| {
        let mut arguments = vec!["plan", file, "-o", &plan];
        arguments.extend(more);
        let output = keepout(&arguments);
        (code(&output), complaint(&output))
    };
    let tool = ["--tool-diameter", "6"];
    let cases: [(&str, &[&str], i32, &str); 8] = [
        ("missing.dxf", &tool, 3, "cannot read the drawing"),
        ("binary_noise.dxf", &tool, 3, "not a readable DXF"),
        ("gap_wide.dxf", &tool, 3, "0.250 mm away"),
        ("bow_tie.dxf", &tool, 4, "(20.000, 20.000) mm"),
        ("far_away.dxf", &tool, 3, "5.37 m"),
        ("triangle.dxf", &["--tool-diameter", "900"], 4, "is out of range"),
        ("triangle.dxf", &["--tool-diameter", "6", "--margin-mm", "0.001"], 4, "--margin-mm"),
        ("triangle.dxf", &["--tool-diameter", "6", "--units", "cubit"], 3, "unknown unit"),
    ];
    for (file, more, wanted, words) in cases {
        let (code, complaint) = attempt(&drawing(file), more);
        assert!(code == wanted && complaint.contains(words), "{file}: {code} {complaint}");
    }
    let (found, words) = attempt(&drawing("pocket.dxf"), &["--tool-diameter", "300", "--side", "inside"]);
    assert!(found == 4 && words.contains("fits nowhere"), "{words}");
    assert_eq!(attempt(&drawing("triangle.dxf"), &[]).0, 2, "a missing argument");
    let (found, words) =
        attempt(&drawing("triangle.dxf"), &["--tool-diameter", "6", "--stock-to-leave-mm=-1"]);
    assert!(found == 2 && words.contains("--stock-to-leave-mm"), "{words}");
    assert_eq!(files(&folder), Vec::<String>::new());
    let own = folder.join("own.dxf").display().to_string();
    std::fs::copy(bracket(), &own).unwrap();
    let output = keepout(&["plan", &own, "--tool-diameter", "6", "-o", &own]);
    assert!(code(&output) == 2 && std::fs::read(&own).unwrap() == std::fs::read(bracket()).unwrap());
    let nowhere = folder.join("no/such/folder.plan").display().to_string();
    let output = keepout(&["plan", &bracket(), "--tool-diameter", "6", "-o", &nowhere]);
    assert_eq!(code(&output), 7, "{}", complaint(&output));
}

#[test]
fn file_faults_name_the_kind_of_file_and_have_exit_codes() {
    let folder = folder("files");
    let plan = planned(&folder);
    let none = folder.join("none/x").display().to_string();
    let picture = format!("{none}.svg");
    let cases: [(&[&str], i32, &str); 10] = [
        (&["inspect", &none], 3, "cannot read the drawing"),
        (&["verify", &none], 5, "cannot read the plan file"),
        (&["replay", &none], 2, "cannot read the log"),
        (&["doctor", "--compare", &none, &none], 2, "cannot read the recording"),
        (&["run", &plan, "--alignment", &none], 2, "cannot read the alignment file"),
        (&["run", &plan, "--operator", &format!("trace:{none}")], 2, "cannot read the trace"),
        (&["plan", &bracket(), "--tool-diameter", "6", "-o", &none], 7, "cannot write the plan file"),
        (&["show", &plan, "-o", &picture], 7, "cannot write the output"),
        (&["run", &plan, "--log", &none], 7, "cannot write the output"),
        (&["demo", "--output", &plan], 7, "cannot write the output"),
    ];
    for (arguments, wanted, words) in cases {
        let output = keepout(arguments);
        let complaint = complaint(&output);
        assert!(code(&output) == wanted && complaint.contains(words), "{arguments:?}: {complaint}");
    }
}

#[test]
fn flipped_bits_and_cut_plans_are_rejected() {
    let folder = folder("flipped");
    let plan = planned(&folder);
    let bytes = std::fs::read(&plan).unwrap();
    for index in [0, 5, 12, 13, 14, 40, 46, 60, bytes.len() / 2, bytes.len() - 1] {
        let mut damaged = bytes.clone();
        damaged[index] ^= 0x10;
        std::fs::write(&plan, &damaged).unwrap();
        let output = keepout(&["verify", &plan]);
        assert_eq!(code(&output), 5, "byte {index}: {}", complaint(&output));
    }
    std::fs::write(&plan, &bytes[..bytes.len() - 3]).unwrap();
    assert_eq!(code(&keepout(&["run", &plan])), 5);
    std::fs::write(&plan, b"").unwrap();
    assert_eq!(code(&keepout(&["show", &plan, "-o", "x.svg"])), 5);
}

#[test]
fn missing_ports_and_jobs_that_do_not_fit_are_refused() {
    let folder = folder("ports");
    let plan = planned(&folder);
    let at_port = ["run", &plan, "--port", "/dev/no-such-port", "--simulate", "--operator", "calm"];
    let with = |more: &[&str]| keepout(&[&at_port[..], more].concat());
    let run = with(&["--origin-mm", "-200,-175", "--home"]);
    assert!(code(&run) == 6 && complaint(&run).contains("cannot open port"), "{}", complaint(&run));
    assert_eq!(code(&with(&[])), 2, "without an origin");
    let run = with(&["--origin-mm", "-200,-175"]);
    assert!(code(&run) == 2 && complaint(&run).contains("--homed"), "{}", complaint(&run));
    for (start, words) in [("-3,20", "too near"), ("50,15", "inside the part"), ("-1000,0", "travel")] {
        let run = keepout(&["run", &plan, "--machine", "sim-fast", "--start-mm", start]);
        assert!(code(&run) == 4 && complaint(&run).contains(words), "{start}: {}", complaint(&run));
    }
    let run = keepout(&["run", &plan, "--machine", "sim-fast", "--origin-mm", "0,0"]);
    assert!(code(&run) == 4 && complaint(&run).contains("--origin-mm may be"), "{}", complaint(&run));
    let run = keepout(&["run", &plan, "--machine", "sim-fast", "--travel-mm", "80,80"]);
    assert!(code(&run) == 4 && complaint(&run).contains("--travel-mm"), "{}", complaint(&run));
}

#[test]
fn inspect_lists_and_draws_contours_and_problems() {
    let folder = folder("inspect");
    let picture = folder.join("part.svg").display().to_string();
    let good = keepout(&["inspect", &drawing("rounded_plate.dxf"), "-o", &picture]);
    let text = String::from_utf8_lossy(&good.stdout).into_owned();
    assert!(code(&good) == 0 && text.contains("5 closed (1 outer, 4 inner), 0 open"), "{text}");
    assert!(text.contains("--at") && text.contains("within 0.00100 mm"), "{text}");
    assert!(std::fs::read_to_string(&picture).unwrap().ends_with("</svg>\n"));
    let bad = keepout(&["inspect", &drawing("tee.dxf"), "--json"]);
    let found: serde_json::Value = serde_json::from_slice(&bad.stdout).unwrap();
    assert_eq!(code(&bad), 3, "a drawing with problems");
    assert_eq!((found["contours"].as_array().unwrap().len(), found["open_chains"].as_u64()), (1, Some(1)));
    assert!((found["area_mm2"].as_f64().unwrap() - 1200.0).abs() < 1e-6);
    let problem = &found["problems"][0];
    assert_eq!((problem["at_mm"][0].as_f64(), problem["at_mm"][1].as_f64()), (Some(20.0), Some(0.0)));
    assert!(problem["text"].as_str().unwrap().contains("on the middle of"));
    let onto_itself = keepout(&["inspect", &drawing("tee.dxf"), "-o", &drawing("tee.dxf")]);
    assert!(code(&onto_itself) == 2 && complaint(&onto_itself).contains("not overwritten"));
}

#[test]
fn passes_and_limits_out_of_range_are_named() {
    let folder = folder("passes");
    let plan = folder.join("part.plan").display().to_string();
    let part = bracket();
    let with = |more: &[&str]| {
        let mut arguments = vec!["plan", &part, "--tool-diameter", "6", "-o", &plan];
        arguments.extend(more);
        keepout(&arguments)
    };
    for (more, words) in [
        (&["--pass", "thin"][..], "is not a pass"),
        (&["--pass", "0.1:0"], "is not a pass"),
        (&["--curve-mm", "1000"], "--curve-mm"),
        (&["--rotate-deg", "1000"], "--rotate-deg"),
        (&["--at", "900,900"], "--at 900.000,900.000"),
        (&["--limit-s", "0"], "--limit-s"),
    ] {
        let output = with(more);
        assert!(code(&output) != 0 && complaint(&output).contains(words), "{more:?}: {}", complaint(&output));
        assert!(files(&folder).is_empty(), "{more:?} left {:?}", files(&folder));
    }
    let double = with(&["--pass", "0.1:900", "--pass", "0:600", "--cut", "climb", "--rotate-deg", "12.5"]);
    let text = String::from_utf8_lossy(&double.stdout).into_owned();
    assert!(
        code(&double) == 0 && text.contains("pass 2") && text.contains("climb") && text.contains("12.5°"),
        "{text}"
    );
}

#[test]
fn plan_that_exceeds_its_time_limit_names_the_option_for_more_time() {
    let folder = folder("long");
    let at = |name: &str| folder.join(name).display().to_string();
    let (drawing, plan, picture) = (at("pins.dxf"), at("pins.plan"), at("pins.svg"));
    // The proof of 400 pins takes some tenths of a second.
    let pin = |k: usize| format!("0\nCIRCLE\n8\n0\n10\n{}\n20\n{}\n40\n5\n", k % 20 * 30, k / 20 * 30);
    let pins: String = (0..400).map(pin).collect();
    let head = "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n4\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n";
    std::fs::write(&drawing, format!("{head}{pins}0\nENDSEC\n0\nEOF\n")).unwrap();
    let made = keepout(&["plan", &drawing, "--tool-diameter", "6", "-o", &plan]);
    assert_eq!(code(&made), 0, "{}", complaint(&made));
    for command in [&["verify", &plan][..], &["show", &plan, "-o", &picture], &["run", &plan]] {
        let brief = keepout(&[command, &["--certify-limit-s", "0.001"]].concat());
        assert_eq!(code(&brief), 4, "{command:?}: {}", complaint(&brief));
        assert!(complaint(&brief).contains("more time with --certify-limit-s"), "{}", complaint(&brief));
    }
    assert!(!std::path::Path::new(&picture).exists());
    let patient = keepout(&["verify", &plan, "--certify-limit-s", "3000"]);
    assert_eq!(code(&patient), 0, "{}", complaint(&patient));
}
