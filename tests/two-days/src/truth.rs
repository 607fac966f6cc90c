//! What the room itself shows, without noise: where a second day looked, and where nobody did.

use isolux_darkroom::camera::Unit;
use isolux_darkroom::{Darkroom, Kind, MapPose, Observation, Room, SensorFrame};
use isolux_record::ReadingKind;
use isolux_record::observation::{self, MapSet, ReadingCoordinates};

/// Where something is read or recorded.
#[derive(Debug, Clone)]
pub enum Places {
    /// Readings of the lux meter.
    Readings(Vec<ReadingCoordinates>),
    /// Bins of maps, every bin of every map in order.
    Maps(MapSet),
}

impl Places {
    /// What the room shows there without noise, lx or relative signal.
    pub fn truth(&self, room: &Darkroom) -> Vec<f64> {
        let room = Room::new(room.clone());
        match self {
            Self::Readings(readings) => readings.iter().map(|at| room.indicated_lx(&observation(at))).collect(),
            Self::Maps(maps) => {
                let frame = SensorFrame {
                    size_mm: maps.sensor_mm(),
                    bins: maps.bins(),
                };
                let map = |map| room.sensor_map(&frame, &pose(map), Unit::Relative);
                maps.maps().iter().flat_map(map).collect()
            }
        }
    }

    /// The standard deviation of the noise of each value, as the station states it.
    pub fn noise(&self, room: &Darkroom, values: &[f64]) -> Vec<f64> {
        let (rel, floor) = match self {
            Self::Readings(_) => (room.luxmeter.noise_rel, room.luxmeter.noise_lx),
            Self::Maps(_) => (room.camera.noise_rel, room.camera.noise_abs),
        };
        values.iter().map(|value| (rel * value).hypot(floor)).collect()
    }

    /// Places beside these where nobody looked: half-planes and γ between those that were read; maps at other
    /// distances and tilts.
    #[must_use]
    pub fn kept_back(&self) -> Self {
        match self {
            Self::Readings(readings) => {
                let illuminated = readings
                    .iter()
                    .filter(|at| at.kind == ReadingKind::Lit && at.gamma_deg.abs() < 78.0);
                let beside = |at: &ReadingCoordinates| ReadingCoordinates {
                    c_deg: at.c_deg + 19.0,
                    gamma_deg: at.gamma_deg + 1.7,
                    ..*at
                };
                Self::Readings(illuminated.map(beside).collect())
            }
            Self::Maps(maps) => {
                let illuminated = &maps.maps()[0];
                let at = |distance_mm: f64, tilt_x_deg: f64| observation::MapPose {
                    distance_mm,
                    tilt_x_deg,
                    exposure: (distance_mm / 500.0).powi(2),
                    ..illuminated.clone()
                };
                // Never none: there are two poses.
                Self::Maps(
                    maps.at_poses(vec![at(400.0, 0.0), at(220.0, 20.0)])
                        .unwrap_or_else(|| maps.clone()),
                )
            }
        }
    }
}

fn observation(at: &ReadingCoordinates) -> Observation {
    Observation {
        kind: match at.kind {
            ReadingKind::Lit => Kind::Lit,
            ReadingKind::Baffled => Kind::Baffled,
            ReadingKind::LampOff => Kind::LampOff,
            ReadingKind::Capped => Kind::Capped,
        },
        time_s: at.lamp_age_s().unwrap_or(0.0),
        c_deg: at.c_deg,
        gamma_deg: at.gamma_deg,
        distance_mm: at.distance_mm,
        travel: f64::from(at.travel),
        range: at.range.and_then(|range| u8::try_from(range).ok()).unwrap_or(0),
        ambient_c: at.ambient_c.unwrap_or(25.0),
    }
}

fn pose(map: &observation::MapPose) -> MapPose {
    MapPose {
        distance_mm: map.distance_mm,
        tilt_x_deg: map.tilt_x_deg,
        tilt_y_deg: map.tilt_y_deg,
        rot_z_deg: map.rot_z_deg,
        offset_mm: map.offset_mm,
        exposure: map.exposure,
        lamp: map.lamp,
        capped: map.capped,
        time_s: map.time_s,
    }
}
