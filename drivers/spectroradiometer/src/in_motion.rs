//! When the light of a spectrum was that nothing confirms.

use std::time::Duration;

use tokio::time::Instant;

/// Why a spectrum has no moment.
pub(crate) const READY: &str =
    "it was ready before its light could be integrated: it was stored, or answers an earlier request";

/// When the light of a spectrum began to be integrated that was asked for at `requested` and complete at `ended`.
///
/// A detector that integrates all the time gives an exposure that began when the one before was read out: asked without
/// a pause that is the moment of the request, or shortly before it. None where less than half of the exposure can lie
/// between: it was stored, and its light may be of any time before.
pub(crate) fn light_began(requested: Instant, ended: Instant, integration: Duration) -> Option<Instant> {
    let since = ended.saturating_duration_since(requested);
    if since < integration / 2 {
        return None;
    }
    Some(if since < integration {
        ended.checked_sub(integration)?
    } else {
        requested
    })
}
