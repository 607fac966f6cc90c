//! Spectra over angle of TM-33-23 (`SpectralData/AngularSpectral`).

use isolux_spectrum::Spectrum;

use crate::finding::{Finding, Findings};
use crate::number;
use crate::text::Text;
use crate::xml;

/// A direction (C, γ) in degrees and its spectrum.
pub type OfDirection = ((f64, f64), Spectrum);

/// C and γ, or wavelength and value.
type Pair = (f64, f64);

/// The spectra of the first emitter that has some, any scale, in the order of the file; empty without any.
///
/// # Errors
/// A finding with the line of what is no number or no spectrum.
pub fn spectra(bytes: &[u8]) -> Result<Vec<OfDirection>, Finding> {
    let text = Text::decode(bytes, &mut Findings::new());
    // What is malformed is said where the intensities are read.
    let Ok(root) = xml::parse(text.content()) else {
        return Ok(Vec::new());
    };
    let mut emitters = root.children.iter().filter(|child| child.name == "Emitter");
    let Some(holder) = emitters.find_map(|emitter| emitter.child("SpectralData")?.child("AngularSpectral")) else {
        return Ok(Vec::new());
    };
    let mut found: Vec<(Pair, Vec<Pair>)> = Vec::new();
    for point in holder.children.iter().filter(|child| child.name == "IntData") {
        let wrong = |what: &str| {
            Finding::warning("tm33-spectrum", format!("the point has no {what} that is a number"))
                .at(point.line, point.column)
                .assumed("no spectra over angle")
        };
        let angle = |name: &'static str| -> Result<f64, Finding> {
            let text = point.attribute(&[name]).ok_or_else(|| wrong(name))?;
            Ok(number::read(text).map_err(|_| wrong(name))?.value)
        };
        let at = (angle("h")?, angle("v")?);
        let value = number::read(&point.text).map_err(|_| wrong("value"))?.value;
        let sample = (angle("w")?, value);
        match found.iter_mut().rfind(|(direction, _)| *direction == at) {
            Some((_, samples)) => samples.push(sample),
            None => found.push((at, vec![sample])),
        }
    }
    let spectrum = |(at, mut samples): (Pair, Vec<Pair>)| {
        samples.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (wavelength_nm, value) = samples.into_iter().unzip();
        let spectrum = Spectrum::new(wavelength_nm, value).map_err(|error| {
            Finding::warning(
                "tm33-spectrum",
                format!("the spectrum at C {}°, γ {}°: {error}", at.0, at.1),
            )
            .at(holder.line, holder.column)
            .assumed("no spectra over angle")
        })?;
        Ok((at, spectrum))
    };
    found.into_iter().map(spectrum).collect()
}
