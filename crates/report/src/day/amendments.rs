//! Amendments of a report: what changed since the one that was issued (ISO/IEC 17025, 7.8.8).

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::document::{Document, Section};

/// Changes that a report lists; the file has all of them.
const LISTED: usize = 40;

/// `amendments.json`: one replacement of a report.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Amendment {
    /// 1 for the first.
    pub number: usize,
    /// Why, as a person said; null where nobody did.
    pub reason: Option<String>,
    /// Every statement that is not as it was.
    pub changed: Vec<Change>,
    /// Folder of the reports that it replaces, in that of the results.
    pub kept_in: String,
    /// SHA-256 of each of them, by its name.
    pub sha256: BTreeMap<String, String>,
}

/// A statement before and after.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Change {
    /// Its place in the report.
    pub statement: String,
    /// What it was; null where it is new.
    pub before: Option<String>,
    /// What it is; null where it is left out.
    pub after: Option<String>,
}

/// What differs between the statements of two reports.
pub fn changes(before: &BTreeMap<String, String>, after: &BTreeMap<String, String>) -> Vec<Change> {
    let mut keys: Vec<&String> = before.keys().chain(after.keys()).collect();
    keys.sort_unstable();
    keys.dedup();
    let changed = keys.into_iter().filter(|key| before.get(*key) != after.get(*key));
    changed
        .map(|key| Change {
            statement: key.clone(),
            before: before.get(key).cloned(),
            after: after.get(key).cloned(),
        })
        .collect()
}

/// The report with what it amends; as it is where it amends none.
#[must_use]
pub fn amended(mut document: Document, amendments: &[Amendment]) -> Document {
    let Some(last) = amendments.last() else {
        return document;
    };
    let words = format!("amendment {}", last.number);
    document.subtitle = format!("{} · {words}", document.subtitle);
    document.foot = format!("{} · {words}", document.foot);
    let mut section = Section::new("Amendments");
    section.paragraph(format!(
        "This report, {words}, replaces the one before, which is kept unchanged in {}.",
        last.kept_in
    ));
    for amendment in amendments.iter().rev() {
        section.subheading(format!("Amendment {}", amendment.number));
        let reason = amendment.reason.as_deref().unwrap_or("not stated");
        let mut facts = vec![("reason".to_owned(), reason.to_owned())];
        for (name, sum) in &amendment.sha256 {
            facts.push((format!("SHA-256 of the {name} that it replaces"), sum.clone()));
        }
        section.facts(facts);
        let cell = |text: &Option<String>| text.clone().unwrap_or_else(|| "–".to_owned());
        let rows = amendment
            .changed
            .iter()
            .take(LISTED)
            .map(|change| vec![change.statement.clone(), cell(&change.before), cell(&change.after)]);
        section.table(&["statement", "before", "after"], rows.collect());
        let more = amendment.changed.len().saturating_sub(LISTED);
        if more > 0 {
            section.paragraph(format!("and {more} more: results/amendments.json has all of them."));
        }
    }
    document.sections.insert(1.min(document.sections.len()), section);
    document
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_is_named_with_what_was_and_what_is() {
        let map = |pairs: &[(&str, &str)]| -> BTreeMap<String, String> {
            pairs
                .iter()
                .map(|(key, value)| ((*key).to_owned(), (*value).to_owned()))
                .collect()
        };
        let found = changes(
            &map(&[("a", "1"), ("b", "2"), ("c", "3")]),
            &map(&[("a", "1"), ("b", "4"), ("d", "5")]),
        );
        let words: Vec<String> = found
            .iter()
            .map(|change| format!("{} {:?} {:?}", change.statement, change.before, change.after))
            .collect();
        assert_eq!(
            words,
            ["b Some(\"2\") Some(\"4\")", "c Some(\"3\") None", "d None Some(\"5\")"]
        );
    }
}
