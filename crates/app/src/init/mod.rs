//! `init`: a station, plan, scene and job file to start from.

mod bench;
mod colour;
mod in_motion;
mod lamp;
mod standard;
pub mod subject;
mod virtual_station;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_darkroom::BUILT_IN;
use isolux_photometry::IntensityDistribution;
use isolux_record::{Plan, Subject};
use isolux_virtual::Instrument;
use isolux_virtual::station::{CALIBRATION_FILE, for_sweeps, in_memory};
use isolux_virtual::twins::Choice;

use crate::Failure;
use crate::files::{self, Overwrite};
use crate::front_end::progress::{Event, Progress};

pub use bench::{ABSENT, BY_HAND, PARTS, Part, Spare, bench, part};
pub use in_motion::sweep_deg_s;
pub use virtual_station::virtual_station;

/// The plan of the day: 25 half-planes × 91 γ, baffled, spectrum, capped, lamp off.
const PLAN: &str = include_str!("plan.toml");

/// Plans of the day.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DayPlan {
    /// At the distance that `isolux plan` proposes for the virtual bench.
    #[default]
    Near,
    /// The published one, at 10 m, the station's own distance.
    Published,
}

impl DayPlan {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Near, Self::Published];

    /// Its name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Near => "near",
            Self::Published => "published-10m",
        }
    }

    /// The plan of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|plan| plan.name() == name)
    }

    /// Its file.
    pub fn text(self) -> String {
        let own_distance = |line: &&str| self == Self::Near || !line.starts_with("distance_mm");
        let lines = PLAN.lines().filter(own_distance);
        lines.fold(String::new(), |text, line| text + line + "\n")
    }

    /// The plan.
    ///
    /// # Errors
    /// Never for the plans as they are shipped.
    pub fn plan(self) -> Result<Plan, Failure> {
        Plan::parse(Utf8Path::new("built-in plan"), &self.text()).map_err(Failure::bad_input)
    }
}
/// The scene of the day: 24.576 mm and 2048 × 2048 pixels at 500 mm.
pub const SCENE: &str = include_str!("scene.toml");
/// The job that names them.
pub const JOB: &str = include_str!("job.toml");
/// Limits of its conditions, with a line where those of the supply belong.
const CONDITIONS: &str = include_str!("conditions.toml");
const OF_THE_SUPPLY: &str = "# SUPPLY\n";
const DIRECT: &str = r#"supply = "dc"                   # or "ac", which has limits of frequency and distortion too
supply_voltage_v = { nominal = 24.0, tolerance_rel = 0.002, clause = "4.3" }
"#;
const ALTERNATING: &str = r#"supply = "ac"                   # or "dc", which has no frequency and no distortion
supply_voltage_v = { nominal = 230.0, tolerance_rel = 0.004, clause = "4.3" }
supply_frequency_hz = { nominal = 50.0, tolerance_rel = 0.002, clause = "4.3" }
supply_thd_rel = { largest = 0.015, clause = "4.3" }
"#;

/// The conditions of the lamp of the built-in virtual darkroom.
pub(crate) fn conditions() -> String {
    CONDITIONS.replace(OF_THE_SUPPLY, DIRECT)
}

/// The job of a subject on this supply.
fn job_text(supply: &str, subject: &Subject) -> String {
    let conditions = CONDITIONS.replace(OF_THE_SUPPLY, supply);
    [JOB, &conditions, &subject::text(subject)].concat()
}

/// Writes the files into `folder`, with the plan asked for; the names written.
///
/// # Errors
/// Bad input (exit 2) when one of them exists and may not be replaced: then none is written.
pub fn run(
    folder: &Utf8Path,
    plan: DayPlan,
    instruments: &Instruments,
    stated: &Subject,
    overwrite: Overwrite,
) -> Result<Vec<Utf8PathBuf>, Failure> {
    let choice = instruments.choice()?;
    let (station, calibration) = virtual_station(&choice)?;
    let station = instruments.station(&station, &choice);
    let built_in = subject::built_in();
    let subject = if stated.is_empty() { &built_in } else { stated };
    let station = format!("{STATION_HEAD}{station}{STATION_TAIL}");
    let mut files = vec![("station.toml", station)];
    files.extend(calibration.map(|text| (CALIBRATION_FILE, text)));
    files.push(("plan.toml", instruments.plan(plan.text(), &choice, None)?));
    files.push(("scene.toml", SCENE.to_owned()));
    files.push(("job.toml", job_text(DIRECT, subject)));
    write_all(folder, files, overwrite)
}

/// Writes into `folder` what rehearses the scan of the luminaire of the photometric file `lamp`: its room, a station
/// and a plan for it; the names written. How the grid was chosen, and what had to be assumed, goes to `progress`.
///
/// # Errors
/// Bad input (exit 2) when one of them exists and may not be replaced, and for a file of which no lamp can be made;
/// then none is written.
pub fn for_lamp(
    folder: &Utf8Path,
    lamp: &Utf8Path,
    instruments: &Instruments,
    stated: &Subject,
    overwrite: Overwrite,
    progress: &dyn Progress,
) -> Result<Vec<Utf8PathBuf>, Failure> {
    let choice = instruments.choice()?;
    let lamp = lamp::lamp(lamp, &choice)?;
    let subject = if stated.is_empty() { &lamp.subject } else { stated };
    let job = job_text(ALTERNATING, subject);
    let mut files = lamp.files;
    for (name, text) in &mut files {
        match *name {
            "station.toml" => {
                let station = instruments.station(text, &choice);
                *text = format!("{STATION_HEAD}{station}{STATION_TAIL}");
            }
            "plan.toml" => *text = instruments.plan(std::mem::take(text), &choice, Some(&lamp.light))?,
            _ => {}
        }
    }
    files.push(("job.toml", job));
    let written = write_all(folder, files, overwrite)?;
    lamp.notes.iter().for_each(|note| progress.event(Event::Note(note)));
    Ok(written)
}

/// Writes into `folder` what a calibration is tried with: a virtual room whose lamp is a standard, its certificate, and
/// a station; the names written.
///
/// # Errors
/// Bad input (exit 2) when one of them exists and may not be replaced: then none is written.
pub fn with_standard(
    folder: &Utf8Path,
    instruments: &Instruments,
    overwrite: Overwrite,
) -> Result<Vec<Utf8PathBuf>, Failure> {
    let mut files = standard::files(&instruments.choice()?)?;
    for (name, text) in &mut files {
        if name.starts_with("station") {
            *text = format!("{STATION_HEAD}{text}{STATION_TAIL}");
        }
    }
    write_all(folder, files, overwrite)
}

/// Writes all of them or none.
fn write_all(folder: &Utf8Path, files: Vec<(&str, String)>, overwrite: Overwrite) -> Result<Vec<Utf8PathBuf>, Failure> {
    if folder.is_file() {
        return Err(Failure::bad_input(format!("{folder} is a file, not a folder")));
    }
    for (name, _) in &files {
        files::refuse_existing(&folder.join(name), overwrite)?;
    }
    let mut written = Vec::new();
    for (name, text) in files {
        let path = folder.join(name);
        files::write(&path, text.as_bytes(), overwrite)?;
        written.push(path);
    }
    Ok(written)
}

/// Writes the whole built-in virtual darkroom to `file`: every key, commented.
///
/// # Errors
/// Bad input (exit 2) when the file exists and may not be replaced.
pub fn room(file: &Utf8Path, overwrite: Overwrite) -> Result<(), Failure> {
    files::write(file, ROOM.as_bytes(), overwrite)
}

/// The text of the whole built-in virtual darkroom.
pub const ROOM: &str = BUILT_IN;

/// The drivers whose twins play the instruments of the virtual darkroom; the default ones where none is named.
#[derive(Debug, Clone, Default)]
pub struct Instruments {
    /// Of the axes.
    pub axes: Option<String>,
    /// Of the lux meter.
    pub luxmeter: Option<String>,
    /// Of the spectroradiometer.
    pub spectroradiometer: Option<String>,
    /// Of the power meter; without one there is none.
    pub powermeter: Option<String>,
    /// Of the lamp's supply; without one there is none.
    pub supply: Option<String>,
    /// The distribution is read while γ moves: by twins that can, and a plan of sweeps.
    pub in_motion: bool,
    /// The plan takes spectra over angle.
    pub colour: bool,
}

impl Instruments {
    /// The twins.
    ///
    /// # Errors
    /// Bad input (exit 2) for a driver that has no such twin; names those that have.
    pub(crate) fn choice(&self) -> Result<Choice, Failure> {
        let mut choice = Choice::default();
        let named = [
            (Instrument::Axes, &self.axes),
            (Instrument::Luxmeter, &self.luxmeter),
            (Instrument::Spectroradiometer, &self.spectroradiometer),
            (Instrument::Powermeter, &self.powermeter),
            (Instrument::Supply, &self.supply),
        ];
        for (instrument, driver) in named {
            if let Some(driver) = driver {
                choice.choose(instrument, driver).map_err(Failure::bad_input)?;
            }
        }
        if self.in_motion {
            in_motion::choose(&mut choice, &named)?;
        }
        Ok(choice)
    }

    /// The station for what is read.
    fn station(&self, text: &str, choice: &Choice) -> String {
        if self.in_motion {
            for_sweeps(text, &in_memory(choice))
        } else {
            text.to_owned()
        }
    }

    /// The plan for how it is read, for a lamp whose file has `light`.
    fn plan(&self, text: String, choice: &Choice, light: Option<&IntensityDistribution>) -> Result<String, Failure> {
        let text = if self.colour { colour::plan(&text) } else { text };
        if self.in_motion {
            in_motion::plan(&text, choice, light)
        } else {
            Ok(text)
        }
    }
}

const STATION_HEAD: &str = "\
# The bench: geometry, axes, instruments. Links that begin with `memory:` are the built-in virtual darkroom, so this file
# runs as it is, in virtual time: `isolux check station.toml`, `isolux scan station.toml plan.toml --out run`.
#
# For instruments of your own, change `open`, as zaber:/dev/ttyUSB0?axis=1 or zaber:tcp://10.0.0.5:55550?axis=1.
# `isolux devices` lists drivers with examples, and what is found. Angle = zero_deg + sense × counts ÷ counts_per_deg. Lengths in mm, uncertainties k = 1.
# A [lamp], [shutter], [baffle] or [rail] without an instrument has  prompt = \"what the person is to do\"  in place of open.
";

const STATION_TAIL: &str = "
# What a plan does not measure, this file bounds; without block and bound a result carries no ±. In [bench]:
# stray_max_rel = 0.01            # lamp's light that comes another way, ÷ the largest direct light
# ambient_max_lx = 0.02           # light at the detector with the lamp off
# dark_max_lx = 0.02              # what the capped meter shows
# When the lamp counts as stable. Without this table EN 13032-4: on for 30 min, then (max − min)/mean < 0.5 % over 15 min.
# [lamp.stable]
# least_s = 1800.0
# window_s = 900.0
# spread_rel = 0.005
";

#[cfg(test)]
mod tests {
    use super::*;
    use isolux_record::{Job, Station};

    #[test]
    fn what_is_written_parses_and_fits_together() {
        let keep = tempfile::tempdir().unwrap();
        let folder = Utf8Path::from_path(keep.path()).unwrap().join("bench");
        run(
            &folder,
            DayPlan::default(),
            &Instruments::default(),
            &Subject::default(),
            Overwrite::Never,
        )
        .unwrap();
        let station = Station::load(&folder.join("station.toml")).unwrap();
        let plan = Plan::load(&folder.join("plan.toml")).unwrap();
        let day = isolux_scan::dry_run(&station, &plan).unwrap();
        assert_eq!((day.points, day.spectra), (2275 + 19 + 1 + 1 + 1, 1));
        assert!(day.notes.is_empty(), "{:?}", day.notes);
        assert_eq!(
            Job::load(&folder.join("job.toml")).unwrap().plan(),
            folder.join("plan.toml")
        );
        assert!(
            run(
                &folder,
                DayPlan::Near,
                &Instruments::default(),
                &Subject::default(),
                Overwrite::Never
            )
            .is_err(),
            "nothing is replaced"
        );
        crate::instruments::bench::StationFiles::load(&folder.join("station.toml")).unwrap();
    }

    #[test]
    fn the_day_is_at_the_distance_that_a_plan_at_ten_metres_is_told_to_take() {
        let keep = tempfile::tempdir().unwrap();
        let folder = Utf8Path::from_path(keep.path()).unwrap().join("bench");
        run(
            &folder,
            DayPlan::Published,
            &Instruments::default(),
            &Subject::default(),
            Overwrite::Never,
        )
        .unwrap();
        let planned = |name: &str| crate::scan::plan::run(&folder.join("station.toml"), &folder.join(name)).unwrap();
        let published = planned("plan.toml");
        let distances = published.distances.as_ref().unwrap();
        let at = |mm: f64| distances.costs.iter().find(|cost| cost.distance_mm == mm).unwrap();
        let best_mm = distances.best_mm.unwrap();
        assert!(at(10_000.0).planned && distances.unknown.is_empty(), "{distances:?}");
        for block in DayPlan::default().plan().unwrap().blocks() {
            if block.instrument == isolux_record::plan::Instrument::Luxmeter {
                assert_eq!(block.distance_mm, Some(best_mm), "block {}", block.name);
            }
        }
        assert!(
            published.proposal()[0].contains(&format!("distance_mm = {best_mm}")),
            "{:?}",
            published.proposal()
        );
        std::fs::write(folder.join("near.toml"), DayPlan::Near.text()).unwrap();
        let near = planned("near.toml");
        assert_eq!(near.distances.as_ref().unwrap().best_mm, Some(best_mm));
        assert!(near.proposal()[0].contains("the plan's"), "{:?}", near.proposal());
        assert_eq!(near.table().len(), near.distances.unwrap().costs.len() + 1);
    }

    #[test]
    fn a_bench_has_a_power_meter_and_a_supply_where_they_are_named() {
        let keep = tempfile::tempdir().unwrap();
        let file = Utf8Path::from_path(keep.path()).unwrap().join("bench.toml");
        let meter = part("powermeter", "yokogawa-wt300:modbus-tcp://10.0.0.6:502", &file).unwrap();
        let address = "scpi-supply:tcp://10.0.0.5:5555?profile=dp800&channel=1&voltage_v=24&current_a=0.35";
        let supply = part("supply", address, &file).unwrap();
        bench(&file, &[meter.clone(), supply.clone()], Overwrite::Never).unwrap();
        let text = std::fs::read_to_string(&file).unwrap();
        assert!(text.contains("u_power_rel = 0.001  # CHECK"), "{text}");
        let station = Station::load(&file).unwrap();
        assert_eq!(station.powermeter().unwrap().open, meter.open);
        assert_eq!(station.lamp_switch().unwrap().open, Some(supply.open));
        bench(&file, &[], Overwrite::Force).unwrap();
        let station = Station::load(&file).unwrap();
        assert!(station.powermeter().is_none() && station.supply().is_none());
        let lamp = part("lamp", BY_HAND, &file).unwrap();
        let both = bench(
            &file,
            &[lamp, part("supply", address, &file).unwrap()],
            Overwrite::Force,
        )
        .unwrap_err();
        assert!(both.message.contains("switched by its [supply]"), "{both}");
    }

    #[test]
    fn a_bench_has_what_was_named_and_twins_for_the_rest() {
        let keep = tempfile::tempdir().unwrap();
        let file = Utf8Path::from_path(keep.path()).unwrap().join("bench.toml");
        let named = [
            ("axis.c", "zaber:/dev/ttyUSB0?axis=1"),
            ("luxmeter", "konica-t10a:/dev/ttyUSB1?head=2"),
            ("lamp", BY_HAND),
            ("rail", ABSENT),
            ("ambient", ABSENT),
        ];
        let parts: Vec<Part> = named
            .iter()
            .map(|(name, open)| part(name, open, Utf8Path::new("")).unwrap())
            .collect();
        let written = bench(&file, &parts, Overwrite::Never).unwrap();
        assert_eq!(
            written.len(),
            2,
            "the twin of the spectroradiometer has its calibration: {written:?}"
        );
        let station = crate::instruments::bench::StationFiles::load(&file).unwrap().station;
        assert_eq!(station.axis_c().open, "zaber:/dev/ttyUSB0?axis=1");
        assert_eq!(station.axis_gamma().open, "zaber:memory:axes?axis=2");
        assert_eq!(station.luxmeter().open, "konica-t10a:/dev/ttyUSB1?head=2");
        assert!(station.lamp().unwrap().prompt.is_some() && station.lamp().unwrap().open.is_none());
        assert!(station.rail().is_none() && station.ambient().is_none() && station.baffle().is_some());
        assert!(!crate::instruments::roles::is_virtual(&station));
        let text = std::fs::read_to_string(&file).unwrap();
        let marked = |key: &str| {
            text.lines()
                .filter(|line| line.starts_with(key) && line.contains("CHECK"))
                .count()
        };
        assert_eq!(
            (marked("counts_per_deg"), marked("calibration_factor")),
            (1, 1),
            "of axis.c and of the meter"
        );
        assert!(bench(&file, &parts, Overwrite::Never).is_err(), "nothing is replaced");

        let spectro = [part("spectroradiometer", "ocean-ooi:/dev/ttyUSB2", Utf8Path::new("")).unwrap()];
        let other = file.with_file_name("other.toml");
        assert_eq!(
            bench(&other, &spectro, Overwrite::Force).unwrap(),
            std::slice::from_ref(&other)
        );
        crate::instruments::bench::StationFiles::load(&other).unwrap();
    }

    #[test]
    fn what_cannot_be_part_of_a_bench_is_refused_by_its_name() {
        for (name, open, word) in [
            ("axes", "zaber:x", "axis.gamma"),
            ("axis.c", "hand", "must be an instrument"),
            ("luxmeter", "none", "must be an instrument"),
            ("luxmeter", "zaber:/dev/x", "opens no luxmeter"),
            ("luxmeter", "zeber:/dev/x", "konica-t10a"),
            ("luxmeter", "konica-t10a:/dev/x?hed=1", "hed"),
        ] {
            let failure = part(name, open, Utf8Path::new("")).unwrap_err();
            assert!(failure.message.contains(word), "{name}={open}: {}", failure.message);
        }
        let same = [
            part("axis.c", "zaber:/dev/x?axis=1", Utf8Path::new("")).unwrap(),
            part("axis.gamma", "zaber:/dev/x", Utf8Path::new("")).unwrap(),
        ];
        let file = Utf8Path::new("/no/such/folder/b.toml");
        let failure = bench(file, &same, Overwrite::Never).unwrap_err();
        assert!(failure.message.contains("cannot be both"), "{}", failure.message);
    }
}
