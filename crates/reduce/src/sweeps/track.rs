//! Where the axis was while a sweep was read: a straight line through the positions that were asked on the way.

use isolux_record::sweeps::SweepRecord;

/// Positions that a line needs at least.
const LEAST: usize = 8;

/// Where the axis that moves is over time while it cruises: γ, or C around a ring.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Track {
    middle_s: f64,
    middle_deg: f64,
    /// As it was read, °/s, with its sign.
    pub speed_deg_s: f64,
    /// Root mean square of the positions about the line, degrees.
    pub rms_deg: f64,
}

impl Track {
    /// Through the positions between the first and the last place of the sweep; none where they are too few.
    pub fn of(sweep: &SweepRecord) -> Option<Self> {
        let [a, b] = sweep.of.way().moving_deg();
        let (low, high) = (a.min(b), a.max(b));
        let on_the_way: Vec<(f64, f64)> = sweep
            .positions
            .iter()
            .filter(|position| (low..=high).contains(&position.place_deg))
            .map(|position| (position.answered_s, position.place_deg))
            .collect();
        if on_the_way.len() < LEAST {
            return None;
        }
        let count = on_the_way.len() as f64;
        let mean = |of: &dyn Fn(&(f64, f64)) -> f64| on_the_way.iter().map(of).sum::<f64>() / count;
        let (middle_s, middle_deg) = (mean(&|at| at.0), mean(&|at| at.1));
        let spread = mean(&|at| (at.0 - middle_s).powi(2));
        let speed_deg_s = mean(&|at| (at.0 - middle_s) * (at.1 - middle_deg)) / spread;
        let track = Self {
            middle_s,
            middle_deg,
            speed_deg_s,
            rms_deg: mean(&|at| (at.1 - middle_deg - speed_deg_s * (at.0 - middle_s)).powi(2)).sqrt(),
        };
        (spread > 0.0 && speed_deg_s != 0.0).then_some(track)
    }

    /// Its place at a time of the run.
    pub fn place_deg(&self, time_s: f64) -> f64 {
        self.middle_deg + self.speed_deg_s * (time_s - self.middle_s)
    }

    /// Time of the run at which it was there.
    pub fn time_s(&self, place_deg: f64) -> f64 {
        self.middle_s + (place_deg - self.middle_deg) / self.speed_deg_s
    }
}
