//! Directional or not, and the useful luminous flux (Regulation (EU) 2019/2015, Annex I, 4, 15 and 16).

use isolux_photometry::{IntensityDistribution, Sector};

use crate::error::ReduceError;
use crate::ratings::{flux_share, sector_flux};
use crate::{Quantity, Reduction};

/// Share of the flux in % that a directional light source has within the cone of 120°.
const DIRECTIONAL_FROM_PERCENT: f64 = 80.0;
/// Half of the cone of 120° and of that of 90°.
const WIDE_DEG: f64 = 60.0;
const NARROW_DEG: f64 = 45.0;
/// Beam angle in degrees from which on the useful flux is that of the wide cone.
const WIDE_FROM_BEAM_DEG: f64 = 90.0;

/// Where the useful luminous flux lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cone {
    /// In the sphere: a light source that is not directional.
    Sphere,
    /// In the cone of 120°: directional, with a beam angle of 90° and more.
    Wide,
    /// In the cone of 90°: directional, with a smaller one.
    Narrow,
}

impl Cone {
    /// As the product information sheet has it.
    pub const fn words(self) -> &'static str {
        match self {
            Self::Sphere => "sphere (360°)",
            Self::Wide => "wide cone (120°)",
            Self::Narrow => "narrow cone (90°)",
        }
    }
}

/// Whether a light source is directional.
#[derive(Debug, Clone, PartialEq)]
pub struct Directional {
    /// Whether it is, by the measured share.
    pub is_directional: bool,
    /// Share of the flux within the cone of 120°, in %.
    pub share: Quantity,
    /// γ of the axis of that cone: 0 or 180, whichever has more light about it.
    pub axis_gamma_deg: f64,
    /// Beam angle in degrees, 50 % of the intensity on the axis, the largest of all planes; none where the intensity
    /// does not fall so far.
    pub beam_deg: Option<f64>,
}

/// Whether the measured lamp is directional, where its useful flux lies and how much it is.
///
/// # Errors
/// [`ReduceError::Distribution`] never for a grid that was one already.
pub(super) fn useful(reduction: &Reduction) -> Result<(Directional, Cone, Quantity), ReduceError> {
    let light = &reduction.grid.distribution;
    let down = light.sector_flux_lm(&about(0.0, WIDE_DEG)) >= light.sector_flux_lm(&about(180.0, WIDE_DEG));
    let axis_gamma_deg = if down { 0.0 } else { 180.0 };
    let share = flux_share(reduction, &about(axis_gamma_deg, WIDE_DEG))?;
    let is_directional = share.value >= DIRECTIONAL_FROM_PERCENT;
    let beam_deg = beam_deg(light, axis_gamma_deg);
    let cone = match beam_deg {
        _ if !is_directional => Cone::Sphere,
        Some(beam) if beam < WIDE_FROM_BEAM_DEG => Cone::Narrow,
        _ => Cone::Wide,
    };
    let flux = match cone {
        Cone::Sphere => reduction.flux.clone(),
        Cone::Wide => sector_flux(reduction, &about(axis_gamma_deg, WIDE_DEG))?,
        Cone::Narrow => sector_flux(reduction, &about(axis_gamma_deg, NARROW_DEG))?,
    };
    let directional = Directional {
        is_directional,
        share,
        axis_gamma_deg,
        beam_deg,
    };
    Ok((directional, cone, flux))
}

/// The cone of `half_deg` about γ 0 or γ 180°.
fn about(axis_gamma_deg: f64, half_deg: f64) -> Sector {
    if axis_gamma_deg == 0.0 {
        Sector::zone(0.0, half_deg)
    } else {
        Sector::zone(180.0 - half_deg, 180.0)
    }
}

/// The beam angle about the axis: in every half-plane the angle from the axis beyond which the intensity stays below
/// half of that on the axis, added for opposite half-planes; the largest. None where one of them does not fall so far.
fn beam_deg(light: &IntensityDistribution, axis_gamma_deg: f64) -> Option<f64> {
    let gammas = light.gamma_deg();
    let half_cd = 0.5 * light.pole_cd(axis_gamma_deg);
    if half_cd <= 0.0 {
        return None;
    }
    let edge = |c_deg: f64| -> Option<f64> {
        let mut profile: Vec<(f64, f64)> = gammas
            .iter()
            .map(|gamma| (gamma - axis_gamma_deg).abs())
            .zip(light.half_plane_cd(c_deg))
            .collect();
        profile.sort_by(|a, b| a.0.total_cmp(&b.0));
        let last = profile.iter().rposition(|(_, cd)| *cd >= half_cd)?;
        let (from, to) = (profile[last], *profile.get(last + 1)?);
        Some(from.0 + (from.1 - half_cd) / (from.1 - to.1) * (to.0 - from.0))
    };
    let planes = light.c_deg().iter();
    let angles: Option<Vec<f64>> = planes.map(|c_deg| Some(edge(*c_deg)? + edge(c_deg + 180.0)?)).collect();
    angles?.into_iter().reduce(f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(f: impl Fn(f64, f64) -> f64) -> IntensityDistribution {
        let c_deg: Vec<f64> = (0..24).map(|plane| 15.0 * f64::from(plane)).collect();
        let gamma_deg: Vec<f64> = (0..=180).map(f64::from).collect();
        let pairs = c_deg
            .iter()
            .flat_map(|c| gamma_deg.iter().map(|gamma| f(*c, gamma.to_radians())));
        let intensity_cd = pairs.collect();
        IntensityDistribution::new(c_deg, gamma_deg, intensity_cd).unwrap()
    }

    #[test]
    fn the_beam_is_the_widest_about_the_intensity_on_the_axis() {
        let flat = of(|_, gamma| gamma.cos().max(0.0));
        assert!((beam_deg(&flat, 0.0).unwrap() - 120.0).abs() < 0.01);
        let up = of(|_, gamma| (-gamma.cos()).max(0.0));
        assert!((beam_deg(&up, 180.0).unwrap() - 120.0).abs() < 0.01);
        // cos⁵ across, cos² along: the wider one, 2·arccos √½ = 90°.
        let oval = of(|c, gamma| {
            let along = c.to_radians().sin().powi(2);
            gamma.cos().max(0.0).powf(5.0 - 3.0 * along)
        });
        assert!((beam_deg(&oval, 0.0).unwrap() - 90.0).abs() < 0.05);
        // Brighter to the side than on the axis: half of the axis counts, not half of the largest.
        let batwing = of(|_, gamma| gamma.cos().max(0.0) * (1.0 + 4.0 * gamma.sin().powi(2)));
        assert!(
            beam_deg(&batwing, 0.0).unwrap() > 150.0,
            "{:?}",
            beam_deg(&batwing, 0.0)
        );
        assert_eq!(beam_deg(&of(|_, _| 1.0), 0.0), None);
        assert_eq!(beam_deg(&of(|_, gamma| gamma.sin().powi(4)), 0.0), None);
    }
}
