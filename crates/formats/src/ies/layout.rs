//! The stream of numbers after `TILT=`: which is which, also where a line is missing, doubled or miscounted.

use crate::finding::{Finding, Findings};
use crate::number;
use crate::slip;
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

impl Token<'_> {
    pub(super) fn value(&self) -> Option<f64> {
        number::read(self.text).ok().map(|number| number.value)
    }
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

/// Index ranges of the stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Layout {
    /// Of ballast factor, photometric factor and watts; none where their line is missing.
    pub factors: Option<usize>,
    pub vertical: usize,
    pub nv: usize,
    pub horizontal: usize,
    pub nh: usize,
    pub candela: usize,
    /// All candela are there and nothing more.
    pub complete: bool,
}

impl Layout {
    fn new(start: usize, factors: bool, nv: usize, nh: usize) -> Self {
        let vertical = start + if factors { 13 } else { 10 };
        Self {
            factors: factors.then_some(start + 10),
            vertical,
            nv,
            horizontal: vertical + nv,
            nh,
            candela: vertical + nv + nh,
            complete: true,
        }
    }

    fn end(&self) -> usize {
        self.candela.saturating_add(self.nv.saturating_mul(self.nh))
    }
}

/// Finds the blocks of the numbers that begin at token `start`, or says where they stop making sense.
pub(super) fn find(tokens: &[Token<'_>], start: usize, text: &Text<'_>, findings: &mut Findings) -> Option<Layout> {
    let (nv, nh) = (
        count(tokens, start + 3, "vertical", findings),
        count(tokens, start + 4, "horizontal", findings),
    );
    if tokens.len() < start + 10 {
        let last = tokens.last().map_or(text.len(), |token| token.line + 1);
        findings.push(
            Finding::error(
                "ies-truncated",
                "the file ends before the ten numbers of lamp and geometry are complete",
            )
            .at(last.max(1), 1)
            .raw(text.line(last.saturating_sub(1)))
            .fix("fetch the file again"),
        );
        return None;
    }
    let (nv, nh) = (nv?, nh?);
    let stated = Layout::new(start, true, nv, nh);
    if stated.end() == tokens.len() && angles_rise(tokens, &stated) {
        return Some(stated);
    }
    let without_factors = Layout::new(start, false, nv, nh);
    if without_factors.end() == tokens.len() && angles_rise(tokens, &without_factors) {
        let at = tokens[start + 10];
        findings.push(
            Finding::error(
                "ies-ballast-missing",
                "ballast factor, photometric factor and watts are missing; the angles begin here",
            )
            .at(at.line + 1, at.column)
            .raw(text.line(at.line))
            .assumed("factors of 1, watts not stated")
            .fix("put the line with ballast factor, 1 and input watts back before the angles"),
        );
        return Some(without_factors);
    }
    if let Some(line) = doubled_line(tokens, start, &stated) {
        findings.push(
            Finding::error(
                "ies-line-doubled",
                "this line repeats the one before it, and there are too many numbers by just that line",
            )
            .at(line + 1, 1)
            .raw(text.line(line))
            .fix("remove the line"),
        );
        return None;
    }
    if let Some(layout) = wrong_count(tokens, start, nv, nh, findings) {
        return Some(layout);
    }
    blame(tokens, &stated, text, findings);
    None
}

fn count(tokens: &[Token<'_>], index: usize, what: &str, findings: &mut Findings) -> Option<usize> {
    let token = tokens.get(index)?;
    match token.value() {
        Some(value) if value.fract() == 0.0 && (1.0..=100_000.0).contains(&value) => Some(value as usize),
        _ => {
            findings.push(
                Finding::error("ies-count", format!("the number of {what} angles is needed here"))
                    .at(token.line + 1, token.column)
                    .raw(token.text)
                    .fix("compare the ten numbers with the format's description"),
            );
            None
        }
    }
}

/// Rising angles in both blocks; one that is no number may be damaged, the reader will say so.
fn angles_rise(tokens: &[Token<'_>], layout: &Layout) -> bool {
    rises(tokens, layout.vertical, layout.nv, 180.0) && rises(tokens, layout.horizontal, layout.nh, 360.0)
}

fn rises(tokens: &[Token<'_>], from: usize, count: usize, largest: f64) -> bool {
    let Some(block) = from.checked_add(count).and_then(|to| tokens.get(from..to)) else {
        return false;
    };
    let mut last = f64::NEG_INFINITY;
    let mut unreadable = 0;
    for token in block {
        match token.value() {
            Some(value) if value > last && (-360.0..=largest).contains(&value) => last = value,
            Some(_) => return false,
            None => unreadable += 1,
        }
    }
    unreadable <= 1
}

/// A line equal to the one before it, without which everything fits.
fn doubled_line(tokens: &[Token<'_>], start: usize, stated: &Layout) -> Option<usize> {
    let surplus = tokens.len().checked_sub(stated.end()).filter(|&surplus| surplus > 0)?;
    let mut lines: Vec<(usize, usize)> = Vec::new();
    for (index, token) in tokens.iter().enumerate() {
        if lines.last().is_none_or(|&(line, _)| line != token.line) {
            lines.push((token.line, index));
        }
    }
    let end_of = |at: usize| lines.get(at + 1).map_or(tokens.len(), |next| next.1);
    (1..lines.len()).find_map(|at| {
        let (line, from) = lines[at];
        let (before, to) = (lines[at - 1].1, end_of(at));
        let same = to - from == from - before
            && (from..to)
                .zip(before..from)
                .all(|(a, b)| tokens[a].text == tokens[b].text);
        if !same || to - from != surplus || from < start {
            return None;
        }
        let mut without: Vec<Token<'_>> = tokens[..from].to_vec();
        without.extend_from_slice(&tokens[to..]);
        angles_rise(&without, stated).then_some(line)
    })
}

fn run(tokens: &[Token<'_>], from: usize, largest: f64) -> usize {
    let mut last = f64::NEG_INFINITY;
    let rising = |token: &&Token<'_>| {
        let value = token
            .value()
            .filter(|value| *value > last && (-360.0..=largest).contains(value));
        last = value.unwrap_or(last);
        value.is_some()
    };
    tokens
        .get(from..)
        .map_or(0, |rest| rest.iter().take_while(rising).count())
}

/// One of the two counts contradicts the data, and another value of it fits exactly.
fn wrong_count(tokens: &[Token<'_>], start: usize, nv: usize, nh: usize, findings: &mut Findings) -> Option<Layout> {
    let vertical = run(tokens, start + 13, 180.0);
    let mut fits: Vec<(Layout, &str, usize, usize)> = Vec::new();
    for candidate in 2..=vertical {
        let layout = Layout::new(start, true, candidate, nh);
        if candidate != nv && layout.end() == tokens.len() && angles_rise(tokens, &layout) && usual(tokens, &layout) {
            fits.push((layout, "vertical", candidate, start + 3));
        }
    }
    let horizontal = run(tokens, start + 13 + nv, 360.0);
    for candidate in 1..=horizontal {
        let layout = Layout::new(start, true, nv, candidate);
        if candidate != nh && layout.end() == tokens.len() && angles_rise(tokens, &layout) && usual(tokens, &layout) {
            fits.push((layout, "horizontal", candidate, start + 4));
        }
    }
    let &[(layout, what, fitting, index)] = fits.as_slice() else {
        return None;
    };
    let token = tokens[index];
    findings.push(
        Finding::warning(
            "ies-count",
            format!("the number of {what} angles contradicts the data, which fit {fitting}"),
        )
        .at(token.line + 1, token.column)
        .raw(token.text)
        .assumed(fitting.to_string())
        .fix("correct the count"),
    );
    Some(layout)
}

/// Angles that begin and end where the standard has them: chance agreement of counts does not get there.
fn usual(tokens: &[Token<'_>], layout: &Layout) -> bool {
    let is = |index: usize, allowed: &[f64]| {
        let value = tokens.get(index).and_then(Token::value);
        value.is_some_and(|value| allowed.contains(&value))
    };
    is(layout.vertical, &[-90.0, 0.0, 90.0])
        && is(layout.horizontal - 1, &[90.0, 180.0])
        && is(layout.horizontal, &[-90.0, 0.0, 90.0])
        && (layout.nh == 1 || is(layout.candela - 1, &[90.0, 180.0, 270.0, 360.0]))
}

/// The first place where the numbers stop fitting.
fn blame(tokens: &[Token<'_>], stated: &Layout, text: &Text<'_>, findings: &mut Findings) {
    let mut broken = false;
    for (from, count, name, largest) in [
        (stated.vertical, stated.nv, "vertical", 180.0),
        (stated.horizontal, stated.nh, "horizontal", 360.0),
    ] {
        let length = run(tokens, from, largest);
        if length < count
            && let Some(token) = tokens.get(from + length)
            && !broken
        {
            broken = true;
            // Without the angle before, the rise goes on: that one is too large.
            let at = from + length;
            let previous = &tokens[at - 1];
            let values = (length > 1).then(|| (tokens[at - 2].value(), previous.value()));
            let too_large = match (values, token.value()) {
                (Some((Some(before), Some(odd))), Some(this)) => before < this && this < odd,
                _ => false,
            };
            let (token, word) = if too_large {
                (previous, "is larger than the one after it")
            } else {
                (token, "does not go on rising")
            };
            findings.push(
                Finding::error(
                    "ies-angles",
                    format!("{count} rising {name} angles are needed; this one {word}"),
                )
                .at(token.line + 1, token.column)
                .raw(token.text)
                .fix("a line or number before may be missing or doubled, or the count wrong"),
            );
        }
    }
    let (there, needed) = (tokens.len(), stated.end());
    if there == needed {
        return;
    }
    // A file that breaks off within a line is cut there.
    let place = (!broken && text.ends_with_newline)
        .then(|| lost_line(tokens, stated).or_else(|| plane_break(tokens, stated)))
        .flatten();
    let last = tokens.last().copied();
    let (token, code) = if there < needed {
        (place.or(last), "ies-values-missing")
    } else {
        (place.or(tokens.get(needed).copied()), "ies-values-extra")
    };
    let short = stated.candela.min(there);
    let message = format!(
        "{} candela values are there, {} are needed ({} × {})",
        there - short,
        stated.nv.saturating_mul(stated.nh),
        stated.nh,
        stated.nv
    );
    let mut finding =
        Finding::error(code, message).fix("a line may be missing or doubled, a number lost, or the file cut off");
    if let Some(token) = token {
        finding = finding.at(token.line + 1, token.column).raw(text.line(token.line));
    }
    findings.push(finding);
}

/// The line after which, or before which, a whole line of candela is missing: there the planes fit each other again.
fn lost_line<'t>(tokens: &[Token<'t>], stated: &Layout) -> Option<Token<'t>> {
    let candela = tokens.get(stated.candela..)?;
    let width = stated.end().checked_sub(tokens.len())?;
    let values: Vec<f64> = candela.iter().map(|token| token.value().unwrap_or(0.0)).collect();
    let mut starts: Vec<usize> = (0..candela.len())
        .filter(|&at| at == 0 || candela[at].line != candela[at - 1].line)
        .collect();
    starts.push(candela.len());
    let lengths: Vec<usize> = starts.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if !lengths.contains(&width) {
        return None;
    }
    let fitting = periodic(&lengths, width, stated);
    if !fitting.is_empty() {
        starts = fitting.into_iter().map(|line| starts[line]).collect();
    }
    let at = slip::missing(&values, stated.nv, width, &starts)?;
    candela.get(at).or(candela.last()).copied()
}

/// Lines before which one of `width` numbers makes every plane stand on lines of the same lengths.
fn periodic(lengths: &[usize], width: usize, stated: &Layout) -> Vec<usize> {
    let whole_plane = |lines: &mut dyn Iterator<Item = &usize>| -> Option<Vec<usize>> {
        let mut plane = Vec::new();
        let mut sum = 0;
        for &length in lines {
            plane.push(length);
            sum += length;
            if sum >= stated.nv {
                break;
            }
        }
        (sum == stated.nv).then_some(plane)
    };
    let from_end = || {
        let mut plane = whole_plane(&mut lengths.iter().rev())?;
        plane.reverse();
        Some(plane)
    };
    let Some(plane) = whole_plane(&mut lengths.iter()).or_else(from_end) else {
        return Vec::new();
    };
    let line = |index: usize| plane[index % plane.len()];
    if !(lengths.len() + 1).is_multiple_of(plane.len()) {
        return Vec::new();
    }
    let before = lengths
        .iter()
        .enumerate()
        .take_while(|&(at, &length)| length == line(at))
        .count();
    let after = lengths
        .iter()
        .enumerate()
        .rev()
        .take_while(|&(at, &length)| length == line(at + 1))
        .count();
    let first = lengths.len() - after;
    (first..=before).filter(|&at| line(at) == width).collect()
}

/// Where planes begin on lines of their own: the line at which the first plane that should begin does not.
fn plane_break<'t>(tokens: &[Token<'t>], stated: &Layout) -> Option<Token<'t>> {
    let begins = |index: usize| {
        index > 0
            && tokens
                .get(index)
                .is_some_and(|token| token.line != tokens[index - 1].line)
    };
    if !begins(stated.candela) {
        return None;
    }
    let mut at = stated.candela;
    for _ in 0..stated.nh {
        let next = at + stated.nv;
        if !begins(next) && next != tokens.len() {
            return tokens.get(next.min(tokens.len() - 1)).copied();
        }
        at = next;
    }
    None
}
