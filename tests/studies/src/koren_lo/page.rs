//! The page `docs/research/koren-lo.md`: every figure and table of the paper's section 7, as we reproduce it.

use std::fmt::Write as _;

use keepout_drives::Axes;
use keepout_drives::budget::sign_patterns;
use keepout_drives::controllers::kind::Kind;
use keepout_drives::drive::Drive;
use keepout_drives::metrics::{Spread, figure};
use keepout_drives::path::Path;
use keepout_drives::plant::PlantModel;
use keepout_drives::profile::{BUILT_IN, DriveProfile, ProfileError};
use keepout_drives::reference::{Ramp, Reference};
use keepout_drives::run::Task;

use super::comparison::{Comparison, ModelError, Row};
use super::equations::{mismatch_error, radial_error, recommended_gain};
use super::scenario::Scenario;
use super::{grades, picture};

/// The page and its pictures.
#[derive(Clone, Debug)]
pub struct Page {
    /// Markdown.
    pub text: String,
    /// File names, in the folder `koren-lo` beside the page, and SVG.
    pub pictures: Vec<(String, String)>,
}

/// A controller in a figure: with an exact model, or one that is wrong by this share.
type Shown = (Kind, f64);

/// A figure of the paper.
struct Figure {
    number: &'static str,
    row: &'static str,
    shown: &'static [Shown],
    /// What the paper says of it.
    says: &'static str,
    /// What we find.
    found: &'static str,
}

const FEEDBACK: [Shown; 4] = [(Kind::P, 0.0), (Kind::Pid, 0.0), (Kind::Zpetc, 0.0), (Kind::Ccc, 0.0)];
const CORNERS: [Shown; 5] =
    [(Kind::P, 0.0), (Kind::Pid, 0.0), (Kind::Zpetc, 0.0), (Kind::Ikf, 0.0), (Kind::Ccc, 0.0)];
const WRONG: [Shown; 4] = [(Kind::Zpetc, 0.0), (Kind::Zpetc, 0.02), (Kind::Zpetc, 0.05), (Kind::Ccc, 0.0)];
const MACHINE: [Shown; 4] = [(Kind::P, 0.0), (Kind::Pid, 0.0), (Kind::Zpetc, 0.02), (Kind::Ccc, 0.0)];

const FIGURES: [Figure; 11] = [
    Figure {
        number: "Fig. 11",
        row: "S2",
        shown: &FEEDBACK,
        says: "Axial errors of PID are much smaller than P's (±0.35 mm for ±3.2 mm), its contour error is larger; ZPETC is best with an \
               exact model; CCC is far better than P and PID.",
        found: "Reproduced.",
    },
    Figure {
        number: "Fig. 12",
        row: "S3",
        shown: &FEEDBACK,
        says: "With 15 % mismatch of gains and 44 % of time constants, all but P reach a very small contour error; ZPETC is best.",
        found: "Reproduced.",
    },
    Figure {
        number: "Fig. 13",
        row: "S1",
        shown: &WRONG,
        says: "ZPETC is better than CCC only when the model error is less than 0.5 %.",
        found: "Reproduced: they cross at 0.51 % of the time constant of one axis (RMS).",
    },
    Figure {
        number: "Fig. 14",
        row: "S7",
        shown: &FEEDBACK,
        says: "ZPETC is strongly limited by saturation; CCC, P, and PID are usually not influenced.",
        found: "Reproduced for ZPETC, CCC and P. PID *is* influenced, much: its integral winds up at the start.",
    },
    Figure {
        number: "Fig. 15",
        row: "S4",
        shown: &FEEDBACK,
        says: "CCC and PID reject friction well (CCC is the best), P and ZPETC very poorly.",
        found: "Reproduced.",
    },
    Figure {
        number: "Fig. 16",
        row: "S5",
        shown: &FEEDBACK,
        says: "The same for the cutting force.",
        found: "Reproduced, with the force at 45° to the path: the paper does not say at which angle, and at 0° it does not bend the path.",
    },
    Figure {
        number: "Fig. 17",
        row: "S6",
        shown: &CORNERS,
        says: "P is average, PID overshoots, ZPETC and CCC are accurate.",
        found: "Reproduced.",
    },
    Figure {
        number: "Fig. 18",
        row: "S6b",
        shown: &CORNERS,
        says: "With a limit ZPETC fails at the corner; IKF does not.",
        found: "Reproduced. The paper gives neither the limit nor the filter: |U| ≤ 200 and two poles of 10 ms do it.",
    },
    Figure {
        number: "Fig. 19",
        row: "E1",
        shown: &MACHINE,
        says: "Measured. ZPETC is worst on the line, PID overshoots, CCC is best.",
        found: "The order of CCC, PID and the rest is reproduced. Which of P and ZPETC is worse depends on the signs of the model error.",
    },
    Figure {
        number: "Fig. 20",
        row: "E2",
        shown: &MACHINE,
        says: "Measured. Only CCC and PID do well, because of the friction.",
        found: "Reproduced.",
    },
    Figure {
        number: "Fig. 21",
        row: "E3",
        shown: &MACHINE,
        says: "Measured. PID fails at the higher feed; ZPETC tracks better than P and PID; CCC is the only one with a small error.",
        found: "CCC is reproduced. **Not reproduced:** that ZPETC is better than PID. With the stated friction ZPETC is bound to P's \
                error, for both have P's feedback.",
    },
];

/// Makes the page. `progress` is told steps done and all of them.
///
/// # Errors
/// None, but for a wrong file in the source.
pub fn page(progress: &mut dyn FnMut(usize, usize)) -> Result<Page, ProfileError> {
    let scenarios = Scenario::built_in()?;
    let steps = FIGURES.len() + 3;
    let mut text = String::from(HEAD);
    equations(&mut text);
    machines(&mut text)?;
    progress(0, steps);
    tables(&mut text, &scenarios)?;
    progress(1, steps);
    let mut pictures = Vec::new();
    text.push_str("\n## The figures\n\nEach panel has a scale of its own; the path's panel magnifies across the path.\n");
    for (number, each) in FIGURES.iter().enumerate() {
        pictures.extend(figure_of(&mut text, each, &scenarios)?);
        progress(2 + number, steps);
    }
    let _ = write!(text, "\n## Table 3\n\n{TABLE_3}\n\n{}", grades::markdown(&grades::cells()?));
    text.push_str(BEYOND);
    pictures.extend(beyond(&mut text, &scenarios)?);
    text.push_str(NOT_REPRODUCED);
    progress(steps, steps);
    Ok(Page { text, pictures })
}

const HEAD: &str = "# Koren & Lo 1992, reproduced\n\n\
    Written by `cargo run --release -p keepout-studies -- koren-lo`; a test compares it. \"Advanced controllers for feed drives\", CIRP Annals 41/2. The paper's drawings \
    are lost to us; what its text states is held against what its model gives. Figures are contour errors in µm, from the first sample on, \
    measured as exact distances to the path: RMS / max.\n\n\
    Readings that the text does not settle: sampling period 4 ms in section 7 (it reproduces the text; 10 ms is stated for section 2.1); \
    the curvature in CCC is signed; at a corner CCC takes the segment nearest to the tool; \"2 %\" is gains +2 %, −2 % and time constants −2 %, \
    +2 % on X, Y; integrals and differences begin at zero; the path is gone at full feed from the first sample on. Gains for Table 2's machine, \
    which the paper does not give, are Table 1's for the same loop gain.\n";

const TABLE_3: &str = "Grades by a rule that was fitted to the paper's, with x the RMS contour error and r = x / P's: Excellent for r ≤ 0.025 or \
    the best of the paper's controllers in the row, Good for r ≤ 0.27, Fair for x < 300 µm and (r ≤ 2.5 or x ≤ 20 µm), else Poor. Corners: \
    overshoot past the corner with |U| ≤ 400, Excellent up to 40 µm, Fair up to 150. What is not in the paper's table has models that are 2 % wrong.";

const BEYOND: &str = "\n## Beyond the paper\n\n\
    *Contouring MPC with observer* minimises, over 15 samples, the predicted distances from the path and (weighed less) the lags along it, \
    within the amplifier's limit; a Kalman observer of each axis tells position, speed and load. The worst of an exact model and all sixteen \
    sign patterns of ±5 % in gains and time constants, and with a sample of delay that it does not know of, beside CCC with the same delay:\n\n";

const NOT_REPRODUCED: &str = "\n## What is not reproduced\n\n\
    - Eq. (5) as printed is dimensionally wrong. The simulation agrees with (fy·Dx − fx·Dy)/(Kp·f) to 10⁻⁶, at any period and time constant.\n\
    - The time constants of 40 and 50 \"s\" in section 2.1 are ms.\n\
    - Fig. 21: ZPETC better than PID. See there.\n\
    - \"PID … usually not influenced by the saturation constraints\" does not hold near the limit (Fig. 14).\n\
    - Table 3: IKF \"Fair\" at corners with a 2 % model error.\n\
    - Section 8: \"a combined algorithm of the CCC and the feedforward controller can reject all the error sources\" does not hold: with an exact \
    model and no limit it is far better than CCC, on friction no better, on saturated circles worse.\n";

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

/// The largest error on a line, µm, when time constants of 40 and 50 ms meet.
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

fn machines(text: &mut String) -> Result<(), ProfileError> {
    text.push_str("\n## The machines\n\n| profile | pulses/mm | T | K of X, Y | tau of X, Y | friction of X, Y | limit |\n|---|---|---|---|---|---|---|\n");
    for (name, _) in BUILT_IN {
        let machine = DriveProfile::load(name)?;
        let DriveProfile { pulses_per_mm, period_s, x, y, limit_bits, .. } = &machine;
        let limit = limit_bits.map_or("–".into(), |limit| format!("{limit} bits"));
        let _ = writeln!(
            text,
            "| `{name}` | {pulses_per_mm} | {} ms | {}, {} s⁻¹ | {}, {} ms | {}, {} bits | {limit} |",
            period_s * 1000.0,
            x.gain,
            y.gain,
            x.time_constant_s * 1000.0,
            y.time_constant_s * 1000.0,
            x.coulomb_bits,
            y.coulomb_bits
        );
    }
    Ok(())
}

fn tables(text: &mut String, scenarios: &[Scenario]) -> Result<(), ProfileError> {
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
            "\nWith models that are {} % wrong (those that have one; gains +, −, time constants −, +):\n\n{}",
            share * 100.0,
            wrong.markdown()
        );
    }
    Ok(())
}

/// Controllers that use a model.
const MODELLED: [Kind; 12] = [
    Kind::StateFeedback,
    Kind::ExactInverse,
    Kind::DriveFeedforward,
    Kind::Zpetc,
    Kind::Ikf,
    Kind::CccFeedforward,
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

fn row_of(scenarios: &[Scenario], name: &str) -> Result<Option<Row>, ProfileError> {
    let Some(scenario) = scenarios.iter().find(|row| row.name == name) else { return Ok(None) };
    Ok(Some(Row::new(scenario, &DriveProfile::load(&scenario.machine)?)))
}

fn figure_of(
    text: &mut String,
    each: &Figure,
    scenarios: &[Scenario],
) -> Result<Option<(String, String)>, ProfileError> {
    let Some(mut row) = row_of(scenarios, each.row)? else { return Ok(None) };
    let Scenario { title, feed_m_min, .. } = &row.scenario;
    let _ = write!(
        text,
        "\n### {}: {title}, {feed_m_min} m/min ({})\n\nPaper: {}\n\nOurs: {}\n\n| | RMS | max | largest axial | past the corner | commands cut off |\n|---|---|---|---|---|---|\n",
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

fn beyond(text: &mut String, scenarios: &[Scenario]) -> Result<Option<(String, String)>, ProfileError> {
    text.push_str("| | CCC | contouring, exact | worst of ±5 % | unknown delay | CCC, the same delay |\n|---|---|---|---|---|---|\n");
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

/// What repetition learns, round by round, and its picture.
fn rounds(text: &mut String, scenarios: &[Scenario]) -> Result<Option<(String, String)>, ProfileError> {
    let Some(mut row) = row_of(scenarios, "R1")? else { return Ok(None) };
    let round = row.scenario.round(&row.machine).unwrap_or(1);
    let kinds = [Kind::P, Kind::Repetitive];
    row.entries = kinds.into_iter().filter_map(|kind| row.entry(kind, ModelError::NONE)).collect();
    text.push_str("\n*Repetitive control* (γ = 0.7) takes seven tenths of the axial error off in each round. RMS of the axial error of X on R1, µm, round by round:\n\n");
    for entry in &row.entries {
        let axial = |moments: &[keepout_drives::metrics::Moment]| {
            figure(
                Spread::of(moments.iter().map(|moment| (moment.reference - moment.position).x)).rms
                    * row.um(),
            )
        };
        let list: Vec<_> = entry.outcome.moments.chunks_exact(round).map(axial).collect();
        let _ = writeln!(text, "- {}: {}", entry.kind.names().1, list.join(", "));
    }
    text.push_str("\n![R1: P and repetitive control over five rounds](koren-lo/rounds.svg)\n");
    Ok(Some(("rounds.svg".into(), picture::svg(&row))))
}
