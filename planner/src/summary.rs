//! Text summary of a plan and of its proof.

use keepout_kernel::UNITS_PER_MM;
use keepout_kernel::offset::{COVERAGE, RESOLUTION};

use crate::Mm2;
use crate::finish::centre_distance;
use crate::plan::{CertifiedPlan, Cut, Pass};
use crate::profile::MachinedSide;
use crate::units::mm;

impl CertifiedPlan {
    /// Summary of the plan, line by line.
    #[must_use]
    pub fn summary(&self) -> String {
        let plan = &self.plan;
        let provenance = &plan.provenance;
        let side = match plan.side {
            MachinedSide::Outside => "outside (the part is inside the contour)",
            MachinedSide::Inside => "inside (the part is outside the contour)",
        };
        let mut lines = vec![
            format!(
                "drawing      {} ({} contours, unit {})",
                provenance.name,
                plan.profile.loops.len(),
                provenance.unit
            ),
            format!("machined     {side}"),
            format!("tool radius  {:.5} mm", mm(plan.tool_radius.units())),
            format!("stock        {:.5} mm to leave", mm(plan.stock_to_leave.units())),
            format!("margin for   {}", plan.machine.name),
            plan.budget.to_string(),
            format!(
                "jogging      the tool centre stays more than {:.5} mm from the part",
                mm(self.roughing.units())
            ),
            format!(
                "finishing    the tool centre stays more than {:.5} mm from the part",
                mm(self.finishing.units())
            ),
        ];
        if let Some((degrees, Mm2 { x, y })) = provenance.placed {
            lines.insert(
                1,
                format!("placed       turned by {degrees}° about its origin, then moved by ({x}, {y}) mm"),
            );
        }
        if !plan.zones.loops.is_empty() {
            lines.push(format!("zones        {} keep-out zones besides the part", plan.zones.loops.len()));
        }
        let sources = plan.profile.source_count();
        if sources > 0 {
            let chord_error = plan.profile.chord_error();
            lines.push(format!(
                "curves       {sources} pieces of splines and ellipses, within {:.5} mm of \
                 their arcs and lines",
                mm(chord_error.units())
            ));
        }
        let direction = match plan.cut {
            Cut::Conventional => "conventional (part on the left)",
            Cut::Climb => "climb (part on the right)",
        };
        lines.push(format!(
            "cut          {direction}, {} motions, every motion certified",
            self.certified_motions
        ));
        lines.extend(plan.passes.iter().enumerate().map(|(index, pass)| pass.summary(index + 1)));
        lines.extend(provenance.remarks.iter().map(|remark| format!("note         {}", remark.text)));
        lines.join("\n")
    }

    /// Claims that a successful [`crate::plan::Plan::certify`] proves, with their numbers, line by line.
    #[must_use]
    pub fn proved(&self) -> String {
        let plan = &self.plan;
        let sources = plan.profile.source_count() + plan.zones.source_count();
        let mut lines = vec![format!(
            "proved       the {} contours are closed, and no contour touches itself or another: \
             {} chords, checked against their arcs",
            plan.profile.loops.len(),
            self.part.edges().len()
        )];
        if sources > 0 {
            lines.push(format!(
                "proved       each of {sources} pieces of splines and ellipses follows its arcs and lines \
                 within {:.5} mm",
                mm(plan.profile.chord_error().max(plan.zones.chord_error()).units())
            ));
        }
        for (index, pass) in plan.passes.iter().enumerate() {
            let at_least = self.finishing.saturating_plus(pass.stock_to_leave);
            let threshold = mm(at_least.units());
            let motions: usize = pass.path.loops.iter().map(|each| each.curves.len()).sum();
            lines.push(format!(
                "proved       pass {}: no gouge: each of {motions} motions is farther from every chord than \
                 {threshold:.5} mm and the chord-error bound",
                index + 1
            ));
            lines.push(format!(
                "proved       pass {}: coverage: along all edges at {:.5} mm, where no other edge is nearer, \
                 the toolpath is within {:.4} mm; gaps are at most {:.3} mm. Contour without a toolpath \
                 beside it is rest material. Its amount is not proved",
                index + 1,
                centre_distance(&plan.profile, &plan.zones, at_least) / f64::from(UNITS_PER_MM),
                COVERAGE / f64::from(UNITS_PER_MM),
                RESOLUTION / f64::from(UNITS_PER_MM)
            ));
        }
        lines.join("\n")
    }
}

impl Pass {
    fn summary(&self, number: usize) -> String {
        let feed = self.feed_mm_min.map_or(String::new(), |feed| format!(", {feed} mm/min"));
        let path = &self.path;
        format!(
            "pass {number}       leaves {:.4} mm{feed}: {} loops, {:.1} mm; rest material {}",
            mm(self.stock_to_leave.units()),
            path.loops.len(),
            path.length_mm(),
            path.residual()
        )
    }
}
