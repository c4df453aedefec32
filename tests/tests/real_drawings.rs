//! Real drawings of many exporters, from `KEEPOUT_SHARED`: the reading of all, and the end-to-end job on
//! some.

use std::path::Path;
use std::time::Duration;

use keepout_executor::session::{Going, NoEventLog};
use keepout_executor::supervisor::PreparedPlan;
use keepout_planner::drawing::{EntityFilter, read_file};
use keepout_planner::inspect::inspect;
use keepout_sim::operator;
use keepout_sim::session::{Link, SimRun, run_simulated};
use keepout_tests::{REAL_DRAWINGS, most_left_mm, oracle, order, plan_bytes, plan_of, shared};

/// Every drawing without a defect gives the same contours as the independent reading. Every drawing without a
/// problem gives a plan. Every other drawing gives a plan or a message.
#[test]
fn every_drawing_agrees_with_the_independent_reading_or_is_explained() {
    let Some(shared) = shared() else { return };
    let entries = oracle::read(&shared).unwrap();
    assert!(entries.len() >= 71, "the shared set has {} drawings", entries.len());
    let (mut agree, mut planned, mut wrong) = (0, 0, Vec::new());
    for (name, entry) in &entries {
        let bytes = read_file(&shared.join("dxf").join(name)).unwrap();
        let (drawing, chained) = match order(1.0).contours(&bytes) {
            Ok(contours) => contours,
            Err(error) => {
                let message = error.to_string();
                assert!(message.len() > 40 && message.contains(['.', ';']), "{name}: {message}");
                assert!(!entry.defects.is_empty(), "{name} has no defect: {message}");
                continue;
            }
        };
        let found = inspect(&drawing, &chained, &EntityFilter::default());
        let same = entry.reading.as_ref().map(|reading| reading.agrees(&found));
        match same {
            Some(Ok(())) => agree += 1,
            Some(Err(difference)) if entry.defects.is_empty() => wrong.push(format!("{name}: {difference}")),
            _ => {}
        }
        if found.problems.is_empty() {
            match plan_bytes(name, &bytes, &order(1.0)) {
                Ok(_) => planned += 1,
                Err(error) => wrong.push(format!("{name}: {error}")),
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(agree >= 56 && planned >= 41, "{agree} agree, {planned} were planned");
}

/// The end-to-end job in virtual time: 20 s of jogging by one operator over a slow line, then the contour.
#[test]
fn end_to_end_job_succeeds_on_real_drawings() {
    let Some(shared) = shared() else { return };
    for (index, (name, exporter)) in REAL_DRAWINGS.iter().enumerate() {
        let operator = ["wall", "calm", "random"][index % 3];
        end_to_end(&shared.join("dxf/dev").join(name), operator)
            .unwrap_or_else(|reason| panic!("{name} ({exporter}), {operator}: {reason}"));
    }
}

fn end_to_end(path: &Path, operator: &str) -> Result<(), String> {
    let plan = plan_of(path, &order(3.0))?;
    let most_left_mm = most_left_mm(&plan);
    let mut run = SimRun {
        link: Link::Virtual,
        baud: 9600,
        latency: Duration::from_millis(150),
        feed_mm_min: 3000,
        ..SimRun::default()
    };
    run.machine.travel_mm = [480.0, 440.0];
    let operator = operator::named(operator, 20.0, 5).map_err(|error| error.to_string())?;
    let result =
        run_simulated(PreparedPlan::new(plan), &run, operator, Box::new(NoEventLog), &mut |_, _, _| {
            Going::On
        })
        .map_err(|error| error.to_string())?;
    let facts = &result.facts;
    let coverage = facts.coverage.ok_or(format!("no contour was cut: {facts:?}"))?;
    if facts.deepest_mm != Some(0.0) {
        return Err(format!("the tool went into the part: {facts:?}"));
    }
    if facts.closest_by_hand_mm.is_none_or(|closest| closest <= 0.2) {
        return Err(format!("the tool entered the stock to leave while jogging: {facts:?}"));
    }
    if !facts.outcome.is_by_operator()
        || facts.outcome.lacks_link_move()
        || coverage.missed > 0
        || coverage.worst_mm > most_left_mm
    {
        return Err(format!("{facts:?}"));
    }
    Ok(())
}
