//! Reads a photometric file of any format and integrates its luminous flux.
//!
//!     cargo run -p isolux-examples --example flux -- crates/formats/tests/golden/absolute.ldt

#![expect(clippy::print_stdout, reason = "an example prints its result")]

use std::error::Error;

use isolux_formats::{Content, Finding, Severity, read_any};

/// Luminous flux in lm of every distribution in the file, and what the reader found wrong with the file.
fn flux_lm(bytes: &[u8], file_name: &str) -> (Vec<f64>, Vec<Finding>) {
    let (mut fluxes_lm, mut findings) = (Vec::new(), Vec::new());
    for parsed in read_any(bytes, file_name) {
        findings.extend(parsed.findings);
        if let Some(Content::Distribution(lamp)) = parsed.document {
            fluxes_lm.push(lamp.intensity.flux_lm());
        }
    }
    (fluxes_lm, findings)
}

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("which file?")?;
    let (fluxes_lm, findings) = flux_lm(&std::fs::read(&path)?, &path);
    for flux_lm in &fluxes_lm {
        println!("{flux_lm:.1} lm");
    }
    for finding in &findings {
        println!(
            "{} in line {:?}: {}",
            finding.severity.word(),
            finding.line,
            finding.message
        );
    }
    if fluxes_lm.is_empty() || findings.iter().any(|finding| finding.severity == Severity::Error) {
        return Err(format!("{path}: no distribution without errors").into());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A Lambertian emitter: Φ = π·I₀.
    #[test]
    fn a_lambertian_emitter_gives_pi_times_its_intensity() {
        let rows = (0..=90).map(|gamma| format!("{gamma},{}\n", 100.0 * f64::from(gamma).to_radians().cos()));
        let file = format!("gamma_deg,intensity_cd\n{}", rows.collect::<String>());
        let (fluxes_lm, findings) = flux_lm(file.as_bytes(), "lamp.csv");
        assert!(findings.is_empty(), "{findings:?}");
        assert!(
            (fluxes_lm[0] / (100.0 * std::f64::consts::PI) - 1.0).abs() < 1e-4,
            "{fluxes_lm:?}"
        );
    }

    #[test]
    fn a_damaged_number_is_found() {
        let (fluxes_lm, findings) = flux_lm(b"gamma_deg,intensity_cd\n0,1O0\n90,0\n", "lamp.csv");
        assert!(
            fluxes_lm.is_empty() && findings[0].severity == Severity::Error,
            "{findings:?}"
        );
    }
}
