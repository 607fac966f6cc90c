//! Whether a run was under the conditions of the certificate.

use isolux_record::plan::Instrument;
use isolux_record::run::StopHow;
use isolux_record::{Reading, ReadingKind, Run, Standard, Station};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::DISTANCE_RATIO_MAX;
use super::error::CalibrationError;

/// Correlated colour temperature of illuminant A, K.
const ILLUMINANT_A_K: f64 = 2856.0;
/// A standard is as good as illuminant A within this, K.
const TOLERANCE_K: f64 = 20.0;

/// Under what a calibration was made.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Conditions {
    /// UTC day of the record, YYYY-MM-DD.
    pub day: String,
    /// The lamp and its certificate.
    pub standard: String,
    /// SHA-256 of the certificate and its table.
    pub certificate_sha256: String,
    /// Last day of the certificate.
    pub expires: String,
    /// Model and serial number of the instrument.
    pub instrument: String,
    /// Distance of the readings.
    pub distance_mm: f64,
    /// Distance of the certificate.
    pub certified_distance_mm: f64,
    /// Mean current of the lamp while it was read.
    pub current_a: f64,
    /// That of the certificate.
    pub certified_current_a: f64,
    /// Relative standard uncertainty of the current: the power meter's, and the difference from the certificate.
    pub u_current_rel: f64,
    /// Seconds from switching on to the first reading.
    pub warm_up_s: f64,
    /// Mean room temperature, where it was measured.
    pub ambient_c: Option<f64>,
}

/// An instrument that is calibrated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Calibrated {
    /// By spectral irradiance.
    Spectroradiometer,
    /// By illuminance.
    Luxmeter,
}

impl Calibrated {
    /// Its table in a station.
    pub const fn role(self) -> &'static str {
        match self {
            Self::Spectroradiometer => "spectroradiometer",
            Self::Luxmeter => "luxmeter",
        }
    }
}

/// What a station and a certificate state that a calibration needs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stated {
    /// Distance of the certificate.
    pub certified_distance_mm: f64,
    /// Standard uncertainty of the distance on the bench.
    pub u_distance_mm: f64,
    /// Relative standard uncertainty of the power meter's current.
    pub u_current_rel: f64,
    /// Standard uncertainty of the wavelength scale; 0 of a lux meter.
    pub u_wavelength_nm: f64,
    /// Relative standard uncertainty from the direction of the lamp in its mount and of the bench: light falls with the
    /// cosine of the angle, whose mean loss over two directions of u each is u².
    pub alignment_rel: f64,
}

/// What a calibration at `distance_mm` on `day` (YYYY-MM-DD) needs of its station and certificate: it can be asked
/// before anything is opened.
///
/// # Errors
/// [`CalibrationError`] for a certificate that states no such quantity or does not hold on that day, an uncertainty
/// that the station does not state, a distance too far from the certified one.
pub fn stated(
    what: Calibrated,
    station: &Station,
    standard: &Standard,
    distance_mm: f64,
    day: &str,
) -> Result<Stated, CalibrationError> {
    let need = |value: Option<f64>, key| value.ok_or(CalibrationError::Missing(key));
    let (certified_mm, u_distance_mm, u_wavelength_nm) = match what {
        Calibrated::Spectroradiometer => {
            let spectral = standard.spectral();
            let (certified, _) = spectral.ok_or(CalibrationError::NotCertified("spectral irradiance"))?;
            let of = station
                .spectroradiometer()
                .ok_or(CalibrationError::NoSpectroradiometer)?;
            let u_distance_mm = need(of.u_distance_mm, "spectroradiometer.u_distance_mm")?;
            let u_wavelength_nm = need(of.u_wavelength_nm, "spectroradiometer.u_wavelength_nm")?;
            (certified.distance_mm, u_distance_mm, u_wavelength_nm)
        }
        Calibrated::Luxmeter => {
            let certified = standard.illuminance();
            let certified = certified.ok_or(CalibrationError::NotCertified("illuminance"))?;
            let found_k = certified.colour_temperature_k;
            if (found_k - ILLUMINANT_A_K).abs() > TOLERANCE_K {
                return Err(CalibrationError::ColourTemperature {
                    found_k,
                    tolerance_k: TOLERANCE_K,
                });
            }
            let u_distance_mm = need(station.bench().u_distance_mm, "bench.u_distance_mm")?;
            (certified.distance_mm, u_distance_mm, 0.0)
        }
    };
    valid_on(standard, day)?;
    let ratio = distance_mm / certified_mm;
    if ratio.max(1.0 / ratio) > DISTANCE_RATIO_MAX {
        return Err(CalibrationError::Distance {
            found_mm: distance_mm,
            certified_mm,
            most: DISTANCE_RATIO_MAX,
        });
    }
    let u_gamma_deg = need(station.bench().u_gamma_deg, "bench.u_gamma_deg")?;
    let meter = station.powermeter().and_then(|meter| meter.u_current_rel);
    let u_deg = standard.document().conditions.u_alignment_deg.hypot(u_gamma_deg);
    Ok(Stated {
        certified_distance_mm: certified_mm,
        u_distance_mm,
        u_current_rel: need(meter, "powermeter.u_current_rel")?,
        u_wavelength_nm,
        alignment_rel: u_deg.to_radians().powi(2),
    })
}

impl Conditions {
    /// Checks that the run is finished, and as [`stated`] and at the certificate's current.
    ///
    /// # Errors
    /// [`CalibrationError`] with the first that does not hold.
    pub fn of(
        what: Calibrated,
        run: &Run,
        standard: &Standard,
        distance_mm: f64,
    ) -> Result<(Self, Stated), CalibrationError> {
        let completed = run.header.stopped.as_ref().map(|stopped| stopped.how) == Some(StopHow::Completed);
        if !completed {
            return Err(CalibrationError::Unfinished);
        }
        let day: String = run.header.started_utc.chars().take(10).collect();
        let stated = stated(what, &run.header.station, standard, distance_mm, &day)?;
        let conditions = &standard.document().conditions;
        let current_a = current_a(run, standard)?;
        let device = run.header.device.iter().find(|device| device.role == what.role());
        let instrument = device.map_or_else(String::new, |device| {
            format!("{} {}", device.model, device.serial.as_deref().unwrap_or(""))
        });
        let warm_up_s = lit(run).filter_map(Reading::lamp_age_s).fold(f64::INFINITY, f64::min);
        let ambient: Vec<f64> = run.readings.rows.iter().filter_map(|row| row.ambient_c).collect();
        let conditions = Self {
            day,
            standard: standard.name(),
            certificate_sha256: standard.sha256().to_owned(),
            expires: standard.document().certificate.expires.clone(),
            instrument: instrument.trim().to_owned(),
            distance_mm,
            certified_distance_mm: stated.certified_distance_mm,
            current_a,
            certified_current_a: conditions.current_a,
            u_current_rel: stated.u_current_rel.hypot(current_a / conditions.current_a - 1.0),
            warm_up_s,
            ambient_c: (!ambient.is_empty()).then(|| ambient.iter().sum::<f64>() / ambient.len() as f64),
        };
        Ok((conditions, stated))
    }
}

fn valid_on(standard: &Standard, day: &str) -> Result<(), CalibrationError> {
    let certificate = &standard.document().certificate;
    if *certificate.expires < *day {
        return Err(CalibrationError::Expired {
            expires: certificate.expires.clone(),
            day: day.to_owned(),
        });
    }
    if *certificate.issued > *day {
        return Err(CalibrationError::NotYetIssued {
            issued: certificate.issued.clone(),
            day: day.to_owned(),
        });
    }
    Ok(())
}

/// Readings of the lux meter in the light of the lamp.
pub(super) fn lit(run: &Run) -> impl Iterator<Item = &Reading> {
    of_kind(run, ReadingKind::Lit)
}

/// Readings of the lux meter of one kind, those of its blocks.
pub(super) fn of_kind(run: &Run, kind: ReadingKind) -> impl Iterator<Item = &Reading> {
    let blocks = run.header.plan.blocks();
    run.readings.rows.iter().filter(move |row| {
        let of_meter = |name: &str| {
            let mut blocks = blocks.iter();
            blocks.any(|block| block.name == name && block.instrument == Instrument::Luxmeter)
        };
        row.kind == kind && of_meter(&row.block)
    })
}

/// Mean current of the lit lamp, each within the tolerance of the certificate, A.
fn current_a(run: &Run, standard: &Standard) -> Result<f64, CalibrationError> {
    let conditions = &standard.document().conditions;
    let (mut sum, mut count) = (0.0, 0.0);
    for row in lit(run) {
        let Some(found_a) = row.electrical.current_a else {
            continue;
        };
        if (found_a - conditions.current_a).abs() > conditions.current_tolerance_a {
            return Err(CalibrationError::Current {
                row: row.index,
                found_a,
                certified_a: conditions.current_a,
                tolerance_a: conditions.current_tolerance_a,
            });
        }
        sum += found_a;
        count += 1.0;
    }
    if count == 0.0 {
        return Err(CalibrationError::NoCurrent);
    }
    Ok(sum / count)
}
