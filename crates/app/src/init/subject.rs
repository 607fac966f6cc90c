//! The tables `[luminaire]` and `[report]` of a job that `init` writes.

pub use isolux_record::Subject;
use isolux_record::key::Key;
use isolux_record::subject::{LUMINAIRE_KEYS, REPORT_KEYS};

use crate::Failure;

/// What the built-in virtual darkroom measures.
const BUILT_IN_NAME: &str = "LED rings of the virtual darkroom";

/// The tables, with every key that they can have.
pub const TABLES: [(&str, [Key; 9]); 2] = [("luminaire", LUMINAIRE_KEYS), ("report", REPORT_KEYS)];

/// What is measured in the built-in virtual darkroom.
pub fn built_in() -> Subject {
    let mut subject = Subject::default();
    subject.luminaire.name = Some(BUILT_IN_NAME.to_owned());
    subject
}

/// What a person states: `maker=ACME` for `[luminaire]` and `[report]`.
///
/// # Errors
/// Bad input (exit 2) for a key that there is not, one that is given twice, and a text that no file of the results can
/// hold.
pub fn stated(luminaire: &[String], report: &[String]) -> Result<Subject, Failure> {
    let mut document = toml::Table::new();
    for ((table, keys), texts) in TABLES.into_iter().zip([luminaire, report]) {
        let mut stated = toml::Table::new();
        for text in texts {
            let refused = |why: String| Failure::bad_input(format!("--{table} {text}: {why}"));
            let (name, value) = text
                .split_once('=')
                .ok_or_else(|| refused(format!("is not KEY=TEXT, as in {}=…", keys[0].name)))?;
            let Some(key) = keys.iter().find(|key| key.name == name) else {
                let names: Vec<&str> = keys.iter().map(|key| key.name).collect();
                return Err(refused(format!(
                    "{name} is no key of [{table}]; there are {}",
                    names.join(", ")
                )));
            };
            key.check(value).map_err(refused)?;
            if stated.insert(name.to_owned(), value.into()).is_some() {
                return Err(refused(format!("{name} is given twice")));
            }
        }
        document.insert(table.to_owned(), stated.into());
    }
    document.try_into().map_err(Failure::bad_input)
}

/// Both tables as text: what is stated, and every other key behind `#`.
pub fn text(subject: &Subject) -> String {
    let mut text = String::from(
        "# What is measured and for whom: it stands in the report, in luminaire.ldt, .ies and .xml, and in run.toml. Leave out what\n\
         # is not known.\n",
    );
    let texts = [subject.luminaire.texts(), subject.report.texts()];
    for ((table, keys), texts) in TABLES.into_iter().zip(texts) {
        text.push_str(&format!("[{table}]\n"));
        for (key, stated) in keys.iter().zip(texts) {
            let line = match stated {
                Some(stated) => format!("{} = {}", key.name, toml::Value::from(stated)),
                None => format!("# {} = \"\"", key.name),
            };
            text.push_str(&format!("{line:<40} # {}\n", key.what));
        }
        text.push('\n');
    }
    text.trim_end().to_owned() + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_stated_stands_in_the_text_and_is_read_from_it() {
        let list = |texts: &[&str]| texts.iter().map(|text| (*text).to_owned()).collect::<Vec<_>>();
        let subject = stated(&list(&["maker=ACME \"A\"", "name=Spot = 12"]), &list(&["customer=B"])).unwrap();
        assert_eq!(subject.luminaire.name.as_deref(), Some("Spot = 12"));
        assert_eq!(toml::from_str::<Subject>(&text(&subject)).unwrap(), subject);
        for (wrong, words) in [
            (&["marker=A"][..], "is no key of [luminaire]"),
            (&["maker"], "is not KEY=TEXT"),
            (&["maker="], "is empty"),
            (&["maker=A", "maker=B"], "twice"),
        ] {
            let refused = stated(&list(wrong), &[]).unwrap_err();
            assert!(refused.message.contains(words), "{}", refused.message);
        }
    }
}
