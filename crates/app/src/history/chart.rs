//! A control chart of individual values (Shewhart; ISO 7870-2): warning at two, action at three standard deviations
//! from the mean.

use serde::Serialize;

use super::Entry;

/// Values that the limits come from at least.
const LEAST: usize = 5;
/// Mean moving range of two values of a normal distribution, in standard deviations: 2/√π, d₂ of ISO 7870-2.
const RANGE_OVER_S: f64 = 1.128;
/// As many values on one side of the mean in a row are a shift (Western Electric 1956, fourth rule).
const ROW: usize = 8;

/// The values of a quantity and what they say.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Chart {
    /// What the values are.
    pub quantity: String,
    /// In the order of the diary.
    pub points: Vec<Entry>,
    /// None with fewer than five values.
    pub limits: Option<Limits>,
    /// Whether the last value is beyond the limits of action, or a run of values on one side of the mean goes up to it.
    pub out_of_control: bool,
    /// In words.
    pub sentence: String,
}

/// Mean and standard deviation of a process.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Limits {
    /// Of the first five values.
    pub mean: f64,
    /// From their moving ranges, which a slow drift does not widen; not below a tenth of the standard uncertainty of a
    /// value: five equal readings are no proof of a process without scatter.
    pub s: f64,
}

/// The charts of a diary, in the order of its quantities.
pub(super) fn of(entries: &[Entry]) -> Vec<Chart> {
    let mut quantities: Vec<&str> = Vec::new();
    for entry in entries {
        if !quantities.contains(&entry.quantity.as_str()) {
            quantities.push(&entry.quantity);
        }
    }
    let points = |quantity: &str| {
        entries
            .iter()
            .filter(|entry| entry.quantity == quantity)
            .cloned()
            .collect()
    };
    quantities
        .into_iter()
        .map(|quantity| chart(quantity, points(quantity)))
        .collect()
}

fn chart(quantity: &str, points: Vec<Entry>) -> Chart {
    let limits = limits(&points);
    let (out_of_control, sentence) = match limits {
        None => (
            false,
            format!("{quantity}: {} values, limits from {LEAST} on", points.len()),
        ),
        Some(limits) => judged(quantity, &points, limits),
    };
    Chart {
        quantity: quantity.to_owned(),
        points,
        limits,
        out_of_control,
        sentence,
    }
}

/// From the first values, which all later ones are judged by.
fn limits(points: &[Entry]) -> Option<Limits> {
    let base = points.get(..LEAST)?;
    let mean = base.iter().map(|entry| entry.value).sum::<f64>() / LEAST as f64;
    let ranges: f64 = base.windows(2).map(|pair| (pair[1].value - pair[0].value).abs()).sum();
    let s = ranges / (LEAST - 1) as f64 / RANGE_OVER_S;
    let u = base.iter().map(|entry| entry.u).sum::<f64>() / LEAST as f64;
    Some(Limits {
        mean,
        s: s.max(0.1 * u).max(1e-9 * mean.abs()).max(f64::MIN_POSITIVE),
    })
}

fn judged(quantity: &str, points: &[Entry], limits: Limits) -> (bool, String) {
    let sigmas = |entry: &Entry| (entry.value - limits.mean) / limits.s;
    let since = |from: usize| {
        points
            .get(from)
            .map_or("", |entry| entry.time_utc.get(..10).unwrap_or(""))
    };
    let Some(last) = points.last().map(sigmas) else {
        return (false, String::new());
    };
    // The values at the end that lie where the last one does.
    let back =
        |holds: &dyn Fn(f64) -> bool| points.len() - points.iter().rev().take_while(|one| holds(sigmas(one))).count();
    let change = last * limits.s;
    // A zero has no per cent.
    let change = if limits.mean.abs() > 10.0 * limits.s {
        format!("{:+.2} %", 100.0 * change / limits.mean)
    } else {
        format!(
            "{change:+.2e} {}",
            points.first().map_or("", |entry| entry.unit.as_str())
        )
    };
    if last.abs() > 3.0 {
        let from = back(&|one| one.signum() == last.signum() && one.abs() > 3.0);
        let words = format!(
            "{quantity}: out of the limits of action since {}: {change}, {last:+.1} standard deviations",
            since(from)
        );
        return (true, words);
    }
    let from = back(&|one| one.signum() == last.signum());
    if points.len() - from >= ROW {
        let words = format!(
            "{quantity}: on one side of the mean since {}, {} times: {change}",
            since(from),
            points.len() - from
        );
        return (true, words);
    }
    if last.abs() > 2.0 {
        return (
            false,
            format!("{quantity}: warning, {change}, {last:+.1} standard deviations; calibrate again"),
        );
    }
    (
        false,
        format!("{quantity}: in control, {change}, {last:+.1} standard deviations"),
    )
}

#[cfg(test)]
mod tests {
    use super::super::Kind;
    use super::*;

    fn entries(values: &[f64]) -> Vec<Entry> {
        let entry = |(day, value): (usize, &f64)| Entry {
            time_utc: format!("2026-01-{:02}T00:00:00Z", day + 1),
            kind: Kind::Calibration,
            quantity: "luxmeter: factor".to_owned(),
            value: *value,
            unit: String::new(),
            u: 0.004,
            run: "run".to_owned(),
            record_sha256: String::new(),
        };
        values.iter().enumerate().map(entry).collect()
    }

    fn said(values: &[f64]) -> (bool, String) {
        let chart = of(&entries(values)).remove(0);
        (chart.out_of_control, chart.sentence)
    }

    #[test]
    fn a_drift_is_named_with_the_day_on_which_it_began() {
        let base = [1.000, 1.002, 0.999, 1.001, 0.998];
        // Moving ranges 0.002, 0.003, 0.002, 0.003: s = 0.0025/1.128 = 0.00222 about 1.
        let limits = of(&entries(&base)).remove(0).limits.unwrap();
        assert!((limits.mean - 1.0).abs() < 1e-12 && (limits.s - 0.0025 / 1.128).abs() < 1e-12);
        assert!(said(&base[..4]).1.contains("limits from 5 on"));
        let with = |more: &[f64]| said(&[&base[..], more].concat());
        assert!(!with(&[1.003]).0);
        assert!(with(&[1.003]).1.contains("in control"));
        assert!(with(&[1.005]).1.contains("warning, +0.50 %"));
        let (out, words) = with(&[1.001, 1.009, 1.012]);
        assert!(out && words.contains("limits of action since 2026-01-07"), "{words}");
        let (out, words) = with(&[1.001, 1.002, 1.001, 1.003, 1.001, 1.002, 1.002, 1.003]);
        assert!(out && words.contains("since 2026-01-06, 8 times"), "{words}");
        // One value beyond the limits and back is no drift any more.
        assert!(!with(&[1.02, 1.0]).0);
    }
}
