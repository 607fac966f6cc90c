//! Writes `published-case.md` with all tables and figures behind the page of that name in the book, which is its
//! summary: the published simulation of a ring illuminator, its four rows by three samplings over many seeds, and what
//! explains them.
//!
//!     cargo run --release -p isolux-report --example published_case [FOLDER] [SEEDS]

#![expect(
    clippy::print_stderr,
    clippy::expect_used,
    reason = "a program to run by hand: it says how far it is, and stops where it cannot go on"
)]

mod filter;
mod impact;
mod rows;
mod scene;
mod statistics;
mod summation;

use std::fmt::Write as _;

use isolux_sim::inverse::{self, Accuracy};
use isolux_sim::noise;
use scene::{FLUX_LM, LER, lamp, sensor, source};

/// The page under construction, and where its figures go.
pub(crate) struct Book {
    page: String,
    folder: String,
}

impl Book {
    fn write(&mut self, text: &str) {
        self.page.push_str(text);
        self.page.push('\n');
    }

    fn figure(&mut self, name: &str, caption: &str, bytes: &[u8]) {
        std::fs::write(format!("{}/{name}", self.folder), bytes).expect("the figure is written");
        let _ = writeln!(self.page, "\n![{caption}]({name})\n");
    }
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let folder = arguments.next().unwrap_or_else(|| "target/published-case".to_owned());
    let seeds: u64 = arguments.next().and_then(|seeds| seeds.parse().ok()).unwrap_or(50);
    std::fs::create_dir_all(&folder).expect("the folder is there");
    let mut book = Book {
        page: INTRODUCTION.to_owned(),
        folder,
    };
    let lamp = lamp(15.0, 1.0, 0.0);
    let source = source(&lamp);
    let reference = inverse::solve(&source, &sensor(24.576, 256, 500.0), Accuracy::Standard);
    let exact = noise::sum(reference.illuminance_lx.iter().copied()) / 65536.0 / LER;
    let top = reference.illuminance_lx.iter().copied().fold(0.0, f64::max) / LER;
    let share = exact * LER * 24.576e-3 * 24.576e-3 / FLUX_LM;
    book.write(&format!(
        "## Without noise\n\nInverse: mean {exact:.4} W/m², largest pixel {top:.4} W/m² (bound on the quadrature's error {:.1e} W/m²). \
         {:.4} % of the flux reaches the sensor: of 2·10⁵ rays {:.0}, of 2·10⁹ rays {:.3e}. The mean of a direct simulation scatters round this \
         value; it does not depend on the pixels.\n",
        reference.bound.mean_lx / LER,
        100.0 * share,
        2e5 * share,
        2e9 * share
    ));
    let runs = rows::table(&mut book, &source, seeds, exact, share);
    rows::significance(&mut book, exact, share);
    filter::maxima(&mut book, &source, seeds);
    summation::single_precision(&mut book, &source);
    rows::convergence(&mut book, &source, exact);
    rows::maps(&mut book, &source);
    scene::efficacy(&mut book);
    impact::sweeps(&mut book);
    book.write(&rows::answer(&runs));
    std::fs::write(format!("{}/published-case.md", book.folder), &book.page).expect("the page is written");
}

const INTRODUCTION: &str = "# The published case, run again and explained

A commercial direct simulation of a ring illuminator (337 lm, about 1000 cd/klm on the axis, a disc of 1 mm as light centre; sensor
24.576 mm at 500 mm) gave four means and four maxima that its authors could not explain. All numbers and figures are computed by

    cargo run --release -p isolux-report --example published_case

| pixels | rays | mean W/m² | maximum W/m² |
|---|---|---|---|
| 2048², 12 µm | 2·10⁵ | 5.07 | 5096.2 |
| 2048², 12 µm | 2·10⁹ | 5.38 | 11.95 |
| 1024², 24 µm | 2·10⁵ | 5.05 | 2548.1 |
| 1024², 24 µm | 2·10⁹ | 5.25 | 8.58 |

Assumptions: a lobe cosⁿγ of 337 lm with 995 cd/klm on the axis, γ step 1°; luminous efficacy of radiation 255.1 lm/W, which the
published means imply. The lobe's width and the 995 cd/klm are not published; they scale means and maxima alike.

";
