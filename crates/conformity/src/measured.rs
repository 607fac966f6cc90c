//! The quantities of a reduction by the names that requirements have for them.

use isolux_modulation::Modulation;
use isolux_record::requirements::{COLOUR_STEPS, Requirement};
use isolux_reduce::{BeamAngles, Colour, Quantity, Reduction};

/// Radius of one step of a colour circle in u′v′ (CIE TN 001:2014).
const STEP: f64 = 0.0011;

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
            Some(steps(requirement.centre?, u_prime, v_prime))
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

/// Steps from the centre. How u′ and v′ vary together is not known: their uncertainties along the way to the centre
/// add, which is the most that they can do.
fn steps(centre: [f64; 2], u_prime: &Quantity, v_prime: &Quantity) -> Quantity {
    let [du, dv] = [u_prime.value - centre[0], v_prime.value - centre[1]];
    let away = du.hypot(dv);
    let along = if away > 0.0 { [du / away, dv / away] } else { [1.0, 1.0] };
    let part = along[0].abs() * u_prime.u_of_parts + along[1].abs() * v_prime.u_of_parts;
    let missing = u_prime.missing.iter().chain(&v_prime.missing).cloned();
    Quantity::new(away / STEP, "steps", [("chromaticity", part / STEP)]).lacking(missing)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_counted_from_the_centre_with_the_most_that_both_can_add() {
        let of = |value: f64, u: f64| Quantity::new(value, "", [("noise", u)]);
        let found = steps([0.2, 0.5], &of(0.2033, 0.0011), &of(0.5, 0.0022));
        assert!(
            (found.value - 3.0).abs() < 1e-9 && (found.u.unwrap() - 1.0).abs() < 1e-9,
            "{found:?}"
        );
        let found = steps([0.2, 0.5], &of(0.2033, 0.0011), &of(0.5044, 0.0022));
        assert!(
            (found.value - 5.0).abs() < 1e-9 && (found.u.unwrap() - 2.2).abs() < 1e-9,
            "{found:?}"
        );
        let lacking = of(0.2, 0.001).lacking(["no u".to_owned()]);
        assert_eq!(steps([0.2, 0.5], &lacking, &of(0.5, 0.001)).u, None);
    }
}
