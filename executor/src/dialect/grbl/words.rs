//! The words of a motion's target.
//!
//! Implements SR-17, SR-25.

use keepout_guard::Motion;
use keepout_kernel::Place;

use super::{Grbl, apart};
use crate::dialect::lines::{push_mm, push_number};
use crate::supervisor::EncodeError;

impl Grbl {
    /// The text of a motion, for a comparison with a log. Nothing sends it: [`Dialect::encode`] takes certified motions
    /// only.
    ///
    /// [`Dialect::encode`]: crate::dialect::Dialect::encode
    ///
    /// # Errors
    /// [`EncodeError`] as for a certified motion.
    pub(crate) fn motion_text(&self, motion: &Motion) -> Result<Vec<u8>, EncodeError> {
        let mut text = Vec::new();
        self.motion(motion, &mut text)?;
        Ok(text)
    }

    /// Adds the words of a target, with its height on a machine with three axes.
    pub(super) fn target(&self, to: Place, with_height: bool, out: &mut Vec<u8>) {
        words(out, &[(b'X', to.point.x.units()), (b'Y', to.point.y.units())]);
        if with_height && self.three() {
            words(out, &[(b'Z', to.height.units())]);
        }
    }

    /// Adds the line that switches the spindle.
    pub(super) fn spindle(&self, runs: bool, out: &mut Vec<u8>) -> Result<(), EncodeError> {
        let rpm = self.setting.spindle_rpm.ok_or(EncodeError::NoSpindle)?;
        out.extend(if runs { &b"M3S"[..] } else { b"M5" });
        if runs {
            push_number(out, u64::from(rpm));
        }
        out.push(b'\n');
        Ok(())
    }

    /// Whether the machine has three axes.
    pub(super) fn three(&self) -> bool {
        self.setting.z.is_some()
    }

    /// Converts to work coordinates. Fails until a report has carried the work offset.
    pub(super) fn work(&self, place: Place) -> Result<Place, EncodeError> {
        let offset = self.work_offset.ok_or(EncodeError::WorkOffsetUnknown)?;
        Ok(apart(self.setting.on_machine(place)?, offset)?)
    }
}

/// Adds words in mm, such as `X1.5Y-0.00001`.
pub(super) fn words(out: &mut Vec<u8>, values: &[(u8, i32)]) {
    for &(letter, units) in values {
        out.push(letter);
        push_mm(out, units);
    }
}
