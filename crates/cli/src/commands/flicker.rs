//! `isolux flicker`.

use camino::Utf8PathBuf;
use clap::Args;
use isolux_app::Failure;
use isolux_app::files::Overwrite;
use isolux_app::modulation::{self, LightModulation};

use crate::screen::{self, Bars};

/// Least sample rate of a record, Hz: ten times what SVM counts.
const LEAST_RATE_HZ: f64 = 20_000.0;

/// Temporal light modulation of a recorded waveform: depth, flicker index, SVM, PstLM, and what a camera sees.
#[derive(Debug, Args)]
#[command(after_help = "Examples: isolux flicker light.csv --dark 0.002 --out flicker\n\
         isolux flicker light.wav --dark 0 --limit-svm 0.4 --limit-pst 1\n\
         isolux flicker light.csv --rate 20000 --exposure 2 --exposure 10 --line-time 15\n\
         isolux flicker --from 'scpi-scope:tcp://192.168.1.7:5555?profile=ds1000z&channel=1' \
--duration 2 --dark 0.004 --out flicker\n\
Exit 1 where a limit is passed or its quantity is not given.")]
pub struct Flicker {
    /// CSV (one column, or time_s and a value) or WAV, of a photodiode with a DC-coupled input.
    #[arg(required_unless_present = "from", conflicts_with = "from")]
    file: Option<Utf8PathBuf>,
    /// Record from this instrument, `driver:target`, in place of a file; `isolux devices` lists drivers.
    #[arg(long, value_name = "ADDRESS", requires_all = ["duration", "out"])]
    from: Option<String>,
    /// Length of the record in s.
    #[arg(long, value_name = "S", requires = "from")]
    duration: Option<f64>,
    /// Sample rate in Hz, where the file has none; with --from the least one, 20000 where it is not given.
    #[arg(long, value_name = "HZ")]
    rate: Option<f64>,
    /// What the recorder shows in the dark, in units of the file; without it nothing has an uncertainty.
    #[arg(long, value_name = "VALUE", allow_negative_numbers = true)]
    dark: Option<f64>,
    /// Exposure time of a camera in ms; may be given more than once.
    #[arg(long, value_name = "MS")]
    exposure: Vec<f64>,
    /// Time from row to row of a rolling shutter in µs.
    #[arg(long, value_name = "US", requires = "exposure")]
    line_time: Option<f64>,
    /// Largest SVM that is allowed.
    #[arg(long, value_name = "SVM")]
    limit_svm: Option<f64>,
    /// Largest PstLM that is allowed.
    #[arg(long, value_name = "PST")]
    limit_pst: Option<f64>,
    /// Folder for modulation.json and figures.
    #[arg(long, value_name = "DIR")]
    out: Option<Utf8PathBuf>,
    /// Print modulation.json.
    #[arg(long)]
    json: bool,
    /// Replace files that exist.
    #[arg(long, requires = "out")]
    force: bool,
}

/// Runs the command.
pub fn run(arguments: &Flicker) -> Result<(), Failure> {
    let overwrite = Overwrite::requested(arguments.force);
    let (waveform, sample_rate_hz) = match (&arguments.from, &arguments.out, arguments.duration) {
        (Some(open), Some(out), Some(duration_s)) => {
            let least_rate_hz = arguments.rate.unwrap_or(LEAST_RATE_HZ);
            let acquisition = modulation::Acquisition {
                open,
                duration_s,
                least_rate_hz,
                out,
                overwrite,
            };
            (modulation::acquire(&acquisition, &Bars::default())?, None)
        }
        _ => (arguments.file.clone().unwrap_or_default(), arguments.rate),
    };
    let request = modulation::Request {
        light: LightModulation {
            waveform,
            sample_rate_hz,
            dark: arguments.dark,
            exposures_ms: arguments.exposure.clone(),
            line_time_us: arguments.line_time,
        },
        limit_svm: arguments.limit_svm,
        limit_pst: arguments.limit_pst,
        out: arguments.out.as_deref(),
        overwrite,
    };
    let (evaluated, written) = modulation::run(&request)?;
    if arguments.json {
        screen::say(serde_json::to_string_pretty(&evaluated).map_err(Failure::instrument)?)?;
    } else {
        evaluated.stated().iter().try_for_each(screen::say)?;
        written.iter().try_for_each(screen::say)?;
    }
    if evaluated.verdicts.iter().all(|verdict| verdict.passes) {
        Ok(())
    } else {
        Err(Failure::no("a limit is passed, or its quantity is not given"))
    }
}
