//! The page `docs/research/koren-lo.md`: our reproduction of every figure and table of the paper's section 7.

use std::fmt::Write as _;

use keepout_drives::Axes;
use keepout_drives::budget::sign_patterns;
use keepout_drives::controllers::contouring::Weights;
use keepout_drives::controllers::kind::Kind;
use keepout_drives::controllers::law::PidGains;
use keepout_drives::drive::Drive;
use keepout_drives::metrics::{Spread, figure};
use keepout_drives::path::Path;
use keepout_drives::plant::PlantModel;
use keepout_drives::profile::{BUILT_IN, DriveProfile, DriveProfileError};
use keepout_drives::reference::{Ramp, Reference};
use keepout_drives::run::Task;
use keepout_planner::report::table::markdown;

use super::comparison::{Comparison, ModelError, Row};
use super::equations::{mismatch_error, radial_error, recommended_gain};
use super::figures::{FIGURES, PaperFigure};
use super::scenario::DriveScenario;
use super::{grades, picture};

/// The page and its pictures.
#[derive(Clone, Debug)]
pub struct Page {
    /// Markdown.
    pub text: String,
    /// File names in the folder `koren-lo` next to the page, and the SVG texts.
    pub pictures: Vec<(String, String)>,
}

/// Makes the page. Calls `progress` with the number of finished steps and of all steps.
///
/// # Errors
/// Only if a built-in file is invalid.
pub fn page(progress: &mut dyn FnMut(usize, usize)) -> Result<Page, DriveProfileError> {
    let scenarios = DriveScenario::built_in()?;
    let steps = FIGURES.len() + 3;
    let mut text = String::from(HEAD);
    equations(&mut text);
    machines(&mut text)?;
    progress(0, steps);
    tables(&mut text, &scenarios)?;
    progress(1, steps);
    let mut pictures = Vec::new();
    text.push_str(
        "\n## The figures\n\n\
         All panels of a figure have one scale. The panel of the path magnifies errors across the path.\n",
    );
    for (number, each) in FIGURES.iter().enumerate() {
        pictures.extend(figure_of(&mut text, each, &scenarios)?);
        progress(2 + number, steps);
    }
    stops(&mut text, &scenarios)?;
    let _ = write!(text, "\n## Table 3\n\n{TABLE_3}\n\n{}", grades::markdown(&grades::cells()?));
    text.push_str(BEYOND);
    pictures.extend(beyond(&mut text, &scenarios)?);
    text.push_str(NOT_REPRODUCED);
    progress(steps, steps);
    Ok(Page { text, pictures })
}

const HEAD: &str = "# Koren & Lo 1992, reproduced\n\n\
    Written by `cargo run --release -p keepout-studies -- koren-lo`; a test compares it.\n\n\
    The paper is \"Advanced controllers for feed drives\", CIRP Annals 41/2. We do not have its drawings, so\n\
    we compare the statements of its text with the results of its model. The values are contour errors in\n\
    µm, RMS / max, from the first sample on until the reference comes to the end of the path. They are exact\n\
    distances to the path.\n\n\
    The text leaves some points open. We read them as follows:\n\n\
    - The sampling period in section 7 is 4 ms, which reproduces the text. The paper states 10 ms for\n  \
    section 2.1 only.\n\
    - The curvature in CCC is signed.\n\
    - CCC computes the contour error by eqs. (15) to (17). While a corner lies between tool and reference, it is\n  \
    the exact distance to the path instead. *CCC with the exact contour error* always takes the exact distance.\n\
    - \"I off at corners\": the integral action adds nothing from one time constant before a corner until the tool\n  \
    has passed it. *PID with ZPETC* adds a PID law on the remaining error to the drive's zero-phase inverse.\n\
    - A model error of \"2 %\" means gains +2 %, −2 % and time constants −2 %, +2 % on X, Y.\n\
    - Integrals and differences begin at zero.\n\
    - The reference moves at full feed from the first sample on.\n\
    - The paper gives no gains for the machine of Table 2. We scale the gains of Table 1 to the same loop\n  \
    gain.\n";

const TABLE_3: &str = "We fitted a rule to the paper's grades. x is the RMS contour error, and r is x divided\n\
    by the x of P.\n\n\
    | grade | rule | corners: overshoot with \\|U\\| ≤ 400 |\n|---|---|---|\n\
    | Excellent | r ≤ 0.025, or the best of the paper's controllers in the row | up to 40 µm |\n\
    | Good | r ≤ 0.27 | |\n\
    | Fair | x < 300 µm and (r ≤ 2.5 or x ≤ 20 µm) | up to 150 µm |\n\
    | Poor | all others | above 150 µm |\n\n\
    Controllers that are not in the paper's table use models with an error of 2 %.";

const BEYOND: &str = "\n## Beyond the paper\n\n\
    *Contouring MPC with observer* predicts 15 samples. It minimises the distances from the path and, with a\n\
    smaller weight, the lags along the path. What comes after the horizon costs the value of the Riccati equation.\n\
    Commands stay within the amplifier's limit. It knows the Coulomb friction of the profile. A Kalman observer of\n\
    each axis estimates position, speed and a load that turns with the path. Where the delay is uncertain, it assumes\n\
    the middle of the range.\n\n\
    \"Worst of ±5 %\" is the worst of an exact model and all sixteen sign patterns of ±5 % in gains and time\n\
    constants. \"Unknown delay\" is a delay of one sample that the controller does not know. CCC with the\n\
    same delay is in the last column.\n\n";

const NOT_REPRODUCED: &str = "\n## What is not reproduced\n\n\
    - Eq. (5) holds as printed if D is the speed that a load takes in each sample, and the motor is 1/(s + 1/τ).\n  \
    With D in bits, as in section 7, the error is (fy·Dx − fx·Dy)/(Kp·f). A test compares both with the simulation.\n\
    - Fig. 13 holds by a special reading only, which is given there.\n\
    - The time constants of 40 and 50 \"s\" in section 2.1 are ms.\n\
    - Fig. 21: ZPETC is not better than PID. The reason is given there.\n\
    - \"PID … usually not influenced by the saturation constraints\" does not hold near the limit\n  \
    (Fig. 14).\n\
    - Table 3: IKF is not \"Fair\" at corners with a 2 % model error.\n\
    - Section 8: \"a combined algorithm of the CCC and the feedforward controller can reject all the error\n  \
    sources\" does not hold. The combination is far better than CCC with an exact model and no limit. It is\n  \
    no better against friction, and worse on saturated circles.\n";

fn equations(text: &mut String) {
    let feed = 1.8 * 1e5 / 60.0;
    let ramp = mismatch_error(Axes::new(feed, feed), Axes::new(10.0, 10.3)) * 10.0;
    let _ = write!(
        text,
        "\n## The equations\n\n| | paper | ours |\n|---|---|---|\n\
         | eq. (1), K = 10 and 10.3 s⁻¹, 1.8 m/min on both axes | 62 µm | {ramp:.2} µm |\n\
         | tau = 40 and 50 ms, T = 10 ms, the same feed, simulated | 105 µm | {:.2} µm |\n\
         | eq. (7), T = 10 ms, tau = 45 ms | 10 s⁻¹ | {:.3} s⁻¹ |\n",
        transient(),
        recommended_gain(0.01, 0.045)
    );
    let drive = Drive { gain: 10.0, time_constant_s: 0.045 };
    for m_min in [0.754, 1.508, 1.88] {
        let turning = m_min * 1e5 / 60.0 / 2000.0;
        let sampled = 1.0 - drive.held(0.004).closed(1.0).magnitude(turning * 0.004);
        let _ = writeln!(
            text,
            "| eq. (6), circle of 20 mm at {m_min} m/min | | {:.3} µm; sampled at 4 ms {:.3} µm |",
            radial_error(drive, turning).abs() * 20_000.0,
            sampled.abs() * 20_000.0
        );
    }
}

/// The largest contour error on a line, µm, with time constants of 40 and 50 ms.
fn transient() -> f64 {
    let drive = |time_constant_s| Drive { gain: 10.0, time_constant_s };
    let plant = PlantModel::ideal([drive(0.040), drive(0.050)], 0.01);
    let feed = 1.8 * 1e5 / 60.0;
    let path = Path::line(Axes::new(feed, feed) * 2.0);
    let along = feed.hypot(feed);
    let reference = Reference::along(&path, along, 0.01, Ramp::None).samples;
    let task = Task { plant, path, feed: along, reference, cutting: None };
    let mut controller = keepout_drives::controllers::proportional::Proportional { gain: 1.0 };
    task.run(&mut controller).figures.contour.max * 10.0
}

fn machines(text: &mut String) -> Result<(), DriveProfileError> {
    text.push_str(
        "\n## The machines\n\n\
         | profile | pulses/mm | T | K of X, Y | tau of X, Y | friction of X, Y | limit | encoder and command |\n\
         |---|---|---|---|---|---|---|---|\n",
    );
    for (name, _) in BUILT_IN {
        let machine = DriveProfile::load(name)?;
        let DriveProfile { pulses_per_mm, period_s, x, y, limit_bits, .. } = &machine;
        let steps = if machine.whole_numbers {
            format!("whole pulses of {} µm, whole bits", machine.um())
        } else {
            "continuous".into()
        };
        let limit = limit_bits.map_or("–".into(), |limit| format!("{limit} bits"));
        let _ = writeln!(
            text,
            "| `{name}` | {pulses_per_mm} | {} ms | {}, {} s⁻¹ | {}, {} ms | {}, {} bits | {limit} | {steps} |",
            period_s * 1000.0,
            x.gain,
            y.gain,
            x.time_constant_s * 1000.0,
            y.time_constant_s * 1000.0,
            x.coulomb_bits,
            y.coulomb_bits
        );
    }
    text.push_str(
        "\n| profile | Kp of P, bits/pulse | PID: Kp, Ki, Kd | W(z) of CCC: Kp, Ki, Kd \
         | contouring MPC: frequencies of commands, changes, observer, load; weight of lags \
         | cutting force, bits at mm/min, angle |\n\
         |---|---|---|---|---|---|\n",
    );
    for (name, _) in BUILT_IN {
        let DriveProfile { gains, cutting, .. } = DriveProfile::load(name)?;
        let law = |law: PidGains| format!("{}, {}, {}", law.proportional, law.integral, law.derivative);
        let Weights { bandwidth, changes, lag, observer, load } = gains.design.contouring;
        let force = cutting.map_or("–".into(), |force| {
            format!("{} at {}, {}°", force.bits, force.at_feed_mm_min, force.angle_deg)
        });
        let _ = writeln!(
            text,
            "| `{name}` | {} | {} | {} | {bandwidth}, {changes}, {observer}, {load}; {lag} | {force} |",
            gains.proportional,
            law(gains.pid),
            law(gains.cross_coupling)
        );
    }
    text.push_str(
        "\nThe frequencies of the contouring MPC are angles per sample, rad. On the machine of Table 1 they leave it\n\
         a peak of the sensitivity of 3.3, with drives that are 20 % wrong and one sample of unknown delay. CCC\n\
         with the paper's gains has a peak of 3.2 with this delay alone, and with such drives as well it does not\n\
         settle.\n",
    );
    Ok(())
}

fn tables(text: &mut String, scenarios: &[DriveScenario]) -> Result<(), DriveProfileError> {
    let exact = Comparison::run(scenarios, None, &Kind::ALL, ModelError::NONE, &mut |_, _| {})?;
    let _ = write!(
        text,
        "\n## Every controller\n\n{}\nWith exact models:\n\n{}",
        exact.legend(),
        exact.markdown()
    );
    let _ = writeln!(text, "\nThe selection of section 8 chooses:{}.", choices(&exact));
    for share in [0.02, 0.05] {
        let wrong = Comparison::run(scenarios, None, &MODELLED, ModelError::crossed(share), &mut |_, _| {})?;
        let _ = write!(
            text,
            "\nControllers that use a model, with a model error of {} % \
             (gains +, −, time constants −, +):\n\n{}",
            share * 100.0,
            wrong.markdown()
        );
    }
    Ok(())
}

/// Controllers that use a model.
const MODELLED: [Kind; 13] = [
    Kind::StateFeedback,
    Kind::ExactInverse,
    Kind::DriveFeedforward,
    Kind::Zpetc,
    Kind::Ikf,
    Kind::CccFeedforward,
    Kind::PidZpetc,
    Kind::Lq,
    Kind::OptimalCcc,
    Kind::Gpc,
    Kind::AdaptiveZpetc,
    Kind::Matching,
    Kind::Contouring,
];

fn choices(comparison: &Comparison) -> String {
    let chosen = comparison.rows.iter().filter_map(|row| {
        let entry = row.entries.iter().find(|entry| entry.kind == Kind::Selection)?;
        Some(format!(" {} {}", row.scenario.name, entry.chosen?.names().0))
    });
    chosen.collect::<Vec<_>>().join(",")
}

/// Overshoot at stopping: the paper's Fig. 19, and "special problems" of its Table 3.
fn stops(text: &mut String, scenarios: &[DriveScenario]) -> Result<(), DriveProfileError> {
    const KINDS: [Kind; 8] = [
        Kind::P,
        Kind::Pid,
        Kind::PidCorners,
        Kind::PidZpetc,
        Kind::Zpetc,
        Kind::Ccc,
        Kind::CccFeedforward,
        Kind::Contouring,
    ];
    text.push_str(
        "\n## Overshoot at stopping\n\n\
         Paper: \"The PID controller … may result in an overshoot at stopping\" (Table 3, Fig. 19).\n\n\
         Ours: Reproduced. The runs go on for ten time constants after the reference has come to the end of the\n\
         path. The values are the largest distance past the end in the direction of the path, and the largest \
         distance\n\
         from the path in that time, µm, with exact models.\n\n",
    );
    let mut table = vec![vec![String::new(), "S6 (corner)".into(), "E1 (line)".into(), "X3 (ramp)".into()]];
    for kind in KINDS {
        let mut line = vec![kind.names().1.to_string()];
        for name in ["S6", "E1", "X3"] {
            let found =
                row_of(scenarios, name)?.and_then(|row| Some((row.entry(kind, ModelError::NONE)?, row.um())));
            line.push(found.map_or("–".into(), |(entry, um)| {
                let figures = &entry.outcome.figures;
                format!("{} / {}", figure(figures.stop_overshoot * um), figure(figures.run_out.max * um))
            }));
        }
        table.push(line);
    }
    text.push_str(&markdown(&table));
    Ok(())
}

fn row_of(scenarios: &[DriveScenario], name: &str) -> Result<Option<Row>, DriveProfileError> {
    let Some(scenario) = scenarios.iter().find(|row| row.name == name) else { return Ok(None) };
    Ok(Some(Row::new(scenario, &DriveProfile::load(&scenario.machine)?)))
}

fn figure_of(
    text: &mut String,
    each: &PaperFigure,
    scenarios: &[DriveScenario],
) -> Result<Option<(String, String)>, DriveProfileError> {
    let Some(mut row) = row_of(scenarios, each.row)? else { return Ok(None) };
    let DriveScenario { title, feed_m_min, .. } = &row.scenario;
    let _ = write!(
        text,
        "\n### {}: {title}, {feed_m_min} m/min ({})\n\nPaper: {}\n\nOurs: {}\n\n\
         | | RMS | max | largest axial error | overshoot at the corner | clipped commands |\n\
         |---|---|---|---|---|---|\n",
        each.number, each.row, each.says, each.found
    );
    for &(kind, error) in each.shown {
        let Some(entry) = row.entry(kind, ModelError::crossed(error)) else { continue };
        let figures = &entry.outcome.figures;
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} | {:.1} % |",
            entry.name(),
            figure(figures.contour.rms * row.um()),
            figure(figures.contour.max * row.um()),
            figure(figures.axial * row.um()),
            figure(figures.overshoot * row.um()),
            figures.saturation_share * 100.0
        );
        row.entries.push(entry);
    }
    row.entries.extend(row.entry(Kind::Contouring, ModelError::NONE));
    let name = format!("{}.svg", each.number.to_lowercase().replace(". ", "-"));
    let _ = write!(text, "\n![{}: contour errors, with ours last](koren-lo/{name})\n", each.number);
    Ok(Some((name, picture::svg(&row))))
}

fn beyond(
    text: &mut String,
    scenarios: &[DriveScenario],
) -> Result<Option<(String, String)>, DriveProfileError> {
    text.push_str(
        "| | CCC | contouring, exact | worst of ±5 % | unknown delay | CCC, the same delay |\n\
         |---|---|---|---|---|---|\n",
    );
    for scenario in scenarios {
        let Some(row) = row_of(scenarios, &scenario.name)? else { continue };
        let mut late = row.clone();
        late.task.plant.delay_samples = 1;
        let of = |row: &Row, kind, error| {
            let contour = row.entry(kind, error).map(|entry| entry.outcome.figures.contour.times(row.um()));
            contour.unwrap_or(Spread { rms: f64::NAN, max: f64::NAN })
        };
        let worst = sign_patterns().iter().fold(Spread::default(), |worst, &signs| {
            let found = of(&row, Kind::Contouring, ModelError { share: 0.05, signs });
            worst.worse(found)
        });
        let cell = |spread: Spread| format!("{} / {}", figure(spread.rms), figure(spread.max));
        let exact = ModelError::NONE;
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {} | {} |",
            scenario.name,
            cell(of(&row, Kind::Ccc, exact)),
            cell(of(&row, Kind::Contouring, exact)),
            cell(worst),
            cell(of(&late, Kind::Contouring, exact)),
            cell(of(&late, Kind::Ccc, exact))
        );
    }
    rounds(text, scenarios)
}

/// The axial errors of repetitive control per round, and their picture.
fn rounds(
    text: &mut String,
    scenarios: &[DriveScenario],
) -> Result<Option<(String, String)>, DriveProfileError> {
    let Some(mut row) = row_of(scenarios, "R1")? else { return Ok(None) };
    let round = row.scenario.round(&row.machine).unwrap_or(1);
    let kinds = [Kind::P, Kind::Repetitive];
    row.entries = kinds.into_iter().filter_map(|kind| row.entry(kind, ModelError::NONE)).collect();
    text.push_str(
        "\n*Repetitive control* (γ = 0.7) removes seven tenths of the axial error in each round.\n\
         RMS of the axial error of X on R1, µm, per round:\n\n",
    );
    for entry in &row.entries {
        let axial = |moments: &[keepout_drives::metrics::Moment]| {
            figure(
                Spread::of(moments.iter().map(|moment| (moment.reference - moment.position).x)).rms
                    * row.um(),
            )
        };
        let list: Vec<_> = entry.outcome.in_motion().chunks_exact(round).map(axial).collect();
        let _ = writeln!(text, "- {}: {}", entry.kind.names().1, list.join(", "));
    }
    text.push_str("\n![R1: P and repetitive control over five rounds](koren-lo/rounds.svg)\n");
    Ok(Some(("rounds.svg".into(), picture::svg(&row))))
}
