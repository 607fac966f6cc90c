//! Blocks that a goniometer could measure.

use isolux_record::ReadingKind;
use isolux_record::observation::ReadingCoordinates;

use super::block::{Block, READING_S, middle_one, nominal};
use crate::assumed::Part;
use crate::search::Outcome;
use crate::table::{Light, ObservationKind, Row};

pub(super) fn reading_blocks(outcome: &Outcome, rows: &[Row], repeats: usize, blocks: &mut Vec<Block>) {
    let Some(bench) = Bench::of(outcome, rows) else { return };
    let first_plane = bench.planes[0];
    let two: Vec<f64> = match bench.planes.get(bench.planes.len() / 2) {
        Some(&other) if other != first_plane => vec![first_plane, other],
        _ => vec![first_plane],
    };
    let has_way = |way: f64| bench.illuminated.iter().any(|row| row.travel == way);
    let reverse = if has_way(-1.0) && !has_way(1.0) { 1 } else { -1 };
    let distance = bench.distance_mm;
    let shortest = bench
        .illuminated
        .iter()
        .map(|row| row.distance_mm)
        .fold(f64::INFINITY, f64::min);
    let short = if shortest < 0.6 * distance {
        0.5 * shortest
    } else {
        0.5 * distance
    };
    let turned: Vec<f64> = two.iter().map(|c| (c + 180.0).rem_euclid(360.0)).collect();
    blocks.push(bench.scan("reverse_travel", &two, distance, reverse, repeats));
    blocks.push(bench.scan("second_distance", &two, short, 1, repeats));
    blocks.push(bench.scan("rotate_c_180", &turned, distance, 1, repeats));
    if repeats > 1 {
        // As many directions as there are, where it is the number of readings that is wanting.
        let every = bench.planes.len().div_ceil(MOST_PLANES);
        let spread: Vec<f64> = bench.planes.iter().copied().step_by(every.max(1)).collect();
        blocks.push(bench.scan("repeat_scan", &spread, distance, 1, repeats));
    }
    blocks.push(bench.dark(DARKS * repeats));
    blocks.push(bench.switched_on());
}

/// What the readings tell of the bench that took them.
struct Bench<'a> {
    illuminated: Vec<&'a Row>,
    /// Half-planes, rising; at least one.
    planes: Vec<f64>,
    /// γ from, to, step.
    gamma: (f64, f64, f64),
    distance_mm: f64,
    /// Relative noise of a lit reading.
    u_rel: f64,
    /// The smallest noise of a reading, lx.
    u_floor: f64,
    /// The largest reading, lx.
    peak: f64,
    ambient_c: Option<f64>,
    /// Age of the lamp at the last reading.
    end_s: f64,
}

impl<'a> Bench<'a> {
    /// None without lit readings.
    fn of(outcome: &Outcome, rows: &'a [Row]) -> Option<Self> {
        let readings: Vec<&Row> = rows
            .iter()
            .filter(|row| row.source == ObservationKind::Reading)
            .collect();
        let illuminated: Vec<&Row> = readings.iter().copied().filter(|row| row.light == Light::Lit).collect();
        let scale = outcome.noise.scale;
        let u_rel = middle_one(
            illuminated
                .iter()
                .map(|row| row.u / row.measured.abs().max(1e-12))
                .collect(),
        );
        let end_s = readings.iter().map(|row| row.lamp_s).fold(f64::NEG_INFINITY, f64::max);
        let mut planes: Vec<f64> = illuminated.iter().map(|row| nominal(row.c_deg)).collect();
        planes.sort_by(f64::total_cmp);
        planes.dedup();
        Some(Self {
            distance_mm: middle_one(illuminated.iter().map(|row| row.distance_mm).collect())?,
            gamma: grid(illuminated.iter().map(|row| row.gamma_deg))?,
            planes,
            u_rel: u_rel.unwrap_or(0.005) * scale,
            u_floor: readings.iter().map(|row| row.u).fold(f64::INFINITY, f64::min) * scale,
            peak: illuminated.iter().map(|row| row.measured).fold(0.0, f64::max),
            ambient_c: middle_one(readings.iter().map(|row| row.ambient_c).collect()).filter(|t| t.is_finite()),
            end_s: if end_s.is_finite() { end_s } else { 3600.0 },
            illuminated,
        })
    }

    /// Expected light, and the range that the reading nearest to it was taken in.
    fn look(&self, gamma_deg: f64, distance_mm: f64) -> (f64, Option<i32>) {
        let away = |row: &Row| (row.gamma_deg - gamma_deg).abs() + (row.distance_mm - self.distance_mm).abs();
        let near = self.illuminated.iter().min_by(|a, b| away(a).total_cmp(&away(b)));
        let level = near.map_or(self.peak, |row| row.measured * (row.distance_mm / distance_mm).powi(2));
        let off = |row: &Row| (row.measured - level).abs();
        let near = self.illuminated.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
        (level, near.map(|row| row.range as i32))
    }

    /// The `k`-th reading of a block on the axis, a minute after the last reading.
    fn ahead(&self, kind: ReadingKind, k: usize) -> ReadingCoordinates {
        ReadingCoordinates {
            kind,
            time_s: Some(self.end_s + 60.0 + READING_S * k as f64),
            lamp_s: None,
            c_deg: self.planes[0],
            gamma_deg: 0.0,
            distance_mm: self.distance_mm,
            travel: 0,
            range: self.look(0.0, self.distance_mm).1,
            ambient_c: self.ambient_c,
            head: 0,
        }
    }

    /// The γ of the readings in these half-planes.
    fn scan(&self, what: &'static str, c: &[f64], distance_mm: f64, travel: i8, repeats: usize) -> Block {
        let (low, high, step) = self.gamma;
        let count = ((high - low) / step).round() as usize;
        let repeats = repeats.min(MOST_READINGS / ((count + 1) * c.len())).max(1);
        let looks: Vec<(f64, (f64, Option<i32>))> = (0..=count)
            .map(|k| {
                let gamma = if travel >= 0 {
                    low + k as f64 * step
                } else {
                    high - k as f64 * step
                };
                (gamma, self.look(gamma, distance_mm))
            })
            .collect();
        let ahead = self.ahead(ReadingKind::Lit, 0);
        let start_s = self.end_s + 60.0;
        let (mut coordinates, mut sigma) = (Vec::new(), Vec::new());
        for &c_deg in c {
            for &(gamma_deg, (level, range)) in &looks {
                for _ in 0..repeats {
                    coordinates.push(ReadingCoordinates {
                        time_s: Some(start_s + READING_S * coordinates.len() as f64),
                        c_deg,
                        gamma_deg,
                        distance_mm,
                        travel,
                        range,
                        ..ahead
                    });
                    sigma.push((self.u_rel * level).hypot(self.u_floor));
                }
            }
        }
        let order = if travel >= 0 { "forward" } else { "reverse" };
        let list = c.iter().map(|c| format!("{c:?}")).collect::<Vec<_>>().join(", ");
        let plan = format!(
            "format = \"isolux-plan/1\"\nname = \"{what}\"\n\n[[block]]\nname = \"{what}\"\nkind = \"lit\"\nc_deg = [{list}]\n\
             gamma_range = [{low:?}, {high:?}, {step:?}]\ndistance_mm = {distance_mm:?}\norder = \"{order}\"\nrepeats = {repeats}\n"
        );
        Block {
            what,
            minutes: coordinates.len() as f64 * READING_S / 60.0 + 1.0,
            part: Part::Readings(coordinates),
            sigma,
            plan,
        }
    }

    /// Readings without light: lamp off, and capped.
    fn dark(&self, count: usize) -> Block {
        let (plane, distance) = (self.planes[0], self.distance_mm);
        let dark: Vec<ReadingCoordinates> = [ReadingKind::LampOff, ReadingKind::Capped]
            .into_iter()
            .flat_map(|kind| (0..count).map(move |k| (kind, k)))
            .map(|(kind, k)| self.ahead(kind, k))
            .collect();
        Block {
            what: "dark",
            sigma: vec![self.u_floor; dark.len()],
            minutes: dark.len() as f64 * READING_S / 60.0 + 2.0,
            part: Part::Readings(dark),
            plan: format!(
                "format = \"isolux-plan/1\"\nname = \"dark\"\n\n[[block]]\nname = \"lamp_off\"\nkind = \"lamp_off\"\nc_deg = [{plane:?}]\n\
                 gamma_deg = [0.0]\ndistance_mm = {distance:?}\nrepeats = {count}\n\n[[block]]\nname = \"capped\"\nkind = \"capped\"\nc_deg = [{plane:?}]\n\
                 gamma_deg = [0.0]\ndistance_mm = {distance:?}\nrepeats = {count}\n"
            ),
        }
    }

    /// References from switch-on, as fast as the meter reads: the lamp is cold first.
    fn switched_on(&self) -> Block {
        let (plane, distance) = (self.planes[0], self.distance_mm);
        let start: Vec<ReadingCoordinates> = (0..REFERENCES)
            .map(|k| ReadingCoordinates {
                time_s: Some(20.0 + READING_S * k as f64),
                ..self.ahead(ReadingKind::Lit, k)
            })
            .collect();
        Block {
            what: "reference_repeats",
            sigma: vec![(self.u_rel * self.peak).hypot(self.u_floor); start.len()],
            minutes: 30.0 + REFERENCES as f64 * READING_S / 60.0,
            part: Part::Readings(start),
            plan: format!(
                "format = \"isolux-plan/1\"\nname = \"reference_repeats\"\n\n[[block]]\nname = \"reference\"\nkind = \"lit\"\nc_deg = [{plane:?}]\n\
                 gamma_deg = [0.0]\ndistance_mm = {distance:?}\nrepeats = {REFERENCES}\n\
                 prompt = \"Let the lamp cool for half an hour, switch it on and confirm at once.\"\n"
            ),
        }
    }
}

/// Smallest and largest angle of an even grid like that of the readings, and its step of half a degree or more.
fn grid(angles_deg: impl Iterator<Item = f64>) -> Option<(f64, f64, f64)> {
    let mut angles: Vec<f64> = angles_deg.map(nominal).collect();
    angles.sort_by(f64::total_cmp);
    angles.dedup();
    let (&low, &high) = (angles.first()?, angles.last()?);
    let step = middle_one(angles.windows(2).map(|pair| nominal(pair[1] - pair[0])).collect())
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
