//! The table of the two days: `cargo bench -p isolux-two-days -- [readings|maps] [--faults LABEL,…] [--sigma 3|10|30]
//! [--seed 1…5] [--grid equal|coarse|shifted] [--lamp ring|spot|oval] [--share 0.1] [--threads N] [--cases] [--write
//! FOLDER]`.
//!
//! Every fault is hidden at 3, 10 and 30 σ above noise and the model's own uncertainty with five lamps, grids and
//! kinds of lamps taking turns, then 200 days without a fault (`--faults none` alone). `--share` takes an even part of
//! it. `--cases` prints a line for each case as it ends; `--write` keeps all files and prints the command that
//! diagnoses a case by hand.

use std::io::Write as _;
use std::process::ExitCode;
use std::time::Instant;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_two_days::case::{Order, Outcome};
use isolux_two_days::days::DayError;
use isolux_two_days::faults::Kind;
use isolux_two_days::lamps::Lamp;
use isolux_two_days::plans::Grid;
use isolux_two_days::suite::{self, Wanted};
use isolux_two_days::tables::report;

/// What was asked for.
struct Options {
    wanted: Wanted,
    cases: bool,
    write: Option<Utf8PathBuf>,
    threads: usize,
}

fn main() -> ExitCode {
    let requested = match requested(std::env::args().skip(1)) {
        Ok(requested) => requested,
        Err(error) => {
            say(&error);
            return ExitCode::from(2);
        }
    };
    let orders = suite::orders(&requested.wanted);
    let temporary = tempfile::tempdir().expect("a temporary folder");
    let root = match &requested.write {
        Some(folder) => folder.clone(),
        None => Utf8PathBuf::try_from(temporary.path().to_owned()).expect("a UTF-8 path"),
    };
    let started = Instant::now();
    let done = |order: &Order, folder: &Utf8Path, outcome: &Result<Outcome, DayError>| {
        if requested.cases || requested.write.is_some() {
            say(&line(order, outcome));
        }
        if let (Some(_), Ok(Outcome::Answered(case))) = (&requested.write, outcome) {
            let observations = match order.kind {
                Kind::Readings => folder.join("run"),
                Kind::Maps => folder.join("maps.toml"),
            };
            let day = root
                .join("days")
                .join(format!("first-{}-{}", case.order.lamp.name(), case.order.seed));
            say(&format!(
                "isolux diagnose {} {observations} --out {}",
                day.join("results/luminaire.model.toml"),
                folder.join("by-hand")
            ));
        }
    };
    let played = suite::play_all(&orders, &root, requested.threads, requested.write.is_some(), done);
    say(&report(&played));
    say(&format!(
        "{} cases in {:.0} s on {} threads",
        orders.len(),
        started.elapsed().as_secs_f64(),
        requested.threads
    ));
    ExitCode::SUCCESS
}

fn line(order: &Order, outcome: &Result<Outcome, DayError>) -> String {
    let what = order.fault.map_or("no fault", |(fault, _)| fault.label);
    match outcome {
        Ok(Outcome::Answered(case)) => case.line(),
        Ok(Outcome::TooWeak) => format!("{:?} {what}: no lamp shows it as strong", order.kind),
        Ok(Outcome::Stopped(why)) => format!("{:?} {what}: the scan ended early: {why}", order.kind),
        Err(error) => format!("{:?} {what}: FAILED: {error}", order.kind),
    }
}

fn say(text: &str) {
    // Whoever closed the output wants no more of it.
    let _ = writeln!(std::io::stdout().lock(), "{text}");
}

fn requested(mut words: impl Iterator<Item = String>) -> Result<Options, String> {
    let mut requested = Options {
        wanted: Wanted::default(),
        cases: false,
        write: None,
        threads: std::thread::available_parallelism().map_or(2, std::num::NonZero::get),
    };
    while let Some(word) = words.next() {
        let mut value = || words.next().ok_or(format!("{word} wants a value"));
        let wanted = &mut requested.wanted;
        match word.as_str() {
            // What cargo gives every benchmark.
            "--bench" => {}
            "readings" => wanted.kind = Some(Kind::Readings),
            "maps" => wanted.kind = Some(Kind::Maps),
            "--faults" => wanted.faults = value()?.split(',').map(str::to_owned).collect(),
            "--sigma" => wanted.sigma = Some(number(&word, &value()?)?),
            "--seed" => wanted.seed = Some(number(&word, &value()?)?),
            "--share" => wanted.share = Some(number(&word, &value()?)?),
            "--threads" => requested.threads = number(&word, &value()?)?,
            "--grid" => wanted.grid = Some(one_of(&word, &value()?, Grid::ALL, Grid::name)?),
            "--lamp" => wanted.lamp = Some(one_of(&word, &value()?, Lamp::ALL, Lamp::name)?),
            "--cases" => requested.cases = true,
            "--write" => requested.write = Some(value()?.into()),
            _ => {
                return Err(format!(
                    "{word} is nothing that this program knows; its first lines say what it does"
                ));
            }
        }
    }
    Ok(requested)
}

fn number<T: std::str::FromStr>(word: &str, text: &str) -> Result<T, String> {
    text.parse()
        .map_err(|_| format!("{word} {text}: is no number of its kind"))
}

fn one_of<T: Copy>(word: &str, text: &str, all: [T; 3], name: fn(T) -> &'static str) -> Result<T, String> {
    let names = all.map(name);
    let found = all.into_iter().find(|one| name(*one) == text);
    found.ok_or(format!("{word} {text}: is none of {}", names.join(", ")))
}
