//! Tests of `keepout align`, and of the alignment file that `plan` and `run` read.
#![expect(clippy::unwrap_used, reason = "a helper of a test may stop it")]

mod support;

use std::path::Path;
use std::process::Output;

use support::{bracket, code, complaint, folder, keepout};

fn printed(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// The `--point` argument of a drawing point, for a drawing turned by 12° with its origin at (−250, −200) mm.
fn point(x: f64, y: f64) -> String {
    let (sin, cos) = 12_f64.to_radians().sin_cos();
    format!("{x},{y}={:.4},{:.4}", x * cos - y * sin - 250.0, x * sin + y * cos - 200.0)
}

fn aligned(folder: &Path) -> String {
    let alignment = folder.join("setup.toml").display().to_string();
    let points = [point(0.0, 0.0), point(100.0, 0.0), point(0.0, 60.0)];
    let mut arguments = vec!["align".to_owned(), bracket(), "-o".into(), alignment.clone()];
    arguments.extend(points.into_iter().flat_map(|point| ["--point".into(), point]));
    let output = keepout(&arguments.iter().map(String::as_str).collect::<Vec<_>>());
    let text = printed(&output);
    assert_eq!(code(&output), 0, "{}", complaint(&output));
    assert!(text.contains("rotation     1") && text.contains("does not affect it"), "{text}");
    alignment
}

#[test]
fn alignment_serves_plan_and_run() {
    let folder = folder("align");
    let alignment = aligned(&folder);
    let plan = folder.join("part.plan").display().to_string();
    let made = keepout(&["plan", &bracket(), "--tool-diameter", "6", "--alignment", &alignment, "-o", &plan]);
    let text = printed(&made);
    assert!(code(&made) == 0 && text.contains("placed       turned by 1"), "{text}{}", complaint(&made));
    let run = keepout(&[
        "run",
        &plan,
        "--machine",
        "sim-fast",
        "--operator",
        "wall",
        "--jog-s",
        "5",
        "--alignment",
        &alignment,
    ]);
    let text = printed(&run);
    assert!(
        code(&run) == 9 && text.contains("deepest gouge                        0.00000 mm"),
        "{text}{}",
        complaint(&run)
    );
    // An alignment that was found with another drawing is refused, unless both have the same origin.
    let text = std::fs::read_to_string(&alignment).unwrap();
    let other = folder.join("other.toml").display().to_string();
    std::fs::write(&other, text.replace("bracket.dxf", "lid.dxf")).unwrap();
    for (alignment, noted) in [(&alignment, false), (&other, true)] {
        let run =
            keepout(&["run", &plan, "--machine", "sim-fast", "--limit-s", "1", "--alignment", alignment]);
        assert_eq!(complaint(&run).contains("was found with lid.dxf"), noted, "{}", complaint(&run));
        assert_eq!(code(&run) == 2, noted);
        let same = ["--alignment", alignment, "--same-origin"];
        let run = keepout(&[&["run", &plan, "--machine", "sim-fast", "--limit-s", "1"], &same[..]].concat());
        assert_eq!(code(&run), 9, "{}", complaint(&run));
    }
    // On a real machine, the alignment file is enough: --origin-mm is not needed besides.
    let port = ["run", &plan, "--port", "/dev/no-such-port", "--home", "--operator", "keyboard"];
    let run = keepout(&[&port[..], &["--simulate"]].concat());
    assert!(code(&run) == 2 && complaint(&run).contains("the drawing's origin"), "{}", complaint(&run));
    let run = keepout(&[&port[..], &["--simulate", "--alignment", &alignment]].concat());
    assert!(code(&run) == 6 && complaint(&run).contains("cannot open port"), "{}", complaint(&run));
    let run = keepout(&[&port[..], &["--alignment", &alignment]].concat());
    assert!(complaint(&run).contains("are of the simulated GRBL 1.1 table"), "{}", complaint(&run));
    let run = keepout(&[&port[..], &["--alignment", &alignment, "--origin-mm", "-250,-200"]].concat());
    assert_eq!(code(&run), 2, "{}", complaint(&run));
}

#[test]
fn plan_with_another_rotation_or_offset_than_the_alignment_is_refused() {
    let folder = folder("register_otherwise");
    let alignment = aligned(&folder);
    let plan = folder.join("part.plan").display().to_string();
    let planned = |more: &[&str]| {
        let mut arguments = vec!["plan", "", "--tool-diameter", "6", "-o", &plan, "--overwrite"];
        let drawing = bracket();
        arguments[1] = &drawing;
        arguments.extend(more);
        keepout(&arguments)
    };
    let run = || keepout(&["run", &plan, "--machine", "sim-fast", "--alignment", &alignment]);
    for (more, words) in [
        (&[][..], "turned by 0°"),
        (&["--rotate-deg", "11"], "turned by 11°"),
        (&["--rotate-deg", "12", "--offset-mm", "1,2"], "--offset-mm 1,2"),
    ] {
        assert_eq!(code(&planned(more)), 0, "{more:?}");
        let run = run();
        assert!(code(&run) == 4 && complaint(&run).contains(words), "{more:?}: {}", complaint(&run));
    }
    for more in [["--rotate-deg", "12"], ["--offset-mm", "1,2"]] {
        let both = planned(&[&["--alignment", &alignment][..], &more].concat());
        assert!(code(&both) == 2 && complaint(&both).contains("--alignment"), "{}", complaint(&both));
    }
    let onto =
        keepout(&["plan", &bracket(), "--tool-diameter", "6", "--alignment", &alignment, "-o", &alignment]);
    assert!(code(&onto) == 2 && complaint(&onto).contains("not overwritten"), "{}", complaint(&onto));
    let text = std::fs::read_to_string(&alignment).unwrap();
    let damages = [
        (text.replace("version = 1", "version = 9"), "version 9"),
        (text.replace("version = 1", "version = 1\nshear_deg = 1.0"), "shear_deg"),
        (text.replace("origin_mm = [", "origin_mm = [1.0, "), "expected an array of two"),
        (text.replace("rotation_deg = 1", "rotation_deg = 9991"), "rotation_deg is 9991"),
        (String::new(), "no alignment file"),
    ];
    for (damaged, words) in damages {
        std::fs::write(&alignment, damaged).unwrap();
        let made = planned(&["--alignment", &alignment]);
        assert!(code(&made) == 2 && complaint(&made).contains(words), "{words}: {}", complaint(&made));
    }
    std::fs::remove_file(&alignment).unwrap();
    assert!(complaint(&run()).contains("keepout align"));
}

#[test]
fn ambiguous_probe_points_are_refused_and_write_no_file() {
    let folder = folder("register_refused");
    let alignment = folder.join("setup.toml").display().to_string();
    let drawing = bracket();
    let attempt = |more: &[&str]| keepout(&[&["align", &drawing, "-o", &alignment], more].concat());
    let cases: [(&[&str], i32, &str); 8] = [
        (&[], 2, "too few probe points"),
        (&["--point", "here"], 2, "not a probe point"),
        (&["--point", "0,0=1"], 2, "two lengths"),
        (
            &["--point", "0,0=-200,-200", "--point", "100,0=-100.5,-200"],
            2,
            "100.0000 mm apart in the drawing",
        ),
        (&["--edge", "50,0=-200,-203"], 2, "--probe-diameter"),
        (&["--point", "0,0=-200,-200", "--rotate-deg", "3"], 2, "leave out --rotate-deg"),
        (&["--point", "0,0=-200,-200", "--layer", "NONE"], 3, "NONE"),
        (&["--point", "0,0=-200,-200", "--probe-error-mm", "0"], 2, "probe error"),
    ];
    for (more, wanted, words) in cases {
        let output = attempt(more);
        assert!(
            code(&output) == wanted && complaint(&output).contains(words),
            "{more:?}: {} {}",
            code(&output),
            complaint(&output)
        );
    }
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 0);
    let edges = ["--edge", "50,0=-200,-203", "--edge", "0,30=-253,-170", "--probe-diameter", "6"];
    let output = attempt(&edges);
    assert!(code(&output) == 0 && printed(&output).contains("not measured"), "{}", complaint(&output));
    assert!(printed(&output).contains("(-250.000, -200.000) mm machine"), "{}", printed(&output));
}
