//! What the checks of the parts of a station share.

use crate::document::Fault;

/// How a relative uncertainty is written.
pub(super) const FRACTION: &str = " (a fraction: 0.015 is 1.5 %)";

/// Largest relative standard uncertainty of a calibration.
pub(super) const MOST_U_REL: f64 = 0.5;

/// That an `open` is one.
pub(super) fn driver_and_target(path: &str, open: &str) -> Result<(), Fault> {
    match open.split_once(':') {
        Some((driver, target)) if !driver.is_empty() && !target.is_empty() => Ok(()),
        _ => Err(Fault::new(
            path,
            format!("`{open}` is not `driver:target`, for instance zaber:/dev/ttyUSB0?axis=1"),
        )),
    }
}
