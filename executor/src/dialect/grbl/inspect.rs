//! Inspects a GRBL 1.1 or grblHAL controller with `$I`, `$G` and `$$`, which store no setting.
//!
//! Implements SR-19.

use std::collections::BTreeMap;

use super::super::inspect::{Finding, Fit, Inspected, Inspector, StatedAxis};
use super::settings::{limits, setting_value};

/// The answers of a GRBL controller.
#[derive(Clone, Debug, Default)]
pub(super) struct GrblInspector {
    greeting: Option<String>,
    version: Option<String>,
    options: Option<String>,
    modes: Option<String>,
    settings: BTreeMap<u16, f64>,
    digits: Option<usize>,
}

/// The queries. The first line spoils a partial line left in the controller's buffer: `$` is not a G-code
/// letter, and no `$` command ends with it, so the controller rejects the line. Alone, `$` asks for help.
const QUESTIONS: [&[u8]; 4] = [b"$\n", b"$I\n", b"$G\n", b"$$\n"];

impl Inspector for GrblInspector {
    fn questions(&self) -> &'static [&'static [u8]] {
        &QUESTIONS
    }

    fn hear(&mut self, line: &str) -> bool {
        let inner = |before: &str| Some(line.strip_prefix(before)?.strip_suffix(']')?.to_string());
        if line.to_ascii_lowercase().starts_with("grbl") {
            self.greeting = Some(line.into());
        } else if let Some(version) = inner("[VER:") {
            self.version = Some(version);
        } else if let Some(options) = inner("[OPT:") {
            self.options = Some(options);
        } else if let Some(modes) = inner("[GC:") {
            self.modes = Some(modes);
        } else if let Some((name, value)) = line.strip_prefix('$').and_then(|rest| rest.split_once('=')) {
            let value = setting_value(value);
            if let (Ok(name), false) = (name.parse(), value.is_nan()) {
                self.settings.insert(name, value);
            }
        } else if let Some((_, place)) = line.split_once("MPos:") {
            let first = place.split([',', '|', '>']).next().unwrap_or("");
            self.digits = first.split_once('.').map(|(_, digits)| digits.len());
        }
        line == "ok" || line.starts_with("error:")
    }

    fn inspected(&self, steps_per_mm: f64, arc_tolerance_mm: f64) -> Inspected {
        let stated = |name: &str, value: &Option<String>| Finding {
            name: name.into(),
            value: value.clone().unwrap_or_else(|| "not reported".into()),
            fit: Fit::Good,
        };
        let mut findings = vec![
            stated("greeting", &self.greeting),
            stated("version", &self.version),
            stated("options: planner blocks, receive buffer", &self.options),
            stated("modes", &self.modes),
        ];
        findings.extend(self.checked(steps_per_mm, arc_tolerance_mm));
        let both = |axes: [u16; 2]| axes.map(|axis| self.settings.get(&axis).copied());
        let steps = both([100, 101]).into_iter().flatten().filter(|value| *value > 0.0 && value.is_finite());
        Inspected {
            findings,
            steps_per_mm: steps.reduce(f64::min),
            report_digit_mm: self
                .digits
                .and_then(|digits| i32::try_from(digits).ok())
                .map(|digits| 10_f64.powi(-digits)),
            limits: limits(both([110, 111]), both([120, 121])),
            travel_mm: match both([130, 131]) {
                [Some(x), Some(y)] if x > 0.0 && y > 0.0 => Some([x, y]),
                _ => None,
            },
            z: self.third_axis(),
            firmware: self.version.clone().or_else(|| self.greeting.clone()),
        }
    }
}

impl GrblInspector {
    fn third_axis(&self) -> StatedAxis {
        let stated = |number: u16| self.settings.get(&number).copied().filter(|value| *value > 0.0);
        StatedAxis {
            travel_mm: stated(132),
            max_rate_mm_s: stated(112).map(|rate| rate / 60.0),
            acceleration_mm_s2: stated(122),
            steps_per_mm: stated(102),
        }
    }

    fn checked(&self, steps_per_mm: f64, arc_tolerance_mm: f64) -> Vec<Finding> {
        let finding = |&(number, name): &(u16, &str)| {
            let stated = self.settings.get(&number);
            let fit = match stated {
                Some(&value) => fit(number, value, steps_per_mm, arc_tolerance_mm),
                None if DISPENSABLE.contains(&number) => Fit::Minor("the controller does not report it"),
                None => Fit::Wrong("the controller must report it"),
            };
            let value = stated.map_or("not reported".into(), ToString::to_string);
            Finding { name: format!("${number} {name}"), value, fit }
        };
        let mut findings: Vec<Finding> = SETTINGS.iter().map(finding).collect();
        let (value, fit) = match self.digits {
            Some(digits @ 3..) => (format!("{digits} decimals of a mm"), Fit::Good),
            Some(digits) => (format!("{digits} decimals"), Fit::Wrong("set $13=0: positions must be in mm")),
            None => {
                ("not reported".into(), Fit::Minor("a session sets $10=3, for machine positions in reports"))
            }
        };
        findings.push(Finding { name: "reported position".into(), value, fit });
        findings
    }
}

/// The inspected settings.
const SETTINGS: [(u16, &str); 18] = [
    (10, "report contents"),
    (12, "arc tolerance, mm"),
    (13, "reports in inches"),
    (20, "soft limits"),
    (21, "hard limits"),
    (22, "homing"),
    (100, "steps per mm, x"),
    (101, "steps per mm, y"),
    (102, "steps per mm, z"),
    (110, "top speed, mm/min, x"),
    (111, "top speed, mm/min, y"),
    (112, "top speed, mm/min, z"),
    (120, "acceleration, mm/s², x"),
    (121, "acceleration, mm/s², y"),
    (122, "acceleration, mm/s², z"),
    (130, "travel, mm, x"),
    (131, "travel, mm, y"),
    (132, "travel, mm, z"),
];
/// The inspected settings that a session can do without.
const DISPENSABLE: [u16; 12] = [20, 21, 102, 110, 111, 112, 120, 121, 122, 130, 131, 132];

/// Whether a session can work with a setting's value.
fn fit(number: u16, value: f64, steps_per_mm: f64, arc_tolerance_mm: f64) -> Fit {
    let on = value >= 1.0;
    let wrong = |good: bool, remedy: &'static str| if good { Fit::Good } else { Fit::Wrong(remedy) };
    let minor = |good: bool, note: &'static str| if good { Fit::Good } else { Fit::Minor(note) };
    match number {
        10 => minor(
            value.rem_euclid(4.0) >= 3.0,
            "a session sets $10=3, for positions and planner blocks in reports",
        ),
        12 => minor(
            value >= 0.001 && value + 0.0005 <= arc_tolerance_mm,
            "a session sets it to the machine profile's arc tolerance",
        ),
        13 => wrong(!on, "set $13=0: positions must be in mm"),
        20 => minor(on, "off: the controller itself does not check its travel"),
        21 => minor(on, "off: limit switches do not stop the machine"),
        22 => wrong(on, "set $22=1: without homing the position is unknown"),
        100 | 101 => wrong(
            value >= steps_per_mm * 0.999,
            "coarser than the machine profile states: enter this steps_per_mm there, and plan again",
        ),
        _ => Fit::Good,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::supervisor::Limits;

    // Evidence for SR-19.
    #[test]
    fn inspection_reads_settings_and_marks_unusable_ones() {
        let mut inspector = GrblInspector::default();
        let lines = [
            "Grbl 1.1h ['$' for help]",
            "[VER:1.1h.20190825:]",
            "[OPT:V,15,128]",
            "<Idle|MPos:-1.000,-1.000,0.000|FS:0,0>",
            "$10=1",
            "$12=0.002",
            "$13=1",
            "$20=0",
            "$22=0 (homing)",
            "$100=400.000",
            "$101=250.000",
            "$110=6000",
            "$111=3000",
            "$120=100",
            "$121=90",
        ];
        assert!(lines.iter().all(|line| !inspector.hear(line)));
        assert!(inspector.hear("ok") && inspector.hear("error:3"));
        let found = inspector.inspected(400.0, 0.0005);
        assert_eq!((found.steps_per_mm, found.report_digit_mm), (Some(250.0), Some(0.001)));
        assert_eq!(found.limits, Limits { speed_mm_s: 50.0, acceleration_mm_s2: 90.0, quicker_mm_s2: 100.0 });
        let wrong = |name: &str| {
            let finding = found.findings.iter().find(|finding| finding.name.starts_with(name)).unwrap();
            matches!(finding.fit, Fit::Wrong(_))
        };
        assert!(wrong("$13") && wrong("$22") && wrong("$101") && !wrong("$100") && !wrong("$10 "));
        assert!(found.findings.iter().any(|finding| finding.value == "3 decimals of a mm"));
        // A value that is not a finite number counts as not reported.
        let mut damaged = GrblInspector::default();
        assert!(!["$13=nan", "$22=inf", "$100=-inf"].iter().any(|line| damaged.hear(line)));
        assert!(damaged.settings.is_empty());
        let silent = GrblInspector::default().inspected(400.0, 0.0005);
        assert!(silent.findings.iter().any(|finding| matches!(finding.fit, Fit::Wrong(_))));
    }
}
