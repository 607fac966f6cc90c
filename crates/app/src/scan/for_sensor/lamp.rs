//! What the lamp is taken to be before it is read for a sensor.

use camino::Utf8Path;
use isolux_model::{Emitter, Model, Scene, Spectral};
use isolux_photometry::IntensityDistribution;
use isolux_record::Station;
use isolux_scan::lobe_exponent;

use crate::Failure;
use crate::simulation::{scene, sensor_so_far};

/// Pixels along each edge on which grids are compared.
const PIXELS: usize = 16;

/// The scene with few pixels, lit by its own model or, where that is not there yet, by the station's lamp; and which.
pub fn lit_scene(station: &Station, file: &Utf8Path) -> Result<(Scene, String), Failure> {
    let (at, table) = scene::table(file, &scene::Changes::default())?;
    let named = table.get("model").and_then(|name| name.as_str());
    let model = named.map(|name| at.parent().unwrap_or(Utf8Path::new("")).join(name));
    let (mut scene, lamp) = match model {
        Some(model) if !model.exists() => {
            let lamp = station.lamp();
            let known = lamp.and_then(|lamp| Some((lamp.flux_lm?, lamp.peak_cd?)));
            let (flux_lm, peak_cd) = known.ok_or_else(|| {
                Failure::bad_input(format!(
                    "{model} is not there, and the station does not say what lamp it is"
                ))
                .help("give flux_lm and peak_cd in [lamp] of the station, or a scene whose model is there")
            })?;
            let diameter_mm = lamp.and_then(|lamp| lamp.diameter_mm);
            let model = lobe(flux_lm, peak_cd, diameter_mm)?;
            let words = format!(
                "a lobe of {flux_lm} lm and {peak_cd} cd, as the station has it: {named:?} is not there yet",
                named = named.unwrap_or_default()
            );
            (scene::lit_by(file, &model)?, words)
        }
        _ => {
            let scene = scene::load(file, &scene::Changes::default())?;
            (scene, "the scene's own luminaire".to_owned())
        }
    };
    scene.sensor.pixels = [PIXELS, PIXELS];
    // What its effects change is alike on every grid.
    let luminaire = scene.model.luminaire();
    let light = luminaire.distribution().clone();
    scene.model = sensor_so_far::model(light, scene.model.emitter(), Spectral::None);
    Ok((scene, lamp))
}

/// I·cosⁿγ with this flux and peak.
fn lobe(flux_lm: f64, peak_cd: f64, diameter_mm: Option<f64>) -> Result<Model, Failure> {
    let exponent = lobe_exponent(flux_lm, peak_cd);
    let gamma_deg: Vec<f64> = (0..=360).map(|k| 0.5 * f64::from(k)).collect();
    let at = |gamma: &f64| peak_cd * gamma.to_radians().cos().max(0.0).powf(exponent);
    let intensity_cd = gamma_deg.iter().map(at).collect();
    let light = IntensityDistribution::new(vec![0.0], gamma_deg, intensity_cd).map_err(Failure::bad_input)?;
    let emitter = diameter_mm.map_or(Emitter::Point {}, |diameter_mm| Emitter::Disc { diameter_mm });
    Ok(sensor_so_far::model(light, emitter, Spectral::None))
}
