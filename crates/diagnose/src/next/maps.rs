//! Maps that a camera could take.

use isolux_record::observation::{MapPose, MapSet};

use super::block::{Block, middle_one};
use crate::assumed::Part;
use crate::search::Outcome;
use crate::table::{Light, ObservationKind, Row};

pub(super) fn map_blocks(outcome: &Outcome, rows: &[Row], maps: &MapSet, blocks: &mut Vec<Block>) {
    let Some(first) = maps.maps().iter().find(|map| map.lamp && !map.capped).cloned() else {
        return;
    };
    let bins: Vec<&Row> = rows.iter().filter(|row| row.source == ObservationKind::Bin).collect();
    let scale = outcome.noise.scale;
    let peak = bins.iter().map(|row| row.measured).fold(0.0, f64::max);
    let u_floor = bins.iter().map(|row| row.u).fold(f64::INFINITY, f64::min) * scale;
    let u_rel = middle_one(
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
