//! `isolux convert`.

use camino::Utf8PathBuf;
use clap::Args;
use isolux_app::Failure;
use isolux_app::convert::{self, Interpolation, Photometry, Wishes};
use isolux_app::files::Overwrite;

use super::reading::{Reading, compiler_style};
use crate::screen;

/// Any photometric or spectral format to any other, by extension; absolute candela are kept.
#[derive(Debug, Args)]
#[command(after_help = "Example: isolux convert luminaire.ldt luminaire.ies\n\
Exit 1 when the source has an error but could be written, 2 when nothing was written.")]
pub struct Convert {
    /// The file to read.
    source: Utf8PathBuf,
    /// The file to write: .ldt .ies .xml .json, or .spdx .spd .sp .spectrum .csv .json for a spectrum.
    target: Utf8PathBuf,
    /// Print the findings as `inspect --json` does.
    #[arg(long)]
    json: bool,
    /// Edition of the target: 2002 or 2019 (IES), 2018 or 2023 (TM-33).
    #[arg(long)]
    edition: Option<String>,
    /// File generation type of LM-63-2019, such as 1.10000; without it the source's own, else 1.00001 (undefined).
    #[arg(long, value_name = "TYPE")]
    generation: Option<String>,
    /// Coordinates of an IES file: type A, B or C; without it those of the source. Types A and B hold the half-space in front.
    #[arg(long, value_enum, ignore_case = true)]
    photometry: Option<Type>,
    /// Series of a spectrum that has several.
    #[arg(long)]
    series: Option<String>,
    /// Resample a spectrum at this step in nm; without it the file's own wavelengths are kept.
    #[arg(long, value_name = "STEP")]
    step_nm: Option<f64>,
    /// How values between the points are found: Sprague's polynomial (CIE 167, even spacing) or straight lines.
    #[arg(long, requires = "step_nm", value_enum, default_value_t = How::Sprague)]
    interpolation: How,
    /// Replace the target if it exists.
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    reading: Reading,
}

/// Photometric types of LM-63.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum Type {
    /// H about the vertical axis, V the elevation.
    A,
    /// V about the horizontal axis, H the elevation.
    B,
    /// C half-planes and γ.
    C,
}

/// Ways to resample.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum How {
    /// CIE 167; needs even spacing.
    Sprague,
    /// Any spacing.
    Linear,
}

/// Runs the command.
pub fn run(arguments: &Convert) -> Result<(), Failure> {
    let wishes = Wishes {
        read: arguments.reading.options(),
        edition: arguments.edition.clone(),
        generation: arguments.generation.clone(),
        photometry: arguments.photometry.map(|photometry| match photometry {
            Type::A => Photometry::A,
            Type::B => Photometry::B,
            Type::C => Photometry::C,
        }),
        series: arguments.series.clone(),
        resample: arguments.step_nm.map(|step_nm| {
            let how = match arguments.interpolation {
                How::Sprague => Interpolation::Sprague,
                How::Linear => Interpolation::Linear,
            };
            (step_nm, how)
        }),
    };
    let overwrite = Overwrite::asked(arguments.force);
    let (inspection, result) = convert::run(&arguments.source, &arguments.target, &wishes, overwrite);
    if let Some(inspection) = inspection {
        if arguments.json {
            screen::say(serde_json::to_string(&inspection).map_err(Failure::instrument)?);
        } else {
            for finding in &inspection.findings {
                screen::say(compiler_style(&inspection.file, finding));
            }
            if result.is_ok() {
                screen::say(format_args!("{} → {}", arguments.source, arguments.target));
            }
        }
    }
    result
}
