//! The page `docs/research/franco-horikawa.md`: written from the results alone, so that a test can write it again.

use std::fmt::Write as _;

use super::attempt::real;
use super::delays::Looked;
use super::results::{PaperRow, Results};
use super::scenario::Scenarios;
use super::tables::{markdown, paper_table, percent};

/// Folder of the page's pictures and results, beside it.
pub const FOLDER: &str = "franco-horikawa";

/// The page.
#[must_use]
pub fn page(scenarios: &Scenarios, results: &Results) -> String {
    let mut text = String::from(HEAD);
    let _ = writeln!(
        text,
        "\n`cargo run --release -p keepout-studies -- franco-horikawa --attempts {} --seed {}` made this page, its pictures and its [results](franco-horikawa/results.json).\n",
        results.attempts, results.seed
    );
    summary(&mut text, results);
    text += SETTING;
    shapes(&mut text, scenarios);
    delays(&mut text, results);
    prediction(&mut text, results);
    ours(&mut text, results);
    pictures(&mut text, scenarios);
    let _ = write!(text, "{CLEARING}{}", markdown(&results.clearing_table()));
    let _ = write!(text, "{FINISHING}{}", markdown(&results.finishing_table()));
    let _ = write!(text, "{HANDWHEEL}{}", markdown(&results.handwheel_table()));
    text += LIMITS;
    for row in paper_table(&results.by_x).iter().enumerate().filter(|(n, row)| *n < 1 || row[0] != "2 (a)") {
        let (number, cells) = row;
        let kept = [0, 1, 2, 3, 6, 10].map(|column| cells[column].clone());
        let _ = writeln!(text, "  | {} |", kept.join(" | "));
        if number == 0 {
            let _ = writeln!(text, "  |{}", "---|".repeat(kept.len()));
        }
    }
    text + LIMITS_ON
}

const HEAD: &str = "# The experiment of Franco & Horikawa, and the same with Keepout

L. N. Franco García and O. Horikawa, *Manual and servo assisted, hybrid system for position control in machine tools*, COBEM 2007, had
operators steer a tool at a part's outline with a joystick. Their computer asked the drives' controller where the tool is, compared, and
sent a stop. They counted how often the tool stayed out of the part, and how far from it it was stopped (Tables 2 and 3).
";

const SETTING: &str = "## What was set up

The paper's controller is a policy of this study (`tests/studies/src/franco_horikawa/paper.rs`): it drives two modelled modules and can not be chosen for
a port. It asks for the position, checks it against the profile that is grown by the tool's radius (eqs. (3) to (13)), by the
distance to the segments whose interval holds the tool (eq. (2)), and then sends a stop, or one motion in the direction of the stick. The flow chart
(Fig. 7) is lost; a round of it is read as: query, answer, computation, and one line. The other two checks, point matrix (eq. (1)) and
sum of angles, stand beside it in `tests/studies/src/franco_horikawa/invasion/`, with tests that show how each fails: points between samples, distances to the infinite
line, acute and inside corners, no side.

With the paper's system an attempt begins 8 to 30 mm from the part, a model of an operator steers, and the first stop ends it, once nothing moves. With
ours it begins there too (at more than 20 mm/s up to 90 mm away), and once the wall first shortens a wish the model steers on for 1 to 6 s and four delays of the
line; then the stick is leant on the wall until the tool rests. An operator who does not come to the part in a minute (and a hundred delays) begins anew, unless
the tool was in the part. The exact witness of the simulated machine decides whether it was, and how near it came at the least: the under-cutting of a
success.

What differs besides the controller: the paper's system is steered by models of people (calm, jittery, straight at the wall, with a stick that sticks), ours by
these and by random directions and reversals timed to the wall. The paper's modules follow with a lag and are at their feed at once; ours speed up by 600 mm/s²
(what the thrust of Table 1 leaves at top speed) and repeat to ±10 µm. The paper's line speaks like an NSK controller, ours GRBL; both run at 9600
baud, ours with a delay besides.

The paper gives no sizes, and of shapes the number of sides. These are ours (`tests/studies/src/franco_horikawa/scenarios.toml`):

";

const CLEARING: &str = "
## Time to clear the same stock

Somebody goes round the part in three rounds and clears what lies 8 to 20 mm from the profile, which both systems allow; then, with ours, in two
more, down to the wall, which is leant on. He follows a line at 28 mm/s at most (steering law), whatever the modules can do (at 1200 mm/s the least tilt of the stick is 48 mm/s), and gives a place
up that he comes no nearer to for 3 s: false alarms keep the paper's tool from some. Means of four runs. What is missing lies in corners that rounds
cut short, where the hand strays, and in inside corners where the tool does not fit: compare the area of the far stock that a second clears. The paper's
system was run with T = 5 mm.

";

const FINISHING: &str = "
## The finishing pass, single and double

The modules of Table 1 as feed drives (`keepout-studies compare --machine nsk-modules`) follow the finishing path at 12 mm/s against friction and the force of the
cut, which is that of Koren & Lo's table at 0.5 mm and grows with the thickness. A single pass takes all that roughing left: with the paper's system
the mean under-cutting of its rows with T of 4 mm and more, with ours that of all our rows, which is less than a first pass would leave. The double pass
of the paper's conclusions leaves 0.1 mm; the second cuts that, and what the first was off by. A first pass that is off by more than 100 µm may have cut into the
part. Errors are without the first half second of a loop. Both controllers are of [Koren & Lo](koren-lo.md): the best
that the paper there names, and ours.

";

const HANDWHEEL: &str = "
## One dimension: the handwheel

Sections 2 and 3.1: pulses of a handwheel reach the motor only while the table is outside the band T before the barrier; within it, only those
that lead back. The sensor is wired to the computer, so a round is the computation alone. The wheel is turned 15 mm beyond the barrier, and 5 mm back.
Ours are the supervisor's wheels, over the serial line. *Released* are attempts in which the table came back with the wheel.

";

const LIMITS: &str = "
## What was reproduced, and what was not

- **Reproduced:** success rises with T from seldom to nearly always, at both feeds alike, and under-cutting grows with T. Errors that do
  not grow with the feed are no delay of the motion that runs: they are what motions of a fixed length (the \"unitary movement\" of section 3.1), one for each
  round of the computation, leave under way. With these, one set of figures does for both feeds.
- **Not told apart:** `cargo run --release -p keepout-studies -- calibrate` lists sets of figures that fit nearly as well. All fitted rows of Table 2 (b) are at
  12 mm/s. The words of the third check name x intervals alone; the fit prefers x or y. By x alone the system is blind to steep sides:

";

const LIMITS_ON: &str = "
- **False alarms:** the distance to the infinite line stops the tool where nothing is near. The paper does not speak of them; here
  such a stop is counted beside, and the attempt begins anew, unless the tool was in the part.
- **Not reproduced:** the least under-cuttings (0.15 mm at T = 2 mm), which are means of one to four successes. That under-cutting falls when the feed
  rises: it does not in theirs at 5 mm either. Shapes, sizes and operators of that day are not known.
- The modules of Table 1 are allowed 1200 mm/s, and do not get there from so near: the table of attempts through drives has the fastest that the tool
  went by hand.
- Lines, drives and operators are models. What ours is proved to do does not rest on them: `proofs/README.md`.
";

/// Rows of the external triangle at a tolerance, mm.
fn triangle(results: &Results, tolerance_mm: f64) -> Vec<&PaperRow> {
    let rows = results.paper.iter().filter(|row| row.reported.table == "2 (a)");
    rows.filter(|row| (row.reported.tolerance_mm - tolerance_mm).abs() < 1e-9).collect()
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (count, sum) = values.fold((0, 0.0), |(count, sum), value| (count + 1, sum + value));
    sum / real(u64::max(count, 1))
}

fn summary(text: &mut String, results: &Results) {
    let ours = results.ours_together();
    let reported =
        |tolerance| percent(mean(triangle(results, tolerance).iter().map(|row| row.reported.success())));
    let found = |tolerance| percent(mean(triangle(results, tolerance).iter().map(|row| row.found.success())));
    let widest = triangle(results, 5.0);
    let left_reported = mean(widest.iter().filter_map(|row| row.reported.under_cutting_mm));
    let left_found = mean(widest.iter().filter_map(|row| row.found.mean_mm));
    let _ = writeln!(
        text,
        "| | paper, reported | paper's controller, simulated | Keepout, simulated |\n|---|---|---|---|\n\
         | without invasion | triangle: {} % (T = 1 mm), {} % (2 mm), {} % (5 mm) | {} %, {} %, {} % | {} % of {} attempts: all profiles, delays to {} s each way |\n\
         | mean under-cutting | {left_reported:.2} mm at T = 5 mm | {left_found:.2} mm at T = 5 mm | {:.3} mm, at most {:.3} mm |\n\n\
         ![success over tolerance]({FOLDER}/success.svg)\n",
        reported(1.0),
        reported(2.0),
        reported(5.0),
        found(1.0),
        found(2.0),
        found(5.0),
        percent(ours.success()),
        ours.attempts,
        real(results.ours.iter().map(|row| row.latency_ms).max().unwrap_or(0)) / 1000.0,
        ours.mean_mm.unwrap_or(f64::NAN),
        ours.worst_mm.unwrap_or(f64::NAN),
    );
}

fn shapes(text: &mut String, scenarios: &Scenarios) {
    let mut table = vec![vec!["profile".to_string(), "what".into(), "corners, mm".into()]];
    for shape in &scenarios.profile {
        let corners: Vec<String> = shape.corners.iter().map(|(x, y)| format!("({x}, {y})")).collect();
        table.push(vec![shape.name.clone(), shape.title.clone(), corners.join(" ")]);
    }
    *text += &markdown(&table);
}

fn delays(text: &mut String, results: &Results) {
    let delays = &results.delays;
    let cuts = if delays.stop_cuts { "cut by a stop" } else { "run to its end after a stop" };
    let looked = match delays.classified {
        Looked::ByX => "by x intervals",
        Looked::ByXOrY => "by x or y intervals",
    };
    let _ = writeln!(
        text,
        "\n## The delay model\n\n\
         Known: {} baud; a query has {} bytes, its answer {}, a motion {}, a stop {} (about those of `executor/dialects/nsk-style.toml`); the controller takes {} ms for \
         a line; the motion that runs is {cuts}.\n\n\
         Free, and found once by `cargo run --release -p keepout-studies -- calibrate` on the rows marked *fitted* (every other row of Table 2), by the deviance of successes and \
         the mean under-cutting (to 0.25 mm):\n\n\
         - a direction motion is **{} mm** long, and up to {} are sent ahead of the one that runs;\n\
         - a round of the computation takes **{} ms** in the mean, half of it at least, the rest exponentially distributed;\n\
         - the table follows with a time constant of **{} ms**;\n\
         - segments are looked up {looked}.\n",
        delays.baud,
        delays.query_bytes,
        delays.answer_bytes,
        delays.motion_bytes,
        delays.stop_bytes,
        1000.0 * delays.controller_s,
        delays.unit_mm,
        delays.ahead,
        (1000.0 * delays.compute_s).round(),
        (1000.0 * delays.inertia_s).round(),
    );
}

/// Of rows: how many, how many of these within chance, and mean absolute errors of success, percentage points, and under-cutting, mm.
fn errors(rows: &[&PaperRow]) -> [String; 4] {
    let success = mean(rows.iter().map(|row| row.success_error().abs()));
    let under_cutting = mean(rows.iter().filter_map(|row| Some(row.under_cutting_error()?.abs())));
    let within = rows.iter().filter(|row| row.is_within_chance()).count();
    [rows.len().to_string(), within.to_string(), format!("{success:.1}"), format!("{under_cutting:.2}")]
}

fn prediction(text: &mut String, results: &Results) {
    *text += "## Tables 2 and 3, reported and found\n\n";
    *text += &markdown(&paper_table(&results.paper));
    *text += "\n*Within chance*: were the share found the true one, so many successes as reported, or fewer, and so many or more, would each have a chance \
              of 2.5 % at least. Mean absolute errors:\n\n";
    let names = ["rows", "count", "within chance", "success, points", "under-cutting, mm"];
    let mut table = vec![names.map(String::from).to_vec()];
    type Which = fn(&PaperRow) -> bool;
    let kinds: [(&str, Which); 3] = [
        ("Table 2, fitted", |row| row.reported.calibrates),
        ("Table 2, predicted", |row| !row.reported.calibrates && row.reported.table != "3"),
        ("Table 3, predicted", |row| row.reported.table == "3"),
    ];
    for (name, which) in kinds {
        let rows: Vec<&PaperRow> = results.paper.iter().filter(|row| which(row)).collect();
        let mut cells = vec![name.to_string()];
        cells.extend(errors(&rows));
        table.push(cells);
    }
    *text += &markdown(&table);
}

fn ours(text: &mut String, results: &Results) {
    let together = results.ours_together();
    let _ = writeln!(
        text,
        "\n## Keepout in the same place\n\n\
         T is the margin budget of the machine (repeatability ±10 µm, contour error of its drives, resolution, \
         rounding) and the least allowance. {} attempts, **{} incursions**.\n",
        together.attempts,
        together.attempts - together.successes
    );
    *text += &markdown(&results.ours_by_speed());
    *text += "\nBy the delay of the line:\n\n";
    *text += &markdown(&results.ours_by_latency());
    let driven: u64 = results.driven.iter().map(|row| row.found.attempts).sum();
    let _ = write!(
        text,
        "\nThe tool is where the modules' repeatability puts it. In {driven} attempts, at the shortest delay, it is besides moved by their feed drives, \
         with the controller that the budget counts on:\n\n"
    );
    let mut driven = results.clone();
    driven.ours.clone_from(&results.driven);
    *text += &markdown(&driven.ours_by_speed());
}

fn pictures(text: &mut String, scenarios: &Scenarios) {
    *text += "\n## Pictures, in the manner of Fig. 8\n\nBlue: 24 approaches by hand. Green: the planned finishing path, and orange, with Keepout: the one that \
              was cut (\"a\" in Fig. 8). Dark: the profile (\"b\"), which it leaves within the margin.\n\n| paper's controller | Keepout |\n|---|---|\n";
    for shape in &scenarios.profile {
        let name = &shape.name;
        let _ = writeln!(
            text,
            "| ![{0}, the paper's]({FOLDER}/{name}-paper.svg) | ![{0}, ours]({FOLDER}/{name}-ours.svg) |",
            shape.title
        );
    }
}
