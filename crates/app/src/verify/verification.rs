//! What was found of a run, as `isolux verify --json` prints it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What `isolux verify --json` prints.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Verification {
    /// The run directory, as it was given.
    pub run: String,
    /// Name and version of the program that verified.
    pub verified_by: String,
    /// Name and version of the program that recorded the run; null where run.toml cannot be read.
    pub recorded_by: Option<String>,
    /// Name and version of the programs that made its results.
    pub reduced_by: Vec<String>,
    /// Whether no file differs, and the signature, where a key was given, is of this run and by that key.
    pub agrees: bool,
    /// Every file of the run, by name.
    pub files: Vec<FileVerdict>,
    /// The signature of SHA256SUMS; null where there is none.
    pub signature: Option<Signed>,
    /// What a person should know beside that.
    pub notes: Vec<String>,
}

/// What was found of one file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct FileVerdict {
    /// Its name in the run directory.
    pub name: String,
    /// What was found.
    pub state: State,
    /// What speaks for it; for a file that was not checked: why not.
    pub because: Vec<String>,
    /// What differs.
    pub differs: Vec<Difference>,
}

/// What was found of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum State {
    /// It is what was recorded or computed.
    Agrees,
    /// No checksum and no computation speaks for it.
    NotChecked,
    /// It is not.
    Differs,
}

/// What differs in a file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Difference {
    /// Its line, from 1; null where it is not known.
    pub line: Option<u64>,
    /// What, in a sentence.
    pub what: String,
}

impl Verification {
    /// The files of one state.
    pub fn of(&self, state: State) -> impl Iterator<Item = &FileVerdict> {
        self.files.iter().filter(move |file| file.state == state)
    }
}

/// A signature as it was found.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Signed {
    /// Number of the key, in hexadecimal digits.
    pub key: String,
    /// Its trusted comment, which is signed too; read from the file, and proved by the signature alone.
    pub comment: String,
    /// Whether it is of this list and by the public key that was given; false where none was given.
    pub by_this_key: bool,
}
