//! `isolux inspect`.

use camino::Utf8PathBuf;
use clap::Args;
use isolux_app::Failure;
use isolux_app::files::Overwrite;
use isolux_app::formats::inspect::{self, Action, Inspection, Meter};
use isolux_app::formats::plot;
use isolux_app::formats::{Finding, Severity};

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
    /// All findings, notes too, each with its place.
    #[arg(long)]
    all: bool,
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
    /// Half-plane C in degrees of the street side of an outdoor luminaire, for its zones and ratings (IES TM-15-11). If
    /// not given: C 90 of EULUMDAT, C 0 of LM-63, of a luminaire that sends more light there than to the other side.
    #[arg(long, value_name = "C_DEG", value_parser = c_deg)]
    street_side: Option<f64>,
    /// Rated colour temperature in K: adds the distance of every spectrum from that colour in steps of 0.0011 in u′v′.
    #[arg(long, value_name = "K", value_parser = rated_cct_k)]
    rated_cct: Option<f64>,
    /// An action spectrum (two columns: wavelength, value), such as the melanopic one of CIE S 026: adds the daylight
    /// efficacy ratio of every spectrum.
    #[arg(long, value_name = "FILE")]
    action: Option<Utf8PathBuf>,
    #[command(flatten)]
    reading: Reading,
}

/// A half-plane C.
fn c_deg(text: &str) -> Result<f64, String> {
    let degrees = text.trim().parse().ok().filter(|c: &f64| (0.0..360.0).contains(c));
    degrees.ok_or_else(|| "a half-plane C from 0 to below 360 is needed, in degrees".to_owned())
}

/// A colour temperature for which there is a colour.
fn rated_cct_k(text: &str) -> Result<f64, String> {
    let kelvins = text.trim().parse().ok().filter(|k: &f64| inspect::is_rated_cct_k(*k));
    kelvins.ok_or_else(|| "a colour temperature from 1000 to 25000 is needed, in K".to_owned())
}

/// Runs the command.
pub fn run(arguments: &Inspect) -> Result<(), Failure> {
    let overwrite = Overwrite::requested(arguments.force);
    let action = arguments.action.as_deref().map(Action::read).transpose()?;
    let meter = arguments
        .meter
        .as_ref()
        .map(|meter| Meter::read(meter, arguments.calibrated_with.as_deref()))
        .transpose()?;
    let options = arguments.reading.options();
    let looked_at = arguments.files.iter().flat_map(|file| inspect::file(file, options));
    let wrong = match &arguments.plot {
        None => tell(looked_at, arguments, meter.as_ref(), action.as_ref(), overwrite)?,
        Some(folder) => {
            // All pictures have their names before the first is drawn.
            let all: Vec<Inspection> = looked_at.collect();
            plot::plan(&all, folder, overwrite)?;
            tell(all.into_iter(), arguments, meter.as_ref(), action.as_ref(), overwrite)?
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
    action: Option<&Action>,
    overwrite: Overwrite,
) -> Result<usize, Failure> {
    let mut wrong = 0;
    for mut inspection in inspections {
        wrong += usize::from(inspection.has_error());
        if let Some(meter) = meter {
            inspection.seen_by(meter);
        }
        if let Some(street_side_c_deg) = arguments.street_side {
            inspection.facing(street_side_c_deg);
        }
        if let Some(rated_cct_k) = arguments.rated_cct {
            inspection.compared_with(rated_cct_k);
        }
        if let Some(action) = action {
            inspection.acting_by(action);
        }
        if arguments.json {
            let line = serde_json::to_string(&inspection).map_err(Failure::instrument)?;
            screen::say(line)?;
        } else {
            print(&inspection, arguments.all)?;
        }
        if let Some(folder) = &arguments.plot {
            for picture in plot::write(&inspection, folder, overwrite)? {
                if !arguments.json {
                    screen::say(format_args!("  → {picture}"))?;
                }
            }
        }
    }
    Ok(wrong)
}

/// What it is, its quantities, then its findings: a screen of them, or all.
fn print(inspection: &Inspection, all: bool) -> Result<(), Failure> {
    screen::say(format_args!("{}: {}", inspection.file, inspection.what()))?;
    for (name, text) in inspection.stated() {
        screen::say(format_args!("  {name:24} {text}"))?;
    }
    findings(inspection, all)
}

/// Findings that are shown without `--all`.
const A_SCREEN: usize = 8;

/// Errors first, then warnings, each with its first place. Notes, and all places, with `--all`.
fn findings(inspection: &Inspection, all: bool) -> Result<(), Failure> {
    let mut list: Vec<&Finding> = inspection.findings.iter().collect();
    list.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
    let shown = if all {
        list.len()
    } else {
        let loud = list.iter().filter(|finding| finding.severity > Severity::Note).count();
        loud.min(A_SCREEN)
    };
    for finding in &list[..shown] {
        screen::say(super::reading::compiler_style(&inspection.file, finding))?;
        let others = finding.places().len() + finding.more();
        if all {
            for place in finding.places() {
                screen::say(super::reading::place(&inspection.file, place))?;
            }
        }
        if let Some(text) = super::reading::unshown(if all { finding.more() } else { others }) {
            screen::say(text)?;
        }
    }
    let hidden = list.len() - shown;
    if hidden > 0 {
        let notes = list[shown..].iter().all(|finding| finding.severity == Severity::Note);
        let what = match (notes, hidden) {
            (true, 1) => "note",
            (true, _) => "notes",
            (false, 1) => "finding",
            (false, _) => "findings",
        };
        screen::say(format_args!("  {hidden} more {what}: --all"))?;
    }
    Ok(())
}
