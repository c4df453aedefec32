//! The job: a small plate, a hand that pushes at it, and what is kept of what was said.

use std::path::{Path, PathBuf};

use keepout_executor::dialect::DialectName;
use keepout_executor::supervisor::PreparedPlan;
use keepout_planner::machine::MachineProfile;
use keepout_planner::plan::PassParameters;
use keepout_planner::plan_file;
use keepout_planner::request::PlanRequest;

/// Toward the plate, let go on the way, on to its wall, let go, and touch it.
pub const SCRIPT: &str = "0 0 -0.05\n0.4 0 0\n1 0 -0.5\n2.5 0 0\n3 0 -0.1 auto\n";
/// Machine coordinates of the drawing's origin, mm: the tool stands above the middle of the plate's upper edge.
pub const ORIGIN_MM: (f64, f64) = (-26.0, -30.0);
/// Where it stands, machine coordinates, mm.
pub const START_MM: (f64, f64) = (-20.0, -12.0);
/// Feed of the contour, mm/min.
pub const FEED_MM_MIN: u32 = 1500;
/// Added delay each way, ms.
pub const LATENCY_MS: u64 = 1;

/// A language at a baud rate.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// A built-in language, or a file's name without its end.
    language: &'static str,
    pub baud: u32,
}

impl Case {
    pub fn all() -> Vec<Self> {
        let languages = DialectName::NAMES.into_iter().chain(["nsk-style", "tango"]);
        let cases =
            languages.flat_map(|language| [9600, 38_400, 115_200].map(|baud| Self { language, baud }));
        cases.collect()
    }

    /// The same at another rate.
    pub fn at(self, baud: u32) -> Self {
        Self { baud, ..self }
    }

    pub fn name(&self) -> String {
        format!("{}-{}", self.language, self.baud)
    }

    /// As `--dialect` takes it.
    pub fn dialect(&self) -> String {
        if DialectName::NAMES.contains(&self.language) {
            return self.language.into();
        }
        format!("{}/../dialects/{}.toml", env!("CARGO_MANIFEST_DIR"), self.language)
    }

    /// Axes that run apart can not follow slanted walls: they leave stock.
    fn needs_stock(&self) -> bool {
        !DialectName::NAMES.contains(&self.language)
    }
}

/// The plans, in a folder.
pub struct Job {
    folder: PathBuf,
    bare: PreparedPlan,
    stock: PreparedPlan,
}

impl Job {
    pub fn new(name: &str) -> Self {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("baud-rates-{name}"));
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join("script"), SCRIPT).unwrap();
        let plan = |file: &str, stock_mm: f64| {
            let mut order = PlanRequest::default();
            order.job.tool_diameter_mm = 3.0;
            if stock_mm > 0.0 {
                order.job.passes = vec![PassParameters { stock_to_leave_mm: stock_mm, feed_mm_min: None }];
            }
            let machine = MachineProfile::simulated();
            let plan = order.plan("plate.dxf", include_bytes!("plate.dxf"), &machine, &mut |_| {}).unwrap();
            plan_file::save(&plan.plan, &folder.join(file)).unwrap();
            PreparedPlan::new(plan)
        };
        Self { bare: plan("bare.plan", 0.0), stock: plan("stock.plan", 0.15), folder }
    }

    /// A file of this job's own.
    pub fn at(&self, name: &str) -> String {
        self.folder.join(name).display().to_string()
    }

    pub fn work(&self, case: Case) -> PreparedPlan {
        if case.needs_stock() { self.stock.clone() } else { self.bare.clone() }
    }

    pub fn plan_file(&self, case: Case) -> String {
        self.at(if case.needs_stock() { "stock.plan" } else { "bare.plan" })
    }
}

/// Where a transcript is kept.
pub fn kept(folder: &str, case: Case) -> PathBuf {
    let transcripts = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/transcripts").join(folder);
    transcripts.join(format!("{}.txt", case.name()))
}

/// Writes a transcript anew, when that is wanted.
pub fn write(path: &Path, said: &str) -> Result<bool, String> {
    if std::env::var_os("KEEPOUT_WRITE_TRANSCRIPTS").is_none() {
        return Ok(false);
    }
    std::fs::write(path, said).map(|()| true).map_err(|error| format!("{}: {error}", path.display()))
}

/// Compares what was said with what is kept, line by line.
pub fn compare(path: &Path, said: &str) -> Result<(), String> {
    if write(path, said)? {
        return Ok(());
    }
    let kept = std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
    if kept == said {
        return Ok(());
    }
    let (mut ours, mut theirs) = (said.lines(), kept.lines());
    for number in 1.. {
        let (ours, theirs) = (ours.next(), theirs.next());
        if ours != theirs {
            return Err(format!("line {number}: said {ours:?}, kept {theirs:?}"));
        }
        if ours.is_none() {
            break;
        }
    }
    Err("their line ends differ".into())
}
