//! The dark of a lux meter that gives no number without one.

use std::time::Duration;

use isolux_device::{DeviceError, LuxMeter, awake};
use tokio::time::Instant;

use crate::devices::{Devices, TwoState};
use crate::error::ScanError;

/// For several spectra at each of its integration times.
const PATIENCE: Duration = Duration::from_mins(2);

/// Takes it; no light may fall on the meter. What was found, in a sentence.
///
/// # Errors
/// What the meter reports.
pub async fn take(meter: &dyn LuxMeter) -> Result<Option<String>, ScanError> {
    let deadline = Instant::now() + PATIENCE;
    let taken = awake::until(deadline + Duration::from_secs(2), meter.take_dark(deadline)).await;
    let late = || DeviceError::Timeout {
        device: meter.identity().target.clone(),
        action: "take the dark".to_owned(),
        waited: PATIENCE,
        received: Vec::new(),
    };
    taken
        .unwrap_or_else(|| Err(late()))
        .map_err(ScanError::device("luxmeter"))
}

/// Takes it behind the shutter, if the meter needs it and an instrument moves the shutter; the shutter is left as it
/// was found.
///
/// # Errors
/// What the meter or the shutter reports.
pub async fn behind_shutter(devices: &Devices) -> Result<(), ScanError> {
    let meter = devices.meter.as_ref();
    if !meter.properties().needs_dark {
        return Ok(());
    }
    let Some(TwoState::Device(shutter)) = &devices.shutter else {
        return Ok(());
    };
    let failed = ScanError::device("shutter");
    let open = shutter.state().await.map_err(&failed)?;
    shutter.set(false).await.map_err(&failed)?;
    let taken = take(meter).await;
    shutter.set(open).await.map_err(&failed)?;
    taken.map(drop)
}
