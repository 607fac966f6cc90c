//! Temporal light modulation.

use isolux_modulation::Modulation;

use crate::document::Section;
use crate::plots::{light_over_frequency, light_over_time};

use super::results::DayResults;

/// None where the job names no waveform.
pub fn section(day_results: &DayResults) -> Option<Section> {
    let modulation = day_results.light_modulation.as_ref()?;
    let mut section = Section::new("Temporal light modulation");
    section.figures([
        (
            light_over_time(modulation, ""),
            "The first periods of the light relative to its mean.",
        ),
        (
            light_over_frequency(modulation, ""),
            "Its components; where one passes the dashed line, the stroboscopic effect of it alone is visible.",
        ),
    ]);
    section.facts(facts(modulation));
    for note in &modulation.notes {
        section.paragraph(format!("{}{}.", note[..1].to_uppercase(), &note[1..]));
    }
    Some(section)
}

/// Names and stated numbers of a waveform.
pub fn facts(modulation: &Modulation) -> Vec<(String, String)> {
    let mut facts = vec![
        ("modulation depth".to_owned(), modulation.modulation_depth.stated()),
        ("flicker index".to_owned(), modulation.flicker_index.stated()),
        ("dominant frequency".to_owned(), modulation.dominant_frequency.stated()),
        ("SVM (IEC TR 63158)".to_owned(), modulation.svm.stated()),
        ("PstLM (IEC TR 61547-1)".to_owned(), modulation.pst_lm.stated()),
        ("mean of the record".to_owned(), modulation.mean.stated()),
        (
            "record".to_owned(),
            format!(
                "{} samples at {} Hz, {:.4} s; noise {:.3} % of the mean",
                modulation.samples,
                modulation.rate_hz,
                modulation.duration_s,
                100.0 * modulation.noise_rel
            ),
        ),
    ];
    for exposed in &modulation.exposures {
        let mut words = format!(
            "peak to peak {:.3} %, standard deviation {:.3} %, of which noise {:.3} %",
            100.0 * exposed.peak_to_peak_rel,
            100.0 * exposed.rms_rel.hypot(exposed.noise_rel),
            100.0 * exposed.noise_rel
        );
        if let Some(banding) = &exposed.banding {
            let period = banding
                .period_rows
                .filter(|rows| rows.is_finite())
                .map_or_else(|| "no bands".to_owned(), |rows| format!("bands of {rows:.1} rows"));
            words += &format!("; rolling shutter: {period}, ±{:.3} %", 100.0 * banding.amplitude_rel);
        }
        facts.push((format!("exposures of {} ms", exposed.exposure_ms), words));
    }
    facts
}
