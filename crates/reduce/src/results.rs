//! What a reduction leaves behind: photometric files, and the budget of every headline number.

use isolux_formats::eulumdat::{self, Header, LampSet};
use isolux_formats::ies;
use isolux_photometry::IntensityDistribution;
use serde_json::{Value, json};

use crate::distribution::Reduction;
use crate::error::ReduceError;
use crate::spectral::SpectralReduction;
use crate::uncertainty::Combined;

/// What is known of the luminaire beside its light; goes into the headers of the files.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Description {
    /// Name of the luminaire or of the run.
    pub name: String,
    /// Who measured, and with what program.
    pub laboratory: String,
    /// Number of the report.
    pub report: String,
    /// Day of the measurement, as the run has it.
    pub date: String,
    /// Diameter of the luminous area in mm.
    pub luminous_diameter_mm: Option<f64>,
    /// General colour rendering index.
    pub ra: Option<f64>,
}

/// One file of results.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ResultFile {
    /// Its name in `results/`.
    pub name: &'static str,
    /// Its bytes.
    pub bytes: Vec<u8>,
}

/// The photometric files of a reduction and what they could not hold.
#[derive(Debug, Clone, PartialEq)]
pub struct LuminaireFiles {
    /// `luminaire.ldt` and `luminaire.ies`.
    pub files: Vec<ResultFile>,
    /// Directions where noise about zero came out negative; the files hold zero there, the budget's flux does not.
    pub negative_points: usize,
    /// What writing them as zero adds to the flux, in lm.
    pub negative_flux_lm: f64,
    /// What the formats had no room for.
    pub remarks: Vec<String>,
}

/// Writes EULUMDAT and LM-63-2002 in absolute photometry (lamp count −1, line 26c the luminaire's flux, LORL 100 %).
///
/// # Errors
/// [`ReduceError::File`] when a format refuses the distribution.
pub fn luminaire_files(
    reduction: &Reduction,
    spectral: Option<&SpectralReduction>,
    description: &Description,
) -> Result<LuminaireFiles, ReduceError> {
    let flux_lm = reduction.distribution.flux().value();
    let floor: Vec<f64> = reduction
        .distribution
        .intensity_cd()
        .iter()
        .map(|value| value.max(0.0))
        .collect();
    let negative_points = reduction
        .distribution
        .intensity_cd()
        .iter()
        .filter(|value| **value < 0.0)
        .count();
    let shown = IntensityDistribution::new(
        reduction.distribution.c_deg().to_vec(),
        reduction.distribution.gamma_deg().to_vec(),
        floor,
    )?;
    let cct = spectral
        .and_then(|spectral| spectral.cct_k.as_ref())
        .map(|cct| format!("{:.0} K", cct.value));
    let header = Header {
        company: description.laboratory.clone(),
        report: description.report.clone(),
        name: description.name.clone(),
        file_name: "luminair".to_owned(),
        date_user: description.date.clone(),
        luminous_length_mm: description.luminous_diameter_mm,
        luminous_width_mm: Some(0.0),
        luminous_height_mm: [Some(0.0); 4],
        length_mm: description.luminous_diameter_mm,
        width_mm: Some(0.0),
        height_mm: Some(0.0),
        conversion_factor: Some(1.0),
        tilt_deg: Some(0.0),
        lorl_percent: Some(100.0),
        lamp_sets: vec![LampSet {
            count: Some(-1.0),
            lamp: "LED".to_owned(),
            flux_lm: Some(flux_lm),
            colour: cct.unwrap_or_default(),
            rendering: description.ra.map(|ra| format!("{ra:.0}")).unwrap_or_default(),
            watts: None,
        }],
        ..Header::default()
    };
    let ldt = eulumdat::write(&shown, &header).map_err(|finding| ReduceError::File {
        file: "luminaire.ldt",
        message: finding.message.into(),
    })?;
    let radius_m = description
        .luminous_diameter_mm
        .map_or(0.0, |diameter| -diameter * 1e-3);
    let facts = ies::Facts {
        keywords: vec![
            ("TEST".to_owned(), description.report.clone()),
            ("TESTLAB".to_owned(), description.laboratory.clone()),
            ("ISSUEDATE".to_owned(), description.date.clone()),
            ("MANUFAC".to_owned(), String::new()),
            ("LUMINAIRE".to_owned(), description.name.clone()),
            ("LAMP".to_owned(), "LED".to_owned()),
        ],
        lamp_flux_lm: None,
        lamp_count: 1.0,
        // A negative width and length of equal size is the format's code for a circular opening.
        opening_m: [radius_m, radius_m, 0.0],
        watts: 0.0,
        generation: None,
    };
    let ies = ies::write(&shown, &facts, ies::Edition::E2002);
    let remarks = ldt
        .findings
        .iter()
        .chain(&ies.findings)
        .map(|finding| finding.message.to_string())
        .collect();
    Ok(LuminaireFiles {
        files: vec![
            ResultFile {
                name: "luminaire.ldt",
                bytes: ldt.bytes,
            },
            ResultFile {
                name: "luminaire.ies",
                bytes: ies.bytes,
            },
        ],
        negative_points,
        negative_flux_lm: shown.flux().value() - flux_lm,
        remarks,
    })
}

/// `budget.json`: each headline number with its standard uncertainty (k = 1) and the parts that make it.
pub fn budget(reduction: &Reduction, spectral: Option<&SpectralReduction>) -> Value {
    let level = |level: &crate::level::Level| json!({ "illuminance_lx": level.illuminance_lx, "u_lx": level.u_lx, "digit_lx": level.digit_lx });
    let mut numbers = json!({
        "flux_lm": number(&reduction.flux_lm()),
        "i_max_cd": number(&reduction.i_max_cd()),
    });
    if let Some(spectral) = spectral {
        numbers["irradiance_w_m2"] = number(&spectral.irradiance_w_m2);
        numbers["illuminance_lx"] = number(&spectral.illuminance_lx);
        numbers["ler_lm_per_w"] = number(&spectral.ler_lm_per_w);
        numbers["cct_k"] = spectral.cct_k.as_ref().map_or(Value::Null, number);
    }
    json!({
        "format": "isolux-budget/1",
        "coverage_factor": 1,
        "numbers": numbers,
        "distance_mm": reduction.distance_mm,
        "spectrum_distance_mm": spectral.map(|spectral| spectral.distance_mm),
        "applied": reduction.applied.iter().map(ToString::to_string).collect::<Vec<_>>(),
        "not_possible": reduction.not_possible.iter()
            .map(|(correction, why)| json!({ "correction": correction.to_string(), "why": why })).collect::<Vec<_>>(),
        "not_stated": reduction.not_stated.iter()
            .chain(spectral.iter().flat_map(|spectral| &spectral.not_stated)).collect::<Vec<_>>(),
        "levels": {
            "capped": reduction.levels.capped.as_ref().map(level),
            "lamp_off": reduction.levels.lamp_off.as_ref().map(level),
            "baffled": reduction.levels.baffled.iter()
                .map(|(gamma, at)| { let mut entry = level(at); entry["gamma_deg"] = json!(gamma); entry }).collect::<Vec<_>>(),
        },
        "drift": reduction.drift.as_ref().map(|drift| json!({
            "visits": drift.visits, "change_rel": drift.change_rel(), "residual_rel": drift.residual_rel,
            "from_s": drift.span_s.0, "to_s": drift.span_s.1,
        })),
        "closing_plane": reduction.closing,
    })
}

fn number(combined: &Combined) -> Value {
    json!(combined)
}
