//! The four published rows by three samplings, what their differences are worth, convergence and maps.

use std::fmt::Write as _;

use isolux_report::axes::{Frame, Scale};
use isolux_report::map::Map;
use isolux_report::svg::{Anchor, Stroke, Svg};
use isolux_sim::direct::{self, Sampling};
use isolux_sim::inverse::{self, Accuracy};
use isolux_sim::source::LightSource;
use isolux_sim::{blur, noise};
use rayon::prelude::*;

use crate::Book;
use crate::filter::{FILTERS, ONCE, TWICE, one_ray};
use crate::scene::{LER, PUBLISHED, sensor};
use crate::statistics::{middle_of, quantile, significant, smirnov};

/// One row by one sampling: a value a seed.
pub(crate) struct Runs {
    row: usize,
    sampling: Sampling,
    means: Vec<f64>,
    /// Largest pixel: unfiltered, one pass, two passes.
    maxima: [Vec<f64>; 3],
    counts: Vec<f64>,
}

/// Four rows by three samplings.
pub(crate) fn table(book: &mut Book, source: &LightSource, seeds: u64, exact: f64, share: f64) -> Vec<Runs> {
    let mut text = format!(
        "## The four rows by three samplings\n\n{seeds} seeds each. Mean: over the seeds ± standard deviation of one run, W/m². Maximum: median (2.5 % to 97.5 %) of the \
         largest pixel, W/m², of the map as it is, after one pass and after two passes of a 3 × 3 mean.\n\n| pixels, rays | sampling | mean | standard error by counting | \
         maximum | one pass | two passes |\n|---|---|---|---|---|---|---|\n"
    );
    let mut all = Vec::new();
    for (index, row) in PUBLISHED.iter().enumerate() {
        let sensor = sensor(24.576, row.pixels, 500.0);
        let map = inverse::solve(source, &sensor, Accuracy::Standard).illuminance_lx;
        let unit = one_ray(row.pixels, row.rays);
        for sampling in [Sampling::Traced, Sampling::Thinned, Sampling::Expected] {
            let mut runs = Runs {
                row: index,
                sampling,
                means: Vec::new(),
                maxima: Default::default(),
                counts: Vec::new(),
            };
            for seed in 1..=seeds {
                // Seeds of their own: rows and samplings are compared as independent.
                let seed = 10_000 * (index as u64 + 1) + 1000 * sampling as u64 + seed;
                let found = match sampling {
                    Sampling::Traced => direct::traced(source, &sensor, row.rays, seed),
                    Sampling::Thinned => direct::thinned(source, &sensor, row.rays, seed),
                    Sampling::Expected => direct::expected(source, &sensor, &map, row.rays, seed),
                };
                let count = found.expect("rays").count;
                let caught = count.iter().sum::<u64>() as f64;
                runs.counts.push(caught);
                runs.means.push(caught * unit / sensor.pixels() as f64);
                let found: Vec<f64> = [0, ONCE, TWICE]
                    .par_iter()
                    .map(|&filter| FILTERS[filter].largest(&count, row.pixels) * unit)
                    .collect();
                for (values, largest) in runs.maxima.iter_mut().zip(found) {
                    values.push(largest);
                }
            }
            let (centre, spread) = middle_of(&runs.means);
            let law = |k: usize| {
                let of = |p: f64| significant(quantile(&runs.maxima[k], p));
                format!("{} ({}–{})", of(0.5), of(0.025), of(0.975))
            };
            let _ = writeln!(
                text,
                "| {} | {} | {centre:.5} ± {spread:.5} | {:.5} | {} | {} | {} |",
                row.name(),
                sampling.word(),
                exact / (row.rays as f64 * share).sqrt(),
                law(0),
                law(1),
                law(2)
            );
            eprintln!("rows: {} {}", row.name(), sampling.word());
            all.push(runs);
        }
    }
    text.push_str(&agreement(&all));
    book.write(&text);
    book.figure(
        "published-case-maxima.svg",
        "Maxima over the seeds by sampling and filter, with the published values",
        maxima_figure(&all).as_bytes(),
    );
    all
}

/// Whether the three samplings follow one law: mean, variance of the count, maximum.
fn agreement(all: &[Runs]) -> String {
    let mut text = String::from(
        "\nThe three samplings against each other: differences of the means in standard errors, variance of the number of rays on the sensor over its mean \
         (1 for counts), and the Kolmogorov–Smirnov probability that two samplings' maxima (two passes) come from one law.\n\n| pixels, rays | traced − thinned | thinned − expected | \
         variance / mean: traced, thinned, expected | maxima: traced, thinned | maxima: thinned, expected |\n|---|---|---|---|---|---|\n",
    );
    for (index, row) in PUBLISHED.iter().enumerate() {
        let of: Vec<&Runs> = all.iter().filter(|runs| runs.row == index).collect();
        let apart = |a: &Runs, b: &Runs| {
            let error = |runs: &Runs| {
                let (mean, spread) = middle_of(&runs.means);
                (mean, spread / (runs.means.len() as f64).sqrt())
            };
            noise::difference(error(a), error(b)).sigma
        };
        let ratio = |runs: &Runs| {
            let (mean, spread) = middle_of(&runs.counts);
            spread * spread / mean
        };
        let _ = writeln!(
            text,
            "| {} | {:+.2} σ | {:+.2} σ | {:.2}, {:.2}, {:.2} | {:.2} | {:.2} |",
            row.name(),
            apart(of[0], of[1]),
            apart(of[1], of[2]),
            ratio(of[0]),
            ratio(of[1]),
            ratio(of[2]),
            smirnov(&of[0].maxima[2], &of[1].maxima[2]),
            smirnov(&of[1].maxima[2], &of[2].maxima[2]),
        );
    }
    let n = all.first().map_or(1.0, |runs| runs.means.len() as f64);
    let _ = writeln!(
        text,
        "\nOver {n} runs the ratio variance / mean scatters by {:.2}.",
        (2.0 / (n - 1.0).max(1.0)).sqrt()
    );
    text
}

/// Which published differences are noise.
pub(crate) fn significance(book: &mut Book, exact: f64, share: f64) {
    let mut text = String::from(
        "## Which mean differences are noise\n\nStandard errors by counting alone, two-sided probability:\n\n| published | against | difference | standard error | | P |\n|---|---|---|---|---|---|\n",
    );
    let u = |rays: u64| exact / (rays as f64 * share).sqrt();
    let mut row = |what: String, against: String, a: (f64, f64), b: (f64, f64)| {
        let difference = noise::difference(a, b);
        let _ = writeln!(
            text,
            "| {what} | {against} | {:+.4} W/m² | {:.4} W/m² | {:+.1} σ | {} |",
            a.0 - b.0,
            a.1.hypot(b.1),
            difference.sigma,
            if difference.p_value < 1e-12 {
                "< 1e-12".to_owned()
            } else {
                format!("{:.2}", difference.p_value)
            }
        );
    };
    let of = |k: usize| (PUBLISHED[k].mean, u(PUBLISHED[k].rays));
    let name = |k: usize| format!("{} ({})", PUBLISHED[k].mean, PUBLISHED[k].name());
    for (a, b) in [(0, 2), (0, 1), (2, 3), (0, 3), (1, 3)] {
        row(name(a), name(b), of(a), of(b));
    }
    for k in 0..4 {
        row(name(k), format!("{exact:.4} without noise"), of(k), (exact, 0.0));
    }
    text.push_str(
        "\nThe means at 2·10⁵ rays differ from each other and from those at 2·10⁹ by noise alone. 5.38 against 5.25 at 2·10⁹ rays is not noise: counting rays on other pixels cannot \
         make it. Against the mean without noise the verdict on 2·10⁹ rays is one on the assumed 995 cd/klm and 255.1 lm/W too, of which one factor is free; two values from one lamp are not.\n",
    );
    book.write(&text);
}

/// Mean and maximum against the number of rays, two pixel sizes, with a figure.
pub(crate) fn convergence(book: &mut Book, source: &LightSource, exact: f64) {
    let mut svg = Svg::new(760.0, 440.0, "Convergence of mean and maximum");
    let frame = Frame {
        left: 80.0,
        top: 24.0,
        width: 640.0,
        height: 350.0,
        x: Scale::logarithmic(1e5, 1e12),
        y: Scale::logarithmic(1.0, 1e5),
    };
    frame.draw(&mut svg, "rays", "irradiance / W/m²");
    let mut text = String::from(
        "## Convergence\n\nExpected counts, seed 1; the law of the largest pixel: P(max ≤ k) = Π F(k; λ).\n\n| pixels | rays | rays a pixel | mean | standard error | largest pixel | its law: median (95 %) |\n|---|---|---|---|---|---|---|\n",
    );
    for (pixels, dash) in [(2048, ""), (1024, "6 4")] {
        let sensor = sensor(24.576, pixels, 500.0);
        let map = inverse::solve(source, &sensor, Accuracy::Standard).illuminance_lx;
        let (mut means, mut maxima) = (Vec::new(), Vec::new());
        for exponent in 5..=12 {
            let rays = 10_u64.pow(exponent);
            let counts = direct::expected(source, &sensor, &map, rays, 1).expect("rays");
            let unit = counts.lux_per_ray() / LER;
            let mean = counts.on_sensor() as f64 * unit / sensor.pixels() as f64;
            let largest = counts.count.iter().copied().max().unwrap_or(0) as f64 * unit;
            let law = noise::largest_count(&map.iter().map(|lux| lux / counts.lux_per_ray()).collect::<Vec<_>>());
            let _ = writeln!(
                text,
                "| {pixels}² | 1e{exponent} | {} | {mean:.4} | {:.4} | {} | {} ({}–{}) |",
                significant(counts.on_sensor() as f64 / sensor.pixels() as f64),
                mean / (counts.on_sensor().max(1) as f64).sqrt(),
                significant(largest),
                significant(law.median * unit),
                significant(law.lo95 * unit),
                significant(law.hi95 * unit)
            );
            means.push(frame.at(rays as f64, mean.max(1.0)));
            maxima.push(frame.at(rays as f64, largest.max(1.0)));
        }
        svg.polyline(means, line("#2458a8", 2.0, dash));
        svg.polyline(maxima, line("#b3261e", 2.0, dash));
    }
    svg.line(frame.at(1e5, exact), frame.at(1e12, exact), line("#666666", 1.0, "2 3"));
    for (k, (words, colour)) in [
        ("largest pixel, 12 µm solid, 24 µm dashed", "#b3261e"),
        ("mean", "#2458a8"),
        ("mean without noise", "#666666"),
    ]
    .into_iter()
    .enumerate()
    {
        svg.text((430.0, 56.0 + 18.0 * k as f64), Anchor::Start, colour, words);
    }
    text.push_str("\nThe error of the mean falls as 1/√(rays on the sensor) and does not know the pixels; the largest pixel at few rays is one or two rays in a pixel's area.\n");
    book.write(&text);
    book.figure(
        "published-case-convergence.svg",
        "Mean and largest pixel against the number of rays",
        svg.finish().as_bytes(),
    );
}

/// What the eye sees: the same light by 2·10⁹ rays as counted, filtered, and without noise.
pub(crate) fn maps(book: &mut Book, source: &LightSource) {
    let side = 1024;
    let sensor = sensor(24.576, side, 500.0);
    let counts = direct::thinned(source, &sensor, 2_000_000_000, 1).expect("rays");
    let counted: Vec<f64> = counts.illuminance_lx().iter().map(|lux| lux / LER).collect();
    let filtered = blur::box3(&counted, side, side, 2);
    let free: Vec<f64> = inverse::solve(source, &sensor, Accuracy::Standard)
        .illuminance_lx
        .iter()
        .map(|lux| lux / LER)
        .collect();
    book.write("## Maps\n\nThe middle 3 mm (128 × 128 pixels of 24 µm) of 2·10⁹ rays, seed 1: as counted, after two passes of the 3 × 3 mean, and without noise. Each has its own scale.");
    for (name, map) in [("counted", &counted), ("filtered", &filtered), ("noise-free", &free)] {
        let from = side / 2 - 64;
        let values: Vec<f32> = (0..128 * 128)
            .map(|k| map[(from + k / 128) * side + from + k % 128] as f32)
            .collect();
        let picture = Map {
            values: &values,
            nx: 128,
            ny: 128,
            size_mm: [3.072; 2],
            quantity: "irradiance",
            unit: "W/m²",
            u: None,
        };
        book.figure(&format!("published-case-{name}.png"), name, &picture.png());
    }
}

/// The answer in a few lines, from the runs.
pub(crate) fn answer(all: &[Runs]) -> String {
    let mut text = String::from(
        "## The answer\n\n| pixels, rays | published mean, max | mean of the thinned runs | median maximum after two passes |\n|---|---|---|---|\n",
    );
    for runs in all.iter().filter(|runs| runs.sampling == Sampling::Thinned) {
        let row = &PUBLISHED[runs.row];
        let _ = writeln!(
            text,
            "| {} | {}, {} | {:.4} | {} |",
            row.name(),
            row.mean,
            row.max,
            middle_of(&runs.means).0,
            significant(quantile(&runs.maxima[2], 0.5))
        );
    }
    text
}

/// Every maximum as a point, the published value as a line.
fn maxima_figure(all: &[Runs]) -> String {
    let mut svg = Svg::new(980.0, 420.0, "Maxima");
    let colours = ["#2458a8", "#2e7d4f", "#a05fb0"];
    for (index, row) in PUBLISHED.iter().enumerate() {
        let of: Vec<&Runs> = all.iter().filter(|runs| runs.row == index).collect();
        let values = || of.iter().flat_map(|runs| runs.maxima.iter().flatten().copied());
        let top = values().fold(row.max, f64::max) * 1.3;
        let low = values().fold(row.max, f64::min) / 1.3;
        let frame = Frame {
            left: 70.0 + 235.0 * index as f64,
            top: 40.0,
            width: 160.0,
            height: 300.0,
            x: Scale::linear(0.0, 9.0),
            y: Scale::logarithmic(low, top),
        };
        // Groups stand for themselves: no numbers under them.
        for (k, words) in ["none", "once", "twice"].iter().enumerate() {
            let (x, y) = frame.at(1.5 + 3.0 * k as f64, low);
            svg.text((x, y + 16.0), Anchor::Middle, "#222831", words);
        }
        let (left, right) = (frame.at(0.0, low), frame.at(9.0, top));
        svg.rectangle(
            left.0,
            right.1,
            right.0 - left.0,
            left.1 - right.1,
            "none",
            Some(Stroke::solid("#66707c", 1.0)),
        );
        for tick in (0..5).flat_map(|decade| [1.0, 2.0, 5.0].map(|k| k * 10.0_f64.powi(decade))) {
            if (low..top).contains(&tick) {
                let at = frame.at(0.0, tick);
                svg.text((at.0 - 6.0, at.1 + 4.0), Anchor::End, "#222831", &format!("{tick}"));
                svg.line((at.0 - 4.0, at.1), at, Stroke::solid("#66707c", 1.0));
            }
        }
        for (s, runs) in of.iter().enumerate() {
            for (k, maxima) in runs.maxima.iter().enumerate() {
                for (n, value) in maxima.iter().enumerate() {
                    let spread = 0.5 * (n as f64 / maxima.len() as f64 - 0.5);
                    let x = 0.5 + 3.0 * k as f64 + s as f64 + spread;
                    svg.circle(frame.at(x, *value), 1.4, colours[s], None);
                }
            }
        }
        svg.line(
            frame.at(0.0, row.max),
            frame.at(9.0, row.max),
            line("#b3261e", 1.5, "5 3"),
        );
        svg.text(
            (frame.left + 80.0, 28.0),
            Anchor::Middle,
            "#222831",
            &format!("{}: {}", row.name(), row.max),
        );
    }
    svg.text(
        (70.0, 385.0),
        Anchor::Start,
        "#222831",
        "passes of the 3 × 3 mean; maximum in W/m²; dashed: published",
    );
    for (k, word) in ["traced", "thinned", "expected"].iter().enumerate() {
        svg.text((70.0 + 90.0 * k as f64, 405.0), Anchor::Start, colours[k], word);
    }
    svg.finish()
}

fn line<'a>(colour: &'a str, width: f64, dash: &'a str) -> Stroke<'a> {
    Stroke { colour, width, dash }
}
