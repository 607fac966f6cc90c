//! What is worked out of the scan so far, the map of the sensor and that of a scan in motion: made anew after each
//! half-plane or sweep, in a thread of its own.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use camino::Utf8Path;
use isolux_app::simulation::sensor_so_far::sensor_so_far;
use isolux_app::study::in_motion::in_motion;
use serde::Serialize;

use crate::broadcast::Broadcast;

/// A record that is being written may be between two files: it is looked at so often.
const TRIES: u32 = 3;

/// What was worked out last.
pub struct SoFar {
    broadcast: Arc<Broadcast>,
    made: Mutex<Made>,
    /// JSON.
    sensor: Mutex<Option<String>>,
    in_motion: Mutex<Option<String>>,
}

/// For which state of the scan it was worked out.
#[derive(Default)]
struct Made {
    /// The marks of the scan.
    marks: u64,
    /// Tries that are left for them.
    tries: u32,
    /// How often something was worked out: no number stands for two runs.
    count: u64,
}

impl SoFar {
    /// Nothing yet.
    pub fn new(broadcast: Arc<Broadcast>) -> Self {
        Self {
            broadcast,
            made: Mutex::default(),
            sensor: Mutex::default(),
            in_motion: Mutex::default(),
        }
    }

    /// The last map of the sensor, JSON.
    pub fn sensor(&self) -> Option<String> {
        locked(&self.sensor).clone()
    }

    /// The last state of a scan in motion, JSON.
    pub fn in_motion(&self) -> Option<String> {
        locked(&self.in_motion).clone()
    }

    /// Works all out anew if a half-plane or a sweep came to its end since the last time.
    pub fn follow(&self) {
        let marks = self.broadcast.marks();
        let Some(run) = self.broadcast.status_now().run else {
            return;
        };
        {
            let mut made = locked(&self.made);
            if made.marks != marks {
                (made.marks, made.tries) = (marks, TRIES);
            }
            if made.tries == 0 {
                return;
            }
            made.tries -= 1;
        }
        let run = Utf8Path::new(&run);
        let (in_motion, sensor) = (in_motion(run), sensor_so_far(run));
        let count = {
            let mut made = locked(&self.made);
            if (in_motion.is_err() || sensor.is_err()) && made.tries > 0 {
                return;
            }
            made.tries = 0;
            made.count += 1;
            made.count
        };
        let is_in_motion = keep(&self.in_motion, in_motion.ok().flatten());
        let has_sensor = keep(&self.sensor, sensor.ok().flatten());
        self.broadcast.status(|status| {
            status.in_motion = if is_in_motion { count } else { 0 };
            status.sensor = if has_sensor { count } else { 0 };
        });
    }
}

fn locked<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Keeps `made` as JSON; whether there is any.
fn keep(place: &Mutex<Option<String>>, made: Option<impl Serialize>) -> bool {
    let text = made.and_then(|made| serde_json::to_string(&made).ok());
    let some = text.is_some();
    *locked(place) = text;
    some
}
