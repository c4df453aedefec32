//! Runs mutants: `mutants FOLDER [--only N | --from N | --kernel | --left]`; the folder holds the copy and what is built of it.

use std::path::PathBuf;

use keepout_proofs::mutants;

fn main() -> std::io::Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let folder = words.first().map_or_else(|| std::env::temp_dir().join("keepout-mutants"), PathBuf::from);
    let value = |name: &str| {
        let at = words.iter().position(|word| word == name)?;
        words.get(at + 1)?.parse::<usize>().ok()
    };
    let (only, from) = (value("--only"), value("--from"));
    let left = words.iter().any(|word| word == "--left");
    let kernel = words.iter().any(|word| word == "--kernel");
    let (list, known) = (mutants::list()?, mutants::results());
    mutants::run(&folder, |number| {
        let mutant = &list[number];
        only.is_none_or(|only| only == number)
            && from.is_none_or(|from| number >= from)
            && (!left || !known.iter().any(|result| result.what == mutant.what && result.fate == "killed"))
            && (!kernel || mutant.file.starts_with("kernel"))
    })
}
