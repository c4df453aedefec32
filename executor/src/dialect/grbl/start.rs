//! The start of a session: who the controller is, its settings, what the session stores, and its modes.
//!
//! A line of which a digit changed on the way is also answered with `ok`. So all settings are read again after the
//! stores. Implements SR-17, SR-19.

use super::identity::Identity;
use super::settings::{Settings, StartupBlocks, Stated, Stores, not_stored};
use super::{Grbl, Stage};
use crate::supervisor::Reply;

impl Grbl {
    pub(super) fn identify(&mut self, out: &mut Vec<u8>) -> Option<Reply> {
        out.extend(b"$I\n");
        self.stage = Stage::Identifying(Identity::default());
        None
    }

    pub(super) fn identified(&mut self, identity: Identity, out: &mut Vec<u8>) -> Option<Reply> {
        match identity.check(self.hal) {
            Ok(()) => self.read(Settings::default(), out),
            Err(unfit) => Some(Reply::Unfit(unfit)),
        }
    }

    fn read(&mut self, settings: Settings, out: &mut Vec<u8>) -> Option<Reply> {
        out.extend(b"$$\n");
        self.stage = Stage::Reading(settings);
        None
    }

    /// Handles the end of `$$`.
    pub(super) fn has_read(&mut self, settings: Settings, out: &mut Vec<u8>) -> Option<Reply> {
        match settings.check(self.setting.steps_per_mm, self.setting.z.map(|z| z.steps_per_mm)) {
            Ok(()) => {
                out.extend(b"$N\n");
                self.stage = Stage::ReadingBlocks(settings, StartupBlocks::default());
                None
            }
            Err(unfit) => Some(Reply::Unfit(unfit)),
        }
    }

    /// Stores the settings that the session relies on, where the controller has other values. Then it reads all of
    /// them again.
    pub(super) fn set_up(
        &mut self,
        settings: &Settings,
        blocks: StartupBlocks,
        out: &mut Vec<u8>,
    ) -> Option<Reply> {
        let needed = blocks.needed().and_then(|startup| {
            self.startup = startup;
            settings.stores(self.hal, self.setting.arc_tolerance_mm)
        });
        match needed {
            Ok(Some(stores)) => self.store(stores, out),
            Ok(None) => {
                self.stage = Stage::Prepared;
                Some(Reply::Prepared(settings.limits()))
            }
            Err(unfit) => Some(Reply::Unfit(unfit)),
        }
    }

    /// Stores the next setting. GRBL loses bytes that arrive while it writes a setting, so each store waits for the
    /// answer to the previous one.
    pub(super) fn store(&mut self, mut stores: Stores, out: &mut Vec<u8>) -> Option<Reply> {
        let Some(line) = stores.take_next() else { return self.read(stores.to_compare_with(), out) };
        out.extend(line);
        self.stage = Stage::Storing(stores);
        None
    }

    /// Handles the end of the `$N` that follows a stored startup line.
    pub(super) fn has_block(&mut self, blocks: StartupBlocks, out: &mut Vec<u8>) -> Option<Reply> {
        match blocks.needed() {
            Ok(None) => {
                self.startup = None;
                self.arm(out);
                None
            }
            Ok(Some(_)) => Some(Reply::Unfit(not_stored("$N", None))),
            Err(unfit) => Some(Reply::Unfit(unfit)),
        }
    }

    /// Sets the modes of the session, and the feed override of another host back to 100 % (0x90). A change of work
    /// coordinates makes the next report carry their offset. The parameter list must agree with it.
    pub(super) fn arm(&mut self, out: &mut Vec<u8>) {
        // Scaling in grblHAL applies to every line, also to jogs, until a G50 cancels it.
        let scaling: &[u8] = if self.hal { b"G50" } else { b"" };
        out.extend([b"\x90G21G90G94G17G40G49G80", scaling, b"G55\nG54\n$#\n"].concat());
        self.work_offset = None;
        self.stated = Stated::default();
        self.stage = Stage::Arming(3);
    }
}
