//! Tests of the commands of the studies, as an engineer uses them.
#![expect(clippy::unwrap_used, reason = "a helper of a test may stop it")]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use keepout_planner::machine::MachineProfile;
use keepout_planner::plan::PlanParameters;
use keepout_planner::plan_file;
use keepout_planner::request::PlanRequest;

fn studies(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_keepout-studies")).args(arguments).output().unwrap()
}

/// An empty folder for one test.
fn folder(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&path);
    std::fs::create_dir_all(&path).unwrap();
    path
}

fn printed(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn errors(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn text(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap()
}

#[test]
fn compare_writes_tables_and_pictures() {
    let folder = folder("compare");
    let to = folder.display().to_string();
    let output =
        studies(&["compare", "--scenario", "S1", "--scenario", "S6", "--model-error", "2", "-o", &to]);
    assert!(output.status.success(), "{}", errors(&output));
    let table = printed(&output);
    assert!(table.contains("| ZPETC | 17.8 / 25.2 |") && table.contains("**S6** corner"), "{table}");
    assert!(table.starts_with(&text(&folder.join("compare.md"))));
    // One line per controller. Repetitive control is missing, because these paths do not repeat.
    assert_eq!(text(&folder.join("compare.csv")).lines().count(), 1 + 2 * 22);
    for name in ["S1.svg", "S6.svg"] {
        assert!(text(&folder.join(name)).ends_with("</svg>\n"));
    }
}

#[test]
fn finishing_toolpath_of_a_plan_is_compared() {
    let folder = folder("plan");
    let plan = folder.join("part.plan").display().to_string();
    let bracket = include_bytes!("../../../executor/cli/drawings/bracket.dxf");
    let request = PlanRequest {
        job: PlanParameters { tool_diameter_mm: 6.0, ..PlanParameters::default() },
        ..PlanRequest::default()
    };
    let made = request.plan("bracket.dxf", bracket, &MachineProfile::simulated(), &mut |_| {}).unwrap();
    plan_file::save(&made.plan, Path::new(&plan)).unwrap();
    let compare =
        ["compare", "--plan", &plan, "--controller", "p", "--controller", "contouring", "--ramp-s", "0.2"];
    let output = studies(&compare);
    assert!(output.status.success(), "{}", errors(&output));
    let table = printed(&output);
    let max = |name: &str| -> f64 {
        let line = table.lines().find(|line| line.starts_with(&format!("| {name} |"))).unwrap();
        let cells = line.split('|').filter_map(|cell| cell.split('/').nth(1));
        cells.map(|cell| cell.trim().parse::<f64>().unwrap()).fold(0.0, f64::max)
    };
    // The feed stays constant around the corners, so P has large errors.
    assert!(max("contouring MPC with observer") < 30.0 && max("P") > 100.0, "{table}");
}

#[test]
fn table_3_is_printed() {
    let output = studies(&["table3"]);
    assert!(
        output.status.success() && printed(&output).contains("25 of the paper's 26 printed grades agree"),
        "{}",
        printed(&output)
    );
}

#[test]
fn invalid_arguments_are_named_and_no_file_is_written() {
    let folder = folder("bad");
    let file = |name: &str, text: &str| {
        let path = folder.join(name);
        std::fs::write(&path, text).unwrap();
        path.display().to_string()
    };
    let drives = include_str!("../../../planner/drives/src/machines/koren-lo-table-1.toml");
    let negative = file("negative.toml", &drives.replacen("gain = 10.0", "gain = -10.0", 1));
    let odd = file("odd.toml", &drives.replacen("[gains]", "[grains]", 1));
    let rows = file("rows.toml", "[[scenario]]\nname = \"A\"\n");
    let to = folder.join("out").display().to_string();
    let cases: [(&[&str], &str); 8] = [
        (&["compare", "--machine", "/no/such.toml"], "koren-lo-table-1"),
        (&["compare", "--machine", &negative], "x.gain is -10"),
        (&["compare", "--machine", &odd], "grains"),
        (&["compare", "--scenario", "S99"], "S99 is neither a scenario"),
        (&["compare", "--scenario", &rows], "missing field"),
        (&["compare", "--controller", "bang-bang"], "adaptive-zpetc"),
        (&["compare", "--model-error", "nan"], "--model-error"),
        (&["compare", "--plan", &rows], "no plan file"),
    ];
    for (arguments, says) in cases {
        let output = studies(&[arguments, &["-o", &to]].concat());
        assert!(
            !output.status.success() && errors(&output).contains(says),
            "{arguments:?}: {}",
            errors(&output)
        );
        assert!(!Path::new(&to).exists(), "{arguments:?}");
    }
}
