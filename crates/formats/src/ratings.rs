//! Flux and power against each other, the same for every format.

/// Above this no lamp gives light out of its power, in lm/W: white light of the best spectrum ends near 400, and of
/// what is sold nothing exceeds 250.
const MOST_LM_PER_W: f64 = 300.0;
/// Below this a lamp is none for light, in lm/W: a candle, by its heat, has 0.1, the dimmest coloured lamp more than 1.
const LEAST_LM_PER_W: f64 = 1.0;
/// From here a lamp count may be a flux.
const MANY_LAMPS: f64 = 50.0;

/// What is wrong with `flux_lm` out of `watts`; nothing where one of them is not stated.
pub(crate) fn efficacy(flux_lm: f64, watts: f64) -> Option<String> {
    if flux_lm <= 0.0 || watts <= 0.0 {
        return None;
    }
    let efficacy = flux_lm / watts;
    let from = format!("{flux_lm} lm out of {watts} W are {efficacy:.3} lm/W");
    if efficacy > 683.0 {
        Some(format!("{from}; no light has more than 683"))
    } else if efficacy > MOST_LM_PER_W {
        Some(format!("{from}; no lamp gives more than {MOST_LM_PER_W}"))
    } else if efficacy < LEAST_LM_PER_W {
        Some(format!("{from}; a lamp gives more than {LEAST_LM_PER_W}"))
    } else {
        None
    }
}

/// Whether the flux of a lamp is none: below 0.1 lm, or below 1.5 lm where there are so many that the two numbers may
/// have changed places.
pub(crate) fn dim(lamps: f64, flux_lm: f64) -> bool {
    let least = if lamps > MANY_LAMPS { 1.5 } else { 0.1 };
    flux_lm > 0.0 && flux_lm < least * lamps
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_lamps_give_is_believed() {
        for (flux, watts) in [
            (1800.0, 12.0),
            (1.0, 0.1),
            (4000.0, 0.0),
            (853.0, 75.0),
            (102.52, 87.4),
            (250.0, 1.0),
        ] {
            assert_eq!(efficacy(flux, watts), None);
        }
        assert!(!dim(1.0, 1.0) && !dim(192.0, 9600.0) && dim(635.0, 635.0) && dim(609.0, 1.0));
        assert!(efficacy(609.0, 1.0).is_some_and(|m| m.ends_with("no lamp gives more than 300")));
        assert!(efficacy(6.9, 609.0).is_some());
        assert!(efficacy(19_800.0, 1.0).is_some_and(|m| m.contains("19800 lm") && m.contains("683")));
    }
}
