//! The lamps, and the rooms in which they stand.

use isolux_darkroom::camera::Unit;
use isolux_darkroom::{Darkroom, MapPose, Room, SensorFrame};

/// A kind of lamp.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Lamp {
    /// Three rings of LEDs with a wide lobe, as in the built-in room.
    Ring,
    /// One LED behind a lens: 20° between the directions of half the peak.
    Spot,
    /// One ring of LEDs that lean inwards, behind elliptic lenses, each of its own flux and aim.
    Oval,
}

impl Lamp {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Ring, Self::Spot, Self::Oval];

    /// Its name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ring => "ring",
            Self::Spot => "spot",
            Self::Oval => "oval",
        }
    }

    /// The built-in room with lamp number `seed` of this kind, on the day with the noise of `day`.
    ///
    /// # Panics
    /// Never with the built-in room as it is shipped.
    pub fn room(self, seed: u64, day: u64) -> Darkroom {
        let mut room = Darkroom::built_in().expect("the built-in room is a room");
        room.seed = day;
        // The camera of the built-in room has a dark offset that no maps of it agree with: a day without a fault has
        // none.
        room.injected_effects.dark_offset.offset_rel = 0.0;
        let lamp = &mut room.lamp;
        lamp.seed = seed;
        match self {
            Self::Ring => {}
            Self::Spot => {
                lamp.ring_diameter_mm = vec![0.0];
                lamp.leds_per_ring = vec![1];
                lamp.exponent = 45.0;
            }
            Self::Oval => {
                lamp.flux_lm = 800.0;
                lamp.ring_diameter_mm = vec![60.0];
                lamp.leds_per_ring = vec![24];
                lamp.exponent = 8.0;
                lamp.aim_deg = 6.0;
                lamp.ellipticity_rel = 0.3;
                lamp.ellipticity_azimuth_deg = 25.0;
                lamp.flux_spread_rel = 0.06;
                lamp.aim_spread_deg = 1.0;
            }
        }
        // The camera is set so that none of the maps of a day reaches its full scale: bins that do are left out by
        // their noisy value, and what is left of their neighbours looks like a sensor that saturates.
        if self != Self::Ring {
            room.camera.full_scale_lx = 1.0;
            let brightest = brightest(&Room::new(room.clone()));
            room.camera.full_scale_lx = (1.05 * brightest).round();
        }
        room
    }
}

/// The largest signal in the middle of maps at the distances of a designed series, exposed as it is.
fn brightest(room: &Room) -> f64 {
    let frame = SensorFrame {
        size_mm: [1.0, 1.0],
        bins: [1, 1],
    };
    let signal = |distance_mm: f64| {
        let pose = MapPose {
            distance_mm,
            exposure: (distance_mm / 500.0).powi(2),
            ..MapPose::default()
        };
        room.sensor_map(&frame, &pose, Unit::Relative)[0]
    };
    [500.0, 300.0, 150.0].map(signal).into_iter().fold(0.0, f64::max)
}
