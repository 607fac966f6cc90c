//! Warning flags: what the device wants known.

/// A two-letter warning flag.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct WarningFlag([u8; 2]);

/// What a flag means for a measurement.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Nothing to act on.
    Note,
    /// Worth a line in the log; the position that the device reports is still true.
    Warning,
    /// The axis cannot move, or its position is not to be trusted (a stall, a limit met unexpectedly, no reference).
    Fault,
}

impl WarningFlag {
    /// Reads the two letters; `--` is no flag.
    pub fn parse(text: &str) -> Option<Self> {
        match text.as_bytes() {
            [a, b] if a.is_ascii_uppercase() && b.is_ascii_uppercase() => Some(Self([*a, *b])),
            _ => None,
        }
    }

    /// The letters.
    pub fn letters(&self) -> &str {
        std::str::from_utf8(&self.0).unwrap_or("??")
    }

    /// In words (Zaber ASCII Protocol Manual, "Warning Flags").
    pub fn meaning(&self) -> &'static str {
        match &self.0 {
            b"FF" => "critical system error",
            b"FN" => "peripheral not supported",
            b"FZ" => "inactive peripheral",
            b"FH" => "hardware emergency stop",
            b"FV" => "overvoltage or undervoltage, driver disabled",
            b"FO" => "driver disabled",
            b"FD" => "driver disabled by overcurrent",
            b"FC" => "current inrush error",
            b"FM" => "motor temperature error",
            b"FQ" => "encoder error",
            b"FT" => "excessive twist",
            b"FI" => "index error",
            b"FA" => "analog encoder sync error",
            b"FR" => "overdrive limit exceeded",
            b"FS" => "stalled and stopped",
            b"FB" => "stream bounds error",
            b"FP" => "interpolated path deviation",
            b"FE" => "limit error: the target is beyond a limit sensor",
            b"WL" => "unexpected limit trigger",
            b"WV" => "voltage out of range",
            b"WT" => "controller temperature high",
            b"WS" => "stalled with recovery",
            b"WM" => "displaced when stationary",
            b"WP" => "invalid calibration type",
            b"WR" => "no reference position",
            b"WH" => "device not homed",
            b"NC" => "manual control",
            b"NI" => "movement interrupted",
            b"NJ" => "joystick calibrating",
            b"ND" => "stream discontinuity",
            b"NR" => "value rounded",
            b"NT" => "value truncated",
            b"NU" => "setting update pending",
            _ => "flag unknown to this program",
        }
    }

    /// What it means for a measurement. An unknown `F` flag is a fault, an unknown `W` flag a warning.
    pub fn severity(&self) -> Severity {
        match &self.0 {
            [b'F', _] | b"WR" | b"WH" | b"WL" => Severity::Fault,
            [b'W', _] | b"NC" => Severity::Warning,
            _ => Severity::Note,
        }
    }

    /// The axis does not know where it is: home it.
    pub fn is_unreferenced(&self) -> bool {
        matches!(&self.0, b"WR" | b"WH")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_are_faults() {
        let severity = |text| WarningFlag::parse(text).map(|flag| flag.severity());
        assert_eq!(severity("--"), None);
        assert_eq!(severity("FS"), Some(Severity::Fault));
        assert_eq!(severity("WR"), Some(Severity::Fault));
        assert_eq!(severity("WM"), Some(Severity::Warning));
        assert_eq!(severity("NI"), Some(Severity::Note));
        assert_eq!(severity("FX"), Some(Severity::Fault), "an unknown fault is one");
        assert_eq!(WarningFlag::parse("FS").unwrap().meaning(), "stalled and stopped");
    }
}
