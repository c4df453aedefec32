//! The page of the tuned controllers agrees with the program.
#![expect(clippy::unwrap_used, reason = "a helper of a test may stop it")]

use keepout_drives::controllers::kind::Kind;
use keepout_studies::tuned::page::{TunedRow, kinds};
use keepout_studies::tuned::variant::{Variant, paths};

const PAGE: &str = include_str!("../../../docs/research/tuned-controllers.md");

/// The cell of a controller and a variant in the table of a path.
fn cell(path: &str, kind: Kind, variant: &Variant) -> String {
    let table = PAGE.lines().skip_while(|line| !line.starts_with(&format!("| {path}: ")));
    let mut lines = table.take_while(|line| line.starts_with('|'));
    let columns = lines.next().unwrap();
    let column = columns.split('|').position(|name| name.trim() == variant.name()).unwrap();
    let row = lines.find(|line| line.starts_with(&format!("| {} |", kind.names().1))).unwrap();
    row.split('|').nth(column).unwrap().trim().to_string()
}

/// Some controllers are tuned and run again. The others take minutes.
#[test]
fn page_agrees_with_the_program() {
    let (variant, paths) = (Variant { period_s: 0.004, pulse_um: 10.0 }, paths());
    let machine = variant.machine().unwrap();
    for kind in [Kind::P, Kind::PidD] {
        let row = TunedRow::of(&variant, &machine, kind, &paths);
        for (at, path) in paths.iter().enumerate() {
            let (ours, there) = (row.cell(at), cell(path.name, kind, &variant));
            let number = |text: &str| text.parse::<f64>().unwrap();
            // The last digit of a sine depends on the system.
            let same = (number(&ours) / number(&there) - 1.0).abs() < 0.02;
            assert!(same, "{kind:?} on {}: {ours}, on the page {there}", path.name);
        }
    }
}

#[test]
fn page_has_every_controller_on_every_path() {
    for path in paths() {
        for variant in Variant::all() {
            for kind in kinds() {
                assert!(!cell(path.name, kind, &variant).is_empty());
            }
        }
    }
}
