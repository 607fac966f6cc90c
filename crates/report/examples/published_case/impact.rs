//! The impact of changing the parameters, all without noise.

use std::fmt::Write as _;

use isolux_photometry::IntensityDistribution;
use isolux_report::axes::{Frame, Scale};
use isolux_report::svg::{Anchor, Stroke, Svg};
use isolux_sim::inverse::{self, Accuracy};
use isolux_sim::noise;
use isolux_sim::sensor::Sensor;

use crate::Book;
use crate::scene::{FLUX_LM, LER, lamp, sensor, source, spectra};

struct Row {
    value: String,
    x: f64,
    mean: f64,
    max: f64,
    min: f64,
}

/// Every sweep as a table and a chart.
pub(crate) fn sweeps(book: &mut Book) {
    book.write("## The impact of changing the parameters\n\nInverse, so that no row holds noise; irradiance in W/m². Changes are against the published case.\n");
    let standard = sensor(24.576, 64, 500.0);
    let round = lamp(15.0, 1.0, 0.0);
    let mut all: Vec<(&str, &str, Vec<Row>)> = Vec::new();
    // Against the finest step: the largest difference of one pixel.
    let apart = |lamp: &IntensityDistribution, finest: &IntensityDistribution, sensor: &Sensor| {
        let map = |lamp| inverse::solve(&source(lamp), sensor, Accuracy::Standard).illuminance_lx;
        let (a, b) = (map(lamp), map(finest));
        let most = a.iter().zip(&b).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max);
        format!("pixels within {:.3} %", 100.0 * most)
    };
    let planes = [5.0, 10.0, 15.0, 22.5, 30.0, 45.0];
    for (name, sensor) in [
        ("half-planes, lobe askew", standard),
        ("half-planes, lobe askew, sensor 400 mm", sensor(400.0, 64, 500.0)),
    ] {
        let of_step = |step| {
            let coarse = lamp(step, 1.0, 0.1);
            let label = format!("every {step}°, {}", apart(&coarse, &lamp(5.0, 1.0, 0.1), &sensor));
            illuminated(&label, step, &coarse, &sensor, LER)
        };
        all.push((name, "step in C / °", planes.map(of_step).into()));
    }
    all.push((
        "γ step",
        "step in γ / °",
        [0.5, 1.0, 2.0, 5.0, 10.0]
            .map(|step| {
                illuminated(
                    &format!(
                        "{step}°, {}",
                        apart(&lamp(15.0, step, 0.0), &lamp(15.0, 0.5, 0.0), &standard)
                    ),
                    step,
                    &lamp(15.0, step, 0.0),
                    &standard,
                    LER,
                )
            })
            .into(),
    ));
    let mut spectral = vec![illuminated(
        "255.1 lm/W, implied by the published means",
        LER,
        &round,
        &standard,
        LER,
    )];
    for (name, spectrum) in spectra() {
        if let Some(ler) = spectrum.ler_lm_per_w() {
            spectral.push(illuminated(
                &format!("{name}: {ler:.1} lm/W"),
                ler,
                &round,
                &standard,
                ler,
            ));
        }
    }
    for ler in [305.0, 319.0] {
        spectral.push(illuminated(
            &format!("{ler} lm/W, CIE LED-B1 to B5"),
            ler,
            &round,
            &standard,
            ler,
        ));
    }
    spectral.sort_by(|a, b| a.x.total_cmp(&b.x));
    all.push(("spectrum", "efficacy / lm/W", spectral));
    all.push((
        "pixel size and number, sensor 24.576 mm",
        "pixel / µm",
        [64, 128, 256, 512, 1024, 2048]
            .map(|pixels| {
                let pitch = 24_576.0 / pixels as f64;
                illuminated(
                    &format!("{pixels}², {pitch} µm"),
                    pitch,
                    &round,
                    &sensor(24.576, pixels, 500.0),
                    LER,
                )
            })
            .into(),
    ));
    all.push((
        "pixel number, pixels of 12 µm",
        "pixels a side",
        [256, 512, 1024, 2048]
            .map(|pixels| {
                illuminated(
                    &format!("{pixels}²"),
                    pixels as f64,
                    &round,
                    &sensor(0.012 * pixels as f64, pixels, 500.0),
                    LER,
                )
            })
            .into(),
    ));
    all.push((
        "sensor size, 64² pixels",
        "side / mm",
        [6.144, 12.288, 24.576, 49.152, 98.304]
            .map(|side| illuminated(&format!("{side} mm"), side, &round, &sensor(side, 64, 500.0), LER))
            .into(),
    ));
    all.push((
        "distance",
        "distance / mm",
        [125.0, 250.0, 500.0, 750.0, 1000.0]
            .map(|d| illuminated(&format!("{d} mm"), d, &round, &sensor(24.576, 64, d), LER))
            .into(),
    ));
    let base = illuminated("", 0.0, &round, &standard, LER);
    let mut text = String::from(
        "| changed | value | mean | max | min/mean | mean against the published case |\n|---|---|---|---|---|---|\n",
    );
    for (name, _, rows) in &all {
        for row in rows {
            let _ = writeln!(
                text,
                "| {name} | {} | {:.5} | {:.5} | {:.5} | {:+.2} % |",
                row.value,
                row.mean,
                row.max,
                row.min / row.mean,
                100.0 * (row.mean / base.mean - 1.0)
            );
        }
    }
    let _ = write!(
        text,
        "\nPixel size and number change nothing but how finely the same light is divided; distance acts as 1/d², the spectrum as 1/K, at {FLUX_LM} lm. The coarser γ step flattens the interpolated lobe between its \
         points, which the fixed flux then gives back elsewhere. The step in C acts only where the lamp is not round, and grows away from the axis; “pixels within” is the largest difference of one pixel from the finest step. The askew lobe is 1 + 0.1 (sin γ cos(C − 20°) + 2 sin²γ cos 2(C − 20°)) times the round one.\n"
    );
    book.write(&text);
    book.figure(
        "published-case-sweeps.svg",
        "Mean and maximum against each parameter",
        chart(&all).as_bytes(),
    );
}

fn illuminated(value: &str, x: f64, lamp: &IntensityDistribution, sensor: &Sensor, ler: f64) -> Row {
    let map = inverse::solve(&source(lamp), sensor, Accuracy::Standard).illuminance_lx;
    let moments = noise::moments(&map).expect("a map has pixels");
    Row {
        value: value.to_owned(),
        x,
        mean: moments.mean / ler,
        max: moments.max / ler,
        min: moments.min / ler,
    }
}

/// A small chart a sweep: mean solid, maximum dashed, minimum dotted.
fn chart(all: &[(&str, &str, Vec<Row>)]) -> String {
    let mut svg = Svg::new(1180.0, 640.0, "Sweeps");
    for (k, (name, label, rows)) in all.iter().enumerate() {
        let frame = Frame {
            left: 70.0 + 290.0 * (k % 4) as f64,
            top: 34.0 + 310.0 * (k / 4) as f64,
            width: 205.0,
            height: 205.0,
            x: Scale::around(rows.iter().map(|row| row.x), false),
            y: Scale::around(rows.iter().flat_map(|row| [row.mean, row.max, row.min]), false),
        };
        frame.draw(&mut svg, label, "W/m²");
        svg.text((frame.left, frame.top - 10.0), Anchor::Start, "#222831", name);
        for (pick, dash) in [
            ((|row| row.mean) as fn(&Row) -> f64, ""),
            (|row| row.max, "6 3"),
            (|row| row.min, "2 3"),
        ] {
            svg.polyline(
                rows.iter().map(|row| frame.at(row.x, pick(row))),
                Stroke {
                    colour: "#2458a8",
                    width: 1.6,
                    dash,
                },
            );
        }
        for row in rows {
            svg.circle(frame.at(row.x, row.mean), 2.4, "#2458a8", None);
        }
    }
    svg.text(
        (70.0, 632.0),
        Anchor::Start,
        "#222831",
        "solid: mean; dashed: largest pixel; dotted: smallest pixel",
    );
    svg.finish()
}
