//! The readings, bins and samples of all observations in one table: what was measured, how well, and where.

use serde::Serialize;

/// What reached the detector, as the record says it (`predict` follows it).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Light {
    /// Lamp on, path free.
    Lit,
    /// Lamp on, direct path blocked.
    Baffled,
    /// Lamp off: ambient and offset.
    LampOff,
    /// Detector capped: offset only.
    Capped,
}

/// The coordinates in which a disagreement can live.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Coordinate {
    /// Seconds along the record.
    TimeS,
    /// Signed γ of the axis.
    GammaDeg,
    /// C of the axis.
    CDeg,
    /// Distance from the intersection of the axes, or of the sensor.
    DistanceMm,
    /// Sign of the last γ motion.
    Travel,
    /// The meter's range.
    Range,
    /// Room temperature.
    AmbientC,
    /// The signal that the model expects (never the noisy reading itself).
    Level,
    /// Sensor x.
    XMm,
    /// Sensor y.
    YMm,
    /// Distance from the sensor's centre.
    RadiusMm,
    /// Angle of incidence on the sensor.
    IncidenceDeg,
    /// Relative exposure of a map.
    Exposure,
    /// Wavelength of a spectrum's sample.
    WavelengthNm,
    /// The number of a reading in its record.
    Index,
    /// The scatter of the readings themselves.
    Noise,
}

impl Coordinate {
    /// The name in files: `time_s`, `gamma_deg`, …
    pub const fn name(self) -> &'static str {
        match self {
            Self::TimeS => "time_s",
            Self::GammaDeg => "gamma_deg",
            Self::CDeg => "c_deg",
            Self::DistanceMm => "distance_mm",
            Self::Travel => "travel",
            Self::Range => "range",
            Self::AmbientC => "ambient_c",
            Self::Level => "level",
            Self::XMm => "x_mm",
            Self::YMm => "y_mm",
            Self::RadiusMm => "radius_mm",
            Self::IncidenceDeg => "incidence_deg",
            Self::Exposure => "exposure",
            Self::WavelengthNm => "wavelength_nm",
            Self::Index => "index",
            Self::Noise => "noise",
        }
    }
}

/// What kind of observation a row comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ObservationKind {
    /// One reading of the lux meter.
    Reading,
    /// One bin of a sensor map.
    Bin,
    /// One sample of a spectrum.
    Sample,
}

/// One row: a reading, a bin or a spectral sample. A coordinate that has no meaning for the source is NaN.
#[derive(Debug, Clone, Copy)]
pub struct Row {
    /// What it is.
    pub source: ObservationKind,
    /// Number of the observation file that it comes from.
    pub file: usize,
    /// Number of the map (bins), of the block (readings) or of the spectrum (samples) inside that file.
    pub group: usize,
    /// Measured value, in the file's unit.
    pub measured: f64,
    /// Stated standard uncertainty, same unit.
    pub u: f64,
    /// One digit of the display, same unit; 0 where it does not matter.
    pub digit: f64,
    /// What reached the detector.
    pub light: Light,
    /// The reading's own number.
    pub index: f64,
    /// Seconds along the record.
    pub time_s: f64,
    /// Seconds since the lamp was switched on, along the record where that is not known.
    pub lamp_s: f64,
    /// Axis C.
    pub c_deg: f64,
    /// Axis γ, signed.
    pub gamma_deg: f64,
    /// Distance.
    pub distance_mm: f64,
    /// −1, 0, 1.
    pub travel: f64,
    /// The meter's range.
    pub range: f64,
    /// Room temperature.
    pub ambient_c: f64,
    /// Sensor x.
    pub x_mm: f64,
    /// Sensor y.
    pub y_mm: f64,
    /// Angle of incidence on the sensor.
    pub incidence_deg: f64,
    /// Relative exposure.
    pub exposure: f64,
    /// Wavelength.
    pub wavelength_nm: f64,
}

impl Row {
    /// A row of which nothing but the value is known.
    pub const fn bare(source: ObservationKind, measured: f64, u: f64) -> Self {
        const NONE: f64 = f64::NAN;
        Self {
            source,
            file: 0,
            group: 0,
            measured,
            u,
            digit: 0.0,
            light: Light::Lit,
            index: NONE,
            time_s: NONE,
            lamp_s: NONE,
            c_deg: NONE,
            gamma_deg: NONE,
            distance_mm: NONE,
            travel: NONE,
            range: NONE,
            ambient_c: NONE,
            x_mm: NONE,
            y_mm: NONE,
            incidence_deg: NONE,
            exposure: NONE,
            wavelength_nm: NONE,
        }
    }

    /// The row's value of a coordinate; `level` is the model's expectation for it. NaN where it has no meaning.
    pub fn coordinate(&self, coordinate: Coordinate, level: f64) -> f64 {
        match coordinate {
            Coordinate::TimeS => self.time_s,
            Coordinate::GammaDeg => self.gamma_deg,
            Coordinate::CDeg => self.c_deg,
            Coordinate::DistanceMm => self.distance_mm,
            Coordinate::Travel => self.travel,
            Coordinate::Range => self.range,
            Coordinate::AmbientC => self.ambient_c,
            Coordinate::Level => level,
            Coordinate::XMm => self.x_mm,
            Coordinate::YMm => self.y_mm,
            Coordinate::RadiusMm => self.x_mm.hypot(self.y_mm),
            Coordinate::IncidenceDeg => self.incidence_deg,
            Coordinate::Exposure => self.exposure,
            Coordinate::WavelengthNm => self.wavelength_nm,
            // Scatter has no value at a reading; it is drawn over the numbers of the readings.
            Coordinate::Index | Coordinate::Noise => self.index,
        }
    }
    /// Whether two readings that follow each other are of one visit of a half-plane: of one block, C and light.
    pub fn same_visit(&self, other: &Self) -> bool {
        (self.file, self.group, self.light) == (other.file, other.group, other.light) && self.c_deg == other.c_deg
    }
}

/// The numbers of readings in the order in which they were taken, those of each visit of a half-plane together.
pub fn visits<'a>(readings: impl Iterator<Item = (usize, &'a Row)>) -> Vec<Vec<usize>> {
    let mut visits: Vec<Vec<usize>> = Vec::new();
    let mut before: Option<&Row> = None;
    for (number, row) in readings {
        match visits.last_mut() {
            Some(visit) if before.is_some_and(|before| before.same_visit(row)) => visit.push(number),
            _ => visits.push(vec![number]),
        }
        before = Some(row);
    }
    visits
}
