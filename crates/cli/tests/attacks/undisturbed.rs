//! What the attacks are compared with: the same bench, the same plan, and nobody who disturbs it.

use crate::support::Bench;

pub fn a_scan_that_nobody_disturbs_is_complete_and_right() {
    let bench = Bench::new();
    let stated = bench.isolux(&["scan", "station.toml", "plan.toml", "--out", "run"], 0);
    assert!(stated.contains("6 points"), "{stated}");
    bench.assert_complete("run");
    bench.assert_true("run");
    bench.assert_at_rest();
}
