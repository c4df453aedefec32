//! Which firmware answers, by what it says to `$I`.

use crate::supervisor::Unfit;
use crate::supervisor::guard::OnCancel;

/// What `$I` said.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Identity {
    /// It is a build of GRBL 1.1h.
    grbl_1_1h: bool,
    /// It names another firmware.
    other: bool,
    hal: bool,
    /// It states that it does not lock after power-on until it is homed: letter `L` of its options.
    wakes_unlocked: bool,
}

impl Identity {
    /// Takes a line without its brackets.
    pub(super) fn take(&mut self, line: &str) {
        let Some((name, value)) = line.split_once(':') else { return };
        match name {
            "OPT" => {
                self.wakes_unlocked |= value.split(',').next().is_some_and(|letters| letters.contains('L'))
            }
            "VER" => self.grbl_1_1h |= value.starts_with("1.1h."),
            "FIRMWARE" => {
                self.other = true;
                self.hal |= value.eq_ignore_ascii_case("grblHAL");
            }
            _ => {}
        }
    }

    /// What a cancel does. GRBL 1.1h brakes along its planned path: its step pulses were recorded at cancels in all phases of
    /// queued jogs (`docs/safety/controllers.md`). grblHAL is never sent one: its fast hold leaves the path, and a hold that ends at
    /// the end of a block can run away. Other builds are not sent one either: they may be grblHAL without saying so.
    pub(super) fn on_cancel(self, hal: bool) -> OnCancel {
        if self.grbl_1_1h && !(self.other || hal) { OnCancel::KeepsPath } else { OnCancel::NotOffered }
    }

    /// Whether it can be used by the dialect: GRBL's does not expect that a cancel throws lines away. A controller that wakes
    /// unlocked after a power failure counts from where it stands, and would execute a line that was on its way from there.
    pub(super) fn check(self, hal: bool) -> Result<(), Unfit> {
        if self.hal && !hal {
            let needed = "that of GRBL 1.1. This controller says that it is grblHAL: use --dialect grblhal";
            return Err(Unfit { name: "$I", value: f64::NAN, needed });
        }
        if self.wakes_unlocked {
            let needed = "without the option L: after a power failure the controller must lock until it is homed. On grblHAL add 4 \
                          to $22 (mostly $22=5)";
            return Err(Unfit { name: "$I", value: f64::NAN, needed });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_grbl_1_1h_keeps_its_path() {
        let identity = |lines: &[&str]| {
            let mut identity = Identity::default();
            lines.iter().for_each(|line| identity.take(line));
            identity
        };
        let grbl = identity(&["VER:1.1h.20190830:mill", "OPT:V,15,128"]);
        assert_eq!((grbl.on_cancel(false), grbl.check(false)), (OnCancel::KeepsPath, Ok(())));
        for unknown in [
            &["VER:1.1f.20260817:"][..],
            &["VER:3.7 FluidNC v3.7.8:"],
            &["VER:1.1h.2026:", "FIRMWARE:x"],
            &[],
        ] {
            assert_eq!(identity(unknown).on_cancel(false), OnCancel::NotOffered, "{unknown:?}");
        }
        let hal = identity(&["VER:1.1f.20260817:", "FIRMWARE:grblHAL"]);
        assert!(hal.check(false).is_err() && hal.check(true).is_ok());
        assert_eq!(hal.on_cancel(true), OnCancel::NotOffered);
        let unlocked = identity(&["VER:1.1f.20260817:", "OPT:VNML,100,1024,3,0", "FIRMWARE:grblHAL"]);
        assert!(unlocked.check(true).is_err());
    }
}
