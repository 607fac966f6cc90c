//! What a test of the noise finds.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::limits::SCALE;
use crate::table::Coordinate;

/// What the test of the noise found.
#[derive(Debug, Clone)]
pub struct NoiseTest {
    /// Probability of the strongest of all tests under noise alone.
    pub p_value: f64,
    /// Standard deviation of the residuals, outliers held, in units of the stated uncertainties.
    pub scatter: f64,
    /// The largest scatter that counts as noise here.
    pub limit: f64,
    /// Scatter of the repeats of one pose, and their degrees of freedom, where there are enough.
    pub repeats: Option<(f64, f64)>,
    /// What is no noise, strongest first; empty where all is.
    pub findings: Vec<Finding>,
    /// The strongest periods, and the significance (σ) of each alone.
    pub spectrum: Vec<Peak>,
}

/// A peak of a periodogram.
#[derive(Debug, Clone, Copy)]
pub struct Peak {
    /// Over what: time or number.
    pub coordinate: Coordinate,
    /// In seconds or readings.
    pub period: f64,
    /// √ of what it explains, in σ.
    pub sigma: f64,
}

/// The test that found something.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Every n-th reading.
    Every,
    /// Every n-th visit of a half-plane.
    EveryVisit,
    /// A run of successive readings.
    Run,
    /// Neighbouring directions.
    Directions,
    /// Directions along a great circle.
    GreatCircle,
    /// Columns or rows of bins.
    Lines,
    /// Neighbouring bins.
    Bins,
    /// A period in time or number.
    Period,
    /// Periods that come, go or change.
    Stretches,
    /// A period that begins anew in every visit of a half-plane.
    Phases,
    /// Means of successive readings wander.
    Means,
    /// Visits of half-planes, or parts of them, have levels of their own.
    Visits,
    /// One γ or one light has a level of its own.
    Levels,
    /// One block scatters more than the others.
    Blocks,
    /// The scatter grows along a coordinate.
    Trend,
    /// More scatter than stated.
    Scatter,
    /// More scatter than repeats of a pose show.
    Repeats,
    /// One reading is further off than outliers are.
    Outlier,
    /// Readings repeat the value before.
    Repeated,
}

/// One way in which the residuals are no noise.
#[derive(Debug, Clone)]
pub struct Finding {
    /// Which.
    pub kind: Kind,
    /// Where: `noise` for a scatter, else the coordinate.
    pub coordinate: Coordinate,
    /// The part of the coordinate; numbers of readings for `noise`.
    pub range: [f64; 2],
    /// Its period, in seconds or readings.
    pub period: Option<f64>,
    /// C, γ and width of a patch of directions, in degrees.
    pub direction: Option<[f64; 3]>,
    /// Significance in σ.
    pub sigma: f64,
    /// What it makes of the squared residuals, in σ².
    pub explained: f64,
    /// Probability of this test alone under noise.
    pub p_value: f64,
    /// In words.
    pub note: String,
}

impl Finding {
    pub(crate) fn new(kind: Kind, coordinate: Coordinate, range: [f64; 2], strongest: Strongest, note: String) -> Self {
        let explained = 2.0 * strongest.half_square;
        Self {
            kind,
            coordinate,
            range,
            period: None,
            direction: None,
            sigma: explained.sqrt(),
            explained,
            p_value: 1.0,
            note,
        }
    }

    pub(super) fn with_period(self, period: f64) -> Self {
        Self {
            period: Some(period),
            ..self
        }
    }

    /// The same, when so much of the squared residuals is its, outliers and all.
    pub(crate) fn explaining(self, explained: f64) -> Self {
        Self { explained, ..self }
    }
}

impl NoiseTest {
    /// Whether something is left that is no noise.
    pub fn disagrees(&self) -> bool {
        !self.findings.is_empty()
    }

    /// What the strongest finding makes of the squared residuals, in σ².
    pub fn explained(&self) -> f64 {
        self.findings
            .iter()
            .map(|finding| finding.explained)
            .fold(0.0, f64::max)
    }

    /// The same, when what was found does not matter.
    #[must_use]
    pub fn without_findings(self) -> Self {
        Self {
            findings: Vec::new(),
            ..self
        }
    }

    /// What is left, in words.
    pub fn note(&self) -> String {
        let mut parts = Vec::new();
        if self.scatter > SCALE {
            parts.push(format!(
                "the readings scatter {:.1} times as much as stated",
                self.scatter
            ));
        }
        let stated = |kind: Kind| kind == Kind::Scatter && !parts.is_empty();
        let more: Vec<String> = self
            .findings
            .iter()
            .filter(|finding| !stated(finding.kind))
            .take(2)
            .map(|finding| finding.note.clone())
            .collect();
        parts.extend(more);
        parts.join(", ")
    }
}

/// The strongest place of one test.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Strongest {
    /// Half of the squared significance.
    pub half_square: f64,
    /// Which place.
    pub place: usize,
}

impl Strongest {
    pub fn raise(&mut self, half_square: f64, place: usize) {
        if half_square > self.half_square {
            *self = Self { half_square, place };
        }
    }
}

/// A number with three digits, and no minus before a zero.
pub(crate) fn digits(value: f64) -> String {
    isolux_model::digits(value + 0.0, 3)
}
