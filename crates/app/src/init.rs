//! `init`: a station, plan, scene and job file to start from.

use camino::{Utf8Path, Utf8PathBuf};
use isolux_darkroom::{BUILT_IN, Darkroom, Room};
use isolux_record::Plan;
use isolux_virtual::Instrument;
use isolux_virtual::station::{CALIBRATION_FILE, calibration, in_memory, station};
use isolux_virtual::twins::Choice;

use crate::Failure;
use crate::files::{self, Overwrite};

/// The plan of the day: 25 half-planes × 91 γ, baffled, spectrum, capped, lamp off.
const PLAN: &str = include_str!("init/plan.toml");

/// Plans of the day.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DayPlan {
    /// At the distance that `isolux plan` proposes for the virtual bench.
    Near,
    /// The published one, at 10 m, the station's own distance.
    #[default]
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

/// The station of the built-in virtual darkroom with the twins of `choice`, and the calibration that it names, if it does.
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
    overwrite: Overwrite,
) -> Result<Vec<Utf8PathBuf>, Failure> {
    let (station, calibration) = virtual_station(&instruments.choice()?)?;
    let plan = plan.text();
    let station = format!("{STATION_HEAD}{station}{STATION_TAIL}");
    let files = [
        ("station.toml", Some(station.as_str())),
        (CALIBRATION_FILE, calibration.as_deref()),
        ("plan.toml", Some(plan.as_str())),
        ("scene.toml", Some(SCENE)),
        ("job.toml", Some(JOB)),
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
    use isolux_record::{Job, Station};

    #[test]
    fn what_is_written_parses_and_fits_together() {
        let keep = tempfile::tempdir().unwrap();
        let folder = Utf8Path::from_path(keep.path()).unwrap().join("bench");
        run(&folder, DayPlan::Near, &Instruments::default(), Overwrite::Never).unwrap();
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
            run(&folder, DayPlan::Near, &Instruments::default(), Overwrite::Never).is_err(),
            "nothing is replaced"
        );
        crate::bench::Source::load(&folder.join("station.toml")).unwrap();
    }

    #[test]
    fn the_day_is_at_the_distance_that_a_plan_at_ten_metres_is_told_to_take() {
        let keep = tempfile::tempdir().unwrap();
        let folder = Utf8Path::from_path(keep.path()).unwrap().join("bench");
        run(&folder, DayPlan::Published, &Instruments::default(), Overwrite::Never).unwrap();
        let planned = |name: &str| crate::plan::run(&folder.join("station.toml"), &folder.join(name)).unwrap();
        let published = planned("plan.toml");
        let distances = published.distances.as_ref().unwrap();
        let at = |mm: f64| distances.costs.iter().find(|cost| cost.distance_mm == mm).unwrap();
        let best_mm = distances.best_mm.unwrap();
        assert!(at(10_000.0).planned && distances.unknown.is_empty(), "{distances:?}");
        for block in DayPlan::Near.plan().unwrap().blocks() {
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
}
