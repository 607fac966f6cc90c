//! What to measure where what is left is no noise: the axes at rest, the same place again, the same block again.

use super::block::{Next, READING_S, middle_one, nominal};
use crate::calibration::WORTH_NAMING_SIGMA;
use crate::document::NextEntry;
use crate::noise::{Finding, Kind, NoiseTest};
use crate::table::{Light, ObservationKind, Row};

/// Readings of each kind at rest.
const LIT: usize = 240;
const DARK: usize = 60;
/// Readings of each pose that is visited again.
const AGAIN: usize = 5;
/// Minutes to begin.
const BEGIN_MIN: f64 = 2.0;

/// Adds the measurement that would show the cause of the strongest finding on readings.
pub(super) fn suggest(next: &mut Next, test: &NoiseTest, rows: &[Row]) {
    let illuminated: Vec<(usize, &Row)> = rows
        .iter()
        .enumerate()
        .filter(|(_, row)| row.source == ObservationKind::Reading && row.light == Light::Lit)
        .collect();
    let (Some(finding), Some(distance)) = (
        test.findings.first(),
        middle_one(illuminated.iter().map(|(_, row)| row.distance_mm).collect()),
    ) else {
        return;
    };
    let (entry, plan) = match (finding.kind, finding.direction) {
        (Kind::Directions, Some(patch)) => again_there(finding, patch, &illuminated, distance),
        (Kind::Blocks | Kind::Run, _) => {
            same_block(finding, &illuminated, distance).unwrap_or_else(|| at_rest(finding, &illuminated, distance))
        }
        _ => at_rest(finding, &illuminated, distance),
    };
    if entry.expected_sigma >= WORTH_NAMING_SIGMA {
        let file = "next.noise.plan.toml".to_owned();
        next.entries.push(NextEntry {
            plan: Some(file.clone()),
            ..entry
        });
        next.plans.push((file, plan));
    }
}

fn entry(what: &'static str, splits: [&str; 2], readings: usize, expected_sigma: f64) -> NextEntry {
    NextEntry {
        what: what.into(),
        splits: splits.map(str::to_owned),
        plan: None,
        expected_sigma,
        minutes: readings as f64 * READING_S / 60.0 + BEGIN_MIN,
    }
}

/// Lit, lamp-off and capped readings with the axes at rest: an error of time stays, one of the motion goes; which of
/// the three kinds show it says whether lamp, room or meter make it.
fn at_rest(finding: &Finding, illuminated: &[(usize, &Row)], distance: f64) -> (NextEntry, String) {
    let c = illuminated.first().map_or(0.0, |(_, row)| nominal(row.c_deg));
    let mut plan = String::from("format = \"isolux-plan/1\"\nname = \"at_rest\"\n");
    for (kind, repeats) in [("capped", DARK), ("lamp_off", DARK), ("lit", LIT)] {
        plan += &block(kind, kind, &[c], "gamma_deg = [0.0]", distance, repeats);
    }
    let expected = finding.explained.sqrt() * (LIT as f64 / illuminated.len().max(1) as f64).sqrt();
    let splits = ["unnamed:time_s", "unnamed:index"];
    (entry("at_rest", splits, LIT + 2 * DARK, expected), plan)
}

/// The directions of a patch and those around it, in finer steps and several times: light from there stays, a moment
/// does not come again.
fn again_there(
    finding: &Finding,
    patch: [f64; 3],
    illuminated: &[(usize, &Row)],
    distance: f64,
) -> (NextEntry, String) {
    let [c_deg, gamma_deg, width] = patch;
    let across = (2.0 * width / gamma_deg.to_radians().sin().abs().max(0.2)).min(60.0);
    let planes = [-1.0, -0.5, 0.0, 0.5, 1.0].map(|part: f64| nominal((c_deg + part * across).rem_euclid(360.0)));
    let reach = |pick: fn(f64, f64) -> f64| illuminated.iter().map(|(_, row)| row.gamma_deg).fold(gamma_deg, pick);
    let step = nominal((0.5 * width).max(0.5));
    let low = nominal((gamma_deg - 2.0 * width).max(reach(f64::min)));
    let count = ((nominal((gamma_deg + 2.0 * width).min(reach(f64::max))) - low) / step).floor();
    let angles = format!("gamma_range = [{low:?}, {:?}, {step:?}]", nominal(low + count * step));
    let readings = planes.len() * (count as usize + 1) * AGAIN;
    let plan = format!(
        "format = \"isolux-plan/1\"\nname = \"same_place\"\n{}",
        block("same_place", "lit", &planes, &angles, distance, AGAIN)
    );
    let expected = finding.explained.sqrt() * (AGAIN as f64).sqrt();
    let splits = ["unnamed:gamma_deg", "unnamed:time_s"];
    (entry("same_place", splits, readings, expected), plan)
}

/// The poses of a block again: what belongs to them stays, what happened then does not come again. None where the
/// readings have no lit pose.
fn same_block(finding: &Finding, illuminated: &[(usize, &Row)], distance: f64) -> Option<(NextEntry, String)> {
    let number = |i: usize, row: &Row| if row.index.is_finite() { row.index } else { i as f64 };
    let inside = illuminated.iter().filter(|(i, row)| {
        let at = number(*i, row);
        at >= finding.range[0] && at <= finding.range[1]
    });
    let inside: Vec<&Row> = inside.map(|(_, row)| *row).collect();
    let sorted = |angle: fn(&Row) -> f64| {
        let mut angles: Vec<f64> = inside.iter().map(|row| nominal(angle(row))).collect();
        angles.sort_by(f64::total_cmp);
        angles.dedup();
        angles
    };
    let (planes, angles) = (sorted(|row| row.c_deg), sorted(|row| row.gamma_deg));
    let distance = middle_one(inside.iter().map(|row| row.distance_mm).collect()).unwrap_or(distance);
    let readings = planes.len() * angles.len() * AGAIN;
    if planes.is_empty() || planes.len() > 12 || readings > 1500 {
        return None;
    }
    let list: Vec<String> = angles.iter().map(|angle| format!("{angle:?}")).collect();
    let angles = format!("gamma_deg = [{}]", list.join(", "));
    let plan = format!(
        "format = \"isolux-plan/1\"\nname = \"same_block\"\n{}",
        block("same_block", "lit", &planes, &angles, distance, AGAIN)
    );
    let expected = finding.explained.sqrt() * (AGAIN as f64).sqrt();
    Some((
        entry("same_block", ["unnamed:noise", "unnamed:time_s"], readings, expected),
        plan,
    ))
}

fn block(name: &str, kind: &str, planes: &[f64], angles: &str, distance: f64, repeats: usize) -> String {
    let planes: Vec<String> = planes.iter().map(|c| format!("{c:?}")).collect();
    format!(
        "\n[[block]]\nname = \"{name}\"\nkind = \"{kind}\"\nc_deg = [{}]\n{angles}\ndistance_mm = {distance:?}\nrepeats = {repeats}\n",
        planes.join(", ")
    )
}
