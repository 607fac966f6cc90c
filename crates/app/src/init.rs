//! `init`: a station, plan, scene and job file to start from.

pub mod subject;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_darkroom::{BUILT_IN, Darkroom, Room};
use isolux_device::Kind;
use isolux_record::{Plan, Station, Subject};
use isolux_virtual::Instrument;
use isolux_virtual::station::{CALIBRATION_FILE, calibration, in_memory, station};
use isolux_virtual::twins::Choice;

use crate::Failure;
use crate::catalogue::{self, open_failure};
use crate::files::{self, Overwrite};

/// The plan of the day: 25 half-planes × 91 γ, baffled, spectrum, capped, lamp off.
const PLAN: &str = include_str!("init/plan.toml");

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
pub const SCENE: &str = include_str!("init/scene.toml");
/// The job that names them.
pub const JOB: &str = include_str!("init/job.toml");

/// The station of the built-in virtual darkroom with the twins of `choice`, and the calibration that it names, if it
/// does.
///
/// # Errors
/// Never for the darkroom as it is shipped.
pub fn virtual_station(choice: &Choice) -> Result<(String, Option<String>), Failure> {
    let document = Darkroom::built_in().map_err(Failure::bad_input)?;
    let outlets = in_memory(choice);
    let text = station(&document, &outlets);
    Ok((text, calibration(&Room::new(document), &outlets)))
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
    let (station, calibration) = virtual_station(&instruments.choice()?)?;
    let plan = plan.text();
    let built_in = subject::built_in();
    let station = format!("{STATION_HEAD}{station}{STATION_TAIL}");
    let job = JOB.to_owned() + &subject::text(if stated.is_empty() { &built_in } else { stated });
    let files = [
        ("station.toml", Some(station.as_str())),
        (CALIBRATION_FILE, calibration.as_deref()),
        ("plan.toml", Some(plan.as_str())),
        ("scene.toml", Some(SCENE)),
        ("job.toml", Some(job.as_str())),
    ];
    let files = files.into_iter().filter_map(|(name, text)| Some((name, text?)));
    if folder.is_file() {
        return Err(Failure::bad_input(format!("{folder} is a file, not a folder")));
    }
    for (name, _) in files.clone() {
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

/// A part of a bench, and how it is opened: `axis.c`, `zaber:/dev/ttyUSB0?axis=1`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Part {
    /// Table of the station file.
    pub name: String,
    /// `driver:target`, [`BY_HAND`] or [`ABSENT`].
    pub open: String,
}

/// In place of an address: a person does it, and is asked.
pub const BY_HAND: &str = "hand";
/// In place of an address: the bench has no such part.
pub const ABSENT: &str = "none";

/// The parts of a bench in the order of the station file, what each is, and whether a person can do it or it can be
/// absent.
pub const PARTS: [(&str, Kind, Spare); 11] = [
    ("axis.c", Kind::Axis, Spare::Needed),
    ("axis.gamma", Kind::Axis, Spare::Needed),
    ("luxmeter", Kind::LuxMeter, Spare::Needed),
    ("spectroradiometer", Kind::Spectroradiometer, Spare::Absent),
    ("powermeter", Kind::PowerMeter, Spare::Absent),
    ("supply", Kind::Switch, Spare::Absent),
    ("lamp", Kind::Switch, Spare::ByHand("switch the lamp as the block says")),
    (
        "shutter",
        Kind::Switch,
        Spare::ByHand("cap or uncap the detector as the block says"),
    ),
    (
        "baffle",
        Kind::Switch,
        Spare::ByHand("put the baffle into the beam, or take it out, as the block says"),
    ),
    (
        "rail",
        Kind::Axis,
        Spare::ByHand("set the detector to the distance of the block"),
    ),
    ("ambient", Kind::Thermometer, Spare::Absent),
];

/// What a bench can do without.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Spare {
    /// Nothing: the part is an instrument.
    Needed,
    /// A person can do it, asked with these words; or it is absent.
    ByHand(&'static str),
    /// It can be absent.
    Absent,
}

/// Writes a station file for a bench of its own: each of `parts` as it says, all others as twins of the built-in room,
/// so that one cable after the other is taken into use. Beside it the calibration of the twin of the spectroradiometer,
/// where that is one. Nothing is opened.
///
/// # Errors
/// Bad input (exit 2) for a part or an address that is none, and for two parts that are the same thing; when a file
/// exists and may not be replaced.
pub fn bench(file: &Utf8Path, parts: &[Part], overwrite: Overwrite) -> Result<Vec<Utf8PathBuf>, Failure> {
    let (twins, calibration) = virtual_station(&on_a_bench(parts))?;
    let text = bench_text(&twins, parts);
    let station = Station::parse(file, &text).map_err(Failure::bad_input)?;
    crate::roles::distinct(&station, file).map_err(|fault| Failure::bad_input(fault).help("nothing was written"))?;
    let twin = station
        .spectroradiometer()
        .is_some_and(|spectro| spectro.open.contains(":memory:"));
    let beside = file.with_file_name(CALIBRATION_FILE);
    let files = [(file.to_owned(), Some(text)), (beside, calibration.filter(|_| twin))];
    let files: Vec<(Utf8PathBuf, String)> = files
        .into_iter()
        .filter_map(|(path, text)| Some((path, text?)))
        .collect();
    for (path, _) in &files {
        files::refuse_existing(path, overwrite)?;
    }
    for (path, text) in &files {
        files::write(path, text.as_bytes(), overwrite)?;
    }
    Ok(files.into_iter().map(|(path, _)| path).collect())
}

/// Whether a part can be opened so in the station `file`.
///
/// # Errors
/// Bad input (exit 2) names the parts, or what is wrong with the address.
pub fn part(name: &str, open: &str, file: &Utf8Path) -> Result<Part, Failure> {
    let known = PARTS.iter().find(|(part, ..)| *part == name);
    let Some((_, kind, spare)) = known else {
        let names: Vec<&str> = PARTS.iter().map(|(part, ..)| *part).collect();
        return Err(Failure::bad_input(format!(
            "{name} is no part of a bench; there are {}",
            names.join(", ")
        )));
    };
    match (open, spare) {
        (BY_HAND, Spare::ByHand(_)) | (ABSENT, Spare::ByHand(_) | Spare::Absent) => {}
        (BY_HAND | ABSENT, _) => {
            return Err(Failure::bad_input(format!(
                "{name}={open}: this part must be an instrument"
            )));
        }
        _ => catalogue::place(open, *kind, file).map_err(open_failure)?,
    }
    Ok(Part {
        name: name.to_owned(),
        open: open.to_owned(),
    })
}

/// The twins of the parts that a bench has anyway, and of those that it has where they are named.
fn on_a_bench(parts: &[Part]) -> Choice {
    let mut choice = Choice::default();
    for (name, instrument) in [("powermeter", Instrument::Powermeter), ("supply", Instrument::Supply)] {
        if parts.iter().any(|part| part.name == name && part.open != ABSENT) {
            choice.add(instrument);
        }
    }
    choice
}

/// The text of a station of twins with `parts` in their place.
fn bench_text(twins: &str, parts: &[Part]) -> String {
    let mut text = BENCH_HEAD.to_owned();
    // The tables of the text, each with what stands above its name.
    for table in twins.split_inclusive("\n\n") {
        let name = table.lines().find_map(|line| line.strip_prefix('[')?.strip_suffix(']'));
        let Some(part) = parts.iter().find(|part| Some(part.name.as_str()) == name) else {
            match name {
                Some("bench") => text.extend(table.lines().map(|line| marked(line) + "\n")),
                None => text.push_str(&table.replace("virtual darkroom", "bench")),
                Some(_) => text.push_str(table),
            }
            continue;
        };
        let spare = PARTS
            .iter()
            .find(|(known, ..)| *known == part.name)
            .map(|(.., spare)| *spare);
        match (part.open.as_str(), spare) {
            (ABSENT, _) => {}
            (BY_HAND, Some(Spare::ByHand(prompt))) => {
                text.push_str(&format!("[{}]\nprompt = {prompt:?}\n", part.name));
                if part.name == "lamp" {
                    text.push_str("# Largest extent of the luminous area.\ndiameter_mm = 73.0\n");
                }
                text.push('\n');
            }
            (open, _) => {
                for line in table.lines() {
                    let line = match line {
                        _ if line.starts_with("open = ") => format!("open = {open:?}"),
                        _ if line.starts_with("calibration = ") => {
                            "calibration = \"device\"  # or a CSV of wavelength_nm,factor beside this file".to_owned()
                        }
                        _ => marked(line),
                    };
                    text.push_str(&line);
                    text.push('\n');
                }
            }
        }
    }
    text
}

/// A line of a twin's table, marked where its value has to become that of the bench.
fn marked(line: &str) -> String {
    if OF_THE_TWIN.iter().any(|key| line.starts_with(key)) {
        format!("{line}  # CHECK: of the twin")
    } else {
        line.to_owned()
    }
}

/// Keys whose value is that of the twin, and has to be that of the bench.
const OF_THE_TWIN: [&str; 16] = [
    "counts_per",
    "zero_",
    "sense",
    "limit_",
    "speed_",
    "accel_",
    "calibration_factor",
    "u_",
    "certificate",
    "noise_",
    "distance_mm",
    "diameter_mm",
    "flux_lm",
    "peak_cd",
    "stray_",
    "floor_mm",
];

const BENCH_HEAD: &str = "\
# A bench that is taken into use one cable at a time. Links that begin with `memory:` are twins of the virtual darkroom, which see its
# axes and its lamp alone; with one real instrument time is real. Lines marked CHECK still have the twin's value: the bench's own belongs
# there. How to find it is in the book, \"Your own bench\".
# Angle = zero_deg + sense × counts ÷ counts_per_deg; counts_per_deg = full steps a turn × microsteps × gear ÷ 360, as a ratio \"n/d\".
";

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
        Ok(choice)
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
    use isolux_record::Job;

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
        crate::bench::Source::load(&folder.join("station.toml")).unwrap();
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
        let planned = |name: &str| crate::plan::run(&folder.join("station.toml"), &folder.join(name)).unwrap();
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
        let station = crate::bench::Source::load(&file).unwrap().station;
        assert_eq!(station.axis_c().open, "zaber:/dev/ttyUSB0?axis=1");
        assert_eq!(station.axis_gamma().open, "zaber:memory:axes?axis=2");
        assert_eq!(station.luxmeter().open, "konica-t10a:/dev/ttyUSB1?head=2");
        assert!(station.lamp().unwrap().prompt.is_some() && station.lamp().unwrap().open.is_none());
        assert!(station.rail().is_none() && station.ambient().is_none() && station.baffle().is_some());
        assert!(!crate::stage::is_virtual(&station));
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
        crate::bench::Source::load(&other).unwrap();
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
