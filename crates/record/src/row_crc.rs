//! The last cell of a row that this program wrote: CRC-32 (IEEE) of the row up to and including its last comma.

/// A row with another checksum than its text has.
pub(crate) struct Damaged {
    /// As written.
    pub found: String,
    /// As computed.
    pub computed: String,
}

/// The checksum of `covered`, a row up to and including its last comma: eight hexadecimal digits.
pub(crate) fn of(covered: &[u8]) -> String {
    format!("{:08x}", crc32fast::hash(covered))
}

/// What the checksum of a row covers. `row` has no line end.
///
/// # Errors
/// [`Damaged`], also where the row is no UTF-8.
pub(crate) fn covered(row: &[u8]) -> Result<&str, Damaged> {
    let end = row.iter().rposition(|&byte| byte == b',').map_or(0, |comma| comma + 1);
    let (covered, written) = row.split_at(end);
    let computed = of(covered);
    let text = std::str::from_utf8(covered).ok();
    text.filter(|_| written == computed.as_bytes()).ok_or_else(|| Damaged {
        found: String::from_utf8_lossy(written).chars().take(16).collect(),
        computed,
    })
}
