//! The workbench: what the panel asks of the program, step by step of a job. The program implements it.

use serde::{Deserialize, Serialize};

/// The steps of a job, in order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum JobStep {
    /// The drawing.
    #[default]
    Drawing,
    /// The tool and the machine.
    Tool,
    /// Where the part lies.
    Place,
    /// Roughing by hand.
    Rough,
    /// The finishing contours.
    Finish,
    /// The report.
    Report,
}

/// A polyline or a polygon of the map, mm: x and y in turn.
pub type MapLine = Vec<f32>;

/// The map of a job: what the pictures show, as lines.
#[derive(Clone, Debug, Default, Serialize)]
pub struct MapView {
    /// The box of the map, mm: low x, low y, high x, high y.
    pub bounds: [f64; 4],
    /// Faces of the part, the highest last, each with its height, mm.
    pub faces: Vec<(f64, Vec<MapLine>)>,
    /// Keep-out zones.
    pub zones: Vec<MapLine>,
    /// The rest material that the tool cannot reach, with the depth, mm.
    pub rest: Vec<(f64, Vec<MapLine>)>,
    /// The finishing contours, with the number of the contour and the depth of the pass, mm.
    pub contours: Vec<(usize, f64, MapLine)>,
    /// Lines of the drawing that are not the part's.
    pub left_out: Vec<MapLine>,
    /// Radius of the tool, mm. `None` before the tool is chosen.
    pub tool_radius_mm: Option<f64>,
}

/// What a person wants to know of a plan.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct PlanView {
    /// Distance that the tool keeps from the part for all errors, mm.
    pub margin_mm: f64,
    /// The terms of the margin: name and size, mm.
    pub terms: Vec<(String, f64)>,
    /// Time of the finishing contours at their feeds, min.
    pub minutes: f64,
    /// Number of contours along which the tool does not fit.
    pub short: usize,
    /// Diameter of the largest tool that fits along all of these, mm.
    pub fits_mm: Option<f64>,
}

/// A problem of a drawing, as a pin on the map.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PinView {
    /// Its place, mm.
    pub at_mm: Option<[f64; 2]>,
    /// What is wrong.
    pub text: String,
    /// The remedy that one button does. `None` when the drawing must be mended.
    pub remedy: Option<RemedyView>,
}

/// A remedy of the program.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct RemedyView {
    /// The button's text.
    pub text: String,
    /// What the button asks for.
    pub request: BenchRequest,
}

/// A contour of the job.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ContourView {
    /// Its number in the drawing.
    pub number: usize,
    /// Its name.
    pub name: String,
    /// The raised tool can cross to its middle, and lower there.
    pub opens: bool,
    /// Its fate.
    pub state: ContourState,
}

/// The fate of a contour.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ContourState {
    /// It is to be cut.
    ToDo,
    /// A part of it is cut.
    Begun,
    /// It is cut.
    Cut,
    /// The tool does not fit.
    NotReached,
}

/// The job, as the page shows it.
#[derive(Clone, Debug, Default, Serialize)]
pub struct JobView {
    /// The names of the jobs in the folder.
    pub jobs: Vec<String>,
    /// The job that is open.
    pub name: Option<String>,
    /// The step that is due.
    pub step: JobStep,
    /// Size of the part, mm.
    pub size_mm: Option<[f64; 2]>,
    /// Problems of the drawing.
    pub pins: Vec<PinView>,
    /// The contours.
    pub contours: Vec<ContourView>,
    /// Rows of figures of the plan: name and value.
    pub figures: Vec<(String, String)>,
    /// The plan, once it is made.
    pub plan: Option<PlanView>,
    /// Whether the part is around its contours, and the tool inside them.
    pub inside: bool,
    /// Names of the machines.
    pub machines: Vec<String>,
    /// Serial ports of this computer.
    pub ports: Vec<String>,
    /// The dialects that a new machine can have.
    pub dialects: Vec<String>,
    /// The machine of the job.
    pub machine: String,
    /// Diameter of the tool, mm.
    pub tool_mm: Option<f64>,
    /// The places to touch, each with its words, in the order of the touches; then the number of those taken.
    pub touches: (Vec<TouchView>, usize),
    /// Where the drawing's origin probably lies while the operator touches off, machine coordinates, mm. The session
    /// then states the machine's own coordinates.
    pub shift_mm: [f64; 2],
    /// Whether the place of the part is known.
    pub aligned: bool,
    /// Whether a session runs, and what for.
    pub running: Option<SessionKind>,
    /// The last message: what went wrong, with the remedy.
    pub message: Option<String>,
    /// Whether the report can be read.
    pub reported: bool,
}

/// A place that the operator touches.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TouchView {
    /// What to do there.
    pub words: String,
    /// The place on the drawing, mm.
    pub at_mm: Option<[f64; 2]>,
}

/// What a session is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SessionKind {
    /// The operator touches places of the part.
    Touch,
    /// The outline is traced with the tool raised.
    DryRun,
    /// The part is cut.
    Cut,
}

/// What a client asks of the workbench.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum BenchRequest {
    /// Opens a job of the folder.
    Open {
        /// Its name.
        name: String,
    },
    /// Goes back to the list of jobs.
    Close {},
    /// States the unit of the drawing.
    Unit {
        /// The unit: mm, inch, …
        unit: String,
    },
    /// Leaves the open lines out.
    LeaveOutOpen {},
    /// States on which side of the outermost contours the part is.
    Side {
        /// The part is around them, and the tool is inside them.
        inside: bool,
    },
    /// Chooses the machine.
    Machine {
        /// Its stored name.
        name: String,
    },
    /// Asks a controller for its figures, and stores it as a machine under a name.
    NewMachine {
        /// The name.
        name: String,
        /// Its port.
        port: String,
        /// Its dialect, by name.
        dialect: String,
        /// Baud rate of the port.
        baud: u32,
        /// Half the spread of ten returns to one place, µm.
        repeatability_um: u32,
        /// Largest distance of the true path from the commanded one in motion, µm.
        contour_error_um: u32,
        /// Keepout moves a third axis. Its spread and its following error are taken to be those of the others.
        third_axis: bool,
    },
    /// Chooses the tool and makes the plan.
    Plan {
        /// Diameter of the tool, micrometres.
        tool_um: u32,
    },
    /// Begins a session. The machine moves only by the operator.
    Begin {
        /// What for.
        kind: SessionKind,
        /// Whether the machine homes first, with the tool raised.
        home: bool,
    },
    /// Takes the place where the tool is.
    Take {},
    /// Ends the session: the machine comes to rest first.
    End {},
    /// Begins another part with the same set-up.
    NextPart {},
}

/// Texts of the running session, which change seldom.
#[derive(Clone, Debug, Default, Serialize)]
pub struct SessionWords {
    /// The contours that are cut and those that are left.
    pub tally: String,
    /// The last notices, oldest first.
    pub notices: Vec<String>,
}

/// A document of the job.
#[derive(Clone, Debug)]
pub struct Document {
    /// Its media type.
    pub media: &'static str,
    /// Its bytes.
    pub bytes: Vec<u8>,
}

/// Names of documents that the page may read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DocumentName {
    /// The picture of the plan or of the drawing, SVG.
    Picture,
    /// The section view, SVG.
    Section,
    /// The report, HTML.
    Report,
}

/// The program behind the panel.
pub trait Workbench: Send + Sync {
    /// The job as it is.
    fn job(&self) -> JobView;

    /// The map of the job.
    fn map(&self) -> MapView;

    /// Number that changes when the job or the map changes.
    fn revision(&self) -> u64;

    /// Does what a client asks for. What goes wrong is a text with its remedy.
    ///
    /// # Errors
    /// The text.
    fn ask(&self, request: BenchRequest) -> Result<(), String>;

    /// Makes a job of a drawing.
    ///
    /// # Errors
    /// A text with its remedy.
    fn drawing(&self, name: &str, bytes: &[u8]) -> Result<(), String>;

    /// A document of the job.
    fn document(&self, name: DocumentName) -> Option<Document>;

    /// The texts of the running session.
    fn words(&self) -> SessionWords;
}
