//! `isolux plan`.

use camino::Utf8PathBuf;
use clap::Args;
use isolux_app::Failure;
use isolux_app::files::{self, Overwrite};
use isolux_app::scan::{duration, for_sensor, plan};

use crate::screen;

/// Dry run of a plan: points, travel, time, limits, and what its distance costs. Opens no instrument.
#[derive(Debug, Args)]
#[command(after_help = "Example: isolux plan station.toml plan.toml\n  \
isolux plan station.toml plan.toml --for scene.toml --u 0.005 --out near.toml\n\n\
The table gives standard uncertainties (k = 1) of the flux and of the largest intensity by distance: rounding of the display, \
noise, near field and the uncertainty of the distance. It needs estimates of the lamp in the station: [lamp] flux_lm, peak_cd, \
diameter_mm, and [luxmeter] noise_rel, noise_lx.\n\n\
With --for the plan is made anew for the sensor of a scene alone: the directions from which light reaches it, and as many \
half-planes, γ and readings as its mean and its most uncertain place need for --u. What a grid loses is computed on the \
scene's luminaire, or where its model is not there yet on the lobe of flux_lm and peak_cd.")]
pub struct Plan {
    /// The bench, STATION.toml.
    station: Utf8PathBuf,
    /// What to measure, PLAN.toml.
    plan: Utf8PathBuf,
    /// Make the plan anew for the sensor of this scene alone, SCENE.toml.
    #[arg(long = "for", value_name = "SCENE.toml")]
    scene: Option<Utf8PathBuf>,
    /// Relative standard uncertainty (k = 1) of the irradiance on that sensor.
    #[arg(long = "u", value_name = "U", default_value_t = 0.005, requires = "scene", value_parser = relative)]
    u_rel: f64,
    /// The file of that plan; without it the plan is printed.
    #[arg(long, value_name = "PLAN.toml", requires = "scene")]
    out: Option<Utf8PathBuf>,
    /// Replace that file.
    #[arg(long, requires = "out")]
    force: bool,
    /// Print the facts as JSON.
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(arguments: &Plan) -> Result<(), Failure> {
    if let Some(scene) = &arguments.scene {
        return for_sensor(arguments, scene);
    }
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
    for sentence in &planned.not_claimable {
        screen::say(format_args!("not to be claimed: {sentence}"))?;
    }
    day.notes
        .iter()
        .try_for_each(|note| screen::say(format_args!("note: {note}")))
}

fn for_sensor(arguments: &Plan, scene: &Utf8PathBuf) -> Result<(), Failure> {
    let made = for_sensor::propose(&arguments.station, &arguments.plan, scene, arguments.u_rel)?;
    if let Some(out) = &arguments.out {
        files::write(out, made.text.as_bytes(), Overwrite::requested(arguments.force))?;
    }
    if arguments.json {
        return screen::say(serde_json::to_string(&made).map_err(Failure::instrument)?);
    }
    made.sentences().iter().try_for_each(screen::say)?;
    match &arguments.out {
        Some(out) => screen::say(format_args!("the plan is {out}")),
        None => screen::say(format_args!("\n{}", made.text.trim_end())),
    }
}

fn relative(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(value) if value > 0.0 && value < 1.0 => Ok(value),
        _ => Err("a relative uncertainty is above 0 and below 1, as 0.005".to_owned()),
    }
}
