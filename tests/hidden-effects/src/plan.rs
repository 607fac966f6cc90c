//! Plans of a bench: where, when and how each reading and map is taken.

use isolux_darkroom::{Kind, MapPose, Observation};

use crate::random::Draws;

/// Whether the operator planned for a diagnosis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Plan {
    /// Several distances, both directions of travel, darks, references; nine maps.
    Designed,
    /// One distance, one direction of travel, no darks; one map.
    Common,
}

/// One planned reading.
#[derive(Debug, Clone)]
pub struct Step {
    /// Name of its block.
    pub block: &'static str,
    /// Where and when.
    pub at: Observation,
    /// Kept back from the operator.
    pub held_out: bool,
}

const STEP_S: f64 = 4.0;

/// The readings of a goniometer day, without ranges and temperatures.
pub fn gonio(plan: Plan, draws: &mut Draws) -> Vec<Step> {
    let mut walk = Walk {
        steps: Vec::new(),
        time_s: draws.between(100.0, 200.0).round(),
    };
    match plan {
        Plan::Designed => {
            walk.dark("dark0");
            for (k, c) in (0..12).map(|k| (k, 15.0 * f64::from(k))) {
                let held = matches!(k, 1 | 5 | 9);
                walk.half_plane("A", c, 2000.0, if k % 2 == 0 { 1.0 } else { -1.0 }, held);
                walk.reference();
            }
            walk.half_plane("B", 0.0, 2000.0, -1.0, false);
            walk.half_plane("B", 90.0, 2000.0, 1.0, false);
            walk.pause(300.0);
            walk.half_plane("C", 0.0, 1000.0, 1.0, false);
            walk.half_plane("C", 90.0, 1000.0, -1.0, false);
            walk.reference();
            walk.pause(300.0);
            walk.half_plane("D", 0.0, 3000.0, -1.0, false);
            walk.half_plane("D", 90.0, 3000.0, 1.0, false);
            walk.reference();
            walk.half_plane("H", 45.0, 1500.0, 1.0, true);
            walk.pause(40.0);
            walk.dark("dark1");
        }
        Plan::Common => {
            for k in 0..12 {
                walk.half_plane("A", 15.0 * f64::from(k), 2000.0, 1.0, k == 4);
            }
        }
    }
    walk.steps
}

struct Walk {
    steps: Vec<Step>,
    time_s: f64,
}

impl Walk {
    fn pause(&mut self, seconds: f64) {
        self.time_s += seconds;
    }

    fn read(&mut self, block: &'static str, kind: Kind, place: [f64; 3], travel: f64, held_out: bool) {
        let [c_deg, gamma_deg, distance_mm] = place;
        let at = Observation {
            kind,
            time_s: self.time_s,
            c_deg,
            gamma_deg,
            distance_mm,
            travel,
            range: 0,
            ambient_c: 25.0,
        };
        self.steps.push(Step { block, at, held_out });
        self.time_s += STEP_S;
    }

    fn dark(&mut self, block: &'static str) {
        for kind in [Kind::LampOff, Kind::Capped] {
            for _ in 0..6 {
                self.read(block, kind, [0.0, 0.0, 2000.0], 0.0, false);
            }
        }
    }

    fn half_plane(&mut self, block: &'static str, c_deg: f64, distance_mm: f64, travel: f64, held_out: bool) {
        self.pause(20.0);
        for k in 0..29 {
            let gamma = travel * (5.0 * f64::from(k) - 70.0);
            self.read(block, Kind::Lit, [c_deg, gamma, distance_mm], travel, held_out);
        }
    }

    fn reference(&mut self) {
        for _ in 0..2 {
            self.read("ref", Kind::Lit, [0.0, 0.0, 2000.0], 0.0, false);
        }
    }
}

/// One planned map.
#[derive(Debug, Clone)]
pub struct Frame {
    /// Its name.
    pub name: &'static str,
    /// Where and how.
    pub pose: MapPose,
    /// Kept back from the operator.
    pub held_out: bool,
}

/// The maps of a sensor day.
pub fn sensor(plan: Plan) -> Vec<Frame> {
    let frame = |name, distance_mm: f64, tilts: [f64; 3], exposure, held_out| Frame {
        name,
        pose: MapPose {
            distance_mm,
            tilt_x_deg: tilts[0],
            tilt_y_deg: tilts[1],
            rot_z_deg: tilts[2],
            offset_mm: [0.0, 0.0],
            exposure,
            lamp: true,
            capped: false,
            time_s: None,
        },
        held_out,
    };
    let flat = [0.0, 0.0, 0.0];
    match plan {
        Plan::Designed => {
            let mut frames = vec![
                frame("d500", 500.0, flat, 1.0, false),
                frame("d500h", 500.0, flat, 0.5, false),
                frame("d300", 300.0, flat, 0.36, false),
                frame("d150", 150.0, flat, 0.09, false),
                frame("tx40", 300.0, [40.0, 0.0, 0.0], 0.36, false),
                frame("ty40", 300.0, [0.0, -40.0, 0.0], 0.36, false),
                frame("rz90", 300.0, [0.0, 0.0, 90.0], 0.36, false),
                frame("lampoff", 500.0, flat, 1.0, false),
                frame("capped", 500.0, flat, 1.0, false),
                frame("h220", 220.0, [0.0, 0.0, 180.0], 0.2, true),
                frame("h400", 400.0, [20.0, 15.0, 0.0], 0.64, true),
            ];
            frames[7].pose.lamp = false;
            frames[8].pose.capped = true;
            frames
        }
        Plan::Common => vec![
            frame("d500", 500.0, flat, 1.0, false),
            frame("h450", 450.0, flat, 0.8, true),
        ],
    }
}
