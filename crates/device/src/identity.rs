//! Who answered.

/// What an instrument said of itself when it was opened. The run directory keeps it, and a resumed run refuses another.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Identity {
    /// Driver that speaks to it (`zaber`, `konica-t10a`, …).
    pub driver: &'static str,
    /// Where it was found, as the station file has it.
    pub target: String,
    /// Model as reported, or the family the language belongs to when the language has no word for it.
    pub model: String,
    /// Serial number as reported; `None` when the language cannot ask for it.
    pub serial: Option<String>,
    /// Firmware version as reported.
    pub firmware: Option<String>,
}
