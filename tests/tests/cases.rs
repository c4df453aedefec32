//! Our own drawings, as data: `cases/*.toml` and `drawings/*.dxf`.

use std::path::Path;

use keepout_planner::plan_file;
use keepout_planner::profile::MachinedSide;
use keepout_tests::{Wanted, area_mm2, plan_of};
use serde::Deserialize;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Cases {
    case: Vec<Case>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Case {
    drawing: String,
    #[serde(default)]
    side: Option<String>,
    #[serde(default)]
    tool: Option<f64>,
    #[serde(default)]
    layers: Vec<String>,
    #[serde(default)]
    units: Option<String>,
    #[serde(default)]
    join_mm: Option<f64>,
    #[serde(default)]
    contours: Option<usize>,
    #[serde(default)]
    area: Option<f64>,
    #[serde(default)]
    area_tolerance: Option<f64>,
    #[serde(default)]
    finish_loops: Option<usize>,
    #[serde(default)]
    residual_mm2: Option<f64>,
    #[serde(default)]
    repairs: Option<usize>,
    #[serde(default)]
    error: Vec<String>,
}

fn check(case: &Case) -> Result<(), String> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let default = Wanted::default();
    let wanted = Wanted {
        tool_mm: case.tool.unwrap_or(default.tool_mm),
        side: match case.side.as_deref() {
            Some("inside") => MachinedSide::Inside,
            None | Some("outside") => MachinedSide::Outside,
            Some(other) => return Err(format!("no side {other}")),
        },
        layers: case.layers.clone(),
        units: case.units.clone(),
        join_mm: case.join_mm.unwrap_or(default.join_mm),
    };
    let made = plan_of(&here.join("drawings").join(&case.drawing), &wanted);
    let plan = match made {
        Err(message) if case.error.is_empty() => return Err(message),
        Err(message) => {
            let missing = case.error.iter().find(|words| !message.contains(words.as_str()));
            return missing.map_or(Ok(()), |words| Err(format!("\"{message}\" does not say \"{words}\"")));
        }
        Ok(_) if !case.error.is_empty() => return Err("was planned, an error was wanted".into()),
        Ok(plan) => plan,
    };
    let same = |what: &str, found: usize, wanted: Option<usize>| match wanted {
        Some(wanted) if wanted != found => Err(format!("{found} {what}, {wanted} wanted")),
        _ => Ok(()),
    };
    same("contours", plan.plan.profile.loops.len(), case.contours)?;
    same("finishing loops", plan.plan.finish.loops.len(), case.finish_loops)?;
    same("repairs", plan.plan.remarks.len(), case.repairs.or(Some(0)))?;
    let near = |what: &str, found: f64, wanted: Option<f64>, tolerance: f64| match wanted {
        Some(wanted) if (wanted - found).abs() > tolerance => Err(format!("{what} {found}, {wanted} wanted")),
        _ => Ok(()),
    };
    near("area", area_mm2(&plan), case.area, case.area_tolerance.unwrap_or(0.15))?;
    near("residual", plan.plan.finish.residual_area_mm2, case.residual_mm2, 0.001)?;
    // The plan survives its file, and is believed again from nothing but that.
    let bytes = plan_file::encode(&plan.plan).map_err(|error| error.to_string())?;
    let again = plan_file::decode(&bytes).map_err(|error| error.to_string())?;
    if again != plan.plan {
        return Err("the plan changed in its file".into());
    }
    again.certify().map(|_| ()).map_err(|error| error.to_string())
}

#[test]
fn every_case_of_ours() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut count = 0;
    let mut failures = Vec::new();
    for file in std::fs::read_dir(here.join("cases")).unwrap() {
        let text = std::fs::read_to_string(file.unwrap().path()).unwrap();
        for case in toml::from_str::<Cases>(&text).unwrap().case {
            count += 1;
            if let Err(reason) = check(&case) {
                failures.push(format!("{}: {reason}", case.drawing));
            }
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    assert!(count >= 25, "only {count} cases were found");
}
