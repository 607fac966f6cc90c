//! Whether what a fit leaves is noise: readings that scatter more than stated, are correlated, periodic, clustered in
//! place, or different from block to block are a disagreement like any other, and never a larger noise.
//!
//! The null of each test is a permutation of the readings' own residuals, correlated again as uncertainly as their
//! correlation is known and with the refitted terms projected out: heavy tails, outliers and a common factor on the
//! uncertainties are the same in it. The strongest of all tests is compared with the strongest of all tests on the
//! simulated records, so that the number of tests raises no false alarms.

pub mod limits;
mod means;
mod moments;
mod nulls;
mod patches;
mod repeats;
mod scatter;
mod series;
mod single;
mod spectrum;

use nalgebra::DVector;

use crate::basis::Basis;
use crate::table::{Coordinate, Row, Source};
use crate::whitening::Sequence;

use limits::{FEWEST, PERMUTED_SHARE, RHO, SCALE, SCATTER_SHARE, SCATTER_TESTS, SIGNIFICANCE};
use means::{Means, Visits};
use moments::Moments;
use nulls::Nulls;
use patches::Patches;
use repeats::Repeats;
use scatter::{Blocks, Neighbours, Trends};
use series::Series;
use spectrum::Spectrum;

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

/// The kind of a finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// More scatter than stated.
    Scatter,
    /// More scatter than repeats of a pose show.
    Repeats,
    /// Neighbours in time are correlated.
    Correlation,
    /// A period in time or number.
    Periodic,
    /// Every n-th reading.
    Every,
    /// A run of successive readings.
    Run,
    /// Means of successive readings wander.
    Means,
    /// Neighbouring directions or bins.
    Patch,
    /// One reading is further off than outliers are.
    Outlier,
    /// Readings repeat the value before.
    Repeated,
    /// One block scatters more than the others.
    Blocks,
    /// The scatter grows along a coordinate.
    Trend,
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
    fn new(kind: Kind, coordinate: Coordinate, range: [f64; 2], strongest: Strongest, note: String) -> Self {
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

    fn with_period(self, period: f64) -> Self {
        Self {
            period: Some(period),
            ..self
        }
    }

    /// The same, when so much of the squared residuals is its, outliers and all.
    fn explaining(self, explained: f64) -> Self {
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
        let said = |kind: Kind| kind == Kind::Scatter && !parts.is_empty();
        let more: Vec<String> = self
            .findings
            .iter()
            .filter(|finding| !said(finding.kind))
            .take(2)
            .map(|finding| finding.note.clone())
            .collect();
        parts.extend(more);
        parts.join(", ")
    }
}

/// What a fit leaves.
#[derive(Debug)]
pub struct Left<'a> {
    /// The rows.
    pub rows: &'a [Row],
    /// What the model expects of each.
    pub level: Vec<f64>,
    /// (measured − expected)/stated u.
    pub plain: DVector<f64>,
    /// The same, whitened with the correlation `rho` and without outlier weights, what was refitted projected out.
    pub whitened: DVector<f64>,
    /// What was refitted, whitened alike.
    pub refitted: Basis,
    /// Order in time.
    pub sequence: &'a Sequence,
    /// Correlation that counts as noise.
    pub rho: f64,
    /// Correlation that the residuals show.
    pub rho_found: f64,
    /// Its standard uncertainty; 0 where there is none.
    pub u_rho: f64,
    /// Fitted scatter in units of the stated uncertainties, and its degrees of freedom.
    pub scale: f64,
    /// Its degrees of freedom.
    pub freedom: f64,
    /// The noise in which the search counts its σ: the fitted scatter, or 1 where the stated uncertainties hold. What a
    /// place explains is compared with what a name explains, and counts in the same unit.
    pub unit: f64,
}

/// The strongest place of one test.
#[derive(Debug, Clone, Copy, Default)]
struct Strongest {
    /// Half of the squared significance.
    half_square: f64,
    /// Which place.
    place: usize,
}

impl Strongest {
    fn raise(&mut self, half_square: f64, place: usize) {
        if half_square > self.half_square {
            *self = Self { half_square, place };
        }
    }
}

/// One test of the residuals.
trait Test: Sync {
    /// The strongest place in values of unit variance.
    fn strongest(&self, values: &[f64]) -> Strongest;

    /// The strongest place of the observed values that would matter.
    fn observed(&self, values: &[f64]) -> Strongest {
        self.strongest(values)
    }

    /// What that place is.
    fn finding(&self, strongest: Strongest, series: &Series<'_>) -> Finding;
}

/// Tests what a fit leaves, with up to `most` simulated records; none where there are too few rows.
pub fn test(left: &Left<'_>, most: usize, seed: u64) -> Option<NoiseTest> {
    let of = |source: Source| {
        let series = Series::new(left, source);
        (series.len() >= FEWEST).then(|| one_source(left, &series, most, seed))
    };
    let mut tested: Vec<NoiseTest> = [Source::Reading, Source::Bin].into_iter().filter_map(of).collect();
    let kinds = tested.len() as f64;
    tested.sort_by(|a, b| a.p_value.total_cmp(&b.p_value));
    let mut first = tested.into_iter().next()?;
    first.p_value = (first.p_value * kinds).min(1.0);
    if first.p_value > SIGNIFICANCE {
        first.findings.clear();
    }
    Some(first)
}

/// The place without a name (a period, every n-th reading, a run, a patch) that explains most of what a fit leaves,
/// significant or not.
pub fn strongest_place(left: &Left<'_>) -> Option<Finding> {
    let series = Series::new(left, Source::Reading);
    if series.len() < FEWEST {
        return None;
    }
    let (patches, spectra) = places(&series);
    let patches = patches.iter().map(|test| test as &dyn Test);
    let tests = patches.chain(spectra.iter().map(|test| test as &dyn Test));
    tests
        .map(|test| test.finding(test.strongest(&series.held), &series))
        .max_by(|a, b| a.explained.total_cmp(&b.explained))
}

/// The tests for a place, with one amplitude or a phase each.
fn places(series: &Series<'_>) -> (Vec<Patches>, Vec<Spectrum>) {
    let patches: &[fn(&Series<'_>) -> Option<Patches>] = match series.source {
        Source::Reading => &[Patches::every, Patches::every_visit, Patches::runs, Patches::directions],
        _ => &[Patches::lines, Patches::bins],
    };
    let spectra = match series.source {
        Source::Reading => vec![
            Spectrum::new(series, Coordinate::TimeS, &series.time, 2.0),
            Spectrum::new(series, Coordinate::Index, &series.index, 1.0),
        ],
        _ => Vec::new(),
    };
    (
        patches.iter().filter_map(|of| of(series)).collect(),
        spectra.into_iter().flatten().collect(),
    )
}

fn one_source(left: &Left<'_>, series: &Series<'_>, most: usize, seed: u64) -> NoiseTest {
    let (patches, spectra) = places(series);
    let mut tests: Vec<Box<dyn Test>> = Vec::new();
    if series.source == Source::Reading {
        tests.push(Box::new(Means::new(series)));
        tests.extend(Visits::new(series).map(|test| Box::new(test) as Box<dyn Test>));
        tests.extend(Moments::new(series).map(|test| Box::new(test) as Box<dyn Test>));
        tests.extend(Neighbours::new(series, left.rho).map(|test| Box::new(test) as Box<dyn Test>));
    }
    let peaks = spectra
        .iter()
        .flat_map(|spectrum| {
            spectrum.peaks(&series.held, 3).into_iter().map(|(period, power)| Peak {
                coordinate: spectrum.coordinate(),
                period,
                sigma: (2.0 * power).sqrt(),
            })
        })
        .collect();
    tests.extend(patches.into_iter().map(|test| Box::new(test) as Box<dyn Test>));
    tests.extend(spectra.into_iter().map(|test| Box::new(test) as Box<dyn Test>));
    tests.extend(Blocks::new(series).map(|test| Box::new(test) as Box<dyn Test>));
    tests.extend(Trends::new(series).map(|test| Box::new(test) as Box<dyn Test>));

    let observed: Vec<Strongest> = tests.iter().map(|test| test.observed(&series.held)).collect();
    let nulls = Nulls::new(left, series, &tests, most, seed);
    let permuted = nulls.combined(&observed);
    let mut findings: Vec<Finding> = tests
        .iter()
        .zip(&observed)
        .enumerate()
        .map(|(number, (test, &strongest))| {
            let mut finding = test.finding(strongest, series);
            finding.p_value = nulls.alone(number, strongest.half_square) / PERMUTED_SHARE;
            finding
        })
        .collect();
    let repeats = Repeats::of(left, series);
    let (mut scattered, limit) = repeats.compare(left, series);
    scattered.extend(single::widest(series));
    scattered.extend(single::repeated(left, series));
    let scatter = scattered.iter().map(|finding| finding.p_value).fold(1.0, f64::min) * SCATTER_TESTS;
    let p_scatter = scatter.min(1.0);
    // Two independent probabilities of one hypothesis (Fisher 1925).
    let product = (permuted * p_scatter).max(f64::MIN_POSITIVE);
    let both = product * (1.0 - product.ln());
    let p_value = (permuted / PERMUTED_SHARE)
        .min(p_scatter / SCATTER_SHARE)
        .min(both / (1.0 - PERMUTED_SHARE - SCATTER_SHARE))
        .min(1.0);
    findings.extend(scattered);
    findings.sort_by(|a, b| a.p_value.total_cmp(&b.p_value).then(b.sigma.total_cmp(&a.sigma)));
    // The strongest stands for what only several find together.
    let clear = findings
        .iter()
        .filter(|finding| finding.p_value <= SIGNIFICANCE)
        .count();
    findings.truncate(clear.max(1));
    let all = series::hold(&series.place.iter().map(|&i| left.plain[i]).collect::<Vec<_>>());
    let parameters = left.refitted.rank() as f64;
    let freedom = (all.len() as f64 - parameters).max(1.0);
    NoiseTest {
        p_value,
        scatter: (all.iter().map(|value| value * value).sum::<f64>() / freedom).sqrt(),
        limit,
        repeats: repeats.visits(),
        findings,
        spectrum: peaks,
    }
}

/// The correlation of two that counts as noise.
pub fn noisy_rho(rho: f64) -> f64 {
    rho.min(RHO)
}

/// A number with three digits, and no minus before a zero.
fn digits(value: f64) -> String {
    isolux_model::digits(value + 0.0, 3)
}
