//! New machines of the panel: the controller is asked for its figures.
//!
//! Implements SR-28.

use keepout_executor::dialect::DialectName;
use keepout_executor::session::serial::port_names;
use keepout_panel::bench::BenchRequest;

use crate::error::CliError;
use crate::new_machine::NewMachine;

/// The dialects that a new machine can have.
pub fn dialects() -> Vec<String> {
    DialectName::NAMES.map(String::from).to_vec()
}

/// Stores a machine, and returns its name.
pub fn new_machine_of(request: BenchRequest) -> Result<String, CliError> {
    let BenchRequest::NewMachine {
        name,
        port,
        dialect,
        baud,
        repeatability_um,
        contour_error_um,
        third_axis,
    } = request
    else {
        return Err(CliError::Argument("that is no machine".into()));
    };
    if !port_names().contains(&port) && !is_device(&port) {
        let shown = keepout_planner::text_file::shown(&port);
        return Err(CliError::Argument(format!(
            "\"{shown}\" is no serial port of this computer. Choose one."
        )));
    }
    if !DialectName::NAMES.contains(&dialect.as_str()) {
        let shown = keepout_planner::text_file::shown(&dialect);
        return Err(CliError::Argument(format!("there is no dialect \"{shown}\". Choose one of the list.")));
    }
    let mm = |um: u32| Some(f64::from(um) / 1000.0);
    let arguments = NewMachine {
        name: name.clone(),
        port,
        dialect,
        baud,
        operator: Some("keyboard".into()),
        travel_mm: None,
        repeatability_mm: mm(repeatability_um),
        contour_error_mm: mm(contour_error_um),
        third_axis,
        z_repeatability_mm: mm(repeatability_um),
        z_following_error_mm: mm(contour_error_um),
        overwrite: false,
    };
    crate::new_machine::store(&arguments, false)?;
    Ok(name)
}

/// Whether a name is of a device, and not of a file.
fn is_device(name: &str) -> bool {
    name.starts_with("/dev/") && !name.contains("..")
}

#[cfg(test)]
mod tests {
    use super::*;

    // Evidence for SR-28.
    #[test]
    fn new_machine_has_a_device_and_a_dialect_of_the_list() {
        let refusal = |port: &str, dialect: &str| {
            let request = BenchRequest::NewMachine {
                name: "shop".into(),
                port: port.into(),
                dialect: dialect.into(),
                baud: 115_200,
                repeatability_um: 10,
                contour_error_um: 50,
                third_axis: true,
            };
            new_machine_of(request).unwrap_err().to_string()
        };
        for port in
            ["/etc/passwd", "", "ttyUSB0\n", "/dev/../etc/passwd", "../dev/ttyUSB0", "socket://elsewhere"]
        {
            let told = refusal(port, "grbl");
            assert!(told.contains("is no serial port of this computer"), "{port}: {told}");
        }
        for dialect in ["", "GRBL", "grbl ", "/etc/passwd"] {
            let told = refusal("/dev/no-such-device", dialect);
            assert!(told.contains("there is no dialect"), "{dialect}: {told}");
        }
        // With a device and a dialect of the list, the program opens the port.
        assert!(refusal("/dev/no-such-device", "grbl").contains("/dev/no-such-device"));
    }
}
