//! The simulated machine behind a pseudo-terminal, in real time: the executor opens it like any serial port.

use std::io::{ErrorKind, Read, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use keepout_executor::session::Sample;
use keepout_executor::session::port::{ClosedPort, PortError};
use keepout_guard::Time;
use serialport::{SerialPort, TTYPort};

use super::machine::SimMachine;

/// A simulated machine in its own thread behind a pty. Dropping it ends the thread.
pub struct PtyMachine {
    name: String,
    stop: Arc<AtomicBool>,
    samples: Arc<Mutex<Vec<Sample>>>,
    thread: Option<JoinHandle<()>>,
}

impl PtyMachine {
    /// Starts `machine` behind a new pty.
    ///
    /// # Errors
    /// [`PortError::Open`] if the system provides no pty.
    pub fn start(machine: SimMachine) -> Result<Self, PortError> {
        let failed =
            |reason: String| PortError::Open { name: "pty".into(), reason, closed: ClosedPort::Other };
        let (mut host, device) = TTYPort::pair().map_err(|error| failed(error.to_string()))?;
        host.set_timeout(Duration::from_millis(1)).map_err(|error| failed(error.to_string()))?;
        let name = device.name().ok_or_else(|| failed("the pty has no name".into()))?;
        // The device is locked while it is open here. The session's program opens it by name.
        drop(device);
        let stop = Arc::new(AtomicBool::new(false));
        let samples = Arc::new(Mutex::new(Vec::new()));
        let shared = (Arc::clone(&stop), Arc::clone(&samples));
        let thread = std::thread::spawn(move || serve(machine, host, &shared.0, &shared.1));
        Ok(Self { name, stop, samples, thread: Some(thread) })
    }

    /// The name of the device to open.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The true tool positions since the last call.
    #[must_use]
    pub fn take_samples(&self) -> Vec<Sample> {
        std::mem::take(&mut self.samples.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Drop for PtyMachine {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn serve(mut machine: SimMachine, mut host: TTYPort, stop: &AtomicBool, samples: &Mutex<Vec<Sample>>) {
    let began = Instant::now();
    let mut buffer = [0; 256];
    let mut out = Vec::new();
    while !stop.load(Ordering::Relaxed) {
        let now = Time::ZERO.after(began.elapsed());
        match host.read(&mut buffer) {
            Ok(count) => machine.host_writes(&buffer[..count], now),
            Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::WouldBlock) => {}
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            // No program has the other end open: the cable is out, and the machine runs on.
            Err(_) => std::thread::sleep(Duration::from_millis(1)),
        }
        let now = Time::ZERO.after(began.elapsed());
        machine.advance(now);
        machine.host_reads(&mut out, now);
        if !out.is_empty() && host.write_all(&out).is_ok() {
            out.clear();
        }
        machine.take_samples(&mut samples.lock().unwrap_or_else(PoisonError::into_inner));
    }
}
