//! `isolux sweep` and `isolux merge`.

use camino::Utf8PathBuf;
use clap::Args;
use isolux_app::Failure;
use isolux_app::files::Overwrite;
use isolux_app::simulation::sweep::{self, Shard};

use crate::screen::{self, Bars};

/// Simulate a scene for every combination of varied keys.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  isolux sweep distances.sweep.toml --out distances\n  \
isolux sweep distances.sweep.toml --out shard3 --shard 3/8   (then: isolux merge shard* --out distances)")]
pub struct Sweep {
    /// A file of format isolux-sweep/1: scene, method, and under `[vary]` lines of `"key" = [values]`.
    file: Utf8PathBuf,
    /// Folder of the table and its charts.
    #[arg(long)]
    out: Utf8PathBuf,
    /// Compute the I-th of N parts only, I from 1.
    #[arg(long, value_name = "I/N", value_parser = shard)]
    shard: Option<Shard>,
    /// Print sweep.json to standard output.
    #[arg(long)]
    json: bool,
    /// Replace results that are there.
    #[arg(long)]
    force: bool,
}

/// Put the shards of a sweep together: the same bytes as one run.
#[derive(Debug, Args)]
#[command(after_help = "Example: isolux merge shard1 shard2 shard3 shard4 --out distances")]
pub struct Merge {
    /// Folders of all shards.
    #[arg(required = true)]
    shards: Vec<Utf8PathBuf>,
    /// Folder of the whole.
    #[arg(long)]
    out: Utf8PathBuf,
    /// Print sweep.json to standard output.
    #[arg(long)]
    json: bool,
    /// Replace results that are there.
    #[arg(long)]
    force: bool,
}

/// Runs `sweep`.
pub fn run(arguments: &Sweep) -> Result<(), Failure> {
    let overwrite = Overwrite::requested(arguments.force);
    let points = sweep::run(
        &arguments.file,
        &arguments.out,
        arguments.shard,
        overwrite,
        &Bars::default(),
    )?;
    say(&arguments.out, points, arguments.json)
}

/// Runs `merge`.
pub fn merge(arguments: &Merge) -> Result<(), Failure> {
    let overwrite = Overwrite::requested(arguments.force);
    let points = sweep::merge(&arguments.shards, &arguments.out, overwrite)?;
    say(&arguments.out, points, arguments.json)
}

fn say(out: &Utf8PathBuf, points: usize, json: bool) -> Result<(), Failure> {
    if json {
        let text = isolux_app::files::read(&out.join("sweep.json"))?;
        screen::say(String::from_utf8_lossy(&text).trim_end())?;
    } else {
        screen::say(format_args!(
            "{points} points in {out}: sweep.json, sweep.csv, a chart a key"
        ))?;
    }
    Ok(())
}

fn shard(text: &str) -> Result<Shard, String> {
    let wrong = || format!("`{text}`: expected I/N with I from 1 to N");
    let (number, of) = text.split_once('/').ok_or_else(wrong)?;
    let (number, of) = (number.parse().map_err(|_| wrong())?, of.parse().map_err(|_| wrong())?);
    if number >= 1 && number <= of {
        Ok(Shard { number, of })
    } else {
        Err(wrong())
    }
}
