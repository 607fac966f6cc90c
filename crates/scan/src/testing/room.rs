//! The truth of the fake bench.

use std::sync::{Arc, Mutex};

use tokio::time::Instant;

/// The truth of the fake bench, shared by its instruments.
#[derive(Debug, Default)]
pub struct Room {
    pub axes: [AxisDrive; 2],
    pub lamp_on: Option<Instant>,
    pub shutter_open: bool,
    pub baffle_in: bool,
    /// Faults.
    pub meter_lost_after: Option<u64>,
    pub meter_garbles_every: Option<u64>,
    pub meter_silent_after: Option<u64>,
    pub reads: u64,
    pub stop_fails: bool,
    pub panic_after: Option<u64>,
    pub stall_at_deg: Option<f64>,
    /// Time constant with which the light of a new pose appears.
    pub lag_s: f64,
    pub warm_up_amplitude: f64,
    pub drift_per_h: f64,
    /// Light when each motion ended.
    pub last_rest: Option<Instant>,
    pub log: Vec<String>,
    /// Share of the lamp's light that is lost.
    pub dimmed: f64,
    /// Share of its light by which it changes around C, three times a turn, at γ 90°.
    pub uneven: f64,
    /// The shutter's blade does not follow its output.
    pub stuck_shut: bool,
    /// The truth of each reading of the meter; its number is the reading's evidence.
    pub looks: Vec<Truth>,
}

/// How the bench was when the meter took a reading.
#[derive(Debug, Clone)]
pub struct Truth {
    pub axes: [i64; 2],
    pub lamp_on: bool,
    pub shutter_open: bool,
    pub baffle_in: bool,
}

#[derive(Debug, Default, Clone, Copy)]
pub struct AxisDrive {
    pub from: i64,
    pub to: i64,
    pub began: Option<Instant>,
    pub ends: Option<Instant>,
    pub homed: bool,
    pub stops: u32,
}

impl AxisDrive {
    pub fn steps(&self, now: Instant) -> i64 {
        match (self.began, self.ends) {
            (Some(began), Some(ends)) if now < ends => {
                let share = now.duration_since(began).as_secs_f64() / ends.duration_since(began).as_secs_f64();
                self.from + ((self.to - self.from) as f64 * share).round() as i64
            }
            _ => self.to,
        }
    }

    pub fn moving(&self, now: Instant) -> bool {
        self.ends.is_some_and(|ends| now < ends)
    }
}

pub type Shared = Arc<Mutex<Room>>;

pub const PEAK_CD: f64 = 1000.0;
pub const OFFSET_LX: f64 = 0.05;
pub const AMBIENT_LX: f64 = 0.02;
pub const STRAY_LX: f64 = 0.03;

impl Room {
    /// Illuminance at the meter's head, its own offset included.
    pub fn light(&self, now: Instant) -> f64 {
        let mut lux = OFFSET_LX;
        if self.shutter_open && !self.stuck_shut {
            lux += AMBIENT_LX;
            if let Some(on) = self.lamp_on {
                let age = now.duration_since(on).as_secs_f64();
                let level = (1.0 - self.dimmed)
                    * (1.0 + self.warm_up_amplitude * (-age / 300.0).exp())
                    * (1.0 + self.drift_per_h * age / 3600.0);
                lux += STRAY_LX * level;
                if !self.baffle_in {
                    let [c, gamma] = [0, 1].map(|axis| (self.axes[axis].steps(now) as f64 / 1000.0).to_radians());
                    let around = 1.0 + self.uneven * gamma.sin() * (3.0 * c).cos();
                    let settled = self.last_rest.map_or(1.0, |rest| {
                        if self.lag_s > 0.0 {
                            1.0 - (-now.saturating_duration_since(rest).as_secs_f64() / self.lag_s).exp()
                        } else {
                            1.0
                        }
                    });
                    lux += level * settled * around * PEAK_CD * gamma.cos().max(0.0) / 100.0;
                }
            }
        }
        lux
    }
}
