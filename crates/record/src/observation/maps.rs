//! Maps of a sensor: `maps.toml` beside `maps.csv` or images.

use std::collections::HashMap;

use camino::{Utf8Path, Utf8PathBuf};
use serde::Deserialize;

use super::error::{ObservationError, Problem};
use super::image::read_image;
use super::need::Need;
use super::pair::OneOrTwo;

use super::table::{Fields, Table, line_of, parse_toml, read_text};
use crate::document::{Fault, Source};

/// Most bins of all maps of a file: beyond it they do not fit into memory.
const MOST_CELLS: usize = 200_000_000;

/// The unit of a map's values.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
pub enum MapUnit {
    /// Signal with one unknown gain, common to all maps of the file.
    #[serde(rename = "relative")]
    Relative,
    /// Illuminance.
    #[serde(rename = "lx")]
    Lux,
    /// Irradiance.
    #[serde(rename = "W/m2")]
    WattPerSquareMetre,
}

/// Where and how one map was taken.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MapPose {
    /// Its name.
    pub name: String,
    /// From the light centre to the sensor's centre.
    pub distance_mm: f64,
    /// Rotation about x, applied last.
    #[serde(default)]
    pub tilt_x_deg: f64,
    /// Rotation about y.
    #[serde(default)]
    pub tilt_y_deg: f64,
    /// Rotation about z, applied first.
    #[serde(default)]
    pub rot_z_deg: f64,
    /// Shift in x and y.
    #[serde(default)]
    pub offset_mm: [f64; 2],
    /// Relative exposure; the signal is proportional to it.
    #[serde(default = "one")]
    pub exposure: f64,
    /// Whether the lamp was on.
    #[serde(default = "yes")]
    pub lamp: bool,
    /// Whether the sensor was capped.
    #[serde(default)]
    pub capped: bool,
    /// Seconds since the lamp was switched on, where known.
    pub time_s: Option<f64>,
    /// Temperature of the room in °C, where known.
    pub ambient_c: Option<f64>,
    /// The image that holds the values.
    pub file: Option<Utf8PathBuf>,
    /// Not to be fitted; without values it is only a pose to predict.
    #[serde(default)]
    pub held_out: bool,
}

fn one() -> f64 {
    1.0
}

fn yes() -> bool {
    true
}

/// One bin of one map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Cell {
    /// Number of the map in [`MapSet::maps`].
    pub map: u32,
    /// Row, 0 at the smallest y.
    pub iy: u32,
    /// Column, 0 at the smallest x.
    pub ix: u32,
}

/// Maps of one sensor, bin by bin.
#[derive(Debug, Clone, PartialEq)]
pub struct MapSet {
    path: Utf8PathBuf,
    sensor_mm: [f64; 2],
    bins: [usize; 2],
    unit: MapUnit,
    full_scale: Option<f64>,
    maps: Vec<MapPose>,
    cells: Vec<Cell>,
    values: Option<(Vec<f64>, Vec<f64>)>,
    /// Where on the sensor the mean of each cell lies, where that is not the middle of an even grid's bin.
    places_mm: Option<Vec<[f64; 2]>>,
}

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

impl MapSet {
    /// Maps from their parts: `cells`, and with them `signal` and `u`, one each a cell, or none of both.
    ///
    /// Used by whoever rebins; files come through [`MapSet::open`].
    ///
    /// # Errors
    /// [`ObservationError`] when a cell lies outside its map, or a value is not finite or its uncertainty not positive.
    pub fn new(
        template: &Self,
        bins: [usize; 2],
        cells: Vec<Cell>,
        values: Option<(Vec<f64>, Vec<f64>)>,
    ) -> Result<Self, ObservationError> {
        let refuse = |problem| Err(ObservationError::new(&template.path, None, problem));
        for cell in &cells {
            if cell.map as usize >= template.maps.len() {
                return refuse(Problem::UnknownMap(cell.map.to_string()));
            }
            for (column, index, bins) in [("ix", cell.ix, bins[0]), ("iy", cell.iy, bins[1])] {
                if index as usize >= bins {
                    return refuse(Problem::OutsideMap {
                        column,
                        found: index.to_string(),
                        last: bins - 1,
                    });
                }
            }
        }
        if let Some((signal, u)) = &values {
            if signal.len() != cells.len() || u.len() != cells.len() {
                return refuse(Problem::FieldCount {
                    found: signal.len().min(u.len()),
                    expected: cells.len(),
                });
            }
            if let Some(bad) = signal.iter().find(|value| !value.is_finite()) {
                return refuse(Problem::OutOfRange {
                    column: "signal",
                    found: *bad,
                    expected: "finite",
                });
            }
            if let Some(bad) = u.iter().find(|value| !(value.is_finite() && **value > 0.0)) {
                return refuse(Problem::OutOfRange {
                    column: "u",
                    found: *bad,
                    expected: "above zero",
                });
            }
        }
        Ok(Self {
            bins,
            cells,
            values,
            places_mm: None,
            ..template.clone()
        })
    }

    /// The same cells as means about these places (mm, in the sensor's own frame), one each a cell: what was averaged
    /// over blocks of unequal size, or over blocks with bins missing.
    ///
    /// None where there is not one place for every cell, or one is not finite.
    pub fn centred_at(self, places_mm: Vec<[f64; 2]>) -> Option<Self> {
        let possible = places_mm.len() == self.cells.len() && places_mm.iter().flatten().all(|mm| mm.is_finite());
        possible.then_some(Self {
            places_mm: Some(places_mm),
            ..self
        })
    }

    /// Where on the sensor the mean of cell number `index` lies, in mm from its middle.
    pub fn place_mm(&self, index: usize) -> [f64; 2] {
        if let Some(places_mm) = &self.places_mm {
            return places_mm[index];
        }
        let cell = &self.cells[index];
        let middle = |i: u32, bins: usize, side_mm: f64| ((f64::from(i) + 0.5) / bins as f64 - 0.5) * side_mm;
        [
            middle(cell.ix, self.bins[0], self.sensor_mm[0]),
            middle(cell.iy, self.bins[1], self.sensor_mm[1]),
        ]
    }

    /// The same sensor at other poses: every bin of every map, without values.
    ///
    /// None without poses.
    pub fn at_poses(&self, maps: Vec<MapPose>) -> Option<Self> {
        let [nx, ny] = self.bins;
        let cells = (0..maps.len() as u32)
            .flat_map(|map| (0..ny as u32).flat_map(move |iy| (0..nx as u32).map(move |ix| Cell { map, iy, ix })))
            .collect();
        (!maps.is_empty()).then(|| Self {
            maps,
            cells,
            values: None,
            places_mm: None,
            ..self.clone()
        })
    }

    /// Maps from `maps.toml`, with the values of the CSV of the same name beside it or of the images that it names.
    ///
    /// # Errors
    /// [`ObservationError`] with file and line.
    pub fn open(path: &Utf8Path, need: Need) -> Result<Self, ObservationError> {
        let text = read_text(path)?;
        let document: Document = parse_toml(path, &text)?;
        let mut set = Self {
            path: path.to_owned(),
            sensor_mm: document.sensor_mm.both(),
            bins: document.bins.both(),
            unit: document.unit,
            full_scale: document.full_scale,
            maps: Vec::new(),
            cells: Vec::new(),
            values: None,
            places_mm: None,
        };
        let refuse = |column, found: f64, expected, line| {
            let problem = Problem::OutOfRange {
                column,
                found,
                expected,
            };
            Err(ObservationError::new(path, line, problem))
        };
        let source = Source {
            file: path,
            text: &text,
        };
        let line_of_key = |key: &str| source.locate(&Fault::new(key, "")).line.map(|line| line as u64);
        for (side_mm, bins) in set.sensor_mm.into_iter().zip(set.bins) {
            if !(1e-4..=1e5).contains(&side_mm) {
                return refuse(
                    "sensor_mm",
                    side_mm,
                    "within 0.0001 to 100000",
                    line_of_key("sensor_mm"),
                );
            }
            if !(1..=65_536).contains(&bins) {
                return refuse("bins", bins as f64, "within 1 to 65536", line_of_key("bins"));
            }
        }
        if set.bins[0] * set.bins[1] * document.map.len().max(1) > MOST_CELLS {
            let cells = (set.bins[0] * set.bins[1] * document.map.len()) as f64;
            return refuse("bins", cells, "at most 200000000 in all maps", line_of_key("bins"));
        }
        if let Some(full_scale) = set.full_scale
            && !(1e-12..=1e12).contains(&full_scale)
        {
            return refuse(
                "full_scale",
                full_scale,
                "within 1e-12 to 1e12",
                line_of_key("full_scale"),
            );
        }
        let mut lines: HashMap<String, u64> = HashMap::new();
        for map in document.map {
            let line = line_of(&text, map.span().start);
            let map = map.into_inner();
            let [x, y] = map.offset_mm;
            let (angle, shift) = ("within -360 to 360", "within -1000000 to 1000000");
            for (column, found, low, high, expected) in [
                ("distance_mm", map.distance_mm, 1e-3, 1e8, "within 0.001 to 100000000"),
                ("exposure", map.exposure, 1e-9, 1e9, "within 1e-9 to 1e9"),
                ("tilt_x_deg", map.tilt_x_deg, -360.0, 360.0, angle),
                ("tilt_y_deg", map.tilt_y_deg, -360.0, 360.0, angle),
                ("rot_z_deg", map.rot_z_deg, -360.0, 360.0, angle),
                ("offset_mm", x, -1e6, 1e6, shift),
                ("offset_mm", y, -1e6, 1e6, shift),
                ("time_s", map.time_s.unwrap_or(0.0), -1e9, 1e9, "within -1e9 to 1e9"),
                (
                    "ambient_c",
                    map.ambient_c.unwrap_or(0.0),
                    -100.0,
                    200.0,
                    "within -100 to 200",
                ),
            ] {
                if !(low..=high).contains(&found) {
                    return refuse(column, found, expected, Some(line));
                }
            }
            if let Some(first) = lines.insert(map.name.clone(), line) {
                let problem = Problem::Duplicate {
                    what: format!("map `{}`", map.name),
                    first,
                };
                return Err(ObservationError::new(path, Some(line), problem));
            }
            set.maps.push(map);
        }
        if set.maps.is_empty() {
            return Err(ObservationError::new(path, None, Problem::NoRows("maps")));
        }
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

    /// The TOML file.
    pub fn path(&self) -> &Utf8Path {
        &self.path
    }

    /// Width and height of the sensor.
    pub const fn sensor_mm(&self) -> [f64; 2] {
        self.sensor_mm
    }

    /// Bins along x and y.
    pub const fn bins(&self) -> [usize; 2] {
        self.bins
    }

    /// The unit of the values.
    pub const fn unit(&self) -> MapUnit {
        self.unit
    }

    /// The signal at which the sensor is full, in the unit of the values, where the file says so.
    pub const fn full_scale(&self) -> Option<f64> {
        self.full_scale
    }

    /// Where and how each map was taken, in file order.
    pub fn maps(&self) -> &[MapPose] {
        &self.maps
    }

    /// The bins, in file order; every bin by map, iy, ix where the file has only poses.
    pub fn cells(&self) -> &[Cell] {
        &self.cells
    }

    /// The measured signals and their standard uncertainties, one each a cell, where they are known.
    pub fn values(&self) -> Option<(&[f64], &[f64])> {
        self.values
            .as_ref()
            .map(|(signal, u)| (signal.as_slice(), u.as_slice()))
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
        let columns = table.columns_with(
            &csv_path,
            &[&["map", "iy", "ix"], values].concat(),
            "map, iy, ix, signal, u",
        )?;
        let by_name: HashMap<&str, usize> = self
            .maps
            .iter()
            .enumerate()
            .map(|(i, map)| (map.name.as_str(), i))
            .collect();
        let [nx, ny] = self.bins;
        let mut first_line: HashMap<Cell, u64> = HashMap::with_capacity(table.rows.len());
        let (mut signal, mut u) = (Vec::new(), Vec::new());
        for (line, fields) in &table.rows {
            let fields = Fields {
                path: &csv_path,
                line: *line,
                columns: &columns,
                fields,
            };
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
            if let Some(first) = first_line.insert(cell, *line) {
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
