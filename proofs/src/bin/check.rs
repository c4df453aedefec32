//! Runs all engines up to the first failure: `check [groups]`. Prints the failure and exits with 1.

fn main() {
    let word = std::env::args().nth(1).unwrap_or_default();
    match keepout_proofs::check::first_failure(&word) {
        None => println!("all hold"),
        Some(name) => {
            println!("fails: {name}");
            std::process::exit(1);
        }
    }
}
