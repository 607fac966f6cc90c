//! Where the blocks of an EULUMDAT file stand: the counts of lines 3, 4, 6 and 26 fix how many values there must be.

use super::document::stored_planes;
use crate::finding::{Finding, Findings};
use crate::number;
use crate::text::Text;

/// Lines of the header before the lamp sets.
pub(super) const HEADER: usize = 26;

/// One number of the value blocks: zero-based line, one-based column, text.
#[derive(Debug, Clone, Copy)]
pub(super) struct Token<'t> {
    pub line: usize,
    pub column: usize,
    pub text: &'t str,
}

/// The counts of a file and its value blocks.
#[derive(Debug)]
pub(super) struct Layout<'t> {
    pub isym: u8,
    pub sets: usize,
    pub ratios: Vec<Token<'t>>,
    pub c: Vec<Token<'t>>,
    pub gamma: Vec<Token<'t>>,
    pub intensity: Vec<Token<'t>>,
}

/// Finds the blocks, or says where the file stops making sense.
pub(super) fn find<'t>(text: &'t Text<'_>, findings: &mut Findings) -> Option<Layout<'t>> {
    if text.len() < HEADER {
        let message = format!(
            "the file ends after {} lines, within the header of {HEADER}",
            text.len()
        );
        let finding = Finding::error("ldt-truncated", message).at(text.len().max(1), 1);
        findings.push(finding.fix("fetch the file again"));
        return None;
    }
    let isym = count(text, 2, "the symmetry indicator (0 to 4)", 0..=4, findings);
    let mc = count(text, 3, "the number of C planes", 1..=100_000, findings);
    let ng = count(text, 5, "the number of γ angles", 2..=100_000, findings);
    let sets = count(text, 25, "the number of lamp sets", 1..=100_000, findings);
    let (isym, mc, ng, sets) = (isym? as u8, mc?, ng?, sets?);
    let planes = stored_planes(isym, mc);
    let needed = planes.saturating_mul(ng);
    let blocks = [10, mc, ng, needed];
    let all = blocks.iter().fold(0_usize, |sum, &block| sum.saturating_add(block));
    let from = HEADER + 6 * sets;
    let blank = |line: &usize| text.line(*line).trim_matches(BLANKS).is_empty();
    let end = (0..text.len())
        .rev()
        .find(|line| !blank(line))
        .map_or(0, |last| last + 1);
    let mut tokens: Vec<Token<'t>> = (from..end).map(|line| token(text, line)).collect();
    if tokens.len() != all {
        let stream = words(text, from..end, &mut Findings::new());
        if stream.len() == all {
            tokens = words(text, from..end, findings);
        }
    }
    if tokens.len() <= 10 + mc + ng {
        let needed = from.saturating_add(all);
        let message = format!("the file ends after {end} lines; its counts (lines 3, 4, 6 and 26) need {needed}");
        let finding = Finding::error("ldt-truncated", message).at(end.max(1), 1);
        let finding = finding.raw(text.line(end.saturating_sub(1)));
        findings.push(finding.fix("fetch the file again, or correct the counts"));
        return None;
    }
    let mut intensity = tokens.split_off(10 + mc + ng);
    let gamma = tokens.split_off(10 + mc);
    let c = tokens.split_off(10);
    let angles = [(&c, "C", 360.0), (&gamma, "γ", 180.0)];
    if let Some(finding) = angles
        .into_iter()
        .find_map(|(tokens, name, most)| falls(tokens, name, most))
    {
        findings.push(finding);
        return None;
    }
    if intensity.len() != needed {
        let there = intensity.len();
        let extra = intensity.split_off(there.min(needed));
        let (code, at) = match extra.first() {
            Some(first) => ("ldt-values-extra", Some(first)),
            None => ("ldt-values-missing", intensity.last()),
        };
        let message = format!("{there} intensities are there, {needed} are needed ({planes} planes × {ng})");
        let finding = Finding::error(code, message).fix("a line may be missing or doubled, or a count be wrong");
        findings.push(at.map_or(finding.clone(), |token| {
            finding.at(token.line + 1, token.column).raw(token.text)
        }));
        return None;
    }
    Some(Layout {
        isym,
        sets,
        ratios: tokens,
        c,
        gamma,
        intensity,
    })
}

/// What some programs pad lines and files with.
const BLANKS: [char; 5] = [' ', '\t', '\u{a0}', '\0', '\u{1a}'];

/// A count of the header.
fn count(
    text: &Text<'_>,
    line: usize,
    what: &str,
    allowed: std::ops::RangeInclusive<usize>,
    findings: &mut Findings,
) -> Option<usize> {
    let value = number::read(text.line(line)).ok().map(|number| number.value);
    let value = value.filter(|value| value.fract() == 0.0 && *value >= 0.0);
    if let Some(count) = value
        .map(|value| value as usize)
        .filter(|count| allowed.contains(count))
    {
        return Some(count);
    }
    let message = format!("{what} is needed here; a line before may be missing or doubled");
    let finding = Finding::error("ldt-header", message)
        .at(line + 1, 1)
        .raw(text.line(line));
    findings.push(finding.fix("compare lines 1 to 26 with the format's description"));
    None
}

/// The one value of a line.
fn token<'t>(text: &'t Text<'_>, line: usize) -> Token<'t> {
    let whole = text.line(line);
    let bare = |byte: Option<&u8>| byte.is_some_and(u8::is_ascii_graphic);
    let trimmed = if bare(whole.as_bytes().first()) && bare(whole.as_bytes().last()) {
        whole
    } else {
        whole.trim()
    };
    Token {
        line,
        column: (trimmed.as_ptr() as usize - whole.as_ptr() as usize) + 1,
        text: trimmed,
    }
}

/// Several values on a line, or blank lines between them: the blocks as a stream.
fn words<'t>(text: &'t Text<'_>, lines: std::ops::Range<usize>, findings: &mut Findings) -> Vec<Token<'t>> {
    let mut tokens: Vec<Token<'t>> = Vec::new();
    for line in lines {
        let whole = text.line(line);
        let before = tokens.len();
        let mut from = 0;
        for word in whole.split([' ', '\t', ';']) {
            if !word.is_empty() {
                tokens.push(Token {
                    line,
                    column: from + 1,
                    text: word,
                });
            }
            from += word.len() + 1;
        }
        let finding = match tokens.len() - before {
            1 => continue,
            0 => Finding::warning("ldt-blank-line", "a blank line stands among the values")
                .assumed("no value here")
                .fix("remove the line"),
            found => Finding::warning("ldt-values-on-line", format!("{found} values stand on one line"))
                .raw(whole)
                .assumed("one after the other")
                .fix("write one value a line"),
        };
        findings.push(finding.at(line + 1, 1));
    }
    tokens
}

/// The angle that does not go on rising. What is no number may be a damaged angle: the reader says so.
fn falls(tokens: &[Token<'_>], name: &str, largest: f64) -> Option<Finding> {
    let mut last = f64::NEG_INFINITY;
    for token in tokens {
        let Ok(number) = number::read(token.text) else { continue };
        if number.value <= last || !(-180.0..=largest).contains(&number.value) {
            let message = format!(
                "the {name} angles do not go on rising here; a line before may be missing or doubled, or a count wrong"
            );
            let finding = Finding::error("ldt-angles", message).at(token.line + 1, token.column);
            return Some(finding.raw(token.text).fix("compare the angles with lines 4 to 7"));
        }
        last = number.value;
    }
    None
}
