//! The report's view of one simulation: the map with sections, the numbers, and the scene in three dimensions.

use isolux_model::Scene;
use isolux_report::html::{Page, Tile};
use isolux_report::viewer::{self, Ray, View};
use isolux_sim::simulation::Simulation;
use isolux_sim::source::Shape;

use crate::{Failure, rays, simulate};

/// Rays that the view shows.
const RAYS: usize = 300;

/// Adds the three-dimensional view of `simulation` to `page`; `id` is unique in it.
///
/// # Errors
/// When the scene cannot be written.
pub fn add(page: &mut Page, scene: &Scene, simulation: &Simulation, id: &str) -> Result<(), Failure> {
    let setup = &simulation.setup;
    let sensor = &setup.sensor;
    let (nx, ny) = (sensor.nx as f64, sensor.ny as f64);
    let distribution = scene.model.distribution().map_err(Failure::bad_input)?;
    // A source without rays is drawn without rays.
    let rows = rays::rows(scene, simulation, RAYS, 1).unwrap_or_default();
    let view = View {
        distribution: &distribution,
        emitter_mm: setup.source.parts().iter().map(|part| outline(&part.shape)).collect(),
        corners_mm: [[0.0, 0.0], [nx, 0.0], [nx, ny], [0.0, ny]].map(|[x, y]| sensor.point(x, y).to_array()),
        map: simulate::picture(simulation),
        rays: rows
            .iter()
            .map(|row| Ray {
                origin_mm: row.origin_mm,
                end_mm: row.end_mm,
                pixel: row.pixel,
                wavelength_nm: row.wavelength_nm,
            })
            .collect(),
    };
    page.library(&viewer::library());
    page.raw(&view.html(id));
    page.script(&view.script(id).map_err(Failure::instrument)?);
    Ok(())
}

/// A page of its own for one simulation.
///
/// # Errors
/// As [`add`].
pub fn page(scene: &Scene, simulation: &Simulation) -> Result<String, Failure> {
    let facts = &simulation.facts;
    let unit = simulate::unit(facts);
    let mut page = Page::new("Light on the sensor");
    let tile = |name: &str, value: String, note: String| Tile {
        name: name.to_owned(),
        value,
        note,
    };
    page.tiles(&[
        tile("mean", simulate::mean(facts), String::new()),
        tile("method", facts.method.to_owned(), simulate::numeric(facts, unit)),
        tile(
            "minimum over mean",
            format!("{:.4}", facts.uniformity_min_over_mean),
            String::new(),
        ),
        tile(
            "flux",
            format!("{:.2} lm", facts.flux_lm),
            facts.ler_lm_per_w.map_or(String::new(), |ler| format!("{ler:.1} lm/W")),
        ),
    ]);
    page.figure(
        &simulate::picture(simulation).figure("sensor"),
        "Map with scale bar, and sections through the middle",
    );
    page.heading("Scene");
    add(&mut page, scene, simulation, "scene")?;
    Ok(page.finish())
}

/// The outline of an emitter's part, mm.
fn outline(shape: &Shape) -> Vec<[f64; 3]> {
    let circle = |centre: [f64; 3], radius: f64| -> Vec<[f64; 3]> {
        (0..24)
            .map(|k| {
                let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / 24.0).sin_cos();
                [centre[0] + radius * cos, centre[1] + radius * sin, centre[2]]
            })
            .collect()
    };
    match *shape {
        // A point is drawn a millimetre wide.
        Shape::Point(centre) => circle(centre.to_array(), 0.5),
        Shape::Disc { centre, radius } => circle(centre.to_array(), radius),
        Shape::Ring { centre, outer, .. } => circle(centre.to_array(), outer),
        Shape::Rectangle { centre, half: [x, y] } => [[-x, -y], [x, -y], [x, y], [-x, y]]
            .map(|[dx, dy]| [centre.x + dx, centre.y + dy, centre.z])
            .to_vec(),
    }
}
