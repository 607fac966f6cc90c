//! Light output of the lamp over time: two thermal masses, depreciation, modulation.

use crate::injected_effects::InjectedEffects;

/// Abscissae and weights of five-point Gauss–Legendre quadrature on [−1, 1] (Abramowitz & Stegun, table 25.4).
const GAUSS: [(f64, f64); 5] = [
    (-0.906_179_845_938_664, 0.236_926_885_056_189),
    (-0.538_469_310_105_683, 0.478_628_670_499_366),
    (0.0, 0.568_888_888_888_889),
    (0.538_469_310_105_683, 0.478_628_670_499_366),
    (0.906_179_845_938_664, 0.236_926_885_056_189),
];

/// Output relative to the warm, new lamp, averaged over a window of `window_s` around `time_s` (s since switch-on).
pub fn relative_output(injected_effects: &InjectedEffects, time_s: f64, window_s: f64) -> f64 {
    GAUSS
        .iter()
        .map(|(x, weight)| 0.5 * weight * instant(injected_effects, time_s + 0.5 * window_s * x))
        .sum()
}

/// Relative excess of the light over that of the warm lamp, `time_s` after switch-on.
pub fn warmup_excess(injected_effects: &InjectedEffects, time_s: f64) -> f64 {
    let warmup = &injected_effects.lamp_warmup;
    let second_s = if warmup.second_time_constant_s > 0.0 {
        warmup.second_time_constant_s
    } else {
        4.0 * warmup.time_constant_s
    };
    // The board cools into the housing, the housing into the room: droop is the sum of both excess temperatures.
    let board = (1.0 - warmup.second_share) * (-time_s / warmup.time_constant_s).exp();
    let housing = warmup.second_share * (-time_s / second_s).exp();
    warmup.amplitude_rel * (board + housing)
}

fn instant(injected_effects: &InjectedEffects, time_s: f64) -> f64 {
    let droop = 1.0 + warmup_excess(injected_effects, time_s);
    // Depreciation follows L(t) = exp(r t), as TM-21 extrapolates it.
    let depreciation =
        (injected_effects.lamp_drift.rate_per_h * (time_s - injected_effects.lamp_drift.reference_s) / 3600.0).exp();
    let beat = &injected_effects.flicker_alias;
    let modulation = 1.0 + beat.amplitude_rel * (std::f64::consts::TAU * time_s / beat.period_s + beat.phase_rad).sin();
    droop * depreciation * modulation * (1.0 + injected_effects.light_level.factor_rel)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lamp_settles_to_one_with_two_time_constants() {
        let mut injected_effects = InjectedEffects::default();
        assert!((relative_output(&injected_effects, 100.0, 0.5) - 1.0).abs() < 1e-14);
        injected_effects.lamp_warmup.amplitude_rel = 0.1;
        injected_effects.lamp_warmup.time_constant_s = 100.0;
        injected_effects.lamp_warmup.second_share = 0.25;
        let expected = 1.0 + 0.1 * (0.75 * (-2.0f64).exp() + 0.25 * (-0.5f64).exp());
        assert!((relative_output(&injected_effects, 200.0, 0.0) - expected).abs() < 1e-12);
        assert!((relative_output(&injected_effects, 1e5, 0.5) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn modulation_averages_over_the_window() {
        let mut injected_effects = InjectedEffects::default();
        injected_effects.flicker_alias.amplitude_rel = 0.05;
        injected_effects.flicker_alias.period_s = 2.0;
        // ∫ over half a period from a crest's side: mean of sin over [0, 1] s is 2/π.
        let mean = relative_output(&injected_effects, 0.5, 1.0);
        assert!((mean - (1.0 + 0.05 * 2.0 / std::f64::consts::PI)).abs() < 1e-7);
    }
}
