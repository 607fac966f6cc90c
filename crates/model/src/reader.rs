//! Reading a document and the files beside it: every fault has the line of its key.

use camino::{Utf8Path, Utf8PathBuf};
use isolux_record::document::{DocumentError, Fault, SourceText};
use isolux_spectrum::Spectrum;

use crate::photometric_file::read_spectrum;

/// The text that keys are checked against, so that every fault has its line.
pub(crate) struct Reader<'a> {
    pub source: SourceText<'a>,
}

impl Reader<'_> {
    pub fn fault(&self, path: &str, message: &str) -> DocumentError {
        self.source.locate(&Fault {
            path: path.to_owned(),
            message: message.to_owned(),
        })
    }

    pub fn within(&self, path: &str, value: f64, low: f64, high: f64) -> Result<(), DocumentError> {
        if (low..=high).contains(&value) {
            Ok(())
        } else {
            Err(self.fault(path, &format!("{value} is not within {low} to {high}")))
        }
    }

    pub fn path(&self, file: &str) -> Utf8PathBuf {
        self.source.file.parent().unwrap_or(Utf8Path::new("")).join(file)
    }

    /// The spectrum in `file`, which the key at `path` names.
    pub fn spectrum(&self, path: &str, file: &str) -> Result<Spectrum, DocumentError> {
        read_spectrum(&self.path(file)).map_err(|error| self.fault(path, &error.to_string()))
    }
}
