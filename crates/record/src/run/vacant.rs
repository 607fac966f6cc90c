//! Whether a run can begin in a folder.

use camino::Utf8Path;

use crate::readings::Layout;
use crate::run_lock::LOCK_FILE;

/// Whether a run can begin in `path`: it is not there, is empty, or holds nothing but what [`RunDir::create`](super::RunDir::create) writes
/// before run.toml, left by a program that was killed.
pub fn vacant(path: &Utf8Path) -> bool {
    if !path.exists() {
        return true;
    }
    let Ok(entries) = path.read_dir_utf8() else {
        return false;
    };
    entries.into_iter().all(|entry| {
        let Ok(entry) = entry else { return false };
        let file = entry.path();
        let name = entry.file_name();
        let only = |bytes: &[&[u8]]| std::fs::read(file).is_ok_and(|found| bytes.contains(&found.as_slice()));
        match name {
            "spectra" => file.read_dir_utf8().is_ok_and(|mut entries| entries.next().is_none()),
            "readings.csv" => {
                let headers = Layout::ALL.map(Layout::header);
                only(&[b"".as_slice()]) || headers.iter().any(|header| only(&[header.as_bytes()]))
            }
            "events.jsonl" => only(&[b""]),
            LOCK_FILE => true,
            _ => name.starts_with('.') && file.extension() == Some("part"),
        }
    })
}
