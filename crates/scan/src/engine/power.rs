//! Scans with a power meter in the lamp's supply line.

use std::time::Duration;

use async_trait::async_trait;
use isolux_device::{DeviceError, Identity, PowerMeter, PowerReading, Quantity};
use isolux_record::Electrical;
use isolux_record::run::Run;
use tokio::time::{Instant, sleep_until};

use super::tests::{DAY, scan};
use crate::cancel::Cancel;
use crate::error::{ScanError, ScanErrorKind};
use crate::testing::{bench, plan, run_dir};

/// A power meter on 24 V and a lamp of 10 W.
struct Fake {
    identity: Identity,
    began: Instant,
    /// Relative change of the power in an hour.
    drift_per_h: f64,
    over_range: bool,
    /// It answers no more after this.
    silent_after: Duration,
}

impl Fake {
    fn new() -> Self {
        Self {
            identity: Identity {
                driver: "fake",
                target: "fake:power".to_owned(),
                model: "fake".to_owned(),
                serial: None,
                firmware: None,
            },
            began: Instant::now(),
            drift_per_h: 0.0,
            over_range: false,
            silent_after: Duration::MAX,
        }
    }
}

#[async_trait]
impl PowerMeter for Fake {
    fn identity(&self) -> &Identity {
        &self.identity
    }

    fn update_interval(&self) -> Duration {
        Duration::from_millis(250)
    }

    async fn read(&self, not_before: Instant, deadline: Instant) -> Result<PowerReading, DeviceError> {
        let began = not_before.max(Instant::now());
        let ended = began + self.update_interval();
        if ended.duration_since(self.began) > self.silent_after {
            sleep_until(deadline).await;
            return Err(DeviceError::Timeout {
                device: self.identity.target.clone(),
                action: "read".to_owned(),
                waited: Duration::from_secs(5),
                received: Vec::new(),
            });
        }
        sleep_until(ended).await;
        let hours = ended.duration_since(self.began).as_secs_f64() / 3600.0;
        let power = if self.over_range {
            Quantity::OverRange
        } else {
            Quantity::Measured(10.0 * (1.0 + self.drift_per_h * hours))
        };
        Ok(PowerReading {
            voltage: Quantity::Measured(24.0),
            current: Quantity::Measured(0.4),
            power,
            power_factor: Quantity::NoData,
            began,
            ended,
            steady: true,
            retries: 1,
            evidence: Vec::new(),
        })
    }
}

/// What the day came to with this power meter, under these limits, and the rows that it left.
async fn day(meter: Fake, limits: &str) -> (Result<u64, ScanError>, Run) {
    let (mut devices, _room) = bench();
    devices.power = Some(Box::new(meter));
    let plan = plan(&format!("{limits}{DAY}"));
    let (_keep, path, mut run) = run_dir(&devices, &plan);
    let outcome = scan(&mut devices, &plan, &mut run, &Cancel::new(), None).await;
    (outcome.map(|summary| summary.retries), Run::read(&path).unwrap())
}

#[tokio::test(start_paused = true)]
async fn every_row_has_the_supply_line_and_no_word_becomes_a_number() {
    let (outcome, run) = day(Fake::new(), "").await;
    let rows = run.readings.rows;
    assert!(outcome.unwrap() >= rows.len() as u64, "what was asked again is counted");
    let expected = Electrical {
        voltage_v: Some(24.0),
        current_a: Some(0.4),
        power_w: Some(10.0),
        power_factor: None,
    };
    assert!(rows.len() > 20 && rows.iter().all(|row| row.electrical == expected));
}

#[tokio::test(start_paused = true)]
async fn a_lamp_whose_power_drifts_is_not_stable_however_steady_its_light() {
    let drifting = || Fake {
        // 1 % in the 15 min of the window, 0.5 % is allowed.
        drift_per_h: 0.04,
        ..Fake::new()
    };
    let (outcome, run) = day(drifting(), "").await;
    let error = outcome.unwrap_err();
    assert!(matches!(error, ScanError::NotStable { of: "power", .. }), "{error}");
    assert_eq!((error.kind(), run.readings.rows.len()), (ScanErrorKind::NotAccepted, 0));
    let (outcome, run) = day(drifting(), "[limits]\npower_spread_rel = 0.02\n").await;
    assert!(outcome.is_ok() && !run.readings.rows.is_empty());
}

#[tokio::test(start_paused = true)]
async fn a_power_that_is_no_number_cannot_be_judged() {
    let over_range = Fake {
        over_range: true,
        ..Fake::new()
    };
    let error = day(over_range, "").await.0.unwrap_err();
    assert!(matches!(error, ScanError::NoPower { .. }), "{error}");
}

#[tokio::test(start_paused = true)]
async fn a_power_meter_that_falls_silent_ends_the_scan_with_what_was_read() {
    let silent = Fake {
        // After the warm-up of half an hour and some points.
        silent_after: Duration::from_secs(1830),
        ..Fake::new()
    };
    let (outcome, run) = day(silent, "").await;
    let error = outcome.unwrap_err();
    assert!(error.to_string().contains("powermeter"), "{error}");
    assert_eq!(error.kind(), ScanErrorKind::Instrument);
    assert!(
        (1..20).contains(&run.readings.rows.len()),
        "{}",
        run.readings.rows.len()
    );
}
