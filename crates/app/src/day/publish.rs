//! The report of a day as files. A report that was issued is not lost when it is made again: it is kept, and the next
//! one says what changed (ISO/IEC 17025, 7.8.8).

use std::collections::BTreeMap;

use camino::Utf8Path;
use isolux_record::disk::sha256;
use isolux_record::subject::REPORT_KEYS;
use isolux_report::day::{Amendment, amended, changes};
use isolux_report::document::Document;

use super::paper::renew_paper;
use crate::Failure;
use crate::files::{self, Overwrite};
use crate::front_end::progress::{Event, Progress};

/// The file of the amendments, and the folder of the reports that they replaced.
pub(crate) const AMENDMENTS: [&str; 2] = ["amendments.json", "amendments"];
/// Statements of the report.
pub(crate) const STATEMENTS: &str = "report.json";
/// What of a report is kept.
const KEPT: [&str; 3] = ["report.html", "report.pdf", STATEMENTS];

/// The amendments of the report in `results`.
///
/// # Errors
/// Bad input (exit 2) for a file that cannot be read.
pub(crate) fn amendments(results: &Utf8Path) -> Result<Vec<Amendment>, Failure> {
    let file = results.join(AMENDMENTS[0]);
    if file.is_file() {
        files::read_json(&file)
    } else {
        Ok(Vec::new())
    }
}

/// Writes page, statements, and the paper where there is one, into `results`. Where that replaces a report that was
/// issued or `reason` is given, and something of it changed, the report before is kept there.
///
/// # Errors
/// Exit 3 when the disk refuses; bad input (exit 2) when the files exist and may not be replaced, and for a reason
/// without a report that it amends or without a change.
pub(crate) fn publish(
    document: Document,
    results: &Utf8Path,
    page: &Utf8Path,
    reason: Option<&str>,
    overwrite: Overwrite,
    progress: &dyn Progress,
) -> Result<(), Failure> {
    files::refuse_existing(page, overwrite)?;
    let stated = document.statements();
    let mut all = amendments(results)?;
    if let Some(next) = next(&stated, results, all.len(), reason)? {
        let folder = results.join(&next.kept_in);
        for name in next.sha256.keys() {
            files::write(&folder.join(name), &files::read(&results.join(name))?, Overwrite::Force)?;
        }
        let note = format!("amendment {}: the report before is kept in {folder}", next.number);
        all.push(next);
        let text = serde_json::to_string_pretty(&all).map_err(Failure::instrument)? + "\n";
        files::write(&results.join(AMENDMENTS[0]), text.as_bytes(), Overwrite::Force)?;
        progress.event(Event::Note(&note));
    }
    let document = amended(document, &all);
    let text = serde_json::to_string_pretty(&stated).map_err(Failure::instrument)? + "\n";
    files::write(&results.join(STATEMENTS), text.as_bytes(), Overwrite::Force)?;
    files::write(page, document.html().as_bytes(), overwrite)?;
    renew_paper(&document, &page.with_extension("pdf"), overwrite, progress)
}

/// The amendment that the report of these statements is of the one in `results`; none where that was not issued and
/// nobody calls it one, or where nothing changed.
fn next(
    stated: &BTreeMap<String, String>,
    results: &Utf8Path,
    amended: usize,
    reason: Option<&str>,
) -> Result<Option<Amendment>, Failure> {
    let file = results.join(STATEMENTS);
    if !file.is_file() || !results.join(KEPT[0]).is_file() {
        return match reason {
            None => Ok(None),
            Some(_) => Err(Failure::bad_input(format!(
                "{results} has no report with its {STATEMENTS} that could be amended"
            ))
            .help("make the report without --amend")),
        };
    }
    let before: BTreeMap<String, String> = files::read_json(&file)?;
    let issued = REPORT_KEYS.iter().find(|key| key.name == "issued");
    let was_issued = before
        .keys()
        .any(|key| issued.is_some_and(|issued| key.ends_with(issued.what)));
    if reason.is_none() && !was_issued {
        return Ok(None);
    }
    let changed = changes(&before, stated);
    if changed.is_empty() {
        return match reason {
            None => Ok(None),
            Some(_) => Err(Failure::bad_input("nothing in the report would change").help("leave --amend out")),
        };
    }
    let there = KEPT.into_iter().filter(|name| results.join(name).is_file());
    let sums = there.map(|name| Ok((name.to_owned(), sha256(&files::read(&results.join(name))?))));
    Ok(Some(Amendment {
        number: amended + 1,
        reason: reason.map(str::to_owned),
        changed,
        kept_in: format!("{}/{amended}", AMENDMENTS[1]),
        sha256: sums.collect::<Result<_, Failure>>()?,
    }))
}
