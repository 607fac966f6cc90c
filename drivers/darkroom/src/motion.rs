//! Motion of one axis: acceleration-limited, as pieces of constant acceleration.

/// A planned motion. Times in s, positions in any unit u, velocities u/s.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    pieces: Vec<Piece>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Piece {
    start_s: f64,
    position: f64,
    velocity: f64,
    acceleration: f64,
}

impl Motion {
    /// At rest at `position`.
    pub fn at_rest(position: f64) -> Self {
        Self {
            pieces: vec![Piece {
                start_s: f64::NEG_INFINITY,
                position,
                velocity: 0.0,
                acceleration: 0.0,
            }],
        }
    }

    /// Position at `time_s`.
    pub fn position(&self, time_s: f64) -> f64 {
        self.state(time_s).0
    }

    /// Velocity at `time_s`.
    pub fn velocity(&self, time_s: f64) -> f64 {
        self.state(time_s).1
    }

    /// True while it has not come to rest.
    pub fn moving(&self, time_s: f64) -> bool {
        time_s < self.end_s()
    }

    /// When it comes to rest; −∞ if it never moved.
    pub fn end_s(&self) -> f64 {
        self.pieces.last().map_or(f64::NEG_INFINITY, |piece| piece.start_s)
    }

    /// When it began; −∞ if it never moved.
    pub fn start_s(&self) -> f64 {
        self.pieces
            .iter()
            .map(|piece| piece.start_s)
            .find(|start_s| start_s.is_finite())
            .unwrap_or(f64::NEG_INFINITY)
    }

    /// Where it comes to rest.
    pub fn target(&self) -> f64 {
        self.pieces.last().map_or(0.0, |piece| piece.position)
    }

    /// From the state at `now_s`: brakes if it still moves, then goes to `target` with a trapezoid of velocity.
    #[must_use]
    pub fn move_to(&self, target: f64, now_s: f64, speed: f64, acceleration: f64) -> Self {
        let mut motion = self.stop(now_s, acceleration);
        let (start_s, from) = (motion.end_s().max(now_s), motion.target());
        let distance = target - from;
        if distance == 0.0 {
            return motion;
        }
        motion.pieces.pop();
        if motion.pieces.is_empty() {
            motion.pieces.push(Piece {
                start_s: f64::NEG_INFINITY,
                position: from,
                velocity: 0.0,
                acceleration: 0.0,
            });
        }
        let sign = distance.signum();
        // Below v²/a of travel the speed is never reached and the trapezoid is a triangle.
        let peak = speed.min((acceleration * distance.abs()).sqrt());
        let ramp_s = peak / acceleration;
        let cruise_s = (distance.abs() - peak * ramp_s).max(0.0) / peak;
        let ramp = 0.5 * peak * ramp_s * sign;
        motion.pieces.extend([
            Piece {
                start_s,
                position: from,
                velocity: 0.0,
                acceleration: sign * acceleration,
            },
            Piece {
                start_s: start_s + ramp_s,
                position: from + ramp,
                velocity: sign * peak,
                acceleration: 0.0,
            },
            Piece {
                start_s: start_s + ramp_s + cruise_s,
                position: target - ramp,
                velocity: sign * peak,
                acceleration: -sign * acceleration,
            },
            Piece {
                start_s: start_s + 2.0 * ramp_s + cruise_s,
                position: target,
                velocity: 0.0,
                acceleration: 0.0,
            },
        ]);
        motion
    }

    /// From the state at `now_s`: brakes to rest.
    #[must_use]
    pub fn stop(&self, now_s: f64, acceleration: f64) -> Self {
        let (position, velocity) = self.state(now_s);
        if velocity == 0.0 {
            return Self::at_rest(position);
        }
        let brake_s = velocity.abs() / acceleration;
        let mut pieces: Vec<Piece> = self
            .pieces
            .iter()
            .copied()
            .filter(|piece| piece.start_s < now_s)
            .collect();
        pieces.push(Piece {
            start_s: now_s,
            position,
            velocity,
            acceleration: -velocity.signum() * acceleration,
        });
        let end = position + 0.5 * velocity * brake_s;
        pieces.push(Piece {
            start_s: now_s + brake_s,
            position: end,
            velocity: 0.0,
            acceleration: 0.0,
        });
        Self { pieces }
    }

    /// Stands still at once, as after a collision.
    #[must_use]
    pub fn freeze(&self, now_s: f64) -> Self {
        Self::at_rest(self.position(now_s))
    }

    fn state(&self, time_s: f64) -> (f64, f64) {
        let Some(piece) = self
            .pieces
            .iter()
            .rev()
            .find(|piece| piece.start_s <= time_s)
            .or(self.pieces.first())
        else {
            return (0.0, 0.0);
        };
        if !piece.start_s.is_finite() {
            return (piece.position, 0.0);
        }
        let t = (time_s - piece.start_s).max(0.0);
        (
            piece.position + piece.velocity * t + 0.5 * piece.acceleration * t * t,
            piece.velocity + piece.acceleration * t,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_move_takes_distance_over_speed_plus_one_ramp() {
        let motion = Motion::at_rest(1.0).move_to(101.0, 10.0, 20.0, 40.0);
        assert!((motion.end_s() - (10.0 + 100.0 / 20.0 + 20.0 / 40.0)).abs() < 1e-12);
        assert_eq!(motion.position(9.0), 1.0);
        assert_eq!(motion.position(100.0), 101.0);
        assert!((motion.velocity(12.0) - 20.0).abs() < 1e-12);
        assert!(motion.moving(15.4) && !motion.moving(15.5));
    }

    #[test]
    fn position_is_the_integral_of_velocity_even_when_interrupted() {
        let motion = Motion::at_rest(0.0).move_to(-3.0, 0.0, 2.0, 1.0);
        let turned = motion.move_to(5.0, 1.5, 2.0, 1.0);
        let step = 1e-4;
        let mut position = 0.0;
        let mut t = 0.0;
        while t < 12.0 {
            position += step * turned.velocity(t + 0.5 * step);
            assert!(turned.velocity(t).abs() <= 2.0 + 1e-9);
            t += step;
        }
        assert!((position - 5.0).abs() < 1e-3, "{position}");
        assert_eq!(turned.target(), 5.0);
        assert_eq!(turned.start_s(), 0.0);
        let stopped = motion.stop(1.0, 1.0);
        assert!((stopped.target() - -1.0).abs() < 1e-12);
        assert!(!stopped.moving(2.0));
    }
}
