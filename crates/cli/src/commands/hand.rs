//! `isolux home`, `move`, `stop`, `read`, `warmup`: one step of the day by hand.

use camino::Utf8PathBuf;
use clap::Args;
use isolux_app::scan::duration;
use isolux_app::{Failure, hand, stop};
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

/// Moves the axes and waits until they rest where they were sent.
#[derive(Debug, Args)]
#[command(after_help = "Example: isolux move station.toml --c 90 --gamma -30")]
pub struct Move {
    /// The bench, STATION.toml.
    station: Utf8PathBuf,
    /// Target of the C axis in degrees; without it C stays.
    #[arg(long, allow_negative_numbers = true, required_unless_present = "gamma")]
    c: Option<f64>,
    /// Target of the γ axis in degrees, signed; without it γ stays.
    #[arg(long, allow_negative_numbers = true)]
    gamma: Option<f64>,
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

/// Reads the lux meter, with lamp, shutter and baffle as they are.
#[derive(Debug, Args)]
#[command(after_help = "Example: isolux read station.toml --count 10")]
pub struct Read {
    /// The bench, STATION.toml.
    station: Utf8PathBuf,
    /// Readings to take.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    count: u32,
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
    let at = hand::home(&arguments.station, arguments.takeover.reason())?;
    tell(arguments.json, &at, || {
        format!("homed: C {:.4}°, γ {:.4}°", at.c_deg, at.gamma_deg)
    })
}

/// Runs `move`.
pub fn move_to(arguments: &Move) -> Result<(), Failure> {
    let at = hand::move_to(
        &arguments.station,
        arguments.c,
        arguments.gamma,
        arguments.takeover.reason(),
    )?;
    tell(arguments.json, &at, || {
        format!("at rest: C {:.4}°, γ {:.4}°", at.c_deg, at.gamma_deg)
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
    let readings = hand::read(&arguments.station, arguments.count, arguments.takeover.reason())?;
    tell(arguments.json, &readings, || {
        let lines: Vec<String> = readings
            .iter()
            .map(|reading| {
                let shown = reading
                    .illuminance_lx
                    .map_or_else(|| reading.quality.to_owned(), |lux| format!("{lux:.4} lx"));
                format!("{shown}  range {}  digit {} lx", reading.range, reading.digit_lx)
            })
            .collect();
        lines.join("\n")
    })
}

/// Runs `warmup`.
pub fn warm_up(arguments: &Warmup) -> Result<(), Failure> {
    let stable = hand::warm_up(&arguments.station, arguments.takeover.reason(), &Bars::default())?;
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
