//! A spectrum of any spacing, at the whole nanometres of the CIE's tables.
//!
//! The tables are lines between whole nanometres. A spectrum that bends at whole nanometres alone is a line there too,
//! and the sum of products at 1 nm is the CIE's own rule (CIE 15, 7.1). A spectrum with a point strictly between two
//! whole nanometres has more to say in that nanometre than its two ends: there the product of the two is integrated
//! exactly, piece by piece.

use crate::{Spectrum, cie};

/// Number of entries of a table.
const TABLE: usize = cie::LAST_NM - cie::FIRST_NM + 1;

/// Nanometre `i` reaches from 359 + i to 360 + i, so that the entry of 360 + i lies between nanometres `i` and `i + 1`.
const NANOMETRES: usize = TABLE + 1;

/// Entries w(360), … w(830) with Σ w·t = ∫ Π S·t dλ for every table t that is linear between whole
/// nanometres: ∫ Π S·hat dλ with the triangle "hat" of ±1 nm about each. In a nanometre where no factor has a
/// point, half of the product at each end.
pub(crate) fn per_nm(factors: &[&Spectrum]) -> [f64; TABLE] {
    if factors.iter().all(|factor| has_whole_nm_alone(factor)) {
        return std::array::from_fn(|k| factors.iter().map(|factor| at_whole_nm(factor, from(k + 1))).product());
    }
    // The first point of each factor that is not below the wavelength at hand: all go up together.
    let mut above = vec![0; factors.len()];
    let mut halves = [0.0; NANOMETRES];
    let mut parts = [None; NANOMETRES];
    for i in 0..NANOMETRES {
        let mut product = 1.0;
        for (spectrum, above) in factors.iter().zip(&mut above) {
            let nm = &spectrum.wavelength_nm()[*above..];
            *above += nm.iter().take_while(|nm| **nm < from(i)).count();
            product *= spectrum.at_nm_from(*above, from(i));
        }
        halves[i] = 0.5 * product;
        parts[i] = exact(factors, &above, from(i));
    }
    let outside = |i: usize| {
        let overlaps = |s: &&Spectrum| s.first_nm() < from(i) + 1.0 && s.last_nm() > from(i);
        !factors.iter().all(overlaps)
    };
    std::array::from_fn(|k| {
        let (below, above) = (k, k + 1);
        // Where data end at a whole nanometre the rule at 1 nm counts half a nanometre beyond; exact integrals do not.
        let end = |part: Option<[f64; 2]>, i: usize, side: usize, inner: usize| match part {
            Some(part) => part[side],
            None if outside(i) && parts[inner].is_some() => 0.0,
            None => halves[above],
        };
        end(parts[below], below, 1, above) + end(parts[above], above, 0, below)
    })
}

/// All points at whole nanometres: none is strictly inside of one.
fn has_whole_nm_alone(spectrum: &Spectrum) -> bool {
    spectrum.wavelength_nm().iter().all(|nm| *nm == f64::from(*nm as i32))
}

/// The value at a whole nanometre; where there is a point at each, its place is known.
fn at_whole_nm(spectrum: &Spectrum, nm: f64) -> f64 {
    let place = (nm - spectrum.first_nm()) as usize;
    match spectrum.wavelength_nm().get(place) {
        Some(at) if *at == nm => spectrum.value()[place],
        _ => spectrum.at_nm(nm),
    }
}

/// Where nanometre `i` begins.
fn from(i: usize) -> f64 {
    (cie::FIRST_NM - 1 + i) as f64
}

/// ∫ Π S·(1 − t) and ∫ Π S·t over the nanometre that begins at `from_nm`, t = 0…1 across it; none where no
/// factor has a point strictly inside. `first` is the first point of each factor that is not below `from_nm`.
fn exact(factors: &[&Spectrum], first: &[usize], from_nm: f64) -> Option<[f64; 2]> {
    let to_nm = from_nm + 1.0;
    let points = |k: usize| {
        let nm = &factors[k].wavelength_nm()[first[k]..];
        &nm[..nm.iter().take_while(|nm| **nm < to_nm).count()]
    };
    let inside = |k: usize| points(k).iter().copied().filter(|nm| *nm > from_nm);
    let mut bends: Vec<f64> = (0..factors.len()).flat_map(inside).collect();
    if bends.is_empty() {
        return None;
    }
    bends.extend([from_nm, to_nm]);
    bends.sort_by(f64::total_cmp);
    let points: Vec<&[f64]> = (0..factors.len()).map(points).collect();
    let mut sums = [0.0; 2];
    for piece in bends.windows(2) {
        let (a, b) = (piece[0], piece[1]);
        let illuminated = |s: &&Spectrum| s.first_nm() <= a && s.last_nm() >= b;
        if a == b || !factors.iter().all(illuminated) {
            continue;
        }
        // At most two lines times the hat's: Simpson's rule is exact for a cubic.
        let product = |nm: f64| {
            let at = |k: usize| factors[k].at_nm_from(first[k] + points[k].partition_point(|w| *w < nm), nm);
            (0..factors.len()).map(at).product::<f64>()
        };
        let middle = 0.5 * (a + b);
        for (nm, weight) in [(a, 1.0), (middle, 4.0), (b, 1.0)] {
            let share = (b - a) / 6.0 * weight * product(nm);
            sums[0] += share * (to_nm - nm);
            sums[1] += share * (nm - from_nm);
        }
    }
    Some(sums)
}

impl Spectrum {
    fn first_nm(&self) -> f64 {
        self.wavelength_nm()[0]
    }

    fn last_nm(&self) -> f64 {
        self.wavelength_nm()[self.wavelength_nm().len() - 1]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ∫ f dλ by a hundred thousand midpoints a nanometre band of the given width.
    fn midpoints(from: f64, to: f64, f: impl Fn(f64) -> f64) -> f64 {
        let n = 200_000;
        let h = (to - from) / f64::from(n);
        (0..n).map(|i| f(from + (f64::from(i) + 0.5) * h)).sum::<f64>() * h
    }

    fn line(centre: f64, fwhm: f64, step: f64, offset: f64) -> Spectrum {
        let sigma = fwhm / 2.354_820_045;
        let n = (40.0 / step) as i32;
        let nm: Vec<f64> = (0..=n)
            .map(|i| (centre - 20.0).floor() + offset + step * f64::from(i))
            .collect();
        let value = nm
            .iter()
            .map(|w| (-0.5 * ((w - centre) / sigma).powi(2)).exp())
            .collect();
        Spectrum::new(nm, value).unwrap()
    }

    #[test]
    fn whole_nanometres_are_their_own_values_to_the_bit() {
        for step in [1, 2, 5, 10, 13] {
            let nm: Vec<f64> = (340..=850).step_by(step).map(f64::from).collect();
            let value = nm.iter().map(|w| (w * 0.37).sin() / 3.0 + 0.1).collect();
            let s = Spectrum::new(nm, value).unwrap();
            let sampled: [f64; TABLE] = std::array::from_fn(|i| s.at_nm((cie::FIRST_NM + i) as f64));
            assert_eq!(per_nm(&[&s]), sampled);
        }
        // Also where the data end with light, and for one point alone.
        let cut = Spectrum::new(vec![400.0, 500.0], vec![1.0, 1.0]).unwrap();
        assert_eq!(cut.integral(), 101.0);
        assert_eq!(Spectrum::new(vec![555.0], vec![2.0]).unwrap().integral(), 2.0);
    }

    #[test]
    fn a_line_between_the_tables_entries_is_integrated() {
        // A laser of 0.2 nm at 532.35 nm: sampling at whole nanometres sees a ten-millionth of it.
        let s = line(532.35, 0.2, 0.05, 0.0);
        let exact = 0.2 / 2.354_820_045 * (2.0 * std::f64::consts::PI).sqrt();
        assert!((s.integral() / exact - 1.0).abs() < 1e-6, "{}", s.integral());
        let v = Spectrum::from_1_nm(&cie::V_LAMBDA).unwrap();
        let seen = 683.0 * midpoints(531.0, 534.0, |nm| s.at_nm(nm) * v.at_nm(nm));
        assert!((s.luminous_integral() / seen - 1.0).abs() < 1e-8);
    }

    #[test]
    fn the_grid_of_a_spectrometer_does_not_move_the_result() {
        // One line of 1 nm seen by grids of any pitch and offset: only the trapezoids' own error is left.
        for step in [0.05, 0.1, 0.25, 0.37] {
            for offset in [0.0, 0.01, 0.13, 0.5, 0.77] {
                let s = line(545.3, 1.0, step, offset);
                let nm = s.wavelength_nm();
                let trapezoid: f64 = (1..nm.len())
                    .map(|i| 0.5 * (nm[i] - nm[i - 1]) * (s.value()[i] + s.value()[i - 1]))
                    .sum();
                assert!((s.integral() / trapezoid - 1.0).abs() < 1e-12, "{step} {offset}");
            }
        }
    }

    #[test]
    fn fine_data_that_end_with_light_count_to_their_ends() {
        for (first, last) in [(400.0, 500.0), (400.3, 500.7)] {
            let nm: Vec<f64> = (0..=200)
                .map(|i| first + (last - first) * f64::from(i) / 200.0)
                .collect();
            let s = Spectrum::new(nm, vec![2.0; 201]).unwrap();
            assert!((s.integral() - 2.0 * (last - first)).abs() < 1e-9, "{}", s.integral());
        }
    }

    #[test]
    fn a_product_of_two_fine_spectra_is_exact() {
        let (a, b) = (line(545.3, 0.6, 0.1, 0.03), line(545.9, 0.8, 0.17, 0.4));
        let exact = midpoints(540.0, 552.0, |nm| a.at_nm(nm) * b.at_nm(nm));
        let ours: f64 = per_nm(&[&a, &b]).iter().sum();
        assert!((ours / exact - 1.0).abs() < 1e-8, "{ours} {exact}");
    }
}
