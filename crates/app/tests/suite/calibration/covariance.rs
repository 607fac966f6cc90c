//! The stated covariance against a Monte Carlo of the inputs: counts by their scatter, the certificate by its scale and
//! its temperature. Nothing of the propagation is in it.

use isolux_app::calibration::Instrument;
use isolux_record::{Run, Standard};
use isolux_reduce::standard::{Component, SpectralFactors, spectroradiometer};
use isolux_spectrum::Spectrum;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;

use crate::calibration::campaign::normal;
use crate::calibration::lab::{Lab, spectral};

/// Second radiation constant, nm·K.
const C2_NM_K: f64 = 1.438_776_877e7;
const AT_NM: [f64; 3] = [420.0, 555.0, 700.0];
const DRAWS: usize = 120;

/// Logarithms of the factors at [`AT_NM`] and of the illuminance of a fixed light measured with them.
fn logarithms(factors: &SpectralFactors, light: &SpectralFactors) -> [f64; 4] {
    let at = |nm: f64| {
        let place = factors.wavelength_nm.partition_point(|at| *at < nm);
        factors.factor_w_m2_nm[place].ln()
    };
    let (mut nm, mut value) = (Vec::new(), Vec::new());
    for (place, wavelength_nm) in light.wavelength_nm.iter().enumerate() {
        if let Ok(here) = factors.wavelength_nm.binary_search_by(|at| at.total_cmp(wavelength_nm)) {
            let counts = light.irradiance_w_m2_nm[place] / light.factor_w_m2_nm[place];
            nm.push(*wavelength_nm);
            value.push(counts * factors.factor_w_m2_nm[here]);
        }
    }
    let lux = Spectrum::new(nm, value).unwrap().luminous_integral().ln();
    let [a, b, c] = AT_NM.map(at);
    [a, b, c, lux]
}

#[test]
fn the_covariance_is_that_of_a_monte_carlo() {
    let lab = Lab::new(5, |_| {});
    let done = lab.calibrate(Instrument::Spectroradiometer).unwrap();
    let factors = spectral(&done);
    let run = Run::read(&lab.run(Instrument::Spectroradiometer)).unwrap();
    let text = std::fs::read_to_string(lab.standard()).unwrap();
    let table = std::fs::read_to_string(lab.standard().with_file_name("standard.csv")).unwrap();
    let (scale, temperature) = (0.004, 0.0005);
    let mut random = ChaCha8Rng::seed_from_u64(9);
    let mut draws: Vec<[f64; 4]> = Vec::new();
    for _ in 0..DRAWS {
        let [z_scale, z_temperature] = [normal(&mut random), normal(&mut random)];
        let mut rows = table.lines();
        let mut moved = format!("{}\n", rows.next().unwrap());
        for row in rows {
            let fields: Vec<&str> = row.split(',').collect();
            let [nm, value]: [f64; 2] = std::array::from_fn(|k| fields[k].parse().unwrap());
            let tilt = C2_NM_K / (nm * factors.temperature_k);
            let by = (scale * z_scale + temperature * tilt * z_temperature).exp();
            moved += &format!("{nm},{:.9e},{}\n", value * by, fields[2]);
        }
        let standard = Standard::parse("standard.toml".into(), &text, &|_| Ok(moved.clone())).unwrap();
        let mut run = run.clone();
        for pixel in run.spectra.iter_mut().flat_map(|spectrum| &mut spectrum.pixels) {
            pixel.counts += pixel.u_counts * normal(&mut random);
            pixel.dark_counts += pixel.u_dark_counts * normal(&mut random);
        }
        draws.push(logarithms(&spectroradiometer(&run, &standard).unwrap(), factors));
    }
    let mean: [f64; 4] = std::array::from_fn(|k| draws.iter().map(|draw| draw[k]).sum::<f64>() / DRAWS as f64);
    let found = |i: usize, j: usize| {
        let sum: f64 = draws.iter().map(|draw| (draw[i] - mean[i]) * (draw[j] - mean[j])).sum();
        sum / (DRAWS - 1) as f64
    };
    // What was drawn: two parts of the certificate, and the noise.
    let named = |name: &str| factors.components.iter().find(|part| part.name == name).unwrap();
    let certificate = Component {
        name: String::new(),
        correlated_rel: named("certificate").correlated_rel[..2].to_vec(),
        independent_rel: Vec::new(),
    };
    let parts = [&certificate, named("noise")];
    let places = AT_NM.map(|nm| factors.wavelength_nm.partition_point(|at| *at < nm));
    let stated = |i: usize, j: usize| {
        parts
            .iter()
            .map(|part| part.covariance_rel(places[i], places[j]))
            .sum::<f64>()
    };
    for i in 0..3 {
        for j in 0..=i {
            // A covariance of n draws has the standard deviation √((c² + c_ii c_jj) / n).
            let s = ((stated(i, j).powi(2) + stated(i, i) * stated(j, j)) / DRAWS as f64).sqrt();
            assert!(
                (found(i, j) - stated(i, j)).abs() < 4.0 * s,
                "{i} {j}: {} {}",
                found(i, j),
                stated(i, j)
            );
        }
    }
    // The illuminance by the same parts alone.
    let mut alone = factors.clone();
    alone.components = vec![certificate.clone(), named("noise").clone()];
    let u = alone.illuminance_u_rel();
    let spread = found(3, 3).sqrt();
    assert!(
        (spread / u - 1.0).abs() < 4.0 / (2.0 * DRAWS as f64).sqrt(),
        "{spread} {u}"
    );
}
