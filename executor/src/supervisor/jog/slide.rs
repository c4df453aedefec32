//! Sliding: targets along a wall, at a small height above the jogging limit.
//!
//! The planner projects the jog velocity on the tangent of the wall, and the tool follows the wall. Along a
//! straight wall all targets lie on one line beside it. So the hull of the in-flight set is thin and clear,
//! however long it is.
//!
//! Along a curved wall of radius r, a chord of length L leaves the wall by its sagitta, L²/8r. The planner
//! keeps heights above the jogging limit below the stock to leave h, so a chord is at most √(8·r·h) long.
//! Along a concave wall, this bounds each jog. Along a convex wall, it bounds the whole in-flight set,
//! because the hull of the set must be clear. The set spans the look-ahead and the path until a target is
//! completed. The planner takes the feed at which the chord fits.

use keepout_guard::Admission;
use keepout_kernel::clip::{Wall, contact_band};
use keepout_kernel::{FreePoint, Vector};
use keepout_planner::Mm2;
use keepout_planner::units::{mm, vector_mm};

use super::search::{CREEP, Proposal, Push, SHORTEST_MM, Search, WallContact, length_mm, on_grid, vector};

/// Height of targets above the jogging limit, mm, because they are rounded to the grid.
const HEIGHT_MM: f64 = 0.01;
/// Greatest height along a curved wall when the stock to leave is less than this, mm.
const HIGHEST_MM: f64 = 0.05;
/// Greatest bend of a wall from its tangent, in heights. The sagitta of a chord is a quarter of the bend, so
/// the limit would be 4. It is lower, because times vary.
const BEND: f64 = 2.8;
/// Least length over which the planner measures the curve of a wall, mm.
const NEXT_MM: f64 = 3.0;
/// Greatest bend that comes from the chords of the wall alone, mm.
const ROUGH_MM: f64 = 0.01;
/// Heights above the tangent at which a place ahead is tried, as shares of its distance. A concave wall needs
/// them.
const LIFTS: [f64; 7] = [0.0, 0.015_625, 0.031_25, 0.0625, 0.125, 0.25, 0.5];
/// A tool that is low above the wall lands on it obliquely. Its height is then at most this share of the
/// motion along the wall (14°), and at most [`SHALLOW_MM`]. A higher tool approaches in the direction of the
/// push.
const SHALLOW: f64 = 0.25;
const SHALLOW_MM: f64 = 3.0;
/// Greatest number of halvings of a length until one is accepted.
const HALVINGS: u32 = 9;
/// Number of bisections between an accepted length and a rejected one.
const REFINEMENTS: u32 = 4;

/// A wall as the tool sees it.
struct Slope {
    /// Unit vector away from the wall.
    normal: Mm2,
    /// Unit vector along the wall, in the direction of the push.
    tangent: Mm2,
    /// Component of the push along the wall.
    along: f64,
    /// Component of the push into the wall.
    into: f64,
    /// Height of the tool above the limit, mm.
    height_mm: f64,
}

impl Slope {
    /// The slope of a wall that the tool meets after `gap_mm` under a push in this direction. `None` when the
    /// push does not lead into the wall.
    fn of(wall: &Wall, unit: Mm2, gap_mm: f64) -> Option<Self> {
        let normal = Mm2::from(wall.normal());
        let into = -unit.dot(normal);
        let beside = unit + normal * into;
        let along = beside.length();
        let tangent = beside / along.max(1e-9);
        (into > 0.0).then_some(Self { normal, tangent, along, into, height_mm: gap_mm * into })
    }

    fn offset(&self, along_mm: f64, height_mm: f64) -> Vector {
        vector(self.tangent * along_mm + self.normal * height_mm, 1.0)
    }
}

/// Speed, chord and height that fit the curve of a wall.
struct Fit {
    speed_mm_s: f64,
    /// The longest chord.
    chord_mm: f64,
    /// Height of targets above the jogging limit.
    height_mm: f64,
}

/// The longest accepted length up to `most_mm`, with the value that `will_do` returns for it. The search
/// assumes that `will_do` accepts every shorter length as well.
fn longest<T>(most_mm: f64, will_do: impl Fn(f64) -> Option<T>) -> Option<(f64, T)> {
    if let Some(all) = will_do(most_mm) {
        return Some((most_mm, all));
    }
    let halved = (1..=HALVINGS).map(|k| most_mm / f64::from(1_u32 << k));
    let mut best = halved.take_while(|&mm| mm >= SHORTEST_MM).find_map(|mm| Some((mm, will_do(mm)?)))?;
    let mut high = 2.0 * best.0;
    for _ in 0..REFINEMENTS {
        let middle = f64::midpoint(best.0, high);
        match will_do(middle) {
            Some(found) => best = (middle, found),
            None => high = middle,
        }
    }
    Some(best)
}

/// Share of a motion that leads in the direction of the push.
fn gained(push: &Push, way: Vector) -> f64 {
    vector_mm(way).dot(push.unit) / length_mm(way).max(1e-9)
}

/// The jog at the speed whose look-ahead distance is the path ahead with this jog. `None` when the jog is too
/// short for that speed.
fn limited<'a>(base: FreePoint, push: &Push, jog: Proposal<'a>) -> Option<Proposal<'a>> {
    let length_mm = length_mm(jog.admission.target().point.minus(base.point()));
    let speed_mm_s = push.look.speed_mm_s(push.ahead_mm + length_mm).min(jog.speed_mm_s);
    (length_mm >= push.look.least_mm(speed_mm_s)).then_some(Proposal { speed_mm_s, ..jog })
}

impl<'a> Search<'a> {
    /// The jog for a push that the part or the hull of the in-flight set blocks before its end.
    pub(super) fn slide(
        &self,
        base: FreePoint,
        push: &Push,
        input: Vector,
    ) -> (Option<Proposal<'a>>, WallContact) {
        let to = base.point().translated(input).unwrap_or(base.point());
        let contact = self.guard().part().clip(base, to);
        let gap_mm = length_mm(contact.point().minus(base.point()));
        let wall = self.guard().part().wall(contact, contact_band());
        let Some(slope) = wall.and_then(|wall| Slope::of(&wall, push.unit, gap_mm)) else {
            // The motion is clear, but its hull with the in-flight set is not.
            let target = self.prefix(base, input, SHORTEST_MM);
            let jog = target.and_then(|target| limited(base, push, push.jog(target, 1.0)));
            return (jog, WallContact::Unknown);
        };
        let length_mm = push.missing_mm(push.speed_mm_s * slope.along).max(SHORTEST_MM);
        let low_mm = (SHALLOW * length_mm).min(SHALLOW_MM).max(2.0 * self.highest_mm());
        let rests = slope.along < CREEP;
        if rests || slope.height_mm > low_mm {
            let way_mm = if rests { gap_mm } else { gap_mm - HEIGHT_MM / slope.into };
            let target = self.prefix(base, vector(push.unit, way_mm), SHORTEST_MM);
            return (target.map(|target| push.jog(target, 1.0)), WallContact::Wall);
        }
        (self.follow(base, &slope, push), WallContact::Wall)
    }

    /// The greatest height along a curved wall: the stock to leave, and at least [`HIGHEST_MM`].
    fn highest_mm(&self) -> f64 {
        let rules = self.guard().rules();
        (mm(rules.jogging_clearance.units()) - mm(rules.finishing_clearance.units())).max(HIGHEST_MM)
    }

    /// The longest admitted jog along a wall, no faster than the curve of the wall permits.
    fn follow(&self, base: FreePoint, slope: &Slope, push: &Push) -> Option<Proposal<'a>> {
        let wanted_mm_s = push.speed_mm_s * slope.along;
        let fit = self.fit(base, slope, push, wanted_mm_s);
        let least_mm = push.look.least_mm(fit.speed_mm_s);
        let missing_mm = push.missing_mm(fit.speed_mm_s);
        let slowed = fit.speed_mm_s < wanted_mm_s;
        // A tool that must slow down has more path ahead than the lower speed needs. It still needs a jog
        // along the curve.
        let length_mm = if slowed { missing_mm.max(least_mm) } else { missing_mm }.min(fit.chord_mm);
        if length_mm < least_mm {
            return None;
        }
        let target = |mm: f64| {
            let heights = [fit.height_mm, f64::midpoint(fit.height_mm, self.highest_mm()), self.highest_mm()];
            heights.into_iter().find_map(|height_mm| self.target(base, slope, push, (mm, height_mm)))
        };
        let (admitted_mm, target) = longest(length_mm, target)?;
        let gains = gained(push, target.target().point.minus(base.point()));
        let jog = push.jog(target, gains);
        let jog = Proposal { speed_mm_s: jog.speed_mm_s.min(fit.speed_mm_s), ..jog };
        if admitted_mm < missing_mm { limited(base, push, jog) } else { Some(jog) }
    }

    /// Speed, chord and height that fit the curve of the wall, up to the wanted speed. The curve is measured
    /// over the next jog, and is assumed to continue.
    fn fit(&self, base: FreePoint, slope: &Slope, push: &Push, wanted_mm_s: f64) -> Fit {
        let straight = Fit { speed_mm_s: wanted_mm_s, chord_mm: f64::INFINITY, height_mm: HEIGHT_MM };
        let next_mm = (2.0 * push.look.least_mm(wanted_mm_s)).max(NEXT_MM);
        let most_mm = BEND * self.highest_mm();
        let bend_mm = |mm: f64| self.foot(base, slope, mm).map(|(_, offset_mm)| offset_mm + slope.height_mm);
        let fits = |mm: f64| bend_mm(mm).filter(|bend_mm| bend_mm.abs() <= most_mm);
        let Some((mm, bend_mm)) = longest(next_mm, fits) else { return straight };
        // A bend grows with the square of the length.
        let seen_mm = (bend_mm.abs() - ROUGH_MM).max(0.0);
        let chord_mm = if mm < next_mm { mm } else { mm * (most_mm / seen_mm).sqrt() };
        if bend_mm >= 0.0 {
            let speed_mm_s = push.look.speed_of_steps_mm_s(chord_mm).min(wanted_mm_s);
            return Fit { speed_mm_s, chord_mm, ..straight };
        }
        let speed_mm_s = push.look.speed_of_set_mm_s(chord_mm).min(wanted_mm_s);
        let share = speed_mm_s / push.look.speed_of_set_mm_s(chord_mm);
        Fit { speed_mm_s, chord_mm, height_mm: (self.highest_mm() * share * share).max(HEIGHT_MM) }
    }

    /// The target at this distance along the wall and this height, if the guard admits it.
    fn target(
        &self,
        base: FreePoint,
        slope: &Slope,
        push: &Push,
        (length_mm, height_mm): (f64, f64),
    ) -> Option<Admission<'a>> {
        let (foot, _) = self.foot(base, slope, length_mm)?;
        let target = foot.point().translated(slope.offset(0.0, height_mm)).ok().and_then(on_grid)?;
        let gains = gained(push, target.minus(base.point())) > CREEP / 2.0;
        gains.then(|| self.admit(base, target))?
    }

    /// The place at the jogging limit at this distance along the tangent, and its height above the tool.
    /// `None` when the wall rises too steeply.
    fn foot(&self, base: FreePoint, slope: &Slope, length_mm: f64) -> Option<(FreePoint, f64)> {
        let part = self.guard().part();
        LIFTS.into_iter().find_map(|lift| {
            let above = base.point().translated(slope.offset(length_mm, lift * length_mm)).ok()?;
            let above = part.motion(base, above).ok()?;
            let depth_mm = (lift + 1.0) * length_mm + slope.height_mm;
            let below = above.point().translated(slope.offset(0.0, -depth_mm)).ok()?;
            let foot = part.clip(above, below);
            let way = foot.point().minus(base.point());
            Some((foot, vector_mm(way).dot(slope.normal)))
        })
    }
}
