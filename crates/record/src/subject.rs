//! What is measured, for whom, and what it is rated by: the tables `[luminaire]`, `[report]`, `[ratings]` and
//! `[eu_label]` of a job, kept in run.toml.

use serde::{Deserialize, Serialize};

use crate::document::Fault;
use crate::key::Key;
use crate::rated::{EuLabel, Ratings};

/// The luminaire under test, as its owner describes it. What is not stated is not known.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Luminaire {
    /// Who makes it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub maker: Option<String>,
    /// Its name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Its catalogue number.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub catalogue_number: Option<String>,
    /// Serial or sample number of the one that was measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sample: Option<String>,
    /// Its light source.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub light_source: Option<String>,
    /// Control gear and its setting (dimming).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub driver: Option<String>,
    /// Burning position during the measurement.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub burning_position: Option<String>,
    /// Hours of operation before the measurement, and other things known of its history.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hours_run: Option<String>,
    /// Rated voltage, current and power.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rated: Option<String>,
}

/// Who measured for whom, and the number of the report.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Commission {
    /// Unique number of the report (ISO/IEC 17025, 7.8.2.1).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub number: Option<String>,
    /// The laboratory, with its place.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub laboratory: Option<String>,
    /// Who measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub operator: Option<String>,
    /// Who answers for the report.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub approved_by: Option<String>,
    /// For whom it was measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub customer: Option<String>,
    /// When the item came.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub received: Option<String>,
    /// Day of issue of the report.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub issued: Option<String>,
    /// Standard and edition that was followed, and deviations from it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub method: Option<String>,
    /// What else a reader should know.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub notes: Option<String>,
}

/// Keys of `[luminaire]`. A line of text of EULUMDAT holds 78 characters, a lamp type 24.
pub const LUMINAIRE_KEYS: [Key; 9] = [
    key("maker", "maker of the luminaire", 78),
    key("name", "name of the luminaire", 78),
    key("catalogue_number", "catalogue number", 78),
    key("sample", "serial or sample number", 78),
    key("light_source", "light source", 24),
    key("driver", "control gear and dimming", 200),
    key("burning_position", "burning position", 200),
    key("hours_run", "hours run before", 200),
    key("rated", "rated electrical values", 200),
];

/// Keys of `[report]`. The number shares a line of EULUMDAT with the distance.
pub const REPORT_KEYS: [Key; 9] = [
    key("number", "number of the report", 40),
    key("laboratory", "laboratory and place", 200),
    key("operator", "operator", 60),
    key("approved_by", "approved by", 200),
    key("customer", "customer", 200),
    key("received", "item received on", 60),
    key("issued", "report issued on", 60),
    key("method", "standard and deviations from it", 200),
    key("notes", "notes", 2000),
];

const fn key(name: &'static str, what: &'static str, longest: usize) -> Key {
    Key { name, what, longest }
}

impl Luminaire {
    /// The texts in the order of [`LUMINAIRE_KEYS`].
    pub fn texts(&self) -> [Option<&str>; 9] {
        [
            &self.maker,
            &self.name,
            &self.catalogue_number,
            &self.sample,
            &self.light_source,
            &self.driver,
            &self.burning_position,
            &self.hours_run,
            &self.rated,
        ]
        .map(Option::as_deref)
    }

    /// Whether nothing is stated.
    pub fn is_empty(&self) -> bool {
        self.texts().iter().all(Option::is_none)
    }
}

impl Commission {
    /// The texts in the order of [`REPORT_KEYS`].
    pub fn texts(&self) -> [Option<&str>; 9] {
        [
            &self.number,
            &self.laboratory,
            &self.operator,
            &self.approved_by,
            &self.customer,
            &self.received,
            &self.issued,
            &self.method,
            &self.notes,
        ]
        .map(Option::as_deref)
    }

    /// Whether nothing is stated.
    pub fn is_empty(&self) -> bool {
        self.texts().iter().all(Option::is_none)
    }
}

/// All tables.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Subject {
    /// What is measured.
    #[serde(skip_serializing_if = "Luminaire::is_empty")]
    pub luminaire: Luminaire,
    /// For whom.
    #[serde(skip_serializing_if = "Commission::is_empty")]
    pub report: Commission,
    /// What its light is rated by.
    #[serde(skip_serializing_if = "Ratings::is_empty")]
    pub ratings: Ratings,
    /// The light source for an EU energy label.
    #[serde(skip_serializing_if = "EuLabel::is_empty")]
    pub eu_label: EuLabel,
}

impl Subject {
    /// Whether nothing is stated.
    pub fn is_empty(&self) -> bool {
        self.luminaire.is_empty() && self.report.is_empty() && self.ratings.is_empty() && self.eu_label.is_empty()
    }

    /// Refuses texts that the files of the results cannot hold.
    ///
    /// # Errors
    /// [`Fault`] with the path of the key.
    pub fn check(&self) -> Result<(), Fault> {
        let tables = [
            ("luminaire", LUMINAIRE_KEYS, self.luminaire.texts()),
            ("report", REPORT_KEYS, self.report.texts()),
        ];
        for (table, keys, texts) in tables {
            for (key, text) in keys.iter().zip(texts) {
                let Some(text) = text else { continue };
                key.check(text)
                    .map_err(|message| Fault::new(format!("{table}.{}", key.name), message))?;
            }
        }
        self.ratings.check()?;
        self.eu_label.check()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_of_the_tables_is_known_by_its_name() {
        let all = |keys: [Key; 9], table: &str| {
            let lines = keys.map(|key| format!("{} = \"{}\"\n", key.name, key.name)).concat();
            format!("[{table}]\n{lines}")
        };
        let text = all(LUMINAIRE_KEYS, "luminaire") + &all(REPORT_KEYS, "report");
        let subject: Subject = toml::from_str(&text).unwrap();
        assert_eq!(subject.luminaire.texts(), LUMINAIRE_KEYS.map(|key| Some(key.name)));
        assert_eq!(subject.report.texts(), REPORT_KEYS.map(|key| Some(key.name)));
        subject.check().unwrap();
    }

    #[test]
    fn what_a_file_cannot_hold_is_refused_with_its_key() {
        let with = |name: &str| Subject {
            luminaire: Luminaire {
                name: Some(name.to_owned()),
                ..Luminaire::default()
            },
            ..Subject::default()
        };
        assert!(with("Downlight ø 120").check().is_ok());
        for (name, words) in [
            (" ", "empty"),
            ("a\nb", "line break"),
            (&"x".repeat(79), "79 characters"),
        ] {
            let fault = with(name).check().unwrap_err();
            assert_eq!(fault.path, "luminaire.name");
            assert!(fault.message.contains(words), "{fault}");
        }
    }
}
