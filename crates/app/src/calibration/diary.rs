//! A calibration in the diary of its bench.

use camino::Utf8Path;
use jiff::Timestamp;

use super::document::{Calibration, Outcome};
use crate::history::{Entry, Kind};

/// Wavelengths of the factors of a spectroradiometer that are followed, nm.
const AT_NM: [f64; 3] = [450.0, 555.0, 650.0];

/// Its lines; `run` is the record as it was called.
pub(super) fn entries(run: &Utf8Path, calibration: &Calibration) -> Vec<Entry> {
    let entry = |quantity: String, value: f64, unit: &str, u: f64| Entry {
        time_utc: Timestamp::now().to_string(),
        kind: Kind::Calibration,
        quantity,
        value,
        unit: unit.to_owned(),
        u,
        run: run.to_string(),
        record_sha256: calibration.record_sha256.clone(),
    };
    match &calibration.outcome {
        Outcome::Spectroradiometer(factors) => {
            let last = factors.wavelength_nm.len().saturating_sub(1);
            let at = |nm: f64| {
                let place = factors.wavelength_nm.partition_point(|at| *at < nm).min(last);
                let value = factors.factor_w_m2_nm[place];
                let quantity = format!("spectroradiometer: factor at {nm:.0} nm");
                entry(
                    quantity,
                    value,
                    "W/(m² nm) of one count a second",
                    value * factors.u_rel_at(place),
                )
            };
            AT_NM.map(at).to_vec()
        }
        Outcome::Luxmeter(factor) => {
            let value = factor.calibration_factor;
            vec![entry("luxmeter: factor".to_owned(), value, "", value * factor.u_rel)]
        }
    }
}
