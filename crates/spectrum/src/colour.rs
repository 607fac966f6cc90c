//! Tristimulus values and chromaticities of the CIE 1931 observer.

use crate::{Spectrum, cie};

/// Tristimulus values X, Y, Z of the CIE 1931 observer: sums at 1 nm over 360–830 nm, unnormalised.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tristimulus {
    /// ΣS·x̄.
    pub x: f64,
    /// ΣS·ȳ.
    pub y: f64,
    /// ΣS·z̄.
    pub z: f64,
}

impl Tristimulus {
    pub(crate) fn of_1_nm(s: &[f64; 471]) -> Self {
        let bars = cie::X_BAR.iter().zip(&cie::V_LAMBDA).zip(&cie::Z_BAR);
        let dark = Self { x: 0.0, y: 0.0, z: 0.0 };
        s.iter().zip(bars).fold(dark, |sum, (s, ((x, y), z))| Self {
            x: sum.x + s * x,
            y: sum.y + s * y,
            z: sum.z + s * z,
        })
    }

    /// Chromaticity; none for a stimulus without light (Y not above zero).
    pub fn chromaticity(self) -> Option<Chromaticity> {
        let sum = self.x + self.y + self.z;
        (self.y > 0.0 && sum > 0.0 && sum.is_finite()).then(|| Chromaticity {
            x: self.x / sum,
            y: self.y / sum,
        })
    }

    pub(crate) fn scaled(self, factor: f64) -> Self {
        Self {
            x: self.x * factor,
            y: self.y * factor,
            z: self.z * factor,
        }
    }
}

/// CIE 1931 chromaticity coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chromaticity {
    /// x.
    pub x: f64,
    /// y.
    pub y: f64,
}

/// The equal-energy stimulus, white point of dominant wavelength and purity of a light source (CIE 127).
pub const EQUAL_ENERGY: Chromaticity = Chromaticity {
    x: 1.0 / 3.0,
    y: 1.0 / 3.0,
};

impl Chromaticity {
    /// (u′, v′) of the CIE 1976 UCS diagram.
    pub fn uv_1976(self) -> (f64, f64) {
        let d = -2.0 * self.x + 12.0 * self.y + 3.0;
        (4.0 * self.x / d, 9.0 * self.y / d)
    }

    /// (u, v) of the CIE 1960 UCS diagram, in which correlated colour temperature is defined.
    pub fn uv_1960(self) -> (f64, f64) {
        let (u, v) = self.uv_1976();
        (u, v * 2.0 / 3.0)
    }

    /// From (u, v) of the CIE 1960 UCS diagram.
    pub fn from_uv_1960(u: f64, v: f64) -> Self {
        let d = 2.0 * u - 8.0 * v + 4.0;
        Self {
            x: 3.0 * u / d,
            y: 2.0 * v / d,
        }
    }
}

impl Spectrum {
    /// Tristimulus values of the CIE 1931 observer.
    pub fn tristimulus(&self) -> Tristimulus {
        Tristimulus::of_1_nm(&self.per_nm())
    }

    /// CIE 1931 chromaticity; none without light.
    pub fn chromaticity(&self) -> Option<Chromaticity> {
        self.tristimulus().chromaticity()
    }

    /// S/P ratio: K′_m ∫SV′ dλ / K_m ∫SV dλ with K′_m = 1700 lm/W (CIE 191, ISO/CIE 23539); none without light.
    pub fn sp_ratio(&self) -> Option<f64> {
        let photopic = self.luminous_integral();
        let scotopic: f64 = self
            .per_nm()
            .iter()
            .zip(&crate::tables::V_PRIME)
            .map(|(s, v)| s * v)
            .sum();
        (photopic > 0.0).then(|| 1700.0 * scotopic / photopic)
    }
}

/// Where a spectral line of each whole wavelength lies, 380–700 nm: the curved part of the diagram's border.
///
/// Outside that range the locus turns back on itself by the tables' last digits.
pub fn spectrum_locus() -> impl DoubleEndedIterator<Item = (f64, Chromaticity)> {
    (380..=700).map(|nm| {
        let i = nm - cie::FIRST_NM;
        let (x, y, z) = (cie::X_BAR[i], cie::V_LAMBDA[i], cie::Z_BAR[i]);
        let sum = x + y + z;
        (nm as f64, Chromaticity { x: x / sum, y: y / sum })
    })
}

/// What a colour is against the equal-energy white.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dominant {
    /// Dominant wavelength; none for a purple.
    pub dominant_nm: Option<f64>,
    /// Complementary wavelength; none where a dominant one exists.
    pub complementary_nm: Option<f64>,
    /// Excitation purity, 0 to 1.
    pub purity: f64,
}

/// Dominant wavelength and excitation purity against `white` (CIE 15, 9.2): the ray from the white through the colour
/// to the spectrum locus or the purple line. None for the white itself (its hue has no direction) and for no real
/// colour.
pub fn dominant(colour: Chromaticity, white: Chromaticity) -> Option<Dominant> {
    let (dx, dy) = (colour.x - white.x, colour.y - white.y);
    let distance = dx.hypot(dy);
    if distance < 1e-6 {
        return None;
    }
    let locus: Vec<(f64, Chromaticity)> = spectrum_locus().collect();
    // Where the ray meets a chord from p to q: (share along the chord, multiple of the vector to the colour).
    let meet = |p: Chromaticity, q: Chromaticity, sign: f64| -> Option<(f64, f64)> {
        let (ex, ey) = (q.x - p.x, q.y - p.y);
        let det = sign * (dx * ey - dy * ex);
        if det == 0.0 {
            return None;
        }
        let (px, py) = (p.x - white.x, p.y - white.y);
        let along = (px * ey - py * ex) / det;
        let share = sign * (px * dy - py * dx) / det;
        (along > 0.0 && (0.0..=1.0).contains(&share)).then_some((share, along))
    };
    let on_locus = |sign: f64| {
        locus
            .windows(2)
            .find_map(|w| meet(w[0].1, w[1].1, sign).map(|(s, along)| (w[0].0 + s * (w[1].0 - w[0].0), along)))
    };
    if let Some((nm, along)) = on_locus(1.0) {
        return Some(Dominant {
            dominant_nm: Some(nm),
            complementary_nm: None,
            purity: 1.0 / along,
        });
    }
    let (_, along) = meet(locus[locus.len() - 1].1, locus[0].1, 1.0)?;
    let (nm, _) = on_locus(-1.0)?;
    Some(Dominant {
        dominant_nm: None,
        complementary_nm: Some(nm),
        purity: 1.0 / along,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_energy_is_at_a_third() {
        let e = Spectrum::new(vec![360.0, 830.0], vec![1.0, 1.0]).unwrap();
        let c = e.chromaticity().unwrap();
        // CIE 15 table T.4: x = 0.33331, y = 0.33329 within the tables' digits.
        assert!(
            (c.x - 1.0 / 3.0).abs() < 3e-5 && (c.y - 1.0 / 3.0).abs() < 5e-5,
            "{c:?}"
        );
    }

    #[test]
    fn a_line_is_its_own_dominant_wavelength() {
        for nm in [450.0, 520.0, 555.0, 620.0] {
            let s = Spectrum::new(vec![nm - 1.0, nm, nm + 1.0], vec![0.0, 1.0, 0.0]).unwrap();
            let d = dominant(s.chromaticity().unwrap(), EQUAL_ENERGY).unwrap();
            assert!((d.dominant_nm.unwrap() - nm).abs() < 1e-6, "{d:?}");
            assert!((d.purity - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn a_purple_has_a_complementary_wavelength_only() {
        let d = dominant(Chromaticity { x: 0.35, y: 0.2 }, EQUAL_ENERGY).unwrap();
        assert_eq!(d.dominant_nm, None);
        // colour-science 0.4.7: complementary_wavelength([0.35, 0.2], E) = 540.35… nm.
        let nm = d.complementary_nm.unwrap();
        assert!(
            (530.0..560.0).contains(&nm) && d.purity > 0.3 && d.purity < 1.0,
            "{d:?}"
        );
        assert_eq!(dominant(EQUAL_ENERGY, EQUAL_ENERGY), None);
    }

    #[test]
    fn uv_1960_is_inverted() {
        let c = Chromaticity { x: 0.31, y: 0.33 };
        let (u, v) = c.uv_1960();
        let back = Chromaticity::from_uv_1960(u, v);
        assert!((back.x - c.x).abs() < 1e-14 && (back.y - c.y).abs() < 1e-14);
    }
}
