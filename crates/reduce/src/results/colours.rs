//! Colour over angle as files: a table of the directions, the spectrum of each, and the total spectral flux.

use std::fmt::Write as _;

use isolux_formats::Format;
use isolux_formats::spectral::SpectrumFile;
use isolux_record::run::Run;
use isolux_spectrum::Spectrum;

use super::file::{ResultFile, file_name};
use super::photometric::describe;
use crate::Reduction;
use crate::over_angle::{DirectionColour, OverAngle};

/// Folder of the spectra of single directions.
pub const FOLDER: &str = "colour";

/// The file of a direction's spectrum: `colour/c090.0_g040.0.spdx`.
pub fn spectrum_name(of: &DirectionColour) -> String {
    // A direction between tenths of a degree keeps all its digits.
    let tenths = [of.c_deg, of.gamma_deg].iter().all(|deg| (deg * 10.0).fract() == 0.0);
    if tenths {
        format!("{FOLDER}/c{:05.1}_g{:05.1}.spdx", of.c_deg, of.gamma_deg)
    } else {
        format!("{FOLDER}/c{}_g{}.spdx", of.c_deg, of.gamma_deg)
    }
}

/// All of them; none without spectra off the axis.
pub fn files(reduction: &Reduction, run: &Run, program: &str) -> Vec<ResultFile> {
    let Some(found) = &reduction.over_angle else {
        return Vec::new();
    };
    let mut files = vec![
        ResultFile {
            name: file_name(reduction, "luminaire.colour.csv"),
            bytes: directions(found).into_bytes(),
        },
        ResultFile {
            name: file_name(reduction, "luminaire.flux.csv"),
            bytes: total(found).into_bytes(),
        },
    ];
    let spdx = |spectrum: &Spectrum, quantity, unit, what: &str, name: String| {
        let mut file = SpectrumFile::new(spectrum, Some(quantity), Some(unit));
        describe(&mut file, what, run, program);
        let bytes = isolux_formats::write_spectrum(&file, Format::SPDX)?.bytes;
        Some(ResultFile { name, bytes })
    };
    let name = file_name(reduction, "luminaire.flux.spdx");
    files.extend(spdx(&found.total, "flux", "W/nm", "total spectral flux", name));
    for (of, spectrum) in found.facts.directions.iter().zip(&found.intensity) {
        let what = format!("towards C {}° γ {}°", of.c_deg, of.gamma_deg);
        let name = spectrum_name(of);
        files.extend(spdx(spectrum, "intensity", "W/(sr*nm)", &what, name));
    }
    files
}

/// A row for every direction; standard uncertainties (k = 1), nothing where `missing` says what is not known.
fn directions(found: &OverAngle) -> String {
    let missing = found.facts.missing.join("; ").replace('"', "\"\"");
    let mut text = String::from(
        "c_deg,gamma_deg,intensity_cd,x,u_x,y,u_y,u_prime,u_u_prime,v_prime,u_v_prime,cct_k,u_cct_k,duv,u_duv,\
         delta_u_prime_v_prime,missing\n",
    );
    let cell = |value: Option<f64>| value.map_or_else(String::new, |value| format!("{value:.6}"));
    for of in &found.facts.directions {
        let numbers = [
            (Some(of.x), of.u_x),
            (Some(of.y), of.u_y),
            (Some(of.u_prime), of.u_u_prime),
            (Some(of.v_prime), of.u_v_prime),
            (of.cct_k, of.u_cct_k),
            (of.duv, of.u_duv),
        ];
        let cells: Vec<String> = numbers.iter().flat_map(|(value, u)| [cell(*value), cell(*u)]).collect();
        let _ = writeln!(
            text,
            "{},{},{},{},{:.6},\"{missing}\"",
            of.c_deg,
            of.gamma_deg,
            of.intensity_cd,
            cells.join(","),
            of.delta_u_prime_v_prime
        );
    }
    text
}

/// The total spectral flux with its standard uncertainty (k = 1), nothing where something is missing in it.
fn total(found: &OverAngle) -> String {
    let mut text = String::from("wavelength_nm,flux_w_nm,u_w_nm\n");
    let values = found.total.wavelength_nm().iter().zip(found.total.value());
    for (place, (nm, value)) in values.enumerate() {
        let u = found.u_total_w_nm.as_ref().map(|u| format!("{:.3e}", u[place]));
        let _ = writeln!(text, "{nm},{value:.6e},{}", u.unwrap_or_default());
    }
    text
}
