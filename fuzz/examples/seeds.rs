//! Writes the generated seeds: `cargo run -p keepout-fuzz --example seeds`.
//!
//! They are files in `fuzz/seeds/TARGET`. The inputs that campaigns find are in `fuzz/corpora`. Every run
//! writes the same seeds.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use arbitrary::{Arbitrary, Unstructured};
use keepout_executor::dialect::DialectName;
use keepout_executor::session::Going;
use keepout_executor::session::log::{Header, LogWriter};
use keepout_fuzz::plate;
use keepout_fuzz::sketch::{OutlineFault, Sketch};
use keepout_kernel::Point;
use keepout_planner::machine::MachineProfile;
use keepout_planner::plan::Plan;
use keepout_planner::plan_file;
use keepout_planner::request::PlanRequest;
use keepout_sim::operator::Script;
use keepout_sim::session::{Scene, SimRun, run_scene};

type Outcome = Result<(), Box<dyn Error>>;

/// Length of a plan file's head before its payload: magic, version, hash.
const PLAN_HEAD: usize = 12 + 2 + 32;
/// Longer plan files are not used as seeds.
const PLAN_MAX: usize = 4_000;
/// Largest number of bytes of a log in a seed.
const LOG_MAX: usize = 16_384;

fn main() -> Outcome {
    drawings()?;
    wrong_plans()?;
    logs()?;
    texts()?;
    errors()?;
    transcripts()
}

fn write(target: &str, name: &str, bytes: &[u8]) -> Outcome {
    let folder: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR")).join("seeds").join(target);
    fs::create_dir_all(&folder)?;
    Ok(fs::write(folder.join(name), bytes)?)
}

/// For each family, the shortest of many random drawings that has just this fault and can be planned, and
/// the shortest that cannot. Each is written as bytes, as DXF and as a plan.
fn drawings() -> Outcome {
    let mut random = fastrand::Rng::with_seed(9);
    let machine = MachineProfile::simulated();
    let plan = |sketch: &Sketch| sketch.order.plan("seed", sketch.dxf().as_bytes(), &machine, &mut |_| {});
    for family in OutlineFault::OF_OUTLINES.into_iter().chain([OutlineFault::Blocks]) {
        for planned in [true, false] {
            let mut best: Option<(usize, Vec<u8>, Sketch)> = None;
            for _ in 0..6_000 {
                let bytes: Vec<u8> = (0..random.usize(8..90)).map(|_| random.u8(..)).collect();
                let Ok(sketch) = Sketch::arbitrary(&mut Unstructured::new(&bytes)) else { continue };
                let only = sketch.families().all(|each| each == family) && sketch.families().count() > 0;
                let size = sketch.dxf().len();
                let longer = best.as_ref().is_some_and(|(least, ..)| size >= *least);
                if only && !longer && plan(&sketch).is_ok() == planned {
                    best = Some((size, bytes, sketch));
                }
            }
            let Some((_, bytes, sketch)) = best else { continue };
            let name = format!("{}-{}", family.name(), if planned { "planned" } else { "refused" });
            write("drawing", &name, &bytes)?;
            write("dxf_import", &format!("{name}.dxf"), sketch.dxf().as_bytes())?;
            let Ok(certified) = plan(&sketch) else { continue };
            let stored = plan_file::encode(&certified.plan)?;
            if stored.len() < PLAN_MAX {
                write("plan_file", &name, &stored[PLAN_HEAD..])?;
            }
        }
    }
    Ok(())
}

/// Plans that are refused for one reason only. One machine leaves its contour by 0.8 µm more than the one
/// that the path was made for. The other is coarser than the whole margin.
fn wrong_plans() -> Outcome {
    let planned = |machine: &MachineProfile| -> Result<Plan, Box<dyn Error>> {
        let certified =
            PlanRequest::default().plan("plate", plate(false).as_bytes(), machine, &mut |_| {})?;
        Ok(certified.plan)
    };
    let usual = MachineProfile::simulated();
    let plan = planned(&usual)?;
    let worse = MachineProfile { contour_error_mm: usual.contour_error_mm + 0.0008, ..usual.clone() };
    let near = Plan { budget: planned(&worse)?.budget, machine: worse, ..plan.clone() };
    let simplified = MachineProfile { arc_tolerance_mm: 0.1, ..usual };
    let small = Plan { machine: simplified, ..plan };
    for (name, plan, cause) in [("too-near", near, "path"), ("margin-too-small", small, "margin")] {
        let refused = plan.clone().certify().err().ok_or("a wrong plan is believed")?.to_string();
        if !refused.contains(cause) {
            return Err(format!("{name}: {refused}").into());
        }
        write("plan_file", name, &plan_file::encode(&plan)?[PLAN_HEAD..])?;
    }
    Ok(())
}

/// Beginnings of sessions on the plate, without checksums and the plan's hash. The target adds these.
fn logs() -> Outcome {
    let hand = "0 0 0.2\n0.2 0.3 0\n0.5 pause\n0.6 quit\n";
    // At the wall, so that a contour begins soon.
    let touch = "0 0 -1 auto\n4 0 0 auto\n";
    let scenes = [
        ("grbl-hand", "grbl", hand, (-10, 8)),
        ("grblhal-hand", "grblhal", hand, (-10, 8)),
        ("grbl-contour", "grbl", touch, (10, 21)),
        ("zaber", "zaber", hand, (-10, 8)),
        ("venus", "venus", hand, (-10, 8)),
    ];
    for (name, language, script, (x, y)) in scenes {
        let work = keepout_fuzz::work();
        let run = SimRun {
            dialect: DialectName::named(language)?,
            servo: None,
            limit: Duration::from_secs(6),
            start: Some(Point::from_units(x * 100_000, y * 100_000)?),
            ..SimRun::default()
        };
        let scene = Scene::of(work, &run)?;
        let header = Header {
            plan: "@".into(),
            drawing: "plate".into(),
            travel_mm: None,
            simulated: true,
            answer_within_ms: 5000,
            ..scene.setup.header()?
        };
        let path = std::env::temp_dir().join(format!("keepout-seed-{name}-{}.log", std::process::id()));
        let tape = Box::new(LogWriter::create(&path, &header)?);
        let operator = Box::new(Script::parse(script)?);
        run_scene(&run, scene, operator, tape, &mut |_, _, _| Going::On)?;
        let text = fs::read_to_string(&path)?;
        fs::remove_file(&path)?;
        let mut lines = String::new();
        // Without the checksum at the beginning of each line.
        for rest in text.lines().filter_map(|line| line.split_once(',').map(|(_, rest)| rest)) {
            // A log with a hole does not replay.
            if lines.len() + rest.len() + 2 > LOG_MAX {
                break;
            }
            lines.push('{');
            lines.push_str(rest);
            lines.push('\n');
        }
        write("session_log", name, lines.as_bytes())?;
        if name == "grbl-hand" {
            // A jog across the part without a certificate.
            let wrong = lines.replacen("{\"jog\":{\"to\":[-1000000,", "{\"jog\":{\"to\":[1000000,", 1);
            if wrong == lines {
                return Err("the log has no jog to change".into());
            }
            write("session_log", "jog-that-was-not-certified", wrong.as_bytes())?;
        }
    }
    Ok(())
}

/// Shipped text files. The byte before them chooses the kind.
fn texts() -> Outcome {
    let tree = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    write("machine_profile", "simulated", MachineProfile::simulated().to_toml().as_bytes())?;
    let kinds = [
        ("d", "executor/dialects/nsk-style.toml"),
        ("d", "executor/dialects/tango.toml"),
        ("d", "executor/sim/tests/described/ok-style.toml"),
        ("d", "executor/sim/tests/described/one-answer.toml"),
        ("h", "planner/drives/src/machines/simulated.toml"),
        ("h", "planner/drives/src/machines/koren-lo-table-1.toml"),
    ];
    for (kind, file) in kinds {
        let name = Path::new(file).file_stem().unwrap_or_default().to_string_lossy().into_owned();
        write("small_files", &name, format!("{kind}{}", fs::read_to_string(tree.join(file))?).as_bytes())?;
    }
    let setup = "eversion = 1\nrotation_deg = 12.0\norigin_mm = [-250.0, -200.0]\ndrawing = \"part.dxf\"\n\
        method = \"points\"\ntouches = 2\nrotation_measured = true\nresidual_mm = 0.0\n\
        probe_error_mm = 0.01\nuncertainty_mm = 0.02\n";
    write("small_files", "setup", setup.as_bytes())?;
    let script = "f# a hand\n0.0 1.0 0.0\n2.5 0.0 -0.5\n6 0 0.3 auto\n20 pause\n25 resume\n\
        50 turn 0.05 -0.1\n60 quit\n";
    write("small_files", "script", script.as_bytes())?;
    let trace = "g# keepout trace 1: seconds x y turned_x turned_y flags\n0.000000 0 0 0 0 -\n\
        0.010000 0.35 -0.125 0 0 -\n4.120000 0 0 0.01 0 a\n9.000000 0 0 0 0 ap\n12.500000 end\n";
    write("small_files", "trace", trace.as_bytes())
}

/// The output of each controller in a session of the tests, with a byte for each command before it.
fn transcripts() -> Outcome {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../executor/cli/tests/transcripts/virtual");
    let files: [(&str, &[u8], &str, [&str; 4]); 5] = [
        ("grbl_decode", &[0], "grbl-38400", ["?", "$\\n", "$H", "G21"]),
        ("zaber_decode", &[], "zaber-38400", ["get pos", "comm.checksum", "home", "setup disable"]),
        ("venus_decode", &[], "venus-38400", ["st p", "ge ", "cal", "1 getcaldone"]),
        ("described_decode", &[0], "nsk-style-38400", ["S", "", "", ""]),
        ("described_decode", &[1], "tango-38400", ["?", "", "", ""]),
    ];
    for (target, first, file, commands) in files {
        let text = fs::read_to_string(folder.join(file).with_extension("txt"))?;
        let mut bytes = first.to_vec();
        for line in text.lines() {
            if let Some(said) = line.strip_prefix("> ") {
                let asks = |command: &&str| !command.is_empty() && said.contains(*command);
                let which = commands.iter().position(asks);
                bytes.extend(which.and_then(|which| u8::try_from(which).ok()).map(|which| 0xf0 + which));
                bytes.extend((said.starts_with("$J") || said.contains("line abs")).then_some(0xf9));
            } else if let Some(heard) = line.strip_prefix("< ") {
                bytes.extend(heard.replace("\\r", "\r").replace("\\n", "\n").replace("\\'", "'").bytes());
            }
        }
        bytes.truncate(6000);
        write(target, file, &bytes)?;
        // Then each fault, after the same beginning.
        for (number, trouble) in troubles(target).into_iter().enumerate() {
            write(target, &format!("{file}-trouble-{number}"), &[&bytes, &trouble[..]].concat())?;
        }
    }
    Ok(())
}

/// An error of each description, and an answered query of two. They are short, so that mutations can build
/// on them.
fn errors() -> Outcome {
    for (which, said) in [(2, &["<Idle>", "X1 Y2"][..]), (3, &["S0 A100 B200"])] {
        let name = format!("query-{which}");
        write("described_decode", &name, &[&[which, 0xf0], lines(said).as_slice()].concat())?;
    }
    for (which, line) in [(0, "E7"), (1, "1.5"), (2, "error:9"), (3, "? 3")] {
        write(
            "described_decode",
            &format!("error-{which}"),
            &[&[which], lines(&[line]).as_slice()].concat(),
        )?;
    }
    Ok(())
}

/// Lines with their ends.
fn lines(lines: &[&str]) -> Vec<u8> {
    lines.iter().flat_map(|line| [line.as_bytes(), b"\r\n"].concat()).collect()
}

/// The output of a controller in each fault, after the commands that it answers.
fn troubles(target: &str) -> Vec<Vec<u8>> {
    match target {
        "grbl_decode" => grbl_troubles(),
        "zaber_decode" => zaber_troubles(),
        "venus_decode" => venus_troubles(),
        _ => vec![[b"\xf9", lines(&["E5 BUSY", "E7", "error:9", "? 3", "ERR 1"]).as_slice()].concat()],
    }
}

fn grbl_troubles() -> Vec<Vec<u8>> {
    let codes =
        |word: &str, last: u8| (1..=last).flat_map(|k| format!("{word}:{k}\r\n").into_bytes()).collect();
    let states = ["Hold:0", "Hold:1", "Home", "Door:0", "Check", "Sleep", "Tool", "Nothing"];
    let states: Vec<String> =
        states.iter().map(|state| format!("<{state}|MPos:0.000,0.000,0.000|Bf:15,128>")).collect();
    let looks = [
        "[VER:1.1h.20190825:]",
        "[OPT:V,15,128]",
        "[AXS:3:XYZ]",
        "$10=1",
        "$13=1",
        "$22=0",
        "$100=80",
        "$101=80",
        "$110=500",
        "$120=10",
        "$32=1",
        "[GC:G0 G54 G17 G21 G90 G94 M5 M9 T0 F0 S0]",
        "ok",
    ];
    vec![
        codes("error", 40),
        codes("ALARM", 12),
        lines(&states.iter().map(String::as_str).collect::<Vec<_>>()),
        lines(&looks),
        lines(&["Grbl 1.1h ['$' for help]", "[MSG:Check door]", "what?"]),
    ]
}

fn zaber_troubles() -> Vec<Vec<u8>> {
    let answer =
        |command: u8, rest: &str| [&[command][..], b"@01 0 \xee ", rest.as_bytes(), b"\xef"].concat();
    let warnings = ["FS", "FE", "FQ", "FD", "FB", "FO", "FP", "WR", "WH", "WL", "WM", "NC", "FZ"];
    let reasons =
        ["AGAIN", "BADAXIS", "BADCOMMAND", "BADDATA", "STATUSBUSY", "FULL", "NOACCESS", "PARKED", "OTHER"];
    let warned = warnings.iter().flat_map(|warning| answer(0xf0, &format!("OK IDLE {warning} 1000 2000")));
    let refused = reasons.iter().flat_map(|reason| answer(0xf9, &format!("RJ IDLE -- {reason}")));
    let homing =
        [answer(0xf2, "OK BUSY -- 0"), answer(0xee, "OK BUSY -- 0 0"), answer(0xee, "OK IDLE FS 0 0")];
    let alerts = b"!01 0 IDLE FS\xef!01 0 IDLE --\xef!01\xef#01 0 says\xef$\xef@01 2\xef";
    vec![
        warned.collect(),
        refused.collect(),
        homing.concat(),
        alerts.to_vec(),
        answer(0xf1, "RJ IDLE -- BADCOMMAND"),
    ]
}

fn venus_troubles() -> Vec<Vec<u8>> {
    let codes = ["1001", "1003", "1004", "1008", "1009", "77777"];
    let errors = codes.iter().flat_map(|code| [b"\xf3", lines(&["3", "3", code]).as_slice()].concat());
    vec![
        errors.collect(),
        [b"\xf1", lines(&["0", "2", "0", "0"]).as_slice()].concat(),
        [b"\xf1", lines(&["0", "3", "0", "-1.0"]).as_slice()].concat(),
        [b"\xf0", lines(&["1", "x y z", "0", "1 2"]).as_slice()].concat(),
    ]
}
