//! Heads that have one f1′, and what they make of a light. The index says how far a responsivity is from V(λ), not
//! where, so a light may be read wrong by more than any of these heads does: f1′ is no bound of F* (ISO/CIE 19476).

use std::sync::LazyLock;

use isolux_spectrum::{Spectrum, cie, illuminant};

/// Entries of a table of the CIE, 360 nm to 830 nm.
const COUNT: usize = cie::V_LAMBDA.len();
/// Wavelengths and widths of leaks and gaps in the blue and in the red, nm.
const LEAKS_NM: [(f64, f64); 6] = [
    (430.0, 20.0),
    (460.0, 20.0),
    (480.0, 20.0),
    (640.0, 20.0),
    (670.0, 25.0),
    (700.0, 25.0),
];
/// Periods of filters that do not match in waves, nm.
const WAVES_NM: [f64; 3] = [100.0, 150.0, 200.0];
/// A departure that cannot have the index, however large it is, is left out: so near it has to come.
const NEAR_REL: f64 = 0.02;

static ILLUMINANT_A: LazyLock<[f64; COUNT]> = LazyLock::new(illuminant::illuminant_a);

/// What heads of one index make of lights.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// Smallest and largest of F* − 1: negative where readings are too high.
    pub off: [f64; 2],
    /// Root of the mean square of F* − 1.
    pub rms: f64,
}

/// What heads with this f1′, calibrated under illuminant A, make of `lights`: shifted, widened, with leaks or gaps in
/// the blue and in the red, with waves, each both ways.
pub fn spread(lights: &[Spectrum], f1_prime_rel: f64) -> Spread {
    let per_nm: Vec<[f64; COUNT]> = lights.iter().map(Spectrum::per_nm).collect();
    let (mut off, mut squares, mut count) = ([0.0_f64; 2], 0.0, 0.0);
    for head in departures().iter().flat_map(|departure| heads(departure, f1_prime_rel)) {
        for light in &per_nm {
            let wrong = f_star(light, &head) - 1.0;
            if wrong.is_finite() {
                off = [off[0].min(wrong), off[1].max(wrong)];
                squares += wrong * wrong;
                count += 1.0;
            }
        }
    }
    let mean_square = if count > 0.0 { squares / count } else { 0.0 };
    Spread {
        off,
        rms: mean_square.sqrt(),
    }
}

/// White light as LEDs give it, warm and cool: a chip under a phosphor of about 2600 K and 5700 K.
pub fn typical_lights() -> Vec<Spectrum> {
    let bell = |nm: f64, peak: f64, below: f64, above: f64| {
        let width = if nm < peak { below } else { above };
        (-0.5 * ((nm - peak) / width).powi(2)).exp()
    };
    let warm = |nm: f64| 0.45 * bell(nm, 452.0, 10.0, 12.0) + bell(nm, 600.0, 50.0, 60.0);
    let cool = |nm: f64| 1.4 * bell(nm, 452.0, 10.0, 12.0) + 0.9 * bell(nm, 560.0, 45.0, 60.0);
    let lights: [&dyn Fn(f64) -> f64; 2] = [&warm, &cool];
    let of = |light: &&dyn Fn(f64) -> f64| Spectrum::from_1_nm(&std::array::from_fn(|place| light(nm_at(place))));
    lights.iter().filter_map(of).collect()
}

fn nm_at(place: usize) -> f64 {
    (cie::FIRST_NM + place) as f64
}

/// How heads depart from V(λ), each in a unit of its own.
fn departures() -> Vec<[f64; COUNT]> {
    let v = |place: usize| cie::V_LAMBDA.get(place).copied().unwrap_or(0.0);
    let slope = |place: usize| 0.5 * (v(place + 1) - if place > 0 { v(place - 1) } else { 0.0 });
    let mut all: Vec<[f64; COUNT]> = vec![
        std::array::from_fn(slope),
        std::array::from_fn(|place| (nm_at(place) - 555.0) * slope(place)),
    ];
    for (peak, width) in LEAKS_NM {
        all.push(std::array::from_fn(|place| {
            (-0.5 * ((nm_at(place) - peak) / width).powi(2)).exp()
        }));
    }
    for period in WAVES_NM {
        let turn = move |place: usize| std::f64::consts::TAU * (nm_at(place) - 555.0) / period;
        all.push(std::array::from_fn(|place| v(place) * turn(place).cos()));
        all.push(std::array::from_fn(|place| v(place) * turn(place).sin()));
    }
    all
}

/// The heads V(λ) + a·departure with this index, one for each sign of a.
fn heads(departure: &[f64; COUNT], f1_prime_rel: f64) -> Vec<[f64; COUNT]> {
    let with = |amplitude: f64| -> [f64; COUNT] {
        std::array::from_fn(|place| (cie::V_LAMBDA[place] + amplitude * departure[place]).max(0.0))
    };
    let of_sign = |sign: f64| {
        let mut amplitude = 1e-3 * sign;
        for _ in 0..40 {
            let found = f1_prime(&with(amplitude));
            if (found - f1_prime_rel).abs() <= 1e-9 {
                break;
            }
            // Nearly in proportion, but for what would fall below zero.
            amplitude *= (f1_prime_rel / found).min(10.0);
        }
        let head = with(amplitude);
        ((f1_prime(&head) - f1_prime_rel).abs() <= NEAR_REL * f1_prime_rel).then_some(head)
    };
    [1.0, -1.0].into_iter().filter_map(of_sign).collect()
}

fn f1_prime(head: &[f64; COUNT]) -> f64 {
    let a = &*ILLUMINANT_A;
    let scale = product(a, &cie::V_LAMBDA) / product(a, head);
    let off = head.iter().zip(&cie::V_LAMBDA).map(|(s, v)| (scale * s - v).abs());
    off.sum::<f64>() / cie::V_LAMBDA.iter().sum::<f64>()
}

fn f_star(light: &[f64; COUNT], head: &[f64; COUNT]) -> f64 {
    let a = &*ILLUMINANT_A;
    product(light, &cie::V_LAMBDA) / product(light, head) * product(a, head) / product(a, &cie::V_LAMBDA)
}

fn product(one: &[f64; COUNT], other: &[f64; COUNT]) -> f64 {
    one.iter().zip(other).map(|(one, other)| one * other).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Expected values by numpy and the tables of colour-science 0.4.7, for the same heads.
    #[test]
    fn heads_of_one_index_read_a_cool_white_wrong_by_parts_in_a_hundred() {
        let lights = typical_lights();
        for (place, index, low, high, rms) in [
            (0, 0.03, -0.010_670, 0.016_264, 0.006_297),
            (0, 0.06, -0.017_023, 0.033_065, 0.012_377),
            (1, 0.03, -0.017_025, 0.019_806, 0.011_243),
            (1, 0.06, -0.031_800, 0.040_413, 0.020_960),
        ] {
            let found = spread(&lights[place..=place], index);
            for (found, expected) in [(found.off[0], low), (found.off[1], high), (found.rms, rms)] {
                assert!((found - expected).abs() < 2e-5, "{place} {index}: {found} {expected}");
            }
        }
        let perfect = spread(&lights, 0.0);
        assert!(perfect.rms < 1e-9, "{perfect:?}");
    }
}
