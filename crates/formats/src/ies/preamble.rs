//! The lines before the numbers: version, keywords, labels, tilt.

use super::edition::Edition;
use crate::finding::{Finding, Findings};
use crate::text::Text;

/// One `[KEYWORD] text`; continuation lines (`[MORE]`) are joined by line breaks.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Keyword {
    pub name: String,
    pub text: String,
    pub line: usize,
}

/// How `TILT=` goes on.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Tilt {
    None,
    Include,
    File(String),
}

#[derive(Debug)]
pub(super) struct Preamble {
    pub edition: Edition,
    /// The version line as written; empty where there is none.
    pub version: String,
    pub keywords: Vec<Keyword>,
    pub labels: Vec<String>,
    pub tilt: Tilt,
    /// Zero-based line of `TILT=`; none where it is missing.
    pub tilt_line: Option<usize>,
    /// Zero-based first line of numbers.
    pub numbers_from: usize,
}

impl Preamble {
    /// Where the keywords name a unit of radiant intensity or radiation that no eye sees, and its name: watts per
    /// steradian in any keyword, or a radiation type that begins with UV or IR.
    pub(super) fn radiometric(&self) -> Option<(usize, String)> {
        let unit = self.keywords.iter().find_map(|keyword| {
            let tight = keyword.text.replace(" /", "/").replace("/ ", "/");
            let prefixed = ["mW/sr", "µW/sr", "uW/sr", "kW/sr", "W/sr"];
            let found = prefixed.into_iter().find(|unit| {
                tight.match_indices(unit).any(|(at, _)| {
                    let before = tight[..at].chars().next_back();
                    let after = tight[at + unit.len()..].chars().next();
                    // "lm/W/sr" is none, nor is the end of a word.
                    before.is_none_or(|before| !before.is_alphabetic() && before != '/')
                        && after.is_none_or(|after| !after.is_alphanumeric())
                })
            });
            found.map(|unit| (keyword.line, unit.to_owned()))
        });
        unit.or_else(|| {
            self.keywords.iter().find_map(|keyword| {
                let name = keyword.name.to_ascii_uppercase();
                let text = keyword.text.trim().to_ascii_uppercase();
                let unseen = ["UV", "IR", "ULTRAVIOLET", "INFRARED"];
                (name.trim_start_matches('_') == "RADIATIONTYPE" && unseen.iter().any(|kind| text.starts_with(kind)))
                    .then(|| (keyword.line, keyword.text.trim().to_owned()))
            })
        })
    }
}

pub(super) fn is_tilt(line: &str) -> bool {
    line.trim_start()
        .get(..5)
        .is_some_and(|start| start.eq_ignore_ascii_case("TILT="))
}

pub(super) fn read(text: &Text<'_>, findings: &mut Findings) -> Option<Preamble> {
    let first = (0..text.len()).find(|&line| !text.line(line).trim().is_empty())?;
    let tilt_line = (first..text.len()).find(|&line| is_tilt(text.line(line)));
    let (edition, version, from) = version(text, first, findings);
    let until = match tilt_line {
        Some(line) => line,
        None => first_numbers(text, from)?,
    };
    let (mut keywords, mut labels) = (Vec::<Keyword>::new(), Vec::new());
    for index in from..until {
        let line = text.line(index).trim_end();
        match keyword(line) {
            Some((name, words)) if name.eq_ignore_ascii_case("MORE") => match keywords.last_mut() {
                Some(last) => {
                    last.text.push('\n');
                    last.text.push_str(words);
                }
                None => findings.push(
                    Finding::warning(
                        "ies-keyword",
                        "[MORE] continues nothing; the keyword before it is missing",
                    )
                    .at(index + 1, 1)
                    .raw(line),
                ),
            },
            Some((name, words)) => {
                let name = name.trim().to_owned();
                keywords.push(Keyword {
                    name,
                    text: words.trim().to_owned(),
                    line: index,
                });
            }
            None if line.trim().is_empty() => {}
            None => {
                if edition > Edition::E1986 && !keywords.is_empty() {
                    let message = "this line begins with no [KEYWORD]";
                    findings.push(
                        Finding::note("ies-label", message)
                            .at(index + 1, 1)
                            .raw(line)
                            .assumed("a label"),
                    );
                }
                labels.push(line.to_owned());
            }
        }
    }
    let tilt = if let Some(line) = tilt_line {
        tilt(text, line, edition, findings)
    } else {
        findings.push(
            Finding::error("ies-tilt-missing", "no line begins with TILT=; numbers begin here")
                .at(until + 1, 1)
                .raw(text.line(until))
                .assumed("TILT=NONE before this line")
                .fix("put the line TILT=NONE back"),
        );
        Tilt::None
    };
    required(edition, &keywords, first, findings);
    let mut numbers_from = if tilt_line.is_some() { until + 1 } else { until };
    if tilt_line.is_some() && is_tilt(text.line(numbers_from)) {
        findings.push(
            Finding::error("ies-line-doubled", "a second line begins with TILT=")
                .at(numbers_from + 1, 1)
                .raw(text.line(numbers_from))
                .assumed("the line is not there")
                .fix("remove the line"),
        );
        numbers_from += 1;
    }
    Some(Preamble {
        edition,
        version,
        keywords,
        labels,
        tilt,
        tilt_line,
        numbers_from,
    })
}

/// A line of nothing but numbers, at least ten of them, or the first line of nothing but numbers.
fn first_numbers(text: &Text<'_>, from: usize) -> Option<usize> {
    (from..text.len()).find(|&line| {
        let line = text.line(line);
        let mut words = line.split([' ', '\t', ',']).filter(|word| !word.is_empty()).peekable();
        words.peek().is_some() && words.all(|word| crate::number::read(word).is_ok())
    })
}

fn version(text: &Text<'_>, first: usize, findings: &mut Findings) -> (Edition, String, usize) {
    let line = text.line(first).trim();
    let upper: String = line.to_ascii_uppercase().split_whitespace().collect();
    let exact = match upper.as_str() {
        "IESNA91" => Some(Edition::E1991),
        "IESNA:LM-63-1995" => Some(Edition::E1995),
        "IESNA:LM-63-2002" => Some(Edition::E2002),
        "IES:LM-63-2019" => Some(Edition::E2019),
        _ => None,
    };
    if let Some(edition) = exact {
        return (edition, line.to_owned(), first + 1);
    }
    if !upper.starts_with("IES") || upper.starts_with('[') {
        let bracketed = (first..text.len().min(first + 40)).any(|at| text.line(at).trim_start().starts_with('['));
        if bracketed && keyword(line).is_some() {
            findings.push(
                Finding::warning("ies-version-missing", "keywords, but no version line before them")
                    .at(first + 1, 1)
                    .raw(line)
                    .assumed("IESNA:LM-63-2002")
                    .fix("put the version line back"),
            );
            return (Edition::E2002, String::new(), first);
        }
        return (Edition::E1986, String::new(), first);
    }
    // "IESNA95", "IESNA:LM-63-95", "IESNA:LM-63-2019" and other hands' spellings: the last digits are the year.
    let digits: String = upper
        .chars()
        .rev()
        .take_while(char::is_ascii_digit)
        .collect::<Vec<_>>()
        .into_iter()
        .rev()
        .collect();
    let edition = match digits.as_str() {
        "86" | "1986" => Some(Edition::E1986),
        "91" | "1991" => Some(Edition::E1991),
        "94" | "1994" | "95" | "1995" => Some(Edition::E1995),
        "02" | "2002" => Some(Edition::E2002),
        "19" | "2019" | "20" | "2020" => Some(Edition::E2019),
        _ => None,
    };
    if let Some(edition) = edition {
        findings.push(
            Finding::note(
                "ies-version-spelling",
                "the version line is not spelled as the standard has it",
            )
            .at(first + 1, 1)
            .raw(line)
            .assumed(format!("LM-63-{}", edition.year())),
        );
        return (edition, line.to_owned(), first + 1);
    }
    findings.push(
        Finding::warning("ies-version-unknown", "the version line names no edition that is known")
            .at(first + 1, 1)
            .raw(line)
            .assumed("LM-63-2002")
            .fix("write IESNA:LM-63-2002 or the edition that is meant"),
    );
    (Edition::E2002, line.to_owned(), first + 1)
}

/// Name and text of a keyword line.
fn keyword(line: &str) -> Option<(&str, &str)> {
    let rest = line.trim_start().strip_prefix('[')?;
    let (name, words) = rest.split_once(']')?;
    Some((name, words.trim()))
}

fn tilt(text: &Text<'_>, line: usize, edition: Edition, findings: &mut Findings) -> Tilt {
    let raw = text.line(line).trim();
    let value = raw.get(5..).unwrap_or("").trim();
    if value.eq_ignore_ascii_case("NONE") {
        return Tilt::None;
    }
    if value.eq_ignore_ascii_case("INCLUDE") {
        return Tilt::Include;
    }
    if value.is_empty() {
        findings.push(
            Finding::error("ies-tilt", "TILT= names nothing")
                .at(line + 1, 6)
                .raw(raw)
                .assumed("NONE")
                .fix("write TILT=NONE"),
        );
        return Tilt::None;
    }
    if edition >= Edition::E2019 {
        findings.push(
            Finding::warning("ies-tilt-file", "the 2019 edition has no tilt files")
                .at(line + 1, 6)
                .raw(raw)
                .fix("use TILT=INCLUDE"),
        );
    }
    Tilt::File(value.to_owned())
}

/// Keywords that an edition demands; their absence changes no light.
fn required(edition: Edition, keywords: &[Keyword], first: usize, findings: &mut Findings) {
    let needed: &[&str] = match edition {
        Edition::E1986 => &[],
        Edition::E1991 | Edition::E1995 => &["TEST", "MANUFAC"],
        Edition::E2002 | Edition::E2019 => &["TEST", "TESTLAB", "ISSUEDATE", "MANUFAC"],
    };
    let missing: Vec<&str> = needed
        .iter()
        .copied()
        .filter(|name| !keywords.iter().any(|keyword| keyword.name.eq_ignore_ascii_case(name)))
        .collect();
    if !missing.is_empty() {
        let message = format!("LM-63-{} asks for [{}]", edition.year(), missing.join("], ["));
        let finding = Finding::note("ies-keyword-missing", message).at(first + 1, 1);
        findings.push(
            finding
                .assumed("not stated")
                .fix("a line may be missing; write the keyword, even with no text"),
        );
    }
}
