//! Spectrum and colour.

use isolux_reduce::Quantity;

use crate::document::Section;
use crate::plots::{Diagram, SpectrumOptions, chromaticity, spectrum, tm30, tm30_bins};

use super::results::DayResults;

/// None without a spectrum: the verdict says that colour was not measured.
pub fn section(day_results: &DayResults) -> Option<Section> {
    let spectral = day_results.reduction.spectral.as_ref()?;
    let colour = day_results.colour.as_ref()?;
    let mut section = Section::new("Spectrum and colour");
    let options = SpectrumOptions {
        title: String::new(),
        value_label: "spectral irradiance in W/(m²·nm)".to_owned(),
    };
    section.figures([
        (
            spectrum(&spectral.spectrum, &options),
            &format!("Spectral irradiance on the axis at {} mm.", spectral.distance_mm),
        ),
        (
            chromaticity(&spectral.spectrum, Diagram::Cie1976, ""),
            "Chromaticity in the CIE 1976 diagram, with the Planckian locus.",
        ),
    ]);
    let stated = |quantity: &Option<Quantity>| quantity.as_ref().map_or_else(|| "none".to_owned(), Quantity::stated);
    let nanometres = |value: Option<f64>| value.map_or_else(|| "none".to_owned(), |nm| format!("{nm:.1} nm"));
    let of = &spectral.colour;
    section.facts(vec![
        ("correlated colour temperature".to_owned(), stated(&of.cct)),
        ("Duv, from the Planckian locus".to_owned(), stated(&of.duv)),
        ("x (CIE 1931)".to_owned(), stated(&of.x)),
        ("y (CIE 1931)".to_owned(), stated(&of.y)),
        ("u′ (CIE 1976)".to_owned(), stated(&of.u_prime)),
        ("v′ (CIE 1976)".to_owned(), stated(&of.v_prime)),
        ("Ra (CIE 13.3)".to_owned(), stated(&of.ra)),
        ("R9".to_owned(), stated(&of.r9)),
        ("Rf (TM-30, CIE 224)".to_owned(), stated(&of.rf)),
        ("Rg (TM-30)".to_owned(), stated(&of.rg)),
        ("peak wavelength".to_owned(), nanometres(colour.peak_nm)),
        ("dominant wavelength".to_owned(), nanometres(colour.dominant_nm)),
        ("full width at half maximum".to_owned(), nanometres(colour.fwhm_nm)),
        ("luminous efficacy of radiation".to_owned(), spectral.ler.stated()),
        ("irradiance there".to_owned(), spectral.irradiance.stated()),
        ("illuminance there".to_owned(), spectral.illuminance.stated()),
    ]);
    section.paragraph("U is not evaluated for the wavelengths and the single indices below.");
    if let Some(r) = colour.r {
        section.subheading("Special colour rendering indices (CIE 13.3)");
        let head = (1..=15).map(|k| format!("R{k}"));
        let row = r.iter().map(|index| format!("{index:.0}"));
        section.numbers(
            std::iter::once(String::new()).chain(head).collect(),
            vec![std::iter::once("Ri".to_owned()).chain(row).collect()],
        );
    }
    if let (Some(graphic), Some(bins)) = (tm30(&spectral.spectrum, ""), tm30_bins(&spectral.spectrum, "")) {
        section.figures([
            (
                graphic,
                "TM-30: the arrows show how colours of each hue are shifted; outside the circle they are more saturated than in the \
                 reference light.",
            ),
            (bins, "TM-30: fidelity and shift of chroma of the sixteen hue bins."),
        ]);
    }
    if let (Some(rf), Some(chroma)) = (colour.rf_hue, colour.rcs_hue_percent) {
        let head = (1..=16).map(|bin| format!("{bin}"));
        let row = |name: &str, values: [f64; 16]| {
            let cells = values.iter().map(|value| format!("{value:.0}"));
            std::iter::once(name.to_owned()).chain(cells).collect()
        };
        section.numbers(
            std::iter::once("hue bin".to_owned()).chain(head).collect(),
            vec![row("Rf,h", rf), row("chroma shift in %", chroma)],
        );
    }
    Some(section)
}
