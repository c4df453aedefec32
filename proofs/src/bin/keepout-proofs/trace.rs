//! `trace`: writes the pages of the safety trace.

use std::process::ExitCode;

use keepout_planner::file::write_whole;
use keepout_proofs::{faults, trace};

/// Whether the pages are written.
#[derive(Debug, clap::Args)]
pub struct TracePages {
    /// Only lists the gaps, and writes nothing.
    #[arg(long)]
    check: bool,
}

impl TracePages {
    /// Writes the pages and lists the gaps. The exit code is 0 if there is no gap.
    pub fn run(&self) -> ExitCode {
        super::code(self.try_run())
    }

    fn try_run(&self) -> std::io::Result<bool> {
        let root = faults::workspace();
        let found = trace::read(&root)?;
        let gaps = found.gaps();
        gaps.iter().for_each(|gap| println!("{gap}"));
        if !self.check {
            for (name, text) in trace::page::pages(&found).map_err(std::io::Error::other)? {
                write_whole(&root.join("docs/safety").join(name), text.as_bytes())?;
            }
        }
        println!("{} gaps", gaps.len());
        Ok(gaps.is_empty())
    }
}
