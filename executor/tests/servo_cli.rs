//! `keepout servo` as an engineer meets it.
#![expect(clippy::unwrap_used, reason = "a helper of a test may stop it")]

mod support;

use std::path::Path;
use std::process::Output;

use support::{bracket, code, complaint, folder, keepout};

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn text(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap()
}

#[test]
fn compare_writes_tables_and_pictures() {
    let folder = folder("servo-compare");
    let to = folder.display().to_string();
    let output = keepout(&[
        "servo",
        "compare",
        "--scenario",
        "S1",
        "--scenario",
        "S6",
        "--model-error",
        "2",
        "-o",
        &to,
    ]);
    assert_eq!(code(&output), 0, "{}", complaint(&output));
    let table = said(&output);
    assert!(table.contains("| ZPETC | 17.8 / 25.2 |") && table.contains("**S6** corner"), "{table}");
    assert!(table.starts_with(&text(&folder.join("compare.md"))));
    // A line for each controller but the repetitive one, for which these paths do not repeat.
    assert_eq!(text(&folder.join("compare.csv")).lines().count(), 1 + 2 * 19);
    for name in ["S1.svg", "S6.svg"] {
        assert!(text(&folder.join(name)).ends_with("</svg>\n"));
    }
}

#[test]
fn finishing_path_of_a_plan_is_compared() {
    let folder = folder("servo-plan");
    let plan = folder.join("part.plan").display().to_string();
    assert_eq!(code(&keepout(&["plan", &bracket(), "--tool-diameter", "6", "-o", &plan])), 0);
    let compare = [
        "servo",
        "compare",
        "--plan",
        &plan,
        "--controller",
        "p",
        "--controller",
        "contouring",
        "--ramp-s",
        "0.2",
    ];
    let output = keepout(&compare);
    assert_eq!(code(&output), 0, "{}", complaint(&output));
    let table = said(&output);
    let max = |name: &str| -> f64 {
        let line = table.lines().find(|line| line.starts_with(&format!("| {name} |"))).unwrap();
        let cells = line.split('|').filter_map(|cell| cell.split('/').nth(1));
        cells.map(|cell| cell.trim().parse::<f64>().unwrap()).fold(0.0, f64::max)
    };
    // At constant feed around its corners.
    assert!(max("contouring MPC with observer") < 30.0 && max("P") > 100.0, "{table}");
}

#[test]
fn budget_goes_into_a_machine_profile_and_a_plan_names_it() {
    let folder = folder("servo-budget");
    let machine = folder.join("mill.toml").display().to_string();
    let budget =
        ["servo", "budget", "koren-lo-table-2", "--feed", "754", "--controller", "ccc", "-o", &machine];
    let output = keepout(&budget);
    assert_eq!(code(&output), 0, "{}", complaint(&output));
    assert!(complaint(&output).contains("no [interpolator]"), "{}", complaint(&output));
    let table = said(&output);
    let line = table.lines().find(|line| line.starts_with("contour error 0.")).unwrap().to_string();
    let plan = folder.join("part.plan").display().to_string();
    let planned =
        keepout(&["plan", &bracket(), "--tool-diameter", "6", "--machine-profile", &machine, "-o", &plan]);
    assert_eq!(code(&planned), 0, "{}", complaint(&planned));
    let margin = said(&planned);
    let term =
        margin.lines().find(|line| line.trim_start().starts_with("contour error")).unwrap().to_string();
    let source = line.split_once(" mm: ").unwrap().1;
    let figure = line.trim_start_matches("contour error ").split(' ').next().unwrap();
    assert!(term.contains(source) && term.contains(figure), "{line}\n{term}");
    let verified = keepout(&["verify", &plan]);
    assert_eq!(code(&verified), 0, "{}", complaint(&verified));
    // A profile that says nothing of where its figure comes from serves as ever.
    let bare: String = text(Path::new(&machine))
        .lines()
        .filter(|line| !line.contains("source"))
        .map(|line| format!("{line}\n"))
        .collect();
    let bare_profile = folder.join("bare.toml").display().to_string();
    std::fs::write(&bare_profile, bare).unwrap();
    let planned = keepout(&[
        "plan",
        &bracket(),
        "--tool-diameter",
        "6",
        "--machine-profile",
        &bare_profile,
        "-o",
        &plan,
    ]);
    assert_eq!(code(&planned), 0, "{}", complaint(&planned));
    assert_eq!(code(&keepout(&["verify", &plan])), 0);
    assert!(source.contains("Koren & Lo, Table 2") && source.contains("754 mm/min"), "{source}");
    // Once more, over the profile that was written.
    let again = keepout(&[budget.as_slice(), &["--machine-profile", &machine]].concat());
    assert_eq!(code(&again), 0, "{}", complaint(&again));
    // Without one the other figures are not of the machine, and that is said here and at the machine.
    let of_which = "the other figures are of the simulated";
    assert!(complaint(&output).contains(of_which) && !complaint(&again).contains(of_which));
    let at_the_machine = |plan: &str| {
        complaint(&keepout(&["run", plan, "--port", "/dev/null", "--homed", "--origin-mm", "0,0"]))
    };
    let told = "margin and travel are of the simulated";
    assert!(at_the_machine(&plan).contains(told), "{}", at_the_machine(&plan));
    let profile = text(Path::new(&machine)).replacen("simulated GRBL 1.1 table", "mill", 1);
    std::fs::write(&machine, profile).unwrap();
    let planned =
        keepout(&["plan", &bracket(), "--tool-diameter", "6", "--machine-profile", &machine, "-o", &plan]);
    assert_eq!(code(&planned), 0, "{}", complaint(&planned));
    assert!(!at_the_machine(&plan).contains(told), "{}", at_the_machine(&plan));
}

#[test]
fn table_3_is_printed() {
    let output = keepout(&["servo", "table3"]);
    assert!(code(&output) == 0 && said(&output).contains("of the paper's cells agree"), "{}", said(&output));
}

#[test]
fn what_is_wrong_is_named_and_nothing_is_written() {
    let folder = folder("servo-bad");
    let file = |name: &str, text: &str| {
        let path = folder.join(name);
        std::fs::write(&path, text).unwrap();
        path.display().to_string()
    };
    let drives = include_str!("../src/servo/machines/koren-lo-table-1.toml");
    let negative = file("negative.toml", &drives.replacen("gain = 10.0", "gain = -10.0", 1));
    let quick = file("quick.toml", &drives.replacen("period_s = 0.004", "period_s = 0.00001", 1));
    let odd = file("odd.toml", &drives.replacen("[gains]", "[grains]", 1));
    let rows = file("rows.toml", "[[scenario]]\nname = \"A\"\n");
    let to = folder.join("out").display().to_string();
    let fast = keepout_planner::machine::MachineProfile::simulated().to_toml().replace("1000.0", "8000.0");
    let fast = file("fast.toml", &fast);
    let cases: [(&[&str], &str); 15] = [
        (&["compare", "--machine", "/no/such.toml"], "koren-lo-table-1"),
        (&["compare", "--machine", &negative], "x.gain is -10"),
        (&["compare", "--machine", &odd], "grains"),
        (&["compare", "--scenario", "S99"], "S99 is neither a scenario"),
        (&["compare", "--scenario", &rows], "missing field"),
        (&["compare", "--controller", "bang-bang"], "adaptive-zpetc"),
        (&["compare", "--model-error", "nan"], "--model-error"),
        (&["compare", "--plan", &rows], "no plan file"),
        (&["budget", "koren-lo-table-1", "--feed", "0"], "--feed 0"),
        (&["budget", "koren-lo-table-1", "--feed", "900", "--by-hand", "900"], "--by-hand"),
        (&["budget", "simulated", "--feed", "900", "--machine-profile", &fast, "-o", &to], "would not hold"),
        (&["budget", "simulated", "--feed", "60000"], "beyond the drives"),
        (&["budget", &quick, "--feed", "1"], "samples of the profile"),
        (&["budget", &quick, "--feed", "900", "-o", &quick], "is what is read"),
        (&["budget", "koren-lo-table-1", "--feed", "900", "--machine-profile", &odd], "--output"),
    ];
    for (arguments, says) in cases {
        let mut all = vec!["servo"];
        all.extend(arguments);
        if arguments[0] == "compare" {
            all.extend(["-o", &to]);
        }
        let output = keepout(&all);
        assert!(
            code(&output) != 0 && complaint(&output).contains(says),
            "{arguments:?}: {}",
            complaint(&output)
        );
        assert!(!Path::new(&to).exists(), "{arguments:?}");
    }
}
