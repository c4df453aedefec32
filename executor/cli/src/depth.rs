//! The third axis on the command line and in the job file.

use clap::Args;
use keepout_planner::depth::{DepthParameters, EntryMove, FaceChoice, FaceDepth};
use serde::Deserialize;

use super::CliError;
use super::values::length;

/// The third axis of a plan. Heights count from the top of the part, where z is 0. Without --thickness-mm, the plan
/// is for two axes.
#[derive(Clone, Debug, Default, Args, Deserialize)]
#[command(next_help_heading = "Depth (machines with three axes)")]
#[serde(deny_unknown_fields, default)]
pub struct DepthArguments {
    /// Thickness of the part, mm. Outlines and openings go through it.
    #[arg(long, value_name = "MM", value_parser = length)]
    pub thickness_mm: Option<f64>,
    /// Depth of the face just inside a contour: its number, and the depth in mm or `through`, such as 3=2.5. Can be
    /// repeated.
    #[arg(long, value_name = "N=MM", requires = "thickness_mm")]
    pub depth: Vec<String>,
    /// Depth of the faces just inside the contours of a layer, such as POCKET=2.5. Can be repeated; --depth counts
    /// more.
    #[arg(long, value_name = "LAYER=MM", requires = "thickness_mm")]
    pub layer_depth: Vec<String>,
    /// Greatest depth of one pass, mm. Without it: the radius of the tool.
    #[arg(long, value_name = "MM", value_parser = length, requires = "thickness_mm")]
    pub step_down_mm: Option<f64>,
    /// Depth of through cuts below the part, mm. Without it: 0.5.
    #[arg(long, value_name = "MM", value_parser = length, requires = "thickness_mm")]
    pub overcut_mm: Option<f64>,
    /// Height above the part at which the tool crosses, mm. Without it: 5.
    #[arg(long, value_name = "MM", value_parser = length, requires = "thickness_mm")]
    pub safe_height_mm: Option<f64>,
    /// Height of the keep-out zones above the top of the part, mm. Needed where there are zones.
    #[arg(long, value_name = "MM", value_parser = length, requires = "thickness_mm")]
    pub clamp_height_mm: Option<f64>,
    /// Depth of the table below the top of the part, mm: the tool stays above it. Without it: just below the overcut.
    #[arg(long, value_name = "MM", value_parser = length, requires = "thickness_mm")]
    pub table_mm: Option<f64>,
    /// How the tool enters the stock: `plunge`, for a tool that cuts at its centre, or the angle of a ramp along the
    /// contour in degrees. Without it: a ramp of 3.
    #[arg(long, value_name = "DEGREES|plunge", requires = "thickness_mm")]
    pub entry: Option<String>,
    /// Error of the tool's length, mm. Without it: 0.02.
    #[arg(long, value_name = "MM", value_parser = length, requires = "thickness_mm")]
    pub tool_length_error_mm: Option<f64>,
}

impl DepthArguments {
    /// These arguments, or those of the job file if these give no thickness.
    pub fn or(&self, file: &Self) -> Self {
        if self.thickness_mm.is_some() { self.clone() } else { file.clone() }
    }

    /// The heights. `None` for a plan for two axes.
    pub fn parameters(&self) -> Result<Option<DepthParameters>, CliError> {
        let Some(thickness_mm) = self.thickness_mm else { return Ok(None) };
        let usual = DepthParameters::of(thickness_mm);
        let of_layer = |text: &String| face(text, |name| Some(FaceChoice::Layer(name.into())));
        let of_contour = |text: &String| face(text, |name| name.parse().ok().map(FaceChoice::Contour));
        // A contour's own depth counts more than that of its layer.
        let layers = self.layer_depth.iter().map(of_layer);
        let faces = layers.chain(self.depth.iter().map(of_contour)).collect::<Result<_, _>>();
        Ok(Some(DepthParameters {
            faces: faces.map_err(CliError::Argument)?,
            step_down_mm: self.step_down_mm,
            overcut_mm: self.overcut_mm.unwrap_or(usual.overcut_mm),
            safe_mm: self.safe_height_mm.unwrap_or(usual.safe_mm),
            clamps_mm: self.clamp_height_mm,
            table_mm: self.table_mm,
            entry: self.entry.as_deref().map_or(Ok(usual.entry), entry).map_err(CliError::Argument)?,
            tool_length_error_mm: self.tool_length_error_mm.unwrap_or(usual.tool_length_error_mm),
            ..usual
        }))
    }
}

/// Parses a choice of contours, `=`, and a depth in mm or `through`.
fn face(text: &str, choice: impl Fn(&str) -> Option<FaceChoice>) -> Result<FaceDepth, String> {
    let wrong = || {
        format!(
            "\"{text}\" is not a depth: give the contour's number or the layer, and mm or `through`, such as 3=2.5"
        )
    };
    let (name, depth) = text.rsplit_once('=').ok_or_else(wrong)?;
    let of = choice(name).ok_or_else(wrong)?;
    let depth_mm = if depth == "through" { None } else { Some(length(depth).map_err(|_| wrong())?) };
    Ok(FaceDepth { of, depth_mm })
}

/// Parses how the tool enters the stock.
fn entry(text: &str) -> Result<EntryMove, String> {
    if text == "plunge" {
        return Ok(EntryMove::Plunge);
    }
    let degrees = text.parse::<f64>().ok().filter(|degrees| (0.1..=45.0).contains(degrees));
    let slope = degrees.map(|degrees| degrees.to_radians().tan().min(1.0));
    slope
        .map(|slope| EntryMove::Ramp { slope })
        .ok_or_else(|| format!("--entry \"{text}\" is not `plunge` or an angle of 0.1 to 45 degrees"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depths_have_the_stated_forms() {
        let text = |text: &str| vec![text.to_owned()];
        let arguments = |depth: &str, layer: &str, entry: &str| DepthArguments {
            thickness_mm: Some(6.0),
            depth: text(depth),
            layer_depth: text(layer),
            entry: Some(entry.into()),
            ..DepthArguments::default()
        };
        let made = arguments("3=2.5", "A=B=1/8in", "plunge").parameters().unwrap().unwrap();
        let layer = FaceDepth { of: FaceChoice::Layer("A=B".into()), depth_mm: Some(3.175) };
        let contour = FaceDepth { of: FaceChoice::Contour(3), depth_mm: Some(2.5) };
        assert_eq!((made.faces, made.entry), (vec![layer, contour], EntryMove::Plunge));
        for (depth, layer, entry) in [
            ("3", "A=1", "3"),
            ("-3=1", "A=1", "3"),
            ("3=deep", "A=1", "3"),
            ("3=1", "A", "3"),
            ("3=1", "A=1", "0"),
            ("3=1", "A=1", "steep"),
        ] {
            assert!(arguments(depth, layer, entry).parameters().is_err(), "{depth} {layer} {entry}");
        }
        assert!(DepthArguments::default().parameters().unwrap().is_none());
    }
}
