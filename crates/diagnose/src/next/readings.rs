//! Blocks that a goniometer could measure.

use isolux_record::ReadingKind;
use isolux_record::observation::ReadingCoordinates;

use super::block::{Block, READING_S, median, nominal};
use crate::assumed::Part;
use crate::search::Outcome;
use crate::table::{Light, Row, Source};

pub(super) fn reading_blocks(outcome: &Outcome, rows: &[Row], repeats: usize, blocks: &mut Vec<Block>) {
    let readings: Vec<&Row> = rows.iter().filter(|row| row.source == Source::Reading).collect();
    let lit: Vec<&Row> = readings.iter().copied().filter(|row| row.light == Light::Lit).collect();
    let Some(distance) = median(lit.iter().map(|row| row.distance_mm).collect()) else {
        return;
    };
    let scale = outcome.noise.scale;
    let u_rel = median(lit.iter().map(|row| row.u / row.measured.abs().max(1e-12)).collect()).unwrap_or(0.005) * scale;
    let u_floor = readings.iter().map(|row| row.u).fold(f64::INFINITY, f64::min) * scale;
    let peak = lit.iter().map(|row| row.measured).fold(0.0, f64::max);
    let temperature = median(readings.iter().map(|row| row.ambient_c).collect()).filter(|t| t.is_finite());
    let end = readings.iter().map(|row| row.time_s).fold(f64::NEG_INFINITY, f64::max);
    let end = if end.is_finite() { end } else { 3600.0 };
    let Some((low, high, step)) = grid(lit.iter().map(|row| row.gamma_deg)) else {
        return;
    };
    let mut planes: Vec<f64> = lit.iter().map(|row| nominal(row.c_deg)).collect();
    planes.sort_by(f64::total_cmp);
    planes.dedup();
    let Some(&first_plane) = planes.first() else { return };
    let level = |gamma: f64, distance_mm: f64| {
        let near = lit.iter().min_by(|a, b| {
            ((a.gamma_deg - gamma).abs() + (a.distance_mm - distance).abs())
                .total_cmp(&((b.gamma_deg - gamma).abs() + (b.distance_mm - distance).abs()))
        });
        near.map_or(peak, |row| row.measured * (row.distance_mm / distance_mm).powi(2))
    };
    // Expected light, and the range that the reading nearest to it was taken in.
    let look = |gamma_deg: f64, distance_mm: f64| {
        let level = level(gamma_deg, distance_mm);
        let off = |row: &Row| (row.measured - level).abs();
        let near = lit.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
        (level, near.map(|row| row.range as i32))
    };
    let (_, range_ahead) = look(0.0, distance);
    let ahead = |kind, k: usize| ReadingCoordinates {
        kind,
        time_s: Some(end + 60.0 + READING_S * k as f64),
        c_deg: first_plane,
        gamma_deg: 0.0,
        distance_mm: distance,
        travel: 0,
        range: range_ahead,
        ambient_c: temperature,
    };
    let mut scan = |what: &'static str, c: &[f64], distance_mm: f64, travel: i8| {
        let count = ((high - low) / step).round() as usize;
        let repeats = repeats.min(MOST_READINGS / ((count + 1) * c.len())).max(1);
        let looks: Vec<(f64, (f64, Option<i32>))> = (0..=count)
            .map(|k| {
                let gamma = if travel >= 0 {
                    low + k as f64 * step
                } else {
                    high - k as f64 * step
                };
                (gamma, look(gamma, distance_mm))
            })
            .collect();
        let (mut coordinates, mut sigma) = (Vec::new(), Vec::new());
        for &c_deg in c {
            for &(gamma_deg, (level, range)) in &looks {
                for _ in 0..repeats {
                    coordinates.push(ReadingCoordinates {
                        c_deg,
                        gamma_deg,
                        distance_mm,
                        travel,
                        range,
                        ..ahead(ReadingKind::Lit, coordinates.len())
                    });
                    sigma.push((u_rel * level).hypot(u_floor));
                }
            }
        }
        let order = if travel >= 0 { "forward" } else { "reverse" };
        let list = c.iter().map(|c| format!("{c:?}")).collect::<Vec<_>>().join(", ");
        let plan = format!(
            "format = \"isolux-plan/1\"\nname = \"{what}\"\n\n[[block]]\nname = \"{what}\"\nkind = \"lit\"\nc_deg = [{list}]\n\
             gamma_range = [{low:?}, {high:?}, {step:?}]\ndistance_mm = {distance_mm:?}\norder = \"{order}\"\nrepeats = {repeats}\n"
        );
        let minutes = coordinates.len() as f64 * READING_S / 60.0 + 1.0;
        blocks.push(Block {
            what,
            part: Part::Readings(coordinates),
            sigma,
            minutes,
            plan,
        });
    };
    let two: Vec<f64> = match planes.get(planes.len() / 2) {
        Some(&other) if other != first_plane => vec![first_plane, other],
        _ => vec![first_plane],
    };
    let has_way = |way: f64| lit.iter().any(|row| row.travel == way);
    let reverse = if has_way(-1.0) && !has_way(1.0) { 1 } else { -1 };
    scan("reverse_travel", &two, distance, reverse);
    let shortest = lit.iter().map(|row| row.distance_mm).fold(f64::INFINITY, f64::min);
    let short = if shortest < 0.6 * distance {
        0.5 * shortest
    } else {
        0.5 * distance
    };
    scan("second_distance", &two, short, 1);
    let turned: Vec<f64> = two.iter().map(|c| (c + 180.0).rem_euclid(360.0)).collect();
    scan("rotate_c_180", &turned, distance, 1);
    if repeats > 1 {
        // As many directions as there are, where it is the number of readings that is wanting.
        let every = planes.len().div_ceil(MOST_PLANES);
        let spread: Vec<f64> = planes.iter().copied().step_by(every.max(1)).collect();
        scan("repeat_scan", &spread, distance, 1);
    }
    let darks = DARKS * repeats;
    let dark: Vec<ReadingCoordinates> = [ReadingKind::LampOff, ReadingKind::Capped]
        .into_iter()
        .flat_map(|kind| (0..darks).map(move |k| (kind, k)))
        .map(|(kind, k)| ahead(kind, k))
        .collect();
    blocks.push(Block {
        what: "dark",
        sigma: vec![u_floor; dark.len()],
        minutes: dark.len() as f64 * READING_S / 60.0 + 2.0,
        part: Part::Readings(dark),
        plan: format!(
            "format = \"isolux-plan/1\"\nname = \"dark\"\n\n[[block]]\nname = \"lamp_off\"\nkind = \"lamp_off\"\nc_deg = [{first_plane:?}]\n\
             gamma_deg = [0.0]\ndistance_mm = {distance:?}\nrepeats = {darks}\n\n[[block]]\nname = \"capped\"\nkind = \"capped\"\nc_deg = [{first_plane:?}]\n\
             gamma_deg = [0.0]\ndistance_mm = {distance:?}\nrepeats = {darks}\n"
        ),
    });
    // References from switch-on, as fast as the meter reads: the lamp is cold first.
    let start: Vec<ReadingCoordinates> = (0..REFERENCES)
        .map(|k| ReadingCoordinates {
            time_s: Some(20.0 + READING_S * k as f64),
            ..ahead(ReadingKind::Lit, k)
        })
        .collect();
    blocks.push(Block {
        what: "reference_repeats",
        sigma: vec![(u_rel * peak).hypot(u_floor); start.len()],
        minutes: 30.0 + REFERENCES as f64 * READING_S / 60.0,
        part: Part::Readings(start),
        plan: format!(
            "format = \"isolux-plan/1\"\nname = \"reference_repeats\"\n\n[[block]]\nname = \"reference\"\nkind = \"lit\"\nc_deg = [{first_plane:?}]\n\
             gamma_deg = [0.0]\ndistance_mm = {distance:?}\nrepeats = {REFERENCES}\n\
             prompt = \"Let the lamp cool for half an hour, switch it on and confirm at once.\"\n"
        ),
    });
}

/// Smallest and largest angle of an even grid like that of the readings, and its step of half a degree or more.
fn grid(angles_deg: impl Iterator<Item = f64>) -> Option<(f64, f64, f64)> {
    let mut angles: Vec<f64> = angles_deg.map(nominal).collect();
    angles.sort_by(f64::total_cmp);
    angles.dedup();
    let (&low, &high) = (angles.first()?, angles.last()?);
    let step = median(angles.windows(2).map(|pair| nominal(pair[1] - pair[0])).collect())
        .unwrap_or(5.0)
        .max(0.5);
    let count = ((high - low) / step + 1e-6).floor();
    Some((low, nominal(low + count * step), step))
}

/// Dark readings of each kind.
const DARKS: usize = 12;

/// Readings of a hundred minutes.
const MOST_READINGS: usize = 1500;

/// Half-planes of a scan that is made again.
const MOST_PLANES: usize = 12;

/// Readings from switch-on.
const REFERENCES: usize = 400;

#[cfg(test)]
mod tests {
    use super::grid;

    #[test]
    fn a_grid_has_the_angles_that_were_meant() {
        // Read back from a drive of 12800/3 counts a degree that is sent to -80, -76, …, 80.
        let count = 12_800.0 / 3.0;
        let read = (-20..=20).map(|k| (f64::from(4 * k) * count).round() / count + 1e-4 * f64::from(k % 3));
        assert_eq!(grid(read), Some((-80.0, 80.0, 4.0)));
        // Steps that do not lead to the last angle end before it.
        assert_eq!(grid([0.0, 2.0, 4.0, 6.0, 7.0].into_iter()), Some((0.0, 6.0, 2.0)));
        assert_eq!(grid([30.0].into_iter()), Some((30.0, 30.0, 5.0)));
        assert_eq!(grid(std::iter::empty()), None);
    }
}
