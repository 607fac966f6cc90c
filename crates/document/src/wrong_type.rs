//! What the TOML reader says about a value of the wrong type, in words that a person can act on.

use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The message of `error`; where a value has another type than its key, the key, what stands there and what is needed.
pub(super) fn explain(text: &str, error: &toml::de::Error) -> String {
    let message = error.message().trim().replace('\n', " ");
    let written = error.span().and_then(|span| text.get(span)).unwrap_or_default();
    let key = error.span().and_then(|span| key_at(text, span.start));
    let Some(key) = key else {
        let line = error.span().map(|span| line_at(text, span.start));
        return line.and_then(not_toml).unwrap_or(message);
    };
    let leaf = key.rsplit('.').next().unwrap_or(&key);
    for start in ["invalid type: ", "invalid value: ", "invalid length "] {
        let Some((found, expected)) = message
            .strip_prefix(start)
            .and_then(|rest| rest.split_once(", expected "))
        else {
            continue;
        };
        let found = if start == "invalid length " {
            format!("a list of {found}")
        } else {
            found_words(found)
        };
        return format!("`{key}` is {found}; {}", needed_words(leaf, expected, written));
    }
    if message.starts_with("unknown field") || message.starts_with("missing field") || message.starts_with("duplicate")
    {
        return message;
    }
    // What a type says itself names neither the key nor the value.
    if written.is_empty() || written.contains('\n') || message.contains(written.trim_matches('"')) {
        return format!("`{key}`: {message}");
    }
    format!("`{key}` is {written}; {message}")
}

/// The line of the text that holds the byte `at`.
fn line_at(text: &str, at: usize) -> &str {
    let start = text
        .get(..at)
        .and_then(|before| before.rfind('\n'))
        .map_or(0, |newline| newline + 1);
    text[start..].lines().next().unwrap_or_default()
}

/// What a line says that is no TOML, where it is a number as people write it elsewhere.
fn not_toml(line: &str) -> Option<String> {
    let (key, value) = line.split_once('=')?;
    let value = value.split('#').next()?.trim();
    let meant = plain_number(value).filter(|meant| meant != value)?;
    let how = if value.ends_with('%') {
        "a percentage is written as a fraction"
    } else {
        "numbers have a decimal point"
    };
    Some(format!("{how}: {} = {meant}", key.trim()))
}

/// The number that `0.4 %` or `1,5` means, as TOML has it; none for other text.
fn plain_number(text: &str) -> Option<String> {
    let text = text.trim();
    let (text, percent) = match text.strip_suffix('%') {
        Some(number) => (number.trim_end(), true),
        None => (text, false),
    };
    let text = if text.matches(',').count() == 1 {
        text.replace(',', ".")
    } else {
        text.to_owned()
    };
    if !text
        .bytes()
        .all(|byte| byte.is_ascii_digit() || b"+-.eE".contains(&byte))
    {
        return None;
    }
    let number: f64 = text.parse().ok()?;
    if !percent {
        return Some(text);
    }
    // Digits as written: 0.4 % is 0.004, not 0.0040000000000000001.
    let fraction = format!("{:.12}", number / 100.0);
    Some(fraction.trim_end_matches('0').trim_end_matches('.').to_owned())
}

/// `string "fast"` as the reader calls it.
fn found_words(found: &str) -> String {
    let inside = found.split_once('`').map(|(_, rest)| rest.trim_end_matches('`'));
    match (found.split_whitespace().next(), inside) {
        (Some("string"), _) => format!("the text {}", found.strip_prefix("string ").unwrap_or(found)),
        (Some("integer" | "floating"), Some(number)) => format!("the number {number}"),
        (Some("boolean"), Some(word)) => word.to_owned(),
        (Some("sequence"), _) => "a list".to_owned(),
        (Some("map"), _) => "a table".to_owned(),
        _ => found.to_owned(),
    }
}

/// What is needed and how it is written; `written` is what stands there.
fn needed_words(leaf: &str, expected: &str, written: &str) -> String {
    let meant = plain_number(written.trim_matches('"'));
    let (what, example) = match expected {
        "f64" | "f32" => ("a number", meant.as_deref().unwrap_or("1.5")),
        "usize" | "u64" | "u32" | "u16" | "u8" | "a nonzero usize" => ("a whole number of zero or more", "3"),
        "i64" | "i32" | "i16" | "i8" => ("a whole number", "1"),
        "a ratio" => ("a ratio of whole numbers in quotes", "\"12800/3\""),
        "a string" | "a character" | "path string" => ("text in quotes", "\"text\""),
        "a boolean" => ("true or false", "true"),
        "a sequence" => ("a list", "[1.0, 2.0]"),
        "an array of length 2" => ("a list of two", "[1.0, 2.0]"),
        "an array of length 3" => ("a list of three", "[0.0, 90.0, 1.0]"),
        "an array of length 4" => ("a list of four", "[1.0, 2.0, 3.0, 4.0]"),
        "a map" => return format!("a table is needed, as in [{leaf}] with keys of its own"),
        other if other.starts_with("struct ") => {
            return format!("a table is needed, as in [{leaf}] with keys of its own");
        }
        other => return format!("{other} is needed"),
    };
    if leaf.parse::<usize>().is_ok() {
        return format!("{what} is needed there");
    }
    format!("{what} is needed, as in {leaf} = {example}")
}

/// The dotted key of the innermost value that holds the byte `at`.
fn key_at(text: &str, at: usize) -> Option<String> {
    let root = DeTable::parse(text).ok()?;
    let mut path = Vec::new();
    within(root.get_ref(), at, &mut path).then(|| path.join("."))
}

/// Whether a value of the table holds the byte, and its path. A table under a heading states the heading's bytes alone,
/// so every table is looked into.
fn within(table: &DeTable<'_>, at: usize, path: &mut Vec<String>) -> bool {
    table.iter().any(|(key, value)| {
        path.push(key.get_ref().to_string());
        let found = holds(value, at, path);
        if !found {
            path.pop();
        }
        found
    })
}

fn holds(value: &Spanned<DeValue<'_>>, at: usize, path: &mut Vec<String>) -> bool {
    let inside = match value.get_ref() {
        DeValue::Table(table) => within(table, at, path),
        DeValue::Array(list) => list.iter().enumerate().any(|(place, value)| {
            path.push(place.to_string());
            let found = holds(value, at, path);
            if !found {
                path.pop();
            }
            found
        }),
        _ => false,
    };
    inside || value.span().contains(&at)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, serde::Deserialize)]
    struct Toy {
        #[serde(rename = "lamp")]
        _lamp: Lamp,
    }

    #[derive(Debug, serde::Deserialize)]
    struct Lamp {
        #[serde(rename = "on", default)]
        _on: bool,
        #[serde(rename = "count", default)]
        _count: usize,
        #[serde(rename = "name", default)]
        _name: String,
        #[serde(rename = "limit_deg", default)]
        _limit: [f64; 2],
        #[serde(rename = "level", default)]
        _level: f64,
        #[serde(rename = "parts", default)]
        _parts: Vec<f64>,
    }

    #[derive(Debug, serde::Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Strict {}

    #[test]
    fn a_wrong_type_names_its_key_and_the_remedy() {
        let described = |line: &str| {
            let text = format!("[[other]]\nx = 1\n[lamp]\n{line}\n[last]\n");
            explain(&text, &toml::from_str::<Toy>(&text).unwrap_err())
        };
        assert_eq!(
            described("on = 1"),
            "`lamp.on` is the number 1; true or false is needed, as in on = true"
        );
        assert_eq!(
            described("count = -3"),
            "`lamp.count` is the number -3; a whole number of zero or more is needed, as in count = 3"
        );
        assert_eq!(
            described("name = [1]"),
            "`lamp.name` is a list; text in quotes is needed, as in name = \"text\""
        );
        assert_eq!(
            described("level = \"0,5 %\""),
            "`lamp.level` is the text \"0,5 %\"; a number is needed, as in level = 0.005"
        );
        assert_eq!(
            described("level = 0.4 %"),
            "a percentage is written as a fraction: level = 0.004"
        );
        assert_eq!(
            described("level = -1,25 # V"),
            "numbers have a decimal point: level = -1.25"
        );
        assert!(!described("level = 1.5 extra").contains("decimal"));
        let unknown = toml::from_str::<Strict>("nothing = 180").unwrap_err();
        assert!(explain("nothing = 180", &unknown).starts_with("unknown field `nothing`"));
        assert!(described("limit_deg = [1.0]").starts_with("`lamp.limit_deg` is a list of 1; a list of two is needed"));
        assert!(described("parts = [1.0, \"x\"]").starts_with("`lamp.parts.1` is the text \"x\"; a number is needed"));
    }
}
