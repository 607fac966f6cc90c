//! What the lamp took from its supply while its light was read, and how much light it made of that.

use isolux_record::{Electrical as Line, Reading, Station};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Quantity;

/// The supply line over the readings of the distribution.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Electrical {
    /// Readings with a power.
    pub readings: usize,
    /// RMS voltage (mean for DC).
    pub voltage_v: Option<Over>,
    /// RMS current (mean for DC).
    pub current_a: Option<Over>,
    /// Active power.
    pub power_w: Over,
    /// Active power ÷ (voltage · current).
    pub power_factor: Option<Over>,
    /// The mean active power, in W.
    pub power: Quantity,
    /// Luminous flux ÷ mean active power, in lm/W.
    pub luminous_efficacy: Quantity,
}

/// One quantity over the readings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Over {
    /// Mean.
    pub mean: f64,
    /// Smallest.
    pub least: f64,
    /// Largest.
    pub most: f64,
}

impl Over {
    fn of(values: &[f64]) -> Option<Self> {
        let fold = |first, pick: fn(f64, f64) -> f64| values.iter().copied().fold(first, pick);
        (!values.is_empty()).then(|| Self {
            mean: values.iter().sum::<f64>() / values.len() as f64,
            least: fold(f64::INFINITY, f64::min),
            most: fold(f64::NEG_INFINITY, f64::max),
        })
    }
}

impl Electrical {
    /// Of the readings of the distribution; none where none of them has a power.
    pub fn of(rows: &[&Reading], station: &Station, flux: &Quantity) -> Option<Self> {
        let values = |pick: fn(&Line) -> Option<f64>| -> Vec<f64> {
            rows.iter().filter_map(|row| pick(&row.electrical)).collect()
        };
        let watts = values(|line| line.power_w);
        let power_w = Over::of(&watts)?;
        let stated = station.powermeter().and_then(|meter| meter.u_power_rel);
        let power = Quantity::new(
            power_w.mean,
            "W",
            [
                ("calibration", power_w.mean * stated.unwrap_or(0.0)),
                ("change during the readings", standard_deviation(&watts, power_w.mean)),
            ],
        );
        let power = power.lacking(stated.is_none().then(|| NO_U_POWER.to_owned()));
        Some(Self {
            readings: watts.len(),
            voltage_v: Over::of(&values(|line| line.voltage_v)),
            current_a: Over::of(&values(|line| line.current_a)),
            power_w,
            power_factor: Over::of(&values(|line| line.power_factor)),
            luminous_efficacy: flux.over(&power, "lm/W", "power"),
            power,
        })
    }
}

/// What the efficacy lacks without the meter's uncertainty.
const NO_U_POWER: &str = "the station states no powermeter.u_power_rel: uncertainty of the power";

/// Of single readings: a lamp that drifts does not average out over them.
fn standard_deviation(values: &[f64], mean: f64) -> f64 {
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (squares / (values.len().max(2) - 1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::reading;
    use isolux_any_record::STATION;

    fn station(tables: &str) -> Station {
        Station::parse("s.toml".into(), &format!("{STATION}{tables}")).unwrap()
    }

    #[test]
    fn efficacy_is_flux_over_mean_power_and_its_parts_add_in_squares() {
        let illuminated = |watts: Option<f64>| Reading {
            electrical: Line {
                voltage_v: Some(230.0),
                power_w: watts,
                ..Line::default()
            },
            ..reading(0.0, 0.0, 3.37)
        };
        let rows = [illuminated(Some(9.9)), illuminated(None), illuminated(Some(10.1))];
        let rows: Vec<&Reading> = rows.iter().collect();
        let flux = Quantity::new(1000.0, "lm", [("calibration", 8.0)]);
        let without = Electrical::of(&rows, &station(""), &flux).unwrap();
        assert_eq!(
            (without.readings, without.power_w.least, without.power_w.most),
            (2, 9.9, 10.1)
        );
        assert_eq!((without.voltage_v.unwrap().mean, without.current_a), (230.0, None));
        assert_eq!(
            (without.luminous_efficacy.value, without.luminous_efficacy.u),
            (100.0, None)
        );
        let meter = "[powermeter]\nopen = \"scpi-meter:/dev/x?profile=gpm-8213\"\nu_power_rel = 0.002\n";
        let with = Electrical::of(&rows, &station(meter), &flux).unwrap();
        // 0.8 % of the flux, 0.2 % of the meter, 0.1·√2 W of scatter on 10 W.
        let expected = 0.8_f64.hypot(0.2).hypot(2.0_f64.sqrt());
        assert!((with.luminous_efficacy.u.unwrap() - expected).abs() < 1e-9);
        assert_eq!(Electrical::of(&rows[1..2], &station(meter), &flux), None);
    }
}
