//! A file or pipe that is opened once: what its first bytes say is not lost for whoever reads on.

use std::fs::File;
use std::io::{self, Chain, Cursor, Read};

use camino::Utf8Path;
use isolux_formats::{Finding, LARGEST_FILE};

/// As many bytes as tell a ray file from all others.
const HEAD: u64 = 4;

/// The bytes of a file from its first on; a pipe gives them once, so nothing here opens or rewinds a second time.
pub(super) struct OpenFile {
    head: Vec<u8>,
    stream: Chain<Cursor<Vec<u8>>, File>,
    /// None where only the end will tell: a pipe, a terminal.
    length: Option<u64>,
}

impl OpenFile {
    /// Opens `path` and looks at its beginning.
    ///
    /// # Errors
    /// The finding `file-unreadable`.
    pub fn open(path: &Utf8Path) -> Result<Self, Finding> {
        let opened = || {
            let mut file = File::open(path)?;
            let facts = file.metadata()?;
            let mut head = Vec::new();
            (&mut file).take(HEAD).read_to_end(&mut head)?;
            Ok(Self {
                stream: Cursor::new(head.clone()).chain(file),
                head,
                length: facts.is_file().then_some(facts.len()),
            })
        };
        opened().map_err(|error| unreadable(path, &error))
    }

    /// Whether the file begins with `mark`, of [`HEAD`] bytes at most.
    pub fn begins_with(&self, mark: &[u8]) -> bool {
        self.head.starts_with(mark)
    }

    /// Size in bytes, where it is known before the end.
    pub fn length(&self) -> Option<u64> {
        self.length
    }

    /// All bytes.
    ///
    /// # Errors
    /// A finding: more than [`LARGEST_FILE`] bytes, or the reading fails.
    pub fn into_bytes(self, path: &Utf8Path) -> Result<Vec<u8>, Finding> {
        let largest = LARGEST_FILE as u64;
        if let Some(length) = self.length.filter(|length| *length > largest) {
            return Err(too_large(&format!("the file has {length} bytes")));
        }
        let mut bytes = Vec::new();
        self.stream
            .take(largest + 1)
            .read_to_end(&mut bytes)
            .map_err(|error| unreadable(path, &error))?;
        if bytes.len() > LARGEST_FILE {
            return Err(too_large("there is no end"));
        }
        Ok(bytes)
    }
}

impl Read for OpenFile {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        self.stream.read(into)
    }
}

fn unreadable(path: &Utf8Path, error: &io::Error) -> Finding {
    Finding::error("file-unreadable", format!("{path}: {error}"))
}

fn too_large(what: &str) -> Finding {
    Finding::error(
        "file-too-large",
        format!("{what}; more than {LARGEST_FILE} are not read"),
    )
    .fix("check that this is a photometric file")
}
