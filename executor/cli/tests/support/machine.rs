//! A simulated machine at a port, as a process of its own.

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// A simulated machine that ends with its test.
pub struct MachineProcess(Child);

impl MachineProcess {
    /// Starts the machine, and waits for its port.
    pub fn start(port: &str, more: &[&str], within: Duration) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_keepout"));
        let child = command.args(["simulate", "--link", port]).args(more).stdout(Stdio::null()).spawn();
        let machine = Self(child.unwrap());
        let begun = Instant::now();
        while !Path::new(port).exists() {
            assert!(begun.elapsed() < within, "the simulated machine does not start");
            std::thread::sleep(Duration::from_millis(5));
        }
        machine
    }

    /// Ends the machine in order. Returns its exit code.
    pub fn end(&mut self) -> Option<i32> {
        signal(&self.0, "TERM");
        self.0.wait().unwrap().code()
    }
}

impl Drop for MachineProcess {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Sends a signal to a process.
pub fn signal(child: &Child, name: &str) {
    let sent = Command::new("kill").args([format!("-{name}"), child.id().to_string()]).status().unwrap();
    assert!(sent.success());
}
