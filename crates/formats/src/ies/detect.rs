//! Whether a text is LM-63.

use super::preamble;
use crate::eulumdat;
use crate::text::Text;

/// Whether this is LM-63: a version line, or a line that begins with `TILT=` in a file that does not count like
/// EULUMDAT (a luminaire may have such a name).
pub fn looks_like(head: &Text<'_>) -> bool {
    let first = head.line(0).trim_start().to_ascii_uppercase();
    let tilt = || head.lines().any(preamble::is_tilt) && !eulumdat::looks_like(head);
    first.starts_with("IESNA") || first.starts_with("IES:") || tilt()
}
