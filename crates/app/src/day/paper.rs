//! Reports on paper.

use camino::Utf8Path;
use isolux_report::document::Document;

use crate::Failure;
use crate::files::{self, Overwrite};
use crate::front_end::progress::{Event, Progress};

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
    if let Some(why) = &paper.not_archival {
        progress.event(Event::Note(&format!("the PDF is not PDF/A-2a and PDF/UA-1: {why}")));
    }
    Ok(paper.bytes)
}
