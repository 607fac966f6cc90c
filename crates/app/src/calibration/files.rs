//! The files of a calibration.

use std::fmt::Write as _;

use camino::Utf8Path;
use isolux_record::Standard;
use isolux_record::spectra::parse_calibration;
use isolux_report::plots::{FactorDrift, factor_drift};

use super::document::{Calibration, FACTORS, Outcome};
use crate::{Failure, files};

/// Names and bytes: the factors with their uncertainty, everything as JSON, the lines for the station, the drift as a
/// picture, and the certificate.
///
/// # Errors
/// Bad input (exit 2) for a certificate that cannot be read any more; exit 3 for factors that no station would read.
pub(super) fn of(
    calibration: &Calibration,
    standard: &Standard,
    certificate: &Utf8Path,
) -> Result<Vec<(String, Vec<u8>)>, Failure> {
    let mut made: Vec<(String, Vec<u8>)> = Vec::new();
    if let Outcome::Spectroradiometer(factors) = &calibration.outcome {
        let text = factor_file(calibration, factors);
        parse_calibration(Utf8Path::new(FACTORS), &text).map_err(Failure::instrument)?;
        made.push((FACTORS.to_owned(), text.into_bytes()));
        let former = factors.drift.u_former_rel;
        let drift: Vec<FactorDrift> = (0..factors.wavelength_nm.len())
            .filter_map(|place| {
                Some(FactorDrift {
                    wavelength_nm: factors.wavelength_nm[place],
                    change_rel: factors.drift.relative[place]?,
                    expanded_rel: 2.0 * factors.u_rel_at(place).hypot(former.unwrap_or(0.0)),
                })
            })
            .collect();
        if !drift.is_empty() {
            let title = format!("New factors of {} against the former ones", calibration.calibrated);
            made.push(("drift.svg".to_owned(), factor_drift(&drift, &title).into_bytes()));
        }
    }
    let json = serde_json::to_string_pretty(calibration).map_err(Failure::instrument)?;
    made.push(("calibration.json".to_owned(), (json + "\n").into_bytes()));
    let lines = calibration.station_lines().join("\n") + "\n";
    made.push(("station-lines.toml".to_owned(), lines.into_bytes()));
    made.push(("standard.toml".to_owned(), files::read(certificate)?));
    if let Some((spectral, _)) = standard.spectral() {
        let name = &spectral.table;
        let table = files::read(&certificate.parent().unwrap_or(Utf8Path::new("")).join(name))?;
        let name = Utf8Path::new(name).file_name().unwrap_or("standard.csv");
        made.push((name.to_owned(), table));
    }
    Ok(made)
}

/// The table that a station reads: comments, wavelength and factor, and the uncertainty by cause.
fn factor_file(calibration: &Calibration, factors: &super::SpectralFactors) -> String {
    let of = &factors.conditions;
    let mut text = format!(
        "# Spectral irradiance, W/(m² nm), of one linear count per second: {}.\n\
         # Calibrated {}, due {}, by {}.\n\
         # Standard: {}, valid until {}; SHA-256 of certificate and table {}.\n\
         # Record: SHA-256 of its run.toml {}.\n\
         # {:.4} A (certified {:.4} A), {} mm (certified {} mm), read from {:.0} s after switching on{}.\n\
         # {} s at the longest; linear within {:.2e}, behind the baffle {:.2e} of the light, light changed by {:.1e}.\n\
         # Corrected by: {}\n\
         # wavelength_nm: as the instrument states it.\n\
         # u_…: relative standard uncertainties (k = 1) by cause. What wavelengths share of each is in \
         calibration.json.\n",
        of.instrument,
        calibration.calibrated,
        calibration.due,
        calibration.program,
        of.standard,
        of.expires,
        of.certificate_sha256,
        calibration.record_sha256,
        of.current_a,
        of.certified_current_a,
        of.distance_mm,
        of.certified_distance_mm,
        of.warm_up_s,
        of.ambient_c
            .map_or_else(String::new, |ambient| format!(", {ambient:.1} °C")),
        factors.integration_s,
        factors.nonlinearity_rel,
        factors.stray_rel,
        factors.change_rel,
        factors.corrected_by
    );
    text += "wavelength_nm,factor,u_rel";
    for part in &factors.components {
        let _ = write!(text, ",u_{}_rel", part.name);
    }
    text.push('\n');
    for (place, nm) in factors.stated_nm.iter().enumerate() {
        let factor = factors.factor_w_m2_nm[place];
        let _ = write!(text, "{nm:.4},{factor:.6e},{:.3e}", factors.u_rel_at(place));
        for part in &factors.components {
            let _ = write!(text, ",{:.3e}", part.u_rel(place));
        }
        text.push('\n');
    }
    text
}
