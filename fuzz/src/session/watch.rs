//! What is watched of a session: the guard's invariant, by other means than the guard's.

use keepout_executor::supervisor::guard::{Motion, MotionShape};
use keepout_executor::supervisor::{Command, Phase};
use keepout_kernel::curve::xy;
use keepout_kernel::{Curve, Point};
use keepout_proofs::properties::Xy;
use keepout_proofs::soak::{segments_within, triangle_within};
use keepout_proofs::square::{off_box, plain};

use super::Play;
use crate::{job, witness};

/// Rounding of places in `f64`, and of nearest points, lattice units.
const ROUNDING: f64 = 4.0;
/// Places looked at on a way out.
const PLACES: u32 = 16;

impl Play {
    /// Looks at what is said to the controller.
    pub(super) fn watch(&self, command: &Command, inside: bool) {
        let abilities = self.machine.abilities();
        match command {
            Command::Move(certified) => match certified.motion() {
                Motion::Jog { to, .. } if inside => self.watch_way_out(*to),
                Motion::Jog { .. } => self.watch_set(),
                Motion::Contour { curve, .. } => self.watch_contour(curve),
            },
            Command::Cancel => assert!(abilities.cancels, "it can not be stopped"),
            Command::Hold | Command::Continue => assert!(abilities.holds, "it can not be held"),
            _ => {}
        }
    }

    pub(super) fn is_near(&self, [a, b, c]: [Xy; 3], r: i64) -> bool {
        let corners = [a, b, c];
        self.walls.iter().any(|&(d, e)| {
            if b == c { segments_within(a, b, d, e, r) } else { triangle_within(corners, d, e, r) }
        })
    }

    /// All that may be executed is clear of the part: each triangle of it, or the whole box, by big integers over all edges.
    fn watch_set(&self) {
        let guard = self.supervisor.guard();
        let kept = i64::from(guard.rules().manual.units()) - 1;
        let mut set: Vec<Xy> = guard.in_flight().map(plain).collect();
        if guard.rules().shape == MotionShape::Box {
            set = corners(&set);
        }
        for (i, &a) in set.iter().enumerate() {
            for (j, &b) in set.iter().enumerate().skip(i) {
                for &c in &set[j..] {
                    let near = self.is_near([a, b, c], kept);
                    assert!(!near, "{a:?} {b:?} {c:?} of what may be executed come nearer than {kept}");
                }
            }
        }
    }

    /// A way out comes nearer to no edge within the threshold by hand, and goes along an axis where axes run apart.
    fn watch_way_out(&self, to: Point) {
        let guard = self.supervisor.guard();
        let from = guard.tail().expect("it stands inside").point();
        let straight = guard.rules().shape == MotionShape::Line || from.x == to.x || from.y == to.y;
        assert!(straight, "a way out from {from:?} to {to:?} is not along an axis");
        let (a, b, manual) = (xy(from), xy(to), f64::from(guard.rules().manual.units()));
        for wall in witness::walls(&job::work().plan) {
            let least = witness::distance(a, [wall].into_iter()).min(manual);
            for k in 1..=PLACES {
                let t = f64::from(k) / f64::from(PLACES);
                let place = (a.0 + (b.0 - a.0) * t, a.1 + (b.1 - a.1) * t);
                let left = witness::distance(place, [wall].into_iter());
                assert!(
                    left > least - ROUNDING,
                    "a way out from {from:?} to {to:?} comes to {left} of {wall:?}"
                );
            }
        }
    }

    fn watch_contour(&self, curve: &Curve) {
        let rules = self.supervisor.guard().rules();
        let kept = f64::from(rules.finishing.units()) - ROUNDING;
        let mut places = witness::places(curve);
        if rules.contours == MotionShape::Box {
            assert!(matches!(curve, Curve::Line(_)), "axes that run apart drive no arc");
            let (a, b) = (xy(curve.from()), xy(curve.to()));
            places.extend([a, b, (a.0, b.1), (b.0, a.1)]);
        }
        for place in places {
            let left = witness::distance(place, witness::walls(&job::work().plan));
            assert!(left > kept, "{curve:?} of a contour comes to {left}, not {kept}");
        }
    }

    /// The tool and the targets under way are in the hull of what the guard takes to be under way.
    pub(super) fn watch_hull(&self) {
        let guard = self.supervisor.guard();
        let by_hand = matches!(self.supervisor.phase(), Phase::Manual | Phase::Sliding | Phase::Escaping);
        let contour = self.machine.under_way().any(|motion| matches!(motion, Motion::Contour { .. }));
        if !by_hand || contour || guard.tail().is_none() {
            return;
        }
        let set: Vec<Xy> = guard.in_flight().map(plain).collect();
        let off = |place: Xy| match guard.rules().shape {
            MotionShape::Line => off_hull(&set, place),
            MotionShape::Box => exact(off_box(&set, place)),
        };
        let tool = off(self.machine.tool);
        let most = 3.0 * f64::from(guard.rules().resolution.units()) + ROUNDING;
        assert!(tool <= most, "the tool is {tool} off {set:?}, at {:?}", self.machine.tool);
        for motion in self.machine.under_way() {
            if let Motion::Jog { to, .. } = motion {
                assert!(off(plain(*to)) <= ROUNDING, "{to:?} is under way, and not in {set:?}");
            }
        }
    }
}

/// The corners of the smallest box around the points.
fn corners(points: &[Xy]) -> Vec<Xy> {
    let ends = |of: fn(&Xy) -> i64| points.iter().map(of).min().zip(points.iter().map(of).max());
    let (Some((x0, x1)), Some((y0, y1))) = (ends(|p| p.0), ends(|p| p.1)) else { return Vec::new() };
    vec![(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
}

/// How far the place is from the convex hull: none when it is in a triangle of the points.
fn off_hull(set: &[Xy], place: Xy) -> f64 {
    let wide = |p: Xy| (i128::from(p.0), i128::from(p.1));
    let side = |a: Xy, b: Xy| {
        let (a, b, p) = (wide(a), wide(b), wide(place));
        (b.0 - a.0) * (p.1 - a.1) - (b.1 - a.1) * (p.0 - a.0)
    };
    let mut least = f64::INFINITY;
    for (i, &a) in set.iter().enumerate() {
        for (j, &b) in set.iter().enumerate().skip(i) {
            let holds = |&c: &Xy| {
                let of = [side(a, b), side(b, c), side(c, a)];
                of.iter().all(|&s| s > 0) || of.iter().all(|&s| s < 0)
            };
            if set[j..].iter().any(holds) {
                return 0.0;
            }
            let real = |p: Xy| (exact(p.0), exact(p.1));
            least = least.min(witness::to_chord(real(place), (real(a), real(b))));
        }
    }
    least
}

#[expect(clippy::cast_precision_loss, reason = "coordinates have 30 bits")]
fn exact(c: i64) -> f64 {
    c as f64
}
