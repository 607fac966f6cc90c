//! Counter-based random numbers: a draw is a function of (seed, stream, index), never of what was drawn before.

/// Philox 4×32 with 10 rounds (Salmon, Moraes, Dror, Shaw, "Parallel random numbers: as easy as 1, 2, 3", SC11).
///
/// `counter` and `key` as in the paper; returns four independent 32-bit words.
pub fn philox(mut counter: [u32; 4], mut key: [u32; 2]) -> [u32; 4] {
    for _ in 0..10 {
        let left = u64::from(counter[0]) * 0xD251_1F53;
        let right = u64::from(counter[2]) * 0xCD9E_8D57;
        counter = [
            (right >> 32) as u32 ^ counter[1] ^ key[0],
            right as u32,
            (left >> 32) as u32 ^ counter[3] ^ key[1],
            left as u32,
        ];
        key = [key[0].wrapping_add(0x9E37_79B9), key[1].wrapping_add(0xBB67_AE85)];
    }
    counter
}

/// What a stream of draws is for. Two streams never share a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum Stream {
    /// Manufacturing spread of the LEDs.
    Leds = 1,
    /// Readings of the lux meter.
    LuxMeter = 2,
    /// Pixels of the spectrometer.
    Spectrometer = 3,
    /// Bins of the camera.
    Camera = 4,
    /// The room thermometer.
    Thermometer = 5,
    /// Encoders of the axes.
    Encoder = 6,
    /// Faults on the links.
    Fault = 7,
    /// Fixed pattern of the spectrometer's dark signal.
    DarkPattern = 8,
    /// Readings of the power meter.
    PowerMeter = 9,
    /// Errors of the certificate of a standard lamp.
    Certificate = 10,
    /// Samples of the oscilloscope.
    Oscilloscope = 11,
}

/// A source of draws addressed by number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Noise {
    seed: u64,
    stream: Stream,
}

impl Noise {
    /// The draws of `stream` under `seed`.
    pub fn new(seed: u64, stream: Stream) -> Self {
        Self { seed, stream }
    }

    /// Two independent uniform numbers in (0, 1), numbers `index` and `sub` of this stream.
    pub fn uniform_pair(&self, index: u64, sub: u32) -> [f64; 2] {
        let counter = [index as u32, (index >> 32) as u32, sub, self.stream as u32];
        let word = philox(counter, [self.seed as u32, (self.seed >> 32) as u32]);
        let uniform = |high: u32, low: u32| {
            let bits = (u64::from(high) << 32 | u64::from(low)) >> 12;
            (bits as f64 + 0.5) / (1u64 << 52) as f64
        };
        [uniform(word[0], word[1]), uniform(word[2], word[3])]
    }

    /// Two independent standard normal numbers (Box–Muller).
    pub fn normal_pair(&self, index: u64, sub: u32) -> [f64; 2] {
        let [u, v] = self.uniform_pair(index, sub);
        let radius = (-2.0 * u.ln()).sqrt();
        let (sin, cos) = (std::f64::consts::TAU * v).sin_cos();
        [radius * cos, radius * sin]
    }

    /// One standard normal number.
    pub fn normal(&self, index: u64, sub: u32) -> f64 {
        self.normal_pair(index, sub)[0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Known answers of the Random123 distribution, file `kat_vectors`.
    #[test]
    fn philox_gives_the_published_known_answers() {
        assert_eq!(
            philox([0; 4], [0; 2]),
            [0x6627_e8d5, 0xe169_c58d, 0xbc57_ac4c, 0x9b00_dbd8]
        );
        assert_eq!(
            philox([0xffff_ffff; 4], [0xffff_ffff; 2]),
            [0x408f_276d, 0x41c8_3b0e, 0xa20b_c7c6, 0x6d54_51fd]
        );
        assert_eq!(
            philox(
                [0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344],
                [0xa409_3822, 0x299f_31d0]
            ),
            [0xd16c_fe09, 0x94fd_cceb, 0x5001_e420, 0x2412_6ea1]
        );
    }

    #[test]
    fn normal_draws_have_unit_variance_and_streams_differ() {
        let noise = Noise::new(7, Stream::LuxMeter);
        let n = 20_000;
        let (mut sum, mut square) = (0.0, 0.0);
        for k in 0..n {
            let x = noise.normal(k, 0);
            sum += x;
            square += x * x;
        }
        assert!((sum / n as f64).abs() < 4.0 / (n as f64).sqrt());
        assert!((square / n as f64 - 1.0).abs() < 4.0 * (2.0 / n as f64).sqrt());
        assert_ne!(noise.normal(3, 0), Noise::new(7, Stream::Camera).normal(3, 0));
        assert_ne!(noise.normal(3, 0), Noise::new(8, Stream::LuxMeter).normal(3, 0));
    }
}
