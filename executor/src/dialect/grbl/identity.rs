//! The firmware's identity, from its answer to `$I`.
//!
//! Implements SR-19.

use crate::supervisor::Unfit;

/// The answer to `$I`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Identity {
    /// Whether it names grblHAL.
    hal: bool,
    /// Whether it states its options.
    options: bool,
    /// Whether the controller starts unlocked after power-on, before homing: letter `L` of its options.
    wakes_unlocked: bool,
}

impl Identity {
    /// Takes a line of the answer, without its brackets.
    pub(super) fn take(&mut self, line: &str) {
        let Some((name, value)) = line.split_once(':') else { return };
        match name {
            "OPT" => {
                self.options = true;
                self.wakes_unlocked |= value.split(',').next().is_some_and(|letters| letters.contains('L'));
            }
            "FIRMWARE" => self.hal |= value.eq_ignore_ascii_case("grblHAL"),
            _ => {}
        }
    }

    /// Checks that this dialect suits the firmware. A controller that starts unlocked after a power failure
    /// counts from its present place, and would execute a line that was still on its way from there.
    pub(super) fn check(self, hal: bool) -> Result<(), Unfit> {
        if self.hal && !hal {
            let needed = "the answer of GRBL 1.1. This controller is grblHAL: use --dialect grblhal";
            return Err(Unfit { name: "$I", value: f64::NAN, needed });
        }
        if !self.options {
            let needed = "answered with a line [OPT:...]: it states whether the controller locks after a \
                          power failure";
            return Err(Unfit { name: "$I", value: f64::NAN, needed });
        }
        if self.wakes_unlocked {
            let needed = "without the option L: after a power failure the controller must lock until it is \
                          homed. On grblHAL add 4 to $22 (mostly $22=5)";
            return Err(Unfit { name: "$I", value: f64::NAN, needed });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // Evidence for SR-19.
    #[test]
    fn controller_that_wakes_unlocked_or_is_another_is_refused() {
        let check = |lines: &[&str], hal| {
            let mut identity = Identity::default();
            lines.iter().for_each(|line| identity.take(line));
            identity.check(hal).is_ok()
        };
        assert!(check(&["VER:1.1h.20190830:mill", "OPT:V,15,128"], false));
        assert!(!check(&["VER:1.1h.20190830:mill"], false), "without its options");
        let hal = ["VER:1.1f.20260817:", "OPT:VNM,100,1024,3,0", "FIRMWARE:grblHAL"];
        assert!(check(&hal, true) && !check(&hal, false));
        assert!(!check(&["VER:1.1f.20260817:", "OPT:VNML,100,1024,3,0", "FIRMWARE:grblHAL"], true));
    }
}
