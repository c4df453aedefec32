//! Checks that the program accepts every command line in README and in the pages for machinists and
//! integrators.

use std::path::{Path, PathBuf};

use clap::Parser as _;

use super::Arguments;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The lines of a document's shell code blocks.
fn shell_lines(text: &str) -> Vec<&str> {
    let mut in_block = None;
    let mut lines = Vec::new();
    for line in text.lines().map(str::trim) {
        if let Some(kind) = line.strip_prefix("```") {
            in_block = if in_block.is_some() { None } else { Some(kind == "sh") };
        } else if in_block == Some(true) {
            lines.push(line);
        }
    }
    lines
}

/// The arguments of `keepout` in a line. `cargo run` without `-p` also runs it.
fn arguments(line: &str) -> Option<Vec<String>> {
    let line = line.split(" #").next().unwrap_or(line);
    let words: Vec<String> =
        line.split_whitespace().map(|word| word.trim_matches(['"', '\'']).into()).collect();
    match words.first().map(String::as_str) {
        Some("keepout") => Some(words),
        Some("cargo") if words.get(1)? == "run" && !words.iter().any(|word| word == "-p") => {
            let from = words.iter().position(|word| word == "--")?;
            Some(std::iter::once("keepout".into()).chain(words[from + 1..].iter().cloned()).collect())
        }
        _ => None,
    }
}

/// The rejected command lines of a document, each with the reason, and the number of all its command lines.
fn faults(name: &str, text: &str) -> (Vec<String>, usize) {
    let commands: Vec<_> = shell_lines(text).into_iter().filter_map(arguments).collect();
    let fault = |words: &Vec<String>| {
        let error = Arguments::try_parse_from(words).err()?;
        Some(format!("{name}: {}\n{error}", words.join(" ")))
    };
    (commands.iter().filter_map(fault).collect(), commands.len())
}

#[test]
fn command_lines_of_documents_are_accepted() {
    let mut paths = vec![root().join("README.md")];
    for room in ["machinist", "integrator"] {
        let pages = std::fs::read_dir(root().join("docs").join(room)).expect("the room is there");
        paths.extend(pages.map(|entry| entry.expect("an entry").path()));
    }
    let (mut wrong, mut count) = (Vec::new(), 0);
    for path in paths.iter().filter(|path| path.extension().is_some_and(|ending| ending == "md")) {
        let text = std::fs::read_to_string(path).expect("a document is text");
        let (faults, commands) = faults(&path.display().to_string(), &text);
        wrong.extend(faults);
        count += commands;
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(count >= 25, "only {count} command lines were found");
}

#[test]
fn wrong_options_in_documents_are_rejected() {
    let page = "```sh\nkeepout plan part.dxf --tool 6 -o part.plan\nkeepout verify part.plan # again\n\
                cargo run --release -- demo --fast\n```\n```text\nkeepout nothing\n```\n";
    let (wrong, count) = faults("page", page);
    assert_eq!((wrong.len(), count), (2, 3), "{wrong:?}");
}
