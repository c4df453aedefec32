//! Text summary of a plan and of its proof.

use keepout_kernel::offset::{COVERAGE, RESOLUTION};
use keepout_kernel::{Height, Side, UNITS_PER_MM};

use crate::Mm2;
use crate::contour::{profile_box, short};
use crate::depth::{EntryMove, Relief, around};
use crate::finish::centre_distance;
use crate::plan::{CertifiedPlan, Cut, Pass};
use crate::profile::MachinedSide;
use crate::select::ContourPolygon;
use crate::size::size;
use crate::units::mm;

/// Largest number of contours that the summary lists.
const LISTED: usize = 40;

impl CertifiedPlan {
    /// The solid side of the contours, in words.
    #[must_use]
    pub fn side_words(&self) -> &'static str {
        match self.plan.side {
            MachinedSide::Outside => "solid inside its outlines",
            MachinedSide::Inside => "solid around its pockets",
        }
    }

    /// Area of the part within its contours by the even-odd rule, mm². For a part around its contours this is the
    /// area of the pockets.
    #[must_use]
    pub fn enclosed_mm2(&self) -> f64 {
        let depths = self.part.region().depths();
        let signed = self.plan.profile.loops.iter().zip(depths).map(|(each, depth)| {
            let area_mm2 = ContourPolygon::of(each).area_mm2;
            if depth % 2 == 0 { area_mm2 } else { -area_mm2 }
        });
        signed.sum()
    }

    /// Text with the area that the contours enclose, or with the volume between their faces.
    fn enclosed(&self) -> String {
        let Some(relief) = &self.plan.relief else {
            return match self.plan.side {
                MachinedSide::Outside => format!("{:.3} mm² of material", self.enclosed_mm2()),
                MachinedSide::Inside => format!("pockets of {:.3} mm²", self.enclosed_mm2()),
            };
        };
        let (tops, side) = (&relief.tops, Side::from(self.plan.side));
        // Heights above the bottom of the part.
        let high_mm =
            |top: Option<Height>| top.map_or(0.0, |top| mm(top.units()) + mm(relief.thickness.units()));
        let contours = self.plan.profile.loops.iter().zip(tops).zip(self.part.region().parents());
        let parts_mm3 = contours.map(|((each, inside), parent)| {
            let outside = parent.map_or(around(side), |parent| tops[parent]);
            ContourPolygon::of(each).area_mm2 * (high_mm(*inside) - high_mm(outside))
        });
        let sum_mm3: f64 = parts_mm3.sum();
        match self.plan.side {
            MachinedSide::Outside => format!("{sum_mm3:.3} mm³ of material"),
            MachinedSide::Inside => format!("pockets of {:.3} mm³", -sum_mm3),
        }
    }

    /// Text with the rest material beside all walls: the length of contour, and the area of a plan for two axes, or
    /// the volume of a plan with depths.
    #[must_use]
    pub fn residual(&self) -> String {
        let Some(relief) = &self.plan.relief else { return self.plan.finish().residual() };
        let reaches = self.contours().iter().map(|contour| &contour.reach);
        let (left_mm, length_mm) =
            reaches.fold((0.0, 0.0), |(left, all), reach| (left + reach.left_mm, all + reach.length_mm));
        let mut above = Height::ZERO;
        let volumes = self.walls.iter().map(|walls| {
            let pass = &self.plan.passes[walls.pass];
            let height = pass.height.max(Height::ZERO.lowered(relief.thickness));
            let step_mm = mm(above.units()) - mm(height.units());
            above = height;
            Some(pass.path.residual_area_mm2? * step_mm)
        });
        let volume = volumes.sum::<Option<f64>>();
        let volume = volume.map_or("volume unknown".into(), |mm3| format!("{mm3:.3} mm³"));
        format!("{left_mm:.3} of {length_mm:.1} mm contour, {volume}")
    }

    /// Size of the profile along x and y, mm.
    #[must_use]
    pub fn profile_size_mm(&self) -> Mm2 {
        profile_box(&self.plan.profile, self.plan.provenance.turned_degrees()).size()
    }

    /// Summary of the plan, line by line. Warnings come first.
    #[must_use]
    pub fn summary(&self) -> String {
        let mut lines: Vec<String> =
            self.warnings().into_iter().map(|text| format!("WARNING      {text}")).collect();
        lines.extend(self.part_lines());
        lines.extend(self.clearance_lines());
        lines.extend(self.plan.relief.as_ref().map(height_lines).unwrap_or_default());
        lines.extend(self.path_lines());
        let remarks = &self.plan.provenance.remarks;
        lines.extend(remarks.iter().map(|remark| format!("note         {}", remark.text)));
        lines.join("\n")
    }

    fn part_lines(&self) -> Vec<String> {
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
            format!(
                "part         {} mm, {}: {}",
                size(self.profile_size_mm()),
                self.side_words(),
                self.enclosed()
            ),
            format!("machined     {side}"),
            format!("tool         Ø {} mm", short(2.0 * mm(plan.tool_radius.units()))),
        ];
        if let Some((degrees, Mm2 { x, y })) = provenance.placed {
            lines.push(format!(
                "placed       turned by {degrees}° about its origin, then moved by ({x}, {y}) mm"
            ));
        }
        if !plan.zones.loops.is_empty() {
            lines.push(format!("zones        {} keep-out zones besides the part", plan.zones.loops.len()));
        }
        lines
    }

    fn clearance_lines(&self) -> Vec<String> {
        let plan = &self.plan;
        let mut lines = vec![
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
        let sources = plan.profile.source_count();
        if sources > 0 {
            let chord_error = plan.profile.chord_error();
            lines.push(format!(
                "curves       {sources} pieces of splines and ellipses, within {:.5} mm of \
                 their arcs and lines",
                mm(chord_error.units())
            ));
        }
        lines
    }

    fn path_lines(&self) -> Vec<String> {
        let plan = &self.plan;
        let direction = match plan.cut {
            Cut::Conventional => "conventional (part on the left)",
            Cut::Climb => "climb (part on the right)",
        };
        let motions = self.certified_motions;
        let mut lines = vec![format!("cut          {direction}, {motions} motions, every motion certified")];
        let deep = plan.relief.is_some();
        lines.extend(plan.passes.iter().enumerate().map(|(index, pass)| pass.summary(index + 1, deep)));
        lines.push("contours     with the numbers of the pictures and of --recut:".into());
        let tops = plan.relief.as_ref().map_or(&[][..], |relief| &relief.tops);
        lines.extend(self.contours().iter().enumerate().take(LISTED).map(|(index, contour)| {
            let top = tops.get(index).copied().flatten().filter(|&top| top < Height::ZERO);
            let face = top.map_or(String::new(), |top| format!(", face at z {}", short(mm(top.units()))));
            format!("  {contour}{face}")
        }));
        if self.contours().len() > LISTED {
            lines.push(format!("  … and {} more", self.contours().len() - LISTED));
        }
        lines
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

/// The heights of a plan with depths.
fn height_lines(relief: &Relief) -> Vec<String> {
    let at = |height: Height| format!("z {}", short(mm(height.units())));
    let margin_mm = relief.budget.total().map_or(f64::NAN, |margin| mm(margin.units()));
    let entry = match relief.entry {
        EntryMove::Plunge => "straight down".into(),
        EntryMove::Ramp { slope } => {
            format!("on a ramp of {:.1}° along the contour", slope.atan().to_degrees())
        }
    };
    vec![
        format!(
            "heights      z 0 is the top of the part, {} mm thick; the tool crosses at {}, through cuts end at {}, \
             the table is at {}",
            short(mm(relief.thickness.units())),
            at(relief.safe),
            at(relief.deepest),
            at(relief.floor)
        ),
        format!("entry        {entry}, at most {} mm deeper at once", short(mm(relief.step_down.units()))),
        relief.budget.to_string(),
        format!("faces        stay {margin_mm:.3} mm above their depth: the height margin"),
    ]
}

impl Pass {
    fn summary(&self, number: usize, deep: bool) -> String {
        let feed = self.feed_mm_min.map_or(String::new(), |feed| format!(", {feed} mm/min"));
        let path = &self.path;
        let height = if deep { format!("z {:.3} mm, ", mm(self.height.units())) } else { String::new() };
        format!(
            "pass {number}       {height}leaves {:.4} mm{feed}: {} {}, {:.1} mm; rest material {}",
            mm(self.stock_to_leave.units()),
            path.loops.len(),
            if path.loops.len() == 1 { "loop" } else { "loops" },
            path.length_mm(),
            path.residual()
        )
    }
}
