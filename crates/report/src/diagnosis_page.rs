//! The page and the pictures of a diagnosis: what was found in plain sentences, its values, the gap before and after;
//! the statistics behind it are folded.

mod panels;

use isolux_diagnose::diagnosis::{Diagnosis, along_words, digits};
use isolux_diagnose::document::{Document, EffectEntry, Independence, NoiseEntry, RankedEntry, Verdict};
use isolux_model::effects;

use crate::answer::{SAME_RECORD, effect_words, key_words, reached_by_chance, with_uncertainty};
use crate::axes::number;
use crate::diagnosis::{gap_bars, residual_maps};
use crate::html::{Page, Tile};

/// The pictures and the page that holds them all.
pub struct Report {
    /// File name and SVG of each.
    pub pictures: Vec<(&'static str, String)>,
    /// HTML.
    pub page: String,
}

/// Pictures and page of a diagnosis, with the change of the model file in lines.
pub fn report(found: &Diagnosis, diff: &[String]) -> Report {
    let document = &found.document;
    let mut pictures = Vec::new();
    let same_record = document.independence == Independence::SameRun;
    let mut page = Page::new(if same_record {
        "Consistency check of the record"
    } else {
        "Diagnosis"
    });
    let good = matches!(document.verdict, Verdict::Consistent | Verdict::Named);
    page.verdict(&document.plain, good);
    if same_record {
        page.paragraph(&capitalised(SAME_RECORD));
    }
    for effect in &document.effects {
        values(&mut page, effect);
    }
    unexplained(&mut page, document);
    gap(&mut page, document, &mut pictures);
    residuals(&mut page, found, &mut pictures);
    next(&mut page, document);
    page.open_fold("Statistics");
    page.paragraph(&capitalised(&document.sentence));
    page.tiles(&tiles(document));
    places(&mut page, document);
    for (effect, ranked) in document.effects.iter().zip(&document.ranked) {
        alternatives(&mut page, effect, ranked);
    }
    noise(&mut page, &document.noise);
    blind_spots(&mut page, document);
    page.close_fold();
    if !diff.is_empty() {
        page.details("Change of the model file", &diff.join("\n"));
    }
    for note in &document.notes {
        page.paragraph(note);
    }
    Report {
        pictures,
        page: page.finish(),
    }
}

/// What was fitted of an effect.
fn values(page: &mut Page, effect: &EffectEntry) {
    page.heading(&capitalised(&effect.standard_name).replace('.', ""));
    let rows: Vec<Vec<String>> = effect
        .parameters
        .iter()
        .map(|(key, parameter)| {
            let plausible = format!("{} … {}", parameter.plausible[0], parameter.plausible[1]);
            let flag = if parameter.implausible { "outside" } else { "" };
            let before = parameter.before.map_or_else(String::new, |before| digits(before, 4));
            vec![
                key_words(key),
                with_uncertainty(parameter),
                before,
                plausible,
                flag.to_owned(),
                format!("{}: {key}", effect.name),
            ]
        })
        .collect();
    page.table(
        &[
            "",
            "value ± U (k = 2)",
            "in the model",
            "plausible",
            "",
            "key of the model file",
        ],
        &rows,
    );
}

fn unexplained(page: &mut Page, document: &Document) {
    let Some(unexplained) = &document.unexplained else {
        return;
    };
    page.heading("Without a name");
    page.paragraph(&format!(
        "{}, along {} between {} and {}: {:.1} σ, {:.0} % of the squared gap.",
        unexplained.note,
        along_words(&unexplained.coordinate),
        digits(unexplained.range[0], 4),
        digits(unexplained.range[1], 4),
        unexplained.significance_sigma,
        100.0 * unexplained.share_of_gap
    ));
}

fn gap(page: &mut Page, document: &Document, pictures: &mut Vec<(&'static str, String)>) {
    let gap = &document.gap;
    page.heading("Gap between model and measurement");
    let mut bars = vec![(
        "fitted readings, as given and after",
        gap.as_given,
        gap.after,
        gap.floor,
    )];
    if let Some(held) = &gap.held_out {
        bars.push(("held-out readings", held.before, held.after, held.floor));
    }
    let svg = gap_bars(&bars);
    page.figure(&svg, &gap.held_out_note);
    pictures.push(("gap.svg", svg));
}

fn residuals(page: &mut Page, found: &Diagnosis, pictures: &mut Vec<(&'static str, String)>) {
    const GIVEN: &str = "Residuals of the model as given, (measured − predicted)/(s·u).";
    page.heading("Where");
    if let Some((coordinate, svg)) = panels::along(found) {
        let caption = format!(
            "Residuals of the model as given along {}, with what was found.",
            along_words(coordinate.name())
        );
        page.figure(&svg, &caption);
        pictures.push(("coordinate.svg", svg));
    }
    let (panels, x, y) = panels::panels(found);
    if !panels.is_empty() {
        let [before, after] = residual_maps(&panels, x, y);
        page.pair((&before, GIVEN), (&after, "Residuals after, on the same scale."));
        pictures.push(("residuals_before.svg", before));
        pictures.push(("residuals_after.svg", after));
    }
    if let Some([before, after]) = panels::of_spectra(found) {
        page.pair((&before, GIVEN), (&after, "Residuals after."));
        pictures.push(("spectra_before.svg", before));
        pictures.push(("spectra_after.svg", after));
    }
}

fn next(page: &mut Page, document: &Document) {
    if document.next_measurement.is_empty() {
        return;
    }
    page.heading("Measure next");
    let rows: Vec<Vec<String>> = document
        .next_measurement
        .iter()
        .map(|next| {
            vec![
                next.what.replace('_', " "),
                format!("{} | {}", effect_words(&next.splits[0]), effect_words(&next.splits[1])),
                format!("{:.1} σ", next.expected_sigma),
                format!("{:.0} min", next.minutes),
                next.plan.clone().unwrap_or_default(),
            ]
        })
        .collect();
    page.table(&["do", "tells apart", "by", "takes", "plan"], &rows);
}

fn tiles(document: &Document) -> Vec<Tile> {
    let (gap, noise) = (&document.gap, &document.noise);
    let tile = |name: &str, value: String, note: String| Tile {
        name: name.to_owned(),
        value,
        note,
    };
    let mut tiles = vec![
        tile(
            "gap as given",
            format!("{:.3} σ rms", gap.as_given),
            format!("{:.3} within what the model knows of itself", gap.before),
        ),
        tile(
            "gap after",
            format!("{:.3} σ rms", gap.after),
            format!("{:.3} expected of noise", gap.floor),
        ),
    ];
    tiles.extend(gap.held_out.as_ref().map(|held| {
        tile(
            "removed, held out",
            format!("{:.1} %", 100.0 * held.removed),
            format!("{:.3} → {:.3} on {} readings", held.before, held.after, held.readings),
        )
    }));
    tiles.extend(reached_by_chance(noise).map(|k| {
        tile(
            "disagreement",
            format!("{k} of {}", noise.n_null),
            "simulated noise-only scans reach it".to_owned(),
        )
    }));
    tiles.push(tile(
        "noise",
        format!("{:.3} × stated", noise.scale),
        format!("autocorrelation {:.2}", noise.autocorrelation),
    ));
    tiles.extend(noise.test.as_ref().map(|test| {
        tile(
            "what is left is noise",
            format!("p = {:.3}", test.p_value),
            format!("scatter {:.2} × stated", test.scatter),
        )
    }));
    tiles
}

fn places(page: &mut Page, document: &Document) {
    let rows: Vec<Vec<String>> = document
        .places
        .iter()
        .map(|place| {
            vec![
                along_words(&place.coordinate).to_owned(),
                format!("{} … {}", digits(place.range[0], 4), digits(place.range[1], 4)),
                format!("{:.1}", place.significance_sigma),
                place.note.clone(),
            ]
        })
        .collect();
    if !rows.is_empty() {
        page.table(&["along", "range", "σ", "pattern"], &rows);
    }
}

/// What else could be behind a pattern.
fn alternatives(page: &mut Page, effect: &EffectEntry, ranked: &[RankedEntry]) {
    page.paragraph(&format!("What could be taken for {}:", effect.standard_name));
    let rows: Vec<Vec<String>> = ranked
        .iter()
        .map(|row| {
            vec![
                effect_words(&row.name),
                format!("{:.1} %", 100.0 * row.posterior),
                format!("{:.1}", row.significance_sigma),
            ]
        })
        .collect();
    page.table(&["cause", "probability", "σ"], &rows);
}

fn noise(page: &mut Page, noise: &NoiseEntry) {
    let Some(test) = noise.test.as_ref().filter(|test| !test.findings.is_empty()) else {
        return;
    };
    let rows: Vec<Vec<String>> = test
        .findings
        .iter()
        .map(|finding| {
            let period = match (finding.period, finding.coordinate.as_ref()) {
                (Some(period), "time_s") => format!("{} s", digits(period, 3)),
                (Some(period), _) => format!("{} readings", digits(period, 3)),
                (None, _) => String::new(),
            };
            vec![
                finding.note.clone(),
                along_words(&finding.coordinate).to_owned(),
                format!("{} … {}", digits(finding.range[0], 4), digits(finding.range[1], 4)),
                period,
                format!("{:.1e}", finding.p_value),
            ]
        })
        .collect();
    page.table(
        &["what is no noise", "along", "range", "period", "p of this test"],
        &rows,
    );
}

fn blind_spots(page: &mut Page, document: &Document) {
    page.paragraph("What these data could show of each effect, and what they could not:");
    let rows: Vec<Vec<String>> = document
        .blind_spots
        .iter()
        .map(|spot| {
            let amplitude = spot
                .amplitude_at_5_sigma
                .map_or_else(|| "never".to_owned(), |a| digits(a, 2));
            vec![
                effect_words(&spot.effect),
                key_words(&spot.parameter),
                amplitude,
                number(spot.plausible_max),
                unit(&spot.effect, &spot.parameter),
                if spot.blind { "blind" } else { "" }.to_owned(),
            ]
        })
        .collect();
    page.table(
        &["effect", "", "shows at 5 σ from", "plausible up to", "unit", ""],
        &rows,
    );
}

fn unit(effect: &str, key: &str) -> String {
    let spec = effects::by_name(effect);
    let found = spec.and_then(|spec| spec.parameters.iter().find(|parameter| parameter.key == key));
    found.map_or_else(String::new, |parameter| parameter.unit.to_owned())
}

/// A sentence with its first letter large and its full stop.
pub fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters
        .next()
        .map_or_else(String::new, |first| first.to_uppercase().collect());
    format!("{first}{}.", letters.as_str())
}
