//! In what state a scan leaves the bench, as the instruments say after its end.

use std::fmt;
use std::time::Duration;

use isolux_device::{Axis, awake};
use tokio::time::Instant;

use crate::devices::{Devices, TwoState};

/// An instrument that does not answer must not hold the end of a scan up.
const ANSWER_WITHIN: Duration = Duration::from_secs(2);

/// The bench after a scan. What has no instrument, or one that gives no answer, is none.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct BenchState {
    /// Position of C in degrees.
    pub c_deg: Option<f64>,
    /// Position of γ in degrees.
    pub gamma_deg: Option<f64>,
    /// Whether both axes were stopped and verified at rest.
    pub axes_at_rest: bool,
    /// Whether the lamp is on.
    pub lamp_is_on: Option<bool>,
    /// Whether the shutter is open.
    pub shutter_is_open: Option<bool>,
    /// Whether the baffle is in the beam.
    pub baffle_is_in: Option<bool>,
}

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

impl fmt::Display for BenchState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let rest = if self.axes_at_rest {
            "at rest"
        } else {
            "NOT verified at rest"
        };
        write!(f, "axes {rest}")?;
        if let (Some(c_deg), Some(gamma_deg)) = (self.c_deg, self.gamma_deg) {
            // Adding 0 makes −0 and 0 one.
            write!(f, " at C {:.2}°, γ {:.2}°", c_deg + 0.0, gamma_deg + 0.0)?;
        }
        for (what, state, words) in [
            ("lamp", self.lamp_is_on, ["on", "off"]),
            ("shutter", self.shutter_is_open, ["open", "closed"]),
            ("baffle", self.baffle_is_in, ["in the beam", "out of the beam"]),
        ] {
            if let Some(state) = state {
                write!(f, "; {what} {}", words[usize::from(!state)])?;
            }
        }
        Ok(())
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_known_is_not_said() {
        let state = BenchState {
            c_deg: Some(-0.0),
            gamma_deg: Some(12.5),
            axes_at_rest: true,
            lamp_is_on: Some(true),
            baffle_is_in: Some(false),
            ..BenchState::default()
        };
        assert_eq!(
            state.to_string(),
            "axes at rest at C 0.00°, γ 12.50°; lamp on; baffle out of the beam"
        );
        let dead = BenchState::default();
        assert_eq!(dead.to_string(), "axes NOT verified at rest");
    }
}
