//! The commands `drives identify`, `tune`, `export` and `ballbar`: from measurements at a machine to its profiles.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, ValueEnum};
use keepout_drives::ballbar::CircularTest;
use keepout_drives::controllers::kind::Kind;
use keepout_drives::export;
use keepout_drives::identification::record::{MotionRecord, MotionRecords};
use keepout_drives::identification::{Estimate, IdentifiedDrive, identify};
use keepout_drives::profile::DriveProfile;
use keepout_drives::tuning::margins::Margins;
use keepout_drives::tuning::tune;
use keepout_planner::machine::{ContourErrorSource, MachineProfile};

use super::CliError;
use super::drives::{bar, show};
use super::plan::{check_ending, given, refuse_same, write};

#[derive(Debug, Args)]
pub struct IdentifyArguments {
    /// The record: CSV with the columns `time_s`, `x_command` and `x_position_mm`, or `y_…`, or both.
    record: PathBuf,
    /// Drive profile that the output copies, with the identified drives.
    #[arg(long, value_name = "PROFILE", requires = "output")]
    drives: Option<String>,
    /// Output file of the drive profile, TOML.
    #[arg(short, long, value_name = "FILE", requires = "drives")]
    output: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub struct TuneArguments {
    /// The drives: a built-in profile or a TOML file.
    profile: String,
    /// Feed along the contour, mm/min.
    #[arg(long, value_name = "MM_MIN")]
    feed: f64,
    /// Controller to tune. Without it, the profile's own.
    #[arg(long, value_name = "NAME", value_parser = kind)]
    controller: Option<Kind>,
    /// Output file of the drive profile with the tuned gains, TOML.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub struct ExportArguments {
    /// The drives: a built-in profile or a TOML file.
    profile: String,
    /// The form of the gains.
    #[arg(long, value_enum, default_value_t = Form::Table)]
    form: Form,
    /// Controller whose gains are written. Without it, the profile's own.
    #[arg(long, value_name = "NAME", value_parser = kind)]
    controller: Option<Kind>,
}

/// A form of exported gains.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Form {
    /// Names and values.
    Table,
    /// HAL lines of LinuxCNC's pid component.
    Linuxcnc,
}

#[derive(Debug, Args)]
pub struct BallbarArguments {
    /// The measured points: CSV with the columns `x_mm` and `y_mm`, or `angle_deg` and `radius_mm`.
    record: PathBuf,
    /// Nominal radius of the circle, mm.
    #[arg(long, value_name = "MM")]
    radius_mm: f64,
    /// Feed of the test, mm/min.
    #[arg(long, value_name = "MM_MIN")]
    feed: f64,
    /// Machine profile that the output copies, with this contour error.
    #[arg(long, value_name = "FILE", requires = "output")]
    machine_profile: Option<PathBuf>,
    /// Output file of the machine profile, TOML.
    #[arg(short, long, value_name = "FILE", requires = "machine_profile")]
    output: Option<PathBuf>,
    /// Output file of the picture of the test, SVG.
    #[arg(long, value_name = "FILE")]
    picture: Option<PathBuf>,
}

fn kind(text: &str) -> Result<Kind, String> {
    Kind::named(text).ok_or_else(|| {
        let names: Vec<_> = Kind::ALL.iter().map(|kind| kind.names().0).collect();
        format!("unknown controller. Choose one of: {}", names.join(", "))
    })
}

pub fn identify_drives(arguments: &IdentifyArguments) -> Result<ExitCode, CliError> {
    refuse_same(&[&arguments.record], &given(&[arguments.output.as_ref()]))?;
    let base = arguments.drives.as_deref().map(DriveProfile::load).transpose()?;
    let refused = |error: String| CliError::Argument(format!("{}: {error}", arguments.record.display()));
    let records =
        MotionRecords::load(&arguments.record).map_err(|error| CliError::Argument(error.to_string()))?;
    let found = |axis: &str, record: &Option<MotionRecord>| -> Result<Option<IdentifiedDrive>, CliError> {
        let Some(record) = record else { return Ok(None) };
        let drive = identify(record).map_err(|error| refused(format!("axis {axis}: {error}")))?;
        print!("{}", described(axis, &drive));
        Ok(Some(drive))
    };
    let drives = [found("x", &records.x)?, found("y", &records.y)?];
    if let (Some(base), Some(output)) = (base, &arguments.output) {
        let profile = identified(base, drives, &arguments.record);
        write(output, profile.to_toml()?.as_bytes())?;
        println!("written      {}", output.display());
    }
    Ok(ExitCode::SUCCESS)
}

/// The lines of an identified drive.
fn described(axis: &str, drive: &IdentifiedDrive) -> String {
    let line = |name: &str, Estimate { value, half_width }: Estimate, factor: f64, unit: &str| {
        let (value, half_width) = (value * factor, half_width * factor);
        let decimals = decimals(half_width);
        format!("{name:<24} {value:.decimals$} ± {half_width:.decimals$} {unit}\n")
    };
    let mut text = format!("axis {axis}, 95 % intervals\n");
    text += &line("gain", drive.gain, 1.0, "mm/s for each bit");
    text += &line("time constant", drive.time_constant_s, 1000.0, "ms");
    text += &line("Coulomb friction", drive.coulomb_bits, 1.0, "bits");
    text += &format!("{:<24} {:.4} bits for each mm/s\n", "viscous friction", 1.0 / drive.gain.value);
    text += &match drive.stiction_bits {
        Some([held, moved]) => format!("{:<24} between {held} and {moved} bits\n", "static friction"),
        None => format!("{:<24} unknown: no command moved the axis from rest\n", "static friction"),
    };
    text += &line("delay", drive.delay_s, 1000.0, "ms");
    text + &format!("{:<24} {:.4} mm (RMS)\n", "distance of the model", drive.residual_mm)
}

/// Number of decimals that show two digits of an interval.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 to 9")]
fn decimals(half_width: f64) -> usize {
    if half_width > 0.0 { (1.0 - half_width.log10().floor()).clamp(0.0, 9.0) as usize } else { 4 }
}

/// `base` with the identified drives.
fn identified(base: DriveProfile, drives: [Option<IdentifiedDrive>; 2], record: &Path) -> DriveProfile {
    let mut profile = base;
    profile.source = format!("identified from {}", record.display());
    let scale = profile.pulses_per_mm;
    for (axis, drive) in [&mut profile.x, &mut profile.y].into_iter().zip(&drives) {
        let Some(drive) = drive else { continue };
        axis.gain = drive.gain.value * scale;
        axis.time_constant_s = drive.time_constant_s.value;
        axis.coulomb_bits = drive.coulomb_bits.value;
        axis.stiction_bits = drive.stiction_bits.map(|[held, _]| held.max(axis.coulomb_bits));
    }
    let found = || drives.iter().flatten();
    let largest = |share: fn(&IdentifiedDrive) -> f64| found().map(share).fold(0.0, f64::max);
    profile.uncertainty.gain = profile.uncertainty.gain.max(largest(|drive| drive.gain.share()));
    profile.uncertainty.time_constant =
        profile.uncertainty.time_constant.max(largest(|drive| drive.time_constant_s.share()));
    // The whole samples of the shortest delay are known; the rest is not.
    let samples = |seconds: f64| seconds / profile.period_s;
    let shortest =
        found().map(|drive| drive.delay_s.value - drive.delay_s.half_width).fold(f64::INFINITY, f64::min);
    let longest = largest(|drive| drive.delay_s.value + drive.delay_s.half_width);
    let known = samples(shortest).max(0.0).floor();
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a count of samples")]
    let whole = known as usize;
    profile.delay_samples = whole;
    profile.uncertainty.delay_samples = (samples(longest) - known).clamp(0.0, 1.0);
    profile
}

/// The feed in mm/s.
fn feed_mm_s(mm_min: f64) -> Result<f64, CliError> {
    let checked = (1.0..=600_000.0).contains(&mm_min).then_some(mm_min / 60.0);
    checked.ok_or_else(|| CliError::Argument(format!("--feed {mm_min} must be between 1 and 600000 mm/min")))
}

/// The controller that was asked for, or that of the profile.
fn controller_of(profile: &DriveProfile, asked: Option<Kind>) -> Result<Kind, CliError> {
    asked.or(profile.controller).ok_or_else(|| {
        CliError::Argument(format!("{} names no controller: give one with --controller", profile.name))
    })
}

pub fn tune_drives(arguments: &TuneArguments) -> Result<ExitCode, CliError> {
    refuse_same(&[Path::new(&arguments.profile)], &given(&[arguments.output.as_ref()]))?;
    let mut profile = DriveProfile::load(&arguments.profile)?;
    let feed_mm_s = feed_mm_s(arguments.feed)?;
    let kind = controller_of(&profile, arguments.controller)?;
    let bar = bar();
    let found = tune(&profile, kind, feed_mm_s, &mut show(&bar));
    bar.finish_and_clear();
    let tuned = found.map_err(|error| CliError::Argument(error.to_string()))?;
    profile.gains = tuned.gains;
    profile.controller = Some(kind);
    print!("{}", export::table(&profile, kind));
    let Margins { gain, phase_deg } = Margins::of(tuned.peak);
    println!(
        "margins      gain {gain:.2}, phase {phase_deg:.0}°, with drives 20 % wrong and a command one sample late"
    );
    println!("contour error {:.2} µm RMS on the tuner's paths", tuned.rms_um);
    if let Some(output) = &arguments.output {
        write(output, profile.to_toml()?.as_bytes())?;
        println!("written      {}", output.display());
    }
    Ok(ExitCode::SUCCESS)
}

pub fn export_gains(arguments: &ExportArguments) -> Result<ExitCode, CliError> {
    let profile = DriveProfile::load(&arguments.profile)?;
    let kind = controller_of(&profile, arguments.controller)?;
    let text = match arguments.form {
        Form::Table => Some(export::table(&profile, kind)),
        Form::Linuxcnc => export::linuxcnc(&profile, kind),
    };
    let text = text.ok_or_else(|| {
        CliError::Argument(format!(
            "LinuxCNC's pid component cannot run {}: choose --controller p, pid or drive-ff",
            kind.names().1
        ))
    })?;
    print!("{text}");
    Ok(ExitCode::SUCCESS)
}

/// Range of the radius of a circular test, mm.
const RADII_MM: std::ops::RangeInclusive<f64> = 1.0..=1000.0;

pub fn ballbar(arguments: &BallbarArguments) -> Result<ExitCode, CliError> {
    refuse_same(&[&arguments.record], &given(&[arguments.output.as_ref(), arguments.picture.as_ref()]))?;
    if let Some(picture) = &arguments.picture {
        check_ending(picture, "svg")?;
    }
    let (radius_mm, feed) = (arguments.radius_mm, feed_mm_s(arguments.feed)? * 60.0);
    if !RADII_MM.contains(&radius_mm) {
        return Err(CliError::Argument(format!("--radius-mm {radius_mm} must be between 1 and 1000 mm")));
    }
    let found = CircularTest::load(&arguments.record, radius_mm)
        .map_err(|error| CliError::Argument(error.to_string()))?;
    let [most, least] = found.deviations_mm;
    let [at_most, at_least] = found.directions_deg;
    let points = found.points_mm.len();
    println!("points       {points}, about {:.4}, {:.4} mm", found.centre_mm.x, found.centre_mm.y);
    println!(
        "radius       {most:+.4} mm at {at_most:.0}°, {least:+.4} mm at {at_least:.0}°, {:.4} mm RMS",
        found.rms_mm
    );
    println!("circularity  {:.4} mm", found.circular_deviation_mm());
    println!(
        "contour error {:.4} mm, for feeds up to {feed:.0} mm/min on radii from {radius_mm} mm",
        found.term_mm()
    );
    let name = arguments.record.file_name().unwrap_or_default().to_string_lossy();
    if let Some(picture) = &arguments.picture {
        write(picture, found.svg(&name).as_bytes())?;
        println!("written      {}", picture.display());
    }
    if let (Some(machine), Some(output)) = (&arguments.machine_profile, &arguments.output) {
        let machine = MachineProfile::load(machine)?;
        let source =
            format!("circular test {name}, radius {radius_mm} mm, {feed:.0} mm/min, {points} points");
        let machine = MachineProfile {
            contour_error_mm: found.term_mm(),
            contour_error_source: ContourErrorSource::Measured(source),
            ..machine
        };
        write(output, machine.checked()?.to_toml().as_bytes())?;
        println!("written      {}", output.display());
    }
    Ok(ExitCode::SUCCESS)
}
