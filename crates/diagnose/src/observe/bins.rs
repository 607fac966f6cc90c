//! Maps of many bins, averaged over blocks of them.

use std::collections::BTreeMap;

use isolux_record::observation::{Cell, MapSet};

use crate::calibration::MOST_BINS;

/// Most bins along a side after averaging, where the sides divide no better.
const AVERAGED: usize = 48;
/// And fewest: sooner blocks of unequal size.
const FEWEST: usize = 24;

/// The set without bins at or above the sensor's full scale, and with at most [`AVERAGED`] bins a side: means over
/// blocks of bins, which may differ by one in size, at the mean of their places; uncertainties propagated as
/// independent. What was done, in words.
pub(super) fn binned(set: &MapSet) -> (MapSet, Vec<String>) {
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

#[cfg(test)]
mod tests {
    use super::*;
    use isolux_record::observation::{Need, Observations, open};
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
