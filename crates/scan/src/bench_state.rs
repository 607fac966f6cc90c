//! In what state a scan leaves the bench, as the instruments say after its end.

use std::time::Duration;

use isolux_device::{Axis, awake};
use isolux_record::BenchState;
use tokio::time::Instant;

use crate::devices::{Devices, TwoState};

/// An instrument that does not answer must not hold the end of a scan up.
const ANSWER_WITHIN: Duration = Duration::from_secs(2);

/// Asks the instruments in what state the bench is.
pub(crate) async fn ask(devices: &Devices, axes_at_rest: bool) -> BenchState {
    let (c_deg, gamma_deg, lamp_is_on, shutter_is_open, baffle_is_in) = tokio::join!(
        position(devices.axis_c.as_ref()),
        position(devices.axis_gamma.as_ref()),
        state(devices.lamp.as_ref()),
        state(devices.shutter.as_ref()),
        state(devices.baffle.as_ref()),
    );
    BenchState {
        c_deg,
        gamma_deg,
        axes_at_rest,
        lamp_is_on,
        shutter_is_open,
        baffle_is_in,
    }
}

async fn position(axis: &dyn Axis) -> Option<f64> {
    let found = awake::until(Instant::now() + ANSWER_WITHIN, axis.position())
        .await?
        .ok()?;
    Some(found.place.value())
}

async fn state(switch: Option<&TwoState>) -> Option<bool> {
    match switch? {
        TwoState::Device(device) => awake::until(Instant::now() + ANSWER_WITHIN, device.state()).await?.ok(),
        TwoState::Person(_) => None,
    }
}
