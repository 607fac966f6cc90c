//! Direct ratios and the CIE flux code: where the downward flux goes.

use isolux_photometry::IntensityDistribution;

use crate::eulumdat::document::ROOM_INDICES;

/// Fluxes of the CIE flux code: within the solid angles π/2, π, 3π/2 and 2π around γ = 0, that is up to these γ.
const CODE_GAMMA_DEG: [f64; 3] = [41.409_622_109_270_86, 60.0, 75.522_487_814_070_08];

/// N1 … N5 of the CIE flux code (CIE 52), in %: shares of the downward flux up to 41.4°, 60° and 75.5°, share of the
/// downward in the whole flux, and light output ratio (none without a lamp flux; 100 for absolute photometry).
pub(crate) fn cie_flux_code(grid: &IntensityDistribution, lamp_flux_lm: Option<f64>) -> Option<[f64; 5]> {
    let down = grid.flux_between_lm(0.0, 90.0);
    let all = grid.flux_lm();
    if down <= 0.0 || all <= 0.0 {
        return None;
    }
    let [n1, n2, n3] = CODE_GAMMA_DEG.map(|gamma| 100.0 * grid.flux_between_lm(0.0, gamma) / down);
    let n5 = lamp_flux_lm
        .filter(|&lamp| lamp > 0.0)
        .map_or(100.0, |lamp| 100.0 * all / lamp);
    Some([n1, n2, n3, 100.0 * down / all, n5])
}

/// Direct ratios of EULUMDAT for the room indices 0.6, 0.8, 1, 1.25, 1.5, 2, 2.5, 3, 4, 5: the share of the luminaire's
/// whole flux that falls directly on the working plane of a square room whose ceiling is evenly filled with luminaires.
/// None where nothing goes down.
///
/// Field descriptions leave open whether light that goes up counts. Files do not: of 17 by many hands whose ratios
/// belong to their light, those with 33 %, 87 %, 90 % and 94 % downward flux are met within 0.033 if it counts, and
/// missed by up to
/// 0.57 if it does not.
pub(crate) fn direct_ratios(grid: &IntensityDistribution) -> Option<[f64; 10]> {
    let (down, all) = (grid.flux_between_lm(0.0, 90.0), grid.flux_lm());
    let shares = direct_shares(grid)?;
    (all > 0.0).then(|| shares.map(|share| share * down / all))
}

/// Rings of γ, and directions on each of them, of the integral over the lower half.
const RINGS: u16 = 180;
const DIRECTIONS: u16 = 72;

/// A ring of γ on a grid: the grid's angle below it and the part of the way to the next one.
struct Ring {
    below: usize,
    part: f64,
    sine: f64,
    tangent: f64,
}

impl Ring {
    /// None outside the grid, where it is dark.
    fn new(grid_deg: &[f64], gamma_deg: f64) -> Option<Self> {
        let after = grid_deg.partition_point(|&angle| angle <= gamma_deg);
        let below = after.checked_sub(1).filter(|_| after < grid_deg.len())?;
        Some(Self {
            below,
            part: (gamma_deg - grid_deg[below]) / (grid_deg[after] - grid_deg[below]),
            sine: gamma_deg.to_radians().sin(),
            tangent: gamma_deg.to_radians().tan(),
        })
    }
}

/// The share of the downward flux that falls directly on the working plane, for the same rooms.
///
/// From height 1 over a square of side 2k, light in the direction (C, γ) shifts by tan γ; the share of it that lands
/// on the square is the overlap of the square with itself, shifted so. For a Lambertian lamp this is the view factor
/// of opposite faces.
pub(super) fn direct_shares(grid: &IntensityDistribution) -> Option<[f64; 10]> {
    let rings: Vec<Ring> = (0..RINGS)
        .filter_map(|ring| Ring::new(grid.gamma_deg(), (f64::from(ring) + 0.5) * 90.0 / f64::from(RINGS)))
        .collect();
    let reach = ROOM_INDICES.map(|k| 0.5 / k);
    let mut all = 0.0;
    let mut landing = [0.0; 10];
    for direction in 0..DIRECTIONS {
        let c = (f64::from(direction) + 0.5) * 360.0 / f64::from(DIRECTIONS);
        let curve = grid.half_plane_cd(c);
        let (along, across) = c.to_radians().sin_cos();
        for ring in &rings {
            let below = curve[ring.below];
            let flux = (below + ring.part * (curve[ring.below + 1] - below)) * ring.sine;
            all += flux;
            let (along, across) = ((along * ring.tangent).abs(), (across * ring.tangent).abs());
            for (sum, reach) in landing.iter_mut().zip(reach) {
                *sum += flux * (1.0 - along * reach).max(0.0) * (1.0 - across * reach).max(0.0);
            }
        }
    }
    (all > 0.0).then(|| landing.map(|sum| sum / all))
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
        // View factors of opposite squares of side 1.2 and 10 at distance 1.
        assert!(
            (ratios[0] - 0.2494).abs() < 0.01 && (ratios[9] - 0.8270).abs() < 0.005,
            "{ratios:?}"
        );
    }
}
