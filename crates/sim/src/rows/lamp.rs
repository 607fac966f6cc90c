//! One point of a source before a sensor: its kinks, and where pixel centres stand for their pixels.

use glam::DVec3;

use super::slopes::Slopes;
use crate::patch::Light;
use crate::sensor::Sensor;
use crate::source::{Part, Shape};

/// Intervals along each side of the sensor at which polar angles are looked at.
const SIDE: usize = 16;

/// One point and its table, in the frame in which the table stands upright. Places in pixels.
pub(super) struct Lamp<'a> {
    pub light: Light<'a>,
    pub share: f64,
    pub corner: DVec3,
    pub step_x: DVec3,
    pub step_y: DVec3,
    pub planes: Vec<Plane>,
    pub cones: Vec<Cone>,
    /// Distance from the pole axis in mm below which a pixel's centre does not stand for it.
    pub axis: f64,
}

/// A half-plane of a grid line.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plane {
    pub line: usize,
    /// Sine and cosine of its azimuth.
    pub turn: [f64; 2],
    pub within: Within,
}

/// A cone of a grid line.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cone {
    pub line: usize,
    pub cosine: f64,
    pub within: Within,
}

/// What a kink asks of the pixels that it crosses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Within {
    /// Nothing: it bends too little.
    Soft,
    /// What a straight ramp over the pixel adds to the value at its centre.
    Ramp,
    /// Their own integral.
    Own,
}

impl<'a> Lamp<'a> {
    /// `part` in its own frame, and the relative bound of what pixel centres neglect elsewhere than near the axis and at sharp
    /// kinks; `None` where the part is no point, or its light may vanish, or comes from behind.
    pub fn new(part: &'a Part, extinction_per_mm: f64, sensor: &Sensor, aim: f64, kink: f64) -> Option<(Self, f64)> {
        let Shape::Point(centre) = part.shape else { return None };
        let own = |v: DVec3| part.aim.map_or(v, |aim| aim.transpose() * v);
        let mut lamp = Self {
            light: Light {
                table: &part.table,
                toward: own(sensor.toward),
                extinction_per_mm,
            },
            share: part.share,
            corner: own(sensor.corner - centre),
            step_x: own(sensor.step_x),
            step_y: own(sensor.step_y),
            planes: Vec::new(),
            cones: Vec::new(),
            axis: 0.0,
        };
        let neglected = lamp.prepare(sensor, aim, kink)?;
        Some((lamp, neglected))
    }

    /// Lists the kinks, and returns the relative bound of what pixel centres neglect elsewhere; `None` where the light may
    /// vanish, or comes from behind.
    fn prepare(&mut self, sensor: &Sensor, aim: f64, kink: f64) -> Option<f64> {
        let table = self.light.table;
        let place = |x: f64, y: f64| self.corner + x * self.step_x + y * self.step_y;
        let (nx, ny) = (sensor.nx as f64, sensor.ny as f64);
        let corners = [place(0.0, 0.0), place(nx, 0.0), place(nx, ny), place(0.0, ny)];
        let height = corners
            .iter()
            .map(|v| self.light.toward.dot(*v))
            .fold(f64::INFINITY, f64::min);
        let farthest = corners.iter().map(|v| v.length()).fold(0.0, f64::max);
        if height <= 1e-3 * farthest {
            return None;
        }
        // The nearest point of the whole plane is not farther than that of the sensor.
        let distance = self.light.toward.dot(corners[0]);
        let [mut low, mut high] = [f64::INFINITY, 0.0_f64];
        for i in 0..=SIDE {
            for j in 0..=SIDE {
                let v = place(nx * i as f64 / SIDE as f64, ny * j as f64 / SIDE as f64);
                let gamma = v.x.hypot(v.y).atan2(v.z);
                (low, high) = (low.min(gamma), high.max(gamma));
            }
        }
        let step = (nx * self.step_x.length()).hypot(ny * self.step_y.length()) / (SIDE as f64 * distance);
        let slopes = Slopes::over(table, (low - step).max(0.0), high + step)?;
        // Curvature over a pixel.
        let square = (self.step_x.length_squared() + self.step_y.length_squared()) / 24.0;
        let (near, face) = (distance.recip(), (3.0 / distance + 1.0 / height));
        let curvature = |axis: f64| {
            let (turn_g, turn_c) = (near, axis.recip());
            // γ turns with the distance from the axis, least far from it.
            let round = near * (slopes.tip / axis + slopes.gamma_per_sine * near);
            let bend_c = 2.0 * axis.powi(-2);
            // In C, the slope falls towards the pole like the distance from it.
            let c = slopes.c_per_sine * (axis * near).min(1.0);
            square
                * (round
                    + 2.0 * slopes.gamma * turn_g * (near + face)
                    + c * (bend_c + 2.0 * turn_c * face)
                    + 2.0 * slopes.both * turn_g * turn_c
                    + 15.0 * near * near
                    + 6.0 * near / height)
        };
        let reach = farthest.max(1e-9);
        if curvature(reach) > aim {
            return None;
        }
        let (mut least, mut most) = (1e-9 * reach, reach);
        for _ in 0..60 {
            let middle = (least * most).sqrt();
            if curvature(middle) > aim {
                least = middle;
            } else {
                most = middle;
            }
        }
        let diagonal = (self.step_x + self.step_y)
            .length()
            .max((self.step_x - self.step_y).length());
        self.axis = most + 0.75 * diagonal;
        let mut neglected = curvature(most);
        // A kink through the middle of a rectangle bends its mean by at most an eighth of the longer side; a straight ramp of an even
        // slope describes it but for how the angle and all else turn over the pixel.
        let side = self.step_x.length().max(self.step_y.length());
        // A pixel may hold a cone and a plane.
        let mut soft = [0.0_f64; 2];
        let mut within = |kind: usize, jump: f64, axis: f64| {
            let error = 0.125 * side * near * jump;
            let bent = 2.0 * square * near * (jump * (axis.recip() + near + face) + 2.0 * slopes.both / axis);
            let (within, left) = match () {
                () if error <= kink => (Within::Soft, error),
                () if bent <= kink => (Within::Ramp, bent),
                () => (Within::Own, 0.0),
            };
            soft[kind] = soft[kind].max(left);
            within
        };
        for &(line, jump) in &slopes.cones {
            let gamma = table.gamma_rad[line];
            let axis = most.max(distance * gamma.sin());
            self.cones.push(Cone {
                line,
                cosine: gamma.cos(),
                within: within(0, jump, axis),
            });
        }
        for &(line, jump) in &slopes.planes {
            self.planes.push(Plane {
                line,
                turn: table.c_rad[line].sin_cos().into(),
                within: within(1, jump, most),
            });
        }
        neglected += soft[0] + soft[1];
        Some(neglected)
    }

    /// Light of this part per candela along `v`, lx.
    pub fn per_cd(&self, v: DVec3) -> f64 {
        let square = v.length_squared();
        let length = square.sqrt();
        let light = 1e6 * self.share * self.light.toward.dot(v) / (square * length);
        if self.light.extinction_per_mm > 0.0 {
            light * (-self.light.extinction_per_mm * length).exp()
        } else {
            light
        }
    }
}
