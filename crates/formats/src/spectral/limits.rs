//! What the heading of a LI-COR text states of its data (`LIMS: 300- 900NM`, `MIN:  318NM -1.459E-05`), against them.

use super::file::SpectrumFile;
use crate::finding::Finding;
use crate::number;
use crate::text::Text;

/// Lines of the heading.
const HEADING: usize = 20;

/// Limits and extremes that the data do not have.
pub(super) fn check(text: &Text<'_>, file: &SpectrumFile) -> Vec<Finding> {
    let mut found = Vec::new();
    let (Some(&first), Some(&last)) = (file.wavelength_nm.first(), file.wavelength_nm.last()) else {
        return found;
    };
    for (index, line) in text.lines().take(HEADING).enumerate() {
        let say = |message: String, fix: &str| {
            Finding::warning("spectrum-limits", message)
                .at(index + 1, 1)
                .raw(line.trim())
                .assumed("the data as they stand")
                .fix(fix)
        };
        let words = line.trim().trim_matches('"');
        if let Some((from, to)) = words.strip_prefix("LIMS:").and_then(limits)
            && (from != first || to != last)
        {
            let message = format!("the heading states {from} to {to} nm, the data go from {first} to {last} nm");
            found.push(say(message, "fetch the file again; it may be cut"));
        }
        for (name, largest) in [("MIN:", false), ("MAX:", true)] {
            let Some((at, stated)) = words.strip_prefix(name).and_then(extreme) else {
                continue;
            };
            let better = |a: f64, b: f64| if largest { a.max(b) } else { a.min(b) };
            let there = file.value.iter().copied().reduce(better);
            let here = file.wavelength_nm.iter().position(|&nm| nm == at);
            let here = here.and_then(|place| file.value.get(place)).copied();
            if there != Some(stated) || here != Some(stated) {
                let message = format!(
                    "the heading states {stated} at {at} nm as the {} value, which the data do not have",
                    if largest { "largest" } else { "smallest" }
                );
                found.push(say(message, "compare the values with the source; one may be damaged"));
            }
        }
    }
    found
}

/// ` 300- 900NM`.
fn limits(words: &str) -> Option<(f64, f64)> {
    let (from, to) = words.trim().strip_suffix("NM")?.split_once('-')?;
    Some((number::read(from).ok()?.value, number::read(to).ok()?.value))
}

/// `  318NM -1.459E-05`.
fn extreme(words: &str) -> Option<(f64, f64)> {
    let (at, value) = words.split_once("NM")?;
    Some((number::read(at).ok()?.value, number::read(value).ok()?.value))
}
