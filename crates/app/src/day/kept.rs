//! A step that fails, even by a panic, costs nothing that was made before it.

use std::panic::{AssertUnwindSafe, catch_unwind};

use camino::Utf8Path;

use crate::Failure;

/// Carries out a step of the day; its failure, a panic among them, names the files of `results` that are made already.
///
/// # Errors
/// As `work`; exit 3 for a panic.
pub(super) fn step<T>(name: &str, results: &Utf8Path, work: impl FnOnce() -> Result<T, Failure>) -> Result<T, Failure> {
    // What `work` holds is dropped with it.
    let outcome = catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
        let words = panic.downcast_ref::<String>().map(String::as_str);
        let words = words.or_else(|| panic.downcast_ref::<&str>().copied());
        let words = words.unwrap_or("no message");
        Err(Failure::instrument(format!(
            "a fault of this program in the step {name}: {words}"
        )))
    });
    outcome.map_err(|mut failure| {
        let made = files(results);
        if !made.is_empty() {
            let help = failure.help.map_or_else(String::new, |help| format!("{help}; "));
            failure.help = Some(format!("{help}already made and kept in {results}: {}", made.join(", ")));
        }
        failure
    })
}

/// Names of the files in a folder, sorted.
fn files(folder: &Utf8Path) -> Vec<String> {
    let entries = folder.read_dir_utf8().into_iter().flatten().flatten();
    let mut names: Vec<String> = entries
        .filter(|entry| entry.path().is_file())
        .map(|entry| entry.file_name().to_owned())
        .collect();
    names.sort();
    names
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::FailureKind;

    #[test]
    fn a_panic_is_a_failure_that_names_what_is_kept() {
        let keep = tempfile::tempdir().unwrap();
        let results = Utf8Path::from_path(keep.path()).unwrap();
        for name in ["luminaire.ldt", "budget.json"] {
            std::fs::write(results.join(name), "made").unwrap();
        }
        let empty: Vec<u32> = Vec::new();
        let failure = step("diagnose", results, || Ok(empty[3])).unwrap_err();
        assert_eq!(failure.kind, FailureKind::Instrument);
        assert!(
            failure.message.contains("the step diagnose") && failure.message.contains("the index is 3"),
            "{failure}"
        );
        assert!(failure.help.unwrap().ends_with(": budget.json, luminaire.ldt"));
        let refused = step::<()>("reduce", results, || {
            Err(Failure::bad_input("no light").help("read again"))
        });
        let failure = refused.unwrap_err();
        assert_eq!(
            (failure.kind, failure.message.as_str()),
            (FailureKind::BadInput, "no light")
        );
        assert!(failure.help.unwrap().starts_with("read again; already made"));
    }
}
