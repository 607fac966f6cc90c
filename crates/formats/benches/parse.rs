//! Parse and write of EULUMDAT beside the floor: a plain line-by-line parse of the same bytes to `f64`.
//!
//! `cargo bench -p isolux-formats`: bytes a second; "values" counts intensities a second.

use divan::counter::{BytesCount, ItemsCount};
use isolux_formats::{Content, eulumdat, read_any};

fn main() {
    divan::main();
}

const SIZES: [(usize, usize); 2] = [(25, 91), (361, 181)];

/// A full-circle file of `planes` × `gammas` intensities.
fn file(planes: usize, gammas: usize) -> String {
    let mut lines: Vec<String> = ["house", "3", "0"].map(str::to_owned).to_vec();
    let c_step = 360.0 / planes as f64;
    let gamma_step = 180.0 / (gammas - 1) as f64;
    lines.extend([
        planes.to_string(),
        c_step.to_string(),
        gammas.to_string(),
        gamma_step.to_string(),
    ]);
    lines.extend(
        [
            "r", "n", "1", "f", "d", "500", "0", "100", "500", "0", "0", "0", "0", "0", "100", "85", "1", "0", "1",
        ]
        .map(str::to_owned),
    );
    lines.extend(["1", "LED", "1000", "4000", "80", "10"].map(str::to_owned));
    lines.extend(std::iter::repeat_n("0.5".to_owned(), 10));
    lines.extend((0..planes).map(|plane| (plane as f64 * c_step).to_string()));
    lines.extend((0..gammas).map(|gamma| (gamma as f64 * gamma_step).to_string()));
    for plane in 0..planes {
        for gamma in 0..gammas {
            let cosine = (gamma as f64 * gamma_step).to_radians().cos().max(0.0);
            let ripple = 1.0 + 0.1 * (plane as f64 * c_step).to_radians().cos() * (1.0 - cosine);
            lines.push(format!("{:.2}", 270.0 * cosine * ripple));
        }
    }
    lines.join("\r\n") + "\r\n"
}

#[divan::bench(args = SIZES)]
fn read(bencher: divan::Bencher<'_, '_>, (planes, gammas): (usize, usize)) {
    let text = file(planes, gammas);
    bencher
        .counter(BytesCount::of_str(&text))
        .counter(ItemsCount::new(planes * gammas))
        .bench(|| {
            eulumdat::read(
                divan::black_box(text.as_bytes()),
                isolux_formats::ReadOptions::default(),
            )
        });
}

#[divan::bench(args = SIZES)]
fn floor(bencher: divan::Bencher<'_, '_>, (planes, gammas): (usize, usize)) {
    let text = file(planes, gammas);
    bencher
        .counter(BytesCount::of_str(&text))
        .counter(ItemsCount::new(planes * gammas))
        .bench(|| {
            divan::black_box(&text)
                .lines()
                .filter_map(|line| line.parse::<f64>().ok())
                .sum::<f64>()
        });
}

#[divan::bench(args = SIZES)]
fn write(bencher: divan::Bencher<'_, '_>, (planes, gammas): (usize, usize)) {
    let text = file(planes, gammas);
    let Some(Content::Distribution(distribution)) = read_any(text.as_bytes(), "x.ldt").remove(0).document else {
        return;
    };
    let Some(document) = distribution.eulumdat.as_deref() else {
        return;
    };
    bencher
        .counter(BytesCount::of_str(&text))
        .counter(ItemsCount::new(planes * gammas))
        .bench(|| eulumdat::write_document(divan::black_box(document)));
}
