//! The command `panel`: the operator's panel in a browser.

mod desk;
mod machines;
mod open_job;
mod sessions;
mod views;

use std::io::IsTerminal as _;
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::mpsc::sync_channel;
use std::time::Duration;

use clap::Args;
use keepout_drives::profile::DriveProfile;
use keepout_executor::dialect::DialectName;
use keepout_panel::bench::Workbench;
use keepout_panel::hub::Hub;
use keepout_panel::server::{Invitation, Listener, PanelSite, ServeError};
use keepout_planner::Mm2;
use keepout_planner::file::OUTPUT;
use keepout_planner::machine::MachineProfile;
use keepout_sim::standalone::{Records, Signals, Standalone};
use keepout_sim::{SimMachine, SimSettings};
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

use self::desk::Desk;
use super::CliError;
use super::demo::COVER;
use super::store::StoredMachine;
use crate::input::TerminalError;

/// The depths of the demonstration, for its job file.
const COVER_DEPTHS: &str =
    "\n[depth]\nthickness_mm = 5.0\nlayer_depth = [\"POCKET=2\"]\nstep_down_mm = 2.0\n";

/// Arguments of `panel`.
#[derive(Debug, Args)]
pub struct PanelArguments {
    /// The folder of the jobs. It is made if it does not exist.
    #[arg(default_value = "keepout-jobs", value_name = "JOBS-FOLDER")]
    folder: PathBuf,
    /// Begin with a job of the built-in drawing, for the simulated machine.
    #[arg(long)]
    demo: bool,
    /// Listen at this address of the network too, such as 192.168.1.20: other devices may then enter with the code that
    /// the program shows. Without it, only this computer reaches the panel.
    #[arg(long, value_name = "ADDRESS")]
    listen: Option<IpAddr>,
    /// The port of the address. 0 takes a free one.
    #[arg(long, default_value_t = 8930)]
    port: u16,
}

pub fn panel(arguments: &PanelArguments) -> Result<ExitCode, CliError> {
    let folder = &arguments.folder;
    std::fs::create_dir_all(folder).map_err(OUTPUT.write_error(folder))?;
    if arguments.demo {
        demo_job(folder)?;
    }
    let at = SocketAddr::new(arguments.listen.unwrap_or(IpAddr::V4(Ipv4Addr::LOCALHOST)), arguments.port);
    let listener = Listener::bind(at)?;
    let hub = Hub::default();
    let desk = Desk::new(hub.clone(), folder.clone(), simulated_machine()?);
    end_in_order(&desk)?;
    let bench: Arc<dyn Workbench> = desk;
    let site = PanelSite::new(hub, bench, listener.at).map_err(ServeError::from)?;
    show(&site.invite().map_err(ServeError::from)?, arguments.listen.is_some());
    invite_again(site.clone(), arguments.listen.is_some());
    listener.serve(site)?;
    Ok(ExitCode::SUCCESS)
}

/// Shows an invitation: its address, and for the network its QR code.
fn show(invitation: &Invitation, as_code: bool) {
    if let Some(code) = invitation.for_terminal().filter(|_| as_code) {
        println!("{code}");
    }
    println!("The panel is at  {}", invitation.address);
    println!("The code ends after 15 minutes. Press Enter for a new one.");
    println!("A hardware emergency stop stays mandatory.");
}

/// Makes a new code for each line that a person enters at the terminal.
fn invite_again(site: PanelSite, as_code: bool) {
    if !std::io::stdin().is_terminal() {
        return;
    }
    let ask = move || {
        for _ in std::io::stdin().lines().map_while(Result::ok) {
            match site.invite() {
                Ok(invitation) => show(&invitation, as_code),
                Err(error) => eprintln!("{error}"),
            }
        }
    };
    // Without the thread the first code stays the only one.
    let _ = std::thread::Builder::new().name("codes".into()).spawn(ask);
}

/// Ends the session in order at a signal: the machine comes to rest first.
fn end_in_order(desk: &Arc<Desk>) -> Result<(), CliError> {
    let wrong = |error| CliError::Terminal(TerminalError::SetUp(error));
    let mut signals = signal_hook::iterator::Signals::new([SIGINT, SIGTERM, SIGHUP]).map_err(wrong)?;
    let desk = Arc::clone(desk);
    let wait = move || {
        if signals.forever().next().is_some() {
            desk.shut_down();
            std::process::exit(0);
        }
    };
    std::thread::Builder::new().name("signals".into()).spawn(wait).map_err(wrong)?;
    Ok(())
}

/// Makes the job of the demonstration, unless it is there.
fn demo_job(folder: &Path) -> Result<(), CliError> {
    let job = folder.join("cover");
    if job.exists() {
        return Ok(());
    }
    super::job::make(&job, "cover.dxf", COVER, super::store::SIMULATED)?;
    let path = job.join("job.toml");
    let text = std::fs::read_to_string(&path).map_err(OUTPUT.write_error(&path))?;
    let text = text.replace("feed_mm_min = 900 ", "feed_mm_min = 3600");
    Ok(OUTPUT.write(&path, (text + COVER_DEPTHS).as_bytes())?)
}

/// Starts the simulated machine, which stays on while the program runs, behind a port of its own.
fn simulated_machine() -> Result<StoredMachine, CliError> {
    let profile = MachineProfile::simulated_three_axes();
    let settings = SimSettings {
        homed: false,
        ..SimSettings::of(profile.clone(), Mm2::new(-1.0, -1.0).at_height(-1.0))
    };
    let servo = DriveProfile::simulated().ok();
    let line = (115_200, Duration::from_millis(1));
    let machine = SimMachine::wandering(settings, &DialectName::Grbl, line, 1, servo.as_ref());
    let (sender, receiver) = sync_channel(1);
    let run = move || {
        let mut ignore = |_: &_| {};
        let simulated = Standalone::new(machine, Records::default(), &mut ignore);
        match simulated {
            Ok(simulated) => {
                let _ = simulated.run(&Signals::default(), |name| _ = sender.try_send(Ok(name.to_string())));
            }
            Err(error) => _ = sender.try_send(Err(error.to_string())),
        }
    };
    let failed =
        |reason: String| CliError::Argument(format!("the simulated machine does not start: {reason}"));
    std::thread::Builder::new()
        .name("simulated machine".into())
        .spawn(run)
        .map_err(|error| failed(error.to_string()))?;
    let port = receiver.recv().map_err(|error| failed(error.to_string()))?.map_err(failed)?;
    Ok(StoredMachine { port, profile, ..StoredMachine::simulated() })
}
