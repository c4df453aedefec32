//! The paths of a command: no output overwrites an input.

use std::path::{Path, PathBuf};

use super::CliError;

/// Refuses an output that is also an input, or that two outputs share.
pub fn refuse_same(inputs: &[&Path], outputs: &[&Path]) -> Result<(), CliError> {
    let read: Vec<PathBuf> = inputs.iter().filter_map(|input| std::fs::canonicalize(input).ok()).collect();
    let mut written: Vec<PathBuf> = Vec::new();
    for output in outputs {
        let place = place_of(output);
        let reason = match (read.contains(&place), written.contains(&place)) {
            (true, _) => "is an input, so it is not overwritten. Choose another output.",
            (_, true) => {
                "is given for two outputs: one would overwrite the other. Choose another path for one of \
                 them."
            }
            _ => {
                written.push(place);
                continue;
            }
        };
        return Err(CliError::Argument(format!("{} {reason}", output.display())));
    }
    Ok(())
}

/// The paths that are present.
pub fn given<'a>(paths: &[Option<&'a PathBuf>]) -> Vec<&'a Path> {
    paths.iter().flatten().map(|path| path.as_path()).collect()
}

/// The canonical path of a file that exists, or will exist.
fn place_of(path: &Path) -> PathBuf {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let there = || Some(std::fs::canonicalize(folder).ok()?.join(path.file_name()?));
    std::fs::canonicalize(path).ok().or_else(there).unwrap_or_else(|| path.to_path_buf())
}
