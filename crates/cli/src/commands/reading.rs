//! What `inspect` and `convert` share: decisions for the reader, and findings as a compiler prints them.

use clap::{Args, ValueEnum};
use isolux_app::formats::{Finding, ReadOptions};

/// Decisions that a file leaves to a person.
#[derive(Debug, Args)]
pub struct Reading {
    /// EULUMDAT symmetry 3: which plane is stored first. The format says C270; some programs write C90 first.
    #[arg(long, value_enum, default_value = "c270-first")]
    isym3: Order,
    /// IES 1995 and 2002: multiply by the field that is kept for future use.
    #[arg(long)]
    apply_future_use: bool,
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
            self_check: false,
        }
    }
}

/// `file:line:column: severity[code]: message`, then what stands there, what was assumed and how to mend it.
pub fn compiler_style(file: &str, finding: &Finding) -> String {
    let mut text = file.to_owned();
    for place in [finding.line, finding.column.map(|column| column as usize)]
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
