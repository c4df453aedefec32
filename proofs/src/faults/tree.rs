//! Copies of the tree with faults in them. The tree itself is never touched.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::{fs, io};

use super::{Edit, SEEDED, SeededFault, workspace};

/// The variable that holds the number of the seeded fault, from 1 on; without it no fault is seeded.
pub const SWITCH: &str = "KEEPOUT_SEEDED_FAULT";

/// Added to the copy of the kernel, which every crate of the product depends on.
const SWITCH_CODE: &str = "
extern crate std;

static SEEDED: std::sync::OnceLock<usize> = std::sync::OnceLock::new();

/// Whether it is this fault's turn.
#[must_use]
pub fn seeded(number: usize) -> bool {
    let chosen = || std::env::var(\"KEEPOUT_SEEDED_FAULT\").ok().and_then(|text| text.parse().ok()).unwrap_or(0);
    *SEEDED.get_or_init(chosen) == number
}
";

/// Brings the copy under `tree` up to the workspace, with one fault in it.
///
/// # Errors
/// When the tree cannot be copied, or an edit's place is not there once.
pub fn seed_one(tree: &Path, fault: &SeededFault) -> io::Result<()> {
    copy_with(tree, edited([(fault, Switch::Always)].into_iter())?)
}

/// Brings the copy under `tree` up to the workspace, with all switched faults in it. A fault's number is
/// its place in the catalogue, from 1 on.
///
/// # Errors
/// When the tree cannot be copied, or an edit's place is not there once.
pub fn seed_switched(tree: &Path, catalogue: &[SeededFault]) -> io::Result<()> {
    let numbered = catalogue.iter().zip((1..).map(Switch::Number));
    let mut files = edited(numbered.filter(|(fault, _)| fault.is_switched()))?;
    let kernel = PathBuf::from("kernel/src/lib.rs");
    let text = files.remove(&kernel).map_or_else(|| fs::read_to_string(workspace().join(&kernel)), Ok)?;
    files.insert(kernel, text + SWITCH_CODE);
    copy_with(tree, files)
}

/// The files that faults change, with all of them in it.
///
/// # Errors
/// When a file cannot be read, or an edit's place is not there once.
pub fn seeded_files(faults: &[SeededFault]) -> io::Result<BTreeMap<PathBuf, String>> {
    edited(faults.iter().map(|fault| (fault, Switch::Always)))
}

/// When a fault is there.
#[derive(Clone, Copy)]
enum Switch {
    Always,
    /// While the program runs under this number.
    Number(usize),
}

fn edited<'a>(
    faults: impl Iterator<Item = (&'a SeededFault, Switch)>,
) -> io::Result<BTreeMap<PathBuf, String>> {
    let mut files: BTreeMap<PathBuf, String> = BTreeMap::new();
    for (fault, switch) in faults {
        for edit in fault.edits() {
            let text = match files.remove(&edit.file) {
                Some(text) => text,
                None => fs::read_to_string(workspace().join(&edit.file))?,
            };
            let kernel = if edit.file.starts_with("kernel") { "crate" } else { "keepout_kernel" };
            let switch = match switch {
                Switch::Always => "true".into(),
                Switch::Number(number) => format!("{kernel}::seeded({number})"),
            };
            let text = replace(&text, fault, &edit, &switch)?;
            files.insert(edit.file, text);
        }
    }
    Ok(files)
}

/// Brings the copy under `tree` up to the workspace, but for these files, whose texts are given.
///
/// # Errors
/// When the tree cannot be copied.
pub fn copy_with(tree: &Path, files: BTreeMap<PathBuf, String>) -> io::Result<()> {
    copy_but(&workspace(), tree, &files.keys().map(|file| tree.join(file)).collect())?;
    files.iter().try_for_each(|(file, text)| write_changed(&tree.join(file), text.as_bytes()))
}

/// The text with one edit made, in which `seeded` reads `switch`.
fn replace(text: &str, fault: &SeededFault, edit: &Edit, switch: &str) -> io::Result<String> {
    if text.matches(&edit.find).count() != 1 {
        let file = edit.file.display();
        return Err(io::Error::other(format!("{}: its place in {file} is not there once", fault.name)));
    }
    Ok(text.replacen(&edit.find, &edit.with.replace(SEEDED, switch), 1))
}

/// Copies the files that are missing or differ, so that little is built again, and removes those that
/// the source lacks. Leaves the files of the copy that are `kept`.
fn copy_but(from: &Path, to: &Path, kept: &BTreeSet<PathBuf>) -> io::Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(to)? {
        let path = entry?.path();
        if path.file_name().is_some_and(|name| !from.join(name).exists()) {
            if path.is_dir() { fs::remove_dir_all(path)? } else { fs::remove_file(path)? }
        }
    }
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        let name = entry.file_name();
        if name == "target" || name.to_string_lossy().starts_with('.') {
            continue;
        }
        let target = to.join(&name);
        if entry.file_type()?.is_dir() {
            copy_but(&entry.path(), &target, kept)?;
        } else if !kept.contains(&target) {
            write_changed(&target, &fs::read(entry.path())?)?;
        }
    }
    Ok(())
}

/// Writes a file that is missing or differs.
fn write_changed(path: &Path, bytes: &[u8]) -> io::Result<()> {
    if fs::read(path).is_ok_and(|there| there == bytes) { Ok(()) } else { fs::write(path, bytes) }
}

#[cfg(test)]
mod tests {
    use super::super::catalogue;
    use super::*;

    /// A change of the code moves the places of faults. This test says so at once, and not hours later.
    #[test]
    fn every_fault_has_its_place_once() {
        for fault in catalogue().expect("the catalogue is read") {
            seeded_files(&[fault]).expect("its place is there once");
        }
    }
}
