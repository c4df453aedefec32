//! Cases on our own drawings, as data: `cases/*.toml` and `drawings/*.dxf`.

use std::path::Path;

use keepout_planner::Mm2;
use keepout_planner::drawing::EntityFilter;
use keepout_planner::plan::PassParameters;
use keepout_planner::plan_file;
use keepout_planner::profile::MachinedSide;
use keepout_planner::request::PlanRequest;
use keepout_planner::select::{InkSide, Selection};
use keepout_tests::{area_mm2, order, plan_of};
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
    without: Vec<String>,
    #[serde(default)]
    units: Option<String>,
    #[serde(default)]
    join_mm: Option<f64>,
    #[serde(default)]
    curve_mm: Option<f64>,
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
    #[serde(default)]
    with: Vec<String>,
    #[serde(default)]
    line_types: Vec<String>,
    #[serde(default)]
    at: Vec<Mm2>,
    #[serde(default)]
    leave_out_open: bool,
    #[serde(default)]
    without_line_types: Vec<String>,
    #[serde(default)]
    scale: Option<f64>,
    #[serde(default)]
    stroke: Option<String>,
    #[serde(default)]
    min_area: Option<f64>,
    #[serde(default)]
    max_area: Option<f64>,
    #[serde(default)]
    rotate_deg: Option<f64>,
    #[serde(default)]
    offset_mm: Option<Mm2>,
    #[serde(default)]
    left_out: Option<String>,
    #[serde(default)]
    keep_out_layers: Vec<String>,
    #[serde(default)]
    travel_layer: Option<String>,
    #[serde(default)]
    passes: Vec<f64>,
    #[serde(default)]
    finish_length: Option<f64>,
    #[serde(default)]
    most_motions: Option<usize>,
}

impl Case {
    fn request(&self) -> Result<PlanRequest, String> {
        let mut wanted = order(self.tool.unwrap_or(3.0));
        wanted.job.side = match self.side.as_deref() {
            Some("inside") => MachinedSide::Inside,
            None | Some("outside") => MachinedSide::Outside,
            Some(other) => return Err(format!("no side {other}")),
        };
        wanted.choice = EntityFilter {
            layers: self.layers.clone(),
            without: self.without.clone(),
            unit: self.units.clone(),
            line_types: self.line_types.clone(),
            hatches: self.with.iter().any(|with| with == "hatch"),
            solids: self.with.iter().any(|with| with == "solid"),
            placed: self.offset_mm.map(|by| (self.rotate_deg.unwrap_or(0.0), by)),
            without_line_types: self.without_line_types.clone(),
            scale: self.scale,
            other_layers: Vec::new(),
        };
        wanted.selection = Selection {
            at: self.at.clone(),
            least_area_mm2: self.min_area,
            most_area_mm2: self.max_area,
            leave_out_open: self.leave_out_open,
            stroke: match self.stroke.as_deref() {
                Some("outer") => Some(InkSide::Outer),
                Some("inner") => Some(InkSide::Inner),
                Some("part") => Some(InkSide::Part),
                None => None,
                Some(other) => return Err(format!("no stroke {other}")),
            },
        };
        wanted.keep_out_layers.clone_from(&self.keep_out_layers);
        wanted.travel_layer.clone_from(&self.travel_layer);
        let pass = |&stock_to_leave_mm: &f64| PassParameters { stock_to_leave_mm, feed_mm_min: None };
        wanted.job.passes = self.passes.iter().map(pass).collect();
        wanted.join_mm = self.join_mm.unwrap_or(wanted.join_mm);
        wanted.curve_mm = self.curve_mm.unwrap_or(wanted.curve_mm);
        Ok(wanted)
    }
}

fn check(case: &Case) -> Result<(), String> {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    let wanted = case.request()?;
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
    same("finishing loops", plan.plan.finish().loops.len(), case.finish_loops)?;
    let repairs = plan.plan.provenance.remarks.iter().filter(|remark| remark.at.is_some()).count();
    same("repairs", repairs, case.repairs.or(Some(0)))?;
    if let Some(words) = &case.left_out
        && !plan.plan.provenance.remarks.iter().any(|remark| remark.text.contains(words.as_str()))
    {
        return Err(format!("no remark says \"{words}\": {:?}", plan.plan.provenance.remarks));
    }
    let near = |what: &str, found: f64, wanted: Option<f64>, tolerance: f64| match wanted {
        Some(wanted) if (wanted - found).abs() > tolerance => Err(format!("{what} {found}, {wanted} wanted")),
        _ => Ok(()),
    };
    near("length of the finishing path", plan.plan.finish().length_mm(), case.finish_length, 0.01)?;
    near("area", area_mm2(&plan), case.area, case.area_tolerance.unwrap_or(0.15))?;
    near("residual", plan.plan.finish().residual_area_mm2.unwrap_or(f64::NAN), case.residual_mm2, 0.001)?;
    if let Some(most) = case.most_motions.filter(|most| plan.certified_motions > *most) {
        return Err(format!("{} motions, {most} at most wanted", plan.certified_motions));
    }
    // The plan file gives the same plan, and the plan certifies again from the file alone.
    let bytes = plan_file::encode(&plan.plan).map_err(|error| error.to_string())?;
    let again = plan_file::decode(&bytes).map_err(|error| error.to_string())?;
    if again != plan.plan {
        return Err("the plan changed in its file".into());
    }
    again.certify().map(|_| ()).map_err(|error| error.to_string())
}

#[test]
fn every_case_gives_the_expected_plan_or_error() {
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
    assert!(count >= 75, "only {count} cases were found");
}
