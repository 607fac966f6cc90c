//! The amplitude spectrum as a picture shows it: the largest amplitude of each narrow band.

/// Bands of a decade.
const PER_DECADE: f64 = 120.0;

/// (frequency in Hz, amplitude) of the largest component of each band, by rising frequency; `step_hz` is the distance
/// of the amplitudes, which begin at 0 Hz.
pub(crate) fn largest(amplitudes: &[f64], step_hz: f64, to_hz: f64) -> Vec<[f64; 2]> {
    let mut bands: Vec<[f64; 2]> = Vec::new();
    let mut last = i64::MIN;
    for (bin, amplitude) in amplitudes.iter().enumerate().skip(1) {
        let frequency_hz = bin as f64 * step_hz;
        if frequency_hz > to_hz {
            break;
        }
        let band = (PER_DECADE * frequency_hz.log10()).floor() as i64;
        match bands.last_mut() {
            Some(known) if band == last => {
                if *amplitude > known[1] {
                    *known = [frequency_hz, *amplitude];
                }
            }
            _ => bands.push([frequency_hz, *amplitude]),
        }
        last = band;
    }
    bands
}
