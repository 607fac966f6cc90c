//! Counter-based random numbers: Philox4x32-10 (Salmon et al., “Parallel random numbers: as easy as 1, 2, 3”, SC11).
//!
//! A number is a function of (seed, purpose, index) alone, so that no result depends on threads, chunks or shards. The
//! samplers are written here because a seed gives the same map in every version, which `rand_distr` does not promise.

const MULTIPLIER: [u32; 2] = [0xD251_1F53, 0xCD9E_8D57];
const WEYL: [u32; 2] = [0x9E37_79B9, 0xBB67_AE85];

/// What a stream of numbers is for: streams of different purpose never overlap.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum Purpose {
    /// Emission of a ray.
    Ray = 1,
    /// Number of rays in the cone.
    Cone = 2,
    /// Counts of a pixel.
    Pixel = 3,
    /// Camera noise of a pixel.
    Camera = 4,
    /// Maps of trial counts for statistics.
    Trial = 5,
}

/// Four words from a key and a counter.
#[inline]
pub fn philox(key: [u32; 2], counter: [u32; 4]) -> [u32; 4] {
    let (mut key, mut c) = (key, counter);
    for round in 0..10 {
        if round > 0 {
            key = [key[0].wrapping_add(WEYL[0]), key[1].wrapping_add(WEYL[1])];
        }
        let p0 = u64::from(MULTIPLIER[0]) * u64::from(c[0]);
        let p1 = u64::from(MULTIPLIER[1]) * u64::from(c[2]);
        c = [
            (p1 >> 32) as u32 ^ c[1] ^ key[0],
            p1 as u32,
            (p0 >> 32) as u32 ^ c[3] ^ key[1],
            p0 as u32,
        ];
    }
    c
}

/// The numbers of one purpose under one seed.
#[derive(Debug, Clone, Copy)]
pub struct Random {
    key: [u32; 2],
    purpose: u32,
}

impl Random {
    /// The stream of `purpose` under `seed`.
    pub fn new(seed: u64, purpose: Purpose) -> Self {
        Self {
            key: [seed as u32, (seed >> 32) as u32],
            purpose: purpose as u32,
        }
    }

    /// Four words for `index`; `block` numbers further words of the same index.
    #[inline]
    pub fn words(&self, index: u64, block: u32) -> [u32; 4] {
        philox(self.key, [index as u32, (index >> 32) as u32, block, self.purpose])
    }

    pub(crate) fn key(&self) -> [u32; 2] {
        self.key
    }

    pub(crate) fn purpose(&self) -> u32 {
        self.purpose
    }

    /// The same as [`Random::sequence`], with `first`, the first four words of `index`.
    pub(crate) fn begun(&self, index: u64, first: [u32; 4]) -> Sequence {
        Sequence {
            random: *self,
            index,
            block: 1,
            left: first,
            used: 0,
        }
    }

    /// An endless sequence for `index`.
    pub fn sequence(&self, index: u64) -> Sequence {
        Sequence {
            random: *self,
            index,
            block: 0,
            left: [0; 4],
            used: 4,
        }
    }
}

/// Numbers one after the other, for samplers that need a number that is not known beforehand.
#[derive(Debug, Clone)]
pub struct Sequence {
    random: Random,
    index: u64,
    block: u32,
    left: [u32; 4],
    used: usize,
}

impl Sequence {
    /// The next word.
    pub fn word(&mut self) -> u32 {
        if self.used == 4 {
            self.left = self.random.words(self.index, self.block);
            self.block += 1;
            self.used = 0;
        }
        self.used += 1;
        self.left[self.used - 1]
    }

    /// Uniform in [0, 1), 53 bits.
    pub fn uniform(&mut self) -> f64 {
        unit53(self.word(), self.word())
    }

    /// Standard normal (polar method).
    pub fn normal(&mut self) -> f64 {
        loop {
            let (a, b) = (2.0 * self.uniform() - 1.0, 2.0 * self.uniform() - 1.0);
            let square = a * a + b * b;
            if square > 0.0 && square < 1.0 {
                return a * (-2.0 * square.ln() / square).sqrt();
            }
        }
    }

    /// Poisson with mean `lambda`: inversion below 12, PTRS (Hörmann 1993) above.
    pub fn poisson(&mut self, lambda: f64) -> u64 {
        if lambda <= 0.0 {
            return 0;
        }
        if lambda < 12.0 {
            let mut left = self.uniform();
            let mut chance = (-lambda).exp();
            let mut count = 0_u64;
            while left >= chance {
                left -= chance;
                count += 1;
                chance *= lambda / count as f64;
                if chance < 1e-300 {
                    break;
                }
            }
            return count;
        }
        let root = lambda.sqrt();
        let b = 0.931 + 2.53 * root;
        let a = -0.059 + 0.02483 * b;
        let inverse_alpha = 1.1239 + 1.1328 / (b - 3.4);
        let v_r = 0.9277 - 3.6224 / (b - 2.0);
        loop {
            let u = self.uniform() - 0.5;
            let v = self.uniform();
            let us = 0.5 - u.abs();
            let k = ((2.0 * a / us + b) * u + lambda + 0.43).floor();
            if us >= 0.07 && v <= v_r {
                return k as u64;
            }
            if k < 0.0 || us < 0.013 && v > us {
                continue;
            }
            if (v * inverse_alpha / (a / (us * us) + b)).ln() <= k * lambda.ln() - lambda - ln_factorial(k) {
                return k as u64;
            }
        }
    }

    /// Binomial(n, p): geometric skips where few are expected, BTRS (Hörmann 1993) above.
    pub fn binomial(&mut self, n: u64, p: f64) -> u64 {
        if p <= 0.0 || n == 0 {
            return 0;
        }
        if p > 0.5 {
            return n - self.binomial(n, 1.0 - p);
        }
        if n as f64 * p < 12.0 {
            let skip = (-p).ln_1p();
            let (mut count, mut at) = (0_u64, 0.0);
            loop {
                at += ((1.0 - self.uniform()).ln() / skip).floor() + 1.0;
                if at > n as f64 {
                    return count;
                }
                count += 1;
            }
        }
        let (nf, q) = (n as f64, 1.0 - p);
        let root = (nf * p * q).sqrt();
        let b = 1.15 + 2.53 * root;
        let a = -0.0873 + 0.0248 * b + 0.01 * p;
        let c = nf * p + 0.5;
        let v_r = 0.92 - 4.2 / b;
        let alpha = (2.83 + 5.1 / b) * root;
        let mode = ((nf + 1.0) * p).floor();
        let h = ln_factorial(mode) + ln_factorial(nf - mode);
        loop {
            let u = self.uniform() - 0.5;
            let v = self.uniform();
            let us = 0.5 - u.abs();
            let k = ((2.0 * a / us + b) * u + c).floor();
            if us >= 0.07 && v <= v_r {
                return k as u64;
            }
            if k < 0.0 || k > nf {
                continue;
            }
            let v = (v * alpha / (a / (us * us) + b)).ln();
            if v <= h - ln_factorial(k) - ln_factorial(nf - k) + (k - mode) * (p / q).ln() {
                return k as u64;
            }
        }
    }
}

/// Uniform in [0, 1) from two words.
#[inline]
pub fn unit53(high: u32, low: u32) -> f64 {
    ((u64::from(high) << 21) | (u64::from(low) >> 11)) as f64 * (1.0 / 9_007_199_254_740_992.0)
}

/// Uniform in (0, 1) from one word.
#[inline(always)]
#[expect(
    clippy::inline_always,
    reason = "inside multiversioned loops, or they would not be vectorised"
)]
pub fn unit32(word: u32) -> f64 {
    (f64::from(word) + 0.5) * (1.0 / 4_294_967_296.0)
}

/// ln k!, exact sums below 16 and Stirling's series (error below 1e-13) above.
pub(crate) fn ln_factorial(k: f64) -> f64 {
    if k < 16.0 {
        return (2..=k as u32).map(|i| f64::from(i).ln()).sum();
    }
    let inverse = 1.0 / k;
    let square = inverse * inverse;
    k * k.ln() - k
        + 0.5 * (std::f64::consts::TAU * k).ln()
        + inverse * (1.0 / 12.0 - square * (1.0 / 360.0 - square * (1.0 / 1260.0 - square / 1680.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn philox_gives_the_published_vectors() {
        // kat_vectors of Random123 1.14, philox4x32 with 10 rounds.
        assert_eq!(
            philox([0; 2], [0; 4]),
            [0x6627_e8d5, 0xe169_c58d, 0xbc57_ac4c, 0x9b00_dbd8]
        );
        assert_eq!(
            philox([!0; 2], [!0; 4]),
            [0x408f_276d, 0x41c8_3b0e, 0xa20b_c7c6, 0x6d54_51fd]
        );
        assert_eq!(
            philox(
                [0xa409_3822, 0x299f_31d0],
                [0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344]
            ),
            [0xd16c_fe09, 0x94fd_cceb, 0x5001_e420, 0x2412_6ea1]
        );
    }

    #[test]
    fn a_sequence_goes_on_as_it_was_begun() {
        let random = Random::new(9, Purpose::Pixel);
        for index in [0, 3, 1 << 40] {
            let (mut whole, mut begun) = (random.sequence(index), random.begun(index, random.words(index, 0)));
            for _ in 0..11 {
                assert_eq!(whole.word(), begun.word());
            }
        }
    }

    #[test]
    fn poisson_and_binomial_have_their_moments() {
        let random = Random::new(7, Purpose::Trial);
        let draws = 40_000_u64;
        for lambda in [0.02, 1.16, 4.6, 11.9, 12.1, 300.0, 2e6] {
            check(lambda, lambda, draws, |i| random.sequence(i).poisson(lambda));
        }
        for (n, p) in [(200_000_u64, 1e-5), (2_000_000_000, 0.0024), (50, 0.7), (400, 0.1)] {
            let mean = n as f64 * p;
            check(mean, mean * (1.0 - p), draws, |i| random.sequence(i).binomial(n, p));
        }
    }

    fn check(mean: f64, variance: f64, draws: u64, draw: impl Fn(u64) -> u64) {
        let values: Vec<f64> = (0..draws).map(|i| draw(i) as f64 - mean).collect();
        let first = values.iter().sum::<f64>() / draws as f64;
        let second = values.iter().map(|v| v * v).sum::<f64>() / draws as f64;
        let u = (variance / draws as f64).sqrt();
        assert!(first.abs() < 4.5 * u, "mean {mean}: off by {first}, u {u}");
        let u = variance * ((2.0 + 1.0 / variance) / draws as f64).sqrt();
        assert!(
            (second - variance).abs() < 4.5 * u,
            "variance {variance}: {second}, u {u}"
        );
    }

    #[test]
    fn poisson_counts_have_their_probabilities() {
        // χ² against the law itself at both sides of the change of method.
        for lambda in [1.5_f64, 14.0] {
            let random = Random::new(11, Purpose::Trial);
            let (draws, bins) = (200_000_u64, 40);
            let mut counts = vec![0.0; bins];
            for i in 0..draws {
                let k = random.sequence(i).poisson(lambda) as usize;
                counts[k.min(bins - 1)] += 1.0;
            }
            let mut chi = 0.0;
            let mut degrees = -1.0_f64;
            for (k, count) in counts.iter().enumerate() {
                let expected = draws as f64 * (k as f64 * lambda.ln() - lambda - ln_factorial(k as f64)).exp();
                if expected > 8.0 {
                    chi += (count - expected).powi(2) / expected;
                    degrees += 1.0;
                }
            }
            assert!(
                chi < degrees + 4.5 * (2.0 * degrees).sqrt(),
                "λ {lambda}: χ² {chi} over {degrees}"
            );
        }
    }
}
