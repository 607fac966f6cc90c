//! What a reader has to say about a file beside its content.

use std::num::NonZeroU32;

use serde::Serialize;

/// How much a finding weighs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// A legal variant.
    Note,
    /// An assumption was made.
    Warning,
    /// Not trustworthy.
    Error,
}

impl Severity {
    /// The word that stands for it in front of a message.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Note => "note",
            Self::Warning => "warning",
            Self::Error => "error",
        }
    }
}

/// One thing that a reader found, with where it stands and how to correct it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// Stable name, `format-what`; programs match on it.
    pub code: &'static str,
    /// How much it weighs.
    pub severity: Severity,
    /// One-based line; none where the finding is about the whole file.
    pub line: Option<usize>,
    /// One-based column, in characters.
    pub column: Option<NonZeroU32>,
    /// First byte and the one beyond the last, where a file has no lines.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bytes: Option<Box<[u64; 2]>>,
    /// The text that stands there.
    pub raw: Option<Box<str>>,
    /// What was assumed to go on.
    pub assumed: Option<Box<str>>,
    /// What was found: one sentence in lower case, no full stop.
    pub message: Box<str>,
    /// How to correct it.
    pub fix: Option<Box<str>>,
    /// Where else the same was found: one cause is one finding, however many lines it has.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub also: Option<Box<Also>>,
}

/// The other places of a finding.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Also {
    /// In the order of their lines.
    pub places: Vec<Place>,
    /// How many there are beyond these.
    pub more: usize,
}

/// Where a finding stands once more.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Place {
    /// One-based line.
    pub line: Option<usize>,
    /// One-based column, in characters.
    pub column: Option<NonZeroU32>,
    /// The text that stands there.
    pub raw: Option<Box<str>>,
    /// What was found, where it differs from what was found first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub message: Option<Box<str>>,
}

impl Finding {
    /// A finding about the whole file; [`at`](Self::at) gives it a place.
    pub fn new(severity: Severity, code: &'static str, message: impl Into<String>) -> Self {
        Self {
            code,
            severity,
            line: None,
            column: None,
            bytes: None,
            raw: None,
            assumed: None,
            message: message.into().into_boxed_str(),
            fix: None,
            also: None,
        }
    }

    /// Not trustworthy.
    pub fn error(code: &'static str, message: impl Into<String>) -> Self {
        Self::new(Severity::Error, code, message)
    }

    /// An assumption was made.
    pub fn warning(code: &'static str, message: impl Into<String>) -> Self {
        Self::new(Severity::Warning, code, message)
    }

    /// A legal variant.
    pub fn note(code: &'static str, message: impl Into<String>) -> Self {
        Self::new(Severity::Note, code, message)
    }

    /// The same finding at a one-based line and column.
    #[must_use]
    pub fn at(mut self, line: usize, column: usize) -> Self {
        self.line = Some(line);
        self.column = NonZeroU32::new(u32::try_from(column).unwrap_or(u32::MAX));
        self
    }

    /// The same finding at these bytes, the last one exclusive.
    #[must_use]
    pub fn bytes(mut self, span: [u64; 2]) -> Self {
        self.bytes = Some(Box::new(span));
        self
    }

    /// The same finding with the text that stands there (long texts are cut at 80 characters).
    #[must_use]
    pub fn raw(mut self, text: &str) -> Self {
        let mut cut: String = text.chars().take(80).collect();
        if cut.len() < text.len() {
            cut.push('…');
        }
        self.raw = Some(cut.into_boxed_str());
        self
    }

    /// The same finding with what was assumed.
    #[must_use]
    pub fn assumed(mut self, what: impl Into<String>) -> Self {
        self.assumed = Some(what.into().into_boxed_str());
        self
    }

    /// The same finding with how to correct it.
    #[must_use]
    pub fn fix(mut self, how: impl Into<String>) -> Self {
        self.fix = Some(how.into().into_boxed_str());
        self
    }
}

/// Collects findings; after [`Findings::PER_CODE`] of one code the rest are only counted, so that a damaged file of a
/// million numbers gives a short answer.
#[derive(Debug, Clone, Default)]
pub struct Findings {
    list: Vec<Finding>,
    dropped: Vec<(&'static str, Severity, usize)>,
}

impl Findings {
    /// Places of one code that are kept whole.
    pub const PER_CODE: usize = 20;

    /// No finding yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes one finding.
    pub fn push(&mut self, finding: Finding) {
        if self.list.iter().filter(|kept| kept.code == finding.code).count() < Self::PER_CODE {
            self.list.push(finding);
        } else if let Some(entry) = self.dropped.iter_mut().find(|(code, ..)| *code == finding.code) {
            entry.1 = entry.1.max(finding.severity);
            entry.2 += 1;
        } else {
            self.dropped.push((finding.code, finding.severity, 1));
        }
    }

    /// Takes all findings of `others`.
    pub fn extend(&mut self, others: impl IntoIterator<Item = Finding>) {
        for finding in others {
            self.push(finding);
        }
    }

    /// One finding a code and severity, with all its places: errors first, then in the order of their lines, those
    /// about the whole file last.
    pub fn into_vec(self) -> Vec<Finding> {
        let mut list = self.list;
        list.sort_by_key(Finding::place);
        let mut grouped: Vec<Finding> = Vec::new();
        for finding in list {
            match grouped.iter_mut().find(|first| first.is_like(&finding)) {
                Some(first) => first.take(finding),
                None => grouped.push(finding),
            }
        }
        for (code, severity, count) in self.dropped {
            let of_code = || {
                grouped
                    .iter()
                    .position(|kept| kept.code == code && kept.severity == severity)
            };
            if let Some(at) = of_code().or_else(|| grouped.iter().position(|kept| kept.code == code)) {
                let kept = &mut grouped[at];
                kept.severity = kept.severity.max(severity);
                kept.also.get_or_insert_default().more += count;
            }
        }
        sort(&mut grouped);
        grouped
    }
}

impl From<Finding> for Findings {
    fn from(finding: Finding) -> Self {
        Self {
            list: vec![finding],
            dropped: Vec::new(),
        }
    }
}

/// Errors first, then warnings, each in the order of their lines.
pub(crate) fn sort(findings: &mut [Finding]) {
    findings.sort_by_key(|finding| (std::cmp::Reverse(finding.severity), finding.place()));
}

impl Finding {
    /// The other places where the same was found.
    pub fn places(&self) -> &[Place] {
        self.also.as_deref().map_or(&[], |also| &also.places)
    }

    /// How many places there are beyond these.
    pub fn more(&self) -> usize {
        self.also.as_deref().map_or(0, |also| also.more)
    }

    /// What findings are ordered by.
    fn place(&self) -> (usize, Option<NonZeroU32>) {
        (self.line.unwrap_or(usize::MAX), self.column)
    }

    /// Whether both have one cause.
    fn is_like(&self, other: &Self) -> bool {
        self.code == other.code && self.severity == other.severity && self.bytes.is_none() && other.bytes.is_none()
    }

    /// Adds the place of another finding of the same cause.
    fn take(&mut self, other: Self) {
        self.also.get_or_insert_default().places.push(Place {
            line: other.line,
            column: other.column,
            raw: other.raw,
            message: (other.message != self.message).then_some(other.message),
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keeps_the_first_of_a_kind_and_counts_the_rest() {
        let mut findings = Findings::new();
        for line in 1..=50 {
            findings.push(Finding::warning("x-y", "z").at(line, 1));
        }
        let list = findings.into_vec();
        assert_eq!(list.len(), 1);
        assert_eq!((list[0].places().len(), list[0].more()), (Findings::PER_CODE - 1, 30));
        assert_eq!((list[0].line, list[0].places()[0].line), (Some(1), Some(2)));
    }

    #[test]
    fn errors_come_first_and_differences_are_kept() {
        let mut findings = Findings::new();
        findings.push(Finding::note("a-note", "n").at(1, 1));
        findings.push(Finding::warning("x-y", "second").at(9, 1));
        findings.push(Finding::warning("x-y", "first").at(5, 1));
        findings.push(Finding::error("z-error", "e").at(30, 1));
        let list = findings.into_vec();
        let codes: Vec<&str> = list.iter().map(|finding| finding.code).collect();
        assert_eq!(codes, ["z-error", "x-y", "a-note"]);
        assert_eq!(&*list[1].message, "first");
        assert_eq!(list[1].places()[0].message.as_deref(), Some("second"));
    }

    #[test]
    fn serialises_as_the_contract_has_it() {
        let finding = Finding::error("ldt-number", "no number").at(3, 1).raw("1O");
        let json = serde_json::to_value(&finding).unwrap();
        assert_eq!(json["severity"], "error");
        assert_eq!(json["line"], 3);
        assert!(json["assumed"].is_null());
    }
}
