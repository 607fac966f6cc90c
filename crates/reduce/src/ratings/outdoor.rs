//! The zones of outdoor luminaires (IES TM-15-11), and the ratings that follow from them.

use isolux_photometry::ratings::{LcsZone, backlight_rating, uplight_rating};
use isolux_record::Run;

use super::sector_flux;
use crate::error::ReduceError;
use crate::{Quantity, Reduction};

/// What the zones of a luminaire with a street side are.
#[derive(Debug, Clone, PartialEq)]
pub struct OutdoorZones {
    /// Half-plane of the street side.
    pub street_side_c_deg: f64,
    /// Flux of every zone in lm; none of uplight that was not measured.
    pub zones: Vec<(LcsZone, Option<Quantity>)>,
    /// Backlight rating B, 0 to 5, of the measured numbers.
    pub backlight: usize,
    /// Uplight rating U likewise; none where uplight was not measured.
    pub uplight: Option<usize>,
    /// Uplight in lm that cannot be distinguished from none: the expanded uncertainty (k = 2) of the larger of both
    /// zones.
    pub uplight_unseen_lm: Option<f64>,
    /// Whether something is missing in the uncertainties.
    pub lacking: bool,
}

/// The zones; none where the job names no street side, or the horizontal was not reached.
///
/// # Errors
/// [`ReduceError::Distribution`] never for a grid that was one already.
pub fn outdoor(reduction: &Reduction, run: &Run) -> Result<Option<OutdoorZones>, ReduceError> {
    let Some(street_side_c_deg) = run.header.ratings.street_side_c_deg else {
        return Ok(None);
    };
    let gammas = reduction.grid.distribution.gamma_deg();
    let (first, last) = (gammas[0], gammas[gammas.len() - 1]);
    if first > 0.0 || last < 90.0 {
        return Ok(None);
    }
    let mut zones = Vec::new();
    for zone in LcsZone::ALL {
        let upward = matches!(zone, LcsZone::Ul | LcsZone::Uh);
        let flux = sector_flux(reduction, &zone.sector(street_side_c_deg))?;
        zones.push((zone, (last == 180.0 || !upward).then_some(flux)));
    }
    let of = |wanted: LcsZone| zones[wanted as usize].1.as_ref();
    let lm = |zone| of(zone).map_or(0.0, |flux| flux.value);
    // Noise about zero is no light: what is below it is taken for none.
    let up = of(LcsZone::Ul).zip(of(LcsZone::Uh));
    Ok(Some(OutdoorZones {
        backlight: backlight_rating(lm(LcsZone::Bl), lm(LcsZone::Bm), lm(LcsZone::Bh)),
        uplight: up.map(|(ul, uh)| uplight_rating(ul.value.max(0.0), uh.value.max(0.0))),
        uplight_unseen_lm: up.map(|(ul, uh)| 2.0 * ul.u_of_parts.max(uh.u_of_parts)),
        street_side_c_deg,
        lacking: !reduction.flux.missing.is_empty(),
        zones,
    }))
}
