//! Colour fidelity and gamut: Rf (CIE 224:2017), Rg and the sixteen hue bins (ANSI/IES TM-30-20).

use std::sync::OnceLock;

use crate::cct::{self, Cct};
use crate::tables::{X10_BAR, Y10_BAR, Z10_BAR};
use crate::{Spectrum, Tristimulus, illuminant};

/// Colour fidelity and gamut of a source.
#[derive(Debug, Clone, PartialEq)]
pub struct Fidelity {
    /// General colour fidelity index Rf.
    pub rf: f64,
    /// Gamut index Rg.
    pub rg: f64,
    /// The sixteen hue bins, beginning at hue angle 0, 22.5° each.
    pub bins: [HueBin; 16],
}

/// One hue bin of TM-30.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HueBin {
    /// Local fidelity Rf,h.
    pub rf: f64,
    /// Local chroma shift Rcs,h in percent.
    pub chroma_shift_percent: f64,
    /// Local hue shift Rhs,h in radian.
    pub hue_shift: f64,
    /// Mean (a′, b′) under the source.
    pub test: (f64, f64),
    /// Mean (a′, b′) under the reference.
    pub reference: (f64, f64),
}

const FIRST: usize = 380 - 360;
const COUNT: usize = 401;
const SAMPLES: usize = 99;

/// Fidelity and gamut, sums at 1 nm over 380–780 nm; none where the source has no reference (no light, no colour
/// temperature, or above 25 000 K).
pub fn fidelity(source: &Spectrum) -> Option<Fidelity> {
    let test = source.per_nm();
    let nearest = cct::nearest_planckian(Tristimulus::of_1_nm(&test).chromaticity()?)?;
    fidelity_of(&test, nearest)
}

/// The same of the values at 360, 361, … 830 nm of a source whose nearest Planckian radiator is known.
pub fn fidelity_of(test: &[f64; 471], nearest: Cct) -> Option<Fidelity> {
    let t = nearest.meaningful()?.cct_k;
    let (test, reference) = (appearances(test)?, appearances(&reference(t)?)?);

    let mut sums = [(0.0, 0.0, 0.0, 0.0, 0.0, 0usize); 16];
    let mut total = 0.0;
    for (a, b) in test.iter().zip(&reference) {
        let difference = ((a.j - b.j).powi(2) + (a.a - b.a).powi(2) + (a.b - b.b).powi(2)).sqrt();
        total += difference;
        let bin = &mut sums[((b.b.atan2(b.a).to_degrees().rem_euclid(360.0) / 22.5) as usize).min(15)];
        bin.0 += difference;
        bin.1 += a.a;
        bin.2 += a.b;
        bin.3 += b.a;
        bin.4 += b.b;
        bin.5 += 1;
    }
    if sums.iter().any(|s| s.5 == 0) {
        return None;
    }
    let bins: [HueBin; 16] = std::array::from_fn(|k| {
        let (difference, ta, tb, ra, rb, n) = sums[k];
        let n = n as f64;
        let (test, reference) = ((ta / n, tb / n), (ra / n, rb / n));
        let (sin, cos) = (22.5 * k as f64 + 11.25).to_radians().sin_cos();
        let (da, db) = (test.0 - reference.0, test.1 - reference.1);
        let chroma = reference.0.hypot(reference.1);
        HueBin {
            rf: index(difference / n),
            chroma_shift_percent: 100.0 * (da * cos + db * sin) / chroma,
            hue_shift: (db * cos - da * sin) / chroma,
            test,
            reference,
        }
    });
    let area = |of: fn(&HueBin) -> (f64, f64)| -> f64 {
        (0..16)
            .map(|k| {
                let (p, q) = (of(&bins[k]), of(&bins[(k + 1) % 16]));
                p.0 * q.1 - p.1 * q.0
            })
            .sum()
    };
    let out = Fidelity {
        rf: index(total / test.len() as f64),
        rg: 100.0 * area(|b| b.test) / area(|b| b.reference),
        bins,
    };
    (out.rf.is_finite() && out.rg.is_finite()).then_some(out)
}

/// 10 ln(1 + exp((100 − 6.73 ΔE)/10)), CIE 224 equation 9.
fn index(difference: f64) -> f64 {
    10.0 * ((100.0 - 6.73 * difference) / 10.0).exp().ln_1p()
}

/// Planck to 4000 K, daylight from 5000 K, between them both at the source's own temperature, mixed by luminance (CIE
/// 224, 4.2).
fn reference(t: f64) -> Option<[f64; 471]> {
    if t <= 4000.0 {
        return Some(illuminant::planck(t));
    }
    let daylight = illuminant::daylight(t)?;
    if t >= 5000.0 {
        return Some(daylight);
    }
    let planck = illuminant::planck(t);
    let (yp, yd) = (Tristimulus::of_1_nm(&planck).y, Tristimulus::of_1_nm(&daylight).y);
    let share = (t - 4000.0) / 1000.0;
    Some(std::array::from_fn(|i| {
        (1.0 - share) * planck[i] / yp + share * daylight[i] / yd
    }))
}

/// J′, a′, b′ of CAM02-UCS.
#[derive(Debug, Clone, Copy)]
struct Appearance {
    j: f64,
    a: f64,
    b: f64,
}

/// Appearance of the 99 samples under a light; 10° observer, L_A = 100 cd/m², Y_b = 20, average surround, D = 1.
fn appearances(light: &[f64; 471]) -> Option<Vec<Appearance>> {
    let light = &light[FIRST..FIRST + COUNT];
    let (mut white, mut seen) = ([0.0; 3], [[0.0; SAMPLES]; 3]);
    for (i, (l, reflectances)) in light.iter().zip(samples()).enumerate() {
        let bars = [&X10_BAR, &Y10_BAR, &Z10_BAR].map(|bar| bar[FIRST + i]);
        for ((white, seen), bar) in white.iter_mut().zip(&mut seen).zip(bars) {
            *white += l * bar;
            // All samples of one wavelength side by side: the processor adds several of them at once.
            for (seen, reflectance) in seen.iter_mut().zip(reflectances) {
                *seen += l * reflectance * bar;
            }
        }
    }
    if white[1].is_nan() || white[1] <= 0.0 {
        return None;
    }
    let k = 100.0 / white[1];
    let view = Viewing::new(white.map(|v| v * k));
    let out: Vec<_> = (0..SAMPLES)
        .map(|sample| view.appearance(seen.map(|sums| sums[sample] * k)))
        .collect();
    out.iter()
        .all(|a| a.j.is_finite() && a.a.is_finite() && a.b.is_finite())
        .then_some(out)
}

/// CIECAM02 (CIE 159) for one white.
struct Viewing {
    gain: [f64; 3],
    f_l: f64,
    n: f64,
    n_bb: f64,
    a_white: f64,
}

const CAT02: [[f64; 3]; 3] = [
    [0.7328, 0.4296, -0.1624],
    [-0.7036, 1.6975, 0.0061],
    [0.0030, 0.0136, 0.9834],
];
/// Hunt-Pointer-Estévez × CAT02⁻¹.
const HPE_FROM_CAT02: [[f64; 3]; 3] = [
    [0.740_979_208_8, 0.218_025_041_1, 0.041_005_750_1],
    [0.285_353_199_0, 0.624_201_574_1, 0.090_445_226_9],
    [-0.009_627_608_7, -0.005_698_031_2, 1.015_325_639_9],
];

fn times(m: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

impl Viewing {
    fn new(white: [f64; 3]) -> Self {
        let l_a: f64 = 100.0;
        let k4 = (1.0 / (5.0 * l_a + 1.0)).powi(4);
        let n: f64 = 20.0 / 100.0;
        let mut view = Self {
            gain: times(&CAT02, white).map(|c| 100.0 / c),
            f_l: 0.2 * k4 * 5.0 * l_a + 0.1 * (1.0 - k4).powi(2) * (5.0 * l_a).cbrt(),
            n,
            n_bb: 0.725 * (1.0 / n).powf(0.2),
            a_white: 1.0,
        };
        view.a_white = view.achromatic(view.cones(white));
        view
    }

    fn cones(&self, xyz: [f64; 3]) -> [f64; 3] {
        let rgb = times(&CAT02, xyz);
        let adapted = std::array::from_fn(|i| rgb[i] * self.gain[i]);
        times(&HPE_FROM_CAT02, adapted).map(|c| {
            let p = (self.f_l * c.abs() / 100.0).powf(0.42);
            (400.0 * p / (p + 27.13)).copysign(c) + 0.1
        })
    }

    fn achromatic(&self, [r, g, b]: [f64; 3]) -> f64 {
        (2.0 * r + g + b / 20.0 - 0.305) * self.n_bb
    }

    fn appearance(&self, xyz: [f64; 3]) -> Appearance {
        let cones = self.cones(xyz);
        let [r, g, b] = cones;
        let (a, bb) = (r - 12.0 * g / 11.0 + b / 11.0, (r + g - 2.0 * b) / 9.0);
        let hue = bb.atan2(a);
        let eccentricity = 0.25 * ((hue + 2.0).cos() + 3.8);
        let j = 100.0 * (self.achromatic(cones) / self.a_white).powf(0.69 * (1.48 + self.n.sqrt()));
        let t = 50_000.0 / 13.0 * self.n_bb * eccentricity * a.hypot(bb) / (r + g + 21.0 / 20.0 * b);
        let chroma = t.powf(0.9) * (j / 100.0).sqrt() * (1.64 - 0.29f64.powf(self.n)).powf(0.73);
        let m = chroma * self.f_l.powf(0.25);
        let m = (1.0 + 0.0228 * m).ln() / 0.0228;
        Appearance {
            j: 1.7 * j / (1.0 + 0.007 * j),
            a: m * hue.cos(),
            b: m * hue.sin(),
        }
    }
}

/// The samples of CIE 224 at 380, 381, … 780 nm: the reflectances of all of them at each.
fn samples() -> &'static [[f64; SAMPLES]] {
    static AT_NM: OnceLock<Vec<[f64; SAMPLES]>> = OnceLock::new();
    AT_NM.get_or_init(|| {
        let samples = table();
        (0..COUNT)
            .map(|i| std::array::from_fn(|sample| samples[sample][i]))
            .collect()
    })
}

/// One line a sample, one value a nanometre.
fn table() -> Vec<Vec<f64>> {
    include_str!("../tables/cfi_2017_1nm.csv")
        .lines()
        .map(|line| line.split(',').filter_map(|v| v.parse().ok()).collect())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sample_table_is_whole() {
        assert_eq!(table().len(), SAMPLES);
        assert!(table().iter().all(|s| s.len() == COUNT));
    }

    #[test]
    fn a_reference_is_faithful() {
        // Also in 4000–5000 K, where both parts of the mixture must have the source's temperature.
        for t in [3000.0, 4300.0, 4700.0, 6500.0] {
            let f = fidelity(&Spectrum::from_1_nm(&reference(t).unwrap()).unwrap()).unwrap();
            assert!(f.rf > 99.95 && (f.rg - 100.0).abs() < 0.05, "{t} {} {}", f.rf, f.rg);
        }
    }
}
