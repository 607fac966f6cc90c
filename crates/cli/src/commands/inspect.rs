//! `isolux inspect`.

use camino::Utf8PathBuf;
use clap::Args;
use isolux_app::Failure;
use isolux_app::files::Overwrite;
use isolux_app::inspect::{self, Inspection, Meter};
use isolux_app::plot;

use super::reading::Reading;
use crate::screen;

/// Facts, quantities and findings of photometric and spectral files.
#[derive(Debug, Args)]
#[command(after_help = "Example: isolux inspect luminaire.ldt lamp.ies --json\n\
         isolux inspect led.spdx --meter v-lambda-head.csv --calibrated-with lamp-a.csv\n\
Exit 1 when any file has a finding of level error.")]
pub struct Inspect {
    /// Files of any known format.
    #[arg(required = true)]
    files: Vec<Utf8PathBuf>,
    /// One JSON object a line and file.
    #[arg(long)]
    json: bool,
    /// Draw the content as SVG files into this folder.
    #[arg(long, value_name = "DIR")]
    plot: Option<Utf8PathBuf>,
    /// Replace pictures that exist.
    #[arg(long, requires = "plot")]
    force: bool,
    /// A meter's relative responsivity: adds the spectral mismatch correction factor of every spectrum.
    #[arg(long, value_name = "FILE")]
    meter: Option<Utf8PathBuf>,
    /// The spectrum that the meter was calibrated with; CIE illuminant A if not given.
    #[arg(long, value_name = "FILE", requires = "meter")]
    calibrated_with: Option<Utf8PathBuf>,
    #[command(flatten)]
    reading: Reading,
}

/// Runs the command.
pub fn run(arguments: &Inspect) -> Result<(), Failure> {
    let overwrite = Overwrite::asked(arguments.force);
    let meter = arguments
        .meter
        .as_ref()
        .map(|meter| Meter::read(meter, arguments.calibrated_with.as_deref()))
        .transpose()?;
    let options = arguments.reading.options();
    let looked_at = arguments.files.iter().flat_map(|file| inspect::file(file, options));
    let wrong = match &arguments.plot {
        None => tell(looked_at, arguments, meter.as_ref(), overwrite)?,
        Some(folder) => {
            // All pictures have their names before the first is drawn.
            let all: Vec<Inspection> = looked_at.collect();
            plot::plan(&all, folder, overwrite)?;
            tell(all.into_iter(), arguments, meter.as_ref(), overwrite)?
        }
    };
    match wrong {
        0 => Ok(()),
        1 => Err(Failure::no("one file has an error")),
        many => Err(Failure::no(format!("{many} files have errors"))),
    }
}

/// Prints and draws; how many files have an error.
fn tell(
    inspections: impl Iterator<Item = Inspection>,
    arguments: &Inspect,
    meter: Option<&Meter>,
    overwrite: Overwrite,
) -> Result<usize, Failure> {
    let mut wrong = 0;
    for mut inspection in inspections {
        wrong += usize::from(inspection.has_error());
        if let Some(meter) = meter {
            inspection.seen_by(meter);
        }
        if arguments.json {
            let line = serde_json::to_string(&inspection).map_err(Failure::instrument)?;
            screen::say(line);
        } else {
            print(&inspection);
        }
        if let Some(folder) = &arguments.plot {
            for picture in plot::write(&inspection, folder, overwrite)? {
                if !arguments.json {
                    screen::say(format_args!("  → {picture}"));
                }
            }
        }
    }
    Ok(wrong)
}

fn print(inspection: &Inspection) {
    let name = |value: serde_json::Result<String>| value.unwrap_or_default().trim_matches('"').to_owned();
    let format = name(serde_json::to_string(&inspection.format));
    let kind = name(serde_json::to_string(&inspection.kind));
    screen::say(format_args!(
        "{}: {format}, {kind}{}",
        inspection.file,
        if inspection.readable { "" } else { ", not readable" }
    ));
    for finding in &inspection.findings {
        screen::say(super::reading::compiler_style(&inspection.file, finding));
    }
    if let Some(check) = &inspection.self_check {
        screen::say(format_args!("  {:20} along γ {}", "self_check", check.along_gamma));
        if check.across_planes.exchanges > 0 {
            screen::say(format_args!("  {:20} across planes {}", "", check.across_planes));
        }
    }
    super::quantities::print(inspection.quantities.iter());
}
