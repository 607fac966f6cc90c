//! What a day was asked, kept in its folder as `job/`: who takes it up again or reports it asks the same of it.

use std::cell::Cell;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_record::{Conditions, Job, Layout, LightModulation, Requirements, RunHeader, Station, Subject};
use isolux_report::clothes::{self, Clothes};
use isolux_report::day::DayLayout;
use isolux_sim::simulation::Facts;
use isolux_virtual::twins::Choice;
use serde::de::DeserializeOwned;
use toml::{Table, Value};

use crate::diagnosis::diagnose;
use crate::files::{self, Overwrite};
use crate::front_end::progress::{Event, Progress};
use crate::init::DayPlan;
use crate::modulation;
use crate::run::record;
use crate::simulation::scene::{self, Changes};
use crate::{Failure, init};

/// The folder's name in the day.
pub(crate) const FOLDER: &str = "job";

/// Files that are always in it.
const KEPT: [&str; 2] = ["job.toml", "scene.toml"];

/// Keeps the job at the first thing that a scan tells, when its run directory is there: a day whose program is killed
/// after that still knows what it was asked.
pub(super) struct JobRecorder<'a> {
    folder: &'a Utf8Path,
    job: &'a Job,
    progress: &'a dyn Progress,
    kept: Cell<bool>,
}

impl<'a> JobRecorder<'a> {
    pub(super) const fn new(folder: &'a Utf8Path, job: &'a Job, progress: &'a dyn Progress) -> Self {
        Self {
            folder,
            job,
            progress,
            kept: Cell::new(false),
        }
    }

    /// Keeps the job if that has not succeeded yet.
    ///
    /// # Errors
    /// As [`keep`].
    pub(super) fn end(&self) -> Result<(), Failure> {
        if self.kept.get() {
            return Ok(());
        }
        keep(self.folder, self.job)
    }
}

impl Progress for JobRecorder<'_> {
    fn event(&self, event: Event<'_>) {
        // What the disk refuses now is said by `end`.
        // What is said before the scan begins, such as of the room, is said before there is a run directory.
        let begun = self.folder.join("run.toml").is_file();
        if begun && !self.kept.get() && keep(self.folder, self.job).is_ok() {
            self.kept.set(true);
        }
        self.progress.event(event);
    }
}

/// Writes the job and its scene into the day. The scene is copied with the files that it reads and names the model that
/// the day makes; the record of the light over time is copied; station, plan and what is diagnosed stay where they are.
///
/// # Errors
/// Bad input (exit 2) for a scene that cannot be read, exit 3 when the disk refuses.
pub(super) fn keep(day: &Utf8Path, job: &Job) -> Result<(), Failure> {
    let folder = day.join(FOLDER);
    if job.scene().starts_with(&folder) {
        return Ok(());
    }
    let (at, mut table) = scene::table(job.scene(), &Changes::default())?;
    table.remove("luminaire");
    table.remove("model");
    let beside = at.parent().unwrap_or(Utf8Path::new(""));
    let mut taken: Vec<(Utf8PathBuf, String)> = Vec::new();
    let mut scene = Value::Table(table);
    scene::each_text(&mut scene, &mut |text| {
        let from = beside.join(&*text);
        if !from.is_file() {
            return;
        }
        let known = taken
            .iter()
            .find(|(path, _)| *path == from)
            .map(|(_, name)| name.clone());
        *text = known.unwrap_or_else(|| {
            let name = from.file_name().unwrap_or("file");
            let name = if ["scene.toml", "job.toml", record::SUMS].contains(&name)
                || taken.iter().any(|(_, other)| other == name)
            {
                format!("{}-{name}", taken.len())
            } else {
                name.to_owned()
            };
            taken.push((from.clone(), name.clone()));
            name
        });
    });
    let mut layout = job.layout().clone();
    for (key, path) in layout.files() {
        // Names of their own, whatever they were called.
        let end = path.extension().unwrap_or("css");
        let name = format!("{}.{end}", key.replace('.', "-"));
        taken.push((std::mem::replace(path, Utf8PathBuf::from(&name)), name));
    }
    let mut kept: Vec<(String, Vec<u8>)> = Vec::new();
    for (from, name) in taken {
        kept.push((name, files::read(&from)?));
    }
    if let Value::Table(table) = &mut scene {
        table.insert("model".into(), "../results/luminaire.model.toml".into());
    }
    let text = |table: &Value| toml::to_string(table).map_err(Failure::bad_input);
    kept.push(("scene.toml".to_owned(), text(&scene)?.into_bytes()));

    let mut document = Table::new();
    document.insert("format".into(), "isolux-job/1".into());
    document.insert("station".into(), whole(job.station())?);
    document.insert("plan".into(), whole(job.plan())?);
    document.insert("scene".into(), "scene.toml".into());
    if let Some((model, observations)) = job.diagnose() {
        let observations = observations.iter().map(|path| whole(path)).collect::<Result<_, _>>()?;
        let mut diagnose = Table::new();
        diagnose.insert("model".into(), whole(model)?);
        diagnose.insert("observations".into(), Value::Array(observations));
        document.insert("diagnose".into(), diagnose.into());
    }
    if let Value::Table(subject) = Value::try_from(job.subject()).map_err(Failure::bad_input)? {
        document.extend(subject);
    }
    if !job.conditions().is_empty() {
        let conditions = Value::try_from(job.conditions()).map_err(Failure::bad_input)?;
        document.insert("conditions".into(), conditions);
    }
    if !job.requirements().is_empty() {
        let requirements = Value::try_from(job.requirements()).map_err(Failure::bad_input)?;
        document.insert("requirements".into(), requirements);
    }
    if !layout.is_empty() {
        let layout = Value::try_from(&layout).map_err(Failure::bad_input)?;
        document.insert("layout".into(), layout);
    }
    if let Some(light) = job.light_modulation() {
        let bytes = files::read(&light.waveform)?;
        let waveform = Utf8PathBuf::from(modulation::kept_name(&bytes));
        kept.push((waveform.to_string(), bytes));
        let light = LightModulation {
            waveform,
            ..light.clone()
        };
        let table = Value::try_from(&light).map_err(Failure::bad_input)?;
        document.insert("light_modulation".into(), table);
    }
    // job.toml last: a folder with it holds what it names.
    kept.push(("job.toml".to_owned(), text(&document.into())?.into_bytes()));
    let sums = record::sums(kept.iter().map(|(name, bytes)| (name.as_str(), bytes.as_slice())));
    files::write(&folder.join(record::SUMS), sums.as_bytes(), Overwrite::Force)?;
    for (name, bytes) in &kept {
        files::write(&folder.join(name), bytes, Overwrite::Force)?;
    }
    Ok(())
}

/// The job of a day that is resumed without one; none where the built-in virtual darkroom played it.
///
/// # Errors
/// Bad input (exit 2) for a day that had a job and does not hold it.
pub(crate) fn kept(day: &Utf8Path) -> Result<Option<Job>, Failure> {
    let file = day.join(FOLDER).join("job.toml");
    if file.is_file() {
        let give = |failure: Failure| failure.help(format!("give the job: isolux run JOB --resume {day}"));
        record::check_sums(&day.join(FOLDER), &KEPT).map_err(give)?;
        return Job::load(&file)
            .map(Some)
            .map_err(|error| give(Failure::bad_input(error)));
    }
    if built_in(day)? {
        return Ok(None);
    }
    Err(unknown(day).help(format!("give the job: isolux run JOB --resume {day}")))
}

/// By what a day is judged, and how its report looks.
#[derive(Debug, Clone, Default)]
pub(crate) struct Wanted {
    /// Wanted of its conditions.
    pub conditions: Conditions,
    /// What the luminaire has to keep.
    pub requirements: Requirements,
    /// The record of its light over time.
    pub light_modulation: Option<LightModulation>,
    /// The look of its report.
    pub layout: DayLayout,
}

impl Wanted {
    /// Those of a job.
    ///
    /// # Errors
    /// Bad input (exit 2) for a picture or a style sheet that cannot be read.
    pub(crate) fn of(job: &Job) -> Result<Self, Failure> {
        Ok(Self {
            conditions: job.conditions().clone(),
            requirements: job.requirements().clone(),
            light_modulation: job.light_modulation().cloned(),
            layout: look(job.layout())?,
        })
    }

    /// Those of the built-in virtual darkroom: what `isolux init` writes.
    ///
    /// # Errors
    /// Never for the text as it is shipped.
    pub(crate) fn built_in() -> Result<Self, Failure> {
        #[derive(serde::Deserialize)]
        struct Shipped {
            conditions: Conditions,
        }
        let shipped: Shipped = toml::from_str(&init::conditions()).map_err(Failure::instrument)?;
        Ok(Self {
            conditions: shipped.conditions,
            ..Self::default()
        })
    }
}

/// A layout with the files that it names.
fn look(layout: &Layout) -> Result<DayLayout, Failure> {
    let picture = |file: &Option<Utf8PathBuf>| -> Result<Option<String>, Failure> {
        let Some(file) = file else { return Ok(None) };
        let made = clothes::picture(&files::read(file)?);
        made.map(Some)
            .map_err(|wrong| Failure::bad_input(format!("{file}: {wrong}")))
    };
    let style = layout.style.as_ref().map_or(Ok(Vec::new()), |file| files::read(file))?;
    let clothes = Clothes {
        logo: picture(&layout.logo)?,
        accreditation_mark: picture(&layout.accreditation_mark)?,
        address: layout.address.clone(),
        style: String::from_utf8(style).map_err(|error| Failure::bad_input(format!("layout.style: {error}")))?,
    };
    Ok(DayLayout {
        language: layout.language.unwrap_or_default(),
        clothes,
        sections: layout.sections.clone(),
        data_sheet: layout.data_sheet,
    })
}

/// What a report takes from the job of its day.
#[derive(Debug, Default)]
pub(crate) struct OfReport {
    /// The scene; none: the run was scanned and reduced by itself, or played by the built-in virtual darkroom.
    pub scene: Option<Utf8PathBuf>,
    /// Whether the job names a diagnosis of its own.
    pub own_model: bool,
    /// What was measured and for whom, where that is known better than the record knows it.
    pub subject: Subject,
    /// By what the day is judged.
    pub wanted: Wanted,
}

/// What a report of `day` takes from its job.
///
/// # Errors
/// Bad input (exit 2) for a day that had a job and does not hold it.
pub(crate) fn of_report(day: &Utf8Path, job: Option<&Utf8Path>) -> Result<OfReport, Failure> {
    if let Some(job) = job {
        let job = Job::load(job).map_err(Failure::bad_input)?;
        return Ok(OfReport {
            scene: Some(job.scene().to_owned()),
            own_model: job.diagnose().is_some(),
            subject: job.subject().clone(),
            wanted: Wanted::of(&job)?,
        });
    }
    let folder = day.join(FOLDER);
    let file = folder.join("job.toml");
    if file.is_file() {
        record::check_sums(&folder, &KEPT)
            .map_err(|failure| failure.help(format!("give the job: isolux report {day} --job JOB --out FILE")))?;
        let text =
            String::from_utf8(files::read(&file)?).map_err(|error| Failure::bad_input(format!("{file}: {error}")))?;
        let table: Table = text
            .parse()
            .map_err(|error| Failure::bad_input(format!("{file}: {error}")))?;
        let wrong = |error| Failure::bad_input(format!("{file}: {error}"));
        let light = table.get("light_modulation").cloned();
        let light = light
            .map(Value::try_into::<LightModulation>)
            .transpose()
            .map_err(wrong)?;
        let subject = (["luminaire", "report", "ratings", "eu_label"].into_iter())
            .filter_map(|name| Some((name.to_owned(), table.get(name)?.clone())))
            .collect::<Table>();
        return Ok(OfReport {
            scene: Some(folder.join("scene.toml")),
            own_model: table.contains_key("diagnose"),
            subject: subject.try_into().map_err(wrong)?,
            wanted: Wanted {
                light_modulation: light.map(|light| LightModulation {
                    waveform: folder.join(&light.waveform),
                    ..light
                }),
                conditions: part(&table, "conditions", &file)?,
                requirements: part(&table, "requirements", &file)?,
                layout: {
                    let mut layout: Layout = part(&table, "layout", &file)?;
                    for (_, path) in layout.files() {
                        *path = folder.join(&*path);
                    }
                    look(&layout)?
                },
            },
        });
    }
    if day.join("results/result.json").is_file() && !built_in(day)? {
        return Err(unknown(day).help(format!("give the job: isolux report {day} --job JOB --out FILE")));
    }
    let wanted = if on_built_in_bench(day)? {
        Wanted::built_in()?
    } else {
        Wanted::default()
    };
    Ok(OfReport {
        wanted,
        ..OfReport::default()
    })
}

/// A table of a kept job; what it has by default where it is left out.
fn part<T: DeserializeOwned + Default>(table: &Table, name: &str, file: &Utf8Path) -> Result<T, Failure> {
    let Some(part) = table.get(name) else {
        return Ok(T::default());
    };
    part.clone()
        .try_into()
        .map_err(|error| Failure::bad_input(format!("{file}: [{name}]: {error}")))
}

fn unknown(day: &Utf8Path) -> Failure {
    Failure::bad_input(format!("{day}: the day does not hold the job that it was asked"))
}

/// Whether a day without a kept job can be one of the built-in virtual darkroom: its station and plan, and its sensor
/// where the day came so far.
fn built_in(day: &Utf8Path) -> Result<bool, Failure> {
    if !on_built_in_bench(day)? {
        return Ok(false);
    }
    let file = day.join("results/result.json");
    if !file.is_file() {
        return Ok(true);
    }
    let result: Facts = files::read_json(&file)?;
    let sensor = scene::load(day, &Changes::default())?.sensor;
    Ok(result.pixels == sensor.pixels && result.size_mm == sensor.size_mm)
}

/// Whether a day has station and plan of the built-in virtual darkroom.
///
/// # Errors
/// Bad input (exit 2) for what is no run.
pub(crate) fn on_built_in_bench(day: &Utf8Path) -> Result<bool, Failure> {
    let header = RunHeader::read(day).map_err(Failure::bad_input)?;
    let (station, _) = init::virtual_station(&Choice::default())?;
    let station = Station::parse(Utf8Path::new("built-in"), &station).map_err(Failure::bad_input)?;
    Ok(header.station == station && built_in_plan(day)?.is_some())
}

/// Which of the built-in plans a day has.
pub(super) fn built_in_plan(day: &Utf8Path) -> Result<Option<DayPlan>, Failure> {
    let header = RunHeader::read(day).map_err(Failure::bad_input)?;
    for plan in DayPlan::ALL {
        if header.plan == plan.plan()? {
            return Ok(Some(plan));
        }
    }
    Ok(None)
}

fn whole(path: &Utf8Path) -> Result<Value, Failure> {
    let path = std::path::absolute(path).map_err(Failure::instrument)?;
    let path = Utf8PathBuf::try_from(path).map_err(Failure::bad_input)?;
    Ok(files::in_document(&path).into())
}

/// The diagnosis that a job asks for.
pub(crate) fn diagnosis(job: &Job, results: &Utf8Path, overwrite: Overwrite) -> Option<diagnose::DiagnoseRequest> {
    let (model, observations) = job.diagnose()?;
    Some(diagnosis_of(
        model.to_owned(),
        observations.to_vec(),
        results,
        overwrite,
    ))
}

/// The diagnosis of `observations` against `model` that a day makes.
pub(crate) fn diagnosis_of(
    model: Utf8PathBuf,
    observations: Vec<Utf8PathBuf>,
    results: &Utf8Path,
    overwrite: Overwrite,
) -> diagnose::DiagnoseRequest {
    diagnose::DiagnoseRequest {
        model,
        observations,
        out: results.join("diagnosis"),
        held_out: None,
        seed: 1,
        accept: false,
        overwrite,
    }
}
