//! Maps of a sensor: `maps.toml` beside `maps.csv` or images.

mod read;

use camino::{Utf8Path, Utf8PathBuf};
use serde::Deserialize;

use crate::table::{ObservationError, Problem};

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
}
