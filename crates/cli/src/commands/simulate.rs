//! `isolux simulate`.

use camino::Utf8PathBuf;
use clap::{Args, ValueEnum};
use isolux_app::Failure;
use isolux_app::files::Overwrite;
use isolux_app::simulation::scene::Changes;
use isolux_app::simulation::simulate::{self, Accuracy, Facts, Method, SimulateRequest};

use super::count;
use crate::screen::{self, Bars};

/// Light a sensor: irradiance.npy, irradiance.png and result.json.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  isolux simulate scene.toml --out lit\n  \
isolux simulate luminaire.ldt --spectrum lamp.spdx --distance-mm 500 --sensor-mm 24.576 --pixels 2048 --out lit\n  \
isolux simulate scene.toml --method direct --sampling thinned --rays 2e9 --seed 7 --out rays")]
pub struct Simulate {
    /// A scene or model file, a run folder, or a photometric file.
    input: Utf8PathBuf,
    /// Folder of the results.
    #[arg(long)]
    out: Utf8PathBuf,
    /// Quadrature without noise, or rays.
    #[arg(long, value_enum, default_value = "inverse")]
    method: MethodWord,
    /// How far the inverse map may be off: 1e-5 of a pixel, or 1e-6, many times slower [default: the scene's
    /// simulation.accuracy, else standard].
    #[arg(long, value_enum)]
    accuracy: Option<AccuracyWord>,
    /// How rays are drawn, with --method direct; all three have the same law [default: thinned].
    #[arg(long, value_enum)]
    sampling: Option<SamplingWord>,
    /// Rays over the whole sphere, with --method direct [default: 2e9].
    #[arg(long, value_parser = count)]
    rays: Option<u64>,
    /// Seed of every random number, with --method direct [default: 1].
    #[arg(long)]
    seed: Option<u64>,
    /// Spectrum file in place of the model's.
    #[arg(long)]
    spectrum: Option<Utf8PathBuf>,
    /// Distance of the sensor's centre along γ = 0, mm.
    #[arg(long)]
    distance_mm: Option<f64>,
    /// Width and height of the sensor, mm.
    #[arg(long, value_name = "W[,H]", value_parser = one_or_two::<f64>)]
    sensor_mm: Option<Pair<f64>>,
    /// Pixels along x and y.
    #[arg(long, value_name = "N[,M]", value_parser = one_or_two_counts)]
    pixels: Option<Pair<u64>>,
    /// Change a key of the scene, such as sensor.tilt_x_deg=5; may be given again.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Let the light leave from the luminous area that the photometric file states, not from a point.
    #[arg(long)]
    luminous_area: bool,
    /// Write N rays that reach the sensor to FILE (.json, or IES TM-25 as .tm25ray).
    #[arg(long, num_args = 2, value_names = ["FILE", "N"])]
    rays_out: Option<Vec<String>>,
    /// Also irradiance.tiff, 32-bit float.
    #[arg(long)]
    tiff: bool,
    /// Also irradiance.csv.
    #[arg(long)]
    csv: bool,
    /// Also sensor.html: map, sections, and the scene with rays in three dimensions.
    #[arg(long)]
    html: bool,
    /// Say whether this simulation differs from an earlier one by more than their noise.
    #[arg(long, value_name = "DIR")]
    against: Option<Utf8PathBuf>,
    /// Print result.json to standard output.
    #[arg(long)]
    json: bool,
    /// Replace results that are there.
    #[arg(long)]
    force: bool,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum MethodWord {
    Inverse,
    Direct,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum AccuracyWord {
    Standard,
    Reference,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum SamplingWord {
    Traced,
    Thinned,
    Expected,
}

/// One number for both sides, or one for each.
type Pair<T> = [T; 2];

/// Runs the command.
pub fn run(arguments: &Simulate) -> Result<(), Failure> {
    let method = method(arguments)?;
    let rays_out = match arguments.rays_out.as_deref() {
        Some([file, wanted]) => {
            let wanted = count(wanted).map_err(|error| Failure::bad_input(format!("--rays-out {file}: {error}")))?;
            Some((
                Utf8PathBuf::from(file),
                usize::try_from(wanted).map_err(Failure::bad_input)?,
            ))
        }
        _ => None,
    };
    let request = SimulateRequest {
        input: arguments.input.clone(),
        out: arguments.out.clone(),
        overwrite: Overwrite::requested(arguments.force),
        method,
        changes: Changes {
            spectrum: arguments.spectrum.clone(),
            distance_mm: arguments.distance_mm,
            sensor_mm: arguments.sensor_mm,
            pixels: arguments.pixels,
            accuracy: arguments.accuracy.map(|word| match word {
                AccuracyWord::Standard => Accuracy::Standard,
                AccuracyWord::Reference => Accuracy::Reference,
            }),
            set: arguments.set.clone(),
            luminous_area: arguments.luminous_area,
        },
        rays_out,
        against: arguments.against.clone(),
        tiff: arguments.tiff,
        csv: arguments.csv,
        html: arguments.html,
    };
    let facts = simulate::run(&request, &Bars::default())?;
    if arguments.json {
        screen::say(serde_json::to_string_pretty(&facts).map_err(Failure::instrument)?)?;
    } else {
        print(&facts, arguments)?;
    }
    Ok(())
}

/// The method; what belongs to rays is refused where there are none, not left aside.
fn method(arguments: &Simulate) -> Result<Method, Failure> {
    if let MethodWord::Inverse = arguments.method {
        let of_rays = [
            ("--sampling", arguments.sampling.is_some()),
            ("--rays", arguments.rays.is_some()),
            ("--seed", arguments.seed.is_some()),
        ];
        if let Some((option, _)) = of_rays.into_iter().find(|(_, given)| *given) {
            return Err(
                Failure::bad_input(format!("{option} is of the rays, and the inverse method draws none"))
                    .help(format!("give --method direct with it, or leave {option} out")),
            );
        }
        return Ok(Method::Inverse);
    }
    Ok(Method::Direct {
        sampling: match arguments.sampling {
            Some(SamplingWord::Traced) => simulate::Sampling::Traced,
            Some(SamplingWord::Thinned) | None => simulate::Sampling::Thinned,
            Some(SamplingWord::Expected) => simulate::Sampling::Expected,
        },
        rays: arguments.rays.unwrap_or(2_000_000_000),
        seed: arguments.seed.unwrap_or(1),
    })
}

fn print(facts: &Facts, arguments: &Simulate) -> Result<(), Failure> {
    let unit = facts.unit.symbol();
    screen::say(format_args!("mean        {}", simulate::mean(facts)))?;
    screen::say(format_args!("computation {}", simulate::numeric(facts, unit)))?;
    if let (Some(accuracy), Some(bound)) = (&facts.accuracy, facts.pixel_error_bound) {
        screen::say(format_args!(
            "error       {}: no pixel is off by more than {:.1e} {unit} or {:.1e} of itself; allowed are {:.0e} of a pixel, and of \
             {:.0e} of the largest where it is dimmer",
            accuracy.name, bound.absolute, bound.relative, accuracy.relative, accuracy.dim
        ))?;
    }
    screen::say(format_args!("min, max    {:.6}, {:.6} {unit}", facts.min, facts.max))?;
    if let (Some(on_sensor), Some(law)) = (facts.rays_on_sensor, facts.max_ray_noise) {
        screen::say(format_args!(
            "rays        {on_sensor} of {} on the sensor",
            facts.rays.unwrap_or(0)
        ))?;
        screen::say(format_args!(
            "maximum     ray noise alone gives {:.4} ({:.4} to {:.4}) {unit}, the light without noise {:.4} {unit}",
            law.median,
            law.lo95,
            law.hi95,
            facts.max_noise_free.unwrap_or(f64::NAN)
        ))?;
    }
    if let Some(relative) = facts.relative_error_per_pixel {
        screen::say(format_args!("per pixel   {:.2} % standard error", 100.0 * relative))?;
    }
    if let Some(against) = &facts.against {
        screen::say(format_args!(
            "against     {}: {:+.6} {unit} ({:+.4} %), of which computing alone makes {:.2e} {unit}: {:+.1} σ, p = {:.2e}: {}",
            against.folder,
            against.difference,
            100.0 * against.difference / against.mean,
            against.u_difference,
            against.sigma,
            against.p_value,
            match (against.same_rays, against.differs) {
                (true, _) => "both drew the same random numbers: give another --seed",
                (false, true) => "they differ by more than their noise",
                (false, false) => "no more than their noise",
            }
        ))?;
    }
    screen::say(format_args!("solver      {:.4} s", facts.elapsed_s.unwrap_or_default()))?;
    screen::say(format_args!("written     {}", arguments.out))
}

fn one_or_two<T: std::str::FromStr + Copy>(text: &str) -> Result<Pair<T>, String> {
    pair(text, |part| part.parse().map_err(|_| format!("`{part}` is no number")))
}

fn one_or_two_counts(text: &str) -> Result<Pair<u64>, String> {
    pair(text, |part| if part == "0" { Ok(0) } else { count(part) })
}

fn pair<T: Copy>(text: &str, parse: impl Fn(&str) -> Result<T, String>) -> Result<Pair<T>, String> {
    if let Some((x, y)) = text.split_once(['x', 'X', '×', '*'])
        && parse(x.trim()).is_ok()
        && parse(y.trim()).is_ok()
    {
        return Err(format!(
            "`{text}`: two numbers are written with a comma: {},{}",
            x.trim(),
            y.trim()
        ));
    }
    match text
        .split(',')
        .map(|part| parse(part.trim()))
        .collect::<Result<Vec<T>, _>>()?
        .as_slice()
    {
        [both] => Ok([*both; 2]),
        [x, y] => Ok([*x, *y]),
        _ => Err(format!("`{text}`: expected one number or two with a comma")),
    }
}
