//! A station file for a bench that is taken into use one cable after the other.

use camino::{Utf8Path, Utf8PathBuf};
use isolux_device::Kind;
use isolux_record::Station;
use isolux_virtual::Instrument;
use isolux_virtual::station::CALIBRATION_FILE;
use isolux_virtual::twins::Choice;

use super::virtual_station::virtual_station;
use crate::Failure;
use crate::files::{self, Overwrite};
use crate::instruments::catalogue::{self, open_failure};

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
    crate::instruments::roles::distinct(&station, file)
        .map_err(|fault| Failure::bad_input(fault).help("nothing was written"))?;
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
