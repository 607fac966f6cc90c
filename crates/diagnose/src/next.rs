//! What to measure next: the block of readings or maps in which two rivals of one set differ most (T-optimality).

use isolux_record::ReadingKind;
use isolux_record::observation::{MapPose, MapSet, ReadingCoordinates};
use nalgebra::{DMatrix, DVector};

use crate::basis::Basis;
use crate::believed::{Believed, Part};
use crate::document::NextEntry;
use crate::fit::{Whitener, fit, nuisance_tangents};
use crate::forward::{Forward, Hypothesis};
use crate::rounding::Rounding;
use crate::search::{Label, Outcome};
use crate::table::{Light, Row, Source};
use crate::whitening::Sequence;

/// Suggestions, best first, and the plan files that carry them out.
#[derive(Debug, Clone, Default)]
pub struct Next {
    /// Entries of `next_measurement`.
    pub entries: Vec<NextEntry>,
    /// File name and content of each plan.
    pub plans: Vec<(String, String)>,
}

/// A block that could be measured.
struct Block {
    what: &'static str,
    part: Part,
    sigma: Vec<f64>,
    minutes: f64,
    plan: String,
}

/// For the first effect whose set holds more than one name: the measurements that would tell its two most probable apart.
pub fn suggest(believed: &Believed, outcome: &Outcome, rows: &[Row]) -> Next {
    let mut next = Next::default();
    let Some((number, pair)) = rivals_of(outcome) else {
        return next;
    };
    let name = |hypothesis: &Hypothesis| believed.spec(hypothesis.effect).name.to_owned();
    let splits = [name(&pair[0]), name(&pair[1])];
    let others: Vec<Hypothesis> = outcome
        .after
        .hypotheses
        .iter()
        .enumerate()
        .filter(|(i, _)| *i != number)
        .map(|(_, member)| member.clone())
        .collect();
    let of_readings = rows.iter().all(|row| row.source == Source::Reading);
    let with_repeats = |repeats: usize| {
        let mut entries: Vec<(NextEntry, Block)> = blocks(believed, outcome, rows, repeats)
            .into_iter()
            .filter_map(|block| {
                let expected_sigma = separation(believed, outcome, rows, &block, &others, &pair)?;
                let entry = NextEntry {
                    what: block.what,
                    splits: splits.clone(),
                    plan: None,
                    expected_sigma,
                    minutes: block.minutes,
                };
                Some((entry, block))
            })
            .collect();
        entries.sort_by(|a, b| b.0.expected_sigma.total_cmp(&a.0.expected_sigma));
        entries.truncate(MOST_ENTRIES);
        // A shape may go far from where its tangent leads: what counts is how far apart the two stay when refitted in full. Refits of
        // maps take too long for that.
        for (entry, block) in entries.iter_mut().filter(|_| of_readings) {
            let refitted = refitted_separation(believed, outcome, rows, block, &others, &pair);
            entry.expected_sigma = refitted.unwrap_or(0.0).min(entry.expected_sigma);
        }
        entries.sort_by(|a, b| b.0.expected_sigma.total_cmp(&a.0.expected_sigma));
        entries
    };
    let mut entries = with_repeats(1);
    // Names that one scan hardly parts want as many readings of it as will, while that is an evening's work.
    let best = entries.first().map_or(0.0, |(entry, _)| entry.expected_sigma);
    if of_readings && best > 0.0 && best < DECISIVE_SIGMA {
        let wanted = (DECISIVE_SIGMA / best).powi(2).ceil() as usize;
        entries = with_repeats(wanted.min(MOST_REPEATS));
    }
    for (place, (mut entry, Block { plan, .. })) in entries.into_iter().enumerate() {
        let kind = if plan.contains("isolux-plan/1") { "plan" } else { "maps" };
        let file = if place == 0 {
            format!("next.{kind}.toml")
        } else {
            format!("next-{}.{kind}.toml", place + 1)
        };
        entry.plan = Some(file.clone());
        next.plans.push((file, plan));
        next.entries.push(entry);
    }
    next
}

/// Suggestions that are made.
const MOST_ENTRIES: usize = 3;
/// Two names this far apart are told apart by most noises.
const DECISIVE_SIGMA: f64 = 5.0;
/// More readings of one direction than this show what common errors allow no better.
const MOST_REPEATS: usize = 24;

/// The first member with a named rival in its set, and the refitted values of both.
fn rivals_of(outcome: &Outcome) -> Option<(usize, [Hypothesis; 2])> {
    for (number, rivalry) in outcome.rivalries.iter().enumerate() {
        let mut sum = 0.0;
        let mut set: Vec<Hypothesis> = Vec::new();
        for ranked in &rivalry.ranked {
            if sum >= 0.95 {
                break;
            }
            sum += ranked.posterior;
            if let (Label::Named(_), Some(hypothesis)) = (ranked.label, &ranked.hypothesis) {
                set.push(hypothesis.clone());
            }
        }
        if let [one, two, ..] = set.as_slice() {
            return Some((number, [one.clone(), two.clone()]));
        }
    }
    None
}

/// How far apart, in σ, the two predictions lie over old and new rows together, after the second is refitted to the first.
fn separation(
    believed: &Believed,
    outcome: &Outcome,
    rows: &[Row],
    block: &Block,
    others: &[Hypothesis],
    pair: &[Hypothesis; 2],
) -> Option<f64> {
    let scale = outcome.noise.scale;
    let all_sigma: Vec<f64> = rows
        .iter()
        .map(|row| scale * row.u)
        .chain(block.sigma.iter().copied())
        .collect();
    let predict = |nuisance: &[f64], members: &[Hypothesis]| -> Option<DVector<f64>> {
        let old = believed.predict(nuisance, members)?;
        let model = believed.model(nuisance, members)?;
        let new = match &block.part {
            Part::Readings(readings) => model.predict_readings(readings),
            Part::Maps(maps) => model.predict_maps(maps),
            Part::Spectra(..) => return None,
        };
        let values = old
            .iter()
            .copied()
            .chain(new)
            .zip(&all_sigma)
            .map(|(value, sigma)| value / sigma);
        Some(DVector::from_iterator(all_sigma.len(), values))
    };
    let with = |rival: &Hypothesis| {
        let mut members = others.to_vec();
        members.push(rival.clone());
        members
    };
    let nuisance = &outcome.after.nuisance;
    let (first, second) = (with(&pair[0]), with(&pair[1]));
    let base = predict(nuisance, &second)?;
    let mut difference = predict(nuisance, &first)? - &base;
    let mut columns: Vec<DVector<f64>> = Vec::new();
    for k in 0..nuisance.len() {
        let mut moved = nuisance.clone();
        moved[k] += 1e-4;
        columns.push(predict(&moved, &second)? - &base);
    }
    for (i, member) in second.iter().enumerate() {
        let searchable = &believed.effects()[member.effect];
        for j in 0..member.linear.len() {
            let mut moved = second.clone();
            moved[i].linear[j] += 0.1 * searchable.step[j];
            columns.push(predict(nuisance, &moved)? - &base);
        }
        for j in (0..member.shape.len()).filter(|&j| !searchable.fixed[j]) {
            let mut moved = second.clone();
            moved[i].shape[j] += searchable.shape_step[j];
            columns.push(predict(nuisance, &moved)? - &base);
        }
    }
    let columns = if columns.is_empty() {
        DMatrix::zeros(base.len(), 0)
    } else {
        DMatrix::from_columns(&columns)
    };
    Basis::spanning(&columns, 1e-8).project_out_vector(&mut difference);
    Some(difference.norm())
}

/// As [`separation`], the smaller of both ways, each name refitted in full to what the other predicts. Needs new rows that bring no
/// other refitted terms.
fn refitted_separation(
    believed: &Believed,
    outcome: &Outcome,
    rows: &[Row],
    block: &Block,
    others: &[Hypothesis],
    pair: &[Hypothesis; 2],
) -> Option<f64> {
    let together = believed.with_part(block.part.clone());
    if together.nuisances() != believed.nuisances() || together.effects().len() != believed.effects().len() {
        return None;
    }
    let nuisance = &outcome.after.nuisance;
    let old = rows.iter().map(|row| 1.0 / (outcome.noise.scale * row.u));
    let row_scale = DVector::from_vec(old.chain(block.sigma.iter().map(|sigma| 1.0 / sigma)).collect());
    let sequence = Sequence::by_time(&vec![0; row_scale.len()], &vec![f64::NAN; row_scale.len()]);
    let (rounding, errors) = (Rounding::default(), together.common_errors());
    let whitener = Whitener::new(&sequence, &rounding, row_scale, 0.0, &errors);
    let tangents = nuisance_tangents(&together, nuisance)?;
    let with = |rival: &Hypothesis| [others, std::slice::from_ref(rival)].concat();
    let left = |truth: &Hypothesis, tried: &Hypothesis| {
        let expected = together.predict(nuisance, &with(truth))?;
        let fitted = fit(&together, &expected, &whitener, nuisance, &tangents, &with(tried))?;
        Some(fitted.chi2.sqrt())
    };
    Some(left(&pair[0], &pair[1])?.min(left(&pair[1], &pair[0])?))
}

/// The blocks that a bench or a camera could measure and these data lack.
fn blocks(believed: &Believed, outcome: &Outcome, rows: &[Row], repeats: usize) -> Vec<Block> {
    let mut blocks = Vec::new();
    if rows.iter().any(|row| row.source == Source::Reading) {
        reading_blocks(outcome, rows, repeats, &mut blocks);
    }
    for part in believed.parts() {
        if let Part::Maps(maps) = part {
            map_blocks(outcome, rows, maps, &mut blocks);
            break;
        }
    }
    blocks
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.retain(|value| value.is_finite());
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

/// What an axis was sent to, of what it read back: a plan in which the angles of the encoder stood would have no even step,
/// or would begin behind a limit by a count.
fn nominal(angle_deg: f64) -> f64 {
    (angle_deg * 20.0).round() / 20.0
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

fn reading_blocks(outcome: &Outcome, rows: &[Row], repeats: usize, blocks: &mut Vec<Block>) {
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
    let level = |gamma: f64, distance_mm: f64| {
        let near = lit.iter().min_by(|a, b| {
            ((a.gamma_deg - gamma).abs() + (a.distance_mm - distance).abs())
                .total_cmp(&((b.gamma_deg - gamma).abs() + (b.distance_mm - distance).abs()))
        });
        near.map_or(peak, |row| row.measured * (row.distance_mm / distance_mm).powi(2))
    };
    let at = |kind, c_deg: f64, gamma_deg: f64, distance_mm: f64, travel: i8, k: usize| ReadingCoordinates {
        kind,
        time_s: Some(end + 60.0 + 4.0 * k as f64),
        c_deg,
        gamma_deg,
        distance_mm,
        travel,
        range: lit
            .iter()
            .min_by(|a, b| {
                (a.measured - level(gamma_deg, distance_mm))
                    .abs()
                    .total_cmp(&(b.measured - level(gamma_deg, distance_mm)).abs())
            })
            .map(|row| row.range as i32),
        ambient_c: temperature,
    };
    let mut scan = |what: &'static str, c: &[f64], distance_mm: f64, travel: i8| {
        let count = ((high - low) / step).round() as usize;
        let repeats = repeats.min(MOST_READINGS / ((count + 1) * c.len())).max(1);
        let mut coordinates = Vec::new();
        for &plane in c {
            for k in 0..=count {
                let gamma = if travel >= 0 {
                    low + k as f64 * step
                } else {
                    high - k as f64 * step
                };
                for _ in 0..repeats {
                    coordinates.push(at(
                        ReadingKind::Lit,
                        plane,
                        gamma,
                        distance_mm,
                        travel,
                        coordinates.len(),
                    ));
                }
            }
        }
        let sigma = coordinates
            .iter()
            .map(|at| (u_rel * level(at.gamma_deg, at.distance_mm)).hypot(u_floor))
            .collect();
        let order = if travel >= 0 { "forward" } else { "reverse" };
        let list = c.iter().map(|c| format!("{c:?}")).collect::<Vec<_>>().join(", ");
        let plan = format!(
            "format = \"isolux-plan/1\"\nname = \"{what}\"\n\n[[block]]\nname = \"{what}\"\nkind = \"lit\"\nc_deg = [{list}]\n\
             gamma_range = [{low:?}, {high:?}, {step:?}]\ndistance_mm = {distance_mm:?}\norder = \"{order}\"\nrepeats = {repeats}\n"
        );
        let minutes = coordinates.len() as f64 * 4.0 / 60.0 + 1.0;
        blocks.push(Block {
            what,
            part: Part::Readings(coordinates),
            sigma,
            minutes,
            plan,
        });
    };
    let two: Vec<f64> = match (planes.first(), planes.get(planes.len() / 2)) {
        (Some(&a), Some(&b)) if a != b => vec![a, b],
        (Some(&a), _) => vec![a],
        _ => return,
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
        .map(|(kind, k)| at(kind, two[0], 0.0, distance, 0, k))
        .collect();
    blocks.push(Block {
        what: "dark",
        sigma: vec![u_floor; dark.len()],
        minutes: dark.len() as f64 * 4.0 / 60.0 + 2.0,
        part: Part::Readings(dark),
        plan: format!(
            "format = \"isolux-plan/1\"\nname = \"dark\"\n\n[[block]]\nname = \"lamp_off\"\nkind = \"lamp_off\"\nc_deg = [{c:?}]\n\
             gamma_deg = [0.0]\ndistance_mm = {distance:?}\nrepeats = {darks}\n\n[[block]]\nname = \"capped\"\nkind = \"capped\"\nc_deg = [{c:?}]\n\
             gamma_deg = [0.0]\ndistance_mm = {distance:?}\nrepeats = {darks}\n",
            c = two[0]
        ),
    });
    // References from switch-on, as fast as the meter reads: the lamp is cold first.
    let start: Vec<ReadingCoordinates> = (0..REFERENCES)
        .map(|k| ReadingCoordinates {
            time_s: Some(20.0 + READING_S * k as f64),
            ..at(ReadingKind::Lit, two[0], 0.0, distance, 0, k)
        })
        .collect();
    blocks.push(Block {
        what: "reference_repeats",
        sigma: vec![(u_rel * peak).hypot(u_floor); start.len()],
        minutes: 30.0 + REFERENCES as f64 * READING_S / 60.0,
        part: Part::Readings(start),
        plan: format!(
            "format = \"isolux-plan/1\"\nname = \"reference_repeats\"\n\n[[block]]\nname = \"reference\"\nkind = \"lit\"\nc_deg = [{c:?}]\n\
             gamma_deg = [0.0]\ndistance_mm = {distance:?}\nrepeats = {REFERENCES}\n\
             prompt = \"Let the lamp cool for half an hour, switch it on and confirm at once.\"\n",
            c = two[0]
        ),
    });
}

/// Dark readings of each kind.
const DARKS: usize = 12;
/// Readings of a hundred minutes.
const MOST_READINGS: usize = 1500;
/// Half-planes of a scan that is made again.
const MOST_PLANES: usize = 12;

/// Readings from switch-on, and seconds from one to the next.
const REFERENCES: usize = 400;
const READING_S: f64 = 4.0;

fn map_blocks(outcome: &Outcome, rows: &[Row], maps: &MapSet, blocks: &mut Vec<Block>) {
    let Some(first) = maps.maps().iter().find(|map| map.lamp && !map.capped).cloned() else {
        return;
    };
    let bins: Vec<&Row> = rows.iter().filter(|row| row.source == Source::Bin).collect();
    let scale = outcome.noise.scale;
    let peak = bins.iter().map(|row| row.measured).fold(0.0, f64::max);
    let u_floor = bins.iter().map(|row| row.u).fold(f64::INFINITY, f64::min) * scale;
    let u_rel = median(
        bins.iter()
            .filter(|row| row.light == Light::Lit)
            .map(|row| row.u / row.measured.abs().max(1e-12))
            .collect(),
    )
    .unwrap_or(0.005)
        * scale;
    let variant = |name: &str, change: &dyn Fn(&mut MapPose)| {
        let mut pose = first.clone();
        name.clone_into(&mut pose.name);
        pose.held_out = false;
        change(&mut pose);
        pose
    };
    let d = first.distance_mm;
    let exposed = |pose: &mut MapPose, distance_mm: f64| {
        pose.exposure = first.exposure * (distance_mm / d).powi(2);
        pose.distance_mm = distance_mm;
    };
    let choices: Vec<(&'static str, Vec<MapPose>)> = vec![
        (
            "distances",
            vec![
                variant("half", &|p| exposed(p, 0.5 * d)),
                variant("third", &|p| exposed(p, d / 3.0)),
            ],
        ),
        (
            "tilts",
            vec![
                variant("tilt40", &|p| p.tilt_x_deg += 40.0),
                variant("tilt60", &|p| p.tilt_x_deg += 60.0),
                variant("tilty40", &|p| p.tilt_y_deg += 40.0),
            ],
        ),
        (
            "rotate_180",
            vec![
                variant("turned90", &|p| p.rot_z_deg += 90.0),
                variant("turned180", &|p| p.rot_z_deg += 180.0),
            ],
        ),
        (
            "exposures",
            vec![
                variant("exposed_half", &|p| p.exposure *= 0.5),
                variant("exposed_tenth", &|p| p.exposure *= 0.1),
            ],
        ),
        (
            "dark_maps",
            vec![
                variant("lamp_off", &|p| p.lamp = false),
                variant("capped", &|p| p.capped = true),
            ],
        ),
    ];
    for (what, poses) in choices {
        // A set of its own: the same sensor, other poses.
        let Some(set) = maps.at_poses(poses.clone()) else {
            continue;
        };
        let level = |pose: &MapPose| {
            if pose.lamp && !pose.capped {
                peak * pose.exposure / first.exposure
            } else {
                0.0
            }
        };
        let sigma = set
            .cells()
            .iter()
            .map(|cell| (u_rel * level(&poses[cell.map as usize])).hypot(u_floor))
            .collect();
        blocks.push(Block {
            what,
            plan: poses_toml(maps, &poses),
            part: Part::Maps(set),
            sigma,
            minutes: poses.len() as f64 * 2.0,
        });
    }
}

fn poses_toml(maps: &MapSet, poses: &[MapPose]) -> String {
    use std::fmt::Write as _;
    let [width, height] = maps.sensor_mm();
    let [nx, ny] = maps.bins();
    let unit = match maps.unit() {
        isolux_record::observation::MapUnit::Relative => "relative",
        isolux_record::observation::MapUnit::Lux => "lx",
        isolux_record::observation::MapUnit::WattPerSquareMetre => "W/m2",
    };
    let mut text = format!("sensor_mm = [{width:?}, {height:?}]\nbins = [{nx}, {ny}]\nunit = \"{unit}\"\n");
    for pose in poses {
        let _ = write!(
            text,
            "\n[[map]]\nname = \"{}\"\ndistance_mm = {:?}\ntilt_x_deg = {:?}\ntilt_y_deg = {:?}\nrot_z_deg = {:?}\nexposure = {:?}\nlamp = {}\ncapped = {}\n",
            pose.name,
            pose.distance_mm,
            pose.tilt_x_deg,
            pose.tilt_y_deg,
            pose.rot_z_deg,
            pose.exposure,
            pose.lamp,
            pose.capped
        );
    }
    text
}

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
