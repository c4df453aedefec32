//! Tests of `keepout drives identify`, `tune`, `export` and `ballbar`: from records to profiles, and their errors.
#![expect(clippy::unwrap_used, reason = "a helper of a test may stop it")]

mod support;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Output;

use keepout_drives::Axes;
use keepout_drives::plant::{Load, Plant};
use keepout_drives::profile::DriveProfile;
use support::{bracket, code, complaint, folder, keepout};

fn printed(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn profile(path: &Path) -> DriveProfile {
    DriveProfile::load(&path.display().to_string()).unwrap()
}

/// A record of both drives of the simulated machine under steps, with positions in steps of 10 µm.
fn record(folder: &Path) -> PathBuf {
    let mut model = DriveProfile::simulated().unwrap().plant();
    model.whole_numbers = false;
    let mut plant = Plant::at_rest(model, Axes::zeros());
    let mut text = String::from("time_s,x_command,x_position_mm,y_command,y_position_mm\n");
    let steps =
        [(0.0, 100), (1500.0, 500), (0.0, 300), (-3000.0, 500), (-800.0, 400), (2000.0, 500), (0.0, 300)];
    let mut row = 0;
    for (command, rows) in steps {
        for _ in 0..rows {
            let [x, y] =
                [plant.position().x, plant.position().y].map(|pulses| (pulses / 20.0).round() / 100.0);
            writeln!(text, "{},{command},{x},{},{y}", f64::from(row) * 0.001, -command).unwrap();
            plant.step(Axes::new(command, -command), &Load::default());
            row += 1;
        }
    }
    let path = folder.join("record.csv");
    std::fs::write(&path, text).unwrap();
    path
}

#[test]
fn record_becomes_a_tuned_profile() {
    let folder = folder("drives-identify");
    let file = |name: &str| folder.join(name).display().to_string();
    let [record, found, tuned] =
        [record(&folder).display().to_string(), file("found.toml"), file("tuned.toml")];
    let output = keepout(&["drives", "identify", &record, "--drives", "simulated", "-o", &found]);
    assert_eq!(code(&output), 0, "{}", complaint(&output));
    assert!(printed(&output).contains("axis y, 95 % intervals"), "{}", printed(&output));
    let (truth, identified) = (DriveProfile::simulated().unwrap(), profile(Path::new(&found)));
    for (truth, axis) in [(truth.x, identified.x), (truth.y, identified.y)] {
        assert!((axis.gain / truth.gain - 1.0).abs() < 0.05, "{axis:?}");
        assert!((axis.time_constant_s / truth.time_constant_s - 1.0).abs() < 0.05, "{axis:?}");
        assert!((axis.coulomb_bits / truth.coulomb_bits - 1.0).abs() < 0.05, "{axis:?}");
    }
    assert!(identified.source.starts_with("identified from"), "{}", identified.source);
    let tune = ["drives", "tune", &found, "--feed", "900", "--controller", "pid", "-o", &tuned];
    let output = keepout(&tune);
    assert_eq!(code(&output), 0, "{}", complaint(&output));
    assert!(printed(&output).contains("margins      gain 2.0"), "{}", printed(&output));
    let gains = profile(Path::new(&tuned)).gains.pid;
    assert_ne!(gains, identified.gains.pid);
    let export = keepout(&["drives", "export", &tuned, "--form", "linuxcnc"]);
    let line = format!("setp pid.x.Pgain {}", gains.proportional * 2000.0);
    assert!(printed(&export).contains(&line), "{line}\n{}", printed(&export));
    let table = keepout(&["drives", "export", &tuned]);
    assert!(printed(&table).contains(&format!("pid.derivative                   {}", gains.derivative)));
}

#[test]
fn circular_test_becomes_the_contour_error_of_a_plan() {
    let folder = folder("drives-ballbar");
    let file = |name: &str| folder.join(name).display().to_string();
    let [points, base, machine, plan] =
        [file("ball.csv"), file("base.toml"), file("mill.toml"), file("part.plan")];
    let mut text = String::from("angle_deg,radius_mm\n");
    for number in 0..720 {
        let angle = f64::from(number) / 2.0;
        writeln!(text, "{angle},{}", 50.0 + 0.011_96 * (2.0 * angle.to_radians()).sin()).unwrap();
    }
    std::fs::write(&points, text).unwrap();
    std::fs::write(&base, keepout_planner::machine::MachineProfile::simulated().to_toml()).unwrap();
    let ballbar = ["drives", "ballbar", &points, "--radius-mm", "50", "--feed", "900"];
    let picture = file("ball.svg");
    let profiles = ["--machine-profile", &base, "-o", &machine, "--picture", &picture];
    let output = keepout(&[&ballbar[..], &profiles].concat());
    assert_eq!(code(&output), 0, "{}", complaint(&output));
    assert!(printed(&output).contains("contour error 0.0120 mm"), "{}", printed(&output));
    let drawn = std::fs::read_to_string(&picture).unwrap();
    assert!(drawn.contains("Circular test ball.csv") && drawn.contains("720 points"), "{drawn}");
    let tool = ["--tool-diameter", "6", "--machine-profile", &machine];
    let planned = keepout(&[&["plan", &bracket(), "-o", &plan], &tool[..]].concat());
    assert_eq!(code(&planned), 0, "{}", complaint(&planned));
    let source = "measured: circular test ball.csv, radius 50 mm, 900 mm/min, 720 points";
    assert!(printed(&planned).contains(source), "{}", printed(&planned));
}

#[test]
fn wrong_arguments_are_named_and_write_no_file() {
    let folder = folder("drives-tools-bad");
    let out = folder.join("out.toml").display().to_string();
    let text = folder.join("text.csv").display().to_string();
    std::fs::write(&text, "time_s,x_command,x_position_mm\nnow,1,2\n").unwrap();
    let still = folder.join("still.csv").display().to_string();
    let rows: String = (0..200).map(|row| format!("{},{},0.5\n", f64::from(row) * 0.01, row / 100)).collect();
    std::fs::write(&still, format!("time_s,x_command,x_position_mm\n{rows}")).unwrap();
    let ball = ["ballbar", &still, "--radius-mm"];
    let cases: [(&[&str], &str); 9] = [
        (&["identify", &text], "has 1 rows of numbers"),
        (&["identify", "none.csv"], "none.csv"),
        (&["identify", &still, "--drives", "simulated", "-o", &out], "axis x: the axis moves 0.000 mm"),
        (&["tune", "koren-lo-table-1", "--feed", "900", "-o", &out], "names no controller"),
        (&["tune", "simulated", "--feed", "0", "-o", &out], "must be between 1 and 600000"),
        (
            &["export", "simulated", "--form", "linuxcnc"],
            "LinuxCNC's pid component cannot run contouring MPC",
        ),
        (&[ball[0], ball[1], ball[2], "0.1", "--feed", "900"], "must be between 1 and 1000 mm"),
        (&[ball[0], ball[1], ball[2], "50", "--feed", "900"], "has no columns x_mm, y_mm"),
        (&[ball[0], ball[1], ball[2], "50", "--feed", "900", "--picture", &out], "out.toml"),
    ];
    for (arguments, says) in cases {
        let output = keepout(&[&["drives"], arguments].concat());
        assert_ne!(code(&output), 0, "{arguments:?}");
        assert!(complaint(&output).contains(says), "{arguments:?}: {}", complaint(&output));
    }
    assert!(!Path::new(&out).exists());
}
