//! What a bin of a map shows is the mean over the bin, not the light in its middle.

use camino::Utf8PathBuf;
use isolux_model::{Emitter, Interpolation, Luminaire, Model, Spectral};
use isolux_photometry::IntensityDistribution;
use isolux_record::observation::{MapSet, Need, Observations, open};

const DISTANCE_MM: f64 = 100.0;
const SIDE_MM: f64 = 40.0;
const BINS: usize = 8;

/// A point source of 1000 cd · cos³γ on the axis: I · cos γ / r².
fn illuminance_lx(x_mm: f64, y_mm: f64) -> f64 {
    let square = x_mm * x_mm + y_mm * y_mm + DISTANCE_MM * DISTANCE_MM;
    1000.0 * (DISTANCE_MM / square.sqrt()).powi(4) / square * 1e6
}

#[test]
fn a_bin_is_the_mean_over_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = Utf8PathBuf::try_from(folder.path().join("maps.toml")).unwrap();
    let text = format!(
        "sensor_mm = [{SIDE_MM:?}, {SIDE_MM:?}]\nbins = [{BINS}, {BINS}]\nunit = \"lx\"\n\
         [[map]]\nname = \"m\"\ndistance_mm = {DISTANCE_MM:?}\n"
    );
    std::fs::write(&path, text).unwrap();
    let Observations::Maps(maps) = open(&path, Need::Coordinates).unwrap() else {
        panic!("no maps");
    };
    // So fine that both interpolants are the cosine; mean and middle differ by 9e-4 at the rim.
    for how in [Interpolation::Linear, Interpolation::Smooth] {
        let gamma_deg: Vec<f64> = (0..=900).map(|i| 0.1 * f64::from(i)).collect();
        let intensity = |gamma: &f64| 1000.0 * gamma.to_radians().cos().max(0.0).powi(3);
        let intensity_cd = gamma_deg.iter().map(intensity).collect();
        let distribution = IntensityDistribution::new(vec![0.0], gamma_deg, intensity_cd).unwrap();
        let luminaire = Luminaire::interpolated(distribution, how, Emitter::Point {}, Spectral::None);
        check(&Model::of(luminaire).predict_maps(&maps), &maps, how);
    }
}

fn check(predicted: &[f64], maps: &MapSet, how: Interpolation) {
    let bin_mm = SIDE_MM / BINS as f64;
    for (index, predicted) in predicted.iter().enumerate() {
        let [x_mm, y_mm] = maps.place_mm(index);
        let parts = 40;
        let off = |k: i32| (f64::from(k) + 0.5) / f64::from(parts) * bin_mm - 0.5 * bin_mm;
        let sum: f64 = (0..parts * parts)
            .map(|k| illuminance_lx(x_mm + off(k % parts), y_mm + off(k / parts)))
            .sum();
        let mean = sum / f64::from(parts * parts);
        let middle = illuminance_lx(x_mm, y_mm);
        assert!(
            (predicted / mean - 1.0).abs() < 1e-5 && (middle / mean - 1.0).abs() > 3e-5,
            "{how:?} ({x_mm}, {y_mm}) mm: {predicted} for {mean}, {middle} in the middle"
        );
    }
}
