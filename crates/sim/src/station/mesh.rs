//! A smooth function over the sensor.

use glam::DVec3;

use crate::sensor::Sensor;

/// A smooth function over the sensor, at Chebyshev points along both sides (barycentric interpolation).
pub(super) struct Mesh {
    nodes: Vec<f64>,
    values: Vec<f64>,
    size: [f64; 2],
}

/// Points along each side.
const NODES: usize = 12;

impl Mesh {
    pub fn new(sensor: &Sensor, law: impl Fn(DVec3) -> f64) -> Self {
        let nodes: Vec<f64> = (0..NODES)
            .map(|k| 0.5 - 0.5 * (std::f64::consts::PI * (k as f64 + 0.5) / NODES as f64).cos())
            .collect();
        let size = [sensor.nx as f64, sensor.ny as f64];
        let mut values = Vec::with_capacity(NODES * NODES);
        for y in &nodes {
            for x in &nodes {
                values.push(law(sensor.point(x * size[0], y * size[1])));
            }
        }
        Self { nodes, values, size }
    }

    pub fn at(&self, x: f64, y: f64) -> f64 {
        let (wx, wy) = (self.weights(x / self.size[0]), self.weights(y / self.size[1]));
        (0..NODES)
            .map(|iy| wy[iy] * (0..NODES).map(|ix| wx[ix] * self.values[iy * NODES + ix]).sum::<f64>())
            .sum()
    }

    fn weights(&self, at: f64) -> [f64; NODES] {
        let mut weights = [0.0; NODES];
        let mut sum = 0.0;
        for (k, node) in self.nodes.iter().enumerate() {
            let away = at - node;
            if away == 0.0 {
                let mut only = [0.0; NODES];
                only[k] = 1.0;
                return only;
            }
            let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
            weights[k] = sign * (std::f64::consts::PI * (k as f64 + 0.5) / NODES as f64).sin() / away;
            sum += weights[k];
        }
        weights.map(|weight| weight / sum)
    }
}
