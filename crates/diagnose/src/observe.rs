//! From observation files to rows: what can be fitted, what was kept back, what had to be left out.

use std::collections::BTreeMap;

use isolux_model::SensorPose;
use isolux_record::ReadingKind;
use isolux_record::observation::{Cell, MapPose, MapSet, Observations, Readings, SpectraSet};

use crate::assumed::Part;
use crate::table::{Light, Row, Source};

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

/// Maps with more bins than this along a side are averaged before the fit, with their uncertainty.
const MOST_BINS: usize = 32;
/// Most bins along a side after averaging, where the sides divide no better.
const AVERAGED: usize = 48;
/// And fewest: sooner blocks of unequal size.
const FEWEST: usize = 24;

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
    for (reading, digit) in set.rows().iter().zip(digits) {
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
            c_deg: at.c_deg,
            gamma_deg: at.gamma_deg,
            distance_mm: at.distance_mm,
            travel: f64::from(at.travel),
            range: at.range.map_or(f64::NAN, f64::from),
            ambient_c: at.ambient_c.unwrap_or(f64::NAN),
            ..Row::bare(Source::Reading, measured, u)
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
        ..Row::bare(Source::Bin, signal, u)
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

/// The set without bins at or above the sensor's full scale, and with at most [`AVERAGED`] bins a side: means over
/// blocks of bins, which may differ by one in size, at the mean of their places; uncertainties propagated as
/// independent. What was done, in words.
fn binned(set: &MapSet) -> (MapSet, Vec<String>) {
    let Some((signal, u)) = set.values() else {
        return (set.clone(), Vec::new());
    };
    let full = set.full_scale().unwrap_or(f64::INFINITY);
    let mut notes = Vec::new();
    let usable: Vec<usize> = (0..signal.len()).filter(|&i| signal[i] < full).collect();
    let over = signal.len() - usable.len();
    if over > 0 {
        notes.push(format!("{over} bins at full scale or above it were left out"));
    }
    let bins = set.bins();
    let blocks = bins.map(blocks);
    if blocks == bins {
        if over == 0 {
            return (set.clone(), notes);
        }
        let cells = usable.iter().map(|&i| set.cells()[i]).collect();
        let values = (
            usable.iter().map(|&i| signal[i]).collect(),
            usable.iter().map(|&i| u[i]).collect(),
        );
        // The parts come from a valid set, so the subset is one too.
        return (
            MapSet::new(set, bins, cells, Some(values)).unwrap_or_else(|_| set.clone()),
            notes,
        );
    }
    let block = |i: u32, side: usize| (i as usize * blocks[side] / bins[side]) as u32;
    let mut sums: BTreeMap<Cell, Block> = BTreeMap::new();
    for &i in &usable {
        let cell = &set.cells()[i];
        let key = Cell {
            map: cell.map,
            iy: block(cell.iy, 1),
            ix: block(cell.ix, 0),
        };
        sums.entry(key).or_default().add(signal[i], u[i], set.place_mm(i));
    }
    // How many bins a block of this number has along one side: those i with ⌊i·blocks/bins⌋ = k.
    let size = |k: u32, side: usize| {
        let first = |k: usize| (k * bins[side]).div_ceil(blocks[side]);
        first(k as usize + 1) - first(k as usize)
    };
    let whole = |key: &Cell| size(key.ix, 0) * size(key.iy, 1);
    let before = sums.len();
    sums.retain(|key, block| 2 * block.count >= whole(key));
    let (dropped, partial) = (
        before - sums.len(),
        sums.iter().filter(|(key, block)| block.count < whole(key)).count(),
    );
    let mut note = format!(
        "maps of {} × {} bins were averaged to {} × {}, their uncertainties as of independent bins: what is finer is not searched",
        bins[0], bins[1], blocks[0], blocks[1]
    );
    if partial > 0 {
        note += &format!("; {partial} averages lack bins that were missing or left out");
    }
    if dropped > 0 {
        note += &format!("; {dropped} blocks with fewer than half of their bins were left out");
    }
    let cells = sums.keys().copied().collect();
    let mean = |of: fn(&Block) -> f64| sums.values().map(|block| of(block) / block.count as f64).collect();
    let values = (mean(|block| block.sum), mean(|block| block.squares.sqrt()));
    let places = sums
        .values()
        .map(|block| block.place_mm.map(|mm| mm / block.count as f64))
        .collect();
    let coarse = MapSet::new(set, blocks, cells, Some(values))
        .ok()
        .and_then(|coarse| coarse.centred_at(places));
    match coarse {
        Some(coarse) => {
            notes.push(note);
            (coarse, notes)
        }
        None => (set.clone(), notes),
    }
}

/// Sums over the bins of one block.
#[derive(Default)]
struct Block {
    sum: f64,
    squares: f64,
    place_mm: [f64; 2],
    count: usize,
}

impl Block {
    fn add(&mut self, signal: f64, u: f64, place_mm: [f64; 2]) {
        self.sum += signal;
        self.squares += u * u;
        self.place_mm[0] += place_mm[0];
        self.place_mm[1] += place_mm[1];
        self.count += 1;
    }
}

/// Number of blocks along a side of `bins`: all of equal size where a divisor gives about [`MOST_BINS`], else that
/// many, which differ by one bin in size.
fn blocks(bins: usize) -> usize {
    if bins <= MOST_BINS {
        return bins;
    }
    (FEWEST..=AVERAGED)
        .filter(|count| bins.is_multiple_of(*count))
        .min_by_key(|count| count.abs_diff(MOST_BINS))
        .unwrap_or(MOST_BINS)
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
            ..Row::bare(Source::Sample, measured, u)
        });
    }
    Observed {
        part: Part::Spectra(set.clone(), numbers),
        rows,
        notes: Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use isolux_record::observation::{Need, open};
    use std::fmt::Write as _;

    /// One map of `bins` whose signal is x + 2·y in bins, without those that `missing` chooses.
    fn set(bins: [usize; 2], extra: &str, missing: impl Fn(usize, usize) -> bool) -> MapSet {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| camino::Utf8PathBuf::try_from(folder.path().join(name)).unwrap();
        let toml = format!(
            "sensor_mm = [24.0, 12.0]\nbins = {bins:?}\nunit = \"lx\"\n{extra}[[map]]\nname = \"a\"\ndistance_mm = 500.0\n"
        );
        std::fs::write(path("maps.toml"), toml).unwrap();
        let mut csv = String::from("map,iy,ix,signal,u\n");
        for iy in 0..bins[1] {
            for ix in (0..bins[0]).filter(|&ix| !missing(ix, iy)) {
                let _ = writeln!(csv, "a,{iy},{ix},{},0.5", ix + 2 * iy);
            }
        }
        std::fs::write(path("maps.csv"), csv).unwrap();
        let Observations::Maps(set) = open(&path("maps.toml"), Need::Values).unwrap() else {
            panic!("maps");
        };
        set
    }

    /// Every mean is the signal at its place, and the mean of all bins' squares is kept.
    fn assert_is_averaged(set: &MapSet, coarse: &MapSet) {
        let ([width, height], [nx, ny]) = (set.sensor_mm(), set.bins());
        let (signal, u) = coarse.values().unwrap();
        let mut information = 0.0;
        for (i, (signal, u)) in signal.iter().zip(u).enumerate() {
            let [x, y] = coarse.place_mm(i);
            let (ix, iy) = (
                (x / width + 0.5) * nx as f64 - 0.5,
                (y / height + 0.5) * ny as f64 - 0.5,
            );
            assert!((signal - (ix + 2.0 * iy)).abs() < 1e-9, "{i}: {signal} at {ix}, {iy}");
            information += (0.5 / u).powi(2);
        }
        assert!(
            (information - set.cells().len() as f64).abs() < 1e-6,
            "no bin lost: {information}"
        );
    }

    #[test]
    fn maps_of_any_size_are_averaged_to_about_32() {
        for (bins, expected) in [
            ([24, 24], [24, 24]),
            ([40, 40], [40, 40]),
            ([64, 90], [32, 30]),
            ([111, 111], [37, 37]),
            ([257, 257], [32, 32]),
            ([67, 31], [32, 31]),
            ([49, 131], [32, 32]),
        ] {
            let set = set(bins, "", |_, _| false);
            let (coarse, notes) = binned(&set);
            assert_eq!(coarse.bins(), expected, "{bins:?}");
            assert_eq!(notes.len(), usize::from(bins != expected));
            assert_is_averaged(&set, &coarse);
        }
    }

    #[test]
    fn missing_and_overexposed_bins_are_left_out_and_counted() {
        // A dead row, and a corner over full scale.
        let set = set([257, 64], "full_scale = 370.0\n", |_, iy| iy == 40);
        let (coarse, notes) = binned(&set);
        assert_eq!(coarse.bins(), [32, 32]);
        assert!(notes[0].starts_with("49 bins at full scale"), "{notes:?}");
        assert!(notes[1].contains("averages lack bins"), "{notes:?}");
        assert!(coarse.values().unwrap().0.iter().all(|signal| *signal < 370.0));
        let most = set.cells().len();
        let few: usize = set.values().unwrap().0.iter().filter(|signal| **signal < 370.0).count();
        assert_eq!(most - few, 49);
    }
}
