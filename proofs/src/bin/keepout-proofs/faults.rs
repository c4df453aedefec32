//! `faults`: the seeded faults of the catalogue, each of which must be noticed.

use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use keepout_campaigns::{ItemOutcome, Shard, ShardOptions, ShardRecord, ShardResults};
use keepout_proofs::faults::results::{self, FaultRow};
use keepout_proofs::faults::run::Workshop;
use keepout_proofs::faults::{self, FaultEngine, SeededFault};
use keepout_proofs::trace;

/// Which faults to seed, and where the copies lie.
#[derive(Debug, clap::Args)]
pub struct SeededFaults {
    /// The folder of the copies and their builds; default: a folder for temporary files.
    folder: Option<PathBuf>,
    /// Only the fault of this number, from 1 on.
    #[arg(long, value_name = "N")]
    only: Option<usize>,
    /// Only the fault of this name.
    #[arg(long, value_name = "NAME")]
    named: Option<String>,
    /// From this number on.
    #[arg(long, value_name = "N")]
    from: Option<usize>,
    /// Only faults that change this file, or a file in this folder.
    #[arg(long, value_name = "FILE")]
    file: Option<PathBuf>,
    /// Only faults in the kernel.
    #[arg(long)]
    kernel: bool,
    /// Only faults that go into one copy: parts of the guard, under the worlds and the hostile simulation.
    #[arg(long)]
    switched: bool,
    /// Only faults that are not settled yet.
    #[arg(long)]
    left: bool,
    /// Minutes of hostile simulation for one fault.
    #[arg(long, default_value_t = 4.0)]
    minutes: f64,
    /// Print the numbers and names of the chosen faults, and run none.
    #[arg(long)]
    list: bool,
    /// Enter the rows of these results files into the table of faults, and run none.
    #[arg(long, value_name = "FILE", num_args = 1.., conflicts_with = "list")]
    take: Vec<PathBuf>,
    #[command(flatten)]
    shard: ShardOptions,
}

impl SeededFaults {
    /// Runs them and prints a line for each. The exit code says whether all faults of the catalogue are settled. For a
    /// shard, or with `--results`, it says whether all faults that ran are settled.
    pub fn run(&self) -> ExitCode {
        super::code(self.try_run())
    }

    fn try_run(&self) -> io::Result<bool> {
        let (catalogue, known) = (faults::catalogue()?, results::read());
        let chosen = |number: usize, engine| self.chooses(number, &catalogue[number - 1], engine, &known);
        if self.list {
            for (number, fault) in (1..).zip(&catalogue) {
                for engine in fault.engines().into_iter().filter(|engine| chosen(number, *engine)) {
                    println!("{number}\t{}\t{}", fault.name, engine.name());
                }
            }
            return Ok(true);
        }
        let evidence = trace::read(&faults::workspace())?.evidence;
        for path in &self.take {
            let taken = ShardResults::read(path).map_err(io::Error::other)?;
            let mut rows = taken.rows.iter().filter_map(|row| FaultRow::of_field(&row.detail));
            rows.try_for_each(|row| trace::keep(row, &evidence))?;
        }
        let runs =
            |number: usize| catalogue[number - 1].engines().into_iter().any(|engine| chosen(number, engine));
        if self.named.is_some() && !(1..=catalogue.len()).any(runs) {
            let remedy =
                "Copy it from faults.toml. For fuzz targets: `cargo run -p keepout-fuzz --example seeded`";
            return Err(io::Error::other(format!("no fault of that name can run here. {remedy}")));
        }
        let mut record = super::begin(&self.shard, self.folder.as_deref().map(Path::as_os_str).as_slice())?;
        if self.take.is_empty() {
            let workshop = Workshop { folder: &self.folder(), minutes: self.minutes };
            workshop.run(&catalogue, chosen, |number, row| {
                self.note(number, &row, &mut record);
                if self.shard.results.is_some() { Ok(()) } else { trace::keep(row, &evidence) }
            })?;
        }
        if self.is_part() {
            return super::finish(record);
        }
        let rows = results::read();
        let open: Vec<_> = catalogue.iter().filter(|fault| !results::is_settled(&rows, fault)).collect();
        open.iter().for_each(|fault| println!("not noticed, or not run: {}", fault.name));
        Ok(open.is_empty())
    }

    /// Whether this run is a part of a campaign. Then it does not judge the whole catalogue.
    fn is_part(&self) -> bool {
        self.shard.results.is_some() || self.shard.shard != Shard::WHOLE
    }

    fn chooses(&self, number: usize, fault: &SeededFault, engine: FaultEngine, known: &[FaultRow]) -> bool {
        let settled = results::row(known, fault, engine).is_some_and(|row| row.fate.is_settled());
        engine != FaultEngine::Fuzz
            && self.shard.shard.takes(number as u64 - 1)
            && self.only.is_none_or(|only| only == number)
            && self.named.as_ref().is_none_or(|name| fault.name == *name)
            && self.from.is_none_or(|from| number >= from)
            && (!self.left || !settled)
            && self.file.as_ref().is_none_or(|place| fault.edits().any(|edit| edit.file.starts_with(place)))
            && (!self.kernel || fault.is_in_kernel())
            && (!self.switched || fault.is_switched() && engine.runs_switched())
    }

    /// The folder of the copies. Shards on one machine do not share it.
    fn folder(&self) -> PathBuf {
        let shard = self.shard.shard;
        let name = match shard {
            Shard::WHOLE => "keepout-faults".into(),
            _ => format!("keepout-faults-{}-of-{}", shard.index(), shard.of()),
        };
        self.folder.clone().unwrap_or_else(|| std::env::temp_dir().join(name))
    }

    /// Notes a row for the results file.
    fn note(&self, number: usize, row: &FaultRow, record: &mut ShardRecord) {
        let outcome = if row.fate.is_settled() { ItemOutcome::Held } else { ItemOutcome::Failed };
        let again = format!("faults --only {number} --minutes {}", self.minutes);
        record.row(outcome, &format!("{number} {}: {}", row.engine, row.name), &row.field(), &again);
        record.total(&format!("faults under {}", row.engine), 1);
    }
}
