//! The page and the pictures of a diagnosis.

use std::collections::BTreeMap;

use isolux_diagnose::diagnosis::{Diagnosis, digits};
use isolux_diagnose::document::{Independence, Verdict};
use isolux_diagnose::table::{Coordinate, Light, Row, Source};

use crate::answer::{SAME_RECORD, reached_by_chance, with_uncertainty};
use crate::axes::number;
use crate::diagnosis::{Panel, gap_bars, residual_maps, residuals_along};
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
    page.paragraph(&capitalised(&document.sentence));
    if same_record {
        page.paragraph(&capitalised(SAME_RECORD));
    }
    let gap = &document.gap;
    let noise = &document.noise;
    let tile = |name: &str, value: String, note: String| Tile {
        name: name.to_owned(),
        value,
        note,
    };
    let mut tiles = vec![
        tile(
            "gap before",
            format!("{:.3} σ rms", gap.before),
            format!("{:.3} as given", gap.as_given),
        ),
        tile(
            "gap after",
            format!("{:.3} σ rms", gap.after),
            format!("{:.3} expected of noise", gap.floor),
        ),
    ];
    if let Some(held) = &gap.held_out {
        let note = format!("{:.3} → {:.3} on {} readings", held.before, held.after, held.readings);
        tiles.push(tile(
            "removed, held out",
            format!("{:.1} %", 100.0 * held.removed),
            note,
        ));
    }
    if let Some(k) = reached_by_chance(noise) {
        tiles.push(tile(
            "disagreement",
            format!("{k} of {}", noise.n_null),
            "simulated noise-only scans reach it".to_owned(),
        ));
    }
    tiles.push(tile(
        "noise",
        format!("{:.3} × stated", noise.scale),
        format!("autocorrelation {:.2}", noise.autocorrelation),
    ));
    if let Some(test) = &noise.test {
        tiles.push(tile(
            "what is left is noise",
            format!("p = {:.3}", test.p_value),
            format!("scatter {:.2} × stated", test.scatter),
        ));
    }
    page.tiles(&tiles);

    page.heading("Where");
    let (panels, x, y) = panels(found);
    if !panels.is_empty() {
        let svg = residual_maps(&panels, x, y);
        page.figure(
            &svg,
            "Residuals before and after, (measured − predicted)/(s·u), on one fixed scale.",
        );
        pictures.push(("residuals.svg", svg));
    }
    if let Some((coordinate, svg)) = along(found) {
        let caption = format!(
            "Residuals of the baseline along {}, with what was found.",
            coordinate.name()
        );
        page.figure(&svg, &caption);
        pictures.push(("coordinate.svg", svg));
    }
    let rows: Vec<Vec<String>> = document
        .places
        .iter()
        .map(|place| {
            let range = format!("{} … {}", digits(place.range[0], 4), digits(place.range[1], 4));
            vec![
                place.coordinate.to_owned(),
                range,
                format!("{:.1}", place.significance_sigma),
                place.note.clone(),
            ]
        })
        .collect();
    if !rows.is_empty() {
        page.table(&["along", "range", "σ", "pattern"], &rows);
    }

    for (effect, ranked) in document.effects.iter().zip(&document.ranked) {
        page.heading(&format!("{} — {}", effect.name, effect.standard_name));
        let rows: Vec<Vec<String>> = ranked
            .iter()
            .map(|row| {
                let name = match row.name.strip_prefix("unnamed:") {
                    Some(coordinate) => format!("no name, along {coordinate}"),
                    None => row.name.clone(),
                };
                vec![
                    name,
                    format!("{:.1} %", 100.0 * row.posterior),
                    format!("{:.1}", row.significance_sigma),
                ]
            })
            .collect();
        page.table(&["who", "probability", "σ"], &rows);
        let rows: Vec<Vec<String>> = effect
            .parameters
            .iter()
            .map(|(key, parameter)| {
                let plausible = format!("{} … {}", parameter.plausible[0], parameter.plausible[1]);
                let flag = if parameter.implausible { "outside" } else { "" };
                let before = parameter.before.map_or_else(String::new, |before| digits(before, 4));
                vec![
                    (*key).to_owned(),
                    with_uncertainty(parameter),
                    before,
                    plausible,
                    flag.to_owned(),
                ]
            })
            .collect();
        page.table(
            &["parameter", "value ± U (k = 2)", "in the model", "plausible", ""],
            &rows,
        );
    }
    if let Some(unexplained) = &document.unexplained {
        page.heading("Without a name");
        page.paragraph(&format!(
            "{}, along {} between {} and {}: {:.1} σ, {:.0} % of the squared gap.",
            unexplained.note,
            unexplained.coordinate,
            digits(unexplained.range[0], 4),
            digits(unexplained.range[1], 4),
            unexplained.significance_sigma,
            100.0 * unexplained.share_of_gap
        ));
    }
    if let Some(test) = noise.test.as_ref().filter(|test| !test.findings.is_empty()) {
        let rows: Vec<Vec<String>> = test
            .findings
            .iter()
            .map(|finding| {
                let period = match (finding.period, finding.coordinate) {
                    (Some(period), "time_s") => format!("{} s", digits(period, 3)),
                    (Some(period), _) => format!("{} readings", digits(period, 3)),
                    (None, _) => String::new(),
                };
                vec![
                    finding.note.clone(),
                    finding.coordinate.to_owned(),
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

    page.heading("Gap");
    let mut bars = vec![("fitted readings", gap.before, gap.after, gap.floor)];
    if let Some(held) = &gap.held_out {
        bars.push(("held-out readings", held.before, held.after, held.floor));
    }
    let svg = gap_bars(&bars);
    page.figure(&svg, &gap.held_out_note);
    pictures.push(("gap.svg", svg));

    if !document.next_measurement.is_empty() {
        page.heading("Measure next");
        let rows: Vec<Vec<String>> = document
            .next_measurement
            .iter()
            .map(|next| {
                vec![
                    next.what.to_owned(),
                    format!("{} | {}", next.splits[0], next.splits[1]),
                    format!("{:.1} σ", next.expected_sigma),
                    format!("{:.0} min", next.minutes),
                    next.plan.clone().unwrap_or_default(),
                ]
            })
            .collect();
        page.table(&["do", "tells apart", "by", "takes", "plan"], &rows);
    }
    page.heading("Blind spots");
    let rows: Vec<Vec<String>> = document
        .blind_spots
        .iter()
        .map(|spot| {
            let amplitude = spot
                .amplitude_at_5_sigma
                .map_or_else(|| "never".to_owned(), |a| digits(a, 2));
            let flag = if spot.blind { "blind" } else { "" };
            vec![
                spot.effect.to_owned(),
                spot.parameter.to_owned(),
                amplitude,
                number(spot.plausible_max),
                flag.to_owned(),
            ]
        })
        .collect();
    page.table(
        &["effect", "parameter", "shows at 5 σ from", "plausible up to", ""],
        &rows,
    );
    if !diff.is_empty() {
        page.heading("Change of the model file");
        page.preformatted(&diff.join("\n"));
    }
    for note in &document.notes {
        page.paragraph(note);
    }
    Report {
        pictures,
        page: page.finish(),
    }
}

/// A sentence with its first letter large and its full stop.
pub fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters
        .next()
        .map_or_else(String::new, |first| first.to_uppercase().collect());
    format!("{first}{}.", letters.as_str())
}

/// Panels of half-planes (one a distance, rows in order of measurement) or of maps.
fn panels(found: &Diagnosis) -> (Vec<Panel>, &'static str, &'static str) {
    let rows = &found.rows;
    if rows.iter().any(|row| row.source == Source::Bin) {
        let mut groups: BTreeMap<(usize, usize), Vec<usize>> = BTreeMap::new();
        for (i, row) in rows.iter().enumerate().filter(|(_, row)| row.source == Source::Bin) {
            groups.entry((row.file, row.group)).or_default().push(i);
        }
        let panels = groups
            .values()
            .take(12)
            .map(|indices| {
                let row = &rows[indices[0]];
                let name = match row.light {
                    Light::Capped => "capped".to_owned(),
                    Light::LampOff => "lamp off".to_owned(),
                    _ => format!("{} mm, exposure {}", row.distance_mm, row.exposure),
                };
                panel(name, found, indices, |row| row.x_mm, |row| row.y_mm)
            })
            .collect();
        return (panels, "x in mm", "y in mm (as the lamp sees the sensor)");
    }
    let mut distances: Vec<f64> = rows
        .iter()
        .map(|row| row.distance_mm)
        .filter(|d| d.is_finite())
        .collect();
    distances.sort_by(f64::total_cmp);
    distances.dedup();
    let panels = distances
        .iter()
        .filter_map(|&distance| {
            let pick: Vec<usize> = (0..rows.len())
                .filter(|&i| rows[i].distance_mm == distance && rows[i].light == Light::Lit && rows[i].travel != 0.0)
                .collect();
            (pick.len() > 4).then(|| {
                panel(
                    format!("{distance} mm"),
                    found,
                    &pick,
                    |row| row.gamma_deg,
                    |row| row.c_deg,
                )
            })
        })
        .collect();
    (panels, "signed γ in degrees", "C in degrees")
}

fn panel(name: String, found: &Diagnosis, indices: &[usize], x: fn(&Row) -> f64, y: fn(&Row) -> f64) -> Panel {
    let places = |f: fn(&Row) -> f64| {
        let mut values: Vec<f64> = indices.iter().map(|&i| f(&found.rows[i])).collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        values
    };
    let (xs, ys) = (places(x), places(y));
    let mut before = vec![f64::NAN; xs.len() * ys.len()];
    let mut after = before.clone();
    for &i in indices {
        let row = &found.rows[i];
        let column = xs.partition_point(|value| *value < x(row));
        let line = ys.partition_point(|value| *value < y(row));
        before[line * xs.len() + column] = found.before[i];
        after[line * xs.len() + column] = found.left[i];
    }
    Panel {
        name,
        columns: xs.len(),
        rows: ys.len(),
        before,
        after,
        x: xs,
        y: ys,
    }
}

/// Residuals against the coordinate of the strongest pattern.
fn along(found: &Diagnosis) -> Option<(Coordinate, String)> {
    const ALL: [Coordinate; 16] = [
        Coordinate::TimeS,
        Coordinate::GammaDeg,
        Coordinate::CDeg,
        Coordinate::DistanceMm,
        Coordinate::Travel,
        Coordinate::Range,
        Coordinate::AmbientC,
        Coordinate::Level,
        Coordinate::XMm,
        Coordinate::YMm,
        Coordinate::RadiusMm,
        Coordinate::IncidenceDeg,
        Coordinate::Exposure,
        Coordinate::WavelengthNm,
        Coordinate::Index,
        Coordinate::Noise,
    ];
    let document = &found.document;
    let wanted = document
        .unexplained
        .as_ref()
        .map(|unexplained| unexplained.coordinate)
        .or_else(|| document.places.first().map(|place| place.coordinate))?;
    let coordinate = ALL.into_iter().find(|coordinate| coordinate.name() == wanted)?;
    let place = |i: usize| found.rows[i].coordinate(coordinate, found.level[i]);
    let pick: Vec<usize> = (0..found.rows.len()).filter(|&i| place(i).is_finite()).collect();
    let points: Vec<(f64, f64)> = pick.iter().map(|&i| (place(i), found.before[i])).collect();
    let fit: Vec<(f64, f64)> = pick.iter().map(|&i| (place(i), found.explained[i])).collect();
    (!points.is_empty()).then(|| (coordinate, residuals_along(wanted, &points, &fit)))
}
