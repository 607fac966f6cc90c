//! TM-25 ray files: what `inspect` says of them. Files of any size are read in one pass.

use std::io::{self, BufReader, Read};

use camino::Utf8Path;
use glam::DVec3;
use isolux_formats::tm25::{Damage, Header, Reader, Spectral, Survey, Tm25Error};
use isolux_formats::{Finding, Format, Kind};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::inspection::{Inspection, Quantities};
use super::source::OpenFile;

/// Whether this is a ray file: by content, and by name where the content is damaged.
pub(super) fn are_in(path: &Utf8Path, source: &OpenFile) -> bool {
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    Format::of_extension(&extension) == Some(Format::TM25) || source.begins_with(b"TM25")
}

/// Looks at a ray file.
pub(super) fn inspection(path: &Utf8Path, source: OpenFile) -> Inspection {
    let mut inspection = Inspection {
        file: path.to_string(),
        format: Some(Format::TM25),
        kind: Some(Kind::Rays),
        readable: false,
        findings: Vec::new(),
        quantities: Quantities::None {},
        content: None,
    };
    if let Err(error) = look(source, &mut inspection) {
        inspection.findings.push(finding(&error));
    }
    inspection
}

/// An error of the reader as a finding, with its bytes.
pub(crate) fn finding(error: &Tm25Error) -> Finding {
    let stated = Finding::error(error.code(), error.to_string());
    let stated = match error.span() {
        Some(span) => stated.bytes(span),
        None => stated,
    };
    match error {
        Tm25Error::Length { expected, found, .. } if found < expected => {
            stated.fix("fetch the file again: it is cut off")
        }
        Tm25Error::Truncated { .. } => stated.fix("fetch the file again: it is cut off"),
        _ => stated,
    }
}

fn look(source: OpenFile, inspection: &mut Inspection) -> Result<(), Tm25Error> {
    let length = source.length();
    let mut stream = Counted {
        from: BufReader::new(source),
        bytes: 0,
    };
    let header = Header::read(&mut stream)?;
    inspection.findings.extend(
        header
            .doubts()
            .into_iter()
            .map(|doubt| Finding::warning("tm25-header", doubt.message).bytes(doubt.span)),
    );
    // What is there is looked at even where the count is wrong.
    let mut reader = Reader::over(header, &mut stream);
    let survey = Survey::of(&mut reader)?;
    let header = reader.header().clone();
    // The end of a pipe is known when it has come.
    let length = if let Some(length) = length {
        length
    } else {
        io::copy(&mut stream, &mut io::sink())?;
        stream.bytes
    };
    let expected = header.end();
    if expected != length {
        inspection.findings.push(finding(&Tm25Error::Length {
            rays: header.rays,
            columns: header.columns.count(),
            expected,
            found: length,
        }));
    }
    damage(&header, &survey, &mut inspection.findings);
    if expected == length {
        sums(&header, &survey, &mut inspection.findings);
    }
    inspection.quantities = Quantities::Rays(Box::new(quantities(&header, &survey)));
    inspection.readable = expected == length;
    Ok(())
}

/// Counts the bytes that it hands on.
struct Counted<R> {
    from: R,
    bytes: u64,
}

impl<R: Read> Read for Counted<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let read = self.from.read(into)?;
        self.bytes += read as u64;
        Ok(read)
    }
}

/// Rays that no light can follow.
fn damage(header: &Header, survey: &Survey, findings: &mut Vec<Finding>) {
    let size = 4 * header.columns.count() as u64;
    let mut say = |damage: Damage, make: fn(&'static str, String) -> Finding, code: &'static str, what: &str| {
        if damage.rays > 0 {
            let start = header.data + damage.first * size;
            let first = damage.first + 1;
            let message = format!("{} rays {what}; the first is ray {first}", damage.rays);
            findings.push(make(code, message).bytes([start, start + size]));
        }
    };
    say(
        survey.not_finite,
        Finding::error,
        "tm25-not-finite",
        "have a place, direction or flux that is no finite number",
    );
    say(
        survey.no_direction,
        Finding::error,
        "tm25-no-direction",
        "have the direction (0, 0, 0)",
    );
    say(
        survey.negative,
        Finding::error,
        "tm25-negative-flux",
        "carry less than no flux",
    );
    say(
        survey.no_wavelength,
        Finding::error,
        "tm25-wavelength",
        "have a wavelength that is not above zero",
    );
    say(
        survey.not_unit,
        Finding::warning,
        "tm25-not-unit",
        "have a direction whose length is not 1",
    );
}

/// Header against rays; float32 sums of other programs are allowed their roundings.
fn sums(header: &Header, survey: &Survey, findings: &mut Vec<Finding>) {
    for (stated, found, span, unit) in [
        (header.luminous_flux_lm, survey.luminous_lm, [12, 16], "lm"),
        (header.radiant_flux_w, survey.radiant_w, [16, 20], "W"),
    ] {
        if let (Some(stated), Some(found)) = (stated, found)
            && (found - stated).abs() > 1e-3 * stated.abs()
        {
            findings.push(
                Finding::warning(
                    "tm25-flux",
                    format!("the header states {stated} {unit}, the rays carry {found:.6} {unit}"),
                )
                .bytes(span),
            );
        }
    }
}

/// The quantities of a ray file, in the frame of its header.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RayQuantities {
    /// Rays that are there.
    pub rays: u64,
    /// Rays by the header.
    pub rays_stated: u64,
    /// Luminous flux that they carry.
    pub luminous_flux_lm: Option<f64>,
    /// Radiant flux that they carry.
    pub radiant_flux_w: Option<f64>,
    /// The same by the header.
    pub luminous_flux_stated_lm: Option<f64>,
    /// The same by the header.
    pub radiant_flux_stated_w: Option<f64>,
    /// What is known of each ray.
    pub columns: Vec<String>,
    /// How spectra are given, in a word.
    pub spectral: String,
    /// Shortest and longest wavelength.
    pub wavelength_nm: Option<[f64; 2]>,
    /// Spectra in the header.
    pub spectra: usize,
    /// Smallest coordinates of the places where rays begin.
    pub bounds_min_mm: Option<[f64; 3]>,
    /// The largest.
    pub bounds_max_mm: Option<[f64; 3]>,
    /// Their mean, weighted by flux.
    pub centroid_mm: Option<[f64; 3]>,
    /// Mean direction, weighted by flux; its length is 1 where all rays are parallel.
    pub mean_direction: Option<[f64; 3]>,
    /// C of it.
    pub mean_direction_c_deg: Option<f64>,
    /// γ of it.
    pub mean_direction_gamma_deg: Option<f64>,
    /// γ within which half the flux lies.
    pub half_flux_gamma_deg: Option<f64>,
    /// Share of the flux in zones of 10° of γ.
    pub zonal_flux_share: [f64; 18],
    /// When the file was made, as it says.
    pub created: String,
    /// Whether the rays were measured, not simulated.
    pub measured: bool,
    /// The light source, as the header names it.
    pub light_source: String,
    /// Its manufacturer.
    pub manufacturer: String,
    /// Who made the file.
    pub file_by: String,
}

fn quantities(header: &Header, survey: &Survey) -> RayQuantities {
    let point = |at: Option<DVec3>| at.map(|at| at.to_array());
    let bounds = |k: usize| point(survey.bounds_mm.map(|bounds| bounds[k]));
    let angles = survey.mean_direction.filter(|mean| mean.length() > 1e-9).map(|mean| {
        let c_deg = mean.y.atan2(mean.x).to_degrees().rem_euclid(360.0);
        (c_deg, mean.x.hypot(mean.y).atan2(mean.z).to_degrees())
    });
    let columns = &header.columns;
    let mut names = vec!["place", "direction"];
    for (present, name) in [
        (columns.radiant, "radiant flux"),
        (columns.wavelength, "wavelength"),
        (columns.luminous, "luminous flux"),
        (columns.stokes, "polarisation"),
        (columns.tristimulus, "tristimulus"),
        (columns.spectrum, "spectrum index"),
    ] {
        names.extend(present.then_some(name));
    }
    let names = names.into_iter().map(str::to_owned).chain(header.names.iter().cloned());
    let names = names.collect();
    let single = match header.spectral {
        Spectral::Single(nm) => Some([nm; 2]),
        _ => None,
    };
    let range = single.or(survey.wavelength_nm).or_else(|| {
        let points = header.tables.iter().flat_map(|table| &table.wavelength_nm).copied();
        let [low, high] = [f64::min, f64::max].map(|pick| points.clone().reduce(pick));
        Some([low?, high?])
    });
    let [light_source, manufacturer, _, file_by, ..] = header.texts.clone();
    RayQuantities {
        rays: survey.rays,
        rays_stated: header.rays,
        luminous_flux_lm: survey.luminous_lm,
        radiant_flux_w: survey.radiant_w,
        luminous_flux_stated_lm: header.luminous_flux_lm,
        radiant_flux_stated_w: header.radiant_flux_w,
        columns: names,
        spectral: header.spectral.word().to_owned(),
        wavelength_nm: range,
        spectra: header.tables.len(),
        bounds_min_mm: bounds(0),
        bounds_max_mm: bounds(1),
        centroid_mm: point(survey.centroid_mm),
        mean_direction: point(survey.mean_direction),
        mean_direction_c_deg: angles.map(|angles| angles.0),
        mean_direction_gamma_deg: angles.map(|angles| angles.1),
        half_flux_gamma_deg: survey.half_flux_gamma_deg,
        zonal_flux_share: survey.zones,
        created: header.created.clone(),
        measured: header.method == 1,
        light_source,
        manufacturer,
        file_by,
    }
}
