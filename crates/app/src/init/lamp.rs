//! `init --lamp`: room, station and plan for a luminaire of which there is a photometric file, so that its scan can be
//! rehearsed before it is mounted.

mod plan;

use camino::Utf8Path;
use isolux_darkroom::parts::RING_KEYS;
use isolux_darkroom::{Darkroom, Room, table};
use isolux_formats::{Distribution, Finding};
use isolux_photometry::IntensityDistribution;
use isolux_record::document::SourceText;
use isolux_record::station::Rail;
use isolux_record::subject::LUMINAIRE_KEYS;
use isolux_record::{Plan, Station, Subject};
use isolux_scan::distances;
use isolux_virtual::station::{CALIBRATION_FILE, calibration, in_memory, station_in};
use isolux_virtual::twins::Choice;

use crate::{Failure, files};

/// Name of the room's file, and of the lamp's table beside it.
const ROOM_FILE: &str = "room.toml";
const TABLE_FILE: &str = "lamp.csv";

/// Diameter of a luminaire whose file states none, mm.
const UNKNOWN_DIAMETER_MM: f64 = 100.0;
/// Share of the peak that the reference point, γ = 0°, needs to show the lamp's drift.
const LEAST_REFERENCE: f64 = 0.05;
/// Most light on the spectroradiometer, lx: its shortest integration is then not yet full.
const MOST_SPECTRO_LX: f64 = 1e5;

/// Files for one luminaire, and what a person should know of them.
pub struct LampFiles {
    /// Name and text, in the order of writing.
    pub files: Vec<(&'static str, String)>,
    /// The light of the file.
    pub light: IntensityDistribution,
    /// What the luminaire is, for the job.
    pub subject: Subject,
    /// How the grid was chosen and what had to be assumed, a sentence each.
    pub notes: Vec<String>,
}

/// Room, table, station, plan and scene for the luminaire of the photometric file `path`, with the twins of `choice`.
///
/// # Errors
/// Bad input (exit 2): no distribution in the file, no light, or none along γ = 0°, where a scan has its reference.
pub fn lamp(path: &Utf8Path, choice: &Choice) -> Result<LampFiles, Failure> {
    let name = path.file_name().unwrap_or(path.as_str());
    let refused = |findings: Vec<Finding>| {
        let why: Vec<String> = findings
            .into_iter()
            .map(|finding| finding.message.into_string())
            .collect();
        Failure::bad_input(format!("{path}: {}", why.join("; ")))
    };
    let (file, _) = Distribution::load(&files::read(path)?, name).map_err(refused)?;
    let mut notes = Vec::new();
    let light = illuminated(&file.intensity)?;
    let peak = light.peak();
    if peak.intensity_cd <= 0.0 {
        return Err(Failure::bad_input(format!("{path}: has no light")));
    }
    let axis_cd = light.pole_cd(0.0);
    if axis_cd < LEAST_REFERENCE * peak.intensity_cd {
        return Err(Failure::bad_input(format!(
            "{path}: {axis_cd:.1} cd along γ = 0° are less than {} % of the peak, {:.1} cd at C {}° γ {}°, and a scan visits C 0°, \
             γ 0° for the lamp's warm-up and drift",
            100.0 * LEAST_REFERENCE, peak.intensity_cd, peak.c_deg, peak.gamma_deg
        ))
        .help("a luminaire that shines upwards is mounted the other way round: turn its file first"));
    }
    let diameter_mm = diameter_mm(&file).unwrap_or_else(|| {
        notes.push(format!(
            "{name} states no luminous size: {UNKNOWN_DIAMETER_MM} mm assumed, luminous_diameter_mm in {ROOM_FILE}"
        ));
        UNKNOWN_DIAMETER_MM
    });
    let table = table_of(&light);
    // Near enough for light, far enough for the detector to see the whole disc under small angles.
    let near_mm = (5.0 * diameter_mm).max(1000.0 * (peak.intensity_cd / MOST_SPECTRO_LX).sqrt());
    let near_mm = ((near_mm / 100.0).ceil() * 100.0).clamp(500.0, 12_000.0);
    let room_text = room(
        name,
        diameter_mm,
        near_mm,
        axis_cd,
        file.luminaire.watts.filter(|watts| *watts > 0.0),
    );
    let source = SourceText {
        file: Utf8Path::new(ROOM_FILE),
        text: &room_text,
    };
    let (document, _) = Darkroom::complete(source, &|_| Ok(table.clone())).map_err(Failure::bad_input)?;

    let outlets = in_memory(choice);
    let station_text = station_in(Some(ROOM_FILE), &document, &outlets);
    let station = Station::parse(Utf8Path::new("station.toml"), &station_text).map_err(Failure::bad_input)?;
    let grid = plan::Grid::choose(&light);
    notes.push(grid.to_string());
    let text_at = |distance_mm: f64| plan::text(name, &grid, distance_mm);
    let draft =
        Plan::parse(Utf8Path::new("plan.toml"), &text_at(station.bench().distance_mm)).map_err(Failure::bad_input)?;
    let costs = crate::scan::plan::display(&station, Utf8Path::new("station.toml"))
        .and_then(|display| distances(&station, &draft, &display));
    let farthest = || {
        let rail = station.rail().and_then(Rail::driven);
        rail.map_or(station.bench().distance_mm, |rail| rail.limit_mm[1])
    };
    let distance_mm = costs.and_then(|costs| costs.best_mm).unwrap_or_else(|| {
        notes.push(format!(
            "{diameter_mm} mm are too large for the far field on this bench: the plan takes its longest distance, and near \
             the lamp's edges directions blur"
        ));
        farthest()
    });
    let mut files = vec![
        (ROOM_FILE, room_text),
        (TABLE_FILE, table),
        ("station.toml", station_text),
    ];
    files.extend(calibration(&Room::new(document), &outlets).map(|text| (CALIBRATION_FILE, text)));
    files.push(("plan.toml", text_at(distance_mm)));
    files.push((
        "scene.toml",
        super::SCENE.replace("distance_mm = 500.0", &format!("distance_mm = {near_mm:.1}")),
    ));
    Ok(LampFiles {
        files,
        light,
        subject: subject(&file),
        notes,
    })
}

/// The distribution without what a measurement leaves below zero.
fn illuminated(light: &IntensityDistribution) -> Result<IntensityDistribution, Failure> {
    let intensity_cd = light.intensity_cd().iter().map(|value| value.max(0.0)).collect();
    IntensityDistribution::new(light.c_deg().to_vec(), light.gamma_deg().to_vec(), intensity_cd)
        .map_err(Failure::bad_input)
}

/// The table of the room, at the directions of the file.
fn table_of(light: &IntensityDistribution) -> String {
    let mut text = format!("{}\n", table::HEAD);
    for (plane, c_deg) in light.c_deg().iter().enumerate() {
        for (gamma_deg, intensity_cd) in light.gamma_deg().iter().zip(light.row(plane)) {
            text += &format!("{c_deg},{gamma_deg},{intensity_cd}\n");
        }
    }
    text
}

/// Largest extent of the luminous area, or of the luminaire where that is not stated, mm.
fn diameter_mm(file: &Distribution) -> Option<f64> {
    let luminaire = &file.luminaire;
    let largest = |length: Option<f64>, width: Option<f64>| {
        let largest = length?.max(width.unwrap_or(0.0));
        (largest > 0.0).then_some(largest)
    };
    largest(luminaire.luminous_length_mm, luminaire.luminous_width_mm)
        .or_else(|| largest(luminaire.length_mm, luminaire.width_mm))
        .filter(|diameter| (1.0..=10_000.0).contains(diameter))
}

/// The built-in room with this lamp: the spectroradiometer and the camera at `near_mm`.
fn room(name: &str, diameter_mm: f64, near_mm: f64, axis_cd: f64, watts: Option<f64>) -> String {
    let mut table = "";
    let mut text = String::new();
    for line in super::ROOM.lines() {
        table = if line.starts_with('[') { line } else { table };
        let key = line.trim_start_matches("# ").split([' ', '=']).next().unwrap_or("");
        let comment = line.find('#').map_or("", |at| &line[at..]);
        let set = |value: String| {
            format!("{:<31} {comment}\n", format!("{key} = {value}"))
                .trim_end()
                .to_owned()
                + "\n"
        };
        text += &match (table, key) {
            ("[lamp]", "[lamp]") => format!(
                "[lamp]\n# The luminaire of {name:?}, absolute, full circle, at the directions of that file.\n\
                 table = \"{TABLE_FILE}\"\nluminous_diameter_mm = {diameter_mm:?}   # of the disc that shines with it from every point\n"
            ),
            ("[lamp]", "table" | "luminous_diameter_mm") => continue,
            ("[lamp]", key) if RING_KEYS.contains(&key) => continue,
            ("[lamp]", "voltage_v") => set("230.0".to_owned()),
            ("[lamp]", "power_w") => match watts {
                Some(watts) => set(format!("{watts:?}")),
                None => format!("{line}\n"),
            },
            ("[spectroradiometer]", "distance_mm") => set(format!("{near_mm:.1}")),
            ("[camera]", "full_scale_lx") => set(format!("{:.4e}", axis_cd / (near_mm * 1e-3).powi(2))),
            _ => format!("{line}\n"),
        };
    }
    text
}

/// What the file says of the luminaire, as far as a job can hold it.
fn subject(file: &Distribution) -> Subject {
    let mut subject = Subject::default();
    let luminaire = &file.luminaire;
    let fits = |key: usize, text: &str| {
        let text = text.trim();
        LUMINAIRE_KEYS[key].check(text).is_ok().then(|| text.to_owned())
    };
    subject.luminaire.maker = fits(0, &luminaire.manufacturer);
    subject.luminaire.name = fits(1, &luminaire.name).or_else(|| Some("rehearsed from a photometric file".to_owned()));
    subject.luminaire.catalogue_number = fits(2, &luminaire.number);
    subject.luminaire.light_source = fits(4, &luminaire.lamp);
    subject
}
