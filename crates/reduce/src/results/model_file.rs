//! The model file of a run.

use isolux_photometry::Symmetry;
use isolux_record::Run;

use super::colours::spectrum_name;
use super::file::{diameter_mm, file_name, hashes};
use super::photometric::instrument;
use crate::budget::noise_of_directions;
use crate::finding;
use crate::grid::Grid;
use crate::headline::{NEAR_FIELD_AT_SENSOR, zone_alone, zone_deg};
use crate::{Drift, Reduction};

/// The model of the run: its distribution and spectrum with the luminous area as emitter, and the offset, ambient and
/// stray light that were taken out of the readings as effects of the bench, so that its predictions are readings again.
pub fn model_toml(reduction: &Reduction, run: &Run, run_files: &[(String, Vec<u8>)]) -> String {
    let mut text = format!(
        "format = \"isolux-model/1\"\n\n[luminaire]\ndistribution = \"{}\"\ninterpolation = \"smooth\"\n",
        file_name(reduction, "luminaire.ldt")
    );
    if reduction.spectral.is_some() {
        text.push_str(&format!("spectrum = \"{}\"\n", file_name(reduction, "luminaire.spdx")));
    }
    // A luminous area of which nothing more is known; where not even its size is, a point in all but name.
    let emitter_mm = diameter_mm(run).unwrap_or(1.0);
    text.push_str(&format!(
        "emitter = {{ shape = \"disc\", diameter_mm = {emitter_mm:?} }}\n\n"
    ));
    text.push_str(&uncertainty_toml(reduction, diameter_mm(run)));
    let (direction_rel, direction_cd) = noise_of_directions(&reduction.grid);
    text.push_str(&format!(
        "direction_rel = {direction_rel:.8}\ndirection_cd = {direction_cd:.6}\n"
    ));
    if let Some((_, facts)) = &reduction.grid.smoothed {
        let [along, around] = facts.own_share;
        text.push_str(&format!("direction_share = [{along:.4}, {around:.4}]\n"));
        text.push_str(&format!("mean_share = {:.4}\n", facts.mean_share));
    }
    if let Some(ages) = half_plane_lamp_s(&reduction.grid) {
        let ages: Vec<String> = ages.iter().map(|age| format!("{age:.0}.0")).collect();
        text.push_str(&format!("half_plane_lamp_s = [{}]\n", ages.join(", ")));
    }
    let common = &reduction.common;
    if common.gamma_deg > 0.0 {
        text.push_str(&format!("gamma_deg = {:?}\n", common.gamma_deg));
    }
    let common_cd = common.added_cd();
    if common_cd > 0.0 {
        text.push_str(&format!("common_cd = {common_cd:.6}\n"));
    }
    text.push_str(&spectrum_uncertainty_toml(reduction, run));
    text.push_str("\n[luminaire.provenance]\n");
    for (file, hash) in hashes(run_files) {
        if file == "readings.csv" {
            text.push_str(&format!("readings_sha256 = \"{hash}\"\n"));
        }
    }
    if let Some(luxmeter) = run.header.luxmeter_name() {
        text.push_str(&format!("luxmeter = {}\n", toml::Value::from(luxmeter)));
    }
    // First and last of each run of numbers.
    let runs = reduction.made_of.chunk_by(|a, b| a + 1 == *b);
    let runs: Vec<String> = runs
        .map(|run| format!("[{}, {}]", run[0], run[run.len() - 1]))
        .collect();
    text.push_str(&format!("distribution_rows = [{}]\n", runs.join(", ")));
    if !reduction.removed_effects.is_empty() {
        text.push_str(&format!("removed = {:?}\n", reduction.removed_effects));
    }
    if let Some(accepted) = &reduction.accepted {
        text.push_str(&format!("accepted = {}\n", toml::Value::from(finding::note(accepted))));
    }
    text.push_str(&colour_toml(reduction));
    text.push_str("\n[noise]\nu_scale = \"stated\"\n");
    for effect in bench_effects(reduction) {
        text.push_str(&format!("\n[[effect]]\n{effect}"));
    }
    text
}

/// `[[luminaire.colour]]` of every direction with a spectrum, where there is one on the axis too: it links lx and
/// W/m².
fn colour_toml(reduction: &Reduction) -> String {
    let found = reduction.over_angle.as_ref().filter(|_| reduction.spectral.is_some());
    let directions = found.map_or(&[][..], |found| found.facts.directions.as_slice());
    directions.iter().fold(String::new(), |text, of| {
        let name = spectrum_name(of);
        let (c_deg, gamma_deg) = (of.c_deg, of.gamma_deg);
        text + &format!("\n[[luminaire.colour]]\nc_deg = {c_deg:?}\ngamma_deg = {gamma_deg:?}\nspectrum = \"{name}\"\n")
    })
}

/// `[luminaire.u]`: relative standard uncertainties of the intensities near the axis, of the flux, and of the efficacy,
/// each where nothing is missing in it; what is missing; the size of the luminous area.
fn uncertainty_toml(reduction: &Reduction, diameter_mm: Option<f64>) -> String {
    let mut text = String::from("[luminaire.u]\n");
    // The near field at some sensor's distance is the simulation's, which knows the distance.
    let near_axis = reduction.sensor_illuminance.without_part(NEAR_FIELD_AT_SENSOR);
    let ler = reduction.spectral.as_ref().map(|spectral| &spectral.ler);
    let mut missing: Vec<&String> = Vec::new();
    // Of a zone the flux is not known; the light in it is.
    let zone_deg = zone_deg(&reduction.grid.distribution);
    let zone = zone_deg.map(zone_alone);
    for (key, quantity) in [
        ("intensity_rel", Some(&near_axis)),
        ("flux_rel", Some(&reduction.flux)),
        ("ler_rel", ler),
    ] {
        let Some(quantity) = quantity else { continue };
        // Where the axis was not measured there is no light to be uncertain of.
        if let Some(rel) = quantity.u_rel().filter(|rel| rel.is_finite()) {
            text.push_str(&format!("{key} = {rel:.6}\n"));
        }
        for phrase in &quantity.missing {
            if !missing.contains(&phrase) && zone.as_ref() != Some(phrase) {
                missing.push(phrase);
            }
        }
    }
    if !missing.is_empty() {
        let list: Vec<toml::Value> = missing.into_iter().map(|phrase| phrase.as_str().into()).collect();
        text.push_str(&format!("missing = {}\n", toml::Value::Array(list)));
    }
    if let Some([first, last]) = zone_deg {
        text.push_str(&format!("measured_gamma_deg = [{first:?}, {last:?}]\n"));
    }
    if let Some(diameter_mm) = diameter_mm {
        text.push_str(&format!("luminous_diameter_mm = {diameter_mm:?}\n"));
    }
    text.push_str(&format!("measured_at_mm = {:?}\n", reduction.distance_mm));
    text
}

/// `[luminaire.u.spectrum]`: the noise of the spectrum every so many nanometres, and what all its values share.
fn spectrum_uncertainty_toml(reduction: &Reduction, run: &Run) -> String {
    let Some(spectral) = &reduction.spectral else {
        return String::new();
    };
    let (mut at_nm, mut noise) = (Vec::new(), Vec::new());
    let values: Vec<(f64, f64)> = spectral
        .spectrum
        .wavelength_nm()
        .iter()
        .copied()
        .zip(spectral.u_expected_w_m2_nm.iter().copied())
        .collect();
    for part in values.chunks(NOISE_STEP) {
        let count = part.len() as f64;
        at_nm.push(format!("{:?}", part.iter().map(|(nm, _)| nm).sum::<f64>() / count));
        let square = part.iter().map(|(_, u)| u * u).sum::<f64>() / count;
        noise.push(format!("{:.3e}", square.sqrt()));
    }
    let mut text = format!(
        "\n[luminaire.u.spectrum]\nwavelength_nm = [{}]\nnoise = [{}]\n",
        at_nm.join(", "),
        noise.join(", ")
    );
    let shared = spectral.shared;
    for (key, value) in [("shape_rel", shared.shape_rel), ("scale_nm", shared.wavelength_nm)] {
        if let Some(value) = value {
            text.push_str(&format!("{key} = {value:.6}\n"));
        }
    }
    if let Some(instrument) = instrument(run) {
        text.push_str(&format!("instrument = {}\n", toml::Value::from(instrument)));
    }
    text
}

/// Wavelengths of the spectrum for one of its noise.
const NOISE_STEP: usize = 10;

/// Age of the lamp when each half-plane was read; none where they were not read one after the other, or the age is not
/// known.
fn half_plane_lamp_s(grid: &Grid) -> Option<Vec<f64>> {
    if grid.assumed != Symmetry::None {
        return None;
    }
    let span = |ages: &[f64]| {
        let (low, high) = ages
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), age| {
                (low.min(*age), high.max(*age))
            });
        high - low
    };
    let (mut ages, mut spans) = (Vec::new(), Vec::new());
    for plane in grid.sample_of.chunks(grid.distribution.gamma_deg().len()) {
        let of: Option<Vec<f64>> = plane.iter().map(|&sample| grid.nodes[sample].lamp_s).collect();
        let of = of?;
        spans.push(span(&of));
        ages.push(of.iter().sum::<f64>() / of.len() as f64);
    }
    let within = spans.iter().sum::<f64>() / spans.len() as f64;
    (ages.len() > 1 && within < 0.5 * span(&ages)).then_some(ages)
}

/// Offset and ambient light as the run measured them, and the drift of the lamp. A level within its uncertainty of
/// nothing is still what was subtracted.
fn bench_effects(reduction: &Reduction) -> Vec<String> {
    let [offset, ambient, _] = reduction.background.parts_lx(0.0);
    let mut effects = Vec::new();
    if let Some(offset) = offset.filter(|_| reduction.subtract.dark) {
        effects.push(format!("name = \"dark_offset\"\noffset_lx = {offset:.6}\n"));
    }
    if let Some(ambient) = ambient.filter(|_| reduction.subtract.ambient) {
        effects.push(format!("name = \"ambient_stray\"\nilluminance_lx = {ambient:.6}\n"));
    }
    effects.extend(reduction.bench_effects.iter().cloned());
    effects.extend(lamp_drift(&reduction.drift));
    effects
}

/// The drift that was taken out of the readings, which the lamp still has; where the visits show none, how much there
/// may be. The intensities are those of its reference time.
fn lamp_drift(drift: &Drift) -> Option<String> {
    let (rate_per_h, u_rate_per_h, centre_s) = match drift {
        Drift::Linear {
            rate_per_h,
            u_rate_per_h,
            centre_s,
            ..
        } => (*rate_per_h, u_rate_per_h, centre_s),
        Drift::None {
            u_rate_per_h, centre_s, ..
        } if *u_rate_per_h > 0.0 => (0.0, u_rate_per_h, centre_s),
        _ => return None,
    };
    Some(format!(
        "name = \"lamp_drift\"\nrate_per_h = {rate_per_h:.8}\nreference_s = {centre_s:.3}\n\n[effect.u]\n\
         rate_per_h = {u_rate_per_h:.8}\n\n[effect.provenance]\nby = \"reduce\"\nfrom = \"visits to the reference point\"\n"
    ))
}
