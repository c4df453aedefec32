//! Runs all engines: `check [groups]`. Prints each failure and exits with 1.

fn main() {
    let word = std::env::args().nth(1).unwrap_or_default();
    let failures = keepout_proofs::check::failures(&word);
    if failures.is_empty() {
        println!("all hold");
        return;
    }
    failures.iter().for_each(|name| println!("fails: {name}"));
    std::process::exit(1);
}
