//! The report of a day: one HTML file with its pictures.

use std::collections::BTreeSet;

use isolux_record::Role;
use isolux_reduce::{Over, Quantity};
use isolux_report::axes::{Frame, Scale};
use isolux_report::html::{Page, Tile};
use isolux_report::plots::{PolarOptions, SpectrumOptions, cartesian, polar, spectrum};
use isolux_report::svg::{Anchor, Stroke, Svg, colour};

use super::compare::gap_words;
use super::{Diagnosed, Evening};
use crate::diagnose::SAME_RECORD;
use crate::diagnosis_report::capitalised;
use crate::reduce::{no_uncertainty, value_only, with_u};
use crate::{Failure, sensor_view, simulate};

/// The page.
///
/// # Errors
/// When the scene cannot be written.
pub(super) fn page(evening: &Evening) -> Result<String, Failure> {
    let header = &evening.reduced.run.header;
    let name = header
        .station
        .document()
        .name
        .clone()
        .or_else(|| header.plan.document().name.clone());
    let mut page = Page::new(&name.unwrap_or_else(|| "Day at the goniophotometer".to_owned()));
    page.paragraph(&format!(
        "{}, {}; standard uncertainties, k = 1",
        header.started_utc, header.program
    ));
    if let Some(comparison) = &evening.comparison {
        let (sentence, good) = comparison.verdict();
        page.verdict(&sentence, good);
    }
    if let Some(accepted) = &evening.reduced.reduction.accepted {
        page.verdict(&isolux_reduce::note(accepted), false);
    }
    page.tiles(&tiles(evening));
    distribution(&mut page, evening);
    electrical(&mut page, evening);
    light(&mut page, evening);
    sensor(&mut page, evening);
    page.heading("The scene in three dimensions");
    sensor_view::add(&mut page, &evening.scene, &evening.simulation, "scene")?;
    comparison(&mut page, evening);
    diagnosis(&mut page, evening);
    record(&mut page, evening);
    results(&mut page, evening);
    Ok(page.finish())
}

fn tiles(evening: &Evening) -> Vec<Tile> {
    let reduction = &evening.reduced.reduction;
    let of = |name: &str, quantity: &Quantity| {
        let with_u = with_u(quantity);
        Tile {
            name: name.to_owned(),
            value: format!("{} {}", value_only(quantity), quantity.unit),
            note: match quantity.u {
                Some(_) => with_u
                    .split_once(" ± ")
                    .map_or_else(String::new, |(_, u)| format!("± {u}")),
                None => no_uncertainty(&quantity.missing),
            },
        }
    };
    let plain = |name: &str, value: String, note: &str| Tile {
        name: name.to_owned(),
        value,
        note: note.to_owned(),
    };
    let mut tiles = vec![
        of("luminous flux", &reduction.flux),
        of("maximum intensity", &reduction.i_max),
    ];
    if let Some(line) = &reduction.electrical {
        tiles.push(of("luminous efficacy", &line.luminous_efficacy));
    }
    if let Some(beam) = reduction.grid.distribution.beam_angle(0) {
        tiles.push(plain(
            "beam angle, C0",
            format!("{:.1}°", beam.full_angle_deg()),
            "half-peak divergence",
        ));
    }
    if let Some(spectral) = &reduction.spectral {
        tiles.extend(spectral.cct.as_ref().map(|cct| of("colour temperature", cct)));
        tiles.push(of("efficacy of radiation", &spectral.ler));
    }
    if let Some(colour) = &evening.colour {
        tiles.extend(
            colour
                .duv
                .map(|duv| plain("Duv", format!("{duv:+.4}"), "from the Planckian locus")),
        );
        tiles.extend(colour.ra.map(|ra| plain("Ra", format!("{ra:.1}"), "CIE 13.3")));
        tiles.extend(
            colour
                .rf
                .zip(colour.rg)
                .map(|(rf, rg)| plain("Rf, Rg", format!("{rf:.1}, {rg:.1}"), "TM-30")),
        );
    }
    let facts = &evening.simulation.facts;
    let unit = unit(facts.unit);
    let u = facts.u_mean.map_or_else(
        || no_uncertainty(&facts.u_mean_missing),
        |u| format!("± {u:.3} {unit} (k = 1)"),
    );
    tiles.push(plain("mean on the sensor", format!("{:.3} {unit}", facts.mean), &u));
    tiles
}

fn distribution(page: &mut Page, evening: &Evening) {
    let reduction = &evening.reduced.reduction;
    let options = PolarOptions {
        title: String::new(),
        per_lamp_flux_lm: Some(reduction.flux.value),
    };
    page.heading("Luminous intensity distribution");
    page.pair(
        (
            &polar(&reduction.grid.distribution, &options),
            &format!("C0–C180 solid red, C90–C270 dashed blue, cd/klm. {}", below(evening)),
        ),
        (&cartesian(&reduction.grid.distribution, &options), "The same over γ."),
    );
    budget(
        page,
        &[
            ("luminous flux", &reduction.flux),
            ("maximum intensity", &reduction.i_max),
        ],
    );
}

/// The supply line over the readings of the distribution, where there was a power meter.
fn electrical(page: &mut Page, evening: &Evening) {
    let Some(line) = &evening.reduced.reduction.electrical else {
        return;
    };
    page.heading("Electrical");
    let row = |name: &str, over: Option<Over>, unit: &str| {
        let over = over?;
        let shown = [over.mean, over.least, over.most].map(|value| format!("{value:.5}{unit}"));
        Some(std::iter::once(name.to_owned()).chain(shown).collect::<Vec<_>>())
    };
    let rows: Vec<Vec<String>> = [
        row("voltage", line.voltage_v, " V"),
        row("current", line.current_a, " A"),
        row("active power", Some(line.power_w), " W"),
        row("power factor", line.power_factor, ""),
    ]
    .into_iter()
    .flatten()
    .collect();
    page.table(&["over the distribution", "mean", "smallest", "largest"], &rows);
    page.paragraph(&format!(
        "Active power {} over {} readings. Luminous efficacy, luminous flux ÷ mean active power: {}.",
        with_u(&line.power),
        line.readings,
        with_u(&line.luminous_efficacy)
    ));
    budget(
        page,
        &[
            ("active power", &line.power),
            ("luminous efficacy", &line.luminous_efficacy),
        ],
    );
}

/// The parts of the uncertainty of some numbers.
fn budget(page: &mut Page, numbers: &[(&str, &Quantity)]) {
    let names: BTreeSet<&str> = numbers
        .iter()
        .flat_map(|(_, quantity)| quantity.parts.keys().copied())
        .collect();
    let mut head = vec!["", "value"];
    head.extend(&names);
    let rows: Vec<Vec<String>> = numbers
        .iter()
        .map(|(name, quantity)| {
            let mut row = vec![(*name).to_owned(), with_u(quantity)];
            row.extend(names.iter().map(|name| {
                quantity
                    .parts
                    .get(name)
                    .map_or_else(String::new, |part| two_digits(*part))
            }));
            row
        })
        .collect();
    page.paragraph(
        "Where the uncertainty comes from: each column is a part in the unit of the row; parts add in squares. A number of which a \
         part was neither measured nor stated has none.",
    );
    page.table(&head, &rows);
}

/// In words, what of a polar curve is below the uncertainty.
fn below(evening: &Evening) -> String {
    let reduction = &evening.reduced.reduction;
    let nodes = reduction.grid.nodes.iter();
    let own = nodes
        .map(|node| node.u_noise_cd.hypot(node.u_digit_cd))
        .fold(f64::INFINITY, f64::min);
    let common = reduction.common.dark_noise_cd.hypot(reduction.common.dark_digit_cd);
    let per_klm = 2000.0 * own.hypot(common) / reduction.flux.value;
    format!("What is nearer to the centre than {per_klm:.2} cd/klm is below 2 standard uncertainties of no light.")
}

fn light(page: &mut Page, evening: &Evening) {
    let Some(spectral) = &evening.reduced.reduction.spectral else {
        return;
    };
    page.heading("Spectrum");
    let options = SpectrumOptions {
        title: String::new(),
        value_label: "spectral irradiance in W/(m²·nm)".to_owned(),
    };
    page.figure(
        &spectrum(&spectral.spectrum, &options),
        &format!("On the axis at {} mm.", spectral.distance_mm),
    );
}

fn sensor(page: &mut Page, evening: &Evening) {
    let facts = &evening.simulation.facts;
    let unit = unit(facts.unit);
    page.heading("Irradiance on the sensor");
    page.figure(
        &simulate::marked(&evening.simulation, evening.u_direction_rel()).figure("noise-free, inverse method"),
        &format!(
            "{} × {} mm, {} × {} pixels.",
            facts.size_mm[0], facts.size_mm[1], facts.pixels[0], facts.pixels[1]
        ),
    );
    page.table(
        &[
            "mean",
            "smallest",
            "largest",
            "min/mean",
            "effects in the map",
            "effects that belong elsewhere",
        ],
        &[vec![
            format!("{:.5} {unit}", facts.mean),
            format!("{:.5} {unit}", facts.min),
            format!("{:.5} {unit}", facts.max),
            format!("{:.5}", facts.uniformity_min_over_mean),
            list(&facts.effects_applied),
            list(&facts.effects_not_applicable),
        ]],
    );
    if let Some(u_rel) = evening.u_direction_rel() {
        let smoothed = if evening.reduced.reduction.grid.smoothed.is_some() {
            " It is drawn from the distribution that was smoothed within these intervals; luminaire.raw.ldt has the one as it was read."
        } else {
            ""
        };
        page.paragraph(&format!(
            "Hatched on the scale: ± 2 standard uncertainties of one direction of the distribution, ± {:.2} %, by rounding and scatter. \
             Smaller structure may be no light. The map spans {:.2} %.{smoothed}",
            200.0 * u_rel,
            100.0 * (facts.max - facts.min) / facts.mean
        ));
    }
}

fn comparison(page: &mut Page, evening: &Evening) {
    let Some(comparison) = &evening.comparison else { return };
    page.heading(&format!(
        "The test: simulated against measured, on the axis at {:.0} mm",
        comparison.distance_mm
    ));
    let row = |what: &str, stated: &super::Stated, lx: &super::Stated| {
        vec![
            what.to_owned(),
            format!("{} W/m²", stated.text(4)),
            format!("{} lx", lx.text(1)),
            String::new(),
        ]
    };
    let mut rows = vec![row(
        "measured, spectroradiometer",
        &comparison.measured_w_m2,
        &comparison.measured_lx,
    )];
    let mut simulated = row(
        "simulated, disc of 1 mm",
        &comparison.simulated_w_m2,
        &comparison.simulated_lx,
    );
    simulated[3] = comparison.gap_text();
    rows.push(simulated);
    if let Some(near) = &comparison.near_field {
        rows.push(vec![
            format!("with near_field, ring of {:.1} mm", near.radius_mm),
            format!("{:.4} W/m²", near.simulated_w_m2),
            String::new(),
            gap_words(near.gap_rel, near.gap_sigma),
        ]);
    }
    page.table(&["", "irradiance", "illuminance", "gap"], &rows);
    page.paragraph(
        "The distribution comes from the lux meter far away, the spectrum from another instrument close by; nothing was \
         fitted between them. One distance cannot tell near_field from an axial offset of the light centre or an error of \
         the short distance: a second short distance would.",
    );
}

fn diagnosis(page: &mut Page, evening: &Evening) {
    let Some(Diagnosed { words, same_record }) = &evening.diagnosis else {
        return;
    };
    if *same_record {
        page.heading("Consistency check of the record");
        page.paragraph(&capitalised(SAME_RECORD));
        if evening.comparison.is_some() {
            page.paragraph("The test of this day is the comparison on the axis, above.");
        }
    } else {
        page.heading("Diagnosis");
    }
    let (patch, found): (Vec<&String>, Vec<&String>) = words
        .iter()
        .filter(|line| !line.starts_with("consistency "))
        .partition(|line| line.starts_with("model "));
    let lines = |lines: Vec<&String>| lines.into_iter().map(String::as_str).collect::<Vec<_>>().join("\n");
    page.preformatted(&lines(found));
    if !patch.is_empty() {
        page.details("what it would change in the model file", &lines(patch));
    }
    page.files(&[("diagnosis/report.html", "the whole of it, with its pictures")]);
}

fn results(page: &mut Page, evening: &Evening) {
    page.heading("Files");
    let mut files = vec![
        ("luminaire.ldt", "EULUMDAT"),
        ("luminaire.raw.ldt", "EULUMDAT as read, before smoothing"),
        ("luminaire.ies", "IES LM-63-2002"),
        ("luminaire.spdx", "spectrum, IES TM-27"),
        ("luminaire.spd", "spectrum, plain columns"),
        ("luminaire.model.toml", "the model that simulates and predicts"),
        ("irradiance.npy", "the map, 32-bit floats"),
        ("irradiance.png", "the map in false colours"),
        ("result.json", "numbers of the simulation"),
        ("budget.json", "the uncertainty, part by part"),
        ("comparison.json", "the axis at the short distance"),
        ("provenance.json", "what was measured, with what, by which program"),
    ];
    files.retain(|(file, _)| evening.reduced.folder.join(file).exists() && !evening.stale.contains(file));
    page.files(&files);
    if !evening.stale.is_empty() {
        page.paragraph(&format!(
            "Of another reduction or sensor than this page, and not shown: {}. `isolux run --resume` makes all of them again.",
            evening.stale.join(", ")
        ));
    }
}

fn record(page: &mut Page, evening: &Evening) {
    let reduction = &evening.reduced.reduction;
    page.heading("The record");
    page.figure(
        &reference(evening),
        "Visits to the reference point (C 0°, γ 0°), relative to their mean.",
    );
    if let Some(closing) = &reduction.closing {
        page.paragraph(&format!(
            "Closing half-plane C 360° against C 0°: rms {:.3} cd over {} directions, largest {:+.3} cd at γ {}°; mean square {:.2} of \
             what noise and rounding allow.",
            closing.rms_cd, closing.directions, closing.max_cd, closing.max_gamma_deg, closing.chi2_per_direction
        ));
    }
    page.paragraph(&format!(
        "{} of {} readings make the distribution, read at {} mm.",
        reduction.readings.0, reduction.readings.1, reduction.distance_mm
    ));
    for note in &reduction.notes {
        page.paragraph(note);
    }
    let devices: Vec<Vec<String>> = evening
        .reduced
        .run
        .header
        .device
        .iter()
        .map(|device| {
            vec![
                device.role.clone(),
                device.model.clone(),
                device.serial.clone().unwrap_or_default(),
                device.open.clone(),
            ]
        })
        .collect();
    page.table(&["instrument", "model", "serial number", "opened as"], &devices);
}

/// Reference readings over time with their digit.
fn reference(evening: &Evening) -> String {
    let visits: Vec<(f64, f64, f64)> = evening
        .reduced
        .run
        .readings
        .rows
        .iter()
        .filter(|row| row.role == Role::Reference)
        .filter_map(|row| Some((row.time_s? / 60.0, row.illuminance_lx?, row.u_lx?)))
        .collect();
    let mean = visits.iter().map(|visit| visit.1).sum::<f64>() / visits.len().max(1) as f64;
    let relative = |lx: f64| 100.0 * (lx / mean - 1.0);
    let mut svg = Svg::new(560.0, 300.0, "reference readings over time");
    let values = visits
        .iter()
        .flat_map(|v| [relative(v.1 + 2.0 * v.2), relative(v.1 - 2.0 * v.2)]);
    let frame = Frame {
        left: 70.0,
        top: 16.0,
        width: 470.0,
        height: 230.0,
        x: Scale::around(visits.iter().map(|visit| visit.0), false),
        y: Scale::around(values, true),
    };
    frame.draw(&mut svg, "time since the lamp was switched on in min", "change in %");
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
            (305.0, 130.0),
            12.0,
            Anchor::Middle,
            colour::MUTED,
            "the plan had no visits",
        );
    }
    svg.finish()
}

/// A part of an uncertainty: more than two digits of it would be noise.
fn two_digits(part: f64) -> String {
    if part == 0.0 {
        return "0".to_owned();
    }
    let decimals = (1 - part.abs().log10().floor() as i32).clamp(0, 9) as usize;
    format!("{part:.decimals$}")
}

fn unit(unit: &str) -> &str {
    if unit == "W/m2" { "W/m²" } else { unit }
}

fn list(names: &[&str]) -> String {
    if names.is_empty() {
        "none".to_owned()
    } else {
        names.join(", ")
    }
}
