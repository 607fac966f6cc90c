//! Repeats of one point: how many, and whether they agree.

use isolux_device::LuxReading;
use isolux_record::limits::Limits;
use isolux_record::plan::Repeats;

use crate::error::ScanError;
use crate::settle::Noise;

/// More readings than this never make a point's mean better: its digit does not average out.
const MOST_REPEATS: u32 = 256;

/// Whether a point was read often enough.
pub(super) fn enough(repeats: Repeats, taken: u32, values: &[f64], last: &LuxReading, noise: Noise) -> bool {
    match repeats {
        Repeats::Exactly(count) => taken >= count,
        Repeats::Until(u_rel) => {
            let n = values.len() as f64;
            let mean = values.iter().sum::<f64>() / n;
            let digit = last.digit.value();
            // Scatter averages out with 1/√n, the rounding of the display does not.
            let scatter = (noise.relative * mean).hypot(noise.absolute_lx) / n.sqrt();
            let u = scatter.hypot(digit / 12.0_f64.sqrt());
            taken >= MOST_REPEATS
                || values.is_empty() && taken >= 3
                || u <= u_rel * mean.abs()
                || scatter <= 0.1 * digit && taken >= 4
        }
    }
}

/// Whether all repeats lie near their median: within so many standard uncertainties of one reading, plus one digit.
///
/// # Errors
/// [`ScanError::Repeats`] with the first that does not.
pub(super) fn agree(
    pose_deg: (f64, f64),
    values_lx: &[f64],
    digit_lx: f64,
    noise: Noise,
    limits: &Limits,
) -> Result<(), ScanError> {
    let mut sorted = values_lx.to_vec();
    sorted.sort_by(f64::total_cmp);
    let Some(&median_lx) = sorted.get(sorted.len() / 2) else {
        return Ok(());
    };
    let allowed_lx = limits.repeats_sigma() * noise.u_lx(median_lx, digit_lx) + digit_lx;
    match values_lx.iter().find(|value| (*value - median_lx).abs() > allowed_lx) {
        None => Ok(()),
        Some(&value_lx) => Err(ScanError::Repeats {
            c_deg: pose_deg.0,
            gamma_deg: pose_deg.1,
            value_lx,
            median_lx,
            allowed_lx,
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_digit_and_noise_are_no_disagreement_and_another_light_is() {
        let noise = Noise {
            relative: 0.001,
            absolute_lx: 0.0,
        };
        let check = |values: &[f64]| agree((0.0, 30.0), values, 0.01, noise, &Limits::default());
        assert!(check(&[]).is_ok() && check(&[3.4]).is_ok());
        assert!(check(&[3.40, 3.41, 3.42, 3.39]).is_ok());
        let error = check(&[3.40, 3.41, 3.30]).unwrap_err();
        assert!(
            matches!(
                error,
                ScanError::Repeats {
                    value_lx: 3.30,
                    median_lx: 3.40,
                    ..
                }
            ),
            "{error}"
        );
        assert!(check(&[0.01, 0.0, 0.02]).is_ok(), "the dark flickers by a digit");
    }
}
