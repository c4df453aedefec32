//! The simulated machine as a program of its own: behind a pty that can be cut and opened anew, with what it received, where
//! the tool truly was and where it stands written down as it happens, so that it outlives this program.

use std::fmt::Write as _;
use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use keepout_executor::session::{Sample, SampleKind};
use keepout_guard::Time;
use serialport::{SerialPort, TTYPort};
use thiserror::Error;

use super::machine::SimMachine;

/// What the machine leaves behind.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Records {
    /// A symbolic link to the pty, renewed when that is.
    pub link: Option<PathBuf>,
    /// Every byte that arrived at the machine's end of the line.
    pub received: Option<PathBuf>,
    /// True tool positions: lines `MICROSECONDS rest|jog|run X Y`, machine coordinates, mm.
    pub positions: Option<PathBuf>,
    /// Where the tool stands: a line `X Y`.
    pub state: Option<PathBuf>,
}

/// Why the machine can not run.
#[derive(Debug, Error)]
pub enum StandaloneError {
    /// There is no pty.
    #[error("the system gives no pty: {0}")]
    Pty(#[from] serialport::Error),
    /// A file can not be written.
    #[error("can not write {}: {source}. Choose another place.", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// There is a file where the link should be.
    #[error("{} is there already, and no link. Choose another --link.", path.display())]
    NoLink {
        /// The file.
        path: PathBuf,
    },
    /// A state or a list of positions can not be understood.
    #[error("{}: line {line} is not formed as it should be. Was it written by another program?", path.display())]
    Form {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
    },
}

/// Signals to a machine that runs.
#[derive(Debug, Default)]
pub struct Signals {
    /// It is to end.
    pub end: AtomicBool,
    /// The cable is to be pulled and put back: the pty is closed, and another opened.
    pub cut: AtomicBool,
}

/// The machine, running.
pub struct Standalone<'a> {
    machine: SimMachine,
    host: (TTYPort, String),
    records: Records,
    received: Option<File>,
    positions: Option<File>,
    state: Option<File>,
    watch: &'a mut dyn FnMut(&Sample),
    last: Option<Sample>,
}

impl<'a> Standalone<'a> {
    /// Opens the pty and the files; `watch` sees every true position.
    ///
    /// # Errors
    /// [`StandaloneError`] when there is no pty, or a file can not be written.
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
        Ok(Self { machine, host, records, received, positions, state, watch, last: None })
    }

    /// Runs until it is to end. `opened` is told the name of each pty.
    ///
    /// # Errors
    /// [`StandaloneError`] when a file can not be written any more.
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
                // What nobody is there to read is lost, as on a cable that is out.
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
            // Nobody has the other end open: the cable is out, the machine goes on.
            Err(_) => std::thread::sleep(Duration::from_millis(1)),
        }
        Ok(())
    }

    /// Writes down where the tool was, each place once.
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
            let (x, y) = sample.position_mm;
            // Writing to a string does not fail.
            let _ = writeln!(text, "{} {} {x:?} {y:?}", sample.at.micros(), name(sample.kind));
            self.last = Some(sample);
        }
        if text.is_empty() {
            return Ok(());
        }
        append(&mut self.positions, &self.records.positions, text.as_bytes())?;
        let (Some(state), Some(last)) = (&mut self.state, self.last) else { return Ok(()) };
        // One write of one length, so that a place is there whole whenever the program is killed.
        let line = format!("{:+017.9} {:+017.9}\n", last.position_mm.0, last.position_mm.1);
        let written = state.seek(SeekFrom::Start(0)).and_then(|_| state.write_all(line.as_bytes()));
        written.map_err(|source| failed(&self.records.state, source))
    }
}

fn append(file: &mut Option<File>, path: &Option<PathBuf>, bytes: &[u8]) -> Result<(), StandaloneError> {
    let Some(file) = file else { return Ok(()) };
    file.write_all(bytes).map_err(|source| failed(path, source))
}

fn failed(path: &Option<PathBuf>, source: std::io::Error) -> StandaloneError {
    StandaloneError::File { path: path.clone().unwrap_or_default(), source }
}

fn file(path: &Path, options: &OpenOptions) -> Result<File, StandaloneError> {
    options.open(path).map_err(|source| StandaloneError::File { path: path.to_path_buf(), source })
}

/// A new pty, and its name; the link leads there.
fn open(link: Option<&Path>) -> Result<(TTYPort, String), StandaloneError> {
    let (mut host, device) = TTYPort::pair()?;
    host.set_timeout(Duration::from_millis(1))?;
    let name = device.name().unwrap_or_default();
    // The device is locked while it is open here; whoever runs the session opens it by name.
    drop(device);
    if let Some(link) = link {
        relink(link, &name).map_err(|source| match source.kind() {
            ErrorKind::AlreadyExists => StandaloneError::NoLink { path: link.to_path_buf() },
            _ => StandaloneError::File { path: link.to_path_buf(), source },
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

/// Where the tool stands, as a [`Records::state`] says; `None` when there is no such file yet, or it is empty.
///
/// # Errors
/// [`StandaloneError`] when it is not understood.
pub fn state(path: &Path) -> Result<Option<(f64, f64)>, StandaloneError> {
    let text = match std::fs::read_to_string(path) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(error) if error.kind() == std::io::ErrorKind::InvalidData => {
            return Err(StandaloneError::Form { path: path.to_path_buf(), line: 1 });
        }
        Err(source) => return Err(StandaloneError::File { path: path.to_path_buf(), source }),
    };
    if text.is_empty() {
        return Ok(None);
    }
    let place = text.split_once(' ').and_then(|(x, y)| Some((x.parse().ok()?, y.trim().parse().ok()?)));
    place.map(Some).ok_or_else(|| StandaloneError::Form { path: path.to_path_buf(), line: 1 })
}

/// The true positions of a [`Records::positions`]; a last line that was not written whole is left out.
///
/// # Errors
/// [`StandaloneError`] naming the line that is not understood.
pub fn positions(path: &Path) -> Result<Vec<Sample>, StandaloneError> {
    let text = std::fs::read_to_string(path);
    let text = text.map_err(|source| StandaloneError::File { path: path.to_path_buf(), source })?;
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
    Some(Sample { at, position_mm: (fields.next()?.parse().ok()?, fields.next()?.parse().ok()?), kind })
}
