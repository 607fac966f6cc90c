//! What a person should know of a reduction, one sentence each.

use std::collections::BTreeSet;

use isolux_record::Reading;
use isolux_record::run::Run;

use crate::background::Background;
use crate::correction::Correction;
use crate::drift::{self, Drift};
use crate::grid::Grid;

/// That the γ are not those of the whole sphere.
pub fn zone_note(grid: &Grid) -> Option<String> {
    let gammas = grid.distribution.gamma_deg();
    let (first, last) = (gammas[0], gammas[gammas.len() - 1]);
    (first > 0.0 || last < 180.0).then(|| {
        format!("γ {first}° to {last}° was measured: the flux is that of this zone, and the files are dark outside it")
    })
}

/// What the lamp's switching on more than once during the distribution means for its level.
pub fn burning_notes(all: &[Reading], rows: &[&Reading], drift: &Drift, corrected: bool) -> Vec<String> {
    let starts = drift::burnings(all);
    let used: BTreeSet<usize> = rows.iter().map(|row| drift::burning_of(&starts, row.index)).collect();
    if used.len() < 2 || !corrected {
        return Vec::new();
    }
    let count = used.len();
    if matches!(drift, Drift::None { .. } | Drift::Linear { .. }) {
        return vec![format!(
            "the lamp was switched on {count} times during the distribution and came back as it was: its parts are corrected by its age"
        )];
    }
    let Drift::ByBurning { burning, .. } = drift else {
        return vec![format!(
            "the lamp was switched on {count} times during the distribution, and no visit to the reference point ties the levels; \
             give the block reference_every"
        )];
    };
    let mut notes = vec![format!(
        "the lamp was switched on {count} times during the distribution: each part is brought to the mean of all visits by its own"
    )];
    notes.extend(burning.iter().filter(|part| part.visits == 0).map(|part| {
        format!(
            "the part from row {} on has no visit to the reference point: its level is not tied to the others'",
            part.first_row
        )
    }));
    notes
}

/// That factors and spectra are corrected by different things.
pub fn factors_note(run: &Run) -> Option<String> {
    let spectral = run.header.spectral.as_ref().filter(|_| !run.spectra.is_empty())?;
    let (then, now) = (spectral.factors_corrected_by.as_ref()?, spectral.corrections.name());
    (*then != now).then(|| {
        format!(
            "the factors of the spectroradiometer were found with spectra corrected by {then}, these are corrected by \
             {now}: calibrate it again"
        )
    })
}

/// What the spectra of the run are not corrected by, because the station names no such file.
pub fn spectrometer_note(run: &Run) -> Option<String> {
    let not_named = run.header.spectral.as_ref()?.corrections.not_named();
    (!run.spectra.is_empty() && !not_named.is_empty()).then(|| {
        format!(
            "the spectra are not corrected for what the spectroradiometer does itself: the station names no {} \
             (isolux calibrate spectroradiometer)",
            not_named.join(", no ")
        )
    })
}

/// What the run itself and its station say.
pub fn run_notes(
    run: &Run,
    without: &BTreeSet<Correction>,
    background: &Background,
    used: usize,
    illuminated: usize,
) -> Vec<String> {
    let mut notes: Vec<String> = without
        .iter()
        .map(|correction| format!("correction {correction} is switched off"))
        .collect();
    if background.capped.is_none() && background.lamp_off.is_none() && background.baffled.is_empty() {
        notes.push("no capped, lamp_off or baffled readings: nothing was subtracted".to_owned());
    } else if background.baffled.is_empty() {
        notes.push("no baffled readings: stray light made by the lamp is still in the distribution".to_owned());
    }
    if used < illuminated {
        notes.push(format!(
            "{} lit readings have no number and were left out",
            illuminated - used
        ));
    }
    notes.extend(run.notices.iter().cloned());
    notes
}
