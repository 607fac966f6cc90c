//! One of the things that are compared: a file, or a run with the uncertainties of its results.

use camino::Utf8Path;
use isolux_formats::{Content, ReadOptions};
use isolux_photometry::IntensityDistribution;
use isolux_reduce::{Quantity, of_directions_cd};

use crate::Failure;
use crate::day::stored;
use crate::formats::inspect::{self, Quantities};
use crate::run::record;

/// A quantity of an item.
#[derive(Debug, Clone)]
pub(super) struct Value {
    pub name: String,
    pub value: f64,
    pub unit: String,
    /// With its parts, where it is that of a run.
    pub known: Option<Quantity>,
}

/// What is known of one item.
#[derive(Debug, Clone)]
pub(super) struct Item {
    pub name: String,
    pub distribution: IntensityDistribution,
    pub values: Vec<Value>,
    /// Standard uncertainty of each intensity, cd, in the order of the distribution; none where one is not known.
    pub u_cd: Option<Vec<f64>>,
    /// The meter of a run with its calibration: two runs with the same share its error.
    pub meter: Option<String>,
}

impl Item {
    /// # Errors
    /// Bad input (exit 2) for what holds no distribution.
    pub fn load(path: &Utf8Path) -> Result<Self, Failure> {
        if path.is_dir() {
            Self::of_run(path)
        } else {
            Self::of_file(path)
        }
    }

    fn of_run(folder: &Utf8Path) -> Result<Self, Failure> {
        let run = record::read_at_rest(folder)?;
        let reduction = stored::reduction(folder, &run)?;
        let mut values = Vec::new();
        let mut add = |name: &str, of: &Quantity| {
            values.push(Value {
                name: name.to_owned(),
                value: of.value,
                unit: of.unit.to_string(),
                known: Some(of.clone()),
            });
        };
        add("luminous flux", &reduction.flux);
        add("maximum intensity", &reduction.i_max);
        for plane in &reduction.angles {
            for (what, angle) in [("beam angle", &plane.beam), ("field angle", &plane.field)] {
                if let Some(angle) = angle {
                    add(&format!("{what} {}", plane.name()), angle);
                }
            }
        }
        if let Some(spectral) = &reduction.spectral {
            let colour = &spectral.colour;
            for (name, of) in [
                ("CCT", &colour.cct),
                ("u′", &colour.u_prime),
                ("v′", &colour.v_prime),
                ("Ra", &colour.ra),
            ] {
                if let Some(of) = of {
                    add(name, of);
                }
            }
        }
        let luxmeter = run.header.station.luxmeter();
        let meter = run.header.luxmeter_name().map(|meter| {
            let certificate = (&luxmeter.certificate, &luxmeter.calibrated);
            format!("{meter}, {:?}, {certificate:?}", luxmeter.calibration_factor)
        });
        let known = reduction.i_max.missing.is_empty();
        Ok(Self {
            name: folder.to_string(),
            u_cd: known.then(|| of_directions_cd(&reduction.grid, &reduction.common)),
            distribution: reduction.grid.distribution,
            values,
            meter,
        })
    }

    fn of_file(path: &Utf8Path) -> Result<Self, Failure> {
        let mut seen = inspect::file(path, ReadOptions::default());
        let found = seen
            .iter()
            .position(|one| matches!(one.content, Some(Content::Distribution(_))));
        let Some(inspection) = found.map(|place| seen.swap_remove(place)) else {
            let why = seen.iter().flat_map(|one| &one.findings).next();
            let why = why.map_or_else(
                || "holds no distribution".to_owned(),
                |finding| finding.message.to_string(),
            );
            return Err(Failure::bad_input(format!("{path}: {why}"))
                .help("give photometric files, a model.toml, or the directory of a run"));
        };
        let Some(Content::Distribution(distribution)) = inspection.content else {
            return Err(Failure::bad_input(format!("{path}: holds no distribution")));
        };
        let mut values = Vec::new();
        let mut add = |name: &str, value: f64, unit: &str| {
            values.push(Value {
                name: name.to_owned(),
                value,
                unit: unit.to_owned(),
                known: None,
            });
        };
        let grid = &distribution.intensity;
        add("luminous flux", grid.flux_lm(), "lm");
        add("maximum intensity", grid.peak().intensity_cd, "cd");
        for c_deg in [0.0, 90.0] {
            let plane = if grid.c_deg().len() == 1 {
                Some(0)
            } else {
                grid.plane_at(c_deg)
            };
            let pair = format!("C{c_deg}–C{}", c_deg + 180.0);
            let angles = plane.map(|plane| {
                [
                    ("beam angle", grid.beam_angle(plane)),
                    ("field angle", grid.field_angle(plane)),
                ]
            });
            for (what, angle) in angles.into_iter().flatten() {
                if let Some(angle) = angle {
                    add(&format!("{what} {pair}"), angle.full_angle_deg(), "°");
                }
            }
        }
        if let Quantities::Coloured(all) = &inspection.quantities {
            let total = &all.colour_over_angle.total;
            if let Some(cct_k) = total.cct_k {
                add("CCT", cct_k, "K");
            }
            add("u′", total.u_prime, "");
            add("v′", total.v_prime, "");
        }
        Ok(Self {
            name: path.to_string(),
            distribution: distribution.intensity,
            values,
            u_cd: None,
            meter: None,
        })
    }
}
