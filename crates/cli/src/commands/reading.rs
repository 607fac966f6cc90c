//! What `inspect` and `convert` share: decisions for the reader, and findings as a compiler prints them.

use clap::{Args, ValueEnum};
use isolux_app::formats::{Finding, Place, ReadOptions};

/// Decisions that a file leaves to a person.
#[derive(Debug, Args)]
pub struct Reading {
    /// EULUMDAT symmetry 3: which plane is stored first. The format says C270; some programs write C90 first.
    #[arg(long, value_enum, default_value = "c270-first")]
    isym3: Order,
    /// IES 1995 and 2002: multiply by the field that is kept for future use.
    #[arg(long)]
    apply_future_use: bool,
    /// The table is a spectrum: the columns of its wavelengths and of its values, counted from 1.
    #[arg(long, value_name = "WAVELENGTH,VALUE", value_parser = columns)]
    columns: Option<[usize; 2]>,
}

/// `1,3`.
fn columns(text: &str) -> Result<[usize; 2], String> {
    let number = |text: &str| text.trim().parse::<usize>().ok().filter(|&column| column > 0);
    match text
        .split_once(',')
        .map(|(first, second)| (number(first), number(second)))
    {
        Some((Some(wavelength), Some(value))) if wavelength != value => Ok([wavelength, value]),
        _ => Err("two different column numbers from 1 on are needed, such as 1,2".to_owned()),
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Order {
    C270First,
    C90First,
}

impl Reading {
    /// For the reader.
    pub fn options(&self) -> ReadOptions {
        ReadOptions {
            isym3_c90_first: self.isym3 == Order::C90First,
            apply_future_use: self.apply_future_use,
            columns: self.columns,
        }
    }
}

/// `file:line:column: severity[code]: message`, then what stands there, what was assumed and what to do about it.
pub fn compiler_style(file: &str, finding: &Finding) -> String {
    let mut text = file.to_owned();
    for place in [finding.line, finding.column.map(|column| column.get() as usize)]
        .into_iter()
        .flatten()
    {
        text.push_str(&format!(":{place}"));
    }
    if let Some(&[from, to]) = finding.bytes.as_deref() {
        text.push_str(&format!(":bytes {from}..{to}"));
    }
    text.push_str(&format!(
        ": {}[{}]: {}",
        finding.severity.word(),
        finding.code,
        finding.message
    ));
    for (label, content) in [
        ("found", &finding.raw),
        ("assumed", &finding.assumed),
        ("help", &finding.fix),
    ] {
        if let Some(content) = content {
            text.push_str(&format!("\n    {label}: {content}"));
        }
    }
    text
}

/// How many places of a finding were not shown.
pub fn unshown(count: usize) -> Option<String> {
    let places = if count == 1 { "place" } else { "places" };
    (count > 0).then(|| format!("    and the same at {count} more {places}"))
}

/// `file:line:column: also: message`, then what stands there.
pub fn place(file: &str, place: &Place) -> String {
    let mut text = file.to_owned();
    for number in [place.line, place.column.map(|column| column.get() as usize)]
        .into_iter()
        .flatten()
    {
        text.push_str(&format!(":{number}"));
    }
    text.push_str(": also");
    for stated in [&place.message, &place.raw].into_iter().flatten() {
        text.push_str(&format!(": {stated}"));
    }
    text
}
