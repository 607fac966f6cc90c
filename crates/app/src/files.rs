//! Results reach the disk whole or not at all.

use std::io::ErrorKind;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_record::disk::{self, DiskError, Pending};
use isolux_record::file;
use serde::de::DeserializeOwned;

use crate::Failure;

/// Whether an existing file may be replaced (`--force`).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Overwrite {
    /// Refuse when the target exists.
    Never,
    /// Replace it.
    Force,
}

impl Overwrite {
    /// What the flag `--force` asks for.
    #[must_use]
    pub const fn requested(force: bool) -> Self {
        if force { Self::Force } else { Self::Never }
    }
}

/// The whole regular file at `path`.
///
/// # Errors
/// Bad input (exit 2) when it is not there, is no regular file, has more than [`file::LARGEST_TABLE`] bytes or cannot
/// be read.
pub fn read(path: &Utf8Path) -> Result<Vec<u8>, Failure> {
    file::read(path, file::LARGEST_TABLE).map_err(|error| Failure::bad_input(format!("{path}: {error}")))
}

/// The JSON file at `path`, as the type that it was written from.
///
/// # Errors
/// As [`read`], and for what is no such document.
pub fn read_json<T: DeserializeOwned>(path: &Utf8Path) -> Result<T, Failure> {
    serde_json::from_slice(&read(path)?).map_err(|error| Failure::bad_input(format!("{path}: {error}")))
}

/// A path as a document names it: with `/`, which Windows reads too, so that a document written there can be read
/// elsewhere. On other systems a `\\` is part of a name and stays.
pub(crate) fn in_document(path: &Utf8Path) -> String {
    #[cfg(windows)]
    return with_slashes(path.as_str());
    #[cfg(not(windows))]
    path.as_str().to_owned()
}

/// A path of Windows with `/`, without the prefix of a canonical path, in which a `/` would be part of a name.
#[cfg(any(windows, test))]
fn with_slashes(path: &str) -> String {
    match (path.strip_prefix(r"\\?\UNC\"), path.strip_prefix(r"\\?\")) {
        (Some(share), _) => format!(r"\\{share}"),
        (None, Some(local)) => local.to_owned(),
        (None, None) => path.to_owned(),
    }
    .replace('\\', "/")
}

/// Writes `bytes` to `path` through a temporary file beside it and a rename, so that no reader ever sees a part.
///
/// # Errors
/// Bad input (exit 2) when the target exists and `overwrite` is [`Overwrite::Never`]; exit 3 when the disk refuses.
pub fn write(path: &Utf8Path, bytes: &[u8], overwrite: Overwrite) -> Result<(), Failure> {
    publish(vec![prepare(path, bytes, overwrite)?])
}

/// Removes a file, if it is there.
///
/// # Errors
/// Exit 3 when the disk refuses.
pub fn remove(path: &Utf8Path) -> Result<(), Failure> {
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != ErrorKind::NotFound => {
            Err(Failure::instrument(format!("{path} cannot be removed: {error}")))
        }
        _ => Ok(()),
    }
}

/// Writes and syncs `bytes` under a temporary name beside `path`, which they get from [`publish`].
///
/// # Errors
/// As [`write()`].
pub fn prepare(path: &Utf8Path, bytes: &[u8], overwrite: Overwrite) -> Result<Pending, Failure> {
    refuse_existing(path, overwrite)?;
    let failed = |error: DiskError| unwritten(path, &error);
    if let Some(folder) = path.parent().filter(|folder| !folder.as_str().is_empty()) {
        disk::create_folder(folder).map_err(failed)?;
    }
    disk::prepare(path, bytes).map_err(failed)
}

/// Gives files their names, the last one when the others are safe on the disk.
///
/// # Errors
/// Exit 3 when the disk refuses; files that had their turn before have their names.
pub fn publish(files: Vec<Pending>) -> Result<(), Failure> {
    disk::publish(files).map_err(|error| unwritten(&error.path, &error))
}

fn unwritten(path: &Utf8Path, error: &DiskError) -> Failure {
    Failure::instrument(format!("{path}: cannot write: {}", error.source))
}

/// Fails when `path` exists and must not be replaced: called before long work, so that nobody waits for a refusal.
///
/// # Errors
/// Bad input (exit 2).
pub fn refuse_existing(path: &Utf8Path, overwrite: Overwrite) -> Result<(), Failure> {
    if overwrite == Overwrite::Never && path.exists() {
        return Err(
            Failure::bad_input(format!("{path} exists")).help("choose another name, or give --force to replace it")
        );
    }
    Ok(())
}

/// The output folder of a command, created; refused as by [`refuse_occupied`].
///
/// # Errors
/// Bad input (exit 2) when it is a file or not empty; exit 3 when it cannot be made.
pub fn output_folder(path: &Utf8Path, overwrite: Overwrite) -> Result<Utf8PathBuf, Failure> {
    refuse_occupied(path, overwrite)?;
    std::fs::create_dir_all(path).map_err(|error| Failure::instrument(format!("{path}: {error}")))?;
    Ok(path.to_owned())
}

/// Fails when the folder `path` already holds something and may not be overwritten: called before long work, as
/// [`refuse_existing`] is.
///
/// # Errors
/// Bad input (exit 2) when it is a file or not empty.
pub fn refuse_occupied(path: &Utf8Path, overwrite: Overwrite) -> Result<(), Failure> {
    if path.is_file() {
        return Err(Failure::bad_input(format!("{path} is a file, not a folder")));
    }
    let occupied = std::fs::read_dir(path).is_ok_and(|mut entries| entries.next().is_some());
    if occupied && overwrite == Overwrite::Never {
        return Err(Failure::bad_input(format!("{path} is not empty"))
            .help("choose another folder, or give --force to replace its files"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_of_windows_is_written_so_that_every_system_reads_it() {
        for (path, written) in [
            (r"sub\plan.toml", "sub/plan.toml"),
            (r"C:\lab\station.toml", "C:/lab/station.toml"),
            (r"\\?\C:\lab\station.toml", "C:/lab/station.toml"),
            (r"\\?\UNC\server\lab\station.toml", "//server/lab/station.toml"),
            ("sub/plan.toml", "sub/plan.toml"),
        ] {
            assert_eq!(with_slashes(path), written);
        }
    }

    #[test]
    fn prepared_files_have_their_names_together_or_leave_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| Utf8PathBuf::try_from(folder.path().join(name)).unwrap();
        let names = || {
            let entries = std::fs::read_dir(folder.path()).unwrap();
            let mut names: Vec<_> = entries.map(|entry| entry.unwrap().file_name()).collect();
            names.sort();
            names
        };
        std::fs::write(path("a"), b"old").unwrap();
        assert!(prepare(&path("a"), b"new", Overwrite::Never).is_err());
        drop(prepare(&path("a"), b"new", Overwrite::Force).unwrap());
        assert!(names() == ["a"] && read(&path("a")).unwrap() == b"old");
        let files = ["a", "b"].map(|name| prepare(&path(name), name.as_bytes(), Overwrite::Force).unwrap());
        assert_eq!(
            read(&path("a")).unwrap(),
            b"old",
            "a file keeps its content until all are on the disk"
        );
        publish(files.into()).unwrap();
        assert_eq!(names(), ["a", "b"]);
        assert!(read(&path("a")).unwrap() == b"a" && read(&path("b")).unwrap() == b"b");
        // The second name belongs to a folder: the third file is not published.
        std::fs::create_dir(path("c")).unwrap();
        let files = ["b", "c", "d"].map(|name| prepare(&path(name), b"later", Overwrite::Force).unwrap());
        assert!(publish(files.into()).is_err());
        assert!(names() == ["a", "b", "c"] && read(&path("b")).unwrap() == b"later");
    }

    #[test]
    fn writes_whole_and_refuses_to_replace() {
        let folder = tempfile::tempdir().unwrap();
        let path = Utf8PathBuf::try_from(folder.path().join("a/b.txt")).unwrap();
        write(&path, b"one", Overwrite::Never).unwrap();
        let refused = write(&path, b"two", Overwrite::Never).unwrap_err();
        assert_eq!(refused.kind, crate::FailureKind::BadInput);
        assert_eq!(read(&path).unwrap(), b"one");
        write(&path, b"two", Overwrite::Force).unwrap();
        assert_eq!(read(&path).unwrap(), b"two");
        assert_eq!(
            std::fs::read_dir(path.parent().unwrap()).unwrap().count(),
            1,
            "no temporary file is left"
        );
    }
}
