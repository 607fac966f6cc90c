//! Lights a camera sensor with a measured luminaire: quadrature, and rays with their counting noise.
//!
//!     cargo run -p isolux-examples --example sensor -- examples/hidden-effect/model.toml

#![expect(clippy::print_stdout, reason = "an example prints its result")]

use std::error::Error;

use isolux_model::{Model, Scene};
use isolux_sim::direct::Sampling;
use isolux_sim::simulation::{Method, Simulation, simulate};

/// A sensor of 24 mm with 24 × 24 pixels, 500 mm before the luminaire.
const SCENE: &str = r#"
format = "isolux-scene/1"
model = "model.toml"
[sensor]
size_mm = [24.0, 24.0]
pixels = [24, 24]
distance_mm = 500.0
"#;

/// Rays over the whole sphere, of which those towards the sensor are followed.
const RAYS: Method = Method::Direct {
    sampling: Sampling::Thinned,
    rays: 100_000_000,
    seed: 1,
};

fn illuminated(model: &Model, method: Method) -> Result<Simulation, Box<dyn Error>> {
    let scene = Scene::parse_with("scene.toml".into(), SCENE, model)?;
    // Nobody asks here how long it took.
    Ok(simulate(&scene, method, &|| 0.0)?)
}

/// Mean over the sensor, in lx for a model without a spectrum.
fn mean(simulation: &Simulation) -> f64 {
    simulation.map.iter().map(|value| f64::from(*value)).sum::<f64>() / simulation.map.len() as f64
}

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("which model?")?;
    let model = Model::load(path.as_str().into())?;
    println!("quadrature {:.2} lx", mean(&illuminated(&model, Method::Inverse)?));
    println!("rays       {:.2} lx", mean(&illuminated(&model, RAYS)?));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_and_quadrature_agree_and_follow_the_law_of_distance() {
        let model = Model::load(concat!(env!("CARGO_MANIFEST_DIR"), "/hidden-effect/model.toml").into()).unwrap();
        let map = illuminated(&model, Method::Inverse).unwrap();
        // The middle pixel of 1 mm begins on the axis.
        let axis_lx = model.luminaire().grid().intensity_cd_at(0.0, 0.0) / 0.5_f64.powi(2);
        let middle_lx = f64::from(map.map[12 * 24 + 12]);
        assert!(
            (middle_lx / axis_lx - 1.0).abs() < 1e-4,
            "{middle_lx} lx, {axis_lx} lx on the axis"
        );

        let counted = illuminated(&model, RAYS).unwrap();
        let rays = counted.counts.as_ref().unwrap().on_sensor();
        let sigma_rel = (rays as f64).sqrt().recip();
        let apart = mean(&counted) / mean(&map) - 1.0;
        assert!(
            apart != 0.0 && apart.abs() < 4.0 * sigma_rel,
            "{apart}, {sigma_rel} by {rays} rays"
        );
    }
}
