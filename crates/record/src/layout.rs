//! `[layout]` of a job: in whose clothes the report comes, in which language, with which sections in which order.

use camino::Utf8PathBuf;
use serde::{Deserialize, Serialize};

use crate::document::Fault;

/// The language of a report.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Language {
    /// English.
    #[default]
    En,
    /// German.
    De,
    /// French.
    Fr,
}

impl Language {
    /// Its code by BCP 47.
    pub const fn code(self) -> &'static str {
        match self {
            Self::En => "en",
            Self::De => "de",
            Self::Fr => "fr",
        }
    }
}

/// Sections of a report by the names that `sections` has for them, in the order in which they stand without it. The
/// first page and the provenance are always there.
pub const SECTIONS: [&str; 16] = [
    "conformity",
    "distribution",
    "flux",
    "colour",
    "colour_over_angle",
    "glare",
    "ratings",
    "eu_label",
    "light_modulation",
    "conditions",
    "uncertainty",
    "simulation",
    "comparison",
    "diagnosis",
    "tables",
    "checklist",
];

/// `[layout]` as written. Paths are relative to the job.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Layout {
    /// The language of the report.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub language: Option<Language>,
    /// Address of the laboratory, one line a line.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub address: Vec<String>,
    /// The laboratory's logo, SVG or PNG.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub logo: Option<Utf8PathBuf>,
    /// Its mark of accreditation, SVG or PNG.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accreditation_mark: Option<Utf8PathBuf>,
    /// A style sheet that follows that of the page.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub style: Option<Utf8PathBuf>,
    /// Which sections the report has, in this order; without it all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sections: Option<Vec<String>>,
    /// Whether a day makes a data sheet of one page too.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub data_sheet: bool,
}

impl Layout {
    /// Whether nothing is stated.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// The files that it names, each with its key.
    pub fn files(&mut self) -> impl Iterator<Item = (&'static str, &mut Utf8PathBuf)> {
        [
            ("layout.logo", &mut self.logo),
            ("layout.accreditation_mark", &mut self.accreditation_mark),
            ("layout.style", &mut self.style),
        ]
        .into_iter()
        .filter_map(|(key, file)| Some((key, file.as_mut()?)))
    }

    /// Refuses sections that there are not, and pictures of another kind.
    ///
    /// # Errors
    /// [`Fault`] with the path of the key.
    pub fn check(&self) -> Result<(), Fault> {
        for (place, name) in self.sections.iter().flatten().enumerate() {
            let path = format!("layout.sections.{place}");
            if !SECTIONS.contains(&name.as_str()) {
                let message = format!("{name} is no section of the report; there are {}", SECTIONS.join(", "));
                return Err(Fault::new(path, message));
            }
            if self.sections.iter().flatten().take(place).any(|other| other == name) {
                return Err(Fault::new(path, format!("{name} is named twice")));
            }
        }
        for (key, file) in [("logo", &self.logo), ("accreditation_mark", &self.accreditation_mark)] {
            let known = |file: &Utf8PathBuf| file.extension().is_some_and(|end| end == "svg" || end == "png");
            if let Some(file) = file.as_ref().filter(|file| !known(file)) {
                return Err(Fault::new(
                    format!("layout.{key}"),
                    format!("{file} is no .svg and no .png"),
                ));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_section_that_there_is_not_and_another_picture_are_refused() {
        let check = |text: &str| toml::from_str::<Layout>(text).unwrap().check();
        assert!(check("sections = [\"flux\", \"conformity\"]\nlogo = \"a.svg\"\nlanguage = \"de\"\n").is_ok());
        for (text, path) in [
            ("sections = [\"flux\", \"light\"]\n", "layout.sections.1"),
            ("sections = [\"flux\", \"flux\"]\n", "layout.sections.1"),
            ("logo = \"logo.jpg\"\n", "layout.logo"),
        ] {
            assert_eq!(check(text).unwrap_err().path, path);
        }
    }
}
