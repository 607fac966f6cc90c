//! Files and folders that outlive a loss of power: what is created or renamed is synced, and so is the folder that
//! names it.

use std::collections::BTreeSet;
use std::fs::{File, OpenOptions};
use std::io::{self, Write};

use camino::{Utf8Path, Utf8PathBuf};
use sha2::{Digest as _, Sha256};

/// What the system refused, and where.
#[derive(Debug, thiserror::Error)]
#[error("{path}: cannot {action}: {source}")]
pub struct DiskError {
    /// The file or folder.
    pub path: Utf8PathBuf,
    /// What was tried.
    pub action: &'static str,
    /// What the system said.
    pub source: io::Error,
}

/// SHA-256 of `bytes` in hexadecimal.
pub fn sha256(bytes: &[u8]) -> String {
    hex::encode(Sha256::digest(bytes))
}

/// Line ends in `bytes`.
pub(crate) fn lines(bytes: &[u8]) -> u64 {
    bytes.split(|byte| *byte == b'\n').count() as u64 - 1
}

/// Writes `path` whole or not at all: a temporary file beside it, synced, renamed, its folder synced.
///
/// # Errors
/// [`DiskError`]; the file that was there before is still there, and no temporary file is left.
pub fn replace(path: &Utf8Path, bytes: &[u8]) -> Result<(), DiskError> {
    publish(vec![prepare(path, bytes)?])
}

/// A file that is on the disk whole, under a temporary name that goes with it unless it is [published](publish).
#[derive(Debug)]
pub struct Pending {
    path: Utf8PathBuf,
    part: Utf8PathBuf,
}

impl Drop for Pending {
    fn drop(&mut self) {
        // What was published has no such name any more.
        let _ = std::fs::remove_file(&self.part);
    }
}

/// Writes and syncs `bytes` under a temporary name beside `path`, which they get from [`publish`]. Several files can be
/// synced at a time, which takes a disk hardly longer than one.
///
/// # Errors
/// [`DiskError`]; no temporary file is left.
pub fn prepare(path: &Utf8Path, bytes: &[u8]) -> Result<Pending, DiskError> {
    let name = path.file_name().unwrap_or("file");
    let pending = Pending {
        path: path.to_owned(),
        part: parent(path).join(format!(".{name}.{}.part", std::process::id())),
    };
    let part = &pending.part;
    let mut file = File::create(part).map_err(failed(part, "write"))?;
    file.write_all(bytes).map_err(failed(part, "write"))?;
    file.sync_all().map_err(failed(part, "sync"))?;
    Ok(pending)
}

/// Gives files their names, one after the other. The last one gets its name when the others are safe on the disk: who
/// sees it sees all, also after a loss of power.
///
/// # Errors
/// [`DiskError`]; files that had their turn before have their names, and no temporary file is left.
pub fn publish(mut files: Vec<Pending>) -> Result<(), DiskError> {
    let last = files.split_off(files.len().saturating_sub(1));
    [files, last].into_iter().try_for_each(|files| {
        let mut folders = BTreeSet::new();
        for file in files {
            std::fs::rename(&file.part, &file.path).map_err(failed(&file.path, "replace"))?;
            folders.insert(parent(&file.path));
        }
        folders.iter().try_for_each(|folder| sync_folder(folder))
    })
}

/// Removes what programs that were killed while they wrote have left in a folder and those in it under temporary names.
/// Only for a folder that this process alone writes.
///
/// # Errors
/// [`DiskError`].
pub fn remove_unpublished(folder: &Utf8Path) -> Result<(), DiskError> {
    for entry in folder.read_dir_utf8().map_err(failed(folder, "list"))? {
        let entry = entry.map_err(failed(folder, "list"))?;
        let (path, kind) = (entry.path(), entry.file_type().map_err(failed(folder, "list"))?);
        if kind.is_dir() {
            remove_unpublished(path)?;
        } else if kind.is_file() && is_temporary(entry.file_name()) {
            std::fs::remove_file(path).map_err(failed(path, "remove"))?;
        }
    }
    Ok(())
}

/// Whether [`prepare`] gives such a name.
fn is_temporary(name: &str) -> bool {
    let inner = name.strip_prefix('.').and_then(|name| name.strip_suffix(".part"));
    let process = inner
        .and_then(|inner| inner.rsplit_once('.'))
        .map(|(_, process)| process);
    process.is_some_and(|process| process.parse::<u32>().is_ok())
}

/// Creates a folder with all that lead to it, each synced in the folder that holds it.
///
/// # Errors
/// [`DiskError`].
pub fn create_folder(path: &Utf8Path) -> Result<(), DiskError> {
    let missing: Vec<&Utf8Path> = path
        .ancestors()
        .take_while(|folder| !folder.as_str().is_empty() && !folder.exists())
        .collect();
    std::fs::create_dir_all(path).map_err(failed(path, "make the folder"))?;
    missing
        .into_iter()
        .rev()
        .try_for_each(|folder| sync_folder(&parent(folder)))
}

/// Syncs the names in a folder: a file that was created or renamed is not found after a loss of power before this.
///
/// # Errors
/// [`DiskError`].
pub fn sync_folder(folder: &Utf8Path) -> Result<(), DiskError> {
    // Only Unix can sync a folder; elsewhere the file system keeps its own journal of names.
    #[cfg(unix)]
    File::open(folder)
        .and_then(|opened| opened.sync_all())
        .map_err(failed(folder, "sync"))?;
    #[cfg(not(unix))]
    let _ = folder;
    Ok(())
}

/// A file that only grows, with the SHA-256 of what was written to it.
#[derive(Debug)]
pub(crate) struct Appended {
    path: Utf8PathBuf,
    file: File,
    /// Bytes that are known to be written, and synced where the file is.
    bytes: u64,
    hash: Sha256,
    /// A write or sync failed: what the disk holds behind `bytes` is unknown.
    broken: bool,
    sync: fn(&File) -> io::Result<()>,
}

impl Appended {
    /// Opens `path`, which holds `already` and nothing else, or is made.
    pub(crate) fn open(path: &Utf8Path, already: &[u8]) -> Result<Self, DiskError> {
        let file = OpenOptions::new()
            .create(true)
            .append(true)
            .open(path)
            .map_err(failed(path, "open"))?;
        Ok(Self {
            path: path.to_owned(),
            file,
            bytes: already.len() as u64,
            hash: Sha256::new_with_prefix(already),
            broken: false,
            sync: File::sync_data,
        })
    }

    /// Appends without waiting for the disk.
    pub(crate) fn write(&mut self, bytes: &[u8]) -> Result<(), DiskError> {
        if self.broken {
            let source = io::Error::other("an earlier row could not be written; resume the run");
            return Err(failed(&self.path, "write")(source));
        }
        if let Err(source) = self.file.write_all(bytes) {
            return Err(self.give_up("write", source));
        }
        self.bytes += bytes.len() as u64;
        self.hash.update(bytes);
        Ok(())
    }

    /// Appends and waits until the disk has it. After a failure the file is cut to what it held before, as far as the
    /// disk still obeys, and takes no more: which bytes of a failed sync are on the disk cannot be known, whatever a
    /// reader sees.
    pub(crate) fn write_synced(&mut self, bytes: &[u8]) -> Result<(), DiskError> {
        let before = (self.bytes, self.hash.clone());
        self.write(bytes)?;
        if let Err(source) = (self.sync)(&self.file) {
            (self.bytes, self.hash) = before;
            return Err(self.give_up("sync", source));
        }
        Ok(())
    }

    pub(crate) fn sync(&self) -> Result<(), DiskError> {
        self.file.sync_all().map_err(failed(&self.path, "sync"))
    }

    /// SHA-256 of everything that was written.
    pub(crate) fn sha256(&self) -> String {
        hex::encode(self.hash.clone().finalize())
    }

    fn give_up(&mut self, action: &'static str, source: io::Error) -> DiskError {
        self.broken = true;
        let _ = self.file.set_len(self.bytes).and_then(|()| self.file.sync_all());
        failed(&self.path, action)(source)
    }

    #[cfg(test)]
    pub(crate) fn fail_to_sync(&mut self) {
        self.sync = |_| Err(io::Error::other("the disk does not answer"));
    }
}

pub(crate) fn failed<'a>(path: &'a Utf8Path, action: &'static str) -> impl Fn(io::Error) -> DiskError + 'a {
    move |source| DiskError {
        path: path.to_owned(),
        action,
        source,
    }
}

fn parent(path: &Utf8Path) -> Utf8PathBuf {
    match path.parent() {
        Some(folder) if !folder.as_str().is_empty() => folder.to_owned(),
        _ => Utf8PathBuf::from("."),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_killed_program_left_unpublished_is_removed_and_nothing_else() {
        let keep = tempfile::tempdir().unwrap();
        let folder = Utf8Path::from_path(keep.path()).unwrap();
        create_folder(&folder.join("results")).unwrap();
        let kept = [".part", ".notes.part", "a.17.part", "run.toml", "results/.17.partial"];
        let left = [".run.toml.4711.part", "results/.budget.json.12.part"];
        for name in kept.iter().chain(&left) {
            std::fs::write(folder.join(name), "").unwrap();
        }
        remove_unpublished(folder).unwrap();
        assert!(kept.iter().all(|name| folder.join(name).exists()));
        assert!(left.iter().all(|name| !folder.join(name).exists()));
    }

    #[test]
    fn a_row_whose_sync_failed_is_cut_off_and_nothing_follows_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = Utf8PathBuf::try_from(folder.path().join("rows")).unwrap();
        let mut file = Appended::open(&path, b"").unwrap();
        file.write_synced(b"one\n").unwrap();
        file.fail_to_sync();
        assert!(file.write_synced(b"two\n").is_err());
        file.sync = File::sync_data;
        assert!(
            file.write_synced(b"three\n").is_err(),
            "nothing follows a row that is not known"
        );
        assert_eq!(std::fs::read(&path).unwrap(), b"one\n");
        assert_eq!(file.sha256(), sha256(b"one\n"));
    }

    #[test]
    fn folders_are_made_and_files_replaced_whole() {
        let keep = tempfile::tempdir().unwrap();
        let folder = Utf8PathBuf::try_from(keep.path().join("a/b")).unwrap();
        create_folder(&folder).unwrap();
        let file = folder.join("c.txt");
        replace(&file, b"1").unwrap();
        replace(&file, b"22").unwrap();
        assert_eq!(std::fs::read(&file).unwrap(), b"22");
        assert!(replace(&folder, b"a folder is there").is_err());
        assert_eq!(
            std::fs::read_dir(&folder).unwrap().count(),
            1,
            "no temporary file is left"
        );
    }
}
