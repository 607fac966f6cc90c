//! From observation files to rows: what can be fitted, what was kept back, what had to be left out.

mod bins;

use std::cmp::Ordering;
use std::collections::BTreeMap;

use isolux_model::SensorPose;
use isolux_record::ReadingKind;
use isolux_record::observation::{Cell, MapPose, MapSet, Observations, ReadingRow, Readings, SpectraSet};

use crate::assumed::Part;
use crate::table::{Light, ObservationKind, Row};

use bins::binned;

/// One observation file, ready to be fitted.
#[derive(Debug, Clone)]
pub struct Observed {
    /// Coordinates, for the model.
    pub part: Part,
    /// One row each, with its value.
    pub rows: Vec<Row>,
    /// What was left out, in words.
    pub notes: Vec<String>,
}

/// The rows of a file that are to be fitted, and those that the file itself holds out (maps with `held_out = true`).
///
/// `file` is the number of the file among all observations.
pub fn observed(observations: &Observations, file: usize) -> (Observed, Option<Observed>) {
    match observations {
        Observations::Readings(set) => (readings(set, file), None),
        Observations::Maps(set) => maps(set, file),
        Observations::Spectra(set) => (spectra(set, file), None),
    }
}

fn light(kind: ReadingKind) -> Light {
    match kind {
        ReadingKind::Lit => Light::Lit,
        ReadingKind::Baffled => Light::Baffled,
        ReadingKind::LampOff => Light::LampOff,
        ReadingKind::Capped => Light::Capped,
    }
}

fn readings(set: &Readings, file: usize) -> Observed {
    let mut blocks: Vec<&str> = Vec::new();
    let (mut coordinates, mut rows) = (Vec::new(), Vec::new());
    let mut left_out = 0;
    let digits = digits(set);
    for place in in_time(set.rows()) {
        let (reading, digit) = (&set.rows()[place], digits[place]);
        let group = blocks
            .iter()
            .position(|block| *block == reading.block)
            .unwrap_or_else(|| {
                blocks.push(&reading.block);
                blocks.len() - 1
            });
        let (Some(measured), Some(u)) = (reading.illuminance_lx, reading.u_lx) else {
            left_out += 1;
            continue;
        };
        let at = reading.at;
        coordinates.push(at);
        rows.push(Row {
            file,
            group,
            digit,
            light: light(at.kind),
            index: reading.index.map_or(f64::NAN, |index| index as f64),
            time_s: at.time_s.unwrap_or(f64::NAN),
            lamp_s: at.lamp_age_s().unwrap_or(f64::NAN),
            c_deg: at.c_deg,
            gamma_deg: at.gamma_deg,
            distance_mm: at.distance_mm,
            travel: f64::from(at.travel),
            range: at.range.map_or(f64::NAN, f64::from),
            ambient_c: at.ambient_c.unwrap_or(f64::NAN),
            ..Row::bare(ObservationKind::Reading, measured, u)
        });
    }
    let notes = match left_out {
        0 => Vec::new(),
        n => vec![format!(
            "{n} readings without a value (over range, under range or failed) were left out"
        )],
    };
    Observed {
        part: Part::Readings(coordinates),
        rows,
        notes,
    }
}

/// Places of the rows in the order in which they were taken, whatever order the file has: by time, where that is the
/// same by number, and where both are by what they hold.
fn in_time(rows: &[ReadingRow]) -> Vec<usize> {
    let numbers = |row: &ReadingRow| {
        let at = &row.at;
        let or_last = |value: Option<f64>| value.unwrap_or(f64::INFINITY);
        let [lamp_s, lux, u] = [at.lamp_s, row.illuminance_lx, row.u_lx].map(or_last);
        [
            lamp_s,
            at.c_deg,
            at.gamma_deg,
            at.distance_mm,
            f64::from(at.travel),
            lux,
            u,
        ]
    };
    let by_numbers = |a: &ReadingRow, b: &ReadingRow| {
        let pairs = numbers(a).into_iter().zip(numbers(b));
        pairs.fold(Ordering::Equal, |order, (a, b)| order.then(a.total_cmp(&b)))
    };
    let time = |row: &ReadingRow| row.at.time_s.unwrap_or(f64::INFINITY);
    let mut places: Vec<usize> = (0..rows.len()).collect();
    places.sort_by(|&a, &b| {
        let (a, b) = (&rows[a], &rows[b]);
        time(a)
            .total_cmp(&time(b))
            .then(a.index.cmp(&b.index))
            .then_with(|| a.block.cmp(&b.block))
            .then(a.at.kind.cmp(&b.at.kind))
            .then_with(|| by_numbers(a, b))
    });
    places
}

/// One digit of the display for every reading, in lx: from the column of that name, else the last decimal place that
/// any reading of the same range was written with; 0 where that cannot be told.
fn digits(set: &Readings) -> Vec<f64> {
    let column = |name: &str| set.header().iter().position(|header| header == name);
    let text = |row: &[String], column: Option<usize>| -> Option<String> { row.get(column?).cloned() };
    let (stated, value, range) = (column("digit_lx"), column("illuminance_lx"), column("range"));
    let mut decimals: BTreeMap<Option<String>, Option<usize>> = BTreeMap::new();
    for row in set.text() {
        let Some(written) = text(row, value).filter(|written| !written.is_empty()) else {
            continue;
        };
        let places = match (written.split_once('.'), written.contains(['e', 'E'])) {
            (_, true) => None,
            (Some((_, after)), _) => Some(after.len()),
            (None, _) => Some(0),
        };
        let known = decimals.entry(text(row, range)).or_insert(places);
        *known = known.zip(places).map(|(a, b)| a.max(b));
    }
    set.text()
        .iter()
        .map(|row| {
            let stated = text(row, stated).and_then(|digit| digit.parse::<f64>().ok());
            let inferred = || {
                let places = decimals.get(&text(row, range)).copied().flatten()?;
                Some(10_f64.powi(-(places as i32)))
            };
            stated
                .or_else(inferred)
                .filter(|digit| digit.is_finite() && *digit > 0.0)
                .unwrap_or(0.0)
        })
        .collect()
}

fn maps(set: &MapSet, file: usize) -> (Observed, Option<Observed>) {
    let (set, notes) = binned(set);
    let held = |cell: &Cell| set.maps()[cell.map as usize].held_out;
    let fitted = chosen(&set, file, |cell| !held(cell), notes);
    let any_held = set.cells().iter().any(held) && set.values().is_some();
    let kept_back = any_held.then(|| chosen(&set, file, held, Vec::new()));
    (fitted, kept_back)
}

/// The rows of the cells that `wanted` chooses.
fn chosen(set: &MapSet, file: usize, wanted: impl Fn(&Cell) -> bool, notes: Vec<String>) -> Observed {
    let Some((signal, u)) = set.values() else {
        return Observed {
            part: Part::Maps(set.clone()),
            rows: Vec::new(),
            notes,
        };
    };
    let pick: Vec<usize> = (0..set.cells().len()).filter(|&i| wanted(&set.cells()[i])).collect();
    let cells: Vec<Cell> = pick.iter().map(|&i| set.cells()[i]).collect();
    let values = (
        pick.iter().map(|&i| signal[i]).collect(),
        pick.iter().map(|&i| u[i]).collect(),
    );
    let rows = pick
        .iter()
        .map(|&i| row(set, file, &set.cells()[i], signal[i], u[i]))
        .collect();
    // The parts come from a valid set, so the subset is one too.
    let subset = MapSet::new(set, set.bins(), cells, Some(values))
        .ok()
        .and_then(|subset| subset.centred_at(pick.iter().map(|&i| set.place_mm(i)).collect()))
        .unwrap_or_else(|| set.clone());
    Observed {
        part: Part::Maps(subset),
        rows,
        notes,
    }
}

fn row(set: &MapSet, file: usize, cell: &Cell, signal: f64, u: f64) -> Row {
    let pose = &set.maps()[cell.map as usize];
    let ([width, height], [nx, ny]) = (set.sensor_mm(), set.bins());
    let x_mm = (f64::from(cell.ix) + 0.5) * width / nx as f64 - 0.5 * width;
    let y_mm = (f64::from(cell.iy) + 0.5) * height / ny as f64 - 0.5 * height;
    let light = match (pose.capped, pose.lamp) {
        (true, _) => Light::Capped,
        (false, true) => Light::Lit,
        (false, false) => Light::LampOff,
    };
    Row {
        file,
        group: cell.map as usize,
        light,
        time_s: pose.time_s.unwrap_or(f64::NAN),
        distance_mm: pose.distance_mm,
        ambient_c: pose.ambient_c.unwrap_or(f64::NAN),
        x_mm,
        y_mm,
        incidence_deg: incidence_deg(pose, x_mm, y_mm),
        exposure: pose.exposure,
        ..Row::bare(ObservationKind::Bin, signal, u)
    }
}

fn incidence_deg(pose: &MapPose, x_mm: f64, y_mm: f64) -> f64 {
    let mut sensor = SensorPose::facing(pose.distance_mm);
    (sensor.tilt_x_deg, sensor.tilt_y_deg, sensor.rot_z_deg) = (pose.tilt_x_deg, pose.tilt_y_deg, pose.rot_z_deg);
    sensor.offset_mm.x = pose.offset_mm[0];
    sensor.offset_mm.y = pose.offset_mm[1];
    let mut place = sensor.offset_mm;
    (place.x, place.y) = (x_mm, y_mm);
    let at = sensor.lamp_from_sensor(place);
    let cosine = -at.dot(sensor.normal()) / at.length();
    cosine.clamp(-1.0, 1.0).acos().to_degrees()
}

fn spectra(set: &SpectraSet, file: usize) -> Observed {
    let (mut numbers, mut rows) = (Vec::new(), Vec::new());
    for (number, sample) in set.rows().iter().enumerate() {
        let (Some(measured), Some(u)) = (sample.value, sample.u) else {
            continue;
        };
        numbers.push(number);
        rows.push(Row {
            file,
            group: usize::try_from(sample.index).unwrap_or(0),
            light: light(sample.kind),
            wavelength_nm: sample.wavelength_nm,
            distance_mm: set.distance_mm,
            ..Row::bare(ObservationKind::Sample, measured, u)
        });
    }
    Observed {
        part: Part::Spectra(set.clone(), numbers),
        rows,
        notes: Vec::new(),
    }
}
