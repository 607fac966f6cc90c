//! Patterns along the wavelength of spectra.

use super::{Builder, word};
use crate::pattern::Acts;
use crate::table::{Coordinate, ObservationKind, Row};

pub(super) fn wavelength(build: &mut Builder<'_>) {
    let samples = build.distinct(ObservationKind::Sample, Coordinate::WavelengthNm);
    let (Some(&low), Some(&high)) = (samples.first(), samples.last()) else {
        return;
    };
    if high <= low {
        return;
    }
    let mut along = build.along(ObservationKind::Sample, Coordinate::WavelengthNm);
    let place = move |row: &Row| (row.wavelength_nm - low) / (high - low);
    for acts in [Acts::Relative, Acts::Everywhere] {
        for width in [0.03, 0.1] {
            let count = (0.7 / width) as usize;
            for k in 0..=count {
                let centre = k as f64 / count as f64;
                let middle = low + centre * (high - low);
                let reach = 1.5 * width * (high - low);
                let range = [middle - reach, middle + reach];
                along.one(
                    acts,
                    "bump",
                    range,
                    format!("{} near one wavelength", word(acts)),
                    move |row| (-0.5 * ((place(row) - centre) / width).powi(2)).exp(),
                );
            }
        }
        let columns: Vec<_> = (1..=4)
            .map(|k| {
                let turn = std::f64::consts::PI * f64::from(k);
                along.column(acts, move |_, row| (turn * place(row)).cos())
            })
            .collect();
        along.add(
            "smooth",
            [low, high],
            format!("{} that varies smoothly", word(acts)),
            columns,
        );
    }
    for step in 1..12 {
        let edge = f64::from(step) / 12.0;
        let from = low + edge * (high - low);
        along.relative(
            "jump",
            [from, high],
            "a relative change beyond one wavelength",
            move |row| f64::from(place(row) > edge),
        );
    }
}
