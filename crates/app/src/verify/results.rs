//! A folder of results beside the hashes in its provenance.json and beside the results computed again.

use std::collections::{BTreeMap, BTreeSet};

use camino::Utf8Path;
use isolux_record::Run;
use isolux_record::disk::sha256;

use super::again::{self, Again};
use super::compare::{Outcome, Place, compare, first_difference};
use super::ledger::Ledger;
use super::provenance::{FILES, Provenance};
use crate::day::publish;
use crate::front_end::progress::Progress;
use crate::instruments::bench::PROGRAM;
use crate::{Failure, files};

/// The folders of results in a run, by name.
pub(super) fn folders(ledger: &Ledger) -> BTreeSet<String> {
    ledger
        .names()
        .filter_map(|name| name.rsplit_once('/'))
        .filter(|(_, file)| FILES.contains(file))
        .map(|(folder, _)| folder.to_owned())
        .collect()
}

/// Compares the results in `folder` of the run directory; the programs that made them, where that is known.
///
/// # Errors
/// Exit 3 when the disk refuses.
pub(super) fn check(
    path: &Utf8Path,
    run: Option<&Run>,
    folder: &str,
    ledger: &mut Ledger,
    progress: &dyn Progress,
) -> Result<Option<String>, Failure> {
    let results = path.join(folder);
    let in_run = |name: &str| format!("{folder}/{name}");
    let names: BTreeSet<String> = ledger
        .names()
        .filter_map(|name| name.strip_prefix(&format!("{folder}/")).map(str::to_owned))
        .collect();
    let file = FILES.into_iter().find(|name| names.contains(*name)).unwrap_or(FILES[0]);
    let provenance: Option<Provenance> = match files::read_json(&results.join(file)) {
        Ok(provenance) => Some(provenance),
        Err(failure) => {
            ledger.differs(&in_run(file), None, failure.message);
            None
        }
    };
    let mut inputs_are_whole = true;
    for (name, hash) in provenance.iter().flat_map(|provenance| &provenance.run.sha256) {
        if !name.starts_with(&format!("{}/", crate::run::reduce::REDUCED_WITH[0])) {
            continue;
        }
        if names.contains(name) && sha256(&files::read(&results.join(name))?) == *hash {
            ledger.agrees(&in_run(name), format!("its SHA-256 in {}", in_run(file)));
        } else {
            let changed = |other: &str| format!("does not agree with {other}; one of the two was changed");
            ledger.differs(&in_run(name), None, changed(&in_run(file)));
            ledger.differs(&in_run(file), None, changed(&in_run(name)));
            inputs_are_whole = false;
        }
    }
    let again = match (run, &provenance) {
        (Some(run), Some(provenance)) if inputs_are_whole => again::make(run, &results, file, provenance, progress)?,
        _ => Again::left_out("what it is made of differs from what was recorded, or cannot be read"),
    };
    let mut place = Place::of(&again.folder);
    let listed = provenance.as_ref().map(|provenance| &provenance.results_sha256);
    // A file of amendments that cannot be read speaks for nothing.
    let kept: BTreeMap<String, String> = publish::amendments(&results)
        .unwrap_or_default()
        .into_iter()
        .flat_map(|amendment| {
            let folder = amendment.kept_in;
            amendment
                .sha256
                .into_iter()
                .map(move |(name, sum)| (format!("{folder}/{name}"), sum))
        })
        .collect();
    for name in &names {
        let bytes = files::read(&results.join(name))?;
        if let Some(sum) = kept.get(name) {
            let list = in_run(publish::AMENDMENTS[0]);
            if *sum == sha256(&bytes) {
                ledger.agrees(&in_run(name), format!("its SHA-256 in {list}"));
            } else {
                ledger.differs(
                    &in_run(name),
                    None,
                    format!("is not the report that was replaced: {list} holds another SHA-256 of it"),
                );
            }
            continue;
        }
        let hash = listed
            .and_then(|listed| listed.get(name))
            .map(|hash| *hash == sha256(&bytes));
        one(
            &in_run(name),
            &bytes,
            hash,
            &again,
            name,
            &in_run(file),
            &mut place,
            ledger,
        );
    }
    let missing = listed
        .into_iter()
        .flat_map(BTreeMap::keys)
        .filter(|name| !names.contains(*name));
    for name in missing {
        ledger.differs(&in_run(name), None, format!("is missing: {} lists it", in_run(file)));
    }
    for name in again.made.keys().filter(|name| !names.contains(*name)) {
        if listed.is_none_or(|listed| !listed.contains_key(name)) {
            ledger.unchecked(&in_run(name), "is not there; the results of a day hold it");
        }
    }
    if let Some(then) = place
        .then()
        .filter(|then| Utf8Path::new(then).file_name() != again.folder.file_name())
    {
        let note = format!("the results in {folder} name the run `{then}`, as it was called when they were made");
        ledger.notes.push(note);
    }
    let program = provenance.map(|provenance| provenance.program);
    if let Some(program) = program.as_ref().filter(|program| *program != PROGRAM) {
        ledger.notes.push(format!(
            "{folder} was made by {program}: where {PROGRAM} computes or words something otherwise, its files differ"
        ));
    }
    Ok(program)
}

/// One file of the results: `hash` says whether it is the one that provenance.json lists.
fn one(
    in_run: &str,
    bytes: &[u8],
    hash: Option<bool>,
    again: &Again,
    name: &str,
    provenance: &str,
    place: &mut Place,
    ledger: &mut Ledger,
) {
    let listed = || format!("its SHA-256 in {provenance}");
    let Some(made) = again.made.get(name) else {
        let why = again.why_not(name);
        match hash {
            Some(true) => ledger.agrees(in_run, format!("{}; not computed again: {why}", listed())),
            Some(false) => ledger.differs(
                in_run,
                None,
                format!("is not the file that was written: {provenance} holds another SHA-256 of it"),
            ),
            None => ledger.unchecked(in_run, format!("not computed again: {why}")),
        }
        return;
    };
    let outcomes: Vec<Outcome> = made.iter().map(|made| compare(bytes, made, place)).collect();
    if outcomes.contains(&Outcome::Same) {
        ledger.agrees(in_run, "computed again: the same bytes");
        return;
    }
    let alike = outcomes.contains(&Outcome::Alike);
    if alike && hash == Some(true) {
        let because = format!(
            "{}; computed again: the same numbers to 1 in 10⁹, other last digits",
            listed()
        );
        ledger.agrees(in_run, because);
        return;
    }
    // Of two ways in which it can have been made, the one that goes along with it furthest.
    let furthest = outcomes.into_iter().max_by_key(|outcome| match outcome {
        Outcome::Differs { line, .. } => line.unwrap_or_default(),
        _ => u64::MAX,
    });
    let (line, mut what) = match furthest {
        Some(Outcome::Differs { line, what }) => (line, what),
        _ => first_difference(bytes, made.first().map_or(&[][..], Vec::as_slice), place),
    };
    if Utf8Path::new(name).extension() == Some("pdf") {
        what += "; it was changed, or made with the fonts of another computer or under another name of the run";
    }
    ledger.differs(in_run, line, what);
}
