//! Mutated logs: bytes of the file, and contents under right checksums.

use fastrand::Rng;
use serde_json::{Value, json};

use crate::honest::HonestSession;
use crate::lines::{contents, edit, event, log_of};

/// A mutated log.
pub struct Mutant {
    /// What was changed.
    pub kind: &'static str,
    pub bytes: Vec<u8>,
}

/// Changes some lines. Returns `false` if it finds nothing to change.
type Change = fn(&mut Vec<String>, &mut Rng) -> bool;

const CHANGES: [(&str, Change); 17] = [
    ("target moved", |lines, random| with_jog(lines, random, move_target)),
    ("target alone moved", |lines, random| {
        with_jog(lines, random, |jog, random| moved(&mut jog["to"], random))
    }),
    ("set point moved", |lines, random| with_jog(lines, random, move_set_point)),
    ("set point removed", |lines, random| with_jog(lines, random, remove_set_point)),
    ("set point added", |lines, random| with_jog(lines, random, add_set_point)),
    ("jog's height", |lines, random| {
        with_jog(lines, random, |jog, random| height(jog, ["height", "lowest"], random))
    }),
    ("motion moved", |lines, random| with_contour(lines, random, move_curve)),
    ("motion's end moved", |lines, random| with_contour(lines, random, move_end)),
    ("motion's kind", |lines, random| with_contour(lines, random, other_kind)),
    ("motion's height", |lines, random| {
        with_contour(lines, random, |motion, random| height(motion, ["from", "to"], random))
    }),
    ("feed", |lines, random| with_certificate(lines, random, feed)),
    ("form", |lines, random| with_certificate(lines, random, form)),
    ("sent text", |lines, random| digit_in(lines, random, "sent")),
    ("received text", |lines, random| digit_in(lines, random, "received")),
    ("line order", line_order),
    ("header", |lines, random| header(lines, random)),
    ("time", |lines, random| time(lines, random)),
];

/// A mutant of a session's log.
pub fn mutate(session: &HonestSession, random: &mut Rng) -> Mutant {
    if random.u8(0..10) == 0 {
        return mutate_bytes(&session.log, random);
    }
    let mut lines = contents(&session.log);
    loop {
        let (kind, change) = CHANGES[random.usize(0..CHANGES.len())];
        if change(&mut lines, random) {
            return Mutant { kind, bytes: log_of(&lines) };
        }
    }
}

/// Bits flipped, or the end cut off.
fn mutate_bytes(log: &[u8], random: &mut Rng) -> Mutant {
    let mut bytes = log.to_vec();
    if random.bool() {
        bytes.truncate(random.usize(0..bytes.len()));
        return Mutant { kind: "end cut off", bytes };
    }
    for _ in 0..random.usize(1..4) {
        let at = random.usize(0..bytes.len());
        bytes[at] ^= 1 << random.u8(0..8);
    }
    Mutant { kind: "bits flipped", bytes }
}

/// A plan file with a byte changed, removed or added.
pub fn mutate_plan(plan: &[u8], random: &mut Rng) -> Vec<u8> {
    let mut bytes = plan.to_vec();
    let at = random.usize(0..bytes.len());
    match random.u8(0..4) {
        0 => drop(bytes.remove(at)),
        1 => bytes.insert(at, random.u8(..)),
        2 => bytes.truncate(at),
        _ => bytes[at] ^= 1 << random.u8(0..8),
    }
    bytes
}

/// A vector of 1 unit to 3 mm. Short ones are as likely as long ones.
fn vector(random: &mut Rng) -> [i64; 2] {
    let length = (random.f64() * f64::from(300_000).ln()).exp();
    let (sine, cosine) = (random.f64() * std::f64::consts::TAU).sin_cos();
    #[expect(clippy::cast_possible_truncation, reason = "at most 300,000")]
    let [dx, dy] = [length * cosine, length * sine].map(|c| c.round() as i64);
    if [dx, dy] == [0, 0] { [1, 0] } else { [dx, dy] }
}

fn add(coordinate: &mut Value, step: i64) {
    *coordinate = json!(coordinate.as_i64().unwrap_or(0) + step);
}

/// Moves a point, or each point of a list of coordinates, by one vector.
fn move_by(coordinates: &mut Value, by: [i64; 2]) {
    for (index, coordinate) in coordinates.as_array_mut().into_iter().flatten().enumerate() {
        add(coordinate, by[index % 2]);
    }
}

fn moved(point: &mut Value, random: &mut Rng) -> bool {
    move_by(point, vector(random));
    true
}

fn with_certificate(
    lines: &mut [String],
    random: &mut Rng,
    change: fn(&mut Value, &mut Rng) -> bool,
) -> bool {
    let kind = if random.bool() { "jog" } else { "contour" };
    with(lines, random, kind, change)
}

fn with_jog(lines: &mut [String], random: &mut Rng, change: fn(&mut Value, &mut Rng) -> bool) -> bool {
    with(lines, random, "jog", change)
}

fn with_contour(lines: &mut [String], random: &mut Rng, change: fn(&mut Value, &mut Rng) -> bool) -> bool {
    with(lines, random, "contour", change)
}

/// Changes a certificate of this kind.
fn with(
    lines: &mut [String],
    random: &mut Rng,
    kind: &str,
    change: fn(&mut Value, &mut Rng) -> bool,
) -> bool {
    let wanted = format!("\"certificate\":{{\"{kind}\"");
    let found: Vec<usize> = (1..lines.len()).filter(|&at| lines[at].contains(&wanted)).collect();
    let Some(&at) = found.get(random.usize(0..found.len().max(1))) else { return false };
    let mut changed = false;
    edit(&mut lines[at], |line| changed = change(&mut line["event"]["certificate"][kind], random));
    changed
}

/// Moves the target, and the target in the set.
fn move_target(jog: &mut Value, random: &mut Rng) -> bool {
    let (by, target) = (vector(random), jog["to"].clone());
    move_by(&mut jog["to"], by);
    for point in jog["set"].as_array_mut().into_iter().flatten().filter(|point| **point == target) {
        move_by(point, by);
    }
    true
}

fn points(jog: &mut Value) -> &mut Vec<Value> {
    jog["set"].as_array_mut().unwrap()
}

fn move_set_point(jog: &mut Value, random: &mut Rng) -> bool {
    let points = points(jog);
    let at = random.usize(0..points.len());
    moved(&mut points[at], random)
}

fn remove_set_point(jog: &mut Value, random: &mut Rng) -> bool {
    let points = points(jog);
    points.remove(random.usize(0..points.len()));
    true
}

fn add_set_point(jog: &mut Value, random: &mut Rng) -> bool {
    let points = points(jog);
    let mut point = points[random.usize(0..points.len())].clone();
    move_by(&mut point, vector(random));
    points.push(point);
    true
}

fn height(certificate: &mut Value, names: [&str; 2], random: &mut Rng) -> bool {
    let name = names[random.usize(0..2)];
    let [step, _] = vector(random);
    let mut height = certificate.get(name).cloned().unwrap_or(json!(0));
    add(&mut height, if step == 0 { -1 } else { step });
    certificate[name] = height;
    true
}

/// The name of a motion's curve, its ends, and the centre of an arc.
fn curve(motion: &mut Value) -> (String, Vec<&mut Value>) {
    let (name, value) = motion["curve"].as_object_mut().unwrap().iter_mut().next().unwrap();
    let name = name.clone();
    if name == "line" {
        (name, vec![value])
    } else {
        (name, value.as_array_mut().unwrap().iter_mut().collect())
    }
}

fn move_curve(motion: &mut Value, random: &mut Rng) -> bool {
    let by = vector(random);
    curve(motion).1.into_iter().for_each(|points| move_by(points, by));
    true
}

fn move_end(motion: &mut Value, random: &mut Rng) -> bool {
    let (_, mut lists) = curve(motion);
    let list = random.usize(0..lists.len());
    let coordinates = lists[list].as_array_mut().unwrap();
    let at = random.usize(0..coordinates.len());
    add(&mut coordinates[at], vector(random)[0]);
    true
}

/// An arc the other way, an arc as a line, or a line that runs back.
fn other_kind(motion: &mut Value, random: &mut Rng) -> bool {
    let (name, lists) = curve(motion);
    let lists: Vec<Value> = lists.into_iter().map(|list| list.clone()).collect();
    let changed = match (name.as_str(), random.bool()) {
        ("line", _) => {
            let ends = lists[0].as_array().unwrap();
            json!({ "line": [ends[2], ends[3], ends[0], ends[1]] })
        }
        ("clockwise", true) => json!({ "counterclockwise": lists }),
        ("counterclockwise", true) => json!({ "clockwise": lists }),
        _ => json!({ "line": lists[0] }),
    };
    motion["curve"] = changed;
    true
}

fn feed(certificate: &mut Value, random: &mut Rng) -> bool {
    certificate["feed_mm_min"] = json!(random.i64(-1..700_000));
    true
}

/// Breaks the form of a certificate, or changes it without a meaning.
fn form(certificate: &mut Value, random: &mut Rng) -> bool {
    let fields: Vec<String> = certificate.as_object().unwrap().keys().cloned().collect();
    let name = &fields[random.usize(0..fields.len())];
    match random.u8(0..6) {
        0 => drop(certificate.as_object_mut().unwrap().remove(name)),
        1 => {
            let value = certificate.as_object_mut().unwrap().remove(name).unwrap();
            certificate[format!("{name}s")] = value;
        }
        2 => certificate[name] = json!(1.5),
        3 => certificate[name] = json!(1_i64 << random.u8(28..40)),
        4 => certificate["comment"] = json!("all is well"),
        _ => certificate[name] = Value::Null,
    }
    true
}

/// Changes a digit in a text of the serial line.
fn digit_in(lines: &mut [String], random: &mut Rng, name: &str) -> bool {
    let found: Vec<usize> = (1..lines.len()).filter(|&at| event(&lines[at]) == name).collect();
    for _ in 0..20 {
        let Some(&at) = found.get(random.usize(0..found.len().max(1))) else { return false };
        let begins = lines[at].find("\"event\"").unwrap_or(0);
        let digits: Vec<usize> =
            (begins..lines[at].len()).filter(|&index| lines[at].as_bytes()[index].is_ascii_digit()).collect();
        if let Some(&index) = digits.get(random.usize(0..digits.len().max(1))) {
            lines[at].replace_range(index..=index, &random.u8(0..10).to_string());
            return true;
        }
    }
    false
}

/// Drops, swaps or doubles lines.
fn line_order(lines: &mut Vec<String>, random: &mut Rng) -> bool {
    let of_motions = random.bool();
    let wanted = |line: &String| !of_motions || ["certificate", "sent", "phase"].contains(&event(line));
    let found: Vec<usize> = (1..lines.len() - 1).filter(|&at| wanted(&lines[at])).collect();
    let Some(&at) = found.get(random.usize(0..found.len().max(1))) else { return false };
    match random.u8(0..4) {
        0 => drop(lines.remove(at)),
        1 => lines.swap(at, at + 1),
        2 => lines.insert(at, lines[at].clone()),
        _ => {
            let other = lines[random.usize(1..lines.len())].clone();
            lines.insert(at, other);
        }
    }
    true
}

fn header(lines: &mut [String], random: &mut Rng) -> bool {
    edit(&mut lines[0], |header| match random.u8(0..12) {
        0 => {
            let mut hash = header["plan"].as_str().unwrap().to_string();
            let at = random.usize(0..hash.len());
            hash.replace_range(at..=at, &random.u8(0..10).to_string());
            header["plan"] = json!(hash);
        }
        1 => move_by(&mut header["offset"], vector(random)),
        2 => header["dialect"] = json!(["grbl", "grblhal", "zaber", "venus", "klingon"][random.usize(0..5)]),
        3 => header["keepout_log"] = json!(random.u8(0..6)),
        4 => drop(header.as_object_mut().unwrap().remove("z")),
        5 => header["z"] = json!({ "zero": -random.i32(0..9_000_000), "lowest": -9_000_000, "highest": 0 }),
        6 => header["description"] = json!("00"),
        7 => header["feed_mm_min"] = json!(random.u32(1..9999)),
        8 => header["began"] = json!("yesterday"),
        9 => header["comment"] = json!("all is well"),
        10 => drop(header.as_object_mut().unwrap().remove("operator")),
        _ => header["home"] = json!(true),
    });
    true
}

fn time(lines: &mut [String], random: &mut Rng) -> bool {
    let at = random.usize(1..lines.len());
    edit(&mut lines[at], |line| add(&mut line["at_us"], vector(random)[0]));
    true
}
