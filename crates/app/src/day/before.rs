//! The whole job is checked before anything moves: what would be refused after a scan of hours is refused before it.

use camino::Utf8Path;
use isolux_conformity::before::not_claimable;
use isolux_model::{Emitter, Luminaire, Model, Spectral};
use isolux_record::plan::Instrument;
use isolux_record::{Job, Plan, ReadingKind, Station};
use isolux_spectrum::Spectrum;

use crate::diagnosis::diagnose;
use crate::files::Overwrite;
use crate::front_end::progress::{Event, Progress};
use crate::modulation;
use crate::run::record;
use crate::simulation::{scene, simulate};
use crate::{Failure, scan};

/// Checks the station, the plan and what it gives, the scene with the files that it names, the model and
/// observations of the diagnosis, and the record of the light over time. `scanned` is the folder of a day whose scan is
/// complete: then nothing moves, and its record says what was planned. What the day will not be able to claim goes to
/// `progress`.
///
/// # Errors
/// Bad input (exit 2) with file and line.
pub(super) fn check(
    job: &Job,
    scanned: Option<&Utf8Path>,
    attended: bool,
    progress: &dyn Progress,
) -> Result<(), Failure> {
    let (station, plan) = if let Some(day) = scanned {
        let header = record::read(day)?.header;
        (header.station, header.plan)
    } else {
        let (source, plan, _) = scan::checked(job.station(), job.plan(), attended)?;
        (source.station, plan)
    };
    let model = stand_in(job, &station, &plan)?;
    let scene = scene::lit_by(job.scene(), &model)?;
    simulate::check_feasibility(&scene).map_err(|failure| Failure {
        message: format!("{}: {}", job.scene(), failure.message),
        ..failure
    })?;
    if let Some(request) = super::requested::diagnosis(job, Utf8Path::new("results"), Overwrite::Never) {
        diagnose::check(&request)?;
    }
    if let Some(light) = job.light_modulation() {
        modulation::of(light)?;
    }
    super::requested::Wanted::of(job)?;
    if scanned.is_none() {
        for sentence in not_claimable(
            &station,
            &plan,
            job.conditions(),
            job.requirements(),
            job.light_modulation().is_some(),
        ) {
            progress.event(Event::Note(&format!("not to be claimed of this day: {sentence}")));
        }
    }
    Ok(())
}

/// A model like the one that the day will make: the plan's directions, and a spectrum where the plan takes one.
fn stand_in(job: &Job, station: &Station, plan: &Plan) -> Result<Model, Failure> {
    let distribution = isolux_reduce::check_feasibility(plan, station)
        .map_err(|failure| Failure::bad_input(format!("{}: {}", job.plan(), failure)))?;
    let takes_spectrum = plan
        .blocks()
        .iter()
        .any(|block| block.instrument == Instrument::Spectroradiometer && block.kind == ReadingKind::Lit);
    let spectral = if takes_spectrum {
        let wavelength_nm = (360..=830).map(f64::from).collect::<Vec<_>>();
        let value = vec![1.0; wavelength_nm.len()];
        Spectral::Spectrum(Spectrum::new(wavelength_nm, value).map_err(Failure::bad_input)?)
    } else {
        Spectral::None
    };
    // As a reduced model has it.
    let emitter = Emitter::Disc { diameter_mm: 1.0 };
    Ok(Model::of(Luminaire::new(distribution, emitter, spectral)))
}
