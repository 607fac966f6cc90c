//! How strong a change is above what is known: noise, and the model's own uncertainty.
//!
//! The strength is the length of what the room shows with the fault less what it shows without, whitened by the
//! covariance of the stated noise and of what the model's file states of its own uncertainty: that of single directions
//! (`common_errors`) and that of level, shape, interpolation and emitter (`known`). A meter rounds readings at the same
//! light alike, so that a hundred of them do not see a change below one digit; readings at different light it rounds
//! independently. The strength is the smaller of the two lengths.

use isolux_diagnose::assumed::{AssumedModel, Part};
use isolux_diagnose::forward::Forward;
use isolux_diagnose::reference::{Errors, joined};
use isolux_diagnose::rounding::Rounding;
use isolux_diagnose::table::Row;
use isolux_diagnose::whitener::Whitener;
use isolux_diagnose::whitening::Sequence;
use isolux_model::Model;
use isolux_record::observation::MapUnit;
use nalgebra::DVector;

use crate::truth::Places;

/// What is known of the values at some places before they are read.
#[derive(Debug)]
pub struct Known {
    /// The model with those places.
    pub assumed: AssumedModel,
    /// What the model expects.
    pub level: DVector<f64>,
    row_scale: DVector<f64>,
    errors: Errors,
    sequence: Sequence,
    independent: Rounding,
    alike: Rounding,
}

impl Known {
    /// By `model`, for the values of `rows` at `places`. None where the model cannot predict them.
    pub fn new(model: &Model, places: &Places, rows: &[Row]) -> Option<Self> {
        let (part, relative) = match places {
            Places::Readings(readings) => (Part::Readings(readings.clone()), false),
            Places::Maps(maps) => (Part::Maps(maps.clone()), maps.unit() == MapUnit::Relative),
        };
        let assumed = AssumedModel::new(model.clone(), vec![part]);
        let level = assumed.predict(&vec![0.0; assumed.nuisances()], &[])?;
        let row_scale = DVector::from_iterator(rows.len(), rows.iter().map(|row| 1.0 / row.u));
        let mut errors = joined(assumed.common_errors(), &row_scale);
        let known = Forward::known(&assumed);
        errors.extend(known.iter().map(|one| one.column.iter().copied().enumerate().collect()));
        if relative {
            // The signal that one lux gives is in no file.
            errors.push(level.iter().copied().enumerate().collect());
        }
        let alike = Rounding::new(rows, level.as_slice());
        Some(Self {
            assumed,
            level,
            row_scale,
            errors,
            sequence: Sequence::by_time(&vec![0; rows.len()], &vec![f64::NAN; rows.len()]),
            independent: Rounding::default(),
            alike,
        })
    }

    /// What makes the values independent and of unit variance.
    pub fn whitener(&self) -> Whitener<'_> {
        self.with(&self.independent)
    }

    /// What `change` is above noise and the model's own uncertainty, in σ.
    pub fn sigma(&self, change: &DVector<f64>) -> f64 {
        let length = |rounding| self.with(rounding).vector(change).norm();
        length(&self.independent).min(length(&self.alike))
    }

    fn with<'a>(&'a self, rounding: &'a Rounding) -> Whitener<'a> {
        Whitener::new(&self.sequence, rounding, self.row_scale.clone(), 0.0, &self.errors)
    }
}

/// `with` less `without`.
pub fn change(with: &[f64], without: &[f64]) -> DVector<f64> {
    DVector::from_iterator(with.len(), with.iter().zip(without).map(|(a, b)| a - b))
}

/// The strength of a fault that reaches `wanted` σ to 2 %; none where `most` does not reach it. `sigma` tells what a
/// strength reaches, and rises with it.
pub fn reaching(wanted: f64, most: f64, sigma: impl Fn(f64) -> f64) -> Option<f64> {
    let near = |reached: f64| (reached / wanted - 1.0).abs() < 0.02;
    let (mut low, mut high) = (most * 1e-9, most);
    let mut tried = 0.1 * most;
    for _ in 0..40 {
        let reached = sigma(tried);
        if near(reached) {
            return Some(tried);
        }
        if reached < wanted {
            if tried >= most {
                return None;
            }
            low = tried;
        } else {
            high = tried;
        }
        // Most changes are nearly proportional; where that leaves the bracket, or it stays empty, the middle is tried.
        let linear = tried * (wanted / reached).clamp(0.05, 20.0);
        tried = if linear >= most && high == most {
            most
        } else if linear > low && linear < high {
            linear
        } else {
            (low * high).sqrt()
        };
    }
    // A step (a converter's, a full well) may jump over the wanted value.
    None
}
