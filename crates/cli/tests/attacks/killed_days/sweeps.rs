//! The sweeps of a day and the intensities that they give.

use std::path::Path;

/// A sweep as it stands in the folder of a day.
#[derive(Debug, Clone, PartialEq)]
pub struct Sweep {
    /// What it went along, and whether it is torn.
    pub way: Vec<String>,
    text: String,
}

/// The sweeps of a day in the order in which they were made; none of a day at rest.
pub fn sweeps(day: &Path) -> Vec<Sweep> {
    let Ok(entries) = std::fs::read_dir(day.join("sweeps")) else {
        return Vec::new();
    };
    let mut files: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
    // The name of a file that is not yet whole ends otherwise.
    files.retain(|path| path.extension().is_some_and(|extension| extension == "csv"));
    files.sort();
    let sweep = |path: &std::path::PathBuf| {
        let text = std::fs::read_to_string(path).unwrap();
        let is_way = |line: &&str| {
            ["c_target_deg", "ring_to_c_deg", "gamma_deg = ", "torn"]
                .iter()
                .any(|key| line.strip_prefix("# ").is_some_and(|line| line.starts_with(key)))
        };
        let way = text.lines().filter(is_way).map(str::to_owned).collect();
        Sweep { way, text }
    };
    files.iter().map(sweep).collect()
}

/// How many of the sweeps that stood when the program was killed were made again: those whose samples are others now.
pub fn repeated(stood: &[Sweep], now: &[Sweep]) -> usize {
    let is_kept = |(index, sweep): (usize, &Sweep)| now.get(index) == Some(sweep);
    stood.iter().enumerate().filter(|sweep| !is_kept(*sweep)).count()
}

/// Each direction of a day with its intensity, cd, and U (k = 2), cd; empty without such a file.
pub fn directions(csv: &str) -> Vec<(String, f64, f64)> {
    let mut lines = csv.lines();
    let columns: Vec<&str> = lines.next().unwrap().split(',').collect();
    let place = |name: &str| columns.iter().position(|column| *column == name).unwrap();
    let [c, gamma, intensity, u] = ["c_deg", "gamma_deg", "intensity_cd", "u_cd"].map(place);
    let direction = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |at: usize| cells[at].parse::<f64>().unwrap();
        (
            format!("C {}°, γ {}°", cells[c], cells[gamma]),
            number(intensity),
            2.0 * number(u),
        )
    };
    lines.map(direction).collect()
}
