//! The heights of the depth passes, and the contours that each has to cut.

use keepout_kernel::{Height, Length, Levels, ProhibitedRegion};

use super::{DepthError, Relief};
use crate::profile::Profile;

/// A band of heights with the same prohibited region, and the depth passes in it.
#[derive(Clone, Debug)]
pub(crate) struct HeightBand {
    /// Heights of the passes, downward. The last one is at the bottom of the band.
    pub heights: Vec<Height>,
    /// Contours that bound the region, by index in the profile.
    pub contours: Vec<usize>,
}

impl Relief {
    /// The bands that the tool cuts, from the top of the part downward, with their depth passes.
    ///
    /// # Errors
    /// [`DepthError`] when the height margin is off the lattice.
    pub(crate) fn bands(
        &self,
        levels: &Levels,
        part: &ProhibitedRegion,
    ) -> Result<Vec<HeightBand>, DepthError> {
        let margin = self.budget.total()?;
        // The tip stays above each top by the margin. Tops of clamps above the part end no band of it.
        let tops = levels.tops().filter(|&top| top < Height::ZERO && top > self.floor);
        let faces = tops.map(|top| top.raised(margin)).filter(|&end| end < Height::ZERO);
        let mut bottoms: Vec<Height> = faces.filter(|&end| end > self.deepest).collect();
        bottoms.push(self.deepest);
        let (mut bands, mut begin) = (Vec::new(), Height::ZERO);
        for end in bottoms {
            let region = levels.at(end.lowered(margin));
            let contours = contours_of(region, part);
            if !contours.is_empty() {
                bands.push(HeightBand { heights: steps(begin, end, self.step_down), contours });
            }
            begin = end;
        }
        Ok(bands)
    }
}

/// Equal steps from `begin` down to `end`, each at most `most`.
fn steps(begin: Height, end: Height, most: Length) -> Vec<Height> {
    let depth = i64::from(begin.units()) - i64::from(end.units());
    let count = (depth + i64::from(most.units()) - 1).div_euclid(i64::from(most.units()).max(1)).max(1);
    let step = |k: i64| {
        let down = Length::from_units(depth * k / count).unwrap_or(Length::ZERO);
        begin.lowered(down)
    };
    (1..=count).map(step).collect()
}

/// The contours of the part that bound a region of its levels, by index. Copies of an outline share their
/// vertices.
fn contours_of(region: &ProhibitedRegion, part: &ProhibitedRegion) -> Vec<usize> {
    let bounds: Vec<_> = region.region().rings().iter().map(|ring| ring.vertices().as_ptr()).collect();
    let rings = part.region().rings().iter().enumerate();
    rings.filter(|(_, ring)| bounds.contains(&ring.vertices().as_ptr())).map(|(index, _)| index).collect()
}

/// The chosen contours of a profile.
pub(crate) fn chosen(profile: &Profile, contours: &[usize]) -> Profile {
    Profile { loops: contours.iter().filter_map(|&index| profile.loops.get(index).cloned()).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_end_at_the_bottom_and_are_no_deeper_than_the_step_down() {
        let height = |units| Height::from_units(units).unwrap();
        for (end, most, count) in [(-100, 100, 1), (-101, 100, 2), (-1000, 300, 4), (-7, 1000, 1)] {
            let heights = steps(Height::ZERO, height(end), Length::from_units(most).unwrap());
            assert_eq!(heights.len(), count);
            assert_eq!(heights.last(), Some(&height(end)));
            let mut before = 0;
            for each in heights {
                let step = before - i64::from(each.units());
                assert!(step > 0 && step <= most, "{end} {most}");
                before = each.units().into();
            }
        }
    }
}
