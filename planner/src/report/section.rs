//! The section view of a plan with depths: a vertical cut through the part, with what a run removed.

use std::fmt::Write as _;

use keepout_kernel::Height;

use super::element::{Lines, line, path};
use super::view::{Mark, Sign, View, beside_another, draw_label, page};
use crate::contour::short;
use crate::depth::Relief;
use crate::plan::CertifiedPlan;
use crate::stock::{StockMap, count};
use crate::units::{mm, point_from_mm};
use crate::{Box2, Mm2, Mm3};

const PART: &str = "#b9c0ca";
const PART_EDGE: &str = "#2b2f36";
const STOCK: &str = "#f7e3cf";
const CLAMP: &str = "#6b7280";
const TABLE: &str = "#d9d2c5";
const PASS: &str = "#0072b2";
const SAFE: &str = "#009e73";
/// Columns of the picture.
const COLUMNS: usize = 1024;
/// Contours through whose middle a section is tried.
const TRIED: usize = 40;
/// Heights are drawn this many times longer: the largest that keeps the picture flat.
const STRETCHES: [f64; 5] = [20.0, 10.0, 5.0, 2.0, 1.0];
/// Greatest height of the picture, as a share of its width.
const FLAT: f64 = 0.35;

/// The heights of the part along a section.
struct Profile {
    /// The section is at this y.
    y_mm: f64,
    /// x of the first column, and distance of the columns.
    left_mm: f64,
    step_mm: f64,
    /// Height of what stands at each column. `None` where nothing stands.
    tops_mm: Vec<Option<f64>>,
}

impl Profile {
    fn of(plan: &CertifiedPlan, shown: Box2, y_mm: f64, columns: usize) -> Self {
        let step_mm = shown.size().x / count(columns);
        let left_mm = shown.low.x + step_mm / 2.0;
        let tops_mm = (0..columns).scan(left_mm, |x, _| {
            let at = std::mem::replace(x, *x + step_mm);
            let top = point_from_mm(Mm2::new(at, y_mm)).ok().and_then(|point| plan.top_at(point));
            Some(top.map(|top| mm(top.units())))
        });
        Self { y_mm, left_mm, step_mm, tops_mm: tops_mm.collect() }
    }

    /// Number of changes of height along the section.
    fn changes(&self) -> usize {
        self.tops_mm.windows(2).filter(|pair| pair[0] != pair[1]).count()
    }

    /// Runs of columns with the same height: from x to x.
    fn runs(heights_mm: &[Option<f64>], left_mm: f64, step_mm: f64) -> Vec<(f64, f64, f64)> {
        let mut runs: Vec<(f64, f64, f64)> = Vec::new();
        let mut x = left_mm - step_mm / 2.0;
        for &height in heights_mm {
            let end = x + step_mm;
            match (runs.last_mut(), height) {
                (Some(last), Some(height)) if last.1 >= x && last.2 == height => last.1 = end,
                (_, Some(height)) => runs.push((x, end, height)),
                (_, None) => {}
            }
            x = end;
        }
        runs
    }
}

/// The heights of the stock along the section that a way of the tool's end leaves, mm.
fn left_mm(profile: &Profile, radius_mm: f64, way: &[Mm3]) -> Vec<Option<f64>> {
    let columns = profile.tops_mm.len();
    let from = Mm2::new(profile.left_mm - profile.step_mm / 2.0, profile.y_mm);
    let mut stock = StockMap::line(from, profile.step_mm * count(columns), columns);
    for pair in way.windows(2) {
        stock.cut([pair[0], pair[1]], radius_mm);
    }
    stock.cells().map(|(_, height_mm)| Some(height_mm)).collect()
}

/// SVG of a vertical section along x, through the contour middle that shows the most. `way`: the consecutive places of
/// the tool's end in a run, mm. `None` for a plan for two axes.
#[must_use]
pub fn section_svg(plan: &CertifiedPlan, title: &str, way: &[Mm3]) -> Option<String> {
    let relief = plan.plan.relief.as_ref()?;
    let radius_mm = mm(plan.plan.tool_radius.units());
    let shown = plan.part_box().grown(3.0 * radius_mm + 2.0);
    let tried = plan.contours().iter().take(TRIED).map(|contour| contour.name.middle_mm.y);
    let y_mm = tried.max_by_key(|&y| Profile::of(plan, shown, y, COLUMNS / 4).changes())?;
    let profile = Profile::of(plan, shown, y_mm, COLUMNS);
    let heights = Heights::of(relief, shown.size().x);
    let view = View::of(Box2 {
        low: Mm2::new(shown.low.x, heights.shown(heights.low_mm)),
        high: Mm2::new(shown.high.x, heights.shown(heights.high_mm)),
    });
    let mut body = Lines::default();
    draw_stock(&mut body, &profile, &heights, &view, (radius_mm, way));
    draw_part(&mut body, &profile, &heights, &view);
    draw_heights(&mut body, plan, (shown, &heights), &view);
    let stretched = match heights.stretch {
        1.0 => String::new(),
        stretch => format!(", heights drawn {stretch:.0} times"),
    };
    let title = format!("{title}: section at y {} mm{stretched}", short(y_mm));
    Some(beside_another(&page(&view, &title, &legend(relief, way), &body)))
}

/// The heights of the picture.
struct Heights {
    bottom_mm: f64,
    floor_mm: f64,
    low_mm: f64,
    high_mm: f64,
    stretch: f64,
}

impl Heights {
    fn of(relief: &Relief, width_mm: f64) -> Self {
        let at = |height: Height| mm(height.units());
        let (floor_mm, safe_mm) = (at(relief.floor), at(relief.safe));
        let high_mm = safe_mm.max(at(relief.clamps)) + 1.0;
        let low_mm = floor_mm - (high_mm - floor_mm) * 0.08;
        let fits = |stretch: &f64| (high_mm - low_mm) * stretch <= FLAT * width_mm;
        let stretch = STRETCHES.into_iter().find(fits).unwrap_or(1.0);
        Self { bottom_mm: -mm(relief.thickness.units()), floor_mm, low_mm, high_mm, stretch }
    }

    fn shown(&self, height_mm: f64) -> f64 {
        height_mm * self.stretch
    }
}

/// SVG path of boxes that stand on a height.
fn boxes(runs: &[(f64, f64, f64)], bottom_mm: f64, heights: &Heights, view: &View) -> String {
    let mut path = String::new();
    for &(from, to, top) in runs.iter().filter(|run| run.2 > bottom_mm) {
        let (left, upper) = view.xy(Mm2::new(from, heights.shown(top)));
        let (right, lower) = view.xy(Mm2::new(to, heights.shown(bottom_mm)));
        let _ = write!(path, "M{left:.2} {upper:.2}H{right:.2}V{lower:.2}H{left:.2}Z");
    }
    path
}

/// Draws the stock, less what the run removed.
fn draw_stock(
    out: &mut Lines,
    profile: &Profile,
    heights: &Heights,
    view: &View,
    (radius_mm, way): (f64, &[Mm3]),
) {
    let left = left_mm(profile, radius_mm, way);
    let runs = Profile::runs(&left, profile.left_mm, profile.step_mm);
    out.draw(&[path(boxes(&runs, heights.bottom_mm, heights, view)).fill(STOCK)]);
    let table = [(profile.left_mm - 1e4, profile.left_mm + 1e4, heights.floor_mm)];
    out.draw(&[path(boxes(&table, heights.low_mm - 1e3, heights, view)).fill(TABLE)]);
}

fn draw_part(out: &mut Lines, profile: &Profile, heights: &Heights, view: &View) {
    let runs = Profile::runs(&profile.tops_mm, profile.left_mm, profile.step_mm);
    let (clamps, part): (Vec<_>, Vec<_>) = runs.into_iter().partition(|run| run.2 > 0.0);
    out.draw(&[
        path(boxes(&part, heights.bottom_mm, heights, view)).fill(PART).stroke(PART_EDGE, 0.8),
        path(boxes(&clamps, heights.floor_mm, heights, view)).fill(CLAMP).stroke(PART_EDGE, 0.8),
    ]);
}

/// Draws the depths of the passes, and the safe height.
fn draw_heights(out: &mut Lines, plan: &CertifiedPlan, (shown, heights): (Box2, &Heights), view: &View) {
    let Some(relief) = &plan.plan.relief else { return };
    let mut across = |height: Height, (colour, dashes): (&str, &str), right: bool| {
        let at_mm = mm(height.units());
        let place = |x: f64| view.xy(Mm2::new(x, heights.shown(at_mm)));
        let (from, to) = (place(shown.low.x), place(shown.high.x));
        out.draw(&[line(from, to, 2).outline(colour, 1).set("stroke-dasharray", dashes)]);
        let x = if right { to.0 - 26.0 } else { from.0 + 26.0 };
        draw_label(out, (x, from.1 - 4.0), &format!("z {}", short(at_mm)), colour);
    };
    across(relief.safe, (SAFE, "2 4"), false);
    // Labels on both sides in turn, because depths can lie close together.
    for (depth, walls) in plan.walls.iter().enumerate() {
        across(plan.plan.passes[walls.pass].height, (PASS, "7 3"), depth % 2 == 1);
    }
}

fn legend(relief: &Relief, way: &[Mm3]) -> Vec<Sign> {
    let stock = if way.len() > 1 { "stock that is left" } else { "stock" };
    let mut entries = vec![
        Sign::new(PART, Mark::Area, "the part"),
        Sign::new(STOCK, Mark::Area, stock),
        Sign::new(PASS, Mark::Dash, "depths of the passes"),
        Sign::new(SAFE, Mark::Dash, "safe height, at which the tool crosses"),
        Sign::new(TABLE, Mark::Area, format!("the tool stays above z {}", short(mm(relief.floor.units())))),
    ];
    if relief.clamps > Height::ZERO {
        let text = format!("keep-out zones, up to z {}", short(mm(relief.clamps.units())));
        entries.push(Sign::new(CLAMP, Mark::Area, text));
    }
    entries
}
