//! The phases of a day, as they can be seen from outside.

use std::path::Path;
use std::time::SystemTime;

/// What the program does when it is killed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    WarmUp,
    Sweeps,
    Scan,
    Spectrum,
    Reduce,
    Simulate,
    Diagnose,
    Report,
}

impl Phase {
    /// Those of a day at rest.
    pub const AT_REST: [Self; 7] = [
        Self::WarmUp,
        Self::Scan,
        Self::Spectrum,
        Self::Reduce,
        Self::Simulate,
        Self::Diagnose,
        Self::Report,
    ];

    /// Those of a day in motion, whose results are made as those of a day at rest. An odd number: every other day
    /// chooses its half-planes.
    pub const IN_MOTION: [Self; 9] = [
        Self::Sweeps,
        Self::Sweeps,
        Self::WarmUp,
        Self::Sweeps,
        Self::Scan,
        Self::Sweeps,
        Self::Spectrum,
        Self::Sweeps,
        Self::Reduce,
    ];
}

/// How far a day has come.
#[derive(Debug, Clone, Copy)]
pub struct Progress {
    looks: usize,
    rows: usize,
    blocks: usize,
    sweeps: usize,
}

impl Progress {
    pub fn of(day: &Path) -> Self {
        Self {
            looks: lines(day, "events.jsonl", "\"warm_up\""),
            rows: lines(day, "readings.csv", ""),
            blocks: lines(day, "events.jsonl", "\"event\":\"block\""),
            sweeps: std::fs::read_dir(day.join("sweeps")).map_or(0, Iterator::count),
        }
    }
}

/// What stands in the folder of a day when its program is started.
pub struct Begun {
    at: SystemTime,
    progress: Progress,
}

impl Begun {
    pub fn now(day: &Path) -> Self {
        Self {
            at: SystemTime::now(),
            progress: Progress::of(day),
        }
    }

    /// Whether the program that was started then is in this phase, `share` (0 to 1) of it being over where that can be
    /// counted; `whole` is a day at its end.
    pub fn is_in(&self, day: &Path, phase: Phase, share: f64, whole: &Progress) -> bool {
        let Progress {
            looks,
            rows,
            blocks,
            sweeps,
        } = self.progress;
        let new = |name: &str| {
            let made = std::fs::metadata(day.join(name)).and_then(|about| about.modified());
            made.is_ok_and(|made| made >= self.at)
        };
        match phase {
            // A warm-up takes about 60 looks.
            Phase::WarmUp => Progress::of(day).looks > looks + (60.0 * share) as usize,
            Phase::Sweeps => {
                let now = Progress::of(day);
                let left = whole.sweeps.saturating_sub(sweeps);
                now.blocks > blocks && now.sweeps >= sweeps + (left as f64 * share) as usize
            }
            Phase::Scan => {
                let left = whole.rows.saturating_sub(rows).max(1);
                lines(day, "readings.csv", "") > rows.max(1) + ((left - 1) as f64 * share) as usize
            }
            Phase::Spectrum => lines(day, "events.jsonl", "\"name\":\"spectrum\"") > 0,
            Phase::Reduce => lines(day, "run.toml", "how = \"completed\"") > 0,
            Phase::Simulate => new("results/luminaire.model.toml"),
            Phase::Diagnose => new("results/result.json"),
            Phase::Report => new("results/diagnosis.json"),
        }
    }

    /// Seconds that the phase lasts at most after it was seen, for those that are not counted.
    pub fn lasts_s(phase: Phase) -> f64 {
        match phase {
            Phase::WarmUp | Phase::Scan => 0.0,
            // As long as a sweep.
            Phase::Sweeps | Phase::Spectrum | Phase::Simulate | Phase::Diagnose | Phase::Report => 0.1,
            Phase::Reduce => 0.5,
        }
    }
}

/// Lines of a file with these words in them.
fn lines(day: &Path, name: &str, words: &str) -> usize {
    let text = std::fs::read_to_string(day.join(name)).unwrap_or_default();
    text.lines().filter(|line| line.contains(words)).count()
}
