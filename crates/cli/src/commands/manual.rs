//! `isolux home`, `move`, `stop`, `read`, `warmup`: one step of the day by hand.

use camino::Utf8PathBuf;
use clap::Args;
use isolux_app::Failure;
use isolux_app::manual::Output;
use isolux_app::manual::{self, spectrum, stop};
use isolux_app::scan::duration;
use serde::Serialize;

use super::takeover::TakeOver;
use crate::screen::{self, Bars};

/// Finds the reference of both axes. Moves them.
#[derive(Debug, Args)]
#[command(after_help = "Example: isolux home station.toml")]
pub struct Home {
    /// The bench, STATION.toml.
    station: Utf8PathBuf,
    #[command(flatten)]
    takeover: TakeOver,
    /// Print the facts as JSON.
    #[arg(long)]
    json: bool,
}

/// Switches lamp, supply, shutter and baffle, and reads back what they are.
#[derive(Debug, Args)]
#[command(after_help = "Example: isolux switch station.toml --lamp on --shutter open")]
#[group(required = true, multiple = true, id = "outputs", args = ["lamp", "shutter", "baffle", "supply"])]
pub struct Switch {
    /// The bench, STATION.toml.
    station: Utf8PathBuf,
    /// The lamp.
    #[arg(long, value_parser = ["on", "off"])]
    lamp: Option<String>,
    /// The shutter before the detectors.
    #[arg(long, value_parser = ["open", "closed"])]
    shutter: Option<String>,
    /// The baffle: in the beam or out of it.
    #[arg(long, value_parser = ["in", "out"])]
    baffle: Option<String>,
    /// The supply that feeds the lamp; it switches the lamp.
    #[arg(long, value_parser = ["on", "off"], conflicts_with = "lamp")]
    supply: Option<String>,
    #[command(flatten)]
    takeover: TakeOver,
    /// Print the facts as JSON.
    #[arg(long)]
    json: bool,
}

/// Moves axes and detector and waits until they rest where they were sent.
#[derive(Debug, Args)]
#[command(after_help = "Example: isolux move station.toml --c 90 --gamma -30")]
pub struct Move {
    /// The bench, STATION.toml.
    station: Utf8PathBuf,
    /// Target of the C axis in degrees; without it C stays.
    #[arg(long, required_unless_present_any = ["gamma", "distance_mm"])]
    c: Option<f64>,
    /// Target of the γ axis in degrees, signed; without it γ stays.
    #[arg(long)]
    gamma: Option<f64>,
    /// Distance of the detector in mm, where a rail drives it; without it the detector stays.
    #[arg(long, value_name = "MM")]
    distance_mm: Option<f64>,
    #[command(flatten)]
    takeover: TakeOver,
    /// Print the facts as JSON.
    #[arg(long)]
    json: bool,
}

/// Stops every axis from any state and verifies that it stands still, also under a scan of another process.
#[derive(Debug, Args)]
#[command(after_help = "Example: isolux stop station.toml\n\
The process that has the instruments is asked to end first; from one that hangs they are taken, and it can drive them no more.")]
pub struct Stop {
    /// The bench, STATION.toml.
    station: Utf8PathBuf,
    /// Print the facts as JSON.
    #[arg(long)]
    json: bool,
}

/// Reads the lux meter and the power meter, or one spectrum, with lamp, shutter and baffle as they are.
#[derive(Debug, Args)]
#[command(after_help = "Example: isolux read station.toml --count 10\n\
With --spectrum: the integration time is found first; an instrument without dark pixels closes the station's shutter for its dark and \
puts it back. --json holds the spectrum itself.")]
pub struct Read {
    /// The bench, STATION.toml.
    station: Utf8PathBuf,
    /// Readings to take.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    count: u32,
    /// One spectrum with its colorimetry instead.
    #[arg(long, conflicts_with = "count")]
    spectrum: bool,
    #[command(flatten)]
    takeover: TakeOver,
    /// Print the facts as JSON.
    #[arg(long)]
    json: bool,
}

/// Switches the lamp on and waits until it is stable (EN 13032-4: 30 min on, 0.5 % over the last 15 min).
#[derive(Debug, Args)]
#[command(after_help = "Example: isolux warmup station.toml")]
pub struct Warmup {
    /// The bench, STATION.toml.
    station: Utf8PathBuf,
    #[command(flatten)]
    takeover: TakeOver,
    /// Print the facts as JSON.
    #[arg(long)]
    json: bool,
}

/// Runs `home`.
pub fn home(arguments: &Home) -> Result<(), Failure> {
    let at = manual::home(&arguments.station, arguments.takeover.reason(), &Bars::default())?;
    tell(arguments.json, &at, || {
        format!("homed: C {:.4}°, γ {:.4}°", at.c_deg, at.gamma_deg)
    })
}

/// Runs `move`.
pub fn move_to(arguments: &Move) -> Result<(), Failure> {
    let at = manual::move_to(
        &arguments.station,
        arguments.c,
        arguments.gamma,
        arguments.distance_mm,
        arguments.takeover.reason(),
        &Bars::default(),
    )?;
    tell(arguments.json, &at, || {
        let distance = at
            .distance_mm
            .map_or(String::new(), |mm| format!(", detector at {mm:.2} mm"));
        format!("at rest: C {:.4}°, γ {:.4}°{distance}", at.c_deg, at.gamma_deg)
    })
}

/// Runs `switch`.
pub fn switch(arguments: &Switch) -> Result<(), Failure> {
    let requested = [
        (Output::Lamp, &arguments.lamp),
        (Output::Shutter, &arguments.shutter),
        (Output::Baffle, &arguments.baffle),
        (Output::Supply, &arguments.supply),
    ];
    let on = |word: &String| matches!(word.as_str(), "on" | "open" | "in");
    let requested: Vec<(Output, bool)> = requested
        .into_iter()
        .filter_map(|(output, word)| Some((output, on(word.as_ref()?))))
        .collect();
    let states = manual::switch(
        &arguments.station,
        &requested,
        arguments.takeover.reason(),
        &Bars::default(),
    )?;
    let facts: std::collections::BTreeMap<&str, bool> =
        states.iter().map(|(output, on)| (output.name(), *on)).collect();
    tell(arguments.json, &facts, || {
        let word = |(output, on): &(Output, bool)| match (output, on) {
            (Output::Lamp, true) => "lamp on",
            (Output::Lamp, false) => "lamp off",
            (Output::Shutter, true) => "shutter open",
            (Output::Shutter, false) => "shutter closed",
            (Output::Baffle, true) => "baffle in the beam",
            (Output::Baffle, false) => "baffle out of the beam",
            (Output::Supply, true) => "supply on",
            (Output::Supply, false) => "supply off",
        };
        states.iter().map(word).collect::<Vec<_>>().join(", ")
    })
}

/// Runs `stop`.
pub fn stop(arguments: &Stop) -> Result<(), Failure> {
    let stopped = stop::stop(&arguments.station)?;
    tell(arguments.json, &stopped, || {
        let at = stopped.at;
        let rest = format!(
            "stopped and verified at rest: C {:.4}°, γ {:.4}°",
            at.c_deg, at.gamma_deg
        );
        std::iter::once(rest)
            .chain(stopped.owner.iter().cloned())
            .collect::<Vec<_>>()
            .join("\n")
    })
}

/// Runs `read`.
pub fn read(arguments: &Read) -> Result<(), Failure> {
    if arguments.spectrum {
        let reading = spectrum::read(&arguments.station, arguments.takeover.reason(), &Bars::default())?;
        return tell(arguments.json, &reading, || colorimetry(&reading));
    }
    let readings = manual::read(
        &arguments.station,
        arguments.count,
        arguments.takeover.reason(),
        &Bars::default(),
    )?;
    tell(arguments.json, &readings, || {
        let lines: Vec<String> = readings
            .iter()
            .map(|reading| {
                let shown = reading
                    .illuminance_lx
                    .map_or_else(|| reading.quality.to_owned(), |lux| format!("{lux:.4} lx"));
                let line = format!("{shown}  range {}  digit {} lx", reading.range, reading.digit_lx);
                match reading.electrical() {
                    Some(electrical) => format!("{line}  {electrical}"),
                    None => line,
                }
            })
            .collect();
        lines.join("\n")
    })
}

/// One line a quantity, with its unit.
fn colorimetry(reading: &spectrum::Reading) -> String {
    let colour = &reading.quantities;
    let shown = |value: Option<f64>, digits: usize| value.map_or("–".to_owned(), |value| format!("{value:.digits$}"));
    let saturated = match reading.saturated_pixels {
        0 => String::new(),
        count => format!(", {count} pixels saturated: their values are \"at least\""),
    };
    [
        format!("illuminance        {:.3} lx", reading.illuminance_lx),
        format!("irradiance         {:.5} W/m² (360–830 nm)", reading.irradiance_w_m2),
        format!("chromaticity       x {}  y {}", shown(colour.x, 4), shown(colour.y, 4)),
        format!(
            "colour temperature {} K, Duv {}",
            shown(colour.cct_k, 0),
            shown(colour.duv, 4)
        ),
        format!(
            "colour rendering   Ra {}  Rf {}  Rg {}",
            shown(colour.ra, 1),
            shown(colour.rf, 1),
            shown(colour.rg, 1)
        ),
        format!(
            "peak               {} nm, FWHM {} nm",
            shown(colour.peak_nm, 1),
            shown(colour.fwhm_nm, 1)
        ),
        format!(
            "exposure           {:.4} s, peak at {:.0} % of saturation{saturated}; dark by {}",
            reading.integration_s,
            reading.peak_of_saturation * 100.0,
            reading.dark.replace('_', " "),
        ),
    ]
    .join("\n")
}

/// Runs `warmup`.
pub fn warm_up(arguments: &Warmup) -> Result<(), Failure> {
    let stable = manual::warm_up(&arguments.station, arguments.takeover.reason(), &Bars::default())?;
    tell(arguments.json, &stable, || {
        format!(
            "lamp stable after {}: {:.2} % over the window, {:.4} lx at C 0°, γ 0°",
            duration(stable.elapsed_s),
            stable.spread_rel * 100.0,
            stable.illuminance_lx
        )
    })
}

fn tell(json: bool, facts: &impl Serialize, words: impl FnOnce() -> String) -> Result<(), Failure> {
    if json {
        screen::say(serde_json::to_string(facts).map_err(Failure::instrument)?)?;
    } else {
        screen::say(words())?;
    }
    Ok(())
}
