//! A file with those that it names beside itself, read and parsed.

use camino::{Utf8Component, Utf8Path, Utf8PathBuf};
use isolux_formats::{Content, Finding, Opened, Parsed, ReadOptions, read_any_beside};

use super::source::OpenFile;
use crate::files;

/// The content of one file or pipe, refused before it is read when it is too large.
///
/// # Errors
/// A finding that says why there is nothing to parse.
pub fn read(path: &Utf8Path, options: ReadOptions) -> Result<Vec<Parsed<Content>>, Finding> {
    parsed(path, OpenFile::open(path)?, options)
}

/// As [`read`], of an open file.
///
/// # Errors
/// As [`read`].
pub fn parsed(path: &Utf8Path, source: OpenFile, options: ReadOptions) -> Result<Vec<Parsed<Content>>, Finding> {
    Ok(read_any_beside(
        &source.into_bytes(path)?,
        path.file_name().unwrap_or(path.as_str()),
        options,
        &|name| beside(path, name),
    ))
}

/// Largest file that another one may name: a tilt table has a few hundred numbers.
const LARGEST_BESIDE: u64 = 1024 * 1024;

/// The file `name` in the folder of `path` or below it; nothing outside that folder is opened, whatever a file says.
fn beside(path: &Utf8Path, name: &str) -> Result<Opened, String> {
    let relative = Utf8PathBuf::from(name.replace('\\', "/"));
    let inside = relative
        .components()
        .all(|part| matches!(part, Utf8Component::Normal(_) | Utf8Component::CurDir));
    if !inside || name.contains(':') {
        return Err(format!("{name} is not below the folder of the file itself"));
    }
    let folder = path
        .parent()
        .filter(|folder| !folder.as_str().is_empty())
        .unwrap_or(Utf8Path::new("."));
    let target = in_any_case(folder, &relative);
    let real = |path: &Utf8Path| path.canonicalize_utf8().map_err(|error| format!("{path}: {error}"));
    let (root, real) = (real(folder)?, real(&target)?);
    if !real.starts_with(&root) {
        return Err(format!("{target} leads out of the folder of the file itself"));
    }
    let facts = std::fs::metadata(&real).map_err(|error| format!("{target}: {error}"))?;
    if !facts.is_file() || facts.len() > LARGEST_BESIDE {
        return Err(format!("{target} is no file of at most {LARGEST_BESIDE} bytes"));
    }
    let bytes = files::read(&real).map_err(|failure| failure.message)?;
    Ok(Opened {
        path: target.into_string(),
        bytes,
    })
}

/// `relative` in `folder`; where no such name exists, the one that differs in case alone (names come from Windows).
fn in_any_case(folder: &Utf8Path, relative: &Utf8Path) -> Utf8PathBuf {
    let exact = folder.join(relative);
    let (Some(parent), Some(name)) = (exact.parent(), exact.file_name()) else {
        return exact;
    };
    if exact.exists() {
        return exact;
    }
    let mut same: Vec<Utf8PathBuf> = parent
        .read_dir_utf8()
        .into_iter()
        .flatten()
        .flatten()
        .filter(|entry| entry.file_name().eq_ignore_ascii_case(name))
        .map(|entry| entry.path().to_owned())
        .collect();
    if same.len() == 1 { same.remove(0) } else { exact }
}
