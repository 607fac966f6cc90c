//! Patterns along the wavelength of spectra.

use super::{Builder, word};
use crate::pattern::Acts;
use crate::table::{Coordinate, Row, Source};

pub(super) fn wavelength(build: &mut Builder<'_>) {
    let samples = build.distinct(Source::Sample, Coordinate::WavelengthNm);
    let (Some(&low), Some(&high)) = (samples.first(), samples.last()) else {
        return;
    };
    if high <= low {
        return;
    }
    let place = move |row: &Row| (row.wavelength_nm - low) / (high - low);
    for acts in [Acts::Relative, Acts::Everywhere] {
        for width in [0.03, 0.1] {
            let count = (0.7 / width) as usize;
            for k in 0..=count {
                let centre = k as f64 / count as f64;
                let column = build.column(Source::Sample, acts, move |_, row| {
                    (-0.5 * ((place(row) - centre) / width).powi(2)).exp()
                });
                let middle = low + centre * (high - low);
                let reach = 1.5 * width * (high - low);
                let note = format!("{} near one wavelength", word(acts));
                build.add(
                    Coordinate::WavelengthNm,
                    "bump",
                    [middle - reach, middle + reach],
                    note,
                    vec![column],
                );
            }
        }
        let columns: Vec<_> = (1..=4)
            .map(|k| {
                let turn = std::f64::consts::PI * f64::from(k);
                build.column(Source::Sample, acts, move |_, row| (turn * place(row)).cos())
            })
            .collect();
        let note = format!("{} that varies smoothly", word(acts));
        build.add(Coordinate::WavelengthNm, "smooth", [low, high], note, columns);
    }
    for step in 1..12 {
        let edge = f64::from(step) / 12.0;
        let column = build.column(Source::Sample, Acts::Relative, move |_, row| {
            f64::from(place(row) > edge)
        });
        let from = low + edge * (high - low);
        build.add(
            Coordinate::WavelengthNm,
            "jump",
            [from, high],
            "a relative change beyond one wavelength",
            vec![column],
        );
    }
}
