//! The numbers of an LM-63 file, one by one and in blocks.

use super::layout::Token;
use crate::finding::{Finding, Findings};
use crate::number;

/// Takes numbers one by one, and says what stands there instead.
pub(super) struct Reader<'r, 't> {
    pub(super) tokens: &'r [Token<'t>],
    pub(super) findings: &'r mut Findings,
}

impl Reader<'_, '_> {
    /// The file ends before what is needed.
    pub(super) fn ended(&mut self, what: &str) {
        let finding = Finding::error("ies-truncated", format!("the file ends before {what}"));
        let finding = match self.tokens.last() {
            Some(last) => finding.at(last.line + 1, last.column).raw(last.text),
            None => finding,
        };
        self.findings.push(finding.fix("fetch the file again"));
    }

    pub(super) fn number(&mut self, index: usize, what: &str, code: &'static str) -> Option<f64> {
        let Some(token) = self.tokens.get(index) else {
            self.ended(what);
            return None;
        };
        match number::read(token.text) {
            Ok(number) if !number.comma => Some(number.value),
            Ok(_) | Err(_) => {
                let why = number::read(token.text)
                    .err()
                    .map_or("this is not a number".to_owned(), |error| error.to_string());
                self.findings.push(
                    Finding::error(code, format!("{what}: {why}"))
                        .at(token.line + 1, token.column)
                        .raw(token.text)
                        .fix("correct the number"),
                );
                None
            }
        }
    }

    pub(super) fn block(&mut self, from: usize, count: usize, what: &str, code: &'static str) -> Option<Vec<f64>> {
        if from.saturating_add(count) > self.tokens.len() {
            self.ended(&format!("{count} numbers, each a {what}, are complete"));
            return None;
        }
        let mut values = Vec::with_capacity(count);
        for index in from..from + count {
            values.extend(self.number(index, what, code));
        }
        (values.len() == count).then_some(values)
    }

    /// Takes a finding about the number at `index`.
    pub(super) fn push(&mut self, index: usize, finding: Finding) {
        let finding = match self.tokens.get(index) {
            Some(token) => finding.at(token.line + 1, token.column).raw(token.text),
            None => finding,
        };
        self.findings.push(finding);
    }
}
