//! The map of the sensor by the scan so far: made anew after each half-plane, in a thread of its own.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use camino::Utf8Path;
use isolux_app::simulation::sensor_so_far::sensor_so_far;

use crate::broadcast::Broadcast;

/// The last map, and for which state of the scan it was made.
pub struct Sensor {
    broadcast: Arc<Broadcast>,
    /// Session and half-planes of the last attempt.
    made: AtomicU64,
    map: Mutex<Option<String>>,
}

impl Sensor {
    /// None yet.
    pub fn new(broadcast: Arc<Broadcast>) -> Self {
        Self {
            broadcast,
            made: AtomicU64::new(0),
            map: Mutex::new(None),
        }
    }

    /// The last map, JSON.
    pub fn last(&self) -> Option<String> {
        self.map.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Makes a new map if a half-plane came to its end since the last one. Takes as long as the simulation does.
    pub fn follow(&self) {
        let marked = self.broadcast.half_planes();
        if self.made.swap(marked, Ordering::Relaxed) == marked {
            return;
        }
        let Some(run) = self.broadcast.status_now().run else {
            return;
        };
        // A record that is being written may be between two files: the next half-plane brings the next map.
        let map = sensor_so_far(Utf8Path::new(&run)).ok().flatten();
        let text = map.and_then(|map| serde_json::to_string(&map).ok());
        let some = text.is_some();
        *self.map.lock().unwrap_or_else(PoisonError::into_inner) = text;
        self.broadcast
            .status(|status| status.sensor = if some { status.sensor + 1 } else { 0 });
    }
}
