//! The light of a sweep where its axis was, as the engine needs it: the reduction knows it better.

use isolux_record::sweeps::SweepRecord;

/// Where the axis was at the middle of each conversion with a number, rising, degrees, and that number; those of an
/// axis that stood still are none.
pub(crate) fn conversions(sweep: &SweepRecord) -> Vec<(f64, f64)> {
    let positions = &sweep.positions;
    let at = |time_s: f64| {
        let next = positions.partition_point(|position| position.answered_s < time_s);
        let (before, after) = (positions.get(next.checked_sub(1)?)?, positions.get(next)?);
        let share = (time_s - before.answered_s) / (after.answered_s - before.answered_s);
        Some(before.place_deg + share * (after.place_deg - before.place_deg))
    };
    let whole = sweep.light.iter().filter_map(|sample| {
        let place_deg = at(sample.asked_s + 0.5 * sweep.of.integration_s)?;
        Some((place_deg, sample.illuminance_lx?))
    });
    let mut conversions: Vec<(f64, f64)> = whole.collect();
    conversions.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Before and after its motion the axis rests.
    conversions.dedup_by(|a, b| a.0 - b.0 < 1e-3);
    conversions
}
