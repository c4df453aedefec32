//! Plans and logs.

use keepout_executor::session::log::{Log, LogReadError};
use keepout_executor::session::replay::replay;
use keepout_executor::session::{Certificate, LoggedEvent, page_of_log, picture_of_log};
use keepout_executor::supervisor::Phase;
use keepout_planner::plan_file;
use keepout_proofs::properties::Xy;
use keepout_proofs::square::plain;

use crate::import::{CURVES_MAX, edges, told};
use crate::session::watch::{ROUNDING, comes_near, ends_of_edges, keep_away, triangles};
use crate::{job, oracle};

/// Any bytes as a plan file, or as what one holds behind its hash: a typed error, or a plan, which certification refuses or
/// believes; what it believes keeps the tool out of the part, by another's eyes, and its texts can be printed.
///
/// # Panics
/// When it believes what does not, or when a plan changes on its way to a file and back.
pub fn plan_file(bytes: &[u8]) {
    let whole = if bytes.starts_with(b"KEEPOUT PLAN") { bytes.to_vec() } else { sealed(bytes) };
    let plan = match plan_file::decode(&whole) {
        Ok(plan) => plan,
        Err(error) => return told(&error.to_string()),
    };
    let stored = plan_file::encode(&plan).expect("a plan in memory can be written");
    let again = plan_file::decode(&stored).expect("what was written can be read");
    assert_eq!(plan_file::encode(&again).expect("as before"), stored, "the plan changed in its file");
    let curves: usize =
        plan.passes.iter().flat_map(|pass| &pass.path.loops).map(|each| each.curves.len()).sum();
    if edges(&plan.profile).max(edges(&plan.zones)).max(curves) > CURVES_MAX {
        return;
    }
    match plan.certify() {
        Ok(certified) => {
            let plan = &certified.plan;
            let terms = plan.budget.terms.iter().map(|term| &term.source);
            let texts = terms.chain([&plan.provenance.name, &plan.provenance.unit, &plan.machine.name]);
            let lines: Vec<&String> = texts.filter(|text| text.contains(char::is_control)).collect();
            assert!(lines.is_empty(), "printed beside what was proved: {lines:?}");
            oracle::watch(&certified, None);
        }
        Err(error) => told(&error.to_string()),
    }
}

/// The bytes behind the head and the hash of a plan file.
fn sealed(payload: &[u8]) -> Vec<u8> {
    let mut bytes = b"KEEPOUT PLAN".to_vec();
    bytes.extend(plan_file::VERSION.to_le_bytes());
    bytes.extend(plan_file::hash(payload));
    bytes.extend(payload);
    bytes
}

/// Any bytes as a log, and as a log's lines without their checksums, which are added: a typed error with the line, or a session
/// that is played again. What it says was sent is certified, by another's eyes, and no bit of it can be changed unnoticed.
///
/// # Panics
/// When one of these does not hold.
pub fn session_log(bytes: &[u8]) {
    let _ = certificates_of_log(bytes);
}

/// What [`session_log`] looks at: how many certificates a log has that plays again.
///
/// # Panics
/// As [`session_log`].
#[must_use]
pub fn certificates_of_log(bytes: &[u8]) -> usize {
    if let Err(error) = Log::parse(bytes) {
        told(&error.to_string());
    }
    let summed = summed(bytes);
    let log = match Log::parse(&summed) {
        Ok(log) => log,
        Err(error) => {
            told(&error.to_string());
            return 0;
        }
    };
    is_not_changed_unnoticed(&summed, bytes.len());
    match replay(&log, job::work()) {
        Ok(played) => {
            told(&played.end().to_string());
            assert!(picture_of_log(&log.header, &played).starts_with("<svg"));
            assert!(page_of_log(&log.header, &played, "fuzz.log", 0).contains("<html"));
            watch(&log)
        }
        Err(error) => {
            told(&error.to_string());
            0
        }
    }
}

/// Lines of a log without their checksums, each with the checksum over itself and the line before, and the plan `@` made the hash
/// of the plan that [`job::work`] has.
fn summed(lines: &[u8]) -> Vec<u8> {
    let mut sum = 0_u32;
    let mut out = Vec::with_capacity(2 * lines.len());
    for line in lines.split_inclusive(|&byte| byte == b'\n') {
        let whole = line.strip_suffix(b"\n").and_then(|line| line.strip_prefix(b"{"));
        let Some(rest) = whole else {
            out.extend(line);
            break;
        };
        let rest = named(rest);
        let mut hasher = crc32fast::Hasher::new();
        hasher.update(&sum.to_le_bytes());
        hasher.update(&rest);
        sum = hasher.finalize();
        out.extend(format!("{{\"crc\":\"{sum:08x}\",").bytes());
        out.extend(&rest);
        out.push(b'\n');
    }
    out
}

fn named(line: &[u8]) -> Vec<u8> {
    const PLACE: &[u8] = b"\"plan\":\"@\"";
    match line.windows(PLACE.len()).position(|window| window == PLACE) {
        Some(at) if line.starts_with(b"\"keepout_log\"") => {
            let plan = format!("\"plan\":\"{}\"", job::hash());
            [&line[..at], plan.as_bytes(), &line[at + PLACE.len()..]].concat()
        }
        _ => line.to_vec(),
    }
}

fn is_not_changed_unnoticed(log: &[u8], which: usize) {
    let Some(end) = log.iter().rposition(|&byte| byte == b'\n') else { return };
    let (at, bit) = (which * 7 % end, which % 8);
    let mut changed = log.to_vec();
    changed[at] ^= 1 << bit;
    let error = Log::parse(&changed).expect_err("a bit was changed");
    assert!(!matches!(error, LogReadError::Read { .. }), "{error}");
}

/// What was certified is clear of the part: all that could be executed with a jog, and each motion of a contour. Ways out of the part's
/// threshold come nearer to nothing, which is looked at elsewhere; they stay out of the part. How many there are.
fn watch(log: &Log) -> usize {
    let plan = &job::work().plan;
    let walls = ends_of_edges(&plan.part);
    let is_way_out = |event: &LoggedEvent<'_>| match event {
        LoggedEvent::Phase { phase, .. } => Some(*phase == Phase::Escaping),
        _ => None,
    };
    // What was sent is of the phase that is logged last, or of the next.
    let (mut last, mut count) = (false, 0);
    for (at, entry) in log.entries.iter().enumerate() {
        let mut next = log.entries[at..].iter().filter_map(|entry| is_way_out(&entry.event));
        let escapes = last || next.next() == Some(true);
        last = is_way_out(&entry.event).unwrap_or(last);
        let LoggedEvent::Certificate(certificate) = &entry.event else { continue };
        count += 1;
        match certificate {
            Certificate::Jog { to, set, .. } => {
                let kept = if escapes { plan.plan.tool_radius } else { plan.roughing };
                let kept = i64::from(kept.units()) - 3;
                let set: Vec<Xy> = set.iter().chain([to]).map(|&point| plain(point)).collect();
                let set = if escapes { &set[set.len() - 1..] } else { &set };
                let near = triangles(set)
                    .find(|corners| walls.iter().any(|&(d, e)| comes_near(*corners, d, e, kept)));
                assert!(near.is_none(), "a jog to {to:?}: {near:?} comes nearer than {kept}");
            }
            Certificate::Contour { curve, .. } => {
                let kept = f64::from(plan.finishing.units()) - ROUNDING;
                keep_away(curve, &oracle::places(curve), kept);
            }
        }
    }
    count
}
