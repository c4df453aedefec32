//! The controller's configuration: its settings, its startup lines, and its work coordinates.
//!
//! Implements SR-19.

use std::hash::{DefaultHasher, Hash, Hasher};

use keepout_kernel::curve::nearest_unit;
use keepout_kernel::{Height, Place, Point};

use super::super::lines::place;
use crate::supervisor::{Limits, Unfit};

/// The offsets that make up the work offset, as the parameter list states them. They confirm the reported
/// offset: a damaged report would send a contour elsewhere.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Stated {
    g54: Option<Place>,
    g92: Option<Place>,
    /// The rotation of G54, degrees, rounded to 0.01. Only builds of grblHAL that can rotate state one.
    turned_deg: Option<f64>,
}

impl Stated {
    pub(super) fn take(&mut self, line: &str, three: bool) {
        let Some((name, value)) = line.split_once(':') else { return };
        let offset = place(value, three);
        match name {
            "G54" => {
                self.g54 = offset;
                self.turned_deg =
                    value.split_once(':').map(|(_, degrees)| degrees.trim().parse().unwrap_or(f64::NAN));
            }
            "G92" => self.g92 = offset,
            _ => {}
        }
    }

    /// Refuses a controller that can turn work coordinates: it does not state a rotation below 0.005°, which moves
    /// the far end of a contour by more than the margin.
    pub(super) fn check(&self) -> Result<(), Unfit> {
        let needed = "no rotation of work coordinates at all: the controller states its angle to 0.01° only. \
                      Use a build of grblHAL without ROTATION_ENABLE";
        self.turned_deg.map_or(Ok(()), |value| Err(Unfit { name: "G54 rotation", value, needed }))
    }

    pub(super) fn sum(&self) -> Option<Place> {
        let (a, b) = (self.g54?, self.g92?);
        let height = Height::from_units(i64::from(a.height.units()) + i64::from(b.height.units())).ok()?;
        Some(a.point.translated(b.point.minus(Point::ORIGIN)).ok()?.at_height(height))
    }
}

/// The startup lines, which the controller runs after each reset. One of them must cancel the motion mode: a
/// reset can swallow the beginning of a jog line, and the controller would run the remaining axis words as a
/// rapid motion in work coordinates. Apart from that, no startup line may change the meaning of later lines
/// or start a motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct StartupBlocks {
    /// Whether the controller stated each line.
    stated: [bool; 2],
    /// Whether each line is stated and empty.
    free: [bool; 2],
    /// Whether the controller stated a further line that is not empty.
    more: bool,
    cancels_motion: bool,
    /// Whether each line has a word that is not [harmless](HARMLESS).
    harms: [bool; 2],
}

/// Words that set modes which the controller has after a reset anyway, so later motion lines keep their
/// meaning. Only G80 among them affects the motion mode, so their order does not matter.
const HARMLESS: [&str; 11] = ["G17", "G21", "G40", "G49", "G54", "G80", "G90", "G94", "G91.1", "M5", "M9"];

impl StartupBlocks {
    pub(super) fn take(&mut self, name: &str, value: &str) {
        let value = value.trim().to_ascii_uppercase();
        let Some(n @ 0..2) = name.strip_prefix('N').and_then(|n| n.parse::<usize>().ok()) else {
            self.more |= !value.is_empty();
            return;
        };
        self.stated[n] = true;
        self.free[n] = value.is_empty();
        for word in words(&value) {
            self.harms[n] |= !HARMLESS.contains(&word.as_str());
            self.cancels_motion |= word == "G80";
        }
    }

    /// The startup line to store, if one is missing.
    ///
    /// # Errors
    /// [`Unfit`] if the startup lines are not fully stated, or contain harmful words.
    pub(super) fn needed(self) -> Result<Option<&'static [u8]>, Unfit> {
        const NEEDED: &str = "empty, or made of G17 G21 G40 G49 G54 G80 G90 G94 G91.1 M5 M9: the controller \
                              runs it after each reset, and it changes the meaning of later lines. Clear it \
                              with $N0= or $N1=";
        let unfit = |name, needed| Err(Unfit { name, value: f64::NAN, needed });
        if self.stated != [true; 2] {
            return unfit("$N", "answered with both startup lines, even empty ones");
        }
        if self.more {
            return unfit("$N2", "empty: the controller runs it after each reset");
        }
        match (self.harms, self.cancels_motion, self.free) {
            ([true, _], ..) => unfit("$N0", NEEDED),
            ([_, true], ..) => unfit("$N1", NEEDED),
            (_, true, _) => Ok(None),
            (.., [_, true]) => Ok(Some(b"$N1=G80\n")),
            (.., [true, _]) => Ok(Some(b"$N0=G80\n")),
            _ => unfit(
                "$N1",
                "G80, or empty: after a reset the controller must not run the rest of a line as a motion",
            ),
        }
    }
}

/// The words of a startup line: a letter and its digits. Leading zeros are left out, as the controller does.
fn words(line: &str) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    for letter in line.chars().filter(|letter| !letter.is_whitespace()) {
        match words.last_mut() {
            Some(word) if !letter.is_ascii_alphabetic() => {
                let zero = letter == '0' && word.len() == 1;
                if !zero {
                    word.push(letter);
                }
            }
            _ => words.push(letter.into()),
        }
    }
    words
}

/// The settings still to store.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Stores {
    report_mask: Option<u16>,
    arc_tolerance_mm: Option<f64>,
    /// [`Settings::others`] before the stores.
    others: u64,
}

impl Stores {
    /// The next line to send.
    pub(super) fn take_next(&mut self) -> Option<Vec<u8>> {
        if let Some(mask) = self.report_mask.take() {
            return Some(format!("$10={mask}\n").into_bytes());
        }
        Some(format!("$12={:.5}\n", written_mm(self.arc_tolerance_mm.take()?)).into_bytes())
    }

    /// The settings to read after the stores.
    pub(super) fn to_compare_with(self) -> Settings {
        Settings { before: Some(self.others), ..Settings::default() }
    }
}

/// The arc tolerance as it is stored, rounded down to a written digit: rounded up, arcs would deviate by more than
/// the margin allows.
fn written_mm(arc_tolerance_mm: f64) -> f64 {
    (arc_tolerance_mm * 1e5 + 1e-6).floor() / 1e5
}

/// The number at the beginning of a setting's value. NaN if there is none, or if it is not finite.
pub(super) fn setting_value(text: &str) -> f64 {
    let number = text.split_whitespace().next().and_then(|number| number.parse().ok());
    number.filter(|number: &f64| number.is_finite()).unwrap_or(f64::NAN)
}

/// The refusal of a controller that lists a setting otherwise than it was stored.
pub(super) fn not_stored(name: &'static str, listed: Option<f64>) -> Unfit {
    let needed = "as this session stored it: start again, and check the cable if it comes back";
    Unfit { name, value: listed.unwrap_or(f64::NAN), needed }
}

/// The settings that a session stores.
const STORED: [u16; 2] = [10, 12];

/// Controller settings that safety and jogging rest on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Settings {
    /// A digest of the settings that no session stores.
    others: u64,
    /// What it was before the session stored settings. `None` at the first reading.
    before: Option<u64>,
    report_mask: Option<f64>,
    arc_tolerance_mm: Option<f64>,
    inches: Option<f64>,
    homing: Option<f64>,
    /// grblHAL: interval of automatic reports, ms.
    auto_report_ms: Option<f64>,
    steps_per_mm: [Option<f64>; 3],
    max_rate_mm_min: [Option<f64>; 3],
    acceleration_mm_s2: [Option<f64>; 3],
}

impl Settings {
    /// Takes a setting. A value that is not a number counts as NaN.
    pub(super) fn take(&mut self, number: u16, text: &str) {
        let value = setting_value(text);
        if !STORED.contains(&number) {
            let mut digest = DefaultHasher::new();
            (self.others, number, text).hash(&mut digest);
            self.others = digest.finish();
        }
        match number {
            10 => self.report_mask = Some(value),
            12 => self.arc_tolerance_mm = Some(value),
            13 => self.inches = Some(value),
            22 => self.homing = Some(value),
            481 => self.auto_report_ms = Some(value),
            100..=102 => self.steps_per_mm[usize::from(number - 100)] = Some(value),
            110..=112 => self.max_rate_mm_min[usize::from(number - 110)] = Some(value),
            120..=122 => self.acceleration_mm_s2[usize::from(number - 120)] = Some(value),
            _ => {}
        }
    }

    /// Checks the settings for a plan with these steps per mm. `z` has those of a third axis.
    pub(super) fn check(&self, steps_per_mm: f64, z: Option<f64>) -> Result<(), Unfit> {
        let unfit = |name, value, needed| Unfit { name, value, needed };
        if let Some(interval) = self.auto_report_ms.filter(|interval| interval.is_nan() || *interval > 0.0) {
            let needed = "0: the dialect would take automatic reports for answers";
            return Err(unfit("$481", interval, needed));
        }
        let stated = |name, value: Option<f64>| {
            let missing = unfit(name, f64::NAN, "reported by the controller");
            value.filter(|value| !value.is_nan()).ok_or(missing)
        };
        let homing = stated("$22", self.homing)?;
        if homing < 1.0 {
            return Err(unfit("$22", homing, "1: without homing the position is unknown"));
        }
        let inches = stated("$13", self.inches)?;
        if inches.abs() > 0.0 {
            return Err(unfit("$13", inches, "0: positions must be in mm"));
        }
        let plane = ["$100", "$101"].map(|name| (name, steps_per_mm));
        let planned = plane.into_iter().chain(z.map(|steps_per_mm| ("$102", steps_per_mm)));
        for ((name, steps_per_mm), value) in planned.zip(self.steps_per_mm) {
            let value = stated(name, value)?;
            if value < steps_per_mm * 0.999 {
                let needed = "at least the steps_per_mm of the plan's machine profile";
                return Err(unfit(name, value, needed));
            }
        }
        Ok(())
    }

    /// What to store so that a session can rely on the controller, at the first reading. At the second one, after
    /// the stores, `None`. `mm` is the arc tolerance that the margin allows.
    ///
    /// # Errors
    /// [`Unfit`] if the second reading lacks what was stored, or differs from the first one in another setting. A digit
    /// can change on the way, in a value or in a number.
    pub(super) fn stores(&self, hal: bool, mm: f64) -> Result<Option<Stores>, Unfit> {
        let has_arcs = self.follows_arcs(mm);
        let Some(before) = self.before else {
            return Ok(Some(Stores {
                report_mask: self.report_mask_needed(hal),
                arc_tolerance_mm: (!has_arcs).then_some(mm),
                others: self.others,
            }));
        };
        // Some builds of grblHAL list the bits of GRBL only.
        if self.report_mask_needed(false).is_some() {
            return Err(not_stored("$10", self.report_mask));
        }
        if !has_arcs && !self.reads_back_arcs(mm) {
            return Err(not_stored("$12", self.arc_tolerance_mm));
        }
        if self.others != before {
            let needed = "the same in two answers: start again, and check the cable if it comes back";
            return Err(Unfit { name: "$$", value: f64::NAN, needed });
        }
        Ok(None)
    }

    /// The report mask to store, if the controller's mask lacks machine positions (bit 0) or buffers (bit 1).
    /// grblHAL reports its work offset only with bit 5, and its overrides with bit 6.
    pub(super) fn report_mask_needed(&self, hal: bool) -> Option<u16> {
        let needed = if hal { 0b110_0011 } else { 0b11 };
        let mask = self.report_mask.map_or(0, |mask| u16::try_from(nearest_unit(mask)).unwrap_or(0));
        let set = if hal { mask | needed } else { needed };
        (mask & needed != needed).then_some(set)
    }

    /// Whether the arc tolerance is provably at most `mm`. The controller reports it with three decimals.
    pub(super) fn follows_arcs(&self, mm: f64) -> bool {
        self.arc_tolerance_mm.is_some_and(|reported| reported >= 0.001 && reported + 0.0005 <= mm)
    }

    /// Whether the controller can have the arc tolerance that was stored for `mm`. It rounds a half either way. A
    /// listed 0 can be no tolerance at all.
    pub(super) fn reads_back_arcs(&self, mm: f64) -> bool {
        let fits = |listed: f64| listed > 0.0 && (listed - written_mm(mm)).abs() <= 0.000_501;
        self.arc_tolerance_mm.is_some_and(fits)
    }

    /// The limits of x and y.
    pub(super) fn limits(&self) -> Limits {
        let [x, y, _] = self.max_rate_mm_min;
        let [ax, ay, _] = self.acceleration_mm_s2;
        limits([x, y], [ax, ay])
    }
}

/// The smaller rate and acceleration of x and y, as far as they are known, and the greater acceleration.
pub(super) fn limits(max_rate_mm_min: [Option<f64>; 2], acceleration_mm_s2: [Option<f64>; 2]) -> Limits {
    let known = |values: [Option<f64>; 2]| values.into_iter().flatten().filter(|value| *value > 0.0);
    let rate = known(max_rate_mm_min).fold(f64::INFINITY, f64::min);
    Limits {
        speed_mm_s: rate / 60.0,
        acceleration_mm_s2: known(acceleration_mm_s2).fold(f64::INFINITY, f64::min),
        quicker_mm_s2: known(acceleration_mm_s2).reduce(f64::max).unwrap_or(f64::INFINITY),
    }
}
