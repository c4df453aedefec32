//! Tests of `keepout drives`: the budget's table, the machine profile that it writes, and its errors.
#![expect(clippy::unwrap_used, reason = "a helper of a test may stop it")]

mod support;

use std::path::Path;
use std::process::Output;

use support::{bracket, code, complaint, folder, keepout};

fn printed(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn text(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap()
}

const TABLE_2: &str = include_str!("../../../planner/drives/src/machines/koren-lo-table-2.toml");

fn plan_with(machine: &str, plan: &str) -> Output {
    let tool = ["--tool-diameter", "6", "--machine-profile", machine];
    keepout(&[&["plan", &bracket(), "-o", plan, "--overwrite"], &tool[..]].concat())
}

#[test]
fn budget_goes_into_a_machine_profile_and_a_plan_names_it() {
    let folder = folder("drives-budget");
    let machine = folder.join("mill.toml").display().to_string();
    let drives = folder.join("drives.toml").display().to_string();
    let named = TABLE_2.replacen("whole_numbers = true", "whole_numbers = true\ncontroller = \"ccc\"", 1);
    std::fs::write(&drives, named).unwrap();
    let budget = ["drives", "budget", &drives, "--feed", "754", "-o", &machine];
    let output = keepout(&budget);
    assert_eq!(code(&output), 0, "{}", complaint(&output));
    assert!(complaint(&output).contains("no [interpolator]"), "{}", complaint(&output));
    let table = printed(&output);
    let line = table.lines().find(|line| line.starts_with("contour error 0.")).unwrap().to_string();
    let plan = folder.join("part.plan").display().to_string();
    let planned = plan_with(&machine, &plan);
    assert_eq!(code(&planned), 0, "{}", complaint(&planned));
    let margin = printed(&planned);
    let term =
        margin.lines().find(|line| line.trim_start().starts_with("contour error")).unwrap().to_string();
    let source = line.split_once(" mm: ").unwrap().1;
    let figure = line.trim_start_matches("contour error ").split(' ').next().unwrap();
    assert!(term.contains(source) && term.contains(figure), "{line}\n{term}");
    let verified = keepout(&["verify", &plan]);
    assert_eq!(code(&verified), 0, "{}", complaint(&verified));
    // A profile that does not say how its figure was obtained is refused.
    let bare: String = text(Path::new(&machine))
        .lines()
        .filter(|line| !line.contains("source"))
        .map(|line| format!("{line}\n"))
        .collect();
    let bare_profile = folder.join("bare.toml").display().to_string();
    std::fs::write(&bare_profile, bare).unwrap();
    let planned = plan_with(&bare_profile, &plan);
    assert!(complaint(&planned).contains("contour_error_source"), "{}", complaint(&planned));
    assert!(source.contains("Koren & Lo, Table 2") && source.contains("754 mm/min"), "{source}");
    // The budget can overwrite the profile that it wrote.
    let again = keepout(&[budget.as_slice(), &["--machine-profile", &machine]].concat());
    assert_eq!(code(&again), 0, "{}", complaint(&again));
    // Without --machine-profile the other figures are not the machine's. `drives` prints a note, and so does
    // `run`.
    let of_which = "the other figures are of the simulated";
    assert!(complaint(&output).contains(of_which) && !complaint(&again).contains(of_which));
    let at_the_machine = |plan: &str| {
        let port = ["--port", "/dev/null", "--homed", "--origin-mm", "0,0", "--operator", "keyboard"];
        complaint(&keepout(&[&["run", plan], &port[..]].concat()))
    };
    let note = "margin and travel are of the simulated";
    assert!(at_the_machine(&plan).contains(note), "{}", at_the_machine(&plan));
    let profile = text(Path::new(&machine)).replacen("simulated GRBL 1.1 table", "mill", 1);
    std::fs::write(&machine, profile).unwrap();
    let planned = plan_with(&machine, &plan);
    assert_eq!(code(&planned), 0, "{}", complaint(&planned));
    assert!(!at_the_machine(&plan).contains(note), "{}", at_the_machine(&plan));
}

#[test]
fn wrong_arguments_of_drives_are_named_and_write_no_file() {
    let folder = folder("drives-bad");
    let file = |name: &str, text: &str| {
        let path = folder.join(name);
        std::fs::write(&path, text).unwrap();
        path.display().to_string()
    };
    let drives = include_str!("../../../planner/drives/src/machines/koren-lo-table-1.toml");
    let quick = file("quick.toml", &drives.replacen("period_s = 0.004", "period_s = 0.00001", 1));
    let odd = file("odd.toml", &drives.replacen("[gains]", "[grains]", 1));
    let to = folder.join("out").display().to_string();
    let fast = keepout_planner::machine::MachineProfile::simulated().to_toml().replace("1000.0", "8000.0");
    let fast = file("fast.toml", &fast);
    let cases: [(&[&str], &str); 8] = [
        (&["budget", "koren-lo-table-2", "--feed", "900", "-o", &to], "names no controller"),
        (&["budget", "koren-lo-table-1", "--feed", "0"], "--feed 0"),
        (&["budget", "koren-lo-table-1", "--feed", "900", "--by-hand", "900"], "--by-hand"),
        (&["budget", "simulated", "--feed", "900", "--machine-profile", &fast, "-o", &to], "would not hold"),
        (&["budget", "simulated", "--feed", "60000"], "beyond the drives"),
        (&["budget", &quick, "--feed", "1"], "samples of the profile"),
        (&["budget", &quick, "--feed", "900", "-o", &quick], "is an input"),
        (&["budget", "koren-lo-table-1", "--feed", "900", "--machine-profile", &odd], "--output"),
    ];
    for (arguments, says) in cases {
        let mut all = vec!["drives"];
        all.extend(arguments);
        let output = keepout(&all);
        assert!(
            code(&output) != 0 && complaint(&output).contains(says),
            "{arguments:?}: {}",
            complaint(&output)
        );
        assert!(!Path::new(&to).exists(), "{arguments:?}");
    }
}
