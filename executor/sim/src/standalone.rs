//! The simulated machine as a separate program, behind a pty that can be cut and opened again. It writes
//! received bytes, true tool positions and the present position to files as they occur, so the records
//! survive the program.

use std::fmt::Write as _;
use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use keepout_executor::session::{Sample, SampleKind};
use keepout_guard::Time;
use keepout_planner::Mm3;
use keepout_planner::file::{FileError, FileKind};
use serialport::{SerialPort, TTYPort};
use thiserror::Error;

use super::machine::SimMachine;

static RECORD: FileKind = FileKind { unwritable: "Choose another place.", ..FileKind::new("machine record") };

/// The files that the machine writes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Records {
    /// A symbolic link to the pty, renewed with each new pty.
    pub link: Option<PathBuf>,
    /// Every byte that arrived at the machine's end of the line.
    pub received: Option<PathBuf>,
    /// True tool positions: lines `MICROSECONDS rest|jog|run X Y`, machine coordinates, mm.
    pub positions: Option<PathBuf>,
    /// The tool's present position: a line `X Y`.
    pub state: Option<PathBuf>,
}

/// Why the machine cannot run.
#[derive(Debug, Error)]
pub enum StandaloneError {
    /// The system provides no pty.
    #[error("the system provides no pty: {0}")]
    Pty(#[from] serialport::Error),
    /// A file cannot be read or written.
    #[error(transparent)]
    File(#[from] FileError),
    /// A file exists at the link's path, and is not a symbolic link.
    #[error("{} exists and is not a symbolic link. Choose another --link.", path.display())]
    NoLink {
        /// The file.
        path: PathBuf,
    },
    /// A state file or a position list is malformed.
    #[error("{}: line {line} is malformed. Another program may have written the file.", path.display())]
    Form {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
    },
}

/// Signals to a running machine.
#[derive(Debug, Default)]
pub struct Signals {
    /// Set to end the machine.
    pub end: AtomicBool,
    /// Set to pull the cable and put it back: the machine closes the pty, and opens another.
    pub cut: AtomicBool,
}

/// A running machine.
pub struct Standalone<'a> {
    machine: SimMachine,
    host: (TTYPort, String),
    records: Records,
    received: Option<File>,
    positions: Option<File>,
    state: Option<File>,
    watch: &'a mut dyn FnMut(&Sample),
    last: Option<Sample>,
    /// Whether positions have heights.
    three_axes: bool,
}

impl<'a> Standalone<'a> {
    /// Opens the pty and the files. `watch` receives every true position.
    ///
    /// # Errors
    /// [`StandaloneError`] if the system provides no pty, or a file cannot be written.
    pub fn new(
        machine: SimMachine,
        records: Records,
        watch: &'a mut dyn FnMut(&Sample),
    ) -> Result<Self, StandaloneError> {
        let added = |path: &Option<PathBuf>| {
            let path = path.as_ref();
            path.map(|path| file(path, OpenOptions::new().append(true).create(true))).transpose()
        };
        let (received, positions) = (added(&records.received)?, added(&records.positions)?);
        let state = records.state.as_ref();
        let state = state.map(|path| file(path, OpenOptions::new().write(true).create(true).truncate(false)));
        let state = state.transpose()?;
        let host = open(records.link.as_deref())?;
        let three_axes = machine.has_height();
        Ok(Self { machine, host, records, received, positions, state, watch, last: None, three_axes })
    }

    /// Runs until [`Signals::end`] is set. `opened` receives the name of each pty.
    ///
    /// # Errors
    /// [`StandaloneError`] if a file can no longer be written.
    pub fn run(mut self, signals: &Signals, mut opened: impl FnMut(&str)) -> Result<(), StandaloneError> {
        opened(&self.host.1);
        let began = Instant::now();
        let now = || Time::ZERO.after(began.elapsed());
        let mut out = Vec::new();
        while !signals.end.load(Ordering::Relaxed) {
            if signals.cut.swap(false, Ordering::Relaxed) {
                self.host = open(self.records.link.as_deref())?;
                out.clear();
                opened(&self.host.1);
            }
            self.listen(now())?;
            self.machine.advance(now());
            self.machine.host_reads(&mut out, now());
            if !out.is_empty() {
                // Without a reader these bytes are lost, as on an unplugged cable.
                let _ = self.host.0.write_all(&out);
                out.clear();
            }
            self.write_down()?;
        }
        if let Some(link) = &self.records.link {
            let _ = std::fs::remove_file(link);
        }
        Ok(())
    }

    fn listen(&mut self, now: Time) -> Result<(), StandaloneError> {
        let mut buffer = [0; 256];
        match self.host.0.read(&mut buffer) {
            Ok(count) => {
                append(&mut self.received, &self.records.received, &buffer[..count])?;
                self.machine.host_writes(&buffer[..count], now);
            }
            Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::WouldBlock) => {}
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            // No program has the other end open: the cable is out, and the machine runs on.
            Err(_) => std::thread::sleep(Duration::from_millis(1)),
        }
        Ok(())
    }

    /// Writes the tool's positions, each one once.
    fn write_down(&mut self) -> Result<(), StandaloneError> {
        let (mut samples, mut text) = (Vec::new(), String::new());
        self.machine.take_samples(&mut samples);
        for sample in samples {
            let same = self
                .last
                .is_some_and(|last| (last.position_mm, last.kind) == (sample.position_mm, sample.kind));
            if same {
                continue;
            }
            (self.watch)(&sample);
            let Mm3 { x, y, z } = sample.position_mm;
            // Writing to a string does not fail.
            let _ = write!(text, "{} {} {x:?} {y:?}", sample.at.micros(), name(sample.kind));
            // A machine with two axes has no height.
            if self.three_axes {
                let _ = write!(text, " {z:?}");
            }
            text.push('\n');
            self.last = Some(sample);
        }
        if text.is_empty() {
            return Ok(());
        }
        append(&mut self.positions, &self.records.positions, text.as_bytes())?;
        let (Some(state), Some(last)) = (&mut self.state, self.last) else { return Ok(()) };
        // One write of fixed length: even if the program is killed, the file holds a complete position.
        let Mm3 { x, y, z } = last.position_mm;
        let height = if self.three_axes { format!(" {z:+017.9}") } else { String::new() };
        let line = format!("{x:+017.9} {y:+017.9}{height}\n");
        let written = state.seek(SeekFrom::Start(0)).and_then(|_| state.write_all(line.as_bytes()));
        written.map_err(|source| failed(&self.records.state, source))
    }
}

fn append(file: &mut Option<File>, path: &Option<PathBuf>, bytes: &[u8]) -> Result<(), StandaloneError> {
    let Some(file) = file else { return Ok(()) };
    file.write_all(bytes).map_err(|source| failed(path, source))
}

fn failed(path: &Option<PathBuf>, source: std::io::Error) -> StandaloneError {
    RECORD.write_error(path.as_deref().unwrap_or(Path::new("")))(source).into()
}

fn file(path: &Path, options: &OpenOptions) -> Result<File, StandaloneError> {
    Ok(options.open(path).map_err(RECORD.write_error(path))?)
}

/// Opens a new pty, returns it with its name, and points the link to it.
fn open(link: Option<&Path>) -> Result<(TTYPort, String), StandaloneError> {
    let (mut host, device) = TTYPort::pair()?;
    host.set_timeout(Duration::from_millis(1))?;
    let name = device.name().unwrap_or_default();
    // The device is locked while it is open here. The session's program opens it by name.
    drop(device);
    if let Some(link) = link {
        relink(link, &name).map_err(|source| match source.kind() {
            ErrorKind::AlreadyExists => StandaloneError::NoLink { path: link.to_path_buf() },
            _ => RECORD.write_error(link)(source).into(),
        })?;
    }
    Ok((host, name))
}

fn relink(link: &Path, name: &str) -> Result<(), std::io::Error> {
    if link.is_symlink() {
        std::fs::remove_file(link)?;
    }
    std::os::unix::fs::symlink(name, link)
}

fn name(kind: SampleKind) -> &'static str {
    match kind {
        SampleKind::Rest => "rest",
        SampleKind::Jog => "jog",
        SampleKind::Run => "run",
    }
}

/// The tool's position from a [`Records::state`] file; `None` if the file is missing or empty.
///
/// # Errors
/// [`StandaloneError`] if the file cannot be read or is malformed.
pub fn state(path: &Path) -> Result<Option<Mm3>, StandaloneError> {
    let text = match std::fs::read_to_string(path) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(error) if error.kind() == std::io::ErrorKind::InvalidData => {
            return Err(StandaloneError::Form { path: path.to_path_buf(), line: 1 });
        }
        Err(source) => return Err(RECORD.read_error(path)(source).into()),
    };
    if text.is_empty() {
        return Ok(None);
    }
    let mut numbers = text.split_whitespace().map(|number| number.parse::<f64>().ok());
    let mut place = || {
        let z = |number: Option<Option<f64>>| number.unwrap_or(Some(0.0));
        Some(Mm3::new(numbers.next()??, numbers.next()??, z(numbers.next())?))
    };
    place().map(Some).ok_or_else(|| StandaloneError::Form { path: path.to_path_buf(), line: 1 })
}

/// The true positions from a [`Records::positions`] file. An incomplete last line is left out.
///
/// # Errors
/// [`StandaloneError`] if the file cannot be read, or naming the malformed line.
pub fn positions(path: &Path) -> Result<Vec<Sample>, StandaloneError> {
    let text = std::fs::read_to_string(path).map_err(RECORD.read_error(path))?;
    let whole = text.rfind('\n').map_or("", |end| &text[..=end]);
    let read = |(index, line)| {
        sample(line).ok_or_else(|| StandaloneError::Form { path: path.to_path_buf(), line: index + 1 })
    };
    whole.lines().enumerate().map(read).collect()
}

fn sample(line: &str) -> Option<Sample> {
    let mut fields = line.split(' ');
    let at = Time::from_micros(fields.next()?.parse().ok()?);
    let kind = match fields.next()? {
        "rest" => SampleKind::Rest,
        "jog" => SampleKind::Jog,
        "run" => SampleKind::Run,
        _ => return None,
    };
    Some(Sample {
        at,
        position_mm: Mm3::new(
            fields.next()?.parse().ok()?,
            fields.next()?.parse().ok()?,
            fields.next().map_or(Some(0.0), |z| z.parse().ok())?,
        ),
        kind,
    })
}
