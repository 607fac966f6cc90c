//! Whether two exposures in a row can be of the same light: the only check that a spectrum without a checksum has.

use std::fmt;
use std::ops::Range;

use isolux_units::median;

/// How far a pixel of one exposure may be from that of the other, in standard deviations of the difference.
const SIGMAS: f64 = 6.0;

/// And in counts above that: two roundings.
const ROUNDING: f64 = 2.0;

/// The light of two exposures in a row may differ as a whole by this share (a lamp on mains power and a short
/// exposure).
const CHANGE: f64 = 0.05;

/// A pixel is bright from this share of the peak on.
const BRIGHT: f64 = 0.2;

/// Fewer pixels than this give no estimate.
const FEWEST: usize = 16;

/// Noise of one pixel by the data sheet of the USB2000+: 50 counts without light, and a signal to noise ratio of 250:1
/// at full scale, so 1.05 counts² a count. What is measured may be more, but not without limit: a spectrum of random
/// bytes must not set its own tolerance.
const SHOT: f64 = 1.05;
const MOST_READ_NOISE: f64 = 150.0;
const MOST_SHOT: f64 = 5.0;

/// Two exposures in a row.
pub(crate) struct Pair<'a> {
    pub before: &'a [u16],
    pub after: &'a [u16],
    /// Pixels that no light reaches.
    pub dark: Range<usize>,
    /// Counts from which on a pixel says only "at least".
    pub saturation: u16,
}

/// How two exposures differ.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Difference {
    Length(usize, usize),
    Light {
        change_rel: f64,
    },
    Pixel {
        pixel: usize,
        before: u16,
        after: u16,
        allowed: f64,
    },
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Length(before, after) => write!(f, "{before} and {after} pixels"),
            Self::Light { change_rel } => write!(f, "the light changed by {:.1} %", change_rel * 100.0),
            Self::Pixel {
                pixel,
                before,
                after,
                allowed,
            } => write!(
                f,
                "pixel {pixel} has {before} and {after} counts, noise allows {allowed:.0} between them"
            ),
        }
    }
}

impl Pair<'_> {
    /// Compares them pixel by pixel, apart from one common factor near 1.
    ///
    /// The noise is estimated from the pair itself: without light from the dimmer half of the pixels, that of the light
    /// from the bright ones, both as medians, which single damaged pixels do not move.
    pub fn agree(&self) -> Result<(), Difference> {
        let (before, after) = (self.before, self.after);
        if before.len() != after.len() {
            return Err(Difference::Length(before.len(), after.len()));
        }
        let pixels = before.len();
        let both = |pixel: usize| (f64::from(before[pixel]), f64::from(after[pixel]));
        let dark = median(
            (0..pixels)
                .filter(|pixel| self.dark.contains(pixel))
                .map(|pixel| 0.5 * (both(pixel).0 + both(pixel).1)),
        )
        .unwrap_or(0.0);
        let signal = |pixel: usize| 0.5 * (both(pixel).0 + both(pixel).1) - dark;
        let clipped = |pixel: usize| before[pixel] >= self.saturation && after[pixel] >= self.saturation;

        let usable: Vec<usize> = (0..pixels).filter(|pixel| !clipped(*pixel)).collect();
        let mut by_signal: Vec<usize> = usable.clone();
        by_signal.sort_by(|a, b| signal(*a).total_cmp(&signal(*b)));
        // A single pixel may be damaged: the peak is that of the tenth from above.
        let peak = by_signal.iter().rev().nth(10).map_or(0.0, |pixel| signal(*pixel));
        let dim = &by_signal[..by_signal.len() / 2];
        let read_variance = (1.4826 * median(dim.iter().map(|&p| (both(p).1 - both(p).0).abs())).unwrap_or(0.0))
            .powi(2)
            .min(2.0 * MOST_READ_NOISE * MOST_READ_NOISE);
        let bright: Vec<usize> = usable
            .iter()
            .copied()
            .filter(|&pixel| signal(pixel) > BRIGHT * peak && signal(pixel) > 10.0 * read_variance.sqrt())
            .collect();
        let factor = if bright.len() >= FEWEST {
            median(bright.iter().map(|&p| (both(p).1 - dark) / (both(p).0 - dark).max(1.0))).unwrap_or(1.0)
        } else {
            1.0
        };
        if (factor - 1.0).abs() > CHANGE {
            return Err(Difference::Light {
                change_rel: factor - 1.0,
            });
        }
        let difference = |pixel: usize| (both(pixel).1 - dark) - factor * (both(pixel).0 - dark);
        // The median of the square of a normal variable is 0.455 of its variance.
        let shot = if bright.len() >= FEWEST {
            let excess = |p: usize| (difference(p).powi(2) / 0.455 - read_variance) / signal(p);
            median(bright.iter().map(|&p| excess(p))).unwrap_or(0.0)
        } else {
            2.0 * SHOT
        };
        let shot = shot.clamp(0.0, 2.0 * MOST_SHOT);
        for pixel in usable {
            let sigma = (read_variance + shot * signal(pixel).max(0.0)).sqrt();
            let allowed = SIGMAS * sigma + ROUNDING;
            if difference(pixel).abs() > allowed {
                let (before, after) = (before[pixel], after[pixel]);
                return Err(Difference::Pixel {
                    pixel,
                    before,
                    after,
                    allowed,
                });
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Noise of one standard deviation from a linear congruential generator: the sum of twelve uniform numbers.
    struct Noise(u64);

    impl Noise {
        fn next(&mut self) -> f64 {
            let mut uniform = || {
                self.0 = self
                    .0
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1_442_695_040_888_963_407);
                (self.0 >> 11) as f64 / (1_u64 << 53) as f64
            };
            (0..12).map(|_| uniform()).sum::<f64>() - 6.0
        }
    }

    fn exposure(noise: &mut Noise, light: impl Fn(usize) -> f64) -> Vec<u16> {
        (0..2048)
            .map(|pixel| {
                let light = if pixel < 22 { 0.0 } else { light(pixel) };
                let counts = 1500.0 + light + noise.next() * 18.0_f64.hypot((light / 1.6).sqrt());
                counts.round().clamp(0.0, 65_535.0) as u16
            })
            .collect()
    }

    fn lamp(pixel: usize) -> f64 {
        40_000.0 * (-((pixel as f64 - 900.0) / 250.0).powi(2)).exp()
    }

    fn line(pixel: usize) -> f64 {
        50_000.0 * (-((pixel as f64 - 700.0) / 2.0).powi(2)).exp()
    }

    fn agree(before: &[u16], after: &[u16]) -> Result<(), Difference> {
        Pair {
            before,
            after,
            dark: 6..21,
            saturation: 65_535,
        }
        .agree()
    }

    #[test]
    fn noise_of_any_light_is_no_disagreement() {
        let mut noise = Noise(1);
        let lights: [fn(usize) -> f64; 5] = [lamp, line, |_| 0.0, |p| 0.01 * lamp(p), |p| 3.0 * lamp(p)];
        for light in lights {
            for _ in 0..200 {
                let pair = (exposure(&mut noise, light), exposure(&mut noise, light));
                assert_eq!(agree(&pair.0, &pair.1), Ok(()));
            }
        }
        let flicker = (exposure(&mut noise, lamp), exposure(&mut noise, |p| 1.04 * lamp(p)));
        assert_eq!(agree(&flicker.0, &flicker.1), Ok(()));
    }

    #[test]
    fn a_bit_a_byte_and_another_light_are() {
        let mut noise = Noise(2);
        for light in [lamp, line, |_| 0.0] {
            let pair = (exposure(&mut noise, light), exposure(&mut noise, light));
            for pixel in [0, 10, 700, 1300, 2047] {
                for bit in 12..16 {
                    let mut flipped = pair.1.clone();
                    flipped[pixel] ^= 1 << bit;
                    let found = agree(&pair.0, &flipped);
                    assert!(
                        matches!(found, Err(Difference::Pixel { pixel: at, .. }) if at == pixel),
                        "{found:?}"
                    );
                }
            }
            // A byte lost in the middle and another put in at the end: all later pixels change their bytes.
            let mut bytes: Vec<u8> = pair.1.iter().flat_map(|counts| counts.to_le_bytes()).collect();
            bytes.remove(1001);
            bytes.push(0);
            let torn: Vec<u16> = bytes
                .chunks_exact(2)
                .map(|two| u16::from_le_bytes([two[0], two[1]]))
                .collect();
            assert!(agree(&pair.0, &torn).is_err());
        }
        let other = exposure(&mut noise, |p| 0.9 * lamp(p));
        let found = agree(&exposure(&mut noise, lamp), &other);
        assert!(matches!(found, Err(Difference::Light { .. })), "{found:?}");
        let random: Vec<u16> = (0..2048).map(|p| (p as u16).wrapping_mul(40_503)).collect();
        assert!(agree(&exposure(&mut noise, lamp), &random).is_err());
    }
}
