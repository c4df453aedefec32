//! Joins pages, comments, lists of evidence and the results of the seeded faults.

use std::path::{Path, PathBuf};
use std::{fs, io};

use super::source::{self, EVIDENCE, IMPLEMENTS, SourceFile, code_digest};
use super::{EvidenceKind, Mechanism, SafetyTrace, SeenTexts, TracedEvidence, TracedFault, statements};
use crate::faults::results::{self, FaultFate, FaultRow};
use crate::faults::{self, FaultEngine, SeededFault};
use crate::theorems::THEOREMS;
use crate::{check, mutants, properties, smt, worlds};

/// The folders of the product.
const PRODUCT: [&str; 3] = ["kernel/src", "planner", "executor"];
/// Further folders with tests.
const TESTS: [&str; 5] = ["kernel/tests", "tests/src", "tests/tests", "proofs/tests", "fuzz/tests"];
/// What explores the worlds.
const EXPLORATION: &str = "proofs/src/invariant";
/// The soaks.
const SOAKS: &str = "proofs/src/soak.rs";
/// The list of fuzz targets.
const FUZZ: &str = "fuzz/src/lib.rs";
/// The file with the fuzz target that runs the properties.
const PROPERTY_OF_BYTES: &str = "proofs/src/lib.rs";
/// The program of the hostile simulation.
const HOSTILE: &str = "tests/src/bin/hostile/main.rs";
/// The folders of its sources.
const HOSTILE_SOURCES: [&str; 2] = ["tests/src/bin/hostile", "tests/src/hostile"];

/// Reads the trace of the workspace at this root.
///
/// # Errors
/// When a page, a source or the results cannot be read.
pub fn read(root: &Path) -> io::Result<SafetyTrace> {
    let mut product = Vec::new();
    for folder in PRODUCT {
        product.extend(source::files(root, folder)?);
    }
    let evidence = evidence(root, &product)?;
    let rows = results::read();
    Ok(SafetyTrace {
        statements: statements::read(root)?,
        mechanisms: product.iter().flat_map(mechanisms).collect(),
        faults: faults::catalogue()?.iter().map(|fault| traced(fault, &rows, &evidence)).collect(),
        evidence,
        seen: SeenTexts::read(root),
        trusted: mutants::files(root)?.into_iter().chain(marked(&product)).collect(),
    })
}

/// The files whose head says that they are trusted.
fn marked(product: &[SourceFile]) -> impl Iterator<Item = PathBuf> + '_ {
    product.iter().filter(|file| file.text.starts_with("//! TRUSTED")).map(|file| file.path.clone())
}

fn mechanisms(file: &SourceFile) -> Vec<Mechanism> {
    let whole = source::of_file(&file.text, IMPLEMENTS);
    let whole = (!whole.is_empty()).then_some((None, whole));
    let items = source::tied_items(&file.text, IMPLEMENTS).into_iter().map(|(item, ids)| (Some(item), ids));
    whole
        .into_iter()
        .chain(items)
        .map(|(item, requirements)| Mechanism { file: file.path.clone(), item, requirements })
        .collect()
}

/// Where the names of a list of evidence are, and how they stand there.
struct Listed {
    kind: EvidenceKind,
    folder: &'static str,
    form: fn(&str) -> Vec<String>,
    names: Vec<(&'static str, bool)>,
}

fn lists() -> io::Result<[Listed; 5]> {
    let theorems = smt::results::read(&faults::workspace().join("proofs/results/theorems.tsv"))?;
    let runs = |name: &str| theorems.iter().any(|row| row.theorem == name && row.paths > 0);
    Ok([
        Listed {
            kind: EvidenceKind::Theorem,
            folder: "proofs/src/theorems",
            form: |name| vec![format!("\"{name}\"")],
            names: THEOREMS.iter().map(|each| (each.name, runs(each.name))).collect(),
        },
        Listed {
            kind: EvidenceKind::Property,
            folder: "proofs/src/properties",
            form: |name| vec![format!("    {name} |")],
            names: properties::all().into_iter().map(|each| (each.name, true)).collect(),
        },
        Listed {
            kind: EvidenceKind::Soak,
            folder: "proofs/src",
            form: |name| vec![format!("(\"{name}\", ")],
            names: check::SOAKS.iter().map(|(name, _)| (*name, true)).collect(),
        },
        Listed {
            kind: EvidenceKind::Harness,
            folder: "proofs/harnesses/src",
            form: |name| vec![format!("        {name}:")],
            names: keepout_harnesses::all().into_iter().map(|each| (each.name, true)).collect(),
        },
        Listed {
            kind: EvidenceKind::World,
            folder: "proofs/src/worlds",
            form: |name| vec![format!("\"{name}\"")],
            names: worlds::all().into_iter().map(|each| (each.name, true)).collect(),
        },
    ])
}

fn evidence(root: &Path, product: &[SourceFile]) -> io::Result<Vec<TracedEvidence>> {
    let mut found = Vec::new();
    let proofs = source::files(root, "proofs/src")?;
    for list in lists()? {
        let files = source::files(root, list.folder)?;
        for (name, runs_code) in &list.names {
            let forms = (list.form)(name);
            let place = files.iter().find_map(|file| Some((file, source::line_of(&file.text, &forms)?)));
            let (file, requirements, text) = match place {
                Some((file, line)) => (
                    file.path.clone(),
                    source::of_listed(&file.text, line, EVIDENCE),
                    text_of(list.kind, name, (file, line), &proofs),
                ),
                None => (PathBuf::from(list.folder), Vec::new(), String::new()),
            };
            found.push(TracedEvidence {
                kind: list.kind,
                name: (*name).into(),
                file,
                requirements,
                runs_code: *runs_code,
                digest: code_digest(&text),
            });
        }
    }
    let mut others = Vec::new();
    for folder in TESTS {
        others.extend(source::files(root, folder)?);
    }
    for file in product.iter().chain(&others) {
        found.extend(source::tests(file).into_iter().map(|test| TracedEvidence {
            kind: EvidenceKind::Test,
            name: test.name,
            file: file.path.clone(),
            requirements: test.requirements,
            runs_code: true,
            digest: code_digest(&test.text),
        }));
    }
    found.extend(targets(root)?);
    let text = fs::read_to_string(root.join(HOSTILE))?;
    let mut sources = Vec::new();
    for folder in HOSTILE_SOURCES {
        sources.extend(source::files(root, folder)?);
    }
    let sources: Vec<&str> = sources.iter().map(|file| file.text.as_str()).collect();
    found.push(TracedEvidence {
        kind: EvidenceKind::Hostile,
        name: "hostile".into(),
        file: HOSTILE.into(),
        requirements: source::of_file(&text, EVIDENCE),
        runs_code: true,
        digest: code_digest(&sources.concat()),
    });
    Ok(found)
}

/// The text of a piece of evidence of a list. Of a property or a harness: its entry and what that names in its file. Of
/// a soak: the same in the file of soaks. Of a theorem: its file. Of a world: its value, and what explores it.
fn text_of(
    kind: EvidenceKind,
    name: &str,
    (file, line): (&SourceFile, usize),
    proofs: &[SourceFile],
) -> String {
    let under = |place: &str| {
        let files = proofs.iter().filter(|file| file.path.starts_with(place));
        files.map(|file| file.text.as_str()).collect::<Vec<_>>()
    };
    let entry = || source::item_at(&file.text, line);
    match kind {
        EvidenceKind::Theorem => file.text.clone(),
        EvidenceKind::World => {
            let value = worlds::all().into_iter().find(|world| world.name == name);
            [format!("{value:?}"), under(EXPLORATION).concat()].concat()
        }
        EvidenceKind::Soak => source::with_helpers(entry(), &under(SOAKS)),
        _ => source::with_helpers(entry(), &[&file.text]),
    }
}

/// The fuzz targets: the names of a list, one in a line.
fn targets(root: &Path) -> io::Result<Vec<TracedEvidence>> {
    let mut files = source::files(root, "fuzz/src")?;
    files.retain(|file| !file.path.ends_with(FUZZ));
    let properties = fs::read_to_string(root.join(PROPERTY_OF_BYTES))?;
    let text = fs::read_to_string(root.join(FUZZ))?;
    let files: Vec<&str> = files.iter().map(|file| file.text.as_str()).chain([&*properties]).collect();
    let lines: Vec<&str> = text.lines().collect();
    let begin = lines.iter().position(|line| line.contains("TARGETS: &[Target] = ")).unwrap_or(lines.len());
    let listed = lines.iter().enumerate().skip(begin + 1).take_while(|(_, line)| !line.starts_with(']'));
    let named = listed.filter(|(_, line)| !line.trim_start().starts_with("//"));
    let evidence = named.map(|(line, entry)| {
        let name = entry.trim().trim_end_matches(',');
        // One target has another name where it is declared.
        let renamed = text.lines().find(|line| line.ends_with(&format!(" as {name};"))).unwrap_or(name);
        TracedEvidence {
            kind: EvidenceKind::Fuzz,
            name: name.into(),
            file: FUZZ.into(),
            requirements: source::of_listed(&text, line, EVIDENCE),
            runs_code: true,
            digest: code_digest(&source::with_helpers(renamed.into(), &files)),
        }
    });
    Ok(evidence.collect())
}

fn traced(fault: &SeededFault, rows: &[FaultRow], evidence: &[TracedEvidence]) -> TracedFault {
    let of = |engine: FaultEngine| results::row(rows, fault, engine);
    let mut noticed: Vec<(EvidenceKind, String)> = Vec::new();
    let mut seconds = None;
    for engine in fault.engines() {
        let Some(row) = of(engine) else { continue };
        let FaultFate::Noticed(names) = &row.fate else { continue };
        seconds = seconds.into_iter().chain([row.seconds]).min();
        for name in names {
            let it = identified(engine, name, fault, evidence);
            noticed.extend(it.into_iter().filter(|it| !noticed.contains(it)).collect::<Vec<_>>());
        }
    }
    TracedFault {
        name: fault.name.clone(),
        requirement: fault.requirement.clone(),
        files: fault.edits().map(|edit| edit.file).collect(),
        settled: results::is_settled(rows, fault),
        noticed,
        equivalent: fault.equivalent.clone(),
        seconds,
    }
}

/// The evidence that a name in the results stands for.
pub(super) fn identified(
    engine: FaultEngine,
    name: &str,
    fault: &SeededFault,
    evidence: &[TracedEvidence],
) -> Option<(EvidenceKind, String)> {
    let known = |kind: EvidenceKind, name: &str| {
        evidence.iter().any(|each| each.kind == kind && each.name == name).then(|| (kind, name.to_string()))
    };
    let name = name.trim_end_matches(" (it does not end)");
    match engine {
        FaultEngine::Hostile => known(EvidenceKind::Hostile, "hostile"),
        FaultEngine::Fuzz => known(EvidenceKind::Fuzz, fault.fuzz.as_ref()?.target.as_str()),
        FaultEngine::Theorem => known(EvidenceKind::Theorem, name),
        FaultEngine::Model => known(EvidenceKind::Harness, name.split(' ').next()?),
        FaultEngine::Proofs | FaultEngine::Tests => {
            let world = name.strip_prefix("invariant: ").and_then(|name| known(EvidenceKind::World, name));
            let harness = name.strip_prefix("harness: ").unwrap_or(name);
            let last = harness.rsplit("::").next()?;
            world
                .or_else(|| known(EvidenceKind::Soak, name))
                .or_else(|| known(EvidenceKind::Property, name.rsplit("::").next()?))
                .or_else(|| known(EvidenceKind::Harness, last))
                .or_else(|| known(EvidenceKind::Test, last))
        }
    }
}
