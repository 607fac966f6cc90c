//! Where the blocks of an EULUMDAT file stand, also where its counts do not say so.
//!
//! The counts of lines 3, 4, 6 and 26 fix how many lines there must be. Where they do not fit what is there, the angle
//! blocks are the landmarks: C rises, then falls back to the first γ, γ rises, and what follows is a whole number of
//! planes. One explanation that fits exactly is an assumption with a finding; none is an error where it begins to fail.

use super::document::stored_planes;
use crate::finding::{Finding, Findings};
use crate::number;
use crate::slip;
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

impl Token<'_> {
    pub(super) fn value(&self) -> Option<f64> {
        number::read(self.text).ok().map(|number| number.value)
    }
}

/// The counts that a file follows, and its value blocks.
#[derive(Debug)]
pub(super) struct Layout<'t> {
    pub isym: u8,
    pub sets: usize,
    /// Header line (zero-based field index) → zero-based line of the file; differs where a line is missing or doubled.
    pub lines: Vec<Option<usize>>,
    /// Direct ratios; `None` where their block is damaged.
    pub ratios: Option<Vec<Token<'t>>>,
    pub c: Vec<Token<'t>>,
    pub gamma: Vec<Token<'t>>,
    pub intensity: Vec<Token<'t>>,
    /// The intensity block has as many values as it needs; where not, nothing of it can be trusted.
    pub complete: bool,
}

/// Counts of the header.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Counts {
    isym: u8,
    mc: usize,
    ng: usize,
    sets: usize,
}

/// Where a line is missing or one too many, zero-based.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Slip {
    None,
    Missing(usize),
    Extra(usize),
}

impl Slip {
    /// The line of the file that holds line `index` of an undamaged one.
    fn line(self, index: usize) -> Option<usize> {
        match self {
            Self::None => Some(index),
            Self::Missing(at) => (index != at).then(|| if index > at { index - 1 } else { index }),
            Self::Extra(at) => Some(if index >= at { index + 1 } else { index }),
        }
    }

    /// Lines of an undamaged file where this one has `lines`.
    fn length(self, lines: usize) -> usize {
        match self {
            Self::None => lines,
            Self::Missing(_) => lines + 1,
            Self::Extra(_) => lines.saturating_sub(1),
        }
    }
}

/// Finds the blocks, or says where the file stops making sense.
pub(super) fn find<'t>(text: &'t Text<'_>, findings: &mut Findings) -> Option<Layout<'t>> {
    let end = (0..text.len())
        .rev()
        .find(|&line| !blank(text.line(line)))
        .map_or(0, |last| last + 1);
    let direct = counts(text, Slip::None);
    if let Some(counts) = direct {
        if let Some(layout) = exact(text, end, counts, Slip::None) {
            return Some(layout);
        }
        if let Some(layout) = retokenised(text, end, counts, findings) {
            return Some(layout);
        }
    }
    if let Some(layout) = one_slip(text, end, findings) {
        return Some(layout);
    }
    if let Some(counts) = direct {
        if let Some(layout) = wrong_count(text, end, counts, findings) {
            return Some(layout);
        }
        return incomplete(text, end, counts, findings);
    }
    complain_of_header(text, findings);
    None
}

fn blank(line: &str) -> bool {
    line.trim_matches([' ', '\t', '\u{a0}', '\0', '\u{1a}']).is_empty()
}

fn whole(text: &Text<'_>, line: Option<usize>) -> Option<usize> {
    let value = number::read(text.line(line?)).ok()?.value;
    ((0.0..=100_000.0).contains(&value) && value.fract() == 0.0).then_some(value as usize)
}

/// The counts at their lines; none where one of them cannot be a count.
fn counts(text: &Text<'_>, slip: Slip) -> Option<Counts> {
    let isym = whole(text, slip.line(2)).filter(|&isym| isym <= 4)? as u8;
    let mc = whole(text, slip.line(3)).filter(|&mc| mc >= 1)?;
    let ng = whole(text, slip.line(5)).filter(|&ng| ng >= 2)?;
    let sets = whole(text, slip.line(25)).filter(|&sets| sets >= 1)?;
    Some(Counts { isym, mc, ng, sets })
}

fn token<'t>(text: &'t Text<'_>, line: usize) -> Token<'t> {
    let whole = text.line(line);
    let bytes = whole.as_bytes();
    if let ([first, ..], [.., last]) = (bytes, bytes)
        && first.is_ascii_graphic()
        && last.is_ascii_graphic()
    {
        return Token {
            line,
            column: 1,
            text: whole,
        };
    }
    let start = whole.len() - whole.trim_start().len();
    Token {
        line,
        column: start + 1,
        text: whole.trim(),
    }
}

/// One value a line, counts and angles as they must be. Damage inside the intensities or direct ratios is seen later.
fn exact<'t>(text: &'t Text<'_>, end: usize, counts: Counts, slip: Slip) -> Option<Layout<'t>> {
    let Counts { isym, mc, ng, sets } = counts;
    let ratios_at = HEADER + 6 * sets;
    let c_at = ratios_at + 10;
    let gamma_at = c_at + mc;
    let intensity_at = gamma_at + ng;
    let values = stored_planes(isym, mc).checked_mul(ng)?;
    if slip.length(end) != intensity_at.checked_add(values)? {
        return None;
    }
    let tokens = |from: usize, to: usize| -> Option<Vec<Token<'t>>> {
        let mut tokens = Vec::with_capacity(to - from);
        for index in from..to {
            tokens.push(token(text, slip.line(index)?));
        }
        Some(tokens)
    };
    let (c, gamma) = (tokens(c_at, gamma_at)?, tokens(gamma_at, intensity_at)?);
    if !plausible_angles(&c, 360.0) || !plausible_angles(&gamma, 180.0) {
        return None;
    }
    Some(Layout {
        isym,
        sets,
        lines: (0..ratios_at).map(|index| slip.line(index)).collect(),
        ratios: tokens(ratios_at, c_at),
        c,
        gamma,
        intensity: tokens(intensity_at, intensity_at + values)?,
        complete: true,
    })
}

/// Angles that rise within their range. What is no number may be a damaged angle: the reader will say so.
fn plausible_angles(tokens: &[Token<'_>], largest: f64) -> bool {
    let mut last = f64::NEG_INFINITY;
    let mut unreadable = 0;
    for token in tokens {
        match token.value() {
            Some(value) if value > last && (-180.0..=largest).contains(&value) => last = value,
            Some(_) => return false,
            None => unreadable += 1,
        }
    }
    unreadable <= 1
}

/// Several values on a line, or blank lines between them: the blocks fit once they are read as a stream.
fn retokenised<'t>(text: &'t Text<'_>, end: usize, counts: Counts, findings: &mut Findings) -> Option<Layout<'t>> {
    let ratios_at = HEADER + 6 * counts.sets;
    let mut tokens: Vec<Token<'t>> = Vec::new();
    let mut odd: Vec<Finding> = Vec::new();
    for line in ratios_at..end {
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
        let found = tokens.len() - before;
        if found == 0 {
            odd.push(
                Finding::warning("ldt-blank-line", "a blank line stands among the values")
                    .at(line + 1, 1)
                    .assumed("no value here")
                    .fix("remove the line"),
            );
        } else if found > 1 {
            odd.push(
                Finding::warning("ldt-values-on-line", format!("{found} values stand on one line"))
                    .at(line + 1, 1)
                    .raw(whole)
                    .assumed("one after the other")
                    .fix("write one value a line"),
            );
        }
    }
    if odd.is_empty() {
        return None;
    }
    let Counts { isym, mc, ng, sets } = counts;
    let values = stored_planes(isym, mc).checked_mul(ng)?;
    let needed = 10 + mc + ng + values;
    if tokens.len() < needed {
        return None;
    }
    let extra = tokens.split_off(needed);
    let intensity = tokens.split_off(10 + mc + ng);
    let gamma = tokens.split_off(10 + mc);
    let c = tokens.split_off(10);
    if !plausible_angles(&c, 360.0) || !plausible_angles(&gamma, 180.0) {
        return None;
    }
    findings.extend(odd);
    if let Some(first) = extra.first() {
        findings.push(trailing(first, extra.len()));
    }
    let lines = (0..ratios_at).map(Some).collect();
    Some(Layout {
        isym,
        sets,
        lines,
        ratios: Some(tokens),
        c,
        gamma,
        intensity,
        complete: true,
    })
}

fn trailing(first: &Token<'_>, count: usize) -> Finding {
    Finding::error(
        "ldt-values-extra",
        format!("{count} more values follow the last intensity that the counts allow"),
    )
    .at(first.line + 1, first.column)
    .raw(first.text)
    .fix("compare lines 3, 4 and 6 with the data; a line may be doubled")
}

/// One line missing or one too many before the intensities: the angle blocks fit once it is put right.
fn one_slip<'t>(text: &'t Text<'_>, end: usize, findings: &mut Findings) -> Option<Layout<'t>> {
    let mut fits: Vec<(Slip, Layout<'t>)> = Vec::new();
    // Beyond the angle blocks a slip does not move them; the widest block is bounded by the file itself.
    let last = end.min(HEADER + 6 * 20 + 10 + 4000);
    for at in 0..last {
        for slip in [Slip::Extra(at), Slip::Missing(at)] {
            // A doubled line equals its neighbour; other extra lines are not told from damage.
            if matches!(slip, Slip::Extra(_)) && (at == 0 || text.line(at) != text.line(at - 1)) {
                continue;
            }
            let Some(counts) = counts(text, slip) else { continue };
            let angles_from = HEADER + 6 * counts.sets + 10;
            let angles_to = angles_from + counts.mc + counts.ng;
            if at >= angles_to || !header_plausible(text, slip, counts) {
                continue;
            }
            if (angles_from..angles_to).contains(&at) && matches!(slip, Slip::Missing(_)) {
                continue;
            }
            if let Some(layout) = exact(text, end, counts, slip) {
                fits.push((slip, layout));
            }
        }
    }
    // A doubled line is seen; of the places where one may be missing, texts come before numbers.
    let first_extra = fits
        .iter()
        .position(|(slip, _)| matches!(slip, Slip::Extra(_)))
        .or_else(|| {
            fits.iter()
                .position(|(slip, _)| matches!(slip, Slip::Missing(0 | 7..=11)))
        });
    if fits.is_empty() {
        return None;
    }
    let (slip, mut layout) = fits.remove(first_extra.unwrap_or(0));
    let ratios_at = HEADER + 6 * layout.sets;
    let (at, finding) = match slip {
        Slip::Extra(at) => (
            at,
            Finding::error(
                "ldt-line-doubled",
                "this line repeats the one before it, and everything after it stands one line too low",
            )
            .raw(text.line(at))
            .assumed("the line is not there")
            .fix("remove the line"),
        ),
        Slip::Missing(at) => (
            at,
            Finding::error(
                "ldt-line-missing",
                format!(
                    "a line is missing from here; {} fits only so",
                    block_name(at, layout.sets)
                ),
            )
            .raw(text.line(at))
            .assumed("an empty line")
            .fix("put the missing line back"),
        ),
        Slip::None => return Some(layout),
    };
    findings.push(finding.at(at + 1, 1));
    if at >= ratios_at && layout.ratios.is_none() {
        return Some(layout);
    }
    if at >= ratios_at {
        layout.ratios = None;
    }
    // Which of several numbers is missing cannot be known, and one of them scales the light.
    if (12..ratios_at).contains(&at) {
        layout.complete = false;
    }
    Some(layout)
}

/// Lines 13–25 and the numbers of the lamp sets are numbers or blank.
fn header_plausible(text: &Text<'_>, slip: Slip, counts: Counts) -> bool {
    let numeric = |index: usize| {
        slip.line(index).is_none_or(|line| {
            let line = text.line(line);
            blank(line) || number::read(line).is_ok()
        })
    };
    let heads = [1, 4, 6].into_iter().chain(12..25).all(numeric);
    let sets = (0..counts.sets.min(20)).all(|set| numeric(HEADER + 6 * set) && numeric(HEADER + 6 * set + 2));
    let flux = slip
        .line(HEADER + 2)
        .and_then(|line| number::read(text.line(line)).ok())
        .is_some_and(|f| f.value > 0.0);
    heads && sets && flux
}

fn block_name(at: usize, sets: usize) -> &'static str {
    match at {
        _ if at < HEADER => "the header",
        _ if at < HEADER + 6 * sets => "the lamp sets",
        _ => "the direct ratios",
    }
}

/// Values of the stream from `from`, one a line.
fn stream<'t>(text: &'t Text<'_>, from: usize, end: usize) -> Vec<Token<'t>> {
    (from..end).map(|line| token(text, line)).collect()
}

/// Length of the rising run of angles that starts at `from`.
fn run(tokens: &[Token<'_>], from: usize, largest: f64) -> usize {
    let mut last = f64::NEG_INFINITY;
    let mut length = 0;
    for token in tokens.iter().skip(from) {
        match token.value() {
            Some(value) if value > last && (-180.0..=largest).contains(&value) => last = value,
            _ => break,
        }
        length += 1;
    }
    length
}

/// The data contradict one of the counts, and another value of it fits exactly.
fn wrong_count<'t>(text: &'t Text<'_>, end: usize, stated: Counts, findings: &mut Findings) -> Option<Layout<'t>> {
    let mut candidates: Vec<(Counts, &'static str, usize)> = Vec::new();
    for sets in 1..=stated.sets + 4 {
        let c_at = HEADER + 6 * sets + 10;
        if c_at >= end {
            break;
        }
        let tokens = stream(text, c_at, end);
        let mc = run(&tokens, 0, 360.0);
        let gammas = run(&tokens, mc, 180.0);
        if mc == 0 || gammas < 2 {
            continue;
        }
        let mut try_counts = |counts: Counts| {
            let needed = stored_planes(counts.isym, counts.mc) * counts.ng;
            let there = counts.mc + counts.ng + needed == tokens.len();
            let changed = [
                (counts.sets != stated.sets, "sets", 25),
                (counts.mc != stated.mc, "Mc", 3),
                (counts.ng != stated.ng, "Ng", 5),
                (counts.isym != stated.isym, "Isym", 2),
            ];
            let wrong: Vec<_> = changed.iter().filter(|(changed, ..)| *changed).collect();
            if let ([(_, name, line)], true) = (wrong.as_slice(), there) {
                candidates.push((counts, name, *line));
            }
        };
        try_counts(Counts { sets, ..stated });
        if sets != stated.sets {
            continue;
        }
        try_counts(Counts { mc, ..stated });
        // γ up to 90 may run on into intensities that happen to rise: every length is tried.
        for ng in 2..=gammas {
            if mc == stated.mc {
                try_counts(Counts { ng, ..stated });
            }
        }
        if mc == stated.mc && gammas >= stated.ng {
            for isym in 0..=4 {
                try_counts(Counts { isym, ..stated });
            }
        }
    }
    candidates.dedup();
    // Isym 2 and 3 store the same number of planes: which one is meant cannot be told from the count.
    let &(counts, name, line) = candidates.first()?;
    let alternatives = candidates.iter().filter(|other| other.0 != counts).count();
    let layout = exact(text, end, counts, Slip::None)?;
    let value = match name {
        "sets" => counts.sets,
        "Mc" => counts.mc,
        "Ng" => counts.ng,
        _ => usize::from(counts.isym),
    };
    let raw = text.line(line);
    let message = format!("{name} contradicts the data, which fit {value}");
    let mut finding = if alternatives == 0 && name != "Isym" {
        Finding::warning("ldt-count", message)
    } else {
        Finding::error("ldt-count", message)
    };
    finding = finding
        .at(line + 1, 1)
        .raw(raw.trim())
        .assumed(format!("{name} = {value}"))
        .fix("correct the count");
    findings.push(finding);
    (alternatives == 0).then_some(layout)
}

/// Header and angles stand where they must, the intensities are too few or too many.
fn incomplete<'t>(text: &'t Text<'_>, end: usize, counts: Counts, findings: &mut Findings) -> Option<Layout<'t>> {
    let Counts { isym, mc, ng, sets } = counts;
    let ratios_at = HEADER + 6 * sets;
    let c_at = ratios_at + 10;
    let needed = stored_planes(isym, mc).saturating_mul(ng);
    let intensity_at = c_at + mc + ng;
    let all = intensity_at.saturating_add(needed);
    if end <= intensity_at {
        findings.push(
            Finding::error(
                "ldt-truncated",
                format!("the file ends after {end} lines; its counts need {all}"),
            )
            .at(end.max(1), 1)
            .raw(text.line(end.saturating_sub(1)))
            .fix("fetch the file again"),
        );
        return None;
    }
    let (c, gamma) = (stream(text, c_at, c_at + mc), stream(text, c_at + mc, intensity_at));
    let mut broken = false;
    for (tokens, name, largest) in [(&c, "C", 360.0), (&gamma, "γ", 180.0)] {
        let length = run(tokens, 0, largest);
        if let Some(token) = tokens.get(length) {
            if !broken {
                findings.push(angle_break(tokens, length, name, token));
            }
            broken = true;
        }
    }
    let mut intensity = stream(text, intensity_at, end);
    if !broken || intensity.len() + 1 < needed {
        findings.extend(count_of_intensities(&intensity, needed, ng, text, end));
    }
    intensity.truncate(needed);
    let lines = (0..ratios_at).map(Some).collect();
    let ratios = Some(stream(text, ratios_at, c_at));
    Some(Layout {
        isym,
        sets,
        lines,
        ratios,
        c,
        gamma,
        intensity,
        complete: false,
    })
}

/// What is wrong with the number of intensities, at the line where it goes wrong if that shows.
fn count_of_intensities(
    intensity: &[Token<'_>],
    needed: usize,
    ng: usize,
    text: &Text<'_>,
    end: usize,
) -> Option<Finding> {
    let there = intensity.len();
    let values: Vec<f64> = intensity.iter().map(|token| token.value().unwrap_or(0.0)).collect();
    let repeated = || -> Vec<usize> { (1..there).filter(|&at| values[at] == values[at - 1]).collect() };
    if there == needed + 1
        && let Some(at) = slip::extra(&values, ng, 1, &repeated())
    {
        let token = &intensity[at];
        let run = run_of_equals(&values, at, intensity);
        let message = format!("one intensity too many; the planes fit each other without this repeated line{run}");
        let finding = Finding::error("ldt-line-doubled", message).at(token.line + 1, token.column);
        return Some(finding.raw(token.text).fix("remove the line"));
    }
    if there > needed {
        return Some(trailing(&intensity[needed], there - needed));
    }
    if there + 1 == needed
        && let Some(at) = slip::missing(&values, ng, 1, &(0..there).collect::<Vec<_>>())
    {
        let token = &intensity[at];
        let run = run_of_equals(&values, at, intensity);
        let message = format!("one intensity too few; the planes fit each other with one more before this line{run}");
        let finding = Finding::error("ldt-line-missing", message).at(token.line + 1, token.column);
        return Some(finding.raw(token.text).fix("put the missing line back"));
    }
    let message = format!(
        "{there} intensities are there, {needed} are needed ({} planes × {ng})",
        needed / ng
    );
    (there < needed).then(|| {
        Finding::error("ldt-values-missing", message)
            .at(end, 1)
            .raw(text.line(end - 1))
            .fix("fetch the file again; a line may be missing or the file cut off")
    })
}

/// In a run of equal values nobody can tell which line it was: the lines of the run, for a message.
fn run_of_equals(values: &[f64], at: usize, tokens: &[Token<'_>]) -> String {
    let Some(&value) = at.checked_sub(1).and_then(|before| values.get(before)) else {
        return String::new();
    };
    let first = values[..at]
        .iter()
        .rposition(|&other| other != value)
        .map_or(0, |odd| odd + 1);
    let behind = values[at..].iter().position(|&other| other != value);
    let last = at + behind.unwrap_or(values.len() - at);
    if last < first + 2 {
        return String::new();
    }
    let (from, to) = (tokens[first].line + 1, tokens[last - 1].line + 1);
    format!("; lines {from} to {to} are equal, and it may be any of them")
}

/// The first angle after a step twice as large as all others: what should stand between is missing.
fn gap(tokens: &[Token<'_>], run: usize) -> Option<usize> {
    let angles: Vec<f64> = tokens[..run].iter().filter_map(Token::value).collect();
    let step = angles.get(1)? - angles.first()?;
    let step = step.min(angles.get(2)? - angles[1]);
    let mut odd = (1..run).filter(|&at| (angles[at] - angles[at - 1] - step).abs() > 1e-6);
    let at = odd.next()?;
    ((angles[at] - angles[at - 1] - 2.0 * step).abs() < 1e-6 && odd.next().is_none()).then_some(at)
}

/// The angle that breaks the rise: a missing or doubled line, or a damaged number.
fn angle_break(tokens: &[Token<'_>], at: usize, name: &str, token: &Token<'_>) -> Finding {
    let doubled = at > 0 && tokens[at - 1].value().is_some() && tokens[at - 1].value() == token.value();
    let gap = gap(tokens, at).filter(|_| !doubled && at + 1 >= tokens.len());
    let token = gap.map_or(token, |gap| &tokens[gap]);
    // Without the angle before, the rise goes on: that one is too large.
    if gap.is_none()
        && !doubled
        && at > 1
        && let (Some(this), Some(odd), Some(before)) = (token.value(), tokens[at - 1].value(), tokens[at - 2].value())
        && before < this
        && this < odd
    {
        let odd = &tokens[at - 1];
        let message = format!("this {name} angle is larger than the one after it; two angles may have changed places");
        return Finding::error("ldt-angles", message)
            .at(odd.line + 1, odd.column)
            .raw(odd.text)
            .fix("compare the angles with lines 4 to 7");
    }
    let message = if gap.is_some() {
        format!("one {name} angle is missing before this one, where the step is twice that of all others")
    } else if doubled {
        format!("this {name} angle repeats the one before it; a line may be doubled")
    } else {
        format!("the {name} angles do not go on rising here; a line before may be missing or a count wrong")
    };
    Finding::error("ldt-angles", message)
        .at(token.line + 1, token.column)
        .raw(token.text)
        .fix("compare the angles with lines 4 to 7")
}

/// Which of the four counts cannot be one.
fn complain_of_header(text: &Text<'_>, findings: &mut Findings) {
    let wanted = [
        (2, "the symmetry indicator (0 to 4)", 0, 4),
        (3, "the number of C planes", 1, 100_000),
        (5, "the number of γ angles", 2, 100_000),
        (25, "the number of lamp sets", 1, 100_000),
    ];
    for (line, what, least, most) in wanted {
        if line >= text.len() {
            findings.push(
                Finding::error(
                    "ldt-truncated",
                    format!("the file ends before line {}, {what}", line + 1),
                )
                .at(text.len().max(1), 1)
                .fix("fetch the file again"),
            );
            return;
        }
        if !whole(text, Some(line)).is_some_and(|value| (least..=most).contains(&value)) {
            findings.push(
                Finding::error(
                    "ldt-header",
                    format!("{what} is needed here; a line before may be missing or doubled"),
                )
                .at(line + 1, 1)
                .raw(text.line(line))
                .fix("compare lines 1 to 26 with the format's description"),
            );
        }
    }
}
