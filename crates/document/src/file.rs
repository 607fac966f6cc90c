//! Whole files in memory: regular files alone, up to a stated size.
//!
//! A device or a pipe that is named where a file is meant has no end (`/dev/zero`) or gives its bytes once; both are
//! refused before they are opened, as opening a pipe without a writer waits for ever.

use std::fs::{File, FileType};
use std::io::{self, Read};

use camino::Utf8Path;

/// Most bytes of a document that a person writes, and of the files that it names: 64 MiB.
pub const LARGEST_DOCUMENT: u64 = 64 << 20;
/// Most bytes of a table of measured values: 4 GiB.
pub const LARGEST_TABLE: u64 = 4 << 30;

/// Why a file cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// The operating system refused.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// Something else that has a path.
    #[error("is {0}, not a regular file; save its content as a file and name that")]
    NotRegular(&'static str),
    /// More bytes than are taken.
    #[error("has {}; at most {limit} bytes are read, so this is another kind of file than is meant here",
        length.map_or("no end".to_owned(), |length| format!("{length} bytes")))]
    TooLarge {
        /// Its length, where the system states one.
        length: Option<u64>,
        /// The most bytes that are taken.
        limit: u64,
    },
}

/// All bytes of the regular file at `path`.
///
/// # Errors
/// [`FileError`]; nothing is read of a file whose length is above `limit`.
pub fn read(path: &Utf8Path, limit: u64) -> Result<Vec<u8>, FileError> {
    regular(std::fs::metadata(path)?.file_type())?;
    let file = File::open(path)?;
    let facts = file.metadata()?;
    // The path may name something else by now.
    regular(facts.file_type())?;
    let length = facts.len();
    if length > limit {
        return Err(FileError::TooLarge {
            length: Some(length),
            limit,
        });
    }
    let mut bytes = Vec::with_capacity(usize::try_from(length).unwrap_or(0));
    // Files of the kernel state a length of 0 and may have no end.
    file.take(limit + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit {
        return Err(FileError::TooLarge { length: None, limit });
    }
    Ok(bytes)
}

fn regular(kind: FileType) -> Result<(), FileError> {
    if kind.is_file() {
        Ok(())
    } else if kind.is_dir() {
        Err(FileError::NotRegular("a folder"))
    } else {
        Err(FileError::NotRegular("a device, pipe or socket"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_regular_files_up_to_the_limit_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let folder = Utf8Path::from_path(folder.path()).unwrap();
        let path = folder.join("a.csv");
        std::fs::write(&path, "12345").unwrap();
        assert_eq!(read(&path, 5).unwrap(), b"12345");
        let refused = read(&path, 4).unwrap_err().to_string();
        assert!(
            refused.contains("5 bytes") && refused.contains("at most 4"),
            "{refused}"
        );
        assert!(read(folder, 5).unwrap_err().to_string().contains("a folder"));
        assert!(matches!(read(&folder.join("b.csv"), 5), Err(FileError::Io(_))));
    }

    #[cfg(unix)]
    #[test]
    fn a_device_without_end_is_not_opened() {
        let refused = read(Utf8Path::new("/dev/zero"), LARGEST_DOCUMENT).unwrap_err();
        assert!(matches!(refused, FileError::NotRegular(_)), "{refused}");
    }
}
