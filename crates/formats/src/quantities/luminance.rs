//! Mean luminance of the luminous area: intensity over the area that is seen from there.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::luminous_body::Body;
use crate::distribution::Distribution;

/// γ of the table in degrees.
const GAMMA_DEG: [f64; 4] = [55.0, 65.0, 75.0, 85.0];

/// From this γ on luminaires are mirrored in screens (EN 12464-1, for screens tilted by up to 15°).
const SCREENS_FROM_DEG: f64 = 65.0;

/// Largest mean luminance in cd/m² of luminaires that can be mirrored in screens with dark characters on light ground
/// and normal demands on colour and detail (EN 12464-1:2011, case A): screens brighter than
/// [`SCREEN_LUMINANCE_CD_M2`], and others. The limits of case B are not in here: they could not be checked.
pub const SCREEN_LIMITS_CD_M2: [f64; 2] = [3000.0, 1500.0];
/// Luminance in cd/m² above which a screen is a bright one in that table.
pub const SCREEN_LUMINANCE_CD_M2: f64 = 200.0;

/// More half-planes than this are not tabulated.
const MOST_PLANES: usize = 24;

/// Mean luminance by direction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LuminanceTable {
    /// Half-planes: those of the distribution, at most 24 of them.
    pub c_deg: Vec<f64>,
    /// γ: a row each.
    pub gamma_deg: [f64; 4],
    /// Mean luminance, by γ and half-plane; null where nothing of the area is seen.
    pub cd_m2: Vec<Vec<Option<f64>>>,
    /// The largest at γ 65°, 75° and 85°, over all half-planes of the distribution.
    pub largest_from_65_cd_m2: f64,
}

/// The table; none without a luminous area, or where the numbers are not candela.
pub(super) fn table(distribution: &Distribution) -> Option<LuminanceTable> {
    if distribution.header.contains_key("intensity_unit") {
        return None;
    }
    let body = Body::of(&distribution.luminaire)?;
    let light = &distribution.intensity;
    let luminance = |c_deg: f64, gamma_deg: f64| {
        let area_m2 = body.projected_m2(c_deg, gamma_deg);
        (area_m2 > 0.0).then(|| light.intensity_cd_at(c_deg, gamma_deg).max(0.0) / area_m2)
    };
    let planes = light.c_deg();
    let c_deg: Vec<f64> = planes
        .iter()
        .copied()
        .step_by(planes.len().div_ceil(MOST_PLANES))
        .collect();
    let row = |gamma_deg: f64| c_deg.iter().map(|c_deg| luminance(*c_deg, gamma_deg)).collect();
    let on_screens = GAMMA_DEG.into_iter().filter(|gamma| *gamma >= SCREENS_FROM_DEG);
    let all = on_screens.flat_map(|gamma_deg| planes.iter().filter_map(move |c_deg| luminance(*c_deg, gamma_deg)));
    Some(LuminanceTable {
        gamma_deg: GAMMA_DEG,
        cd_m2: GAMMA_DEG.into_iter().map(row).collect(),
        largest_from_65_cd_m2: all.fold(0.0, f64::max),
        c_deg,
    })
}
