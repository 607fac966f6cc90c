//! Maps from their files: the TOML with the poses, and the CSV or the images with the values.

use std::collections::HashMap;

use camino::Utf8Path;
use serde::Deserialize;

use super::{Cell, MapPose, MapSet, MapUnit};
use crate::document::Fault;
use crate::document::bounds::within;
use crate::observation::image::read_image;
use crate::observation::need::Need;
use crate::observation::pair::OneOrTwo;
use crate::table::{ObservationError, Problem};
use crate::table::{Table, line_of, parse_toml, read_text, wrong_key};

/// Most bins of all maps of a file: beyond it they do not fit into memory.
const MOST_CELLS: f64 = 2e8;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Noise {
    u_abs: f64,
    u_rel: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    sensor_mm: OneOrTwo<f64>,
    bins: OneOrTwo<usize>,
    unit: MapUnit,
    full_scale: Option<f64>,
    noise: Option<Noise>,
    map: Vec<toml::Spanned<MapPose>>,
}

impl Document {
    /// Size, bins and full scale of the sensor.
    fn check_sensor(&self) -> Result<(), Fault> {
        let bins = self.bins.both();
        for (side_mm, bins) in self.sensor_mm.both().into_iter().zip(bins) {
            within("sensor_mm", side_mm, 1e-4..=1e5, " mm")?;
            within("bins", bins as f64, 1.0..=65_536.0, "")?;
        }
        let cells = (bins[0] * bins[1] * self.map.len()) as f64;
        within("bins", cells, 0.0..=MOST_CELLS, " in all maps")?;
        within("full_scale", self.full_scale, 1e-12..=1e12, "")
    }
}

/// The poses in the order of the file, each name once.
fn poses(path: &Utf8Path, text: &str, maps: Vec<toml::Spanned<MapPose>>) -> Result<Vec<MapPose>, ObservationError> {
    let mut lines: HashMap<String, u64> = HashMap::new();
    let mut poses = Vec::new();
    for (number, map) in maps.into_iter().enumerate() {
        let line = line_of(text, map.span().start);
        let map = map.into_inner();
        check_pose(&format!("map.{number}"), &map).map_err(wrong_key(path, text))?;
        if let Some(first) = lines.insert(map.name.clone(), line) {
            let what = format!("map `{}`", map.name);
            let problem = Problem::Duplicate { what, first };
            return Err(ObservationError::new(path, Some(line), problem));
        }
        poses.push(map);
    }
    if poses.is_empty() {
        return Err(ObservationError::new(path, None, Problem::NoRows("maps")));
    }
    Ok(poses)
}

fn check_pose(table: &str, map: &MapPose) -> Result<(), Fault> {
    let key = |name: &str| format!("{table}.{name}");
    within(&key("distance_mm"), map.distance_mm, 1e-3..=1e8, " mm")?;
    within(&key("exposure"), map.exposure, 1e-9..=1e9, "")?;
    for (name, angle_deg) in [
        ("tilt_x_deg", map.tilt_x_deg),
        ("tilt_y_deg", map.tilt_y_deg),
        ("rot_z_deg", map.rot_z_deg),
    ] {
        within(&key(name), angle_deg, -360.0..=360.0, "°")?;
    }
    for offset_mm in map.offset_mm {
        within(&key("offset_mm"), offset_mm, -1e6..=1e6, " mm")?;
    }
    within(&key("time_s"), map.time_s, -1e9..=1e9, " s")?;
    within(&key("ambient_c"), map.ambient_c, -100.0..=200.0, " °C")
}

impl MapSet {
    /// Maps from `maps.toml`, with the values of the CSV of the same name beside it or of the images that it names.
    ///
    /// # Errors
    /// [`ObservationError`] with file and line.
    pub fn open(path: &Utf8Path, need: Need) -> Result<Self, ObservationError> {
        let text = read_text(path)?;
        let document: Document = parse_toml(path, &text)?;
        document.check_sensor().map_err(wrong_key(path, &text))?;
        let mut set = Self {
            path: path.to_owned(),
            sensor_mm: document.sensor_mm.both(),
            bins: document.bins.both(),
            unit: document.unit,
            full_scale: document.full_scale,
            maps: poses(path, &text, document.map)?,
            cells: Vec::new(),
            values: None,
            places_mm: None,
        };
        if set.maps.iter().any(|map| map.file.is_some()) {
            set.read_images(document.noise.as_ref(), need)?;
        } else {
            set.read_csv(need)?;
        }
        if need == Need::Values {
            set.refuse_unusable_maps()?;
        }
        Ok(set)
    }

    fn every_cell(&self, map: usize) -> impl Iterator<Item = Cell> + use<> {
        let [nx, ny] = self.bins;
        (0..ny).flat_map(move |iy| {
            (0..nx).map(move |ix| Cell {
                map: map as u32,
                iy: iy as u32,
                ix: ix as u32,
            })
        })
    }

    fn read_csv(&mut self, need: Need) -> Result<(), ObservationError> {
        let mut csv_path = self.path.with_extension("csv");
        if !csv_path.is_file() {
            if need == Need::Coordinates {
                self.cells = (0..self.maps.len()).flat_map(|map| self.every_cell(map)).collect();
                return Ok(());
            }
            csv_path = self.path.with_file_name("maps.csv");
        }
        let table = Table::parse(&csv_path, &read_text(&csv_path)?, false)?;
        let values: &[&'static str] = if need == Need::Values { &["signal", "u"] } else { &[] };
        let columns = table.columns_with(&csv_path, &[&["map", "iy", "ix"], values].concat())?;
        let by_name: HashMap<&str, usize> = self
            .maps
            .iter()
            .enumerate()
            .map(|(i, map)| (map.name.as_str(), i))
            .collect();
        let [nx, ny] = self.bins;
        let mut first_line: HashMap<Cell, u64> = HashMap::new();
        let (mut signal, mut u) = (Vec::new(), Vec::new());
        for fields in table.rows(&csv_path, &columns) {
            let name = fields.text("map");
            let map = *by_name
                .get(name)
                .ok_or_else(|| fields.error(Problem::UnknownMap(name.to_owned())))?;
            let index = |column: &'static str, bins: usize| match fields.text(column).parse::<usize>() {
                Ok(index) if index < bins => Ok(index as u32),
                _ => Err(fields.error(Problem::OutsideMap {
                    column,
                    found: fields.text(column).to_owned(),
                    last: bins - 1,
                })),
            };
            let cell = Cell {
                map: map as u32,
                iy: index("iy", ny)?,
                ix: index("ix", nx)?,
            };
            if let Some(first) = first_line.insert(cell, fields.line()) {
                let what = format!("map `{name}`, iy {}, ix {}", cell.iy, cell.ix);
                return Err(fields.error(Problem::Duplicate { what, first }));
            }
            if need == Need::Values {
                signal.push(fields.number("signal")?);
                u.push(fields.positive("u")?);
            }
            self.cells.push(cell);
        }
        if self.cells.is_empty() {
            return Err(ObservationError::new(&csv_path, None, Problem::NoRows("bins")));
        }
        if need == Need::Values {
            self.values = Some((signal, u));
        }
        Ok(())
    }

    fn read_images(&mut self, noise: Option<&Noise>, need: Need) -> Result<(), ObservationError> {
        let (mut signal, mut u) = (Vec::new(), Vec::new());
        for index in 0..self.maps.len() {
            let cells: Vec<Cell> = self.every_cell(index).collect();
            let Some(file) = &self.maps[index].file else {
                // A map without an image beside maps with one is a pose: values are asked for below.
                if need == Need::Coordinates {
                    self.cells.extend(cells);
                }
                continue;
            };
            if need == Need::Coordinates {
                self.cells.extend(cells);
                continue;
            }
            let noise = noise.ok_or_else(|| ObservationError::new(&self.path, None, Problem::NoNoise))?;
            let possible = |v: f64| v.is_finite() && v >= 0.0;
            if !(possible(noise.u_abs) && possible(noise.u_rel) && noise.u_abs + noise.u_rel > 0.0) {
                let problem = Problem::OutOfRange {
                    column: "u_abs, u_rel",
                    found: noise.u_abs,
                    expected: "not negative and not both zero",
                };
                return Err(ObservationError::new(&self.path, None, problem));
            }
            let path = self.path.parent().unwrap_or(Utf8Path::new("")).join(file);
            let image = read_image(&path, self.bins)?;
            for value in image {
                let uncertainty = noise.u_abs.hypot(noise.u_rel * value);
                if uncertainty <= 0.0 {
                    let problem = Problem::OutOfRange {
                        column: "u_abs",
                        found: noise.u_abs,
                        expected: "above zero where a signal is zero",
                    };
                    return Err(ObservationError::new(&self.path, None, problem));
                }
                signal.push(value);
                u.push(uncertainty);
            }
            self.cells.extend(cells);
        }
        if need == Need::Values {
            self.values = Some((signal, u));
        }
        Ok(())
    }

    fn refuse_unusable_maps(&self) -> Result<(), ObservationError> {
        let Some((signal, _)) = &self.values else { return Ok(()) };
        let mut of_map: Vec<(usize, f64, f64)> = vec![(0, f64::INFINITY, f64::NEG_INFINITY); self.maps.len()];
        for (cell, value) in self.cells.iter().zip(signal) {
            let (count, low, high) = &mut of_map[cell.map as usize];
            (*count, *low, *high) = (*count + 1, low.min(*value), high.max(*value));
        }
        for (map, (count, low, high)) in self.maps.iter().zip(of_map) {
            let refuse = |problem| Err(ObservationError::new(&self.path, None, problem));
            if count == 0 && !map.held_out {
                return refuse(Problem::MapWithoutValues(map.name.clone()));
            }
            if count > 8 && low == high && map.lamp && !map.capped {
                return refuse(Problem::Saturated {
                    name: map.name.clone(),
                    bins: count,
                    value: low,
                });
            }
        }
        Ok(())
    }
}
