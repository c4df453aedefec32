//! A terminal for tests: the program at one end of a pty, the test at the other.

use std::fs::{File, OpenOptions};
use std::io::{Read, Write};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serialport::{SerialPort, TTYPort};

/// A program in a terminal of its own.
pub struct Terminal {
    pub keys: TTYPort,
    pub child: Child,
    pub shown: Vec<u8>,
    /// Keeps the terminal open after the program ends, so that its last output can be read.
    pub _end: File,
}

impl Terminal {
    /// Runs the program. With the folder of its stored machines and tools, the terminal also shows its error output.
    pub fn run(arguments: &[&str], stored: Option<&str>) -> Self {
        let (own, device) = TTYPort::pair().unwrap();
        // No program may inherit this end of the terminal: it would keep its own terminal open.
        let mut keys = own.try_clone_native().unwrap();
        drop(own);
        keys.set_timeout(Duration::from_millis(10)).unwrap();
        let name = device.name().unwrap();
        drop(device);
        let end = || OpenOptions::new().read(true).write(true).open(&name).unwrap();
        let child = Command::new(env!("CARGO_BIN_EXE_keepout"))
            .args(arguments)
            .envs(stored.map(|folder| ("KEEPOUT_CONFIG", folder)))
            .stdin(end())
            .stdout(end())
            .stderr(stored.map_or(Stdio::null(), |_| end().into()))
            .spawn()
            .unwrap();
        Self { keys, child, shown: Vec::new(), _end: end() }
    }

    /// Types keys for a time, or until the program ends. Answers queries as a plain terminal does.
    pub fn type_for(&mut self, time: Duration, keys: &[u8], every: Duration) {
        let (began, mut due) = (Instant::now(), Duration::ZERO);
        while began.elapsed() < time && self.child.try_wait().unwrap().is_none() {
            let mut bytes = [0; 4096];
            if let Ok(count) = self.keys.read(&mut bytes) {
                self.shown.extend(&bytes[..count]);
                if bytes[..count].windows(3).any(|question| question == b"\x1b[c") {
                    self.keys.write_all(b"\x1b[?62;c").unwrap();
                }
            }
            if began.elapsed() >= due {
                due += every;
                self.keys.write_all(keys).unwrap();
            }
        }
    }

    /// Waits until the program shows a text, for at most one minute.
    pub fn wait_for(&mut self, text: &str) {
        let began = Instant::now();
        loop {
            let shown = String::from_utf8_lossy(&self.shown);
            if shown.contains(text) {
                return;
            }
            assert!(began.elapsed() < Duration::from_secs(60), "\"{text}\" is not shown:\n{shown}");
            self.type_for(Duration::from_millis(100), b"", Duration::from_secs(60));
        }
    }

    /// Kills the program if it still runs, and reads its last output. Returns its exit code if it ended
    /// by itself.
    pub fn end(&mut self) -> Option<i32> {
        let status = self.child.try_wait().unwrap();
        let _ = self.child.kill();
        let _ = self.child.wait();
        let mut bytes = [0; 4096];
        while let Ok(count @ 1..) = self.keys.read(&mut bytes) {
            self.shown.extend(&bytes[..count]);
        }
        status?.code()
    }
}
