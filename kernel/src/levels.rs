//! TRUSTED. Levels: the part as a height field, and its prohibited region at each height of the tool.
//!
//! Implements SR-06.
//!
//! The tool is a cylinder from its tip upward. What is above the tool's cutting length, such as the shank and
//! the holder, is outside this claim, and so is what lies above the machine's travel.
//!
//! The outlines of a height field divide the plane into faces, each with a top. A tool whose tip is at height
//! z touches only faces with a top above z. So the prohibited region K(z) is the union of those faces and of
//! the keep-out zones with a top above z. It changes only at a top: a *level* is K(z) below one top.
//!
//! **Theorem.** K(z) contains K(z') for every z' ≥ z, because a top above z' is above z. Take a shape outside
//! K(z) and farther from its outline than a threshold. It is outside K(z'). A straight line from a point of
//! the shape to a point of K(z') begins outside K(z) and ends in it, so it crosses the outline of K(z). So the
//! shape is farther from K(z') than the threshold, too. What is clear at z is clear at every z' ≥ z, and a
//! tool may always rise (`levels_are_monotone`).
//!
//! **The outlines of K(z).** Every outline lies between two faces: the face just inside it, and the face around
//! it. K(z) is bounded by those outlines that have a face of K(z) on exactly one side. From a point, walk out
//! through all outlines around it. K(z) is entered or left at exactly these outlines. So the point is in K(z)
//! exactly when an odd number of them is around it, or an even number if the outermost face is in K(z).

use alloc::sync::Arc;
use alloc::vec::Vec;
use core::fmt;

use crate::clear::{ProhibitedRegion, Side};
use crate::exact::lattice::{Height, Length};
use crate::exact::region::Region;
use crate::exact::ring::Ring;
use crate::index::IndexFault;

/// A part as faces with tops.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HeightField {
    /// The outlines of the faces.
    pub outlines: Region,
    /// The top of the face just inside each outline. `None` where nothing stands: a through hole.
    pub tops: Vec<Option<Height>>,
    /// The top of the face around all outlines. `None` where nothing stands.
    pub around: Option<Height>,
    /// Keep-out zones with their tops: clamps, a vice. They may overlap the faces and each other.
    pub zones: Vec<(Ring, Height)>,
    /// The height of the table. Everything below it is prohibited.
    pub floor: Option<Height>,
}

/// Why a height field has no levels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LevelsError {
    /// The number of tops is not the number of outlines.
    Tops {
        /// The number of tops.
        count: usize,
    },
    /// A top is the lowest height of the lattice, so no height is below it.
    Lowest,
    /// More than 65,534 different tops.
    TooMany,
    /// A level has no index.
    Index(IndexFault),
}

impl fmt::Display for LevelsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Tops { count } => write!(f, "{count} tops do not fit the number of outlines"),
            Self::Lowest => write!(f, "a top is at the lowest height of the lattice: {}", Height::LOWEST),
            Self::TooMany => write!(f, "the part has more than 65,534 different heights"),
            Self::Index(fault) => fault.fmt(f),
        }
    }
}

impl core::error::Error for LevelsError {}

impl From<IndexFault> for LevelsError {
    fn from(fault: IndexFault) -> Self {
        Self::Index(fault)
    }
}

/// K(z) for tips below a top, down to the top of the next level.
#[derive(Clone, Debug)]
struct Level {
    top: Height,
    prohibited: Arc<ProhibitedRegion>,
}

/// The prohibited region at each height of the tool's tip.
#[derive(Clone, Debug)]
pub struct Levels {
    /// K(z) at and above the highest top: nothing is prohibited there, unless the part has no tops.
    highest: Arc<ProhibitedRegion>,
    /// From the highest top to the lowest.
    below: Vec<Level>,
}

impl Levels {
    /// A part without tops: the same region at every height, as on a machine with two axes.
    #[must_use]
    pub fn flat(prohibited: Arc<ProhibitedRegion>) -> Self {
        Self { highest: prohibited, below: Vec::new() }
    }

    /// The levels of a height field. Copies of an outline share its vertices.
    ///
    /// # Errors
    /// [`LevelsError`] with the reason.
    pub fn new(field: &HeightField) -> Result<Self, LevelsError> {
        let HeightField { outlines, tops, around, zones, floor } = field;
        if tops.len() != outlines.rings().len() {
            return Err(LevelsError::Tops { count: tops.len() });
        }
        let parents = outlines.parents();
        let inside = |outline: usize| tops.get(outline).copied().flatten();
        let outside = |outline: usize| match parents.get(outline).copied().flatten() {
            Some(parent) => inside(parent),
            None => *around,
        };
        let all = tops.iter().copied().flatten().chain(*around).chain(zones.iter().map(|(_, top)| *top));
        let above_floor = |top: &Height| floor.is_none_or(|floor| *top > floor);
        let mut heights: Vec<Height> = all.filter(above_floor).chain(*floor).collect();
        heights.sort_unstable_by(|one, other| other.cmp(one));
        heights.dedup();
        if heights.last() == Some(&Height::LOWEST) {
            return Err(LevelsError::Lowest);
        }
        let mut below = Vec::with_capacity(heights.len());
        for (number, top) in (1..u16::MAX).zip(heights.iter().copied()) {
            let prohibited = if *floor == Some(top) {
                ProhibitedRegion::new(Region::empty(), Side::Inside)?
            } else {
                let stands = |face: Option<Height>| face.is_some_and(|face| face >= top);
                let bounds = |outline: usize| stands(inside(outline)) != stands(outside(outline));
                let side = if stands(*around) { Side::Inside } else { Side::Outside };
                let standing = zones.iter().filter(|(_, zone)| *zone >= top).map(|(ring, _)| ring.clone());
                ProhibitedRegion::with_zones(outlines.of_some(bounds), side, standing.collect())?
            };
            below.push(Level { top, prohibited: Arc::new(prohibited.numbered(number)) });
        }
        if below.len() < heights.len() {
            return Err(LevelsError::TooMany);
        }
        let highest = Arc::new(ProhibitedRegion::new(Region::empty(), Side::Outside)?);
        Ok(Self { highest, below })
    }

    /// K(z) for a tip at height `tip`: the lowest level with a top above it. A tip at the height of a top
    /// touches that top, but is not below it.
    #[must_use]
    pub fn at(&self, tip: Height) -> &Arc<ProhibitedRegion> {
        let reached = self.below.iter().take_while(|level| level.top > tip).last();
        reached.map_or(&self.highest, |level| &level.prohibited)
    }

    /// The tops, from the highest to the lowest.
    pub fn tops(&self) -> impl Iterator<Item = Height> + '_ {
        self.below.iter().map(|level| level.top)
    }

    /// K(z) above all tops, then below each top in turn.
    pub fn regions(&self) -> impl Iterator<Item = &Arc<ProhibitedRegion>> + '_ {
        core::iter::once(&self.highest).chain(self.below.iter().map(|level| &level.prohibited))
    }

    /// The lowest level: everything that is prohibited at some height.
    #[must_use]
    pub fn lowest(&self) -> &Arc<ProhibitedRegion> {
        self.at(Height::LOWEST)
    }

    /// The same levels, each prepared for the thresholds ([`ProhibitedRegion::prepare`]). Answers stay the
    /// same.
    #[must_use]
    pub fn prepared(&self, thresholds: &[Length]) -> Self {
        let of = |prohibited: &Arc<ProhibitedRegion>| {
            let mut prohibited = ProhibitedRegion::clone(prohibited);
            for &threshold in thresholds {
                // Cells only speed up the queries. For a part too large for cells, the queries use its index.
                let _ = prohibited.prepare(threshold);
            }
            Arc::new(prohibited)
        };
        let below =
            self.below.iter().map(|level| Level { top: level.top, prohibited: of(&level.prohibited) });
        Self { highest: of(&self.highest), below: below.collect() }
    }

    /// The same levels with simplified outlines ([`ProhibitedRegion::simplified`]).
    ///
    /// # Errors
    /// [`IndexFault::TooManyEdges`] above 2^30 edges.
    pub fn simplified(&self, tolerance: Length) -> Result<Self, IndexFault> {
        let below = self.below.iter().map(|Level { top, prohibited }| {
            Ok(Level { top: *top, prohibited: Arc::new(prohibited.simplified(tolerance)?) })
        });
        let below = below.collect::<Result<_, IndexFault>>()?;
        Ok(Self { highest: Arc::new(self.highest.simplified(tolerance)?), below })
    }
}

#[cfg(test)]
mod tests {
    use alloc::vec;

    use super::*;
    use crate::clear::Blocked;
    use crate::exact::lattice::Point;

    fn square(low: i64, high: i64) -> Ring {
        let at = |x, y| Point::from_units(x, y).unwrap();
        Ring::new(vec![at(low, low), at(high, low), at(high, high), at(low, high)]).unwrap()
    }

    fn height(units: i64) -> Height {
        Height::from_units(units).unwrap()
    }

    /// A plate with a pocket 50 deep, an island in it, a clamp, and a table at −80.
    fn plate() -> HeightField {
        HeightField {
            outlines: Region::new(vec![square(0, 1000), square(200, 800), square(400, 600)]).unwrap(),
            tops: vec![Some(height(0)), Some(height(-50)), Some(height(-20))],
            around: None,
            zones: vec![(square(-100, 50), height(30))],
            floor: Some(height(-80)),
        }
    }

    #[test]
    fn region_grows_as_the_tip_falls() {
        let levels = Levels::new(&plate()).unwrap();
        assert_eq!(levels.tops().map(Height::units).collect::<Vec<_>>(), [30, 0, -20, -50, -80]);
        let held = |tip: i64, c: i64| levels.at(height(tip)).holds(Point::from_units(c, c).unwrap());
        for (tip, of) in [
            (30, [false; 5]),
            (29, [true, false, false, false, false]),
            (0, [true, false, false, false, false]),
            (-1, [true, true, false, false, false]),
            (-20, [true, true, false, false, false]),
            (-21, [true, true, false, true, false]),
            (-50, [true, true, false, true, false]),
            (-51, [true, true, true, true, false]),
            (-80, [true, true, true, true, false]),
            (-81, [true; 5]),
        ] {
            assert_eq!([-50, 100, 300, 500, 2000].map(|c| held(tip, c)), of, "{tip}");
        }
    }

    #[test]
    fn certificate_of_a_level_holds_above_it_and_not_below() {
        let levels = Levels::new(&plate()).unwrap();
        let (pocket, threshold) = (Point::from_units(300, 300).unwrap(), Length::small(90));
        let above = levels.at(height(0)).free_point(pocket, threshold).unwrap();
        let deep = levels.at(height(-50)).free_point(pocket, threshold).unwrap();
        let aside = Point::from_units(301, 300).unwrap();
        assert!(levels.at(height(0)).motion(deep, aside).is_ok());
        assert_eq!(levels.at(height(-50)).motion(above, aside), Err(Blocked::StartTooNear(pocket)));
        let floor = levels.at(height(-51)).free_point(pocket, threshold);
        assert_eq!(floor, Err(Blocked::OnPartSide(pocket)));
        let far = Point::from_units(5000, 5000).unwrap();
        assert_eq!(levels.lowest().free_point(far, threshold), Err(Blocked::OnPartSide(far)));
    }

    #[test]
    fn flat_part_is_the_same_at_every_height() {
        let region = Region::new(vec![square(0, 1000)]).unwrap();
        let part = Arc::new(ProhibitedRegion::new(region, Side::Outside).unwrap());
        let levels = Levels::flat(Arc::clone(&part));
        for tip in [Height::LOWEST, Height::ZERO, Height::HIGHEST] {
            assert!(Arc::ptr_eq(levels.at(tip), &part));
        }
        assert_eq!(levels.tops().count(), 0);
    }

    #[test]
    fn faults_are_named() {
        let error = |field: HeightField| Levels::new(&field).err();
        assert_eq!(error(HeightField { tops: vec![], ..plate() }), Some(LevelsError::Tops { count: 0 }));
        let lowest = HeightField { around: Some(Height::LOWEST), floor: None, ..plate() };
        assert_eq!(error(lowest), Some(LevelsError::Lowest));
    }
}
