//! The trusted code is short and plain.

use crate::source::{Exceptions, Offender, judge, product, sources};

/// What every certified motion rests on. The mesh, the offsets' proposals and the indexes' proposals are not
/// here: they are checked.
const TRUSTED: [&str; 9] = [
    "kernel/src/exact",
    "kernel/src/index/check.rs",
    "kernel/src/index/query.rs",
    "kernel/src/index/cells.rs",
    "kernel/src/clear.rs",
    "kernel/src/levels.rs",
    "kernel/src/simplify.rs",
    "kernel/src/offset/certify.rs",
    "executor/guard/src",
];

/// The trusted files at these places, without their tests: no product is built with those.
fn trusted(places: &[&str]) -> Vec<(String, String)> {
    places.iter().flat_map(|place| sources(place)).filter(|(name, _)| !name.ends_with("tests.rs")).collect()
}

#[test]
fn trusted_lines_are_fewer_than_4500() {
    let (mut code, mut all) = (0, 0);
    for (_, text) in trusted(&TRUSTED) {
        let lines = product(&text).into_iter().map(|(_, line)| line.trim());
        let lines: Vec<_> = lines.filter(|line| !line.is_empty()).collect();
        code += lines.iter().filter(|line| !line.starts_with("//")).count();
        all += lines.len();
    }
    println!("{code} lines of code, {all} with comments");
    assert!(code < 4500, "{code} trusted lines of code, {all} with comments");
}

/// Whether the text names the word, not as a part of a longer one.
fn names(text: &str, word: &str) -> bool {
    let part = |c: char| c.is_alphanumeric() || c == '_';
    text.match_indices(word)
        .any(|(at, _)| !text[..at].ends_with(part) && !text[at + word.len()..].starts_with(part))
}

#[test]
fn trusted_crates_name_no_float() {
    let mut offenders = Vec::new();
    for (file, text) in trusted(&["kernel/src/exact", "executor/guard/src"]) {
        let floats =
            |line: &str| ["f32", "f64"].into_iter().filter(|float| names(line, float)).collect::<Vec<_>>();
        for (number, line) in product(&text) {
            offenders.extend(
                floats(line).iter().map(|float| Offender::at(&file, number, format_args!("names {float}"))),
            );
        }
    }
    judge("The exact geometry and the guard name no float", &offenders, &[]);
}

#[test]
fn trusted_files_name_no_geometry_in_f64() {
    let mut offenders = Vec::new();
    for (file, text) in trusted(&TRUSTED) {
        for (number, line) in product(&text) {
            let found = ["ArcView", "arc_view", "Vec2", "vec2"].into_iter().filter(|word| names(line, word));
            offenders.extend(found.map(|word| Offender::at(&file, number, format_args!("names {word}"))));
        }
    }
    judge("Trusted files do not rest on arcs and vectors in f64", &offenders, &[]);
}

/// A public function of the trusted code.
struct Function<'a> {
    name: &'a str,
    /// The number of its line.
    line: usize,
    /// Its parameters without `self`, as written.
    parameters: Vec<&'a str>,
}

/// The end of a bracketed text that begins at the first character.
fn closing(text: &str) -> usize {
    let mut depth = 0;
    let mut before = ' ';
    for (at, c) in text.char_indices() {
        match c {
            '(' | '[' | '{' | '<' => depth += 1,
            ')' | ']' | '}' => depth -= 1,
            '>' if before != '-' => depth -= 1,
            _ => {}
        }
        if depth == 0 {
            return at;
        }
        before = c;
    }
    text.len()
}

/// The parts of a text between commas outside brackets.
fn parts(text: &str) -> Vec<&str> {
    let mut parts = Vec::new();
    let (mut begin, mut at) = (0, 0);
    while let Some(found) = text[at..].find([',', '(', '[', '{', '<']) {
        at += found;
        if text[at..].starts_with(',') {
            parts.push(&text[begin..at]);
            begin = at + 1;
            at += 1;
        } else {
            at += closing(&text[at..]) + 1;
        }
        at = at.min(text.len());
    }
    parts.push(&text[begin..]);
    parts.into_iter().map(str::trim).filter(|part| !part.is_empty()).collect()
}

/// The functions of a file that are `pub` or `pub(crate)`.
fn functions(text: &str) -> Vec<Function<'_>> {
    let mut functions = Vec::new();
    let mut begin = 0;
    for (number, line) in text.split_inclusive('\n').enumerate() {
        let rest = &text[begin..];
        begin += line.len();
        let declaration = line.trim_start();
        let public = declaration.strip_prefix("pub ").or_else(|| declaration.strip_prefix("pub(crate) "));
        let Some(head) = public.map(|rest| rest.strip_prefix("const ").unwrap_or(rest)) else { continue };
        let Some(head) = head.strip_prefix("fn ") else { continue };
        let head = &rest[line.len() - head.len()..];
        let name = &head[..head.find(['(', '<']).unwrap_or(0)];
        let mut head = &head[name.len()..];
        if head.starts_with('<') {
            head = &head[closing(head) + 1..];
        }
        let mut parameters = parts(&head[1..closing(head)]);
        let is_self = |one: &&str| one.split(':').next().is_some_and(|name| names(name, "self"));
        parameters.retain(|one| !is_self(one));
        functions.push(Function { name, line: number + 1, parameters });
    }
    functions
}

/// What is wrong with the parameters of a function.
fn faults(function: &Function<'_>) -> Vec<String> {
    let mut faults = Vec::new();
    if function.parameters.len() > 4 {
        faults.push(format!("{} parameters", function.parameters.len()));
    }
    for parameter in &function.parameters {
        let kind = parameter.rsplit_once(": ").map_or(*parameter, |(_, kind)| kind);
        // The parentheses of a function's type make no tuple.
        let calls = ["Fn(", "FnMut(", "FnOnce(", "fn("].iter().any(|call| kind.contains(call));
        if kind == "bool" || kind.contains('(') && !calls {
            faults.push(format!("parameter `{parameter}`"));
        }
    }
    faults
}

/// Functions with other parameters than the rule has it.
const OTHER_PARAMETERS: &Exceptions = &[
    ("kernel/src/exact/predicate.rs/near_if", "owed: `Proximity` from a condition"),
    ("kernel/src/exact/predicate.rs/box_segment", "owed: a box, a segment and a radius"),
    ("kernel/src/exact/predicate.rs/on_ring", "owed"),
    ("kernel/src/exact/predicate.rs/ahead", "owed"),
];

#[test]
fn trusted_functions_have_four_plain_parameters() {
    let mut offenders = Vec::new();
    for (file, text) in trusted(&TRUSTED) {
        for function in functions(&text) {
            let wrong = faults(&function);
            let (name, line) = (function.name, function.line);
            let fault = format!("{file}:{line}: {name}: {}", wrong.join(", "));
            let offender = Offender { subject: format!("{file}/{name}"), fault };
            offenders.extend((!wrong.is_empty()).then_some(offender));
        }
    }
    let rule = "A public trusted function has at most four parameters, no `bool` and no tuple among them";
    judge(rule, &offenders, OTHER_PARAMETERS);
}

#[test]
fn too_many_flags_and_tuples_are_noticed() {
    let faults = |text: &str| functions(text).iter().map(|one| faults(one).len()).collect::<Vec<_>>();
    assert_eq!(faults("pub fn a(&mut self, a: A<B, C>, b: &[D], c: E, d: F) -> (A, B) {}"), [0]);
    assert_eq!(
        faults("    pub(crate) const fn a<L: Lattice>(\n  a: A, b: B, c: C, d: D, e: bool,\n) {}"),
        [2]
    );
    assert_eq!(faults("pub fn a(mut self: Self, (a, b): (A, B), c: Vec<(A, B)>)\npub fn b(a: bool)"), [2, 1]);
    assert_eq!(faults("pub fn a(ask: impl Fn(&A, B) -> bool)\nfn b(a: bool)"), [0]);
}
