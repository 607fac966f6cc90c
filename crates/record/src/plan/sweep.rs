//! A block that is read in motion: its sweeps of γ, in their order.

use serde::{Deserialize, Serialize};

use super::{BlockDocument, Instrument, Order};
use crate::document::Fault;
use crate::reading::ReadingKind;

/// How a block is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mode {
    /// Every direction at rest: the reference.
    #[default]
    Step,
    /// While γ moves through each half-plane.
    Sweep,
}

/// Speed of a block of sweeps where it states none, °/s: run-up and run-out take 4.8° at 40 °/s².
pub const SPEED_DEG_S: f64 = 12.0;
/// The slow pair that separates delay and backlash reaches so far to both sides of γ = 0°, degrees.
const SLOW_REACH_DEG: f64 = 60.0;
/// Share of the block's speed that it has.
const SLOW_SHARE: f64 = 0.5;

/// One sweep: γ from one angle to the other at one C, at one speed. Run-up and run-out lie outside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pass {
    /// Half-plane, degrees.
    pub c_deg: f64,
    /// γ from and to, degrees.
    pub gamma_deg: [f64; 2],
    /// Cruising speed, °/s.
    pub speed_deg_s: f64,
}

impl Pass {
    /// +1 where γ rises, −1 where it falls.
    pub fn sign(&self) -> f64 {
        (self.gamma_deg[1] - self.gamma_deg[0]).signum()
    }

    /// Where the axis starts from and is sent to: so far outside that it cruises within, with a quarter of a second for
    /// its swing, at the acceleration `accel_deg_s2`. Degrees.
    pub fn ends_deg(&self, accel_deg_s2: f64) -> [f64; 2] {
        let ramp = 0.5 * self.speed_deg_s * self.speed_deg_s / accel_deg_s2 + 0.25 * self.speed_deg_s;
        [
            self.gamma_deg[0] - self.sign() * ramp,
            self.gamma_deg[1] + self.sign() * ramp,
        ]
    }
}

/// The speed of a block of sweeps; none for one that is read at rest.
///
/// # Errors
/// [`Fault`] for a key that does not go with sweeps.
pub(super) fn speed(path: &str, block: &BlockDocument, gamma_deg: &[f64]) -> Result<Option<f64>, Fault> {
    let fault = |key: &str, message: &str| Err(Fault::new(format!("{path}.{key}"), message));
    if block.mode == Mode::Step {
        return match block.speed_deg_s {
            Some(_) => fault("speed_deg_s", "belongs to blocks with mode = \"sweep\""),
            None => Ok(None),
        };
    }
    if block.kind != ReadingKind::Lit || block.instrument != Instrument::Luxmeter {
        return fault(
            "mode",
            "sweeps are lit readings of the lux meter; leave `mode` out of this block",
        );
    }
    if block.repeats.is_some() || block.u_rel.is_some() {
        let key = if block.repeats.is_some() { "repeats" } else { "u_rel" };
        return fault(
            key,
            "does not go with mode = \"sweep\": a slower `speed_deg_s` reads more often",
        );
    }
    if block.order != Order::Forward {
        return fault("order", "does not go with mode = \"sweep\": directions alternate");
    }
    if gamma_deg.len() < 4 || gamma_deg.windows(2).any(|pair| pair[0] >= pair[1]) {
        let key = if block.gamma_deg.is_some() {
            "gamma_deg"
        } else {
            "gamma_range"
        };
        return fault(
            key,
            "a sweep needs at least four γ, rising; −180 to 180 gives two half-planes a sweep",
        );
    }
    match block.speed_deg_s {
        Some(speed) if !(speed.is_finite() && speed > 0.0 && speed <= 360.0) => {
            fault("speed_deg_s", "is above 0 and at most 360 °/s")
        }
        speed => Ok(Some(speed.unwrap_or(SPEED_DEG_S))),
    }
}

/// The sweeps of half-planes `c_deg` over rising `gamma_deg`: the first forward, backward, and both again slowly near γ =
/// 0°; then directions alternate.
pub(super) fn passes(c_deg: &[f64], gamma_deg: &[f64], speed_deg_s: f64) -> Vec<Pass> {
    let (Some(&low), Some(&high), Some(&first)) = (gamma_deg.first(), gamma_deg.last(), c_deg.first()) else {
        return Vec::new();
    };
    let pass = |c_deg: f64, [from, to]: [f64; 2], speed_deg_s: f64| Pass {
        c_deg,
        gamma_deg: [from, to],
        speed_deg_s,
    };
    let inner = [low.max(-SLOW_REACH_DEG), high.min(SLOW_REACH_DEG)];
    let inner = if inner[1] - inner[0] < SLOW_REACH_DEG {
        [low, high]
    } else {
        inner
    };
    let slow = SLOW_SHARE * speed_deg_s;
    let mut passes = vec![
        pass(first, [low, high], speed_deg_s),
        pass(first, [high, low], speed_deg_s),
        pass(first, inner, slow),
        pass(first, [inner[1], inner[0]], slow),
    ];
    for (place, &c) in c_deg[1..].iter().enumerate() {
        let way = if place % 2 == 0 { [low, high] } else { [high, low] };
        passes.push(pass(c, way, speed_deg_s));
    }
    passes
}
