//! A text that may be cut within its last number.

use crate::finding::{Finding, Findings};
use crate::text::Text;

/// A last line without its end, whose last number has fewer decimals than all others, is cut in the middle of it.
pub(crate) fn unfinished_line(text: &Text<'_>, findings: &mut Findings) {
    let decimals = |line: &str| {
        let last = line.rsplit([',', ';', '\t', ' ']).find(|cell| !cell.is_empty())?;
        let digits = last.rsplit_once('.').map_or("", |(_, digits)| digits);
        last.ends_with(|c: char| c.is_ascii_digit() || c == '.')
            .then_some(digits.len())
    };
    if text.ends_with_newline || text.len() < 4 {
        return;
    }
    let last = text.line(text.len() - 1);
    let others = (text.len().saturating_sub(40)..text.len() - 1).filter_map(|line| decimals(text.line(line)));
    let cut = match (decimals(last), others.min()) {
        (Some(here), Some(fewest)) => here < fewest,
        _ => last.ends_with(['.', 'e', 'E', '-', '+']),
    };
    if cut {
        let message = "the last line has no line end and its last number fewer decimals than the others: it may be cut";
        findings.push(
            Finding::warning("text-unfinished", message)
                .at(text.len(), last.chars().count().max(1))
                .raw(last)
                .assumed("the number is whole")
                .fix("fetch the file again, or end it with a line end"),
        );
    }
}
