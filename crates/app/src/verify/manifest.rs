//! `SHA256SUMS` of a run: every file with its SHA-256, as `sha256sum --check` reads it. It is what a signature signs.

use camino::Utf8Path;
use isolux_record::disk::sha256;

use super::ledger::{Ledger, SIGNATURE, is_list, names};
use crate::Failure;
use crate::files::{self, Overwrite};
use crate::run::record::{self, SUMS};

/// Writes the list of the run's files; its bytes.
///
/// # Errors
/// Exit 3 when the disk refuses.
pub(super) fn write(run: &Utf8Path) -> Result<Vec<u8>, Failure> {
    let mut kept = Vec::new();
    for name in names(run)?.into_iter().filter(|name| !is_list(name)) {
        let bytes = files::read(&run.join(&name))?;
        kept.push((name, bytes));
    }
    let text = record::sums(kept.iter().map(|(name, bytes)| (name.as_str(), bytes.as_slice())));
    files::write(&run.join(SUMS), text.as_bytes(), Overwrite::Force)?;
    Ok(text.into_bytes())
}

/// Compares the files with the list, where there is one. `signed`: a signature says that the list is the one that was
/// written.
///
/// # Errors
/// Bad input (exit 2) for a file that cannot be read.
pub(super) fn check(run: &Utf8Path, signed: bool, ledger: &mut Ledger) -> Result<(), Failure> {
    let file = run.join(SUMS);
    if !file.is_file() {
        return Ok(());
    }
    let because = if signed {
        "its SHA-256 in the signed SHA256SUMS"
    } else {
        "its SHA-256 in SHA256SUMS"
    };
    let text = String::from_utf8_lossy(&files::read(&file)?).into_owned();
    let mut listed = Vec::new();
    for (line, row) in (1..).zip(text.lines()) {
        let Some((hash, name)) = row.split_once("  ").filter(|(hash, _)| hash.len() == 64) else {
            ledger.differs(SUMS, Some(line), "is not a SHA-256 and a name");
            continue;
        };
        listed.push(name.to_owned());
        let path = run.join(name);
        if !path.is_file() {
            ledger.differs(name, None, format!("is missing: line {line} of SHA256SUMS lists it"));
        } else if sha256(&files::read(&path)?) == hash {
            ledger.agrees(name, because);
        } else {
            let also = if signed { "" } else { "; one of the two was changed" };
            let otherwise = ledger.is_sound(name);
            ledger.differs(
                name,
                None,
                format!("is not the file of line {line} of SHA256SUMS{also}"),
            );
            if otherwise && !signed {
                ledger.differs(
                    SUMS,
                    Some(line),
                    format!("is not the SHA-256 of {name}; one of the two was changed"),
                );
            }
        }
    }
    let later: Vec<String> = ledger
        .names()
        .filter(|name| !is_list(name) && !listed.iter().any(|listed| listed == name))
        .map(str::to_owned)
        .collect();
    if !later.is_empty() {
        ledger
            .notes
            .push(format!("not in SHA256SUMS, and so not signed: {}", later.join(", ")));
    }
    if !signed {
        let why = if run.join(SIGNATURE).is_file() {
            "its signature was not checked"
        } else {
            "nothing signs it"
        };
        ledger.unchecked(SUMS, format!("{why}; its lines were compared with the files"));
    }
    Ok(())
}
