//! `isolux convert`.

use camino::Utf8PathBuf;
use clap::Args;
use isolux_app::Failure;
use isolux_app::files::Overwrite;
use isolux_app::formats::WriteOptions;
use isolux_app::formats::convert::{self, Edit, Interpolation, Options, Photometry, Symmetry};

use super::reading::{Reading, compiler_style, unshown};
use crate::screen;

/// Any photometric or spectral format to any other, by extension; absolute candela are kept.
#[derive(Debug, Args)]
#[command(after_help = "Example: isolux convert luminaire.ldt luminaire.ies\n\
         isolux convert luminaire.ldt turned.ldt --rotate-c 90 --scale-flux 1200 --set luminaire.name=\"Ring 2\"\n\
Edits are made in this order: --rotate-c, --symmetrize, --resample, --scale-flux, --set; each is noted in the file.\n\
Exit 1 when the source has an error but could be written, 2 when nothing was written.")]
pub struct Convert {
    /// The file to read.
    source: Utf8PathBuf,
    #[arg(help = format!("The file to write: {}", convert::targets()))]
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
    /// Coordinates of an IES file: type A, B or C; without it those of the source. Types A and B hold the half-space in
    /// front.
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
    /// Turn the light of a distribution about its axis: what was at C is then at C + DEG.
    #[arg(long, value_name = "DEG")]
    rotate_c: Option<f64>,
    /// Give every direction the mean of its images.
    #[arg(long, value_enum)]
    symmetrize: Option<Mirror>,
    /// Another grid of a distribution: steps of C and γ in degrees, such as 15,2.5.
    #[arg(long, value_name = "C,GAMMA", value_parser = steps)]
    resample: Option<(f64, f64)>,
    /// Scale intensities and lamps so that the luminaire gives this flux.
    #[arg(long, value_name = "LM")]
    scale_flux: Option<f64>,
    /// Change an entry of the description, such as luminaire.name=Ring; may be given more than once.
    #[arg(long, value_name = "KEY=TEXT", value_parser = entry)]
    set: Vec<(String, String)>,
    /// Replace the target if it exists.
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    reading: Reading,
}

/// Symmetries of EULUMDAT and LM-63.
#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum Mirror {
    /// One half-plane stands for all.
    Rotational,
    /// About the plane C0–C180.
    C0C180,
    /// About the plane C90–C270.
    C90C270,
    /// About both.
    Quadrant,
}

/// `15,2.5`.
fn steps(text: &str) -> Result<(f64, f64), String> {
    let pair = text
        .split_once(',')
        .map(|(c, gamma)| (c.trim().parse(), gamma.trim().parse()));
    match pair {
        Some((Ok(c), Ok(gamma))) => Ok((c, gamma)),
        _ => Err("two steps in degrees are needed, of C and of γ, such as 15,2.5".to_owned()),
    }
}

/// `luminaire.name=Ring`.
fn entry(text: &str) -> Result<(String, String), String> {
    let pair = text
        .split_once('=')
        .map(|(key, value)| (key.trim().to_owned(), value.trim().to_owned()));
    pair.ok_or_else(|| "KEY=TEXT is needed, such as luminaire.name=Ring".to_owned())
}

impl Convert {
    /// The edits in the order in which they are made, whatever their order on the command line.
    fn edits(&self) -> Vec<Edit> {
        let symmetrize = self.symmetrize.map(|mirror| {
            Edit::Symmetrize(match mirror {
                Mirror::Rotational => Symmetry::Rotational,
                Mirror::C0C180 => Symmetry::C0C180,
                Mirror::C90C270 => Symmetry::C90C270,
                Mirror::Quadrant => Symmetry::Quadrant,
            })
        });
        let set = self.set.iter().map(|(key, text)| Edit::Set(key.clone(), text.clone()));
        let light = [
            self.rotate_c.map(Edit::RotateC),
            symmetrize,
            self.resample.map(|(c, gamma)| Edit::Resample(c, gamma)),
            self.scale_flux.map(Edit::ScaleFlux),
        ];
        light.into_iter().flatten().chain(set).collect()
    }
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
    let requested = Options {
        read: arguments.reading.options(),
        write: WriteOptions {
            edition: arguments.edition.clone(),
            generation: arguments.generation.clone(),
            photometry: arguments.photometry.map(|photometry| match photometry {
                Type::A => Photometry::A,
                Type::B => Photometry::B,
                Type::C => Photometry::C,
            }),
            edited: false,
        },
        series: arguments.series.clone(),
        edits: arguments.edits(),
        resample: arguments.step_nm.map(|step_nm| {
            let how = match arguments.interpolation {
                How::Sprague => Interpolation::Sprague,
                How::Linear => Interpolation::Linear,
            };
            (step_nm, how)
        }),
    };
    let overwrite = Overwrite::requested(arguments.force);
    let (inspection, result) = convert::run(&arguments.source, &arguments.target, &requested, overwrite);
    if let Some(inspection) = inspection {
        if arguments.json {
            screen::say(serde_json::to_string(&inspection).map_err(Failure::instrument)?)?;
        } else {
            for finding in &inspection.findings {
                screen::say(compiler_style(&inspection.file, finding))?;
                if let Some(text) = unshown(finding.places().len() + finding.more()) {
                    screen::say(text)?;
                }
            }
            if result.is_ok() {
                screen::say(format_args!("{} → {}", arguments.source, arguments.target))?;
            }
        }
    }
    result
}
