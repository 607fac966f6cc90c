//! `isolux reduce`: the record of a scan → distribution, spectrum, files and budget.

use std::collections::BTreeSet;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_model::{BelongsTo, Effect, Emitter, Luminaire, Model, Spectral};
use isolux_record::observation::ReadingCoordinates;
use isolux_record::{Reading, ReadingKind, Run};
use isolux_reduce::{BenchInverse, Corrected, Correction, Options, Quantity, Reduction, Subtract};

use crate::Failure;
use crate::files::{self, Overwrite};

/// Name and version, as it stands in files that this program writes.
pub const PROGRAM: &str = concat!("isolux ", env!("CARGO_PKG_VERSION"));

/// A reduced run and where its files are.
#[derive(Debug)]
pub struct Reduced {
    /// The run as it was read.
    pub run: Run,
    /// What it says.
    pub reduction: Reduction,
    /// The folder of results.
    pub folder: Utf8PathBuf,
    /// Names of the files written there.
    pub files: Vec<&'static str>,
}

impl Reduced {
    /// The headline numbers, each with unit and standard uncertainty, the notes, and where the files are.
    pub fn sentences(&self) -> Vec<String> {
        let reduction = &self.reduction;
        let mut lines = vec![
            format!("flux {}", with_u(&reduction.flux)),
            format!(
                "I max {} at C {}° γ {}°",
                with_u(&reduction.i_max),
                reduction.i_max_deg.0,
                reduction.i_max_deg.1
            ),
        ];
        if let Some(spectral) = &reduction.spectral {
            lines.push(format!("efficacy of radiation {}", with_u(&spectral.ler)));
            lines.extend(spectral.cct.as_ref().map(|cct| format!("CCT {}", with_u(cct))));
            lines.push(format!(
                "irradiance on the axis at {} mm {}",
                spectral.distance_mm,
                with_u(&spectral.irradiance)
            ));
        }
        lines.extend(reduction.notes.iter().map(|note| format!("note: {note}")));
        lines.push(format!("{} in {}", self.files.join(", "), self.folder));
        lines
    }
}

/// A quantity as people write it: value and standard uncertainty to two digits of the latter.
pub fn with_u(quantity: &Quantity) -> String {
    let decimals = if quantity.u > 0.0 {
        (1 - quantity.u.log10().floor() as i32).clamp(0, 9) as usize
    } else {
        3
    };
    format!(
        "{:.decimals$} ± {:.decimals$} {} (k = 1)",
        quantity.value, quantity.u, quantity.unit
    )
}

/// Reduces the run in `run`, writes its results to `out` (`RUN/results` without one).
///
/// `without` names corrections to leave out; `with` is a model whose bench effects are taken out of the readings.
///
/// # Errors
/// Bad input (exit 2) for a record that gives no distribution, an unknown correction, a bench effect without inverse, or
/// results that exist; nothing is written then.
pub fn run(
    run: &Utf8Path,
    out: Option<&Utf8Path>,
    without: &[String],
    with: Option<&Utf8Path>,
    overwrite: Overwrite,
) -> Result<Reduced, Failure> {
    let folder = out.map_or_else(|| run.join("results"), Utf8Path::to_owned);
    let without = without
        .iter()
        .map(|word| word.parse::<Correction>())
        .collect::<Result<BTreeSet<_>, _>>()
        .map_err(Failure::bad_input)?;
    let bench = with
        .map(Model::load)
        .transpose()
        .map_err(Failure::bad_input)?
        .map(Bench::new);
    let record = Run::read(run).map_err(Failure::bad_input)?;
    let mut reduction = isolux_reduce::reduce(
        &record,
        &Options { without },
        bench.as_ref().map(|bench| bench as &dyn BenchInverse),
    )
    .map_err(|error| Failure::bad_input(format!("{run}: {error}")))?;
    reduction.bench_effects = match &bench {
        Some(bench) => bench.tables(),
        None => floor(&record, &reduction).into_iter().collect(),
    };
    let made =
        isolux_reduce::files(&reduction, &record, &run_files(run, &record)?, PROGRAM).map_err(Failure::bad_input)?;
    for file in &made {
        files::refuse_existing(&folder.join(file.name), overwrite)?;
    }
    for file in &made {
        files::write(&folder.join(file.name), &file.bytes, overwrite)?;
    }
    Ok(Reduced {
        run: record,
        reduction,
        folder,
        files: made.iter().map(|file| file.name).collect(),
    })
}

/// Names and bytes of the record's own files, for their hashes.
fn run_files(folder: &Utf8Path, run: &Run) -> Result<Vec<(String, Vec<u8>)>, Failure> {
    let spectra = run
        .spectra
        .iter()
        .map(|spectrum| format!("spectra/{:03}.csv", spectrum.index));
    std::iter::once("readings.csv".to_owned())
        .chain(spectra)
        .map(|name| Ok((name.clone(), files::read(&folder.join(&name))?)))
        .collect()
}

fn table(effect: &Effect) -> String {
    let keys = effect.spec().parameters.iter().zip(effect.values());
    keys.fold(format!("name = \"{}\"\n", effect.name()), |text, (parameter, value)| {
        text + &format!("{} = {value:?}\n", parameter.key)
    })
}

/// The floor whose diffuse reflection explains the baffled readings: its albedo, fitted to baffled − lamp_off over γ at the
/// height that the station gives. An albedo within its uncertainty of nothing is still what stands for the stray light that
/// was subtracted.
fn floor(run: &Run, reduction: &Reduction) -> Option<String> {
    const TRIAL_ALBEDO: f64 = 0.1;
    let height_mm = run.header.station.bench().floor_mm?;
    let levels = &reduction.levels;
    let off = levels.lamp_off.or(levels.capped)?;
    if levels.baffled.is_empty() || !reduction.subtract.stray {
        return None;
    }
    let at: Vec<ReadingCoordinates> = levels
        .baffled
        .iter()
        .map(|(gamma_deg, _)| ReadingCoordinates {
            kind: ReadingKind::Baffled,
            time_s: None,
            c_deg: 0.0,
            gamma_deg: *gamma_deg,
            distance_mm: reduction.distance_mm,
            travel: 0,
            range: None,
            ambient_c: None,
        })
        .collect();
    let trial = Effect::from_keys("floor_reflection", [("albedo", TRIAL_ALBEDO), ("height_mm", height_mm)]).ok()?;
    let lamp = Luminaire::new(reduction.grid.distribution.clone(), Emitter::Point {}, Spectral::None);
    let predicted = Model::of(lamp).with_effects(vec![trial]).predict_readings(&at);
    let (mut squares, mut product, mut sum) = (0.0, 0.0, 0.0);
    let mut u_lx = 0.0_f64;
    for (lux, (_, level)) in predicted.iter().zip(&levels.baffled) {
        squares += lux * lux;
        product += lux * (level.mean_lx - off.mean_lx);
        sum += lux;
        u_lx = u_lx.max(level.u_lx().hypot(off.u_lx()));
    }
    let albedo = TRIAL_ALBEDO * product / squares;
    // The rounding is the same at every γ, so it does not average out over them.
    let u = TRIAL_ALBEDO * sum * u_lx / squares;
    (albedo.is_finite() && albedo > 0.0)
        .then(|| format!("name = \"floor_reflection\"\nalbedo = {albedo:.6}\nheight_mm = {height_mm:?}\n\n[effect.u]\nalbedo = {u:.6}\n"))
}

/// The bench effects of a model, turned around.
struct Bench(Model);

impl Bench {
    fn new(model: Model) -> Self {
        Self(model)
    }

    fn of_the_bench(&self) -> impl Iterator<Item = &Effect> {
        self.0
            .effects()
            .iter()
            .filter(|effect| effect.spec().belongs_to(BelongsTo::Bench))
    }

    /// Its effects as tables of a model file: the new model predicts the readings as they were read. The near field, which
    /// no far distribution holds, stays known too.
    fn tables(&self) -> Vec<String> {
        let near_field = self.0.effects().iter().filter(|effect| effect.name() == "near_field");
        self.of_the_bench().chain(near_field).map(table).collect()
    }

    fn has(&self, name: &str) -> bool {
        self.0.effects().iter().any(|effect| effect.name() == name)
    }
}

impl BenchInverse for Bench {
    fn correct(&self, readings: &[&Reading], illuminance_lx: &[f64]) -> Result<Vec<Corrected>, String> {
        let at: Vec<ReadingCoordinates> = readings
            .iter()
            .map(|reading| ReadingCoordinates {
                kind: reading.kind,
                time_s: reading.time_s,
                c_deg: reading.c_deg,
                gamma_deg: reading.gamma_deg,
                distance_mm: reading.distance_mm,
                travel: reading.travel,
                range: Some(reading.range),
                ambient_c: reading.ambient_c,
            })
            .collect();
        let corrected = self
            .0
            .correct_readings(&at, illuminance_lx)
            .map_err(|error| error.to_string())?;
        Ok(corrected
            .into_iter()
            .map(|light| Corrected {
                intensity_cd: light.intensity_cd,
                cd_per_lx: (light.distance_mm * 1e-3).powi(2),
                c_deg: light.c_deg,
                gamma_deg: light.gamma_deg,
            })
            .collect())
    }

    fn takes_over(&self) -> Subtract {
        Subtract {
            dark: self.has("dark_offset"),
            ambient: self.has("ambient_stray"),
            stray: self.has("floor_reflection"),
        }
    }

    fn effects(&self) -> Vec<String> {
        self.of_the_bench().map(Effect::name).map(str::to_owned).collect()
    }
}
