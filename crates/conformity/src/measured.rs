//! The quantities of a reduction by the names that requirements have for them.

use isolux_modulation::Modulation;
use isolux_record::requirements::{COLOUR_STEPS, Requirement};
use isolux_reduce::ratings::steps_from;
use isolux_reduce::{BeamAngles, Colour, Quantity, Reduction};

/// What was measured of the quantity that is required, with what tells it from others of its name (a half-plane);
/// empty where it was not measured.
pub fn of(
    requirement: &Requirement,
    reduction: &Reduction,
    light: Option<&Modulation>,
) -> Vec<(Option<String>, Quantity)> {
    let colour = reduction.spectral.as_ref().map(|spectral| &spectral.colour);
    let total = reduction.over_angle.as_ref().map(|found| &found.facts.total.colour);
    let line = reduction.electrical.as_ref();
    let of = |colour: Option<&Colour>, pick: fn(&Colour) -> &Option<Quantity>| {
        colour.and_then(|colour| pick(colour).clone())
    };
    let one = match requirement.quantity.as_str() {
        "beam_deg" => return planes(reduction, |plane| plane.beam.as_ref()),
        "field_deg" => return planes(reduction, |plane| plane.field.as_ref()),
        "flux_lm" => Some(reduction.flux.clone()),
        "i_max_cd" => Some(reduction.i_max.clone()),
        "sensor_illuminance_lx" => Some(reduction.sensor_illuminance.clone()),
        "sensor_irradiance_w_m2" => reduction.sensor_irradiance.clone(),
        "power_w" => line.map(|line| line.power.clone()),
        "efficacy_lm_w" => line.map(|line| line.luminous_efficacy.clone()),
        "cct_k" => of(colour, |colour| &colour.cct),
        "duv" => of(colour, |colour| &colour.duv),
        "x" => of(colour, |colour| &colour.x),
        "y" => of(colour, |colour| &colour.y),
        "u_prime" => of(colour, |colour| &colour.u_prime),
        "v_prime" => of(colour, |colour| &colour.v_prime),
        "ra" => of(colour, |colour| &colour.ra),
        "r9" => of(colour, |colour| &colour.r9),
        "rf" => of(colour, |colour| &colour.rf),
        "rg" => of(colour, |colour| &colour.rg),
        COLOUR_STEPS => colour.and_then(|colour| {
            let (u_prime, v_prime) = (colour.u_prime.as_ref()?, colour.v_prime.as_ref()?);
            let [u, v] = requirement.centre?;
            Some(steps_from(u_prime, v_prime, (u, v)))
        }),
        "total_cct_k" => of(total, |colour| &colour.cct),
        "total_ra" => of(total, |colour| &colour.ra),
        "delta_u_prime_v_prime" => {
            let found = reduction.over_angle.as_ref();
            found.map(|found| found.facts.delta_u_prime_v_prime.value.clone())
        }
        "svm" => light.and_then(|light| light.svm.quantity.clone()),
        "pst_lm" => light.and_then(|light| light.pst_lm.quantity.clone()),
        "modulation_depth_percent" => light.map(|light| light.modulation_depth.clone()),
        "flicker_index" => light.map(|light| light.flicker_index.clone()),
        _ => None,
    };
    one.map(|quantity| (None, quantity)).into_iter().collect()
}

fn planes(reduction: &Reduction, of: impl Fn(&BeamAngles) -> Option<&Quantity>) -> Vec<(Option<String>, Quantity)> {
    let planes = reduction.angles.iter();
    planes
        .filter_map(|plane| Some((Some(plane.name()), of(plane)?.clone())))
        .collect()
}
