//! What lies in a folder of work: jobs that can be started, run directories that can be shown.

use std::time::SystemTime;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_record::Job;

/// Names of the jobs in `folder`, by name. A file that is no job, or a wrong one, is left out.
pub fn jobs(folder: &Utf8Path) -> Vec<String> {
    let mut names: Vec<String> = entries(folder)
        .into_iter()
        .filter(|path| path.extension() == Some("toml") && Job::load(path).is_ok())
        .filter_map(|path| path.file_name().map(str::to_owned))
        .collect();
    names.sort();
    names
}

/// Names of the run directories in `folder`, the newest first; `folder` itself, where it is one, is called `.`.
pub fn runs(folder: &Utf8Path) -> Vec<String> {
    let itself = std::iter::once((".".to_owned(), folder.to_owned()));
    let below = entries(folder).into_iter();
    let below = below.filter_map(|path| Some((path.file_name()?.to_owned(), path)));
    let mut runs: Vec<(SystemTime, String)> = itself
        .chain(below)
        .filter_map(|(name, path)| {
            let written = std::fs::metadata(path.join("run.toml")).ok()?.modified().ok()?;
            Some((written, name))
        })
        .collect();
    runs.sort_by(|a, b| b.cmp(a));
    runs.into_iter().map(|(_, name)| name).collect()
}

/// Names of the files in `folder`, by name; none where there is no such folder.
pub fn files(folder: &Utf8Path) -> Vec<String> {
    let files = entries(folder).into_iter().filter(|path| path.is_file());
    let mut names: Vec<String> = files.filter_map(|path| path.file_name().map(str::to_owned)).collect();
    names.sort();
    names
}

/// Whether `name` is the name of something that lies in a folder, and no path that leads out of it.
pub fn is_name(name: &str) -> bool {
    let path = Utf8Path::new(name);
    // On Windows `a:b` is a second stream of the file `a`.
    let hidden = cfg!(windows) && name.contains(':');
    !name.is_empty() && path.file_name() == Some(name) && !name.starts_with('.') && !hidden
}

/// A name for a new run in `folder`: `day`, or the first of `day-2`, … that does not exist.
pub fn fresh(folder: &Utf8Path) -> String {
    let mut name = "day".to_owned();
    let mut number = 1;
    while folder.join(&name).exists() {
        number += 1;
        name = format!("day-{number}");
    }
    name
}

fn entries(folder: &Utf8Path) -> Vec<Utf8PathBuf> {
    let Ok(entries) = folder.read_dir_utf8() else {
        return Vec::new();
    };
    entries.flatten().map(camino::Utf8DirEntry::into_path).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_leads_nowhere_else() {
        for name in ["day", "day-2", "job.toml"] {
            assert!(is_name(name), "{name}");
        }
        for name in ["", ".", "..", "../day", "/etc", "a/b", "day/", ".lock"] {
            assert!(!is_name(name), "{name}");
        }
    }
}
