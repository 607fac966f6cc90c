//! Direct ratios and the CIE flux code: where the downward flux goes.

use isolux_photometry::IntensityDistribution;

/// Fluxes of the CIE flux code: within the solid angles π/2, π, 3π/2 and 2π around γ = 0, that is up to these γ.
const CODE_GAMMA_DEG: [f64; 3] = [41.409_622_109_270_86, 60.0, 75.522_487_814_070_08];

/// N1 … N5 of the CIE flux code (CIE 52), in %: shares of the downward flux up to 41.4°, 60° and 75.5°, share of the
/// downward in the whole flux, and light output ratio (none without a lamp flux; 100 for absolute photometry).
pub(crate) fn cie_flux_code(grid: &IntensityDistribution, lamp_flux_lm: Option<f64>) -> Option<[f64; 5]> {
    let down = grid.flux_between(0.0, 90.0).value();
    let all = grid.flux().value();
    if down <= 0.0 || all <= 0.0 {
        return None;
    }
    let [n1, n2, n3] = CODE_GAMMA_DEG.map(|gamma| 100.0 * grid.flux_between(0.0, gamma).value() / down);
    let n5 = lamp_flux_lm
        .filter(|&lamp| lamp > 0.0)
        .map_or(100.0, |lamp| 100.0 * all / lamp);
    Some([n1, n2, n3, 100.0 * down / all, n5])
}

/// Geometric multipliers of the zonal method of EULUMDAT (LiTG): the direct ratio is the sum over four cumulated
/// fluxes F1 … F4 (to 41.4°, 60°, 75.5° and 90°) of p1·F1 + p2·F2 + p3·F3 + p4·F4 per total downward flux, for room
/// indices 0.6 … 5.
const MULTIPLIERS: [[f64; 10]; 4] = [
    [0.943, 0.752, 0.636, 0.510, 0.429, 0.354, 0.286, 0.258, 0.236, 0.231],
    [-0.317, -0.033, 0.121, 0.238, 0.275, 0.248, 0.190, 0.118, -0.006, -0.099],
    [0.481, 0.372, 0.310, 0.282, 0.309, 0.363, 0.416, 0.463, 0.512, 0.518],
    [
        -0.107, -0.091, -0.067, -0.030, -0.013, 0.035, 0.108, 0.161, 0.258, 0.350,
    ],
];

/// Direct ratios for the room indices 0.6, 0.8, 1, 1.25, 1.5, 2, 2.5, 3, 4, 5: the share of the downward flux that
/// falls directly on the working plane. None where nothing goes down.
pub(crate) fn direct_ratios(grid: &IntensityDistribution) -> Option<[f64; 10]> {
    let down = grid.flux_between(0.0, 90.0).value();
    if down <= 0.0 {
        return None;
    }
    let flux = [CODE_GAMMA_DEG[0], CODE_GAMMA_DEG[1], CODE_GAMMA_DEG[2], 90.0]
        .map(|gamma| grid.flux_between(0.0, gamma).value() / down);
    let ratio = |room: usize| (0..4).map(|zone| MULTIPLIERS[zone][room] * flux[zone]).sum();
    Some(std::array::from_fn(ratio))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lambertian_lamp_has_the_code_of_its_sines() {
        let gamma: Vec<f64> = (0..=360).map(|i| f64::from(i) * 0.25).collect();
        let candela = gamma.iter().map(|g| 1000.0 * g.to_radians().cos()).collect();
        let grid = IntensityDistribution::new(vec![0.0], gamma, candela).unwrap();
        // Lambert: the flux up to γ is sin²γ of all; cos γ = 3/4, 1/2, 1/4 at the zone edges.
        let code = cie_flux_code(&grid, None).unwrap();
        for (found, expected) in code
            .iter()
            .zip([100.0 * 7.0 / 16.0, 75.0, 100.0 * 15.0 / 16.0, 100.0, 100.0])
        {
            assert!((found - expected).abs() < 1e-2, "{code:?}");
        }
        let ratios = direct_ratios(&grid).unwrap();
        assert!(ratios.windows(2).all(|pair| pair[1] > pair[0]), "{ratios:?}");
        assert!(
            (0.45..0.55).contains(&ratios[0]) && (0.8..1.0).contains(&ratios[9]),
            "{ratios:?}"
        );
    }
}
