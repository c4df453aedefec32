//! Sliding: targets along a wall, at a small height above the jogging limit.
//!
//! The jog velocity is projected on the tangent of the wall, and the tool follows the wall. Along a straight
//! wall all targets lie on one line beside it, so the hull of the in-flight set is thin and clear, however
//! long it is.
//!
//! Along a curved wall of radius r a chord of length L leaves the wall by its sagitta, L²/8r. Heights above
//! the jogging limit are kept below the stock to leave h, so a chord is no longer than √(8·r·h). Along a
//! concave wall that bounds each jog. Along a convex wall it bounds the whole in-flight set, because the hull
//! of the set must be clear: all that the tool covers in the look-ahead and until a target is completed. The
//! feed is the one at which the chord fits.

use keepout_guard::Admission;
use keepout_kernel::clip::{Wall, contact_band};
use keepout_kernel::{FreePoint, Vector};

use super::search::{CREEP, Contact, Proposal, Push, SHORTEST_MM, Search, length_mm, mm_of, on_grid, vector};

/// Height of targets above the jogging limit, mm: they are rounded to the grid.
const HEIGHT_MM: f64 = 0.01;
/// The greatest height along a curved wall, mm, where less stock is left than that.
const HIGHEST_MM: f64 = 0.05;
/// What a wall may bend away from its tangent, in heights: a chord of a circle has a quarter of that as
/// sagitta. A little less, because times vary.
const BEND: f64 = 2.8;
/// The curve of a wall is judged over no less than this, mm, and less bend than this is that of the chords it
/// is made of, mm.
const NEXT_MM: f64 = 3.0;
const ROUGH_MM: f64 = 0.01;
/// How far a place ahead is lifted off the tangent when the wall is concave, as shares of its distance.
const LIFTS: [f64; 7] = [0.0, 0.015_625, 0.031_25, 0.0625, 0.125, 0.25, 0.5];
/// A tool no higher above the wall than this share of its way along it (14°), and than this height, lands on
/// it aslant. A higher one approaches as it is pushed.
const SHALLOW: f64 = 0.25;
const SHALLOW_MM: f64 = 3.0;
/// How often a length is halved, and then searched between one that will do and one that will not.
const HALVINGS: u32 = 9;
const REFINEMENTS: u32 = 4;

/// A wall as the tool sees it.
struct Slope {
    /// Unit vector away from the wall.
    normal: (f64, f64),
    /// Unit vector along the wall, the way the tool is pushed.
    tangent: (f64, f64),
    /// Component of the push along the wall.
    along: f64,
    /// Component of the push into the wall.
    into: f64,
    /// Height of the tool above the limit, mm.
    height_mm: f64,
}

impl Slope {
    /// The slope of a wall that is met after `gap_mm` under a push in this direction; `None` when the push
    /// does not lead into it.
    fn of(wall: &Wall, (x, y): (f64, f64), gap_mm: f64) -> Option<Self> {
        let (nx, ny) = wall.normal();
        let into = -(x * nx + y * ny);
        let (tx, ty) = (x + into * nx, y + into * ny);
        let along = tx.hypot(ty);
        let length = along.max(1e-9);
        let tangent = (tx / length, ty / length);
        (into > 0.0).then_some(Self { normal: (nx, ny), tangent, along, into, height_mm: gap_mm * into })
    }

    fn offset(&self, along_mm: f64, height_mm: f64) -> Vector {
        let part = |t: f64, n: f64| t * along_mm + n * height_mm;
        vector((part(self.tangent.0, self.normal.0), part(self.tangent.1, self.normal.1)), 1.0)
    }
}

/// What fits the curve of a wall.
struct Fit {
    speed_mm_s: f64,
    /// The longest chord.
    chord_mm: f64,
    /// Height of targets above the jogging limit.
    height_mm: f64,
}

/// The longest length up to `most_mm` that will do, with what it gives; all below one that will do are taken
/// to do.
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

/// Share of a way that leads where the push does.
fn gained(push: &Push, way: Vector) -> f64 {
    (mm_of(way.dx) * push.unit.0 + mm_of(way.dy) * push.unit.1) / length_mm(way).max(1e-9)
}

/// The jog at the speed for which what is then ahead is the look-ahead; `None` when it is too short for that
/// speed.
fn limited<'a>(base: FreePoint, push: &Push, jog: Proposal<'a>) -> Option<Proposal<'a>> {
    let length_mm = length_mm(jog.admission.target().minus(base.point()));
    let speed_mm_s = push.look.speed_mm_s(push.ahead_mm + length_mm).min(jog.speed_mm_s);
    (length_mm >= push.look.least_mm(speed_mm_s)).then_some(Proposal { speed_mm_s, ..jog })
}

impl<'a> Search<'a> {
    /// The jog for a push that meets the part or the hull before its end.
    pub(super) fn slide(
        &self,
        base: FreePoint,
        push: &Push,
        input: Vector,
    ) -> (Option<Proposal<'a>>, Contact) {
        let to = base.point().translated(input).unwrap_or(base.point());
        let contact = self.guard().part().clip(base, to);
        let gap_mm = length_mm(contact.point().minus(base.point()));
        let wall = self.guard().part().wall(contact, contact_band());
        let Some(slope) = wall.and_then(|wall| Slope::of(&wall, push.unit, gap_mm)) else {
            // The way is clear, and the in-flight set is in the way.
            let target = self.prefix(base, input, SHORTEST_MM);
            return (target.and_then(|target| limited(base, push, push.jog(target, 1.0))), Contact::Unknown);
        };
        let length_mm = push.missing_mm(push.speed_mm_s * slope.along).max(SHORTEST_MM);
        let low_mm = (SHALLOW * length_mm).min(SHALLOW_MM).max(2.0 * self.highest_mm());
        let rests = slope.along < CREEP;
        if rests || slope.height_mm > low_mm {
            let way_mm = if rests { gap_mm } else { gap_mm - HEIGHT_MM / slope.into };
            let target = self.prefix(base, vector(push.unit, way_mm), SHORTEST_MM);
            return (target.map(|target| push.jog(target, 1.0)), Contact::Wall);
        }
        (self.follow(base, &slope, push), Contact::Wall)
    }

    /// The greatest height along a curved wall: the stock to leave.
    fn highest_mm(&self) -> f64 {
        let rules = self.guard().rules();
        (mm_of(rules.jogging_clearance.units()) - mm_of(rules.finishing_clearance.units())).max(HIGHEST_MM)
    }

    /// The jog along a wall, no faster than its curve lets it be; as long as the guard admits.
    fn follow(&self, base: FreePoint, slope: &Slope, push: &Push) -> Option<Proposal<'a>> {
        let wanted_mm_s = push.speed_mm_s * slope.along;
        let fit = self.fit(base, slope, push, wanted_mm_s);
        let least_mm = push.look.least_mm(fit.speed_mm_s);
        let missing_mm = push.missing_mm(fit.speed_mm_s);
        let slowed = fit.speed_mm_s < wanted_mm_s;
        // A tool that is to slow down has more ahead of it than the lower speed needs: the curve must still
        // go on.
        let length_mm = if slowed { missing_mm.max(least_mm) } else { missing_mm }.min(fit.chord_mm);
        if length_mm < least_mm {
            return None;
        }
        let target = |mm: f64| {
            let heights = [fit.height_mm, f64::midpoint(fit.height_mm, self.highest_mm()), self.highest_mm()];
            heights.into_iter().find_map(|height_mm| self.target(base, slope, push, (mm, height_mm)))
        };
        let (admitted_mm, target) = longest(length_mm, target)?;
        let gains = gained(push, target.target().minus(base.point()));
        let jog = push.jog(target, gains);
        let jog = Proposal { speed_mm_s: jog.speed_mm_s.min(fit.speed_mm_s), ..jog };
        if admitted_mm < missing_mm { limited(base, push, jog) } else { Some(jog) }
    }

    /// What fits the curve of the wall up to the wanted speed. The curve is that of the next jog, and is
    /// taken to go on.
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

    /// The target at this distance along the wall and this height, when it is admitted.
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

    /// The place at the jogging limit at this distance along the tangent, and how far it is above the tool's
    /// height; `None` when the wall rises too steeply.
    fn foot(&self, base: FreePoint, slope: &Slope, length_mm: f64) -> Option<(FreePoint, f64)> {
        let part = self.guard().part();
        LIFTS.into_iter().find_map(|lift| {
            let above = base.point().translated(slope.offset(length_mm, lift * length_mm)).ok()?;
            let above = part.motion(base, above).ok()?;
            let depth_mm = (lift + 1.0) * length_mm + slope.height_mm;
            let below = above.point().translated(slope.offset(0.0, -depth_mm)).ok()?;
            let foot = part.clip(above, below);
            let way = foot.point().minus(base.point());
            Some((foot, mm_of(way.dx) * slope.normal.0 + mm_of(way.dy) * slope.normal.1))
        })
    }
}
