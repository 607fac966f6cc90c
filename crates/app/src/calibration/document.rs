//! `calibration.json`: what a calibration found, as a type.

use isolux_reduce::standard::{Conditions, LuxFactor, SpectralFactors};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Value of `format`.
pub const FORMAT: &str = "isolux-calibration/1";

/// The file of the factors, as a station names it.
pub(super) const FACTORS: &str = "spectroradiometer.csv";

/// A calibration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Calibration {
    /// [`FORMAT`].
    pub format: String,
    /// Program that made it.
    pub program: String,
    /// Day of the calibration, YYYY-MM-DD.
    pub calibrated: String,
    /// Day it is due again, YYYY-MM-DD.
    pub due: String,
    /// SHA-256 of run.toml of the record, which has that of every file of it.
    pub record_sha256: String,
    /// What was found.
    pub outcome: Outcome,
}

/// What was found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// Factors over wavelength.
    Spectroradiometer(Box<SpectralFactors>),
    /// One factor.
    Luxmeter(Box<LuxFactor>),
}

impl Outcome {
    /// Under what it was found.
    pub fn conditions(&self) -> &Conditions {
        match self {
            Self::Spectroradiometer(factors) => &factors.conditions,
            Self::Luxmeter(factor) => &factor.conditions,
        }
    }
}

impl Calibration {
    /// Lines for the table of the instrument in STATION.toml.
    pub fn station_lines(&self) -> Vec<String> {
        let certificate = &self.outcome.conditions().standard;
        let mut lines = match &self.outcome {
            Outcome::Spectroradiometer(factors) => vec![
                "[spectroradiometer]".to_owned(),
                format!("calibration = {:?}", FACTORS),
                format!("u_rel = {:.5}", factors.u_rel),
                format!("u_shape_rel = {:.5}", factors.u_shape_rel),
            ],
            Outcome::Luxmeter(factor) => vec![
                "[luxmeter]".to_owned(),
                format!("calibration_factor = {:.6}", factor.calibration_factor),
                format!("u_rel = {:.5}", factor.u_rel),
            ],
        };
        lines.extend([
            format!("certificate = {certificate:?}"),
            format!("calibrated = {:?}", self.calibrated),
            format!("due = {:?}", self.due),
        ]);
        lines
    }

    /// What a person reads first, a sentence each.
    pub fn sentences(&self) -> Vec<String> {
        let of = self.outcome.conditions();
        let mut lines = vec![format!(
            "{} with {}, {:.4} A, {} mm; due again on {}",
            of.instrument, of.standard, of.current_a, of.distance_mm, self.due
        )];
        match &self.outcome {
            Outcome::Spectroradiometer(factors) => lines.extend(spectral(factors)),
            Outcome::Luxmeter(factor) => lines.extend([
                format!(
                    "factor {:.5} ± {:.5} (k = 2): {:.3} lx certified there, {:.3} lx shown",
                    factor.calibration_factor,
                    2.0 * factor.u_rel * factor.calibration_factor,
                    factor.certified_lx,
                    factor.shown_lx
                ),
                format!(
                    "drift {:+.2} ± {:.2} % (k = 2) against the factor of the station, {}",
                    100.0 * factor.drift_rel,
                    200.0 * factor.u_rel.hypot(factor.u_former_rel),
                    factor.former_factor
                ),
                format!(
                    "parts of u {}",
                    parts(factor.parts_rel.iter().map(|(name, u)| (name.as_str(), *u)))
                ),
            ]),
        }
        lines
    }
}

fn spectral(factors: &SpectralFactors) -> Vec<String> {
    let nm = &factors.wavelength_nm;
    let last = nm.len() - 1;
    let at = |wanted: f64| nm.partition_point(|nm| *nm < wanted).min(last);
    let shown = [400.0, 450.0, 555.0, 650.0, 750.0].map(at);
    let percent = |rel: f64| format!("{:.2} %", 100.0 * rel);
    let u = shown.map(|place| format!("{} at {:.0} nm", percent(2.0 * factors.u_rel_at(place)), nm[place]));
    let mut lines = vec![
        format!(
            "factors from {:.0} nm to {:.0} nm, U (k = 2) {}",
            nm[0],
            nm[last],
            u.join(", ")
        ),
        format!(
            "illuminance measured with them: U (k = 2) {}",
            percent(2.0 * factors.u_rel)
        ),
    ];
    if let Some(colour) = &factors.colour {
        let cct = colour
            .cct_k
            .map_or_else(String::new, |[cct, u]| format!(", CCT {cct:.0} ± {:.0} K", 2.0 * u));
        lines.push(format!(
            "colour of the standard (k = 2): x {:.4} ± {:.4}, y {:.4} ± {:.4}{cct}",
            colour.x[0],
            2.0 * colour.x[1],
            colour.y[0],
            2.0 * colour.y[1]
        ));
    }
    lines.push(format!(
        "linear within {}, behind the baffle {} of the light, light changed by {:+.2} %",
        percent(factors.nonlinearity_rel),
        percent(factors.stray_rel),
        100.0 * factors.change_rel
    ));
    lines.push(drift(factors));
    let middle = at(555.0);
    let parts_rel = factors
        .components
        .iter()
        .map(|part| (part.name.as_str(), part.u_rel(middle)));
    lines.push(format!("parts of u at {:.0} nm {}", nm[middle], parts(parts_rel)));
    lines
}

/// What has changed since the factors that the station has.
fn drift(factors: &SpectralFactors) -> String {
    let drift = &factors.drift;
    let Some(illuminance_rel) = drift.illuminance_rel else {
        return "drift not known: the station had no factors over the visible".to_owned();
    };
    let u = drift.u_former_rel.map_or_else(
        || {
            format!(
                " (U of the new ones {:.2} %, the station states none)",
                200.0 * factors.u_rel
            )
        },
        |former| format!(" ± {:.2} % (k = 2)", 200.0 * factors.u_rel.hypot(former)),
    );
    let known = drift.relative.iter().zip(&factors.wavelength_nm);
    let within = known.filter_map(|(change, nm)| (400.0..=720.0).contains(nm).then_some(((*change)?, *nm)));
    let largest = within.max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
    let largest = largest.map_or_else(String::new, |(change, nm)| {
        format!("; largest from 400 nm to 720 nm {:+.2} % at {nm:.0} nm", 100.0 * change)
    });
    format!(
        "drift {:+.2} %{u} in illuminance against the factors of the station{largest}",
        100.0 * illuminance_rel
    )
}

fn parts<'a>(parts: impl Iterator<Item = (&'a str, f64)>) -> String {
    let parts: Vec<String> = parts.map(|(name, u)| format!("{name} {:.3} %", 100.0 * u)).collect();
    parts.join(", ")
}
