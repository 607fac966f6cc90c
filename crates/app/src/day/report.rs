//! The report of a run that was reduced, as a page and on paper.

use camino::{Utf8Path, Utf8PathBuf};
use isolux_reduce::Reduction;
use isolux_report::day::{DayResults, amended, document};
use isolux_report::document::Document;

use super::light::light;
use super::paper::paper;
use super::publish::{amendments, publish};
use super::{requested, stored};
use crate::Failure;
use crate::files::{self, Overwrite};
use crate::front_end::progress::Progress;
use crate::run::{record, reduce};

/// Writes the report of a run that was reduced, of the results that lie in its folder: `isolux report`, as one HTML
/// page or as PDF; without `out` beside those results. `job` is that of a day that does not hold its own. The report
/// of a scan that is not finished has `partial` in its name, which is returned. A page among the results takes the PDF
/// there with it (`renew_paper`); `amend` is why it replaces one that was issued (`publish`).
///
/// # Errors
/// Bad input (exit 2) when there is no run, no result, or the file exists; when the results are not of this record;
/// when the day had a job that is not known.
pub fn report(
    folder: &Utf8Path,
    job: Option<&Utf8Path>,
    out: Option<&Utf8Path>,
    pdf: bool,
    amend: Option<&str>,
    overwrite: Overwrite,
    progress: &dyn Progress,
) -> Result<Utf8PathBuf, Failure> {
    let (day_results, results) = of_results(folder, job, progress)?;
    let reduction = &day_results.reduction;
    let beside = |name: &str| named(&results.join(name), reduction);
    let own = beside(if pdf { "report.pdf" } else { "report.html" });
    let among_results = !pdf && out.is_none();
    let out = out.map_or(own, |out| named(out, reduction));
    files::refuse_existing(&out, overwrite)?;
    let document = document(&day_results)?;
    if among_results {
        publish(document, &results, &out, amend, overwrite, progress)?;
        return Ok(out);
    }
    let document = amended(document, &amendments(&results)?);
    if pdf {
        files::write(&out, &paper(&document, progress)?, overwrite)?;
        return Ok(out);
    }
    files::write(&out, document.html().as_bytes(), overwrite)?;
    Ok(out)
}

/// Writes the data sheet of a reduced run, as page or as PDF; without `out` beside its results.
///
/// # Errors
/// As [`report`].
pub fn data_sheet(
    folder: &Utf8Path,
    job: Option<&Utf8Path>,
    out: Option<&Utf8Path>,
    pdf: bool,
    overwrite: Overwrite,
    progress: &dyn Progress,
) -> Result<Utf8PathBuf, Failure> {
    let (day_results, results) = of_results(folder, job, progress)?;
    let name = if pdf { "data-sheet.pdf" } else { "data-sheet.html" };
    let out = out.map_or_else(|| results.join(name), Utf8Path::to_owned);
    let out = named(&out, &day_results.reduction);
    files::refuse_existing(&out, overwrite)?;
    let sheet = isolux_report::day::data_sheet(&day_results, &document(&day_results)?);
    let bytes = if pdf {
        paper(&sheet, progress)?
    } else {
        sheet.html().into_bytes()
    };
    files::write(&out, &bytes, overwrite)?;
    Ok(out)
}

/// Writes every figure of a report as SVG and PNG, and every table as CSV, into `out`; their number.
///
/// # Errors
/// As [`report`].
pub fn parts(
    folder: &Utf8Path,
    job: Option<&Utf8Path>,
    out: &Utf8Path,
    overwrite: Overwrite,
    progress: &dyn Progress,
) -> Result<usize, Failure> {
    let (day_results, _) = of_results(folder, job, progress)?;
    let parts = document(&day_results)?.parts().map_err(Failure::instrument)?;
    let pending = parts
        .iter()
        .map(|part| files::prepare(&out.join(&part.name), &part.bytes, overwrite))
        .collect::<Result<Vec<_>, _>>()?;
    files::publish(pending)?;
    Ok(parts.len())
}

/// The report of a reduced run as a document.
///
/// # Errors
/// As [`report`].
pub fn report_document(
    folder: &Utf8Path,
    job: Option<&Utf8Path>,
    progress: &dyn Progress,
) -> Result<Document, Failure> {
    document(&of_results(folder, job, progress)?.0).map_err(Failure::bad_input)
}

/// The results of a reduced run, and the folder where they lie.
fn of_results(
    folder: &Utf8Path,
    job: Option<&Utf8Path>,
    progress: &dyn Progress,
) -> Result<(DayResults, Utf8PathBuf), Failure> {
    let mut run = record::read_at_rest(folder)?;
    let requested = requested::of_report(folder, job)?;
    run.header.state(&requested.subject);
    let reduction = stored::reduction(folder, &run)?;
    let results = reduce::results_folder(folder, &reduction);
    let scene = requested.scene.as_deref();
    let mut day_results = light(&results, run, reduction, scene, &requested.wanted, progress)?;
    stored::beside(folder, requested.own_model, &mut day_results)?;
    Ok((day_results, results))
}

/// The name of a report, with `partial` in it where the scan is not finished.
fn named(out: &Utf8Path, reduction: &Reduction) -> Utf8PathBuf {
    let name = out.file_name().unwrap_or("report.html");
    if reduction.partial.is_none() || name.contains("partial") {
        return out.to_owned();
    }
    out.with_file_name(isolux_reduce::file_name(reduction, name))
}
