//! A lux meter's language on its link: one request or reading, confirmed by nothing.

use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use isolux_device::{DeviceError, LuxOutcome, LuxRange, LuxReading};
use isolux_transport::ExclusiveAccess;
use isolux_units::Lux;
use tokio::time::Instant;

use crate::language::{Converts, Failure, Language, Link, Meaning};

/// Over and above the conversion itself: both ways on the line, and a USB chip that waits for more bytes.
const ANSWERS_WITHIN: Duration = Duration::from_millis(200);

/// A language on its link.
pub(crate) struct Connected<L: Language> {
    pub link: Link<L::Conversation>,
    pub language: L,
    /// As it was chosen.
    range: Mutex<LuxRange>,
}

impl<L: Language> Connected<L> {
    /// Puts `language` on `link`, in the automatic range.
    pub fn new(link: Link<L::Conversation>, language: L) -> Self {
        Self {
            link,
            language,
            range: Mutex::new(LuxRange::Auto),
        }
    }

    /// The range that was chosen.
    pub fn range(&self) -> LuxRange {
        *self.range.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// From now on this range is chosen.
    pub fn chosen(&self, range: LuxRange) {
        *self.range.lock().unwrap_or_else(PoisonError::into_inner) = range;
    }

    /// Light of so long before a request may be in its answer now.
    pub fn reach(&self) -> Duration {
        self.language.timing().reach(self.range())
    }

    /// The longest that the answer to a sample takes: in a fixed range, one conversion.
    pub fn patience(&self) -> Duration {
        let timing = self.language.timing();
        match (self.range(), timing.converts) {
            (LuxRange::Fixed(_), Converts::OnRequest) => (timing.integration + ANSWERS_WITHIN).min(timing.answer),
            _ => timing.answer,
        }
    }

    /// One reading asked for and answered within `patience`, confirmed by nothing.
    pub async fn exchange(
        &self,
        line: &ExclusiveAccess<'_, L::Conversation>,
        patience: Duration,
        deadline: Instant,
    ) -> Result<LuxReading, DeviceError> {
        let (range, timing) = (self.range(), self.language.timing());
        let (mut sent, mut ended) = (None, Instant::now());
        let (mut action, mut answers) = (String::new(), Vec::new());
        for (request, name) in self.language.reading(range) {
            let exchanged = self.link.ask(line, (request, &name), patience, deadline).await?;
            if sent.is_none() {
                (sent, ended, action) = (Some(exchanged.sent), Instant::now(), name);
            }
            answers.push(exchanged.answer);
        }
        let evidence: Vec<u8> = answers.iter().flat_map(L::bytes).copied().collect();
        let failed = |failure| self.link.failure(&action, failure, evidence.clone());
        let stated = self.language.stated(range, &answers).map_err(failed)?;
        let lux = |value| Lux::new(value).map_err(|error| failed(Failure::malformed(error)));
        let outcome = match stated.meaning {
            Meaning::Lux(value) => LuxOutcome::Measured(lux(value)?),
            Meaning::OverRange => LuxOutcome::OverRange,
            Meaning::UnderRange => LuxOutcome::UnderRange,
            Meaning::Error(reason) => return Err(failed(Failure::Fault(reason))),
        };
        Ok(LuxReading {
            outcome,
            range: stated.range,
            confirmed_by: None,
            digit: lux(stated.digit_lx)?,
            began: sent.unwrap_or(ended) - timing.reach(range),
            ended,
            caution: stated.caution,
            retries: 0,
            evidence,
        })
    }
}
