//! The page `docs/research/franco-horikawa.md`. It depends only on the scenarios and the results, so a test
//! can generate it again.

use std::cmp::Ordering;
use std::fmt::Write as _;

use keepout_drives::controllers::kind::Kind;
use keepout_planner::Mm2;
use keepout_planner::report::table::markdown;

use super::attempt::real;
use super::brake;
use super::delays::Looked;
use super::finishing::Finished;
use super::invasion::{PointMatrix, mean_operations, of_matrix};
use super::prediction::{mean, prediction};
use super::results::{PaperRow, Results};
use super::scenario::Scenarios;
use super::tables::{paper_table, percent};

/// Folder of the pictures and results, next to the page.
pub const FOLDER: &str = "franco-horikawa";

/// The text of the page.
#[must_use]
pub fn page(scenarios: &Scenarios, results: &Results) -> String {
    let mut text = String::from(HEAD);
    let _ = writeln!(
        text,
        "\n`cargo run --release -p keepout-studies -- franco-horikawa --attempts {} --seed {}`\n\
         made this page, its pictures and its [results](franco-horikawa/results.json).\n",
        results.attempts, results.seed
    );
    summary(&mut text, results);
    text += SETTING;
    shapes(&mut text, scenarios);
    operations(&mut text, scenarios);
    text += include_str!("verdicts.md");
    let _ = writeln!(
        text,
        "\nFigs. 4 to 6, drawn from what the functions compute:\n\n![Figs. 4 to 6]({FOLDER}/checks.svg)"
    );
    delays(&mut text, results);
    text += &prediction(results);
    ours(&mut text, results);
    pictures(&mut text, scenarios);
    let _ = write!(text, "{CLEARING}{}", markdown(&results.clearing_table()));
    roughing(&mut text, scenarios, results);
    let _ = write!(text, "{FINISHING}{}{}", markdown(&results.finishing_table()), finishing_verdict(results));
    let _ = write!(text, "{HANDWHEEL}{}", markdown(&results.handwheel_table()));
    let _ = write!(text, "{}{}", brake::SECTION, markdown(&results.brake_table()));
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

The paper is: L. N. Franco García and O. Horikawa, *Manual and servo assisted, hybrid system for position
control in machine tools*, COBEM 2007. Its operators moved a tool toward the outline of a part with a
joystick. A computer queried the position from the drives' controller, checked it, and sent a stop. The
authors counted how often the tool stayed out of the part, and measured the remaining distance (Tables 2 and
3).
";

const SETTING: &str = "## The set-up

**The paper's controller** exists only in this study (`tests/studies/src/franco_horikawa/paper.rs`). It drives
two simulated modules and can not be selected for a port. We do not have the flow chart (Fig. 7). We read one
round as follows:

1. Query the position.
2. Check the position against the profile, which is enlarged by the tool radius (eqs. (3) to (13)). The check
   selects the segments with the tool in their interval, and computes the distance to them (eq. (2)).
3. Send a stop, or one motion in the direction of the stick.

The other two checks of the paper are the point matrix (eq. (1)) and the sum of angles. They are in
`tests/studies/src/franco_horikawa/invasion/`. Tests show the defects of each check: gaps between points,
distances to the infinite line, acute and inside corners, and the missing side.

**An attempt with the paper's system** begins 8 to 30 mm from the part. A model of an operator jogs. The first
stop ends the attempt, after all motion has ended.

**An attempt with Keepout** begins at the same distances. At more than 20 mm/s it begins up to 90 mm away.
After the guard first clips a jog, the model jogs on for 1 to 6 s and four delays of the line. Then the stick
points at the wall until the tool is at rest.

**Trials without contact.** An operator who does not reach the part in a minute (plus a hundred delays) starts
again, unless the tool was in the part.

**The result.** The exact collision monitor of the simulated machine decides whether the tool entered the
part. It also measures the smallest distance, which is the under-cutting of a success.

The two systems also differ in other points:

| | paper's system | Keepout |
|---|---|---|
| operators | models of people: calm, jittery, straight at the wall, with a stick that sticks \
| the same, random directions, and reversals timed to the wall |
| modules | they follow with a lag and reach their feed at once \
| they accelerate at 600 mm/s² (the thrust of Table 1 at top speed) and repeat to ±10 µm |
| line | like an NSK controller, 9600 baud | GRBL, 9600 baud, with an added delay |

The paper states the number of sides, but no sizes. We chose these shapes
(`tests/studies/src/franco_horikawa/scenarios.toml`):

";

const CLEARING: &str = "
## Time to clear the same stock

An operator goes around the part in three rounds and clears the stock from 8 to 20 mm from the profile. Both
systems allow this. With Keepout the operator then goes around in two more rounds, down to the wall. In the
last round the operator pushes against the wall.

- The operator follows a line at 28 mm/s at most (steering law), also with faster modules. At 1200 mm/s the
  smallest tilt of the stick gives 48 mm/s.
- The stick of the paper's system gives a direction and no speed, so the operator tilts it fully.
- The operator gives a place up if the tool comes no nearer to it for 3 s. False alarms keep the paper's tool
  away from some places.
- The values are means of four runs. The paper's system uses T = 5 mm.
- The missing stock is at corners that the rounds cut short, where the hand deviates, and in inside corners
  that are too small for the tool. Therefore compare the cleared area of far stock per second.

";

const FINISHING: &str = "
## The finishing pass, single and double

The modules of Table 1 follow the finishing toolpath at 12 mm/s, as feed drives with friction and a cutting
force (`keepout-studies compare --machine nsk-modules`). The force at a thickness of 0.5 mm is that of Koren &
Lo's table. It is proportional to the thickness.

- A single pass cuts all the stock that roughing left. For the paper's system this is the mean under-cutting
  of its rows with T of 4 mm and more. For Keepout it is the mean under-cutting of all rows, which is less
  than the stock that a first pass would leave.
- In the double pass of the paper's conclusions, the first pass leaves 0.1 mm. The second pass cuts this stock
  and the contour error of the first pass.
- A first pass with an error above 100 µm may have cut into the part.
- The errors do not include the first half second of a loop.

Both controllers are described in [Koren & Lo](koren-lo.md): the best one of that paper, and ours.

";

const HANDWHEEL: &str = "
## One dimension: the handwheel

This is the system of sections 2 and 3.1. The pulses of a handwheel reach the motor only while the table is in
front of the band T before the barrier. Within the band, only backward pulses pass. The sensor is wired to the
computer, so a round takes only the time of the computation. The wheel turns to 15 mm beyond the barrier, and
then back by 5 mm. Keepout uses the handwheel inputs of its supervisor, over the serial line. *Released*
counts the attempts in which the table followed the wheel back.

";

const ROUGHING: &str = "
## One roughing pass all round the part

Both systems move the same simulated modules here: they accelerate at 600 mm/s², feed drives with friction follow
(`keepout-studies compare --machine nsk-modules`), and they repeat to ±10 µm. Both have a line of 9600 baud. The delays
of the paper's computer, and the length of its motions, are those of the delay model. The lag of its tables is not.

The same operator goes round the part with both. Every 3 mm along the profile, less than the diameter of the tool, the
operator pushes the tool at the part until it comes no nearer for 3 s, and draws it back by 8 mm. *Invasions* counts how
often the tool entered the part. *Stock left* is measured every millimetre along the profile, where the tool can reach
it. It includes the ridges between two approaches.

Reading: after a stop, the paper's controller passes only motions away from the segment, to the tool's side, as section
2 says of its brake, or to a place where its check finds no invasion. A tool behind the line of the segment may move
anywhere. The paper does not say what its prototype did after a stop. Where much stock is left, false alarms kept the
tool away: the line of a segment has no ends.

";

const LIMITS: &str = "
## Results that are reproduced, and results that are not

- **Reproduced:** The success rises with T from rare to nearly always, at both feeds alike. The under-cutting
  grows with T. The errors do not grow with the feed, so a delay of the current motion can not be their cause.
  Motions of a fixed length, one per round of the computation, explain them (the \"unitary movement\" of
  section 3.1). With such motions, one set of values fits both feeds.
- **Not distinguishable:** `cargo run --release -p keepout-studies -- calibrate` lists other sets of values
  that fit nearly as well. All fitted rows of Table 2 (b) are at 12 mm/s. The text of the third check names x
  intervals alone, but the fit prefers x or y intervals. With x intervals alone, the system does not see steep
  sides:

";

const LIMITS_ON: &str = "
- **False alarms:** The distance to the infinite line stops the tool at places without a segment. The paper
  does not mention such stops. We count them separately, and the attempt starts again, unless the tool was in
  the part.
- **Not reproduced:** The smallest under-cutting (0.15 mm at T = 2 mm). Such values are means of one to four
  successes. We also do not reproduce that the under-cutting falls at the higher feed. In the paper it does
  not fall at T = 5 mm either. The original shapes, sizes and operators are unknown.
- The modules of Table 1 may reach 1200 mm/s, but the attempts begin too near to the part for this speed. The
  table of the attempts with drives states the highest jog speed.
- Lines, drives and operators are models. The proofs of Keepout do not depend on them: see `proofs/README.md`.
";

/// Rows of the external triangle at a tolerance, mm.
fn triangle(results: &Results, tolerance_mm: f64) -> Vec<&PaperRow> {
    let rows = results.paper.iter().filter(|row| row.reported.table == "2 (a)");
    rows.filter(|row| (row.reported.tolerance_mm - tolerance_mm).abs() < 1e-9).collect()
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
         | without invasion | triangle: {} % (T = 1 mm), {} % (2 mm), {} % (5 mm) | {} %, {} %, {} % \
         | {} % of {} attempts: all profiles, delays up to {} s each way |\n\
         | mean under-cutting | {left_reported:.2} mm at T = 5 mm | {left_found:.2} mm at T = 5 mm \
         | {:.3} mm, at most {:.3} mm |\n\n\
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
    let mut table = vec![vec!["profile".to_string(), "description".into(), "corners, mm".into()]];
    for shape in &scenarios.profile {
        let corners: Vec<String> = shape.corners.iter().map(|Mm2 { x, y }| format!("({x}, {y})")).collect();
        table.push(vec![shape.name.clone(), shape.title.clone(), corners.join(" ")]);
    }
    *text += &markdown(&table);
}

/// The operations of the three checks for a position.
fn operations(text: &mut String, scenarios: &Scenarios) {
    *text += OPERATIONS;
    let head = ["profile", "points 1 mm apart, eq. (1)", "points 0.1 mm apart", "sum of angles", "eq. (2)"];
    let mut table = vec![head.map(String::from).to_vec()];
    for shape in &scenarios.profile {
        let matrix = |spacing_mm: f64| {
            let points = PointMatrix::new(&shape.corners, spacing_mm).map(|matrix| matrix.points().to_vec());
            let (done, _) = of_matrix(&points.unwrap_or_default(), Mm2::default(), spacing_mm);
            done.total().to_string()
        };
        let [angles, intervals] = mean_operations(&shape.corners).map(|mean| format!("{mean:.0}"));
        table.push(vec![shape.name.clone(), matrix(1.0), matrix(0.1), angles, intervals]);
    }
    *text += &markdown(&table);
}

const OPERATIONS: &str = "
The paper calls the third check the most efficient, because it needs fewer operations, and gives no numbers
(section 5.2). Counted for one position: sums, products, roots, arctangents and comparisons together, the last
two columns as a mean over positions up to 30 mm from the profile
(`tests/studies/src/franco_horikawa/invasion/operations.rs`). An arctangent counts as one operation, although it
takes as long as many sums.

";

fn delays(text: &mut String, results: &Results) {
    let delays = &results.delays;
    let cuts =
        if delays.stop_cuts { "ends the current motion" } else { "lets the current motion run to its end" };
    let looked = match delays.classified {
        Looked::ByX => "by x intervals",
        Looked::ByXOrY => "by x or y intervals",
    };
    let _ = writeln!(
        text,
        "\n## The delay model\n\n\
         Known values:\n\n\
         - The line has {} baud. A query has {} bytes, its answer {}, a motion {}, a stop {}.\n  \
         They are about those of `executor/dialects/nsk-style.toml`.\n\
         - The controller takes {} ms for a line. A stop {cuts}.\n\n\
         Free values, found once by `cargo run --release -p keepout-studies -- calibrate` on the rows\n\
         marked *fitted* (every second row of Table 2). The fit uses the deviance of the successes and the\n\
         mean under-cutting (to 0.25 mm):\n\n\
         - A joystick motion is **{} mm** long. Up to {} are queued behind the current one.\n\
         - A round of the computation takes **{} ms** on average. Half of it is constant, the rest\n  \
         exponentially distributed.\n\
         - The table follows with a time constant of **{} ms**.\n\
         - The check selects segments {looked}.\n",
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

fn ours(text: &mut String, results: &Results) {
    let together = results.ours_together();
    let _ = writeln!(
        text,
        "\n## The experiment with Keepout\n\n\
         T is the margin budget of the machine (repeatability ±10 µm, contour error of its drives,\n\
         resolution, rounding) plus the smallest stock to leave. {} attempts, **{} gouges**.\n",
        together.attempts,
        together.attempts - together.successes
    );
    *text += &markdown(&results.ours_by_speed());
    *text += "\nThe same attempts by the delay of the line:\n\n";
    *text += &markdown(&results.ours_by_latency());
    let driven: u64 = results.driven.iter().map(|row| row.found.attempts).sum();
    let _ = write!(
        text,
        "\nThe simulated tool deviates from its command by the repeatability of the modules. In {driven}\n\
         of the attempts, at the shortest delay, simulated feed drives also move it, with the controller\n\
         that the budget assumes:\n\n"
    );
    let mut driven = results.clone();
    driven.ours.clone_from(&results.driven);
    *text += &markdown(&driven.ours_by_speed());
}

/// Which of the two controllers has the smaller errors, in how many rows.
fn finishing_verdict(results: &Results) -> String {
    let (mut all, mut larger, mut larger_rms) = (0, 0, 0);
    let ours = results.finishing.iter().filter(|row| row.controller == Kind::Contouring.names().1);
    for row in ours {
        let same = |other: &&Finished| {
            (&other.profile, other.passes) == (&row.profile, row.passes)
                && other.stock_mm == row.stock_mm
                && other.controller == Kind::Gpc.names().1
        };
        let Some(gpc) = results.finishing.iter().find(same) else { continue };
        all += 1;
        larger += u32::from(row.max_mm > gpc.max_mm);
        larger_rms += u32::from(row.rms_mm > gpc.rms_mm);
    }
    let better = match (2 * larger).cmp(&all) {
        Ordering::Less => "the contouring MPC is the better controller",
        Ordering::Equal => "neither is the better controller",
        Ordering::Greater => "GPC is the better controller",
    };
    format!(
        "\nThe largest error of the contouring MPC is greater than that of GPC in {larger} of {all} rows, and its \
         RMS error in\n{larger_rms}. A margin covers the largest error, so {better} for these\nmodules. Both are \
         fast here: neither keeps its margins with drives that are 20 % wrong and a command that is\none sample \
         late.\n"
    )
}

/// The roughing passes, with the pictures of the profiles of Fig. 8.
fn roughing(text: &mut String, scenarios: &Scenarios, results: &Results) {
    let _ = write!(text, "{ROUGHING}{}", markdown(&results.roughing_table()));
    *text += "\n| paper's controller | Keepout |\n|---|---|\n";
    for shape in scenarios.of_fig_8() {
        let name = &shape.name;
        let _ = writeln!(
            text,
            "| ![{0}, the paper's pass]({FOLDER}/{name}-pass-paper.svg) \
             | ![{0}, our pass]({FOLDER}/{name}-pass-ours.svg) |",
            shape.title
        );
    }
}

fn pictures(text: &mut String, scenarios: &Scenarios) {
    *text += "\n## Pictures like Fig. 8\n\n\
              Each picture has 24 jogged approaches, and explains its colours. With Keepout it also has the path of\n\
              the tool in finishing (\"a\" in Fig. 8), which agrees with the profile (\"b\") within the margin.\n\n\
              | paper's controller | Keepout |\n|---|---|\n";
    for shape in &scenarios.profile {
        let name = &shape.name;
        let _ = writeln!(
            text,
            "| ![{0}, the paper's]({FOLDER}/{name}-paper.svg) | ![{0}, ours]({FOLDER}/{name}-ours.svg) |",
            shape.title
        );
    }
}
