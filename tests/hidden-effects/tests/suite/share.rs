//! The interval of a share.

use isolux_hidden_effects::suite::wilson;

#[test]
fn wilson_agrees_with_its_published_example() {
    // Wilson (1927) interval for 81 of 263, z = 1.96: 0.2553 … 0.3662 (Newcombe 1998, table I).
    let [low, high] = wilson(81, 263);
    assert!(
        (low - 0.2553).abs() < 1e-4 && (high - 0.3662).abs() < 1e-4,
        "{low} {high}"
    );
}
