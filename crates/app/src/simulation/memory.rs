//! Whether a map fits into the memory that is free: a process that the system ends for want of memory says nothing.

use crate::Failure;

/// Bytes a pixel while a map is computed and written, by the peak of memory of maps of 1024² and 4096² pixels
/// (`/usr/bin/time -v isolux simulate`, 2026-11-22): 12 inverse in either precision, 32 direct in every sampling, 39
/// with `--tiff --csv --html`; with a window and a camera 30 inverse and 49.4 direct with all files.
const BYTES_PER_PIXEL: u64 = 50;

/// Refuses a map that does not fit into the memory that is free now.
///
/// # Errors
/// Bad input (exit 2) with both numbers.
pub(crate) fn refuse_too_many([nx, ny]: [usize; 2]) -> Result<(), Failure> {
    let needed = (nx as u64).saturating_mul(ny as u64).saturating_mul(BYTES_PER_PIXEL);
    match free_bytes() {
        Some(free) if needed > free => Err(Failure::bad_input(format!(
            "{nx} × {ny} pixels need {:.1} GB of memory, and {:.1} GB are free",
            needed as f64 / 1e9,
            free as f64 / 1e9
        ))
        .help("give fewer pixels in sensor.pixels or --pixels")),
        _ => Ok(()),
    }
}

/// What the system could give a process now, where it says so.
fn free_bytes() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kilobytes * 1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_map_beyond_all_memory_is_refused() {
        refuse_too_many([1, 1]).unwrap();
        if free_bytes().is_some() {
            let refused = refuse_too_many([1 << 31, 1 << 31]).unwrap_err();
            assert!(refused.message.contains("GB are free"), "{refused}");
        }
    }
}
