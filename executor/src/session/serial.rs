//! A real serial port.

use std::io::{ErrorKind, Read, Write};
use std::time::Duration;

use keepout_guard::Time;
use serialport::{ClearBuffer, SerialPort};

use super::port::{ClosedPort, Port, PortError};

/// A serial port, 8 data bits, no parity, 1 stop bit.
pub struct Serial {
    name: String,
    port: Box<dyn SerialPort>,
}

/// The names of this computer's serial ports. Empty where the system does not list them.
#[must_use]
pub fn port_names() -> Vec<String> {
    let ports = serialport::available_ports().unwrap_or_default();
    ports.into_iter().map(|port| port.port_name).collect()
}

impl Serial {
    /// Opens the port by its system name.
    ///
    /// # Errors
    /// [`PortError::Open`], which names the remedy.
    pub fn open(name: &str, baud: u32) -> Result<Self, PortError> {
        let port = serialport::new(name, baud)
            .timeout(Duration::from_millis(2))
            .open()
            .map_err(|error| closed(name, &error.to_string()))?;
        // Bytes in the buffer may be replies to an earlier session that was killed.
        port.clear(ClearBuffer::Input).map_err(|error| closed(name, &error.to_string()))?;
        Ok(Self { name: name.into(), port })
    }

    fn lost(&self, reason: &dyn std::fmt::Display) -> PortError {
        PortError::Lost { name: self.name.clone(), reason: reason.to_string() }
    }
}

fn closed(name: &str, reason: &str) -> PortError {
    PortError::Open { name: name.into(), reason: reason.into(), closed: ClosedPort::of(reason) }
}

/// Most retries of one write while the driver's buffer is full. Each waits for the port's timeout at most.
const WRITE_TRIES: u32 = 500;

impl Port for Serial {
    fn write(&mut self, mut bytes: &[u8], _now: Time) -> Result<(), PortError> {
        let mut tries = 0;
        while !bytes.is_empty() {
            match self.port.write(bytes) {
                Ok(count) => bytes = &bytes[count.min(bytes.len())..],
                Err(error) if retry(error.kind()) && tries < WRITE_TRIES => tries += 1,
                Err(error) => return Err(self.lost(&error)),
            }
        }
        Ok(())
    }

    fn read(&mut self, into: &mut Vec<u8>, _now: Time) -> Result<(), PortError> {
        let mut buffer = [0; 512];
        match self.port.read(&mut buffer) {
            Ok(0) => Err(self.lost(&"the device is gone")),
            Ok(count) => {
                into.extend(&buffer[..count]);
                Ok(())
            }
            Err(error) if retry(error.kind()) => Ok(()),
            Err(error) => Err(self.lost(&error)),
        }
    }
}

fn retry(kind: ErrorKind) -> bool {
    matches!(kind, ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted)
}

#[cfg(all(test, unix))]
mod tests {
    use serialport::TTYPort;

    use super::*;

    #[test]
    fn busy_missing_and_forbidden_ports_have_their_own_remedies() {
        let (_host, device) = TTYPort::pair().unwrap();
        let name = device.name().unwrap();
        drop(device);
        // Another program holds the port. A lock keeps even the administrator out.
        let _held = Serial::open(&name, 115_200).unwrap();
        let busy = Serial::open(&name, 115_200).err().unwrap().to_string();
        assert!(busy.contains("Another program has it open"), "{busy}");
        let missing = Serial::open("/dev/no-such-port", 115_200).err().unwrap().to_string();
        assert!(missing.contains("plugged in"), "{missing}");
        assert_eq!(ClosedPort::of("Permission denied (os error 13)"), ClosedPort::Forbidden);
    }

    #[test]
    fn bytes_from_before_the_opening_are_dropped() {
        let (mut host, device) = TTYPort::pair().unwrap();
        let name = device.name().unwrap();
        drop(device);
        // An earlier session ends while these replies are on their way.
        let before = Serial::open(&name, 115_200).unwrap();
        host.write_all(b"<Idle|MPos:0.000,0.000,0.000>\r\nok\r\n").unwrap();
        std::thread::sleep(Duration::from_millis(20));
        drop(before);
        let mut port = Serial::open(&name, 115_200).unwrap();
        let mut received = Vec::new();
        port.read(&mut received, Time::ZERO).unwrap();
        assert_eq!(received, b"");
        host.write_all(b"ok\r\n").unwrap();
        std::thread::sleep(Duration::from_millis(20));
        port.read(&mut received, Time::ZERO).unwrap();
        assert_eq!(received, b"ok\r\n");
    }
}
