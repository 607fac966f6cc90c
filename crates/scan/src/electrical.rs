//! The lamp's supply line, read beside its light.

use std::time::Duration;

use isolux_device::{DeviceError, PowerMeter, PowerReading, awake};
use isolux_record::Electrical;
use tokio::time::Instant;

use crate::error::ScanError;

/// One new reading of nothing from before `not_before`. The driver asks again when an answer is lost or damaged.
///
/// # Errors
/// [`ScanError::Device`] when it stays lost, or the meter is at fault.
pub async fn read(meter: &dyn PowerMeter, not_before: Instant) -> Result<PowerReading, ScanError> {
    let patience = 20 * meter.update_interval() + Duration::from_secs(5);
    let deadline = Instant::now().max(not_before) + patience;
    let source = match awake::until(deadline + Duration::from_secs(2), meter.read(not_before, deadline)).await {
        Some(Ok(reading)) => return Ok(reading),
        Some(Err(error)) => error,
        None => DeviceError::Timeout {
            device: meter.identity().target.clone(),
            action: "read".to_owned(),
            waited: patience,
            received: Vec::new(),
        },
    };
    Err(ScanError::Device {
        role: "powermeter",
        source,
    })
}

/// What the record keeps of a reading: numbers. Where two exchanges did not agree there is none.
pub fn recorded(reading: &PowerReading) -> Electrical {
    if !reading.steady {
        return Electrical::default();
    }
    Electrical {
        voltage_v: reading.voltage.value(),
        current_a: reading.current.value(),
        power_w: reading.power.value(),
        power_factor: reading.power_factor.value(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use isolux_device::Quantity;

    #[test]
    fn what_is_no_number_or_not_confirmed_is_recorded_as_nothing() {
        let now = Instant::now();
        let reading = PowerReading {
            voltage: Quantity::Measured(24.0),
            current: Quantity::OverRange,
            power: Quantity::Measured(-0.1),
            power_factor: Quantity::NoData,
            began: now,
            ended: now,
            steady: true,
            retries: 0,
            evidence: Vec::new(),
        };
        let kept = Electrical {
            voltage_v: Some(24.0),
            power_w: Some(-0.1),
            ..Electrical::default()
        };
        assert_eq!(recorded(&reading), kept);
        let unsteady = PowerReading {
            steady: false,
            ..reading
        };
        assert_eq!(recorded(&unsteady), Electrical::default());
    }
}
