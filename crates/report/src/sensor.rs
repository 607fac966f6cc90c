//! The report's view of one simulation: the map with sections, the numbers, and the scene in three dimensions.

use isolux_model::Scene;
use isolux_sim::rays;
use isolux_sim::simulation::{Facts, Simulation};
use isolux_sim::source::Shape;
use isolux_units::digits::{significant, stated};

use crate::html::{Page, Tile};
use crate::map::Map;
use crate::viewer::{Ray, View};

/// Why the view of a simulation cannot be drawn.
#[derive(Debug, thiserror::Error)]
pub enum ViewError {
    /// The effects leave no distribution to draw.
    #[error(transparent)]
    Model(#[from] isolux_photometry::DistributionError),
    /// The scene does not go into a script.
    #[error(transparent)]
    Script(#[from] serde_json::Error),
    /// The readings give no rating.
    #[error(transparent)]
    Rating(#[from] isolux_reduce::ReduceError),
}

/// Rays that the view shows.
const RAYS: usize = 300;

/// Adds the three-dimensional view of `simulation` to `page`; `id` is unique in it.
///
/// # Errors
/// When the scene cannot be written.
pub fn add(page: &mut Page, scene: &Scene, simulation: &Simulation, id: &str) -> Result<(), ViewError> {
    let setup = &simulation.setup;
    let sensor = &setup.sensor;
    let (nx, ny) = (sensor.nx as f64, sensor.ny as f64);
    let distribution = scene.model.distribution()?;
    // A source without rays is drawn without rays.
    let rows = rays::rows(scene, simulation, RAYS, 1).unwrap_or_default();
    let view = View {
        distribution: &distribution,
        emitter_mm: setup.source.parts().iter().map(|part| outline(&part.shape)).collect(),
        corners_mm: [[0.0, 0.0], [nx, 0.0], [nx, ny], [0.0, ny]].map(|[x, y]| sensor.point(x, y).to_array()),
        map: picture(simulation),
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
    Ok(view.add(page, id)?)
}

/// A page of its own for one simulation.
///
/// # Errors
/// As [`add`].
pub fn page(scene: &Scene, simulation: &Simulation) -> Result<String, ViewError> {
    let facts = &simulation.facts;
    let unit = facts.unit.symbol();
    let mut page = Page::new("Light on the sensor");
    let tile = |name: &str, value: String, note: String| Tile {
        name: name.to_owned(),
        value,
        note,
    };
    page.tiles(&[
        tile("mean", mean(facts), String::new()),
        tile("method", facts.method.to_string(), numeric(facts, unit)),
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
    let [map, sections] = picture(simulation).figures("sensor");
    page.pair(
        (&map, "Map with its scale."),
        (&sections, "Sections through the middle."),
    );
    page.heading("Scene");
    add(&mut page, scene, simulation, "scene")?;
    Ok(page.finish())
}

/// The mean over the sensor with its expanded uncertainty, or with what is missing in it.
pub fn mean(facts: &Facts) -> String {
    let unit = facts.unit.symbol();
    if let Some(u) = facts.u_mean {
        return stated(facts.mean, u, unit);
    }
    let missing = facts.u_mean_missing.join("; ");
    format!("{} {unit}, no uncertainty: {missing}", significant(facts.mean, 5))
}

/// What the computation itself adds to the mean, under its own name: never the uncertainty of the value.
pub fn numeric(facts: &Facts, unit: &str) -> String {
    match facts.rays {
        Some(rays) => format!(
            "{rays} rays: standard error of the mean by ray counting {:.2e} {unit}",
            facts.u_mean_numeric
        ),
        None => format!(
            "bound on the error of the mean by quadrature {:.2e} {unit}",
            facts.u_mean_numeric
        ),
    }
}

/// The picture with what is below the uncertainty of single directions marked.
pub fn marked(simulation: &Simulation, u_rel: Option<f64>) -> Map<'_> {
    Map {
        u: u_rel.map(|u_rel| u_rel * simulation.facts.mean),
        ..picture(simulation)
    }
}

/// The map of a simulation as the report draws it.
pub fn picture(simulation: &Simulation) -> Map<'_> {
    let facts = &simulation.facts;
    let [nx, ny] = facts.pixels;
    Map {
        values: &simulation.map,
        nx,
        ny,
        size_mm: facts.size_mm,
        quantity: facts.unit.quantity(),
        unit: facts.unit.symbol(),
        u: None,
    }
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
