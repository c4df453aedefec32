//! The job of the baud-rate tests: a small plate, an operator script, and the kept transcripts.

use std::path::{Path, PathBuf};

use keepout_executor::dialect::DialectName;
use keepout_executor::supervisor::PreparedPlan;
use keepout_planner::Mm2;
use keepout_planner::machine::MachineProfile;
use keepout_planner::plan::PassParameters;
use keepout_planner::plan_file;
use keepout_planner::request::PlanRequest;

/// Operator script: jog toward the plate, release, jog to its wall, release, and start the contour by
/// contact.
pub const SCRIPT: &str = "0 0 -0.05\n0.4 0 0\n1 0 -0.5\n2.5 0 0\n3 0 -0.1 auto\n";
/// Machine coordinates of the drawing's origin, mm. The tool starts above the middle of the plate's upper
/// edge.
pub const ORIGIN_MM: Mm2 = Mm2::new(-26.0, -30.0);
/// Start position of the tool, machine coordinates, mm.
pub const START_MM: Mm2 = Mm2::new(-20.0, -12.0);
/// Feed of the contour, mm/min.
pub const FEED_MM_MIN: u32 = 1500;
/// Added delay each way, ms.
pub const LATENCY_MS: u64 = 1;

/// A dialect at a baud rate.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// A built-in dialect, or the name of a dialect file without its extension.
    dialect: &'static str,
    pub baud: u32,
}

impl Case {
    pub fn all() -> Vec<Self> {
        let dialects = DialectName::NAMES.into_iter().chain(["nsk-style", "tango"]);
        let cases = dialects.flat_map(|dialect| [9600, 38_400, 115_200].map(|baud| Self { dialect, baud }));
        cases.collect()
    }

    /// The same dialect at another baud rate.
    pub fn at(self, baud: u32) -> Self {
        Self { baud, ..self }
    }

    pub fn name(&self) -> String {
        format!("{}-{}", self.dialect, self.baud)
    }

    /// The value of `--dialect`.
    pub fn dialect(&self) -> String {
        if DialectName::NAMES.contains(&self.dialect) {
            return self.dialect.into();
        }
        format!("{}/../dialects/{}.toml", env!("CARGO_MANIFEST_DIR"), self.dialect)
    }

    /// Whether the plan leaves stock. Non-interpolated axes cannot follow slanted walls.
    fn needs_stock(&self) -> bool {
        !DialectName::NAMES.contains(&self.dialect)
    }
}

/// The plans of the job, in a folder of its own.
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
            let mut request = PlanRequest::default();
            request.job.tool_diameter_mm = 3.0;
            if stock_mm > 0.0 {
                request.job.passes = vec![PassParameters { stock_to_leave_mm: stock_mm, feed_mm_min: None }];
            }
            let machine = MachineProfile::simulated();
            let plan = request.plan("plate.dxf", include_bytes!("plate.dxf"), &machine, &mut |_| {}).unwrap();
            plan_file::save(&plan.plan, &folder.join(file)).unwrap();
            PreparedPlan::new(plan)
        };
        Self { bare: plan("bare.plan", 0.0), stock: plan("stock.plan", 0.15), folder }
    }

    /// The path of a file in the job's folder.
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

/// The path of a kept transcript.
pub fn kept(folder: &str, case: Case) -> PathBuf {
    let transcripts = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/transcripts").join(folder);
    transcripts.join(format!("{}.txt", case.name()))
}

/// Writes a transcript if `KEEPOUT_WRITE_TRANSCRIPTS` is set. Returns whether it did.
pub fn write(path: &Path, transcript: &str) -> Result<bool, String> {
    if std::env::var_os("KEEPOUT_WRITE_TRANSCRIPTS").is_none() {
        return Ok(false);
    }
    std::fs::write(path, transcript).map(|()| true).map_err(|error| format!("{}: {error}", path.display()))
}

/// Compares a transcript with the kept one, line by line.
pub fn compare(path: &Path, transcript: &str) -> Result<(), String> {
    if write(path, transcript)? {
        return Ok(());
    }
    let kept = std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
    if kept == transcript {
        return Ok(());
    }
    let (mut ours, mut theirs) = (transcript.lines(), kept.lines());
    for number in 1.. {
        let (ours, theirs) = (ours.next(), theirs.next());
        if ours != theirs {
            return Err(format!(
                "line {number}: the session has {ours:?}, the kept transcript has {theirs:?}"
            ));
        }
        if ours.is_none() {
            break;
        }
    }
    Err("the line ends differ".into())
}
