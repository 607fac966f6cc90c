//! The stream of numbers after `TILT=`, and which is which by its counts.

use crate::finding::{Finding, Findings};
use crate::number;
use crate::text::Text;

/// One number of the stream.
#[derive(Debug, Clone, Copy)]
pub(super) struct Token<'t> {
    /// Zero-based line.
    pub line: usize,
    /// One-based column.
    pub column: usize,
    pub text: &'t str,
}

/// The stream of numbers from a line on; blanks and commas separate, `END` and Ctrl-Z end it.
pub(super) fn tokens<'t>(text: &'t Text<'_>, from: usize, findings: &mut Findings) -> Vec<Token<'t>> {
    let mut tokens = Vec::new();
    for line in from..text.len() {
        let whole = text.line(line);
        let bytes = whole.as_bytes();
        let mut at = 0;
        let mut commas = 0;
        while at < bytes.len() {
            match bytes[at] {
                b',' => {
                    commas += 1;
                    if commas > 1 {
                        findings.push(
                            Finding::warning("ies-empty-field", "two commas with nothing between them")
                                .at(line + 1, at + 1)
                                .raw(whole)
                                .assumed("one separator")
                                .fix("put the missing number back"),
                        );
                    }
                    at += 1;
                }
                b' ' | b'\t' | 0x1A | 0 | 0x0C => at += 1,
                _ => {
                    let start = at;
                    while at < bytes.len() && !matches!(bytes[at], b' ' | b'\t' | b',' | 0x1A | 0 | 0x0C) {
                        at += 1;
                    }
                    commas = 0;
                    tokens.push(Token {
                        line,
                        column: start + 1,
                        text: &whole[start..at],
                    });
                }
            }
        }
    }
    if let Some(last) = tokens.last()
        && last.text.eq_ignore_ascii_case("END")
    {
        findings.push(
            Finding::note("ies-end-mark", "the file ends with the mark END")
                .at(last.line + 1, last.column)
                .raw("END"),
        );
        tokens.pop();
    }
    tokens
}

/// Where the blocks begin in the stream, and how long they are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Layout {
    /// Of ballast factor, photometric factor and watts.
    pub factors: usize,
    pub vertical: usize,
    pub nv: usize,
    pub horizontal: usize,
    pub nh: usize,
    pub candela: usize,
}

/// Finds the blocks of the numbers that begin at token `start`, or says where they stop making sense.
pub(super) fn find(tokens: &[Token<'_>], start: usize, text: &Text<'_>, findings: &mut Findings) -> Option<Layout> {
    let nv = count(tokens, start + 3, "vertical", findings);
    let nh = count(tokens, start + 4, "horizontal", findings);
    let last = tokens
        .last()
        .map_or((text.len().max(1), 1), |token| (token.line + 1, token.column));
    if tokens.len() < start + 13 {
        let message = "the file ends before the thirteen numbers of lamp and geometry are complete";
        let finding = Finding::error("ies-truncated", message).at(last.0, last.1);
        findings.push(finding.raw(text.line(last.0 - 1)).fix("fetch the file again"));
        return None;
    }
    let (nv, nh) = (nv?, nh?);
    let vertical = start + 13;
    let layout = Layout {
        factors: start + 10,
        vertical,
        nv,
        horizontal: vertical + nv,
        nh,
        candela: vertical + nv + nh,
    };
    let needed = nv.saturating_mul(nh);
    let there = tokens.len().saturating_sub(layout.candela);
    let angles = falls(tokens, vertical, nv, "vertical", 180.0)
        .or_else(|| falls(tokens, layout.horizontal, nh, "horizontal", 360.0));
    if let Some(finding) = angles {
        findings.push(finding);
    } else if there != needed {
        let (code, place) = match tokens.get(layout.candela.saturating_add(needed)) {
            Some(extra) => ("ies-values-extra", (extra.line + 1, extra.column)),
            None => ("ies-values-missing", last),
        };
        let message = format!("{there} candela values are there, {needed} are needed ({nh} × {nv})");
        let finding = Finding::error(code, message)
            .at(place.0, place.1)
            .raw(text.line(place.0 - 1));
        findings.push(finding.fix("a line or number may be missing or doubled, a count wrong, or the file cut off"));
    } else {
        return Some(layout);
    }
    None
}

fn count(tokens: &[Token<'_>], index: usize, what: &str, findings: &mut Findings) -> Option<usize> {
    let token = tokens.get(index)?;
    match number::read(token.text) {
        Ok(read) if read.value.fract() == 0.0 && (1.0..=100_000.0).contains(&read.value) => Some(read.value as usize),
        _ => {
            let finding = Finding::error("ies-count", format!("the number of {what} angles is needed here"));
            let finding = finding.at(token.line + 1, token.column).raw(token.text);
            findings.push(finding.fix("compare the ten numbers with the format's description"));
            None
        }
    }
}

/// The angle that does not go on rising. What is no number may be a damaged angle: the reader says so.
fn falls(tokens: &[Token<'_>], from: usize, count: usize, name: &str, largest: f64) -> Option<Finding> {
    let mut last = f64::NEG_INFINITY;
    for token in tokens.iter().skip(from).take(count) {
        let Ok(read) = number::read(token.text) else { continue };
        if read.value <= last || !(-360.0..=largest).contains(&read.value) {
            let message = format!("{count} rising {name} angles are needed; this one does not go on rising");
            let finding = Finding::error("ies-angles", message).at(token.line + 1, token.column);
            let fix = "a line or number before may be missing or doubled, or the count wrong";
            return Some(finding.raw(token.text).fix(fix));
        }
        last = read.value;
    }
    None
}
