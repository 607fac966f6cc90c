//! The sensor lit by the luminaire of a day, and its axis beside what the spectroradiometer read.

use camino::Utf8Path;
use isolux_conformity::Conformity;
use isolux_diagnose::on_axis::on_axis;
use isolux_model::Model;
use isolux_record::{Run, event};
use isolux_reduce::Reduction;
use isolux_report::day::DayResults;
use isolux_sim::simulation::Method;

use super::requested::Wanted;
use crate::Failure;
use crate::front_end::progress::{Event, Progress};
use crate::modulation;
use crate::simulation::{scene, simulate};

/// Simulates the sensor with the model in the folder of results, compares the axis, and judges the record by its
/// limits.
pub(crate) fn light(
    results: &Utf8Path,
    run: Run,
    reduction: Reduction,
    sensor: Option<&Utf8Path>,
    wanted: &Wanted,
    progress: &dyn Progress,
) -> Result<DayResults, Failure> {
    progress.event(Event::Began {
        step: "simulate",
        total: None,
    });
    let model = results.join(isolux_reduce::file_name(&reduction, "luminaire.model.toml"));
    let model = Model::load(&model).map_err(Failure::bad_input)?;
    let scene = match sensor {
        // Whatever model the scene names.
        Some(file) => scene::lit_by(file, &model)?,
        None => scene::of_the_published_case(&model)?,
    };
    let mut simulation = simulate::solve(&scene, Method::Inverse)?;
    progress.event(Event::Ended(&format!(
        "{} × {} pixels in {:.2} s, mean {:.4} {}",
        simulation.facts.pixels[0],
        simulation.facts.pixels[1],
        simulation.facts.elapsed_s.unwrap_or_default(),
        simulation.facts.mean,
        simulation.facts.unit.symbol()
    )));
    // No wall clock in results: the time of the solver is for the terminal.
    simulation.facts.elapsed_s = None;
    let colour = reduction
        .spectral
        .as_ref()
        .map(|spectral| isolux_spectrum::quantities(&spectral.spectrum));
    let comparison = on_axis(&model, &reduction).map_err(Failure::bad_input)?;
    let light_modulation = wanted.light_modulation.as_ref().map(modulation::of).transpose()?;
    let conformity = Conformity::of(
        &wanted.conditions,
        &wanted.requirements,
        &run,
        &event::read(&run.path),
        &reduction,
        light_modulation.as_ref(),
    );
    Ok(DayResults {
        run,
        reduction,
        folder: results.to_owned(),
        scene,
        simulation,
        colour,
        comparison,
        conformity,
        layout: wanted.layout.clone(),
        diagnosis: None,
        undiagnosed: None,
        light_modulation,
        stale: Vec::new(),
    })
}
