//! `isolux calibrate`.

use camino::Utf8PathBuf;
use clap::{Args, ValueEnum};
use isolux_app::Failure;
use isolux_app::calibration::{self, CalibrationRequest, Instrument};
use isolux_app::scan::Operator;

use super::takeover::TakeOver;
use crate::screen::{self, Bars};
use crate::terminal::Terminal;

/// Calibrates an instrument with a standard lamp: warm-up, spectra at several integration times, baffle, factors with
/// their uncertainty.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  isolux init lab --standard   a virtual bench under a standard lamp, and its \
certificate\n  isolux calibrate spectroradiometer lab/station.toml --standard lab/standard.toml --out \
lab/calibration\n  isolux calibrate luxmeter lab/station.toml --standard lab/standard.toml --out lab/lux\n\
Broken off: the same command goes on; complete: it computes again from the record. Exit 1: the record gives no \
calibration (another current, saturated, not linear, unsteady). Exit 2: the certificate has expired or does not fit."
)]
pub struct Calibrate {
    /// What is calibrated.
    #[arg(value_enum)]
    instrument: Kind,
    /// The bench with the standard lamp in it, STATION.toml.
    station: Utf8PathBuf,
    /// The certificate of the lamp, `isolux-standard/1`.
    #[arg(long, value_name = "CERTIFICATE.toml")]
    standard: Utf8PathBuf,
    /// The run directory to write.
    #[arg(long)]
    out: Utf8PathBuf,
    /// Days after which the calibration is due again.
    #[arg(long, value_name = "DAYS", default_value_t = calibration::VALID_DAYS,
        value_parser = clap::value_parser!(i32).range(1..=36_500))]
    valid_days: i32,
    #[command(flatten)]
    takeover: TakeOver,
    /// Print calibration.json.
    #[arg(long)]
    json: bool,
}

/// An instrument that can be calibrated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Kind {
    /// Factors over wavelength, from spectral irradiance.
    Spectroradiometer,
    /// One factor, from illuminance.
    Luxmeter,
}

/// Runs the command.
pub fn run(arguments: &Calibrate) -> Result<(), Failure> {
    let terminal = Terminal::of_stdin();
    let control = terminal.control();
    let operator = terminal.operator();
    let done = calibration::run(&CalibrationRequest {
        instrument: match arguments.instrument {
            Kind::Spectroradiometer => Instrument::Spectroradiometer,
            Kind::Luxmeter => Instrument::Luxmeter,
        },
        station: &arguments.station,
        standard: &arguments.standard,
        out: &arguments.out,
        valid_days: arguments.valid_days,
        force: arguments.takeover.reason(),
        operator: operator.as_ref().map(|operator| operator as &dyn Operator),
        control: &control,
        progress: &Bars::default(),
    })?;
    if arguments.json {
        screen::say(serde_json::to_string_pretty(&done.calibration).map_err(Failure::instrument)?)?;
        return Ok(());
    }
    done.calibration.sentences().into_iter().try_for_each(screen::say)?;
    screen::say(format_args!("{} in {}", done.files.join(", "), done.folder))?;
    screen::say("for the station:")?;
    done.calibration
        .station_lines()
        .into_iter()
        .try_for_each(|line| screen::say(format_args!("  {line}")))
}
