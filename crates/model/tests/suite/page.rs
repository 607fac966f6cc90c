//! The book's page of the effects is made from their files: `WRITE_PAGE=1 cargo test -p isolux-model --test suite page`
//! writes it. What stands before its first section is written by hand and kept.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;

use isolux_model::{EffectSpec, ParameterSpec, catalogue};

const PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/src/effects.md");
const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/src/effects");

#[test]
fn the_page_of_effects_is_what_their_files_say() {
    let page = std::fs::read_to_string(PAGE).unwrap();
    let begin = page.find("\n## ").map_or(page.len(), |at| at + 1);
    let made: String = catalogue().iter().map(|spec| section(spec)).collect();
    let made = page[..begin].to_owned() + made.trim_end() + "\n";
    if std::env::var_os("WRITE_PAGE").is_some() {
        std::fs::write(PAGE, made).unwrap();
        return;
    }
    for (written, made) in page.lines().zip(made.lines()) {
        assert_eq!(
            written, made,
            "docs/src/effects.md: write it with WRITE_PAGE=1 cargo test -p isolux-model --test suite page"
        );
    }
    assert_eq!(page.len(), made.len(), "docs/src/effects.md ends elsewhere");
}

/// What its file says of an effect.
fn section(spec: &EffectSpec) -> String {
    let owners: Vec<_> = spec.belongs_to.iter().map(|owner| owner.as_str()).collect();
    let keys: Vec<_> = spec.parameters.iter().map(key).collect();
    let mut text = format!(
        "## {}\n\n**{}** · {} · `{}`. {}\n\n{} — {}. Keys: {}.",
        spec.name,
        capitalised(spec.standard_name),
        owners.join(", "),
        spec.shows_in,
        paragraph(spec.name),
        spec.formula,
        spec.source,
        keys.join(", ")
    );
    if spec.parameters[0].null != 0.0 {
        let _ = write!(text, " Null value {}.", spec.parameters[0].null);
    }
    let look_alikes: Vec<_> = spec.look_alikes.iter().map(|(name, _)| format!("`{name}`")).collect();
    if !look_alikes.is_empty() {
        let _ = write!(text, " Look-alikes: {}.", look_alikes.join(", "));
    }
    text + "\n\n"
}

/// The first lines of the effect's file.
fn paragraph(name: &str) -> String {
    let file = Path::new(FOLDER).join(name).with_extension("rs");
    let text = std::fs::read_to_string(&file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    let lines: Vec<_> = text.lines().map_while(|line| line.strip_prefix("//! ")).collect();
    assert!(!lines.is_empty(), "{}: begins with no paragraph", file.display());
    lines.join(" ")
}

fn key(parameter: &ParameterSpec) -> String {
    let (low, high) = parameter.plausible;
    let unit = match parameter.unit {
        "" | "1" => String::new(),
        unit => format!(" {unit}"),
    };
    format!("`{}` ({} … {}{unit})", parameter.key, number(low), number(high))
}

fn number(value: f64) -> String {
    match value {
        TAU => "2π".to_owned(),
        _ if value != 0.0 && value.abs() < 5e-3 => format!("{value:e}"),
        _ => value.to_string(),
    }
}

/// With a capital where the first letter is a Latin one: γ stays γ.
fn capitalised(text: &str) -> String {
    let (first, rest) = text.split_at(text.chars().next().map_or(0, char::len_utf8));
    first.to_ascii_uppercase() + rest
}
