//! The lux meter of a station: its calibration, and what is known of how it answers light that is not that of its
//! calibration.

use serde::{Deserialize, Serialize};

use super::parts::{FRACTION, MOST_U_REL, driver_and_target};
use crate::document::Fault;
use crate::document::bounds::within;

/// The lux meter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LuxMeter {
    /// `driver:target`.
    pub open: String,
    /// Serial number that the instrument must answer with, where its language has a word for it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub serial: Option<String>,
    /// Certificate's factor: true illuminance ÷ shown illuminance.
    pub calibration_factor: f64,
    /// Relative standard uncertainty of the calibration (k = 1).
    pub u_rel: f64,
    /// Relative standard deviation of one reading, of the meter and of the lamp together: what `isolux plan` counts as
    /// noise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise_rel: Option<f64>,
    /// Standard deviation of one reading without light.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise_lx: Option<f64>,
    /// Number of the certificate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub certificate: Option<String>,
    /// Day of the calibration, YYYY-MM-DD.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub calibrated: Option<String>,
    /// Day the calibration is due again, YYYY-MM-DD.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub due: Option<String>,
    /// CSV beside the station: relative spectral responsivity of the head, `wavelength_nm`, `responsivity` and its
    /// relative standard uncertainty `u_rel`. With it and a spectrum of the lamp readings are corrected by F*.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub responsivity: Option<String>,
    /// CSV beside the station: the light under which `calibration_factor` holds, `wavelength_nm` and `power`; without
    /// it CIE standard illuminant A.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub calibration_light: Option<String>,
    /// General V(λ) mismatch index f1′ as a fraction, for a head whose `responsivity` is not known; 0 for a meter that
    /// weighs a spectrum by V(λ).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub f1_prime_rel: Option<f64>,
    /// How its responsivity follows its temperature.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub temperature: Option<Temperature>,
    /// How its readings depart from proportion to the light.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub linearity: Option<Linearity>,
    /// How it answers light that does not come along its normal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cosine: Option<Cosine>,
    /// What light takes from its responsivity for a while.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fatigue: Option<Fatigue>,
}

/// Temperature dependence (ISO/CIE 19476, f6,T): a reading is too large by 1 + coefficient · (T − reference).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Temperature {
    /// Relative change of a reading for one kelvin.
    pub coefficient_per_k: f64,
    /// Its standard uncertainty (k = 1).
    pub u_coefficient_per_k: f64,
    /// Temperature at which the meter was calibrated, °C.
    pub reference_c: f64,
    /// Standard uncertainty of the meter's temperature as the room's thermometer gives it (k = 1), K.
    pub u_temperature_k: f64,
    /// Largest difference from `reference_c`, K: for a run that records no temperature.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_difference_k: Option<f64>,
}

/// Linearity (ISO/CIE 19476, f3): true over shown illuminance, linear over the logarithm of the illuminance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Linearity {
    /// Illuminance as it is recorded, with the calibration factor and without offset, rising, lx.
    pub illuminance_lx: Vec<f64>,
    /// True over recorded illuminance at each.
    pub factor: Vec<f64>,
    /// Relative standard uncertainty of these factors (k = 1).
    pub u_rel: f64,
}

/// Directional response (ISO/CIE 19476, f2): over the cosine of the angle of incidence, and over that of light along
/// the normal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cosine {
    /// Angles of incidence, from 0 on rising, degrees.
    pub angle_deg: Vec<f64>,
    /// Response at each: 1 at 0°.
    pub response_rel: Vec<f64>,
    /// Its relative standard uncertainty at each (k = 1): 0 at 0°.
    pub u_rel: Vec<f64>,
}

/// Fatigue (ISO/CIE 19476, f5): under steady light the responsivity falls exponentially to a loss in proportion to the
/// light, and comes back likewise.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fatigue {
    /// Relative loss under `at_lx` in the end.
    pub loss_rel: f64,
    /// Its standard uncertainty (k = 1).
    pub u_loss_rel: f64,
    /// Illuminance under which it was found, lx.
    pub at_lx: f64,
    /// Time constant of loss and recovery, s.
    pub time_constant_s: f64,
}

impl LuxMeter {
    /// Checks the table.
    pub(super) fn check(&self) -> Result<(), Fault> {
        driver_and_target("luxmeter.open", &self.open)?;
        within("luxmeter.calibration_factor", self.calibration_factor, 1e-3..=1e3, "")?;
        within("luxmeter.u_rel", self.u_rel, 0.0..=MOST_U_REL, FRACTION)?;
        within("luxmeter.noise_rel", self.noise_rel, 0.0..=MOST_U_REL, " (a fraction)")?;
        within("luxmeter.noise_lx", self.noise_lx, 0.0..=1e3, " lx")?;
        self.check_spectral()?;
        self.temperature.as_ref().map_or(Ok(()), Temperature::check)?;
        self.linearity.as_ref().map_or(Ok(()), Linearity::check)?;
        self.cosine.as_ref().map_or(Ok(()), Cosine::check)?;
        self.fatigue.as_ref().map_or(Ok(()), Fatigue::check)
    }

    fn check_spectral(&self) -> Result<(), Fault> {
        for (key, file) in [
            ("luxmeter.responsivity", &self.responsivity),
            ("luxmeter.calibration_light", &self.calibration_light),
        ] {
            if file.as_ref().is_some_and(|file| file.trim().is_empty()) {
                return Err(Fault::new(key, "is empty; name a CSV file beside the station"));
            }
        }
        // Above it a detector is none that reads lux.
        let unit = " (a fraction: 0.03 is 3 %)";
        within("luxmeter.f1_prime_rel", self.f1_prime_rel, 0.0..=0.3, unit)?;
        if self.responsivity.is_some() && self.f1_prime_rel.is_some() {
            return Err(Fault::new(
                "luxmeter.f1_prime_rel",
                "is that of `responsivity`; remove one of the two keys",
            ));
        }
        if self.responsivity.is_none() && self.calibration_light.is_some() {
            return Err(Fault::new(
                "luxmeter.calibration_light",
                "says nothing without `responsivity`; state the head's curve, or remove this key",
            ));
        }
        Ok(())
    }
}

impl Temperature {
    fn check(&self) -> Result<(), Fault> {
        let key = |name: &str| format!("luxmeter.temperature.{name}");
        within(
            &key("coefficient_per_k"),
            self.coefficient_per_k,
            -0.02..=0.02,
            " (a fraction)",
        )?;
        within(
            &key("u_coefficient_per_k"),
            self.u_coefficient_per_k,
            0.0..=0.02,
            " (a fraction)",
        )?;
        within(&key("reference_c"), self.reference_c, -20.0..=60.0, " °C")?;
        within(&key("u_temperature_k"), self.u_temperature_k, 0.0..=20.0, " K")?;
        within(&key("max_difference_k"), self.max_difference_k, 0.0..=50.0, " K")
    }
}

impl Linearity {
    fn check(&self) -> Result<(), Fault> {
        let key = |name: &str| format!("luxmeter.linearity.{name}");
        table(
            &key("illuminance_lx"),
            &self.illuminance_lx,
            &[(&key("factor"), &self.factor)],
        )?;
        for (lux, factor) in self.illuminance_lx.iter().zip(&self.factor) {
            within(&key("illuminance_lx"), *lux, 1e-6..=1e6, " lx")?;
            within(&key("factor"), *factor, 0.5..=2.0, "")?;
        }
        within(&key("u_rel"), self.u_rel, 0.0..=MOST_U_REL, FRACTION)
    }
}

impl Cosine {
    fn check(&self) -> Result<(), Fault> {
        let key = |name: &str| format!("luxmeter.cosine.{name}");
        let (response, u) = (key("response_rel"), key("u_rel"));
        table(
            &key("angle_deg"),
            &self.angle_deg,
            &[(&response, &self.response_rel), (&u, &self.u_rel)],
        )?;
        if self.angle_deg.first() != Some(&0.0) || self.response_rel.first() != Some(&1.0) {
            return Err(Fault::new(key("angle_deg"), "begins with 0, where response_rel is 1"));
        }
        for place in 0..self.angle_deg.len() {
            within(&key("angle_deg"), self.angle_deg[place], 0.0..=89.0, "°")?;
            within(&response, self.response_rel[place], 0.1..=2.0, "")?;
            within(&u, self.u_rel[place], 0.0..=MOST_U_REL, FRACTION)?;
        }
        Ok(())
    }
}

impl Fatigue {
    fn check(&self) -> Result<(), Fault> {
        let key = |name: &str| format!("luxmeter.fatigue.{name}");
        within(&key("loss_rel"), self.loss_rel, -0.1..=0.1, " (a fraction)")?;
        within(&key("u_loss_rel"), self.u_loss_rel, 0.0..=0.1, " (a fraction)")?;
        within(&key("at_lx"), self.at_lx, 1e-3..=1e6, " lx")?;
        within(&key("time_constant_s"), self.time_constant_s, 1.0..=1e6, " s")
    }
}

/// Lists of at least two numbers, as many of each, the first one rising.
fn table(key: &str, rising: &[f64], others: &[(&str, &[f64])]) -> Result<(), Fault> {
    // A number that is none rises nowhere.
    if rising.len() < 2 || !rising.windows(2).all(|pair| pair[0] < pair[1]) {
        return Err(Fault::new(key, "needs at least two numbers that rise"));
    }
    match others.iter().find(|(_, other)| other.len() != rising.len()) {
        Some((other, values)) => Err(Fault::new(
            *other,
            format!("has {} numbers where {key} has {}", values.len(), rising.len()),
        )),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use camino::Utf8Path;

    use crate::station::Station;
    use crate::station::tests::STATION;

    const TABLES: &str = "[luxmeter.temperature]
coefficient_per_k = -0.0008
u_coefficient_per_k = 0.0002
reference_c = 23.0
u_temperature_k = 0.5
max_difference_k = 4.0
[luxmeter.linearity]
illuminance_lx = [1.0, 100.0, 1000.0]
factor = [1.0, 1.001, 1.004]
u_rel = 0.0005
[luxmeter.cosine]
angle_deg = [0, 10, 20]
response_rel = [1, 0.999, 0.996]
u_rel = [0, 0.0005, 0.001]
[luxmeter.fatigue]
loss_rel = 0.002
u_loss_rel = 0.0005
at_lx = 1000.0
time_constant_s = 600.0
";

    fn parse(from: &str, to: &str) -> Result<Station, String> {
        assert!(TABLES.contains(from), "{from}");
        let tables = TABLES.replacen(from, to, 1);
        let text = STATION.replace("[lamp]\n", &format!("{tables}[lamp]\n"));
        Station::parse(Utf8Path::new("s.toml"), &text).map_err(|error| error.to_string())
    }

    #[test]
    fn what_a_meter_does_is_read_and_written_the_same() {
        let station = parse("", "").unwrap();
        assert_eq!(
            station.luxmeter().cosine.as_ref().unwrap().response_rel,
            [1.0, 0.999, 0.996]
        );
        let written = toml::to_string(&station).unwrap();
        assert_eq!(Station::parse(Utf8Path::new("again.toml"), &written).unwrap(), station);
    }

    #[test]
    fn what_no_meter_does_is_refused_with_its_line() {
        for (from, to, expected) in [
            (
                "-0.0008",
                "-0.08",
                "s.toml:28:1: luxmeter.temperature.coefficient_per_k: is -0.08",
            ),
            ("0.0002", "0.2", "luxmeter.temperature.u_coefficient_per_k"),
            ("23.0", "230.0", "luxmeter.temperature.reference_c: is 230"),
            (
                "u_temperature_k = 0.5",
                "u_temperature_k = -1.0",
                "luxmeter.temperature.u_temperature_k",
            ),
            ("4.0", "400.0", "luxmeter.temperature.max_difference_k"),
            ("reference_c = 23.0\n", "", "missing field `reference_c`"),
            (
                "[1.0, 100.0, 1000.0]",
                "[100.0, 1.0, 1000.0]",
                "illuminance_lx: needs at least two numbers that rise",
            ),
            (
                "[1.0, 100.0, 1000.0]",
                "[1.0, nan, 1000.0]",
                "illuminance_lx: needs at least two numbers that rise",
            ),
            (
                "[1.0, 100.0, 1000.0]",
                "[1.0, 1000.0]",
                "luxmeter.linearity.factor: has 3 numbers where",
            ),
            (
                "[1.0, 100.0, 1000.0]",
                "[0.0, 100.0, 1000.0]",
                "luxmeter.linearity.illuminance_lx: is 0",
            ),
            ("1.004]", "10.04]", "luxmeter.linearity.factor: is 10.04"),
            ("u_rel = 0.0005", "u_rel = 5.0", "luxmeter.linearity.u_rel: is 5"),
            ("[0, 10, 20]", "[5, 10, 20]", "luxmeter.cosine.angle_deg: begins with 0"),
            ("[0, 10, 20]", "[0, 10, 95]", "luxmeter.cosine.angle_deg: is 95"),
            (
                "[1, 0.999, 0.996]",
                "[1, 0.999]",
                "luxmeter.cosine.response_rel: has 2 numbers where",
            ),
            ("0.996]", "9.96]", "luxmeter.cosine.response_rel: is 9.96"),
            (
                "[0, 0.0005, 0.001]",
                "[0, 0.0005]",
                "luxmeter.cosine.u_rel: has 2 numbers",
            ),
            ("0.001]", "-0.001]", "luxmeter.cosine.u_rel: is -0.001"),
            (
                "loss_rel = 0.002",
                "loss_rel = 0.2",
                "luxmeter.fatigue.loss_rel: is 0.2",
            ),
            ("u_loss_rel = 0.0005", "u_loss_rel = 0.5", "luxmeter.fatigue.u_loss_rel"),
            ("at_lx = 1000.0", "at_lx = 0.0", "luxmeter.fatigue.at_lx: is 0"),
            (
                "time_constant_s = 600.0",
                "time_constant_s = 0.0",
                "luxmeter.fatigue.time_constant_s: is 0",
            ),
        ] {
            let message = parse(from, to).unwrap_err();
            assert!(
                message.starts_with("s.toml:") && message.contains(expected),
                "{to}: {message}"
            );
        }
    }
}
