//! The answer to `SYSTem:ERRor?`.

/// One entry of an instrument's error queue: `-113,"Undefined header"`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct QueuedError {
    /// 0: the queue is empty. −1xx command, −2xx execution, −3xx device, −4xx query; positive: the maker's own.
    pub code: i32,
    /// In the instrument's words, without the quotes.
    pub text: String,
}

/// Not an entry.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("\"{0}\" is no entry of an error queue (number, \"text\")")]
pub struct NotAnError(String);

impl QueuedError {
    /// Reads an entry. A blank after the comma occurs, and a plus before the zero.
    ///
    /// # Errors
    /// [`NotAnError`].
    pub fn parse(answer: &str) -> Result<Self, NotAnError> {
        let wrong = || NotAnError(answer.to_owned());
        let (code, text) = answer.trim().split_once(',').ok_or_else(wrong)?;
        let code = code.parse().map_err(|_| wrong())?;
        let text = text.trim().strip_prefix('"').and_then(|text| text.strip_suffix('"'));
        let text = text.ok_or_else(wrong)?.to_owned();
        Ok(Self { code, text })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_number_decides_and_not_the_words() {
        for (answer, code, text) in [
            ("0,\"No error\"", 0, "No error"),
            ("+0, \"No error\"", 0, "No error"),
            (
                "-113,\"Undefined header; \"\"X\"\"\"",
                -113,
                "Undefined header; \"\"X\"\"",
            ),
        ] {
            let entry = QueuedError::parse(answer).unwrap();
            assert_eq!((entry.code, entry.text.as_str()), (code, text));
        }
        for wrong in ["", "0", "0,No error", "No error", "1.000E+00,1", "0,\""] {
            assert!(QueuedError::parse(wrong).is_err(), "{wrong}");
        }
    }
}
