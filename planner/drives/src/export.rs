//! The gains of a profile in the forms of other controllers.

use std::fmt::Write as _;

use crate::controllers::kind::Kind;
use crate::profile::DriveProfile;
use crate::tuning::parameter::Parameter;

/// The gains of a controller and their units, as a table for people.
#[must_use]
pub fn table(profile: &DriveProfile, kind: Kind) -> String {
    let mut text = format!("{}, {}, T = {} s\n", profile.name, kind.names().1, profile.period_s);
    for parameter in Parameter::of(kind) {
        let _ = writeln!(text, "{:<32} {}", parameter.name, parameter.value(&profile.gains));
    }
    text
}

/// The gains as HAL lines of LinuxCNC's `pid` component, with positions in mm and outputs in bits: `output =
/// Pgain·e + Igain·∫e·dt + Dgain·de/dt + FF1·v + FF2·a` (manual page pid(9)). `None` for a controller that this
/// component is not.
#[must_use]
pub fn linuxcnc(profile: &DriveProfile, kind: Kind) -> Option<String> {
    let per_mm = profile.pulses_per_mm;
    let gains = &profile.gains;
    let mut text = format!(
        "# {}: {} of {}. Positions in mm, outputs in bits. Run the thread of pid.*.do-pid-calcs every {} ns.\n",
        profile.name,
        kind.names().1,
        "keepout drives export",
        (profile.period_s * 1e9).round()
    );
    let pid = gains.pid;
    for (axis, drive) in ["x", "y"].into_iter().zip(profile.drives()) {
        let speed_gain = drive.gain / per_mm;
        let values = match kind {
            Kind::P => [gains.proportional * per_mm, 0.0, 0.0, 0.0, 0.0],
            Kind::Pid => {
                [pid.proportional * per_mm, pid.integral * per_mm, pid.derivative * per_mm, 0.0, 0.0]
            }
            Kind::DriveFeedforward => {
                [gains.proportional * per_mm, 0.0, 0.0, 1.0 / speed_gain, drive.time_constant_s / speed_gain]
            }
            _ => return None,
        };
        for (name, value) in ["Pgain", "Igain", "Dgain", "FF1", "FF2"].into_iter().zip(values) {
            let _ = writeln!(text, "setp pid.{axis}.{name} {value}");
        }
        if let Some(limit) = profile.limit_bits {
            let _ = writeln!(text, "setp pid.{axis}.maxoutput {limit}");
        }
    }
    Some(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// LinuxCNC's law with these lines gives the commands of our controller.
    #[test]
    fn linuxcnc_gains_give_the_same_commands() {
        let profile = DriveProfile::load("koren-lo-table-1").unwrap();
        let text = linuxcnc(&profile, Kind::Pid).unwrap();
        let gain = |name: &str| -> f64 {
            let line = text.lines().find(|line| line.starts_with(&format!("setp pid.x.{name} "))).unwrap();
            line.rsplit(' ').next().unwrap().parse().unwrap()
        };
        let mut law = crate::controllers::law::Law::new(profile.gains.pid, profile.period_s);
        let (mut sum, mut before) = (0.0, 0.0);
        for error_mm in [0.0, 0.1, 0.3, 0.2, -0.1] {
            // pid(9): in mm, with the period in s.
            sum += error_mm * profile.period_s;
            let output = gain("Pgain") * error_mm
                + gain("Igain") * sum
                + gain("Dgain") * (error_mm - before) / profile.period_s;
            before = error_mm;
            let ours = law.step(error_mm * profile.pulses_per_mm);
            assert!((output - ours).abs() < 1e-9, "{output} {ours}");
        }
    }

    #[test]
    fn other_controllers_have_no_linuxcnc_form() {
        let profile = DriveProfile::simulated().unwrap();
        let kinds: Vec<_> =
            Kind::ALL.into_iter().filter(|kind| linuxcnc(&profile, *kind).is_some()).collect();
        assert_eq!(kinds, [Kind::P, Kind::Pid, Kind::DriveFeedforward]);
        let text = linuxcnc(&profile, Kind::DriveFeedforward).unwrap();
        // 0.061 05 mm/s per bit: the steady command for a speed.
        assert!(text.contains("setp pid.y.FF1 16.3") && text.contains("maxoutput 8191"), "{text}");
        assert!(table(&profile, Kind::Ccc).contains("cross_coupling.proportional      0.5897"));
    }
}
