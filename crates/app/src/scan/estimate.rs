//! How long a scan still takes: what the plan asks of the axes and meters, corrected by how long it took so far.

use isolux_record::run::RunHeader;
use isolux_record::{Reading, Role};
use isolux_scan::clock::RunClock;
use isolux_scan::itinerary::{Visit, visits};
use isolux_scan::{VisitTime, visit_times};
use tokio::time::Instant;

/// Visits after which the pace so far counts.
const VISITS_OF_A_PACE: usize = 5;

/// How far a scan is, and how fast.
#[derive(Debug, Clone)]
pub struct Estimate {
    visits: Vec<Visit>,
    times: Vec<VisitTime>,
    /// Visits made; those that lie in the record already among them.
    reached: usize,
    /// The visit at which this session began to read, and when, in s of its clock.
    began: Option<(usize, f64)>,
    now_s: f64,
    paused_s: f64,
}

impl Estimate {
    /// For a run that holds `already`.
    pub fn of(header: &RunHeader, already: &[Reading]) -> Self {
        let mut estimate = Self {
            visits: visits(&header.plan),
            times: visit_times(&header.station, &header.plan),
            reached: 0,
            began: None,
            now_s: 0.0,
            paused_s: 0.0,
        };
        for reading in already {
            estimate.advance(reading);
        }
        estimate
    }

    /// Points of the plan.
    pub fn total(&self) -> u64 {
        self.visits.iter().filter(|visit| visit.role == Role::Point).count() as u64
    }

    /// Points done.
    pub fn done(&self) -> u64 {
        let made = self.visits.iter().take(self.reached);
        made.filter(|visit| visit.role == Role::Point).count() as u64
    }

    /// Reading begins: what came before says nothing about the pace.
    pub fn begin_work(&mut self, clock: &RunClock) {
        (self.began, self.paused_s) = (Some((self.reached, clock.seconds(Instant::now()))), 0.0);
    }

    /// The scan was paused for so long.
    pub fn paused(&mut self, paused_s: f64) {
        self.paused_s += paused_s;
    }

    /// This reading was recorded just now.
    pub fn reached(&mut self, reading: &Reading, clock: &RunClock) {
        self.advance(reading);
        self.now_s = clock.seconds(Instant::now());
        if self.began.is_none() {
            self.begin_work(clock);
        }
    }

    /// This reading is recorded.
    pub fn advance(&mut self, reading: &Reading) {
        let ahead = self.visits.iter().enumerate().skip(self.reached.saturating_sub(1));
        let same = |visit: &Visit| visit.role == reading.role && visit.point == reading.point;
        if let Some((index, _)) = ahead.clone().find(|(_, visit)| same(visit)) {
            self.reached = self.reached.max(index + 1);
        }
    }

    /// Motion and readings that are left, by the plan alone.
    pub fn work_left_s(&self) -> f64 {
        self.times.iter().skip(self.reached).map(|time| time.work_s).sum()
    }

    /// Everything that is left, warm-ups to come included, at the pace so far.
    pub fn left_s(&self) -> f64 {
        let warm_up_s: f64 = self.times.iter().skip(self.reached).map(|time| time.warm_up_s).sum();
        self.work_left_s() * self.pace() + warm_up_s
    }

    /// How long visits took, relative to what the plan asks.
    fn pace(&self) -> f64 {
        let Some((from, began_s)) = self.began else { return 1.0 };
        if self.reached < from + VISITS_OF_A_PACE {
            return 1.0;
        }
        let planned: f64 = self.times[from..self.reached].iter().map(|time| time.work_s).sum();
        let took = self.now_s - began_s - self.paused_s;
        if planned > 0.0 && took > 0.0 {
            took / planned
        } else {
            1.0
        }
    }
}
