//! `isolux plan`.

use camino::Utf8PathBuf;
use clap::Args;
use isolux_app::Failure;
use isolux_app::scan::duration;
use isolux_app::scan::plan;

use crate::screen;

/// Dry run of a plan: points, travel, time, limits, and what its distance costs. Opens no instrument.
#[derive(Debug, Args)]
#[command(after_help = "Example: isolux plan station.toml plan.toml\n\n\
The table gives standard uncertainties (k = 1) of the flux and of the largest intensity by distance: rounding of the display, \
noise, near field and the uncertainty of the distance. It needs estimates of the lamp in the station: [lamp] flux_lm, peak_cd, \
diameter_mm, and [luxmeter] noise_rel, noise_lx.")]
pub struct Plan {
    /// The bench, STATION.toml.
    station: Utf8PathBuf,
    /// What to measure, PLAN.toml.
    plan: Utf8PathBuf,
    /// Print the facts as JSON.
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(arguments: &Plan) -> Result<(), Failure> {
    let planned = plan::run(&arguments.station, &arguments.plan)?;
    if arguments.json {
        screen::say(serde_json::to_string(&planned).map_err(Failure::instrument)?)?;
        return Ok(());
    }
    let day = &planned.run;
    screen::say(format_args!(
        "{} points, {} reference visits, {} readings, {} spectra",
        day.points, day.references, day.readings, day.spectra
    ))?;
    screen::say(format_args!(
        "travel: C {:.0}°, γ {:.0}°",
        day.travel_c_deg, day.travel_gamma_deg
    ))?;
    screen::say(format_args!(
        "time: {} = warm-up {} + motion {} + readings {}",
        duration(day.total_s),
        duration(day.warm_up_s),
        duration(day.motion_s),
        duration(day.reading_s)
    ))?;
    for block in &day.blocks {
        screen::say(format_args!(
            "block {}: {} {} points at {} mm; {}",
            block.name, block.points, block.kind, block.distance_mm, block.distance_class
        ))?;
    }
    let table = planned.table();
    let width = |column: usize| table.iter().map(|line| line[column].chars().count()).max().unwrap_or(0);
    for line in &table {
        let cells = line.iter().enumerate().map(|(column, cell)| {
            let gap = " ".repeat(width(column) - cell.chars().count());
            format!("{gap}{cell}")
        });
        screen::say(cells.collect::<Vec<_>>().join("  "))?;
    }
    planned.proposal().iter().try_for_each(screen::say)?;
    if day.prompts > 0 {
        screen::say(format_args!("{} blocks ask a person", day.prompts))?;
    }
    day.notes
        .iter()
        .try_for_each(|note| screen::say(format_args!("note: {note}")))
}
