//! The heights of faces, as a job states them.

use keepout_kernel::{Height, Length};

use super::{DepthError, FaceChoice, FaceDepth, figure};
use crate::units::mm;

impl FaceDepth {
    /// Sets the tops of its faces.
    pub(super) fn apply(
        &self,
        tops: &mut [Option<Height>],
        numbers: &[usize],
        layers: &[std::sync::Arc<str>],
        thickness: Length,
    ) -> Result<(), DepthError> {
        let top = match self.depth_mm {
            None => None,
            Some(depth) => {
                let depth = figure("the depth of a face", depth, 0.0)?;
                if depth >= thickness {
                    let (value_mm, needed) = (mm(depth.units()), "less than --thickness-mm, or `through`");
                    return Err(DepthError::Figure { what: "the depth of a face", value_mm, needed });
                }
                Some(Height::ZERO.lowered(depth))
            }
        };
        let number = |index: usize| numbers.get(index).copied().unwrap_or(index + 1);
        let chosen = |index: usize| match &self.of {
            FaceChoice::Contour(wanted) => number(index) == *wanted,
            FaceChoice::Layer(wanted) => layers.get(index).is_some_and(|layer| **layer == **wanted),
        };
        let mut found = false;
        for (_, each) in tops.iter_mut().enumerate().filter(|(index, _)| chosen(*index)) {
            *each = top;
            found = true;
        }
        match &self.of {
            _ if found => Ok(()),
            FaceChoice::Contour(number) => Err(DepthError::NoContour { number: *number }),
            FaceChoice::Layer(layer) => Err(DepthError::NoLayer { layer: layer.clone() }),
        }
    }
}
