//! What ties an instrument of a station to its calibration: certificate, day, next day.

use super::{Station, StationDocument};
use crate::document::Fault;

/// What a station states of the calibration of an instrument. Days are YYYY-MM-DD.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Traceability<'a> {
    /// Number of the certificate.
    pub certificate: Option<&'a str>,
    /// Day of the calibration.
    pub calibrated: Option<&'a str>,
    /// Day the calibration is due again.
    pub due: Option<&'a str>,
}

impl Traceability<'_> {
    /// Whether the calibration was due before `day`, YYYY-MM-DD.
    pub fn overdue(&self, day: &str) -> bool {
        self.due.is_some_and(|due| due < day)
    }

    /// That the days are days, in their order.
    pub(super) fn check(&self, table: &str) -> Result<(), Fault> {
        for (key, day) in [("calibrated", self.calibrated), ("due", self.due)] {
            if let Some(day) = day.filter(|day| !is_day(day)) {
                return Err(Fault::new(
                    format!("{table}.{key}"),
                    format!("`{day}` is no day, write YYYY-MM-DD"),
                ));
            }
        }
        match (self.calibrated, self.due) {
            (Some(calibrated), Some(due)) if due < calibrated => Err(Fault::new(
                format!("{table}.due"),
                format!("{due} is before the calibration of {calibrated}"),
            )),
            _ => Ok(()),
        }
    }
}

impl Station {
    /// What is stated of the instrument with this part; none for one that is not there, and for what measures nothing
    /// that is calibrated (lamp, shutter, baffle, rail, supply).
    pub fn traceability(&self, part: &str) -> Option<Traceability<'_>> {
        stated(&self.0).into_iter().find(|(name, _)| *name == part)?.1
    }
}

/// Every instrument that is calibrated, by its part, with what is stated of it.
pub(super) fn stated(station: &StationDocument) -> [(&'static str, Option<Traceability<'_>>); 5] {
    macro_rules! of {
        ($table:expr) => {
            Traceability {
                certificate: $table.certificate.as_deref(),
                calibrated: $table.calibrated.as_deref(),
                due: $table.due.as_deref(),
            }
        };
    }
    let (spectro, power) = (&station.spectroradiometer, &station.powermeter);
    [
        ("axis.c", Some(of!(station.axis.c))),
        ("axis.gamma", Some(of!(station.axis.gamma))),
        ("luxmeter", Some(of!(station.luxmeter))),
        ("spectroradiometer", spectro.as_ref().map(|meter| of!(meter))),
        ("powermeter", power.as_ref().map(|meter| of!(meter))),
    ]
}

/// Whether `text` is a day, YYYY-MM-DD.
pub(crate) fn is_day(text: &str) -> bool {
    let parts: Vec<&str> = text.split('-').collect();
    let number = |part: &str, digits: usize, range: std::ops::RangeInclusive<u32>| {
        part.len() == digits && part.parse().is_ok_and(|value: u32| range.contains(&value))
    };
    parts.len() == 3 && number(parts[0], 4, 1..=9999) && number(parts[1], 2, 1..=12) && number(parts[2], 2, 1..=31)
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn days<'a>(calibrated: &'a str, due: &'a str) -> Traceability<'a> {
        Traceability {
            certificate: None,
            calibrated: Some(calibrated),
            due: Some(due),
        }
    }

    #[test]
    fn days_are_days_in_their_order() {
        assert!(days("2025-11-24", "2026-11-24").check("luxmeter").is_ok());
        assert!(Traceability::default().check("luxmeter").is_ok());
        let stated = |of: Traceability<'_>| of.check("axis.c").unwrap_err().to_string();
        assert!(stated(days("24.11.2025", "2026-11-24")).contains("is no day"));
        assert!(stated(days("2025-11-24", "2026-13-01")).contains("is no day"));
        assert!(stated(days("2026-11-24", "2025-11-24")).contains("before the calibration"));
    }

    #[test]
    fn a_calibration_is_overdue_from_the_day_after_it_was_due() {
        let known = days("2025-11-24", "2026-11-24");
        assert!(!known.overdue("2026-11-24") && known.overdue("2026-11-25"));
        assert!(!Traceability::default().overdue("2026-11-25"));
    }
}
