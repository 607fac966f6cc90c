//! `isolux calibrate`.

use camino::Utf8PathBuf;
use clap::{Args, ValueEnum};
use isolux_app::Failure;
use isolux_app::calibration::spectrometer::{self, Procedure};
use isolux_app::calibration::{self, AtBench, CalibrationRequest, Instrument};
use isolux_app::scan::Operator;

use super::takeover::TakeOver;
use crate::screen::{self, Bars};
use crate::terminal::Terminal;

/// Calibrates an instrument with a standard lamp: warm-up, spectra at several integration times, baffle, factors with
/// their uncertainty. Or finds what a spectroradiometer does itself: wavelength scale and bandpass, scattered light,
/// linearity.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  isolux init lab --standard   a virtual bench under a standard lamp, and its \
certificate\n  isolux calibrate spectroradiometer lab/station.toml --standard lab/standard.toml --out \
lab/calibration\n  isolux calibrate luxmeter lab/station.toml --standard lab/standard.toml --out lab/lux\n  \
isolux calibrate spectroradiometer lab/station-lines.toml --lines mercury_argon --out lab/lines\n  \
isolux calibrate spectroradiometer lab/station-filter.toml --cut-on lab/filter.toml --out lab/scatter\n  \
isolux calibrate spectroradiometer lab/station.toml --linearity --out lab/linearity\n\
Broken off: the same command goes on; complete: it computes again from the record. Exit 1: the record gives no \
calibration (another current, saturated, not linear, unsteady). Exit 2: the certificate has expired or does not fit."
)]
pub struct Calibrate {
    /// What is calibrated.
    #[arg(value_enum)]
    instrument: Kind,
    /// The bench with the standard lamp in it, STATION.toml.
    station: Utf8PathBuf,
    /// The certificate of the standard lamp, `isolux-standard/1`.
    #[arg(long, value_name = "CERTIFICATE.toml", required_unless_present_any = ["lines", "cut_on", "linearity"])]
    standard: Option<Utf8PathBuf>,
    /// Of a spectroradiometer: the lamp whose lines give wavelength scale and bandpass, `mercury_argon` or a list
    /// `isolux-lines/1`.
    #[arg(long, value_name = "LAMP", conflicts_with_all = ["standard", "cut_on", "linearity"])]
    lines: Option<String>,
    /// Of a spectroradiometer: the long-pass filter before its entrance that shows the light scattered inside,
    /// `isolux-filter/1`.
    #[arg(long, value_name = "FILTER.toml", conflicts_with_all = ["standard", "linearity"])]
    cut_on: Option<Utf8PathBuf>,
    /// Of a spectroradiometer: its linearity, from the light of a steady lamp at several integration times.
    #[arg(long, conflicts_with = "standard")]
    linearity: bool,
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
    let bench = AtBench {
        out: &arguments.out,
        force: arguments.takeover.reason(),
        operator: operator.as_ref().map(|operator| operator as &dyn Operator),
        control: &control,
        progress: &Bars::default(),
    };
    let Some(standard) = &arguments.standard else {
        return of_the_instrument(arguments, &bench);
    };
    let done = calibration::run(&CalibrationRequest {
        instrument: match arguments.instrument {
            Kind::Spectroradiometer => Instrument::Spectroradiometer,
            Kind::Luxmeter => Instrument::Luxmeter,
        },
        station: &arguments.station,
        standard,
        valid_days: arguments.valid_days,
        out: bench.out,
        force: bench.force,
        operator: bench.operator,
        control: bench.control,
        progress: bench.progress,
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

/// A procedure that finds something of a spectroradiometer itself.
fn of_the_instrument(arguments: &Calibrate, bench: &AtBench<'_>) -> Result<(), Failure> {
    if arguments.instrument != Kind::Spectroradiometer {
        return Err(Failure::bad_input(
            "--lines, --cut-on and --linearity are of a spectroradiometer; a lux meter is calibrated with --standard",
        ));
    }
    let procedure = match (&arguments.lines, &arguments.cut_on) {
        (Some(lamp), _) => Procedure::lines(lamp)?,
        (None, Some(filter)) => Procedure::cut_on(filter)?,
        (None, None) => Procedure::Linearity,
    };
    let done = spectrometer::run(&procedure, &arguments.station, bench)?;
    if arguments.json {
        return screen::say(serde_json::to_string_pretty(&done.found).map_err(Failure::instrument)?);
    }
    done.found.sentences().into_iter().try_for_each(screen::say)?;
    screen::say(format_args!("{} in {}", done.files.join(", "), done.folder))?;
    screen::say("for the station:")?;
    let lines = done.found.station_lines();
    lines
        .into_iter()
        .try_for_each(|line| screen::say(format_args!("  {line}")))
}
