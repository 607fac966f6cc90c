//! The measurement that a diagnosis asks for next, carried out in the same room with the same thing hidden in it.

use std::fmt::Write as _;

use isolux_darkroom::{Kind, MapPose, Observation};

use crate::case::{self, BINS, Order};
use crate::plan::{Frame, Step};
use crate::random::Draws;
use crate::truth;

/// The plan's readings or maps as files: name and content. None where the plan cannot be read, or what is hidden has no
/// recipe.
pub fn follow_up(order: &Order, plan: &str) -> Option<Vec<(&'static str, String)>> {
    let plan: toml::Table = plan.parse().ok()?;
    if order.sensor {
        maps(order, &plan)
    } else {
        readings(order, &plan)
    }
}

const READING_S: f64 = 4.0;

fn readings(order: &Order, plan: &toml::Table) -> Option<Vec<(&'static str, String)>> {
    let day = case::day(order, &mut Draws::new(order.seed, 1))?;
    if day.settings.len() != order.hidden.len() {
        return None;
    }
    let mut draws = Draws::new(order.seed, 3);
    let mut time_s = day.steps.last()?.at.time_s + 60.0;
    let mut steps: Vec<Step> = Vec::new();
    for block in plan.get("block")?.as_array()? {
        let number = |key: &str| block.get(key).and_then(value);
        let kind = match block.get("kind")?.as_str()? {
            "lit" => Kind::Lit,
            "baffled" => Kind::Baffled,
            "lamp_off" => Kind::LampOff,
            "capped" => Kind::Capped,
            _ => return None,
        };
        // Who lets the lamp cool and switches it on begins at once.
        if block.get("prompt").is_some() {
            time_s = 20.0;
        }
        let backwards = block.get("order").and_then(toml::Value::as_str) == Some("reverse");
        let sweep = angles(block, "gamma", backwards)?;
        let repeats = number("repeats").unwrap_or(1.0) as usize;
        for c_deg in angles(block, "c", false)? {
            time_s += if sweep.len() > 1 { 20.0 } else { 0.0 };
            for &gamma_deg in &sweep {
                for _ in 0..repeats {
                    let travel = match (sweep.len() > 1, backwards) {
                        (false, _) => 0.0,
                        (true, false) => 1.0,
                        (true, true) => -1.0,
                    };
                    let at = Observation {
                        kind,
                        time_s,
                        c_deg,
                        gamma_deg,
                        distance_mm: number("distance_mm")?,
                        travel,
                        range: 0,
                        ambient_c: day.climate.at(time_s),
                    };
                    steps.push(Step {
                        block: "next",
                        at,
                        held_out: false,
                    });
                    time_s += READING_S;
                }
            }
        }
    }
    let plain = truth::readings(day.room.clone(), &[], &steps);
    case::set_ranges(&mut steps, &plain);
    let disturbed = truth::with_effects(day.room.clone(), &day.settings);
    let clean = truth::readings(disturbed, &day.settings, &steps);
    let noise = case::unit_noise(steps.len(), order, &mut draws);
    let mut csv = format!("{},illuminance_lx,u_lx\n", case::COLUMNS);
    for (i, step) in steps.iter().enumerate() {
        let sigma = day.noise.sigma(plain[i]);
        let place = case::place(i, step, &mut draws);
        let _ = writeln!(
            csv,
            "{place},{:.6},{:.6}",
            clean[i] + sigma * noise[i],
            day.noise.ratio * sigma
        );
    }
    Some(vec![("next.csv", csv)])
}

/// The angles of an axis in a block: a list, or from, to, step.
fn angles(block: &toml::Value, axis: &str, backwards: bool) -> Option<Vec<f64>> {
    let numbers = |key: String| -> Option<Vec<f64>> { block.get(key)?.as_array()?.iter().map(value).collect() };
    let mut angles = match numbers(format!("{axis}_range")) {
        Some(range) => {
            let [from, to, step] = range.try_into().ok()?;
            (0..=((to - from) / step).round() as usize)
                .map(|k| from + step * k as f64)
                .collect()
        }
        None => numbers(format!("{axis}_deg"))?,
    };
    if backwards {
        angles.reverse();
    }
    Some(angles)
}

fn value(value: &toml::Value) -> Option<f64> {
    value
        .as_float()
        .or_else(|| value.as_integer().map(|whole| whole as f64))
}

fn maps(order: &Order, plan: &toml::Table) -> Option<Vec<(&'static str, String)>> {
    let day = case::map_day(order, &mut Draws::new(order.seed, 2))?;
    if day.settings.len() != order.hidden.len() {
        return None;
    }
    let mut draws = Draws::new(order.seed, 4);
    let mut frames = Vec::new();
    for map in plan.get("map")?.as_array()? {
        let number = |key: &str| map.get(key).and_then(value);
        let is = |key: &str| map.get(key).and_then(toml::Value::as_bool);
        let name: &'static str = Box::leak(map.get("name")?.as_str()?.to_owned().into_boxed_str());
        frames.push(Frame {
            name,
            pose: MapPose {
                distance_mm: number("distance_mm")?,
                tilt_x_deg: number("tilt_x_deg")?,
                tilt_y_deg: number("tilt_y_deg")?,
                rot_z_deg: number("rot_z_deg")?,
                offset_mm: [0.0, 0.0],
                exposure: number("exposure")?,
                lamp: is("lamp")?,
                capped: is("capped")?,
                time_s: None,
            },
            held_out: false,
        });
    }
    let plain = truth::maps(day.room.clone(), &frames, BINS);
    let clean = truth::maps(truth::with_effects(day.room.clone(), &day.settings), &frames, BINS);
    let noise = case::unit_noise(plain.len(), order, &mut draws);
    let mut toml = case::map_head();
    let mut csv = case::MAP_COLUMNS.to_owned();
    for (m, frame) in frames.iter().enumerate() {
        case::pose(&mut toml, frame);
        for cell in 0..BINS * BINS {
            let i = m * BINS * BINS + cell;
            let sigma = day.noise.sigma(plain[i]);
            let (iy, ix) = (cell / BINS, cell % BINS);
            let (signal, u) = (clean[i] + sigma * noise[i], (day.noise.ratio * sigma).max(1e-6));
            let _ = writeln!(csv, "{},{iy},{ix},{signal:.6},{u:.6}", frame.name);
        }
    }
    Some(vec![("maps.toml", toml), ("maps.csv", csv)])
}
