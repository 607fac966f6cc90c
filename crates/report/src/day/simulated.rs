//! The light on the sensor, the test on the axis, and the diagnosis.

use std::borrow::Cow;

use crate::document::{Block, Section};
use crate::html::Page;
use crate::viewer::explorer;
use isolux_units::digits::significant;

use super::results::DayResults;
use super::results::Diagnosed;
use crate::answer::SAME_RECORD;
use crate::diagnosis_page::capitalised;
use crate::sensor::{self, ViewError};
use isolux_diagnose::on_axis::Stated;

pub fn section(day_results: &DayResults) -> Result<Section, ViewError> {
    let facts = &day_results.simulation.facts;
    let unit = facts.unit.symbol();
    let mut section = Section::new("Simulation: irradiance on the sensor");
    let marked = sensor::marked(&day_results.simulation, day_results.u_direction_rel());
    section.paragraph(format!("Mean {}.", sensor::mean(facts)));
    let [map, sections] = marked.figures("noise-free, inverse method");
    section.figures([
        (
            map,
            &format!(
                "{} × {} mm, {} × {} pixels.",
                facts.size_mm[0], facts.size_mm[1], facts.pixels[0], facts.pixels[1]
            ),
        ),
        (sections, "Sections through the middle."),
    ]);
    let relative = |value: f64| format!("{:+.2} %", 100.0 * (value / facts.mean - 1.0));
    section.facts(vec![
        (
            "smallest and largest, against the mean".to_owned(),
            format!("{}, {}", relative(facts.min), relative(facts.max)),
        ),
        (
            "smallest over mean".to_owned(),
            format!("{:.5}", facts.uniformity_min_over_mean),
        ),
        (
            "luminous flux of the model".to_owned(),
            format!("{} lm", significant(facts.flux_lm, 4)),
        ),
        (
            "illuminance, mean".to_owned(),
            format!("{} lx", significant(facts.illuminance_lx, 4)),
        ),
        ("computation".to_owned(), sensor::numeric(facts, unit)),
        ("effects in the map".to_owned(), list(&facts.effects_applied)),
        (
            "effects of the bench, not in the map".to_owned(),
            list(&facts.effects_not_applicable),
        ),
    ]);
    if let Some(u_rel) = day_results.u_direction_rel() {
        let smoothed = if day_results.reduction.grid.smoothed.is_some() {
            " It is drawn from the distribution that was smoothed within these intervals; luminaire.raw.ldt has the one as it was read."
        } else {
            ""
        };
        section.paragraph(format!(
            "Hatched on the scale: twice the standard uncertainty of one direction of the distribution to either side, {} %, by \
             rounding and scatter. Smaller structure may be no light. The map spans {:.2} %.{smoothed}",
            significant(200.0 * u_rel, 2),
            100.0 * (facts.max - facts.min) / facts.mean
        ));
    }
    let mut view = Page::new("");
    view.raw("<div class=\"screen\"><h3>The map, point by point</h3>");
    let summary = [
        ("distance", format!("{} mm", day_results.scene.sensor.pose.distance_mm)),
        ("size", format!("{} × {} mm", facts.size_mm[0], facts.size_mm[1])),
        ("pixels", format!("{} × {}", facts.pixels[0], facts.pixels[1])),
        ("mean", sensor::mean(facts)),
        (
            "smallest / largest",
            format!("{} / {}", relative(facts.min), relative(facts.max)),
        ),
    ];
    let summary = summary.map(|(name, value)| (name.to_owned(), value));
    explorer::add(&mut view, &sensor::picture(&day_results.simulation), &summary, 5, "map")?;
    view.raw("</div>");
    view.raw("<div class=\"screen\"><h3>The scene in three dimensions</h3>");
    sensor::add(&mut view, &day_results.scene, &day_results.simulation, "scene")?;
    view.raw("</div>");
    section.add(Block::Screen(view));
    Ok(section)
}

pub fn comparison(day_results: &DayResults) -> Option<Section> {
    let comparison = day_results.comparison.as_ref()?;
    let mut section = Section::new(&format!(
        "The test: simulated against measured, on the axis at {:.0} mm",
        comparison.distance_mm
    ));
    let row = |what: &str, stated: &Stated, lx: &Stated| {
        vec![what.to_owned(), stated.text("W/m²"), lx.text("lx"), String::new()]
    };
    let mut rows = vec![row(
        "measured, spectroradiometer",
        &comparison.measured_w_m2,
        &comparison.measured_lx,
    )];
    let mut simulated = row("simulated", &comparison.simulated_w_m2, &comparison.simulated_lx);
    simulated[3] = comparison.gap_text();
    rows.push(simulated);
    section.table(&["", "irradiance", "illuminance", "gap"], rows);
    if let Some(causes) = comparison.causes() {
        section.paragraph(causes);
    }
    section.paragraph(
        "The distribution comes from the lux meter far away, the spectrum from another instrument close by; nothing was fitted between \
         them. A gap in σ is in standard uncertainties (k = 1) of the difference: of the measurement, and of \
         what the model knows of itself, such as where in the luminous area the light leaves. One distance cannot tell \
         that from an axial offset of the light centre or an error of the short distance: a second short distance \
         would.",
    );
    Some(section)
}

pub fn diagnosis(day_results: &DayResults) -> Option<Section> {
    if let Some(why) = &day_results.undiagnosed {
        let mut section = Section::new("Diagnosis");
        section.add(Block::Verdict(capitalised(why), false));
        return Some(section);
    }
    let Diagnosed {
        plain,
        good,
        details,
        same_record,
    } = day_results.diagnosis.as_ref()?;
    let mut section;
    if *same_record {
        section = Section::new("Consistency check of the record");
        section.paragraph(capitalised(SAME_RECORD));
        if day_results.comparison.is_some() {
            section.paragraph("The test of this day is the comparison on the axis, above.");
        }
    } else {
        section = Section::new("Diagnosis");
    }
    section.add(Block::Verdict(plain.clone(), *good));
    if !details.is_empty() {
        section.add(Block::Details("Statistics".to_owned(), details.clone()));
    }
    section.add(Block::Files(vec![(
        "diagnosis/report.html".to_owned(),
        "the whole of it, with its pictures".to_owned(),
    )]));
    Some(section)
}

/// Names of effects in words.
fn list(names: &[Cow<'_, str>]) -> String {
    if names.is_empty() {
        "none".to_owned()
    } else {
        names.join(", ").replace('_', " ")
    }
}
