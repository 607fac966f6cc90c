//! How long a scan still takes: what the plan asks of the axes and meters, corrected by how long it took so far.

use isolux_record::run::RunHeader;
use isolux_record::{Reading, Role};
use isolux_scan::itinerary::{Visit, visits};
use isolux_scan::visit_times;
use jiff::Timestamp;

/// Visits after which the pace so far counts.
const VISITS_OF_A_PACE: usize = 5;

/// How far a scan is, and how fast.
#[derive(Debug, Clone)]
pub struct Estimate {
    /// Names of the plan's blocks.
    blocks: Vec<String>,
    visits: Vec<Visit>,
    /// What is left from each visit on, and after the last: every reading asks for it.
    left: Vec<Ahead>,
    /// Visits made; those that lie in the record already among them.
    reached: usize,
    /// The visit at which this session began to read, and when.
    began: Option<(usize, Timestamp)>,
    now: Timestamp,
    paused_s: f64,
}

/// Visits to come.
#[derive(Debug, Clone, Copy, Default)]
struct Ahead {
    points: u64,
    work_s: f64,
    warm_up_s: f64,
}

impl Estimate {
    /// For a run that holds nothing yet.
    pub fn of(header: &RunHeader) -> Self {
        let visits = visits(&header.plan);
        let times = visit_times(&header.station, &header.plan);
        let mut left = vec![Ahead::default(); visits.len() + 1];
        for (at, (visit, time)) in visits.iter().zip(&times).enumerate().rev() {
            left[at] = Ahead {
                points: left[at + 1].points + u64::from(visit.role == Role::Point),
                work_s: left[at + 1].work_s + time.work_s,
                warm_up_s: left[at + 1].warm_up_s + time.warm_up_s,
            };
        }
        Self {
            blocks: header.plan.blocks().iter().map(|block| block.name.clone()).collect(),
            visits,
            left,
            reached: 0,
            began: None,
            now: Timestamp::default(),
            paused_s: 0.0,
        }
    }

    /// Points of the plan.
    pub fn total(&self) -> u64 {
        self.left[0].points
    }

    /// Points done.
    pub fn done(&self) -> u64 {
        self.total() - self.left[self.reached].points
    }

    /// A session at the bench begins: how fast an earlier one was says nothing about this one.
    pub fn begin_session(&mut self) {
        self.began = None;
    }

    /// Reading begins: what came before says nothing about the pace.
    pub fn begin_work(&mut self, at: Timestamp) {
        (self.began, self.paused_s) = (Some((self.reached, at)), 0.0);
    }

    /// The scan was paused for so long.
    pub fn paused(&mut self, paused_s: f64) {
        self.paused_s += paused_s;
    }

    /// This reading was recorded.
    pub fn reached(&mut self, reading: &Reading, at: Timestamp) {
        self.now = at;
        let ahead = self.visits.iter().enumerate().skip(self.reached.saturating_sub(1));
        let same = |visit: &Visit| visit.role == reading.role && visit.point == reading.point;
        if let Some((index, _)) = ahead.clone().find(|(_, visit)| same(visit)) {
            self.reached = self.reached.max(index + 1);
        }
        if self.began.is_none() {
            self.begin_work(at);
        }
    }

    /// A sweep of this block was recorded. Where half-planes are chosen, the sweep that the plan names next stands for
    /// it: each takes about as long.
    pub fn swept(&mut self, block: &str, at: Timestamp) {
        self.now = at;
        let mut ahead = (self.reached..).zip(&self.visits[self.reached..]);
        let is_sweep = |visit: &Visit| visit.pass.is_some() && self.blocks[visit.block] == block;
        if let Some((index, _)) = ahead.find(|(_, visit)| is_sweep(visit)) {
            self.reached = index + 1;
        }
        if self.began.is_none() {
            self.begin_work(at);
        }
    }

    /// Motion and readings that are left, by the plan alone.
    pub fn work_left_s(&self) -> f64 {
        self.left[self.reached].work_s
    }

    /// Everything that is left, warm-ups to come included, at the pace so far.
    pub fn left_s(&self) -> f64 {
        self.work_left_s() * self.pace() + self.left[self.reached].warm_up_s
    }

    /// How long visits took, relative to what the plan asks.
    fn pace(&self) -> f64 {
        let Some((from, began)) = self.began else { return 1.0 };
        if self.reached < from + VISITS_OF_A_PACE {
            return 1.0;
        }
        let planned = self.left[from].work_s - self.left[self.reached].work_s;
        let took = self.now.duration_since(began).as_secs_f64() - self.paused_s;
        if planned > 0.0 && took > 0.0 {
            took / planned
        } else {
            1.0
        }
    }
}
