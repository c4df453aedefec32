//! Prints the feel of jogging as Markdown tables: `cargo run --release -p keepout-tests --bin feel`.

use std::process::ExitCode;

use keepout_executor::dialect::DialectName;
use keepout_tests::feel::{self, CURVE_PUSH, MachineTable, ReleasePlace, WallShape, median_and_p99};

/// Push angles into the straight wall, degrees.
const ANGLES: [f64; 6] = [0.0, 15.0, 30.0, 45.0, 60.0, 75.0];
/// Angles of the straight wall, degrees.
const WALLS: [f64; 2] = [0.0, 17.0];
/// Delays of the line, ms each way.
const DELAYS_MS: [u64; 2] = [1, 50];
/// Pushes from rest.
const PUSHES: usize = 200;

fn main() -> ExitCode {
    for table in [straight, curved, corners, first_steps, releases] {
        if let Err(message) = table() {
            eprintln!("feel: {message}");
            return ExitCode::FAILURE;
        }
    }
    ExitCode::SUCCESS
}

fn header(columns: &str) {
    println!("{columns}\n|{}", "---|".repeat(columns.matches('|').count() - 1));
}

fn straight() -> Result<(), String> {
    println!(
        "Sliding along a straight wall: share of the commanded component, dips per metre, height (p90), \
         full stops.\n"
    );
    header("| table | delay | wall | 0° | 15° | 30° | 45° | 60° | 75° |");
    for table in &MachineTable::ALL {
        for (delay, wall) in DELAYS_MS.into_iter().flat_map(|delay| WALLS.map(|wall| (delay, wall))) {
            print!("| {} | {delay} ms | {wall}° |", table.name);
            for angle in ANGLES {
                let slide = feel::straight(table, wall, angle, delay)?;
                let share = 100.0 * slide.share;
                print!(
                    " {share:.0} %, {:.0}, {:.3} mm, {} |",
                    slide.dips_per_m, slide.height_mm, slide.stops
                );
            }
            println!();
        }
    }
    println!();
    Ok(())
}

fn curved() -> Result<(), String> {
    println!(
        "Sliding along a smooth wall, pushed {CURVE_PUSH}° into it: speed, dips below 40 % of it per metre, \
         height (p90), full stops.\n"
    );
    header("| wall | A, 1 ms | A, 50 ms | B, 1 ms | C, 1 ms | K, 1 ms |");
    for shape in WallShape::CURVES {
        print!("| {shape:?} |");
        let [a, b, c, k] = &MachineTable::ALL;
        for (table, delay) in [(a, 1), (a, 50), (b, 1), (c, 1), (k, 1)] {
            let slide = feel::curved(table, shape, delay)?;
            let (speed, dips) = (slide.speed_mm_s, slide.dips_per_m);
            print!(" {speed:.1} mm/s, {dips:.0}, {:.3} mm, {} |", slide.height_mm, slide.stops);
        }
        println!();
    }
    println!();
    Ok(())
}

fn corners() -> Result<(), String> {
    println!(
        "Past an outside corner, pushed 45° into the wall: from 30 mm before it to beside the end of the \
         bar.\n"
    );
    header("| table | 1 ms | 50 ms |");
    for table in &MachineTable::ALL {
        let seconds = [feel::corner(table, 1)?, feel::corner(table, 50)?];
        println!("| {} | {:.2} s | {:.2} s |", table.name, seconds[0], seconds[1]);
    }
    println!();
    Ok(())
}

fn first_steps() -> Result<(), String> {
    println!("First step after a push from rest, {PUSHES} pushes: median and 99th percentile.\n");
    header("| table | delay | median | p99 |");
    for table in &MachineTable::ALL {
        for delay in DELAYS_MS {
            let (median, p99) = median_and_p99(&feel::first_steps(table, delay, PUSHES)?);
            println!("| {} | {delay} ms | {:.0} ms | {:.0} ms |", table.name, 1e3 * median, 1e3 * p99);
        }
    }
    println!();
    Ok(())
}

fn releases() -> Result<(), String> {
    println!("From release to rest, at full deflection and 45°: time and distance.\n");
    header("| table | delay | grbl, far | grblhal, far | grbl, sliding | grblhal, sliding |");
    for table in &MachineTable::ALL {
        for delay in DELAYS_MS {
            print!("| {} | {delay} ms |", table.name);
            for wall in [ReleasePlace::Far, ReleasePlace::Sliding] {
                for language in [DialectName::Grbl, DialectName::GrblHal] {
                    let release = feel::release(table, language, delay, wall)?;
                    print!(" {:.0} ms, {:.1} mm |", 1e3 * release.seconds, release.distance_mm);
                }
            }
            println!();
        }
    }
    Ok(())
}
