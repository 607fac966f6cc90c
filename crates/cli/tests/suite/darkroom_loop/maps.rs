//! How far apart, in the camera's noise, a recorded and a predicted set of maps are.

use std::path::Path;

/// rms((recorded − gain · predicted) / u) over the lit bins of all maps, one gain fitted, and that gain.
pub fn gap(recorded: &Path, predicted: &Path) -> (f64, f64) {
    let recorded = columns(recorded, &["signal", "u"]);
    let predicted = columns(predicted, &["predicted_signal"]);
    assert_eq!(recorded.len(), predicted.len(), "one prediction a bin");
    let pairs = || {
        recorded
            .iter()
            .zip(&predicted)
            .map(|(row, guess)| (row[0], row[1], guess[0]))
    };
    let (mut product, mut square) = (0.0, 0.0);
    for (signal, u, guess) in pairs() {
        product += signal * guess / (u * u);
        square += guess * guess / (u * u);
    }
    let gain = product / square;
    let sum: f64 = pairs()
        .map(|(signal, u, guess)| ((signal - gain * guess) / u).powi(2))
        .sum();
    ((sum / recorded.len() as f64).sqrt(), gain)
}

fn columns(file: &Path, names: &[&str]) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(file).expect("a CSV");
    let mut lines = text.lines();
    let head: Vec<&str> = lines.next().expect("a header").split(',').collect();
    let places: Vec<usize> = names
        .iter()
        .map(|name| head.iter().position(|column| column == name).expect("the column"))
        .collect();
    lines
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            places
                .iter()
                .map(|&place| cells[place].parse().expect("a number"))
                .collect()
        })
        .collect()
}
