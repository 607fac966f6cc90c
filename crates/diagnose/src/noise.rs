//! Whether what a fit leaves is noise: readings that scatter more than stated, are correlated, periodic, clustered in
//! place, or different from block to block are a disagreement like any other, and never a larger noise.
//!
//! The null of each test is a permutation of the readings' own residuals, correlated again as uncertainly as their
//! correlation is known and with the refitted terms projected out: heavy tails, outliers and a common factor on the
//! uncertainties are the same in it. The strongest of all tests is compared with the strongest of all tests on the
//! simulated records, so that the number of tests raises no false alarms.

pub(crate) mod finding;
pub mod limits;
mod means;
mod moments;
mod nulls;
mod patches;
mod phases;
mod repeats;
mod residuals;
mod scatter;
pub(crate) mod series;
mod single;
mod spectrum;
mod statistic;

use crate::patterns::{AMONG_BINS, AMONG_READINGS, Grids, IN_THE_LIGHT};
use crate::table::{Coordinate, ObservationKind};

use finding::Strongest;
pub use finding::{Finding, Kind, NoiseTest, Peak};
use limits::{FEWEST, PERMUTED_SHARE, RHO, SCATTER_SHARE, SCATTER_TESTS, SIGNIFICANCE};
use means::Means;
use moments::Moments;
use nulls::Nulls;
use patches::Patches;
use phases::Phases;
use repeats::Repeats;
pub use residuals::Residuals;
use scatter::{Blocks, Trends};
use series::Series;
use spectrum::Spectrum;
use statistic::Test;

/// Tests what a fit leaves, with up to `most` simulated records; none where there are too few rows.
pub fn test(residuals: &Residuals<'_>, most: usize, seed: u64) -> Option<NoiseTest> {
    let of = |source: ObservationKind| {
        let series = Series::new(residuals, source);
        (series.len() >= FEWEST).then(|| one_source(residuals, &series, most, seed))
    };
    let mut tested: Vec<NoiseTest> = [ObservationKind::Reading, ObservationKind::Bin]
        .into_iter()
        .filter_map(of)
        .collect();
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
pub fn strongest_place(residuals: &Residuals<'_>) -> Option<Finding> {
    let series = Series::new(residuals, ObservationKind::Reading);
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
    let kinds: &[Grids] = match series.source {
        ObservationKind::Reading => &AMONG_READINGS,
        _ => &AMONG_BINS,
    };
    let spectra = match series.source {
        ObservationKind::Reading => vec![
            Spectrum::new(series, Coordinate::TimeS, &series.time, 2.0),
            Spectrum::new(series, Coordinate::Index, &series.index, 1.0),
        ],
        _ => Vec::new(),
    };
    (
        kinds.iter().filter_map(|of| Patches::new(series, *of)).collect(),
        spectra.into_iter().flatten().collect(),
    )
}

fn boxed<T: Test + 'static>(tests: impl IntoIterator<Item = T>) -> impl Iterator<Item = Box<dyn Test>> {
    tests.into_iter().map(|test| Box::new(test) as Box<dyn Test>)
}

fn one_source(residuals: &Residuals<'_>, series: &Series<'_>, most: usize, seed: u64) -> NoiseTest {
    let (patches, spectra) = places(series);
    let mut tests: Vec<Box<dyn Test>> = Vec::new();
    if series.source == ObservationKind::Reading {
        tests.extend(boxed(Means::successive(series)));
        tests.extend(boxed(Means::visits(series)));
        tests.extend(boxed(Means::levels(series)));
        tests.extend(boxed(Phases::new(series)));
        tests.extend(boxed(Patches::of_the_light(series, IN_THE_LIGHT)));
        tests.extend(boxed(Moments::new(series)));
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
    tests.extend(boxed(patches));
    tests.extend(boxed(spectra));
    tests.extend(boxed(Blocks::new(series)));
    tests.extend(boxed(Trends::new(series)));

    let observed: Vec<Strongest> = tests.iter().map(|test| test.observed(&series.held)).collect();
    let nulls = Nulls::new(residuals, series, &tests, most, seed);
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
    let repeats = Repeats::of(residuals, series);
    let (mut scattered, limit) = repeats.compare(residuals, series);
    scattered.extend(single::widest(series));
    scattered.extend(single::repeated(residuals, series));
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
    let all = series::hold(&series.place.iter().map(|&i| residuals.plain[i]).collect::<Vec<_>>());
    let parameters = residuals.refitted.rank() as f64;
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
