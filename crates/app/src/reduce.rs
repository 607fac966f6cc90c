//! `isolux reduce`: the record of a scan → distribution, spectrum, files and budget.

use std::collections::BTreeSet;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_model::{BelongsTo, Effect, Emitter, Luminaire, Model, Spectral};
use isolux_record::observation::ReadingCoordinates;
use isolux_record::{Reading, ReadingKind, Run, Subject};
use isolux_reduce::{BenchInverse, Corrected, Correction, Options, Quantity, ReduceError, Reduction, Subtract};

use crate::files::{self, Overwrite};
use crate::{Failure, record};

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
    pub files: Vec<String>,
}

impl Reduced {
    /// The headline numbers, each with unit and expanded uncertainty (k = 2), the notes, and where the files are.
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
        if let Some(electrical) = &reduction.electrical {
            lines.push(format!("power {}", with_u(&electrical.power)));
            lines.push(format!("luminous efficacy {}", with_u(&electrical.luminous_efficacy)));
        }
        if let Some(spectral) = &reduction.spectral {
            lines.push(format!("efficacy of radiation {}", with_u(&spectral.ler)));
            lines.extend(spectral.colour.cct.as_ref().map(|cct| format!("CCT {}", with_u(cct))));
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

/// A quantity as reports state it: the value and its expanded uncertainty (k = 2), to the digits of the latter; where
/// something is missing in the uncertainty, the value and what is missing.
pub fn with_u(quantity: &Quantity) -> String {
    let said = quantity.rounded();
    // A chromaticity has no unit.
    let unit = if quantity.unit.is_empty() {
        String::new()
    } else {
        format!(" {}", quantity.unit)
    };
    match quantity.u {
        Some(_) => format!("{} ± {}{unit} (k = 2)", said.value, said.expanded),
        None => format!("{}{unit}, {}", said.value, no_uncertainty(&quantity.missing)),
    }
}

/// The value alone, to the digits that its known parts leave.
pub fn value_only(quantity: &Quantity) -> String {
    quantity.rounded().value
}

/// Why a number has no ±.
pub fn no_uncertainty(missing: &[String]) -> String {
    format!("no uncertainty: {}", missing.join("; "))
}

/// What is asked of a reduction.
#[derive(Debug, Clone, Default)]
pub struct Request<'a> {
    /// Folder of the results; without one `RUN/results`, or `RUN/results-partial` where the scan is not finished.
    pub out: Option<&'a Utf8Path>,
    /// Names of corrections to leave out.
    pub without: &'a [String],
    /// A model whose bench effects are taken out of the readings.
    pub with: Option<&'a Utf8Path>,
    /// Why a drift beyond the limits of the plan is accepted; none: it is refused.
    pub accept_drift: Option<&'a str>,
    /// What was measured and for whom, where that is known better than the record knows it.
    pub subject: Option<&'a Subject>,
}

/// Reduces the run in `run` and writes its results.
///
/// # Errors
/// "No" (exit 1) for a drift, an unstable reference or a closing half-plane beyond the limits of the plan. Bad input
/// (exit 2) for a record that gives no distribution, an unknown correction, a bench effect without inverse, or results
/// that exist. Nothing is written then.
pub fn run(run: &Utf8Path, request: &Request<'_>, overwrite: Overwrite) -> Result<Reduced, Failure> {
    let without = request
        .without
        .iter()
        .map(|word| word.parse::<Correction>())
        .collect::<Result<BTreeSet<_>, _>>()
        .map_err(Failure::bad_input)?;
    let model = request.with.map(Model::load).transpose().map_err(Failure::bad_input)?;
    // Read before anything is written: the model may lie among the results that are replaced.
    let kept = model.as_ref().map(model_files).transpose()?;
    let mut record = record::read_at_rest(run)?;
    if let Some(subject) = request.subject {
        record.header.state(subject);
    }
    let accept_drift = request.accept_drift.map(str::to_owned);
    let reduction =
        reduction(&record, &Options { without, accept_drift }, model).map_err(|error| refused(run, &error))?;
    let made =
        isolux_reduce::files(&reduction, &record, &run_files(run, &record)?, PROGRAM).map_err(Failure::bad_input)?;
    let folder = request
        .out
        .map_or_else(|| results_folder(run, &reduction), Utf8Path::to_owned);
    for file in &made {
        files::refuse_existing(&folder.join(&file.name), overwrite)?;
    }
    keep_model(&folder, kept)?;
    remove_raw(&folder, &made)?;
    for file in &made {
        files::write(&folder.join(&file.name), &file.bytes, overwrite)?;
    }
    Ok(Reduced {
        run: record,
        reduction,
        folder,
        files: made.into_iter().map(|file| file.name).collect(),
    })
}

/// Where the results of a run lie: those of a scan that is not finished in a folder of their own, so that nothing takes
/// them for the whole.
pub fn results_folder(run: &Utf8Path, reduction: &Reduction) -> Utf8PathBuf {
    run.join(if reduction.partial.is_some() {
        "results-partial"
    } else {
        "results"
    })
}

/// The distribution before it was smoothed.
const RAW: &str = "luminaire.raw.ldt";

/// The failure of a record that gives no result.
fn refused(run: &Utf8Path, error: &ReduceError) -> Failure {
    let message = format!("{run}: {error}");
    match error {
        ReduceError::Unsteady { .. } => Failure::no(message).help(
            "nothing was written; look at these rows, measure again what they spoil, or give --accept-drift=REASON: then every \
             result says so and carries no uncertainty",
        ),
        _ => Failure::bad_input(message),
    }
}

/// Folder in the results with the model whose bench effects were taken out, and the file's name there.
const REDUCED_WITH: [&str; 2] = ["reduced_with", "model.toml"];

/// The model that was given to the reduction whose results lie in `results`, if one was.
///
/// # Errors
/// Bad input (exit 2) for a model that cannot be read.
pub(crate) fn kept_model(results: &Utf8Path) -> Result<Option<Model>, Failure> {
    let [folder, name] = REDUCED_WITH;
    let file = results.join(folder).join(name);
    file.is_file()
        .then(|| Model::load(&file).map_err(Failure::bad_input))
        .transpose()
}

/// The files of a model by name, each beside the other.
fn model_files(model: &Model) -> Result<Vec<(String, Vec<u8>)>, Failure> {
    let mut kept = Vec::new();
    for (name, from) in model.files() {
        let name = Utf8Path::new(&name).file_name().unwrap_or("distribution");
        kept.push((name.to_owned(), files::read(&from)?));
    }
    let text = model.beside_its_files().to_toml().into_bytes();
    kept.push((REDUCED_WITH[1].to_owned(), text));
    Ok(kept)
}

/// Keeps the model of the reduction with its results, from which the report makes it again; takes away that of an
/// earlier one.
fn keep_model(results: &Utf8Path, kept: Option<Vec<(String, Vec<u8>)>>) -> Result<(), Failure> {
    let folder = results.join(REDUCED_WITH[0]);
    if folder.join(REDUCED_WITH[1]).is_file() {
        std::fs::remove_dir_all(&folder).map_err(|error| Failure::instrument(format!("{folder}: {error}")))?;
    }
    for (name, bytes) in kept.into_iter().flatten() {
        files::write(&folder.join(name), &bytes, Overwrite::Force)?;
    }
    Ok(())
}

/// Removes the raw distribution of an earlier reduction where this one is not smoothed and writes none.
fn remove_raw(results: &Utf8Path, made: &[isolux_reduce::ResultFile]) -> Result<(), Failure> {
    let file = results.join(RAW);
    if made.iter().any(|file| file.name == RAW) || !file.is_file() {
        return Ok(());
    }
    std::fs::remove_file(&file).map_err(|error| Failure::instrument(format!("{file}: {error}")))
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

/// What a run says: by `model`, whose bench effects are taken out, or else by the run's own dark, ambient and baffled
/// readings. Where a floor explains the baffled readings, it is the floor that is taken out: then the model file, which
/// carries it, predicts the readings as they were read, and no digit of the baffled readings is cut into the
/// distribution.
///
/// # Errors
/// [`ReduceError`].
pub fn reduction(record: &Run, options: &Options, model: Option<Model>) -> Result<Reduction, ReduceError> {
    if let Some(model) = model {
        let bench = Bench {
            model,
            measured_by_the_run: false,
        };
        let mut reduction = isolux_reduce::reduce(record, options, Some(&bench))?;
        reduction.bench_effects = bench.tables();
        return Ok(reduction);
    }
    let plain = isolux_reduce::reduce(record, options, None)?;
    let Some(floor) = Floor::of(record, &plain) else {
        return Ok(plain);
    };
    let table = floor.table();
    let bench = Bench {
        model: far_field(&plain).with_effects(vec![floor.effect]),
        measured_by_the_run: true,
    };
    let mut reduction = isolux_reduce::reduce(record, options, Some(&bench))?;
    reduction.bench_effects = vec![table];
    Ok(reduction)
}

fn far_field(reduction: &Reduction) -> Model {
    let distribution = reduction.grid.distribution.clone();
    Model::of(Luminaire::new(distribution, Emitter::Point {}, Spectral::None))
}

/// The floor whose diffuse reflection explains the baffled readings.
struct Floor {
    effect: Effect,
    u_albedo: f64,
}

impl Floor {
    /// The albedo fitted to baffled − lamp_off over γ, at the height that the station gives; nothing where there is no
    /// such reading, where the fit is no floor (albedo below zero) or where a reading is further from it than three
    /// times its uncertainty: that stray light comes another way.
    fn of(run: &Run, reduction: &Reduction) -> Option<Self> {
        const TRIAL_ALBEDO: f64 = 0.1;
        const WITHIN_U: f64 = 3.0;
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
        let of_albedo = |albedo| Effect::from_keys("floor_reflection", [("albedo", albedo), ("height_mm", height_mm)]);
        let per_trial = far_field(reduction)
            .with_effects(vec![of_albedo(TRIAL_ALBEDO).ok()?])
            .predict_readings(&at);
        let stray: Vec<(f64, f64)> = levels
            .baffled
            .iter()
            .map(|(_, level)| (level.mean_lx - off.mean_lx, level.u_lx().hypot(off.u_lx())))
            .collect();
        let squares: f64 = per_trial.iter().map(|lux| lux * lux).sum();
        let product: f64 = per_trial.iter().zip(&stray).map(|(lux, (stray, _))| lux * stray).sum();
        let share = product / squares;
        let explained = per_trial
            .iter()
            .zip(&stray)
            .all(|(lux, (stray, u))| (stray - share * lux).abs() <= WITHIN_U * u);
        if !(share > 0.0 && explained) {
            return None;
        }
        // The rounding is the same at every γ, so it does not average out over them.
        let u_lx = stray.iter().fold(0.0_f64, |largest, (_, u)| largest.max(*u));
        Some(Self {
            effect: of_albedo(TRIAL_ALBEDO * share).ok()?,
            u_albedo: TRIAL_ALBEDO * per_trial.iter().sum::<f64>() * u_lx / squares,
        })
    }

    fn table(&self) -> String {
        format!("{}\n[effect.u]\nalbedo = {:.6}\n", table(&self.effect), self.u_albedo)
    }
}

/// The bench effects of a model, turned around.
struct Bench {
    model: Model,
    /// Its effects were fitted to readings of the run, whose uncertainty the budget holds.
    measured_by_the_run: bool,
}

impl Bench {
    fn of_the_bench(&self) -> impl Iterator<Item = &Effect> {
        self.model
            .effects()
            .iter()
            .filter(|effect| effect.spec().belongs_to(BelongsTo::Bench))
    }

    /// Its effects as tables of a model file: the new model predicts the readings as they were read. The near field,
    /// which no far distribution holds, stays known too.
    fn tables(&self) -> Vec<String> {
        let near_field = self
            .model
            .effects()
            .iter()
            .filter(|effect| effect.name() == "near_field");
        self.of_the_bench().chain(near_field).map(table).collect()
    }

    fn has(&self, name: &str) -> bool {
        self.model.effects().iter().any(|effect| effect.name() == name)
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
            .model
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

    fn without_uncertainty(&self) -> Vec<String> {
        // Levels that the run measured itself are in its budget, whoever takes them out.
        let of_levels = ["dark_offset", "ambient_stray", "floor_reflection"];
        let unknown = self.of_the_bench().map(Effect::name);
        unknown
            .filter(|name| !self.measured_by_the_run && !of_levels.contains(name))
            .map(str::to_owned)
            .collect()
    }

    fn effects(&self) -> Vec<String> {
        self.of_the_bench().map(Effect::name).map(str::to_owned).collect()
    }
}
