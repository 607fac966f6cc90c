//! What the light is rated by: zones of outdoor luminaires, rated colour, blue-light hazard, photons. Each only where
//! it applies.

use isolux_photometry::ratings::LcsZone;
use isolux_reduce::ratings::{HazardDistance, OutdoorZones, hazard_distance, outdoor, photon_flux, rated_colour};
use isolux_reduce::{Quantity, ReduceError, no_uncertainty};
use isolux_units::digits::significant;

use super::results::DayResults;
use crate::document::Section;

/// None where nothing of it applies.
///
/// # Errors
/// [`ReduceError`] never for a distribution that is one already.
pub fn section(day_results: &DayResults) -> Result<Option<Section>, ReduceError> {
    let (reduction, run) = (&day_results.reduction, &day_results.run);
    let zones = outdoor(reduction, run)?;
    let rated = rated_colour(reduction, run);
    let hazard = hazard_distance(reduction);
    let photons = photon_flux(reduction);
    if zones.is_none() && rated.is_none() && hazard.is_none() && photons.is_none() {
        return Ok(None);
    }
    let mut section = Section::new("Ratings");
    if let Some(zones) = &zones {
        outdoor_luminaire(&mut section, zones);
    }
    let of = |all: bool| if all { "all the light" } else { "the light on the axis" };
    let mut facts = Vec::new();
    if let Some(rated) = &rated {
        facts.push((
            format!(
                "distance of {} from {}, steps of 0.0011 in u′v′ (CIE TN 001)",
                of(rated.of_all),
                rated.with
            ),
            rated.steps.stated(),
        ));
    }
    if let Some(hazard) = &hazard {
        facts.push((
            format!("K_B,v of {} (IEC TR 62778)", of(hazard.of_all)),
            hazard.k_bv.stated(),
        ));
        facts.push(("threshold illuminance E_thr".to_owned(), hazard.threshold.stated()));
        facts.push((
            "distance at which the largest intensity makes it".to_owned(),
            hazard.distance.stated(),
        ));
    }
    if let Some(photons) = &photons {
        facts.push(("photon flux, 400–700 nm (PPF)".to_owned(), photons.stated()));
    }
    facts.extend(at_the_spectroradiometer(day_results));
    if !facts.is_empty() {
        section.subheading("Light");
        section.facts(facts);
    }
    if let Some(hazard) = &hazard {
        section.paragraph(hazard_words(hazard));
    }
    Ok(Some(section))
}

/// Photons where the spectrum was read.
fn at_the_spectroradiometer(day_results: &DayResults) -> Option<(String, String)> {
    let spectral = day_results.reduction.spectral.as_ref()?;
    let per_lumen = spectral.colour.photons.as_ref()?.times(1e-3, "µmol/s/lm");
    let density: Quantity = spectral.illuminance.by(&per_lumen, "µmol/(m²·s)", "spectrum");
    Some((
        format!("photon flux density on the axis at {} mm (PPFD)", spectral.distance_mm),
        density.stated(),
    ))
}

fn hazard_words(hazard: &HazardDistance) -> String {
    format!(
        "Below E_thr, 1 W/m² weighted with B(λ) over K_B,v, no source of this light is of a higher risk group than 1, whatever its \
         size (IEC 62471, B(λ) of its Table 4.2, over 360–830 nm); nearer than {} m the radiance decides, which is not measured here.",
        significant(hazard.distance.value, 2)
    )
}

fn outdoor_luminaire(section: &mut Section, found: &OutdoorZones) {
    section.subheading("Classification of outdoor luminaires (IES TM-15-11)");
    let total: f64 = found
        .zones
        .iter()
        .filter_map(|(_, flux)| Some(flux.as_ref()?.value))
        .sum();
    let rows = found.zones.iter().map(|(zone, flux)| {
        let (stated, share) = match flux {
            Some(flux) => (flux.brief(), format!("{:.1} %", 100.0 * flux.value / total)),
            None => ("not measured".to_owned(), "–".to_owned()),
        };
        vec![format!("{}, {}", zone.name(), what(*zone)), stated, share]
    });
    let rows = rows.collect();
    section.numbers(["zone", "flux", "of the total"].map(str::to_owned).to_vec(), rows);
    let missing = found.zones.iter().find_map(|(_, flux)| Some(&flux.as_ref()?.missing));
    if let Some(missing) = missing.filter(|missing| !missing.is_empty()) {
        section.paragraph(format!("The zones have {}.", no_uncertainty(missing)));
    }
    let uplight = match (found.uplight, found.uplight_unseen_lm) {
        (Some(uplight), Some(unseen_lm)) => format!(
            "U{uplight} by the measured numbers. U0 is 0 lm of uplight, which no measurement shows: {} {} lm in a zone (k = 2) cannot be \
             distinguished from none here.",
            if found.lacking { "at least" } else { "up to" },
            significant(unseen_lm, 2)
        ),
        _ => "No uplight rating: γ was not measured to 180°.".to_owned(),
    };
    section.paragraph(format!(
        "Street side C {}°. B{}, {uplight} The glare rating G is not given: its limits could not be checked.",
        found.street_side_c_deg, found.backlight
    ));
}

const fn what(zone: LcsZone) -> &'static str {
    match zone {
        LcsZone::Fl => "forward, γ 0–30°",
        LcsZone::Fm => "forward, γ 30–60°",
        LcsZone::Fh => "forward, γ 60–80°",
        LcsZone::Fvh => "forward, γ 80–90°",
        LcsZone::Bl => "back, γ 0–30°",
        LcsZone::Bm => "back, γ 30–60°",
        LcsZone::Bh => "back, γ 60–80°",
        LcsZone::Bvh => "back, γ 80–90°",
        LcsZone::Ul => "up, γ 90–100°",
        LcsZone::Uh => "up, γ 100–180°",
    }
}
