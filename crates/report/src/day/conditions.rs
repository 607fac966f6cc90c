//! Under which conditions it was measured: limits, stabilisation, temperature, supply, distance, scan, drift, closing
//! check, instruments.

use crate::axes::{Frame, Scale};
use crate::document::Section;
use crate::svg::{Anchor, HEIGHT, Stroke, Svg, WIDTH, colour};
use isolux_photometry::IntensityDistribution;
use isolux_record::event::{self, WarmUp};
use isolux_record::{DistanceClass, Event, Logged, ReadingKind, Role};
use isolux_reduce::{Drift, Over};
use isolux_units::digits::significant;

use super::results::DayResults;
use super::words::angle;

/// (max − min)/mean over the window within which EN 13032-4 and CIE S 025 call a lamp stable.
const STABLE_REL: f64 = 0.005;

pub fn section(day_results: &DayResults) -> Section {
    let mut section = Section::new("Conditions");
    let events = event::read(&day_results.run.path);
    section.facts(facts(day_results, &events));
    super::conformity::conditions(&mut section, day_results);
    section.subheading("Electrical");
    electrical(&mut section, day_results);
    section.subheading("Stability");
    let drift = (
        reference(day_results),
        "Visits to the reference point (C 0°, γ 0°) relative to their mean; bars: standard uncertainty (k = 1).",
    );
    match warm_up(&events) {
        Some(warm_up) => section.figures([
            (warm_up, "Warm-up: illuminance relative to its last reading; band: ± 0.5 %, within which a lamp counts as stable."),
            drift,
        ]),
        None => section.figures([drift]),
    }
    section.paragraph(drift_words(&day_results.reduction.drift));
    if let Some(closing) = &day_results.reduction.closing {
        section.paragraph(format!(
            "Closing check, half-plane C 360° against C 0°: rms difference {} cd over {} directions, largest {} cd at γ {}; mean square \
             {} of what noise and rounding allow.",
            significant(closing.rms_cd, 2),
            closing.directions,
            significant(closing.max_cd, 2),
            angle(closing.max_gamma_deg),
            significant(closing.chi2_per_direction, 2)
        ));
    }
    for note in &day_results.reduction.notes {
        section.paragraph(note.clone());
    }
    section.subheading("Instruments");
    instruments(&mut section, day_results);
    checks(&mut section, day_results);
    section
}

fn facts(day_results: &DayResults, events: &[Logged]) -> Vec<(String, String)> {
    let header = &day_results.run.header;
    let reduction = &day_results.reduction;
    let mut facts = Vec::new();
    let mut add = |name: &str, value: String| facts.push((name.to_owned(), value));
    if let Some(position) = &header.luminaire.burning_position {
        add("burning position", position.clone());
    }
    let temperatures = day_results.run.readings.rows.iter().filter_map(|row| row.ambient_c);
    add("ambient temperature", over(temperatures, "°C", 1));
    let stable = events.iter().rev().find_map(|logged| match logged.event {
        Event::Stable { lamp_s, spread_rel, .. } => Some((lamp_s, spread_rel)),
        _ => None,
    });
    add(
        "stabilisation",
        match stable {
            Some((lamp_s, spread)) => format!(
                "{:.0} min; spread (max − min)/mean {:.2} % over the last {:.0} min, allowed {} %",
                lamp_s / 60.0,
                100.0 * spread,
                window_min(day_results),
                allowed_percent(day_results)
            ),
            None => "not recorded".to_owned(),
        },
    );
    add("photometric distance", format!("{} m", reduction.distance_mm * 1e-3));
    add("distance class", distance_class(day_results));
    let shown = &reduction.grid.distribution;
    add("half-planes C", range(shown.c_deg()));
    add("angles γ", range(shown.gamma_deg()));
    let (used, all) = reduction.readings;
    add("readings", format!("{used} of {all} make the distribution"));
    let block = header.plan.blocks().iter().find(|block| block.kind == ReadingKind::Lit);
    if let Some(block) = block {
        add("block of the plan", block.name.clone());
    }
    facts
}

/// Mean, smallest and largest of a quantity over the run.
fn over(values: impl Iterator<Item = f64>, unit: &str, places: usize) -> String {
    let values: Vec<f64> = values.collect();
    if values.is_empty() {
        return "not measured".to_owned();
    }
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    format!("mean {mean:.places$} {unit}, from {least:.places$} {unit} to {most:.places$} {unit}")
}

fn range(degrees: &[f64]) -> String {
    let (Some(first), Some(last)) = (degrees.first(), degrees.last()) else {
        return "none".to_owned();
    };
    let steps: Vec<f64> = degrees.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let even = steps.windows(2).all(|pair| (pair[1] - pair[0]).abs() < 1e-6);
    match steps.first() {
        Some(step) if even => format!("{} to {} in steps of {}", angle(*first), angle(*last), angle(*step)),
        Some(_) => format!(
            "{} to {}, {} of them, unevenly spaced",
            angle(*first),
            angle(*last),
            degrees.len()
        ),
        None => angle(*first),
    }
}

fn window_min(day_results: &DayResults) -> f64 {
    let lamp = day_results.run.header.station.lamp();
    lamp.and_then(|lamp| lamp.stable.as_ref())
        .map_or(15.0, |stable| stable.window_s / 60.0)
}

fn allowed_percent(day_results: &DayResults) -> String {
    let lamp = day_results.run.header.station.lamp();
    let rel = lamp
        .and_then(|lamp| lamp.stable.as_ref())
        .map_or(STABLE_REL, |stable| stable.spread_rel);
    significant(100.0 * rel, 2)
}

/// Distance in luminous diameters against what CIE S 025, 4.5.2 asks of a distribution of this width: 5 for a
/// cosine-like one (beam angle of at least 90°), 10 for a broad one (60°), 15 for a narrower one.
fn distance_class(day_results: &DayResults) -> String {
    let lamp = day_results.run.header.station.lamp();
    let Some(diameter_mm) = lamp.and_then(|lamp| lamp.diameter_mm) else {
        return "not known: the station states no lamp.diameter_mm".to_owned();
    };
    let reduction = &day_results.reduction;
    let class = DistanceClass::of(reduction.distance_mm, Some(diameter_mm));
    let ratio = class.ratio().unwrap_or_default();
    let narrowest = narrowest_beam_deg(&reduction.grid.distribution);
    let wanted = DistanceClass::wanted(narrowest);
    let beam = narrowest.map_or_else(|| "no beam".to_owned(), |beam| format!("narrowest beam {beam:.0}°"));
    format!(
        "{ratio:.0} luminous diameters of {diameter_mm} mm; {beam}, for which CIE S 025 asks for {wanted}: {}",
        if ratio >= wanted {
            "kept"
        } else {
            "not kept, the readings are apparent intensities"
        }
    )
}

fn narrowest_beam_deg(shown: &IntensityDistribution) -> Option<f64> {
    (0..shown.c_deg().len())
        .filter_map(|plane| shown.beam_angle(plane))
        .map(|beam| beam.full_angle_deg())
        .min_by(f64::total_cmp)
}

/// The supply line over the readings of the distribution, where there was a power meter.
fn electrical(section: &mut Section, day_results: &DayResults) {
    let Some(line) = &day_results.reduction.electrical else {
        section.paragraph("Voltage, current, power and efficacy: not measured, the bench has no power meter.");
        return;
    };
    let row = |name: &str, over: Option<Over>, unit: &str, digits: i32| {
        let over = over?;
        let shown = [over.mean, over.least, over.most].map(|value| format!("{}{unit}", significant(value, digits)));
        Some(std::iter::once(name.to_owned()).chain(shown).collect::<Vec<_>>())
    };
    let rows: Vec<Vec<String>> = [
        row("voltage", line.voltage_v, " V", 5),
        row("current", line.current_a, " A", 4),
        row("active power", Some(line.power_w), " W", 5),
        row("power factor", line.power_factor, "", 3),
    ]
    .into_iter()
    .flatten()
    .collect();
    section.numbers(
        ["over the distribution", "mean", "smallest", "largest"]
            .map(str::to_owned)
            .to_vec(),
        rows,
    );
    section.paragraph(format!(
        "Active power {} over {} readings. Luminous efficacy, luminous flux ÷ mean active power: {}.",
        line.power.stated(),
        line.readings,
        line.luminous_efficacy.stated()
    ));
}

fn drift_words(drift: &Drift) -> String {
    match drift {
        Drift::Unknown { u_rel } => format!(
            "Drift: fewer than two visits to the reference, or not corrected; a stable lamp may change by a standard uncertainty of {} %.",
            significant(100.0 * u_rel, 2)
        ),
        Drift::None { u_rel, .. } => format!(
            "Drift: none beyond the uncertainty of the visits; standard uncertainty left {} %.",
            significant(100.0 * u_rel, 2)
        ),
        Drift::Linear {
            rate_per_h,
            u_rate_per_h,
            ..
        } => format!(
            "Drift: a straight line was taken out, {} % an hour.",
            isolux_units::digits::stated(100.0 * rate_per_h, 100.0 * u_rate_per_h, "").replace("  (k", " (k")
        ),
        Drift::Interpolated { lamp_s, u_rel, .. } => format!(
            "Drift: taken out by lines between {} visits; standard uncertainty left {} %.",
            lamp_s.len(),
            significant(100.0 * u_rel, 2)
        ),
        Drift::ByBurning { burning, u_rel } => format!(
            "Drift: taken out in each of {} burnings by its own visits; standard uncertainty left {} %.",
            burning.len(),
            significant(100.0 * u_rel, 2)
        ),
    }
}

fn instruments(section: &mut Section, day_results: &DayResults) {
    let header = &day_results.run.header;
    let measured_on = header.started_utc.get(..10).unwrap_or_default();
    let rows = header.device.iter().map(|device| {
        // What is not calibrated (a lamp, a shutter) has empty cells.
        let [certificate, calibrated, due] = match header.station.traceability(&device.role) {
            Some(known) => {
                let due = known.due.map(|due| {
                    let late = if known.overdue(measured_on) {
                        ", before the measurement"
                    } else {
                        ""
                    };
                    format!("{due}{late}")
                });
                [
                    known.certificate.map(str::to_owned),
                    known.calibrated.map(str::to_owned),
                    due,
                ]
                .map(|cell| cell.unwrap_or_else(|| "–".to_owned()))
            }
            None => Default::default(),
        };
        let serial = device.serial.clone().unwrap_or_else(|| "not known".to_owned());
        vec![
            device.role.clone(),
            device.model.clone(),
            serial,
            certificate,
            calibrated,
            due,
        ]
    });
    section.table(
        &[
            "instrument",
            "model",
            "serial number",
            "certificate",
            "calibrated",
            "due",
        ],
        rows.collect(),
    );
    section.paragraph("–: not stated by the station; empty: not calibrated.");
    if let Some(spectral) = &header.spectral {
        section.paragraph(format!(
            "Spectral calibration: {}, SHA-256 {}….",
            spectral.file,
            spectral.sha256.get(..8).unwrap_or_default()
        ));
    }
}

/// What the history of the bench said when the run began.
fn checks(section: &mut Section, day_results: &DayResults) {
    let checks = &day_results.run.header.bench_check;
    if checks.is_empty() {
        section.paragraph("History of the bench: no calibration and no check was in it when the run began.");
        return;
    }
    section.subheading("History of the bench before this run");
    let rows = checks.iter().map(|check| {
        let day = check.time_utc.get(..10).unwrap_or(&check.time_utc);
        let words = check.sentence.strip_prefix(&format!("{}: ", check.quantity));
        [&check.quantity, day, words.unwrap_or(&check.sentence)]
            .map(str::to_owned)
            .to_vec()
    });
    section.table(&["quantity", "last on", "control chart"], rows.collect());
}

/// Illuminance during the last warm-up; none where the run began with a warm lamp.
fn warm_up(events: &[Logged]) -> Option<String> {
    let from = events
        .iter()
        .rposition(|logged| logged.event == Event::Lamp { on: true })
        .unwrap_or(0);
    let looks: Vec<(f64, f64)> = events[from..]
        .iter()
        .filter_map(|logged| match logged.event {
            Event::WarmUp(WarmUp {
                lamp_s, illuminance_lx, ..
            }) => Some((lamp_s / 60.0, illuminance_lx)),
            _ => None,
        })
        .collect();
    let last = looks.last()?.1;
    if looks.len() < 2 || last <= 0.0 {
        return None;
    }
    let relative = |lx: f64| 100.0 * (lx / last - 1.0);
    let mut svg = Svg::figure("illuminance during warm-up");
    let band = 100.0 * STABLE_REL;
    let values = looks
        .iter()
        .map(|look| relative(look.1))
        .chain([-1.5 * band, 1.5 * band]);
    let frame = Frame::of_figure(
        Scale::around(looks.iter().map(|look| look.0), true),
        Scale::around(values, true),
    );
    let end = looks.last()?.0;
    svg.polygon(
        [(0.0, band), (end, band), (end, -band), (0.0, -band)].map(|(x, y)| frame.at(x, y)),
        colour::GOOD,
        0.14,
    );
    frame.draw(&mut svg, "time since the lamp was switched on in min", "change in %");
    svg.polyline(
        looks.iter().map(|look| frame.at(look.0, relative(look.1))),
        Stroke::solid(colour::DATA, 1.6),
    );
    Some(svg.finish())
}

/// Reference readings over time with their digit.
fn reference(day_results: &DayResults) -> String {
    let rows = day_results.run.readings.rows.iter();
    let mut visits: Vec<(f64, f64, f64)> = rows
        .filter(|row| row.role == Role::Reference)
        .filter_map(|row| Some((row.time_s? / 60.0, row.illuminance_lx?, row.u_lx?)))
        .collect();
    // In whatever order the rows are.
    visits.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.total_cmp(&b.2)));
    let mean = visits.iter().map(|visit| visit.1).sum::<f64>() / visits.len().max(1) as f64;
    let relative = |lx: f64| 100.0 * (lx / mean - 1.0);
    let mut svg = Svg::figure("reference readings over time");
    let values = visits
        .iter()
        .flat_map(|v| [relative(v.1 + 2.0 * v.2), relative(v.1 - 2.0 * v.2)]);
    let frame = Frame::of_figure(
        Scale::around(visits.iter().map(|visit| visit.0), false),
        Scale::around(values, true),
    );
    frame.draw(&mut svg, "time since the run began in min", "change in %");
    for &(minute, lx, u) in &visits {
        svg.line(
            frame.at(minute, relative(lx - u)),
            frame.at(minute, relative(lx + u)),
            Stroke::solid(colour::DATA, 1.0),
        );
        svg.circle(frame.at(minute, relative(lx)), 2.5, colour::DATA, None);
    }
    if visits.is_empty() {
        svg.text(
            (0.5 * WIDTH, 0.4 * HEIGHT),
            Anchor::Middle,
            colour::MUTED,
            "the plan had no visits",
        );
    }
    svg.finish()
}
