//! Peak, centroid and width of a spectrum, from its own points over its whole range.

use crate::Spectrum;

impl Spectrum {
    /// Wavelength of the highest point (the first of equals), nm; none where no value is above zero.
    pub fn peak_nm(&self) -> Option<f64> {
        self.peak().map(|i| self.wavelength_nm()[i])
    }

    /// Centroid wavelength ∫λS dλ / ∫S dλ of the linear interpolant, nm; none where ∫S dλ is not above zero.
    pub fn centroid_nm(&self) -> Option<f64> {
        let (mut weight, mut moment) = (0.0, 0.0);
        for (w, v) in self.wavelength_nm().windows(2).zip(self.value().windows(2)) {
            let h = w[1] - w[0];
            weight += 0.5 * h * (v[0] + v[1]);
            // Exact for a product of two linear functions.
            moment += h / 6.0 * (w[0] * (2.0 * v[0] + v[1]) + w[1] * (v[0] + 2.0 * v[1]));
        }
        (weight > 0.0).then(|| moment / weight).filter(|c| c.is_finite())
    }

    /// Full width at half the highest value, between the crossings nearest to the peak (CIE 127), nm; none where a side
    /// does not fall to half inside the data.
    pub fn fwhm_nm(&self) -> Option<f64> {
        let peak = self.peak()?;
        let (w, v) = (self.wavelength_nm(), self.value());
        let half = 0.5 * v[peak];
        let crossing = |low: usize, high: usize| w[low] + (half - v[low]) / (v[high] - v[low]) * (w[high] - w[low]);
        let left = (0..peak).rev().find(|&i| v[i] <= half)?;
        let right = (peak + 1..v.len()).find(|&i| v[i] <= half)?;
        Some(crossing(right, right - 1) - crossing(left, left + 1))
    }

    fn peak(&self) -> Option<usize> {
        let mut best: Option<usize> = None;
        for (i, &v) in self.value().iter().enumerate() {
            if v > best.map_or(0.0, |b| self.value()[b]) {
                best = Some(i);
            }
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gaussian_has_its_own_width_and_centre() {
        let nm: Vec<f64> = (4000..=6000).map(|i| i as f64 / 10.0).collect();
        let sigma = 12.0;
        let v = nm
            .iter()
            .map(|w| (-0.5 * ((w - 503.2f64) / sigma).powi(2)).exp())
            .collect();
        let s = Spectrum::new(nm, v).unwrap();
        assert!((s.peak_nm().unwrap() - 503.2).abs() < 1e-9);
        assert!((s.centroid_nm().unwrap() - 503.2).abs() < 1e-6);
        assert!((s.fwhm_nm().unwrap() - 2.354_820_045 * sigma).abs() < 1e-3);
    }

    #[test]
    fn a_triangle_on_two_slopes() {
        let s = Spectrum::new(vec![400.0, 410.0, 440.0], vec![0.0, 2.0, 0.0]).unwrap();
        assert_eq!(s.fwhm_nm(), Some(20.0));
        // Centroid of a triangle: mean of its corners.
        assert!((s.centroid_nm().unwrap() - 1250.0 / 3.0).abs() < 1e-9);
    }

    #[test]
    fn no_light_no_peak_and_a_cut_side_no_width() {
        let dark = Spectrum::new(vec![400.0, 500.0], vec![0.0, -1.0]).unwrap();
        assert_eq!((dark.peak_nm(), dark.centroid_nm(), dark.fwhm_nm()), (None, None, None));
        let cut = Spectrum::new(vec![400.0, 500.0], vec![1.0, 0.2]).unwrap();
        assert_eq!(cut.fwhm_nm(), None);
    }
}
