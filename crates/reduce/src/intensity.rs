//! A reading in lux as luminous intensity in the direction where it was taken.

use isolux_record::{Reading, ReadingKind, Run};

use crate::Options;
use crate::background::{Background, Subtract};
use crate::bench::Bench;
use crate::correction::Correction;
use crate::error::ReduceError;
use crate::meter::Meter;
use crate::samples::Corrected;

/// How lux becomes intensity: what is subtracted, and at which distance it counts.
#[derive(Debug)]
pub struct Conversion<'a> {
    background: &'a Background,
    meter: &'a Meter<'a>,
    /// What is corrected, by the run's own levels or by a model.
    pub corrected: Subtract,
    /// What the run's own levels correct.
    pub subtract: Subtract,
    /// Distance at which every reading counts, where the inverse square law is switched off; else each its own.
    pub counted_at_mm: Option<f64>,
    /// By row number, what a model makes of the reading.
    by_model: Option<Vec<Option<Corrected>>>,
}

impl<'a> Conversion<'a> {
    /// For the readings of `run` by `meter`, with the effects of `bench` taken out.
    ///
    /// # Errors
    /// [`ReduceError::Format`] for an effect of `bench` without inverse.
    pub fn new(
        run: &Run,
        options: &Options,
        bench: Option<&Bench>,
        background: &'a Background,
        meter: &'a Meter<'a>,
    ) -> Result<Self, ReduceError> {
        let on = |correction| !options.without.contains(&correction);
        let corrected = Subtract {
            dark: on(Correction::Dark),
            ambient: on(Correction::Ambient),
            stray: on(Correction::Stray),
        };
        let taken = bench.map(Bench::takes_over);
        let subtract = Subtract {
            dark: corrected.dark && !taken.is_some_and(|taken| taken.dark),
            ambient: corrected.ambient && !taken.is_some_and(|taken| taken.ambient),
            stray: corrected.stray && !taken.is_some_and(|taken| taken.stray),
        };
        let by_model = bench.map(|bench| inverted(bench, &run.readings.rows, background, subtract));
        Ok(Self {
            background,
            meter,
            corrected,
            subtract,
            counted_at_mm: (!on(Correction::InverseSquare)).then(|| run.header.station.bench().distance_mm),
            by_model: by_model.transpose()?,
        })
    }

    /// Intensity of a lit reading of `lux`.
    pub fn intensity(&self, row: &Reading, lux: f64) -> Corrected {
        let read = self.as_read(row, lux);
        let factor = self.meter.factor(read.c_deg, read.gamma_deg, row.distance_mm);
        Corrected {
            intensity_cd: factor * read.intensity_cd,
            cd_per_lx: factor * read.cd_per_lx,
            ..read
        }
    }

    /// The same as the meter weighs the light.
    fn as_read(&self, row: &Reading, lux: f64) -> Corrected {
        let by_model = self.by_model.as_ref();
        if let Some(corrected) = by_model.and_then(|corrected| corrected[row.index as usize]) {
            return corrected;
        }
        let metres = self.counted_at_mm.unwrap_or(row.distance_mm) * 1e-3;
        let cd_per_lx = metres * metres;
        Corrected {
            intensity_cd: (lux - self.background.subtracted_lx(row.gamma_deg, self.subtract)) * cd_per_lx,
            cd_per_lx,
            c_deg: row.c_deg,
            gamma_deg: row.gamma_deg,
        }
    }
}

/// Every lit reading through the model's inverse at once, by row number. What the run itself measured of offset and
/// stray light is taken off first where the model has no effect for it.
fn inverted(
    bench: &Bench,
    all: &[Reading],
    background: &Background,
    subtract: Subtract,
) -> Result<Vec<Option<Corrected>>, ReduceError> {
    let illuminated: Vec<(&Reading, f64)> = all
        .iter()
        .filter(|row| row.kind == ReadingKind::Lit)
        .filter_map(|row| {
            row.illuminance_lx
                .map(|lux| (row, lux - background.subtracted_lx(row.gamma_deg, subtract)))
        })
        .collect();
    let rows: Vec<&Reading> = illuminated.iter().map(|(row, _)| *row).collect();
    let lux: Vec<f64> = illuminated.iter().map(|(_, lux)| *lux).collect();
    let corrected = bench.correct(&rows, &lux).map_err(|error| ReduceError::Format {
        file: "--with model",
        message: error.to_string(),
    })?;
    let mut by_row = vec![None; all.len()];
    for (row, corrected) in rows.iter().zip(corrected) {
        if let Some(place) = by_row.get_mut(row.index as usize) {
            *place = Some(corrected);
        }
    }
    Ok(by_row)
}
