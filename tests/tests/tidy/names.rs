//! One name, one type; and coordinates have a type.

use std::collections::BTreeMap;

use crate::source::{Exceptions, Offender, judge, product, sources};

/// Names of more than one type.
const SHARED: &Exceptions = &[("Xy", "a pair of plain numbers, each for one module or test crate")];

/// Places whose public signatures may have two bare reals.
const BARE_PAIRS: &Exceptions = &[
    ("planner/src/report", "pixels of a page"),
    ("executor/cli/src/view/canvas.rs", "dots of the screen"),
    ("planner/src/drawing/entity.rs", "fields of the file, in its own unit"),
    ("planner/src/drawing/placement.rs", "columns and rows of an array"),
    ("tests/src/feel/trace.rs", "a median and a percentile"),
    ("tests/studies/src", "ranges of distances"),
    ("tests/peers", "plain numbers, as the other libraries take them"),
    ("tests/tests/findings/dxf.rs", "plain numbers of a small drawing, as its text has them"),
    ("fuzz/src", "plain numbers of an oracle, and of a sketch before it is a drawing"),
    ("proofs/src/oracle.rs", "plain numbers of an oracle"),
];

#[test]
fn public_signatures_name_their_coordinates() {
    let mut offenders = Vec::new();
    for (file, text) in &sources("") {
        for (number, line) in product(text) {
            let is_public = ["pub ", "pub(crate) "].iter().any(|start| line.trim_start().starts_with(start));
            let mut pairs = line.match_indices("(f64, f64)").map(|(at, _)| &line[..at]);
            // A function that takes two numbers, such as `Fn(f64, f64)`, has no pair.
            if is_public && pairs.any(|before| !before.ends_with(char::is_alphanumeric)) {
                offenders.push(Offender::at(file, number, line.trim()));
            }
        }
    }
    judge("Two reals in a public signature are a `Mm2` or a `Vec2`", &offenders, BARE_PAIRS);
}

/// The public type that a line declares. A `pub(super)` type belongs to its folder alone and does not count.
fn declared(line: &str) -> Option<&str> {
    let line = line.trim_start();
    let line = line.strip_prefix("pub ").or_else(|| line.strip_prefix("pub(crate) "))?;
    let name = ["struct ", "enum ", "trait ", "type "].iter().find_map(|kind| line.strip_prefix(kind))?;
    name.split(|c: char| !(c.is_alphanumeric() || c == '_')).next()
}

#[test]
fn public_types_have_different_names() {
    let sources = sources("");
    // The files that declare a name, each with the line of the first declaration.
    let mut places: BTreeMap<&str, BTreeMap<&str, usize>> = BTreeMap::new();
    for (file, text) in &sources {
        for (line, name) in
            product(text).into_iter().filter_map(|(number, line)| Some((number, declared(line)?)))
        {
            places.entry(name).or_default().entry(file).or_insert(line);
        }
    }
    assert!(places.len() > 300, "only {} types were found", places.len());
    let shared = places.into_iter().filter(|(_, files)| files.len() > 1);
    let offender = |(name, files): (&str, BTreeMap<&str, usize>)| {
        let files: Vec<_> = files.iter().map(|(file, line)| format!("{file}:{line}")).collect();
        Offender { subject: name.into(), fault: format!("{name}: {}", files.join(", ")) }
    };
    let offenders: Vec<_> = shared.map(offender).collect();
    judge("No two public types have the same name", &offenders, SHARED);
}

#[test]
fn declarations_of_public_types_are_noticed() {
    let lines = [
        ("pub struct Point(i32);", Some("Point")),
        ("    pub(crate) enum Side {", Some("Side")),
        ("pub trait Draw: Sized {", Some("Draw")),
        ("pub type Pair<T> = (T, T);", Some("Pair")),
        ("pub(super) struct Room;", None),
        ("struct Own;", None),
        ("pub fn struct_of() {}", None),
    ];
    for (line, name) in lines {
        assert_eq!(declared(line), name);
    }
}
