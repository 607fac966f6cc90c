//! The light of a sweep where its axis was, as the engine needs it: the reduction knows it better.

use isolux_record::own_clock::ByOwnClock;
use isolux_record::sweeps::SweepRecord;

/// When the light of each conversion with a number was, and that number: the middle in seconds of the run, lx.
pub(crate) fn middles_s(sweep: &SweepRecord) -> Vec<(f64, f64)> {
    if let Some(own) = ByOwnClock::of(sweep) {
        let conversions = own.conversions.iter();
        return conversions
            .map(|one| (0.5 * (one.from_s + one.to_s), one.illuminance_lx))
            .collect();
    }
    let middle_s = |asked_s: f64| asked_s + 0.5 * sweep.of.integration_s;
    let light = sweep.light.iter();
    light
        .filter_map(|sample| Some((middle_s(sample.asked_s), sample.illuminance_lx?)))
        .collect()
}

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
    let middles = middles_s(sweep).into_iter();
    let mut conversions: Vec<(f64, f64)> = middles
        .filter_map(|(time_s, illuminance_lx)| Some((at(time_s)?, illuminance_lx)))
        .collect();
    conversions.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Before and after its motion the axis rests.
    conversions.dedup_by(|a, b| a.0 - b.0 < 1e-3);
    conversions
}
