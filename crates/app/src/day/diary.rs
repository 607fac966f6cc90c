//! What a day adds to the diary of its bench: the dark reading of the lux meter, the reference reading, and of a lamp
//! with a sample number, which may be measured again, its flux and colour temperature.

use camino::Utf8Path;
use isolux_record::{Job, Quality, Reading, ReadingKind, Role, disk};
use isolux_reduce::Quantity;
use isolux_report::day::DayResults;

use crate::Failure;
use crate::files;
use crate::front_end::progress::{Event, Progress};
use crate::history::{self, Entry, Kind};

/// Adds them, and notes what is not in control then.
///
/// # Errors
/// Bad input (exit 2) where the diary cannot be read; exit 3 where it cannot be written.
pub(super) fn add(job: &Job, folder: &Utf8Path, day: &DayResults, progress: &dyn Progress) -> Result<(), Failure> {
    if day.reduction.partial.is_some() {
        return Ok(());
    }
    let record_sha256 = disk::sha256(&files::read(&folder.join("run.toml"))?);
    let header = &day.run.header;
    let entry = |kind: Kind, quantity: String, (value, u): (f64, f64), unit: &str| Entry {
        time_utc: header.started_utc.clone(),
        kind,
        quantity,
        value,
        unit: unit.to_owned(),
        u,
        run: folder.to_string(),
        record_sha256: record_sha256.clone(),
    };
    let mut entries = Vec::new();
    let rows = &day.run.readings.rows;
    if let Some(dark) = mean(rows.iter().filter(|row| row.kind == ReadingKind::Capped)) {
        entries.push(entry(Kind::Dark, "luxmeter: dark reading".to_owned(), dark, "lx"));
    }
    if let Some(lamp) = lamp(day) {
        let distance_mm = day.reduction.distance_mm;
        let visits = rows.iter().filter(|row| {
            row.role == Role::Reference && row.kind == ReadingKind::Lit && row.distance_mm == distance_mm
        });
        if let Some((mean_lx, noise_lx)) = mean(visits) {
            let per_lx = (distance_mm * 1e-3).powi(2);
            let u = noise_lx.hypot(mean_lx * header.station.luxmeter().u_rel);
            let reading = (per_lx * mean_lx, per_lx * u);
            entries.push(entry(
                Kind::Reference,
                format!("{lamp}: reference reading"),
                reading,
                "cd",
            ));
        }
        let mut checked = |what: &str, of: &Quantity, unit: &str| {
            let value = (of.value, of.u.unwrap_or(of.u_of_parts));
            entries.push(entry(Kind::LampCheck, format!("{lamp}: {what}"), value, unit));
        };
        checked("luminous flux", &day.reduction.flux, "lm");
        let spectral = day.reduction.spectral.as_ref();
        if let Some(cct) = spectral.and_then(|spectral| spectral.colour.cct.as_ref()) {
            checked("CCT", cct, "K");
        }
    }
    history::add(job.station(), &entries)?;
    let charts = history::judged(job.station())?;
    for chart in charts.iter().filter(|chart| chart.out_of_control) {
        let new = entries.iter().any(|entry| entry.quantity == chart.quantity);
        if new {
            progress.event(Event::Note(&format!("not in control: {}", chart.sentence)));
        }
    }
    Ok(())
}

/// Name and sample number of the luminaire; none without a sample number: another one of its kind is another lamp.
fn lamp(day: &DayResults) -> Option<String> {
    let luminaire = &day.run.header.luminaire;
    let sample = luminaire.sample.as_ref()?;
    let name = luminaire.name.as_deref().unwrap_or("luminaire");
    Some(format!("{name} {sample}"))
}

/// Mean and its standard uncertainty from the scatter, lx; none of fewer than two values.
fn mean<'a>(rows: impl Iterator<Item = &'a Reading>) -> Option<(f64, f64)> {
    let values: Vec<f64> = rows
        .filter(|row| row.quality == Quality::Ok)
        .filter_map(|row| row.illuminance_lx)
        .collect();
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (values.len() > 1).then(|| (mean, (squares / (n * (n - 1.0))).sqrt()))
}
