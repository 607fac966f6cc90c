//! Patterns along the wavelength of spectra.

use super::Acts::{Everywhere, Relative};
use super::shape::Shape::{Beyond, Bump};
use super::{List, cosines};
use crate::table::{Coordinate, ObservationKind};

pub(super) fn wavelength(list: &mut List<'_>) {
    let Some((_, [low, high])) = list.distinct(ObservationKind::Sample, Coordinate::WavelengthNm, 2) else {
        return;
    };
    let share = list.values(|row| (row.wavelength_nm - low) / (high - low));
    let mut on = list.on(ObservationKind::Sample, Coordinate::WavelengthNm);
    for acts in [Relative, Everywhere] {
        for width in [0.03, 0.1] {
            let count = (0.7 / width) as usize;
            for k in 0..=count {
                let centre = k as f64 / count as f64;
                let middle = low + centre * (high - low);
                let reach = 1.5 * width * (high - low);
                let bump = Bump(centre, width).along(&share);
                on.one(
                    acts,
                    "bump",
                    [middle - reach, middle + reach],
                    "near one wavelength",
                    bump,
                );
            }
        }
        on.one(acts, "smooth", [low, high], "that varies smoothly", cosines(4, &share));
    }
    for step in 1..12 {
        let edge = f64::from(step) / 12.0;
        let (from, beyond) = (low + edge * (high - low), Beyond(edge).along(&share));
        on.one(Relative, "jump", [from, high], "beyond one wavelength", beyond);
    }
}
