//! The report of a run that was reduced, as a page and on paper.

use camino::{Utf8Path, Utf8PathBuf};
use isolux_reduce::Reduction;
use isolux_report::day::document;
use isolux_report::document::Document;

use super::light::light;
use super::{requested, stored};
use crate::Failure;
use crate::files::{self, Overwrite};
use crate::front_end::progress::{Event, Progress};
use crate::modulation;
use crate::run::{record, reduce};

/// Writes the report of a run that was reduced, of the results that lie in its folder: `isolux report`, as one HTML
/// page or as PDF; without `out` beside those results. `job` is that of a day that does not hold its own. The report
/// of a scan that is not finished has `partial` in its name, which is returned. A page among the results takes the PDF
/// there with it (`renew_paper`).
///
/// # Errors
/// Bad input (exit 2) when there is no run, no result, or the file exists; when the results are not of this record;
/// when the day had a job that is not known.
pub fn report(
    folder: &Utf8Path,
    job: Option<&Utf8Path>,
    out: Option<&Utf8Path>,
    pdf: bool,
    overwrite: Overwrite,
    progress: &dyn Progress,
) -> Result<Utf8PathBuf, Failure> {
    let mut run = record::read_at_rest(folder)?;
    let requested::OfReport {
        scene,
        own_model,
        light_modulation,
        subject,
    } = requested::of_report(folder, job)?;
    run.header.state(&subject);
    let reduction = stored::reduction(folder, &run)?;
    let results = reduce::results_folder(folder, &reduction);
    let beside = |name: &str| named(&results.join(name), &reduction);
    let own = beside(if pdf { "report.pdf" } else { "report.html" });
    let paper_beside = (!pdf && out.is_none()).then(|| beside("report.pdf"));
    let out = out.map_or(own, |out| named(out, &reduction));
    files::refuse_existing(&out, overwrite)?;
    let mut day_results = light(&results, run, reduction, scene.as_deref(), progress)?;
    day_results.light_modulation = light_modulation.as_ref().map(modulation::of).transpose()?;
    stored::beside(folder, own_model, &mut day_results)?;
    let document = document(&day_results)?;
    if pdf {
        files::write(&out, &paper(&document, progress)?, overwrite)?;
        return Ok(out);
    }
    files::write(&out, document.html().as_bytes(), overwrite)?;
    if let Some(file) = paper_beside {
        renew_paper(&document, &file, overwrite, progress)?;
    }
    Ok(out)
}

/// Makes the PDF beside a page again, where there is one: it would be of other results than the page. Where it may not
/// be replaced and is another, this is said.
///
/// # Errors
/// Exit 3 when it cannot be made or written.
pub(super) fn renew_paper(
    document: &Document,
    file: &Utf8Path,
    overwrite: Overwrite,
    progress: &dyn Progress,
) -> Result<(), Failure> {
    if !file.is_file() {
        return Ok(());
    }
    let bytes = paper(document, progress)?;
    if files::read(file)? == bytes {
        return Ok(());
    }
    if overwrite == Overwrite::Never {
        let note = format!("{file} is not of these results, and --force was not given: it is left as it is");
        progress.event(Event::Note(&note));
        return Ok(());
    }
    files::write(file, &bytes, overwrite)
}

/// The report as PDF; names the characters that no font has.
pub(crate) fn paper(document: &Document, progress: &dyn Progress) -> Result<Vec<u8>, Failure> {
    let paper = document.pdf().map_err(Failure::instrument)?;
    if !paper.unknown.is_empty() {
        let letters: String = paper.unknown.iter().collect();
        let note = format!(
            "the PDF shows ? for {letters}: no font of this system has them; install one, or use the HTML report"
        );
        progress.event(Event::Note(&note));
    }
    Ok(paper.bytes)
}

/// The name of a report, with `partial` in it where the scan is not finished.
fn named(out: &Utf8Path, reduction: &Reduction) -> Utf8PathBuf {
    let name = out.file_name().unwrap_or("report.html");
    if reduction.partial.is_none() || name.contains("partial") {
        return out.to_owned();
    }
    out.with_file_name(isolux_reduce::file_name(reduction, name))
}
