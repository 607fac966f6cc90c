//! The classification of outdoor luminaires of a file (IES TM-15-11): which side is the street's, and whether there is
//! one.

use isolux_photometry::IntensityDistribution;
use isolux_photometry::ratings::{LcsZone, ZonalFlux, backlight_rating, uplight_rating};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::distribution::Distribution;

/// Forward light over back light from which a luminaire is taken for one with a street side, where nobody says so.
const SIDED: f64 = 1.1;
/// A beam that is brightest nearer to the axis than this is a spot, tilted or not.
const SPOT_TO_DEG: f64 = 30.0;

/// Flux of the zones of TM-15-11 in lm, and the ratings that follow.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Outdoor {
    /// Half-plane of the street side.
    pub street_side_c_deg: f64,
    /// Forward light, γ 0–30°.
    pub fl_lm: f64,
    /// Forward light, γ 30–60°.
    pub fm_lm: f64,
    /// Forward light, γ 60–80°.
    pub fh_lm: f64,
    /// Forward light, γ 80–90°.
    pub fvh_lm: f64,
    /// Back light, γ 0–30°.
    pub bl_lm: f64,
    /// Back light, γ 30–60°.
    pub bm_lm: f64,
    /// Back light, γ 60–80°.
    pub bh_lm: f64,
    /// Back light, γ 80–90°.
    pub bvh_lm: f64,
    /// Uplight, γ 90–100°; null where the distribution ends below 180° in light.
    pub ul_lm: Option<f64>,
    /// Uplight, γ 100–180°; null likewise.
    pub uh_lm: Option<f64>,
    /// Backlight rating B, 0 to 5.
    pub backlight_rating: usize,
    /// Uplight rating U, 0 to 5; null likewise.
    pub uplight_rating: Option<usize>,
}

impl Outdoor {
    /// Of a distribution whose street side is C = `street_side_c_deg`; none where it does not reach the horizontal.
    pub fn of(light: &IntensityDistribution, street_side_c_deg: f64) -> Option<Self> {
        let last_deg = *light.gamma_deg().last()?;
        if last_deg < 90.0 || light.gamma_deg()[0] > 0.0 {
            return None;
        }
        let whole = last_deg == 180.0 || (0..light.c_deg().len()).all(|plane| light.row(plane).last() == Some(&0.0));
        let zones = ZonalFlux::of(light, street_side_c_deg);
        let lm = |zone| zones.lm(zone);
        let up = |zone| whole.then(|| zones.lm(zone).max(0.0));
        let (ul_lm, uh_lm) = (up(LcsZone::Ul), up(LcsZone::Uh));
        Some(Self {
            street_side_c_deg: street_side_c_deg.rem_euclid(360.0),
            fl_lm: lm(LcsZone::Fl),
            fm_lm: lm(LcsZone::Fm),
            fh_lm: lm(LcsZone::Fh),
            fvh_lm: lm(LcsZone::Fvh),
            bl_lm: lm(LcsZone::Bl),
            bm_lm: lm(LcsZone::Bm),
            bh_lm: lm(LcsZone::Bh),
            bvh_lm: lm(LcsZone::Bvh),
            ul_lm,
            uh_lm,
            backlight_rating: backlight_rating(lm(LcsZone::Bl), lm(LcsZone::Bm), lm(LcsZone::Bh)),
            uplight_rating: ul_lm.zip(uh_lm).map(|(ul, uh)| uplight_rating(ul, uh)),
        })
    }

    /// Towards the street and away from it, below the horizontal, in lm.
    pub fn sides_lm(&self) -> [f64; 2] {
        [
            self.fl_lm + self.fm_lm + self.fh_lm + self.fvh_lm,
            self.bl_lm + self.bm_lm + self.bh_lm + self.bvh_lm,
        ]
    }
}

impl Distribution {
    /// The street side by the convention of the file's format: C90 in EULUMDAT, C0 in LM-63 of type C (the horizontal
    /// angle 0° of a road luminaire points to the street); none in the others.
    pub fn street_side_c_deg(&self) -> Option<f64> {
        if self.header.contains_key("symmetry_indicator") {
            Some(90.0)
        } else {
            let lm63 = self.header.contains_key("photometric_type") && self.native.is_none();
            lm63.then_some(0.0)
        }
    }

    /// The classification with the street at C = `street_side_c_deg`; none where the file does not allow it.
    pub fn outdoor(&self, street_side_c_deg: f64) -> Option<Outdoor> {
        if self.header.contains_key("intensity_unit") {
            return None;
        }
        Outdoor::of(&self.intensity, street_side_c_deg)
    }
}

/// The classification by the convention of the format, of a luminaire that has a street side: one that sends clearly
/// more light there than to the other, and is brightest to the side.
pub(super) fn by_convention(distribution: &Distribution) -> Option<Outdoor> {
    let outdoor = distribution.outdoor(distribution.street_side_c_deg()?)?;
    let [forward_lm, back_lm] = outdoor.sides_lm();
    let sideways = distribution.intensity.peak().gamma_deg > SPOT_TO_DEG;
    (sideways && forward_lm > SIDED * back_lm.max(0.0)).then_some(outdoor)
}
