//! Real drawings of many exporters, from `KEEPOUT_SHARED`: what is understood of them, and the whole job on some.

use std::path::Path;
use std::time::Duration;

use keepout_executor::operator;
use keepout_executor::session::{Ended, Link, Log, SimRun, run_simulated};
use keepout_planner::units::point_mm;
use keepout_tests::{REAL_DRAWINGS, area_mm2, order, plan_of, shared};
use serde_json::Value;

/// What an independent reading found in a drawing.
struct Oracle {
    loops: usize,
    area: f64,
    area_tolerance: f64,
    bounds: [f64; 4],
}

/// Millimetres of a file's unit, as `$INSUNITS` numbers it.
fn scale(entry: &Value) -> f64 {
    match entry["insunits"].as_u64() {
        Some(1) => 25.4,
        Some(6) => 1000.0,
        _ => 1.0,
    }
}

fn oracle(entry: &Value) -> Option<Oracle> {
    let reference = &entry["ref"];
    let scale = scale(entry);
    let corners: Vec<f64> = reference["bbox_loops"].as_array()?.iter().filter_map(Value::as_f64).collect();
    let bounds: [f64; 4] = corners.try_into().ok()?;
    Some(Oracle {
        loops: usize::try_from(reference["loops"].as_u64()?).ok()?,
        area: reference["area_evenodd"].as_f64()? * scale * scale,
        area_tolerance: reference["area_tolerance"].as_f64().unwrap_or(0.0) * scale * scale,
        bounds: bounds.map(|c| c * scale),
    })
}

/// Every drawing gives a plan that agrees with the oracle, or a message; drawings without defects of the kinds that
/// are read give a plan.
#[test]
fn every_drawing_is_understood_or_explained() {
    let Some(shared) = shared() else { return };
    let text = std::fs::read_to_string(shared.join("dxf/oracle_dev.json")).unwrap();
    let entries: Value = serde_json::from_str(&text).unwrap();
    let (mut planned, mut explained, mut wrong) = (0, 0, Vec::new());
    for (name, entry) in entries.as_object().unwrap() {
        let path = shared.join("dxf").join(name);
        match plan_of(&path, &order(1.0)) {
            Ok(plan) => {
                planned += 1;
                if let Err(difference) = compare(&plan, entry) {
                    wrong.push(format!("{name}: {difference}"));
                }
            }
            Err(message) => {
                explained += 1;
                assert!(message.len() > 40 && message.contains(['.', ';']), "{name}: {message}");
            }
        }
    }
    eprintln!("{planned} planned, {explained} refused with a message");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(planned >= 30, "only {planned} drawings were planned");
}

fn compare(plan: &keepout_planner::plan::CertifiedPlan, entry: &Value) -> Result<(), String> {
    let oracle = oracle(entry).ok_or("planned, but the oracle has no contours")?;
    let loops = plan.plan.profile.loops.len();
    if loops != oracle.loops {
        return Err(format!("{loops} contours, the oracle has {}", oracle.loops));
    }
    let area = area_mm2(plan);
    if (area - oracle.area).abs() > 0.001 * oracle.area.abs() + oracle.area_tolerance {
        return Err(format!("area {area:.3}, the oracle has {:.3}", oracle.area));
    }
    let (low, high) = plan.part_box();
    let ((x0, y0), (x1, y1)) = (point_mm(low), point_mm(high));
    let worst = [x0, y0, x1, y1].iter().zip(oracle.bounds).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    if worst > 0.02 { Err(format!("box off by {worst:.4} mm")) } else { Ok(()) }
}

/// The whole job in virtual time: 20 s of each operator over a slow line, then the contour.
#[test]
fn whole_job_on_real_drawings() {
    let Some(shared) = shared() else { return };
    for (index, (name, exporter)) in REAL_DRAWINGS.iter().enumerate() {
        let operator = ["wall", "calm", "random"][index % 3];
        whole_job(&shared.join("dxf/dev").join(name), operator)
            .unwrap_or_else(|reason| panic!("{name} ({exporter}), {operator}: {reason}"));
    }
}

fn whole_job(path: &Path, operator: &str) -> Result<(), String> {
    let plan = plan_of(path, &order(3.0))?;
    let mut run = SimRun {
        link: Link::Virtual,
        baud: 9600,
        latency: Duration::from_millis(150),
        feed_mm_min: 3000,
        ..SimRun::default()
    };
    run.machine.stroke_mm = [480.0, 440.0];
    let operator = operator::named(operator, 20.0, 5).map_err(|error| error.to_string())?;
    let result = run_simulated(plan, &run, operator, Log::none(), |_| {}, &mut |_, _, _| {})
        .map_err(|error| error.to_string())?;
    let facts = &result.facts;
    let coverage = facts.coverage.ok_or(format!("nothing was contoured: {facts:?}"))?;
    if facts.deepest_mm != Some(0.0) {
        return Err(format!("the tool went into the part: {facts:?}"));
    }
    if facts.closest_by_hand_mm.is_none_or(|closest| closest <= 0.2) {
        return Err(format!("by hand the allowance was not kept: {facts:?}"));
    }
    if facts.ended != Ended::Done || facts.unreached > 0 || coverage.missed > 0 || coverage.worst_mm > 0.020 {
        return Err(format!("{facts:?}"));
    }
    Ok(())
}
