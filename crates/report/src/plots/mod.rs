//! Pictures of luminaires and light sources: each a function from data to an SVG string.

mod cartesian;
mod cct_over_gamma;
mod chromaticity;
mod colour_directions;
mod colour_over_sphere;
mod colour_steps;
mod cone;
mod contour;
mod control_chart;
mod difference;
mod factor_drift;
mod isocandela;
mod isolux;
mod modulation;
mod polar;
mod scale_bar;
mod shown;
mod solid;
mod spectral_colour;
mod spectrum;
mod thumbnail;
mod tm30;
mod zones;

pub use cartesian::cartesian;
pub use cct_over_gamma::cct_over_gamma;
pub use chromaticity::{Diagram, chromaticity};
pub use colour_directions::{ColourDirections, DirectionColour, STEP};
pub use colour_over_sphere::colour_over_sphere;
pub use colour_steps::colour_steps;
pub use cone::{Cone, cone, cones};
pub use control_chart::{ControlChart, ControlPoint, control_chart};
pub use difference::{DifferenceCurve, difference_over_gamma, difference_over_sphere};
pub use factor_drift::{FactorDrift, factor_drift};
pub use isocandela::isocandela;
pub use isolux::{IsoluxOptions, isolux};
pub use modulation::{light_over_frequency, light_over_time};
pub use polar::{PolarOptions, PolarSoFar, polar, polar_so_far};
pub use solid::solid;
pub use spectrum::{SpectrumOptions, spectrum, spectrum_beside};
pub use thumbnail::{Curves, thumbnail};
pub use tm30::{tm30, tm30_bins};
pub use zones::zones;

#[cfg(test)]
mod tests {
    use isolux_photometry::IntensityDistribution;
    use isolux_spectrum::{Spectrum, illuminant};

    use super::*;

    #[test]
    fn figures_of_a_row_are_equally_high_and_have_one_size_of_text() {
        let gamma: Vec<f64> = (0..=18).map(|k| 10.0 * f64::from(k)).collect();
        for upper in [0.0, 30.0] {
            let row = gamma.iter().map(|g| 100.0 * g.to_radians().cos().max(0.0) + upper);
            let row: Vec<f64> = row.collect();
            let light = IntensityDistribution::new(
                vec![0.0, 90.0, 180.0, 270.0],
                gamma.clone(),
                row.iter().copied().cycle().take(4 * row.len()).collect(),
            )
            .unwrap();
            let lamp = Spectrum::from_1_nm(&illuminant::planck(3000.0)).unwrap();
            let options = PolarOptions::default();
            let colours = colour_directions::tests::yellow_at_the_rim();
            let mut figures = vec![
                colour_steps(&colours),
                colour_over_sphere(&colours),
                cct_over_gamma(&colours).unwrap(),
                control_chart(&ControlChart::default()),
                factor_drift(&[], ""),
                spectrum_beside(&lamp, &lamp, &SpectrumOptions::default(), ["one", "other"]),
                polar(&light, &options),
                polar_so_far(&PolarSoFar::default()),
                cartesian(&light, &options),
                isocandela(&light, &options),
                isolux(&light, &IsoluxOptions::at_one_metre(&light, "")),
                solid(&light, &options),
                spectrum(&lamp, &SpectrumOptions::default()),
                chromaticity(&lamp, Diagram::Cie1931, ""),
                chromaticity(&lamp, Diagram::Cie1976, ""),
                tm30(&lamp, "").unwrap(),
                tm30_bins(&lamp, "").unwrap(),
            ];
            figures.extend(cone(&light));
            for figure in figures {
                assert!(figure.contains("viewBox=\"0 0 500 400\""), "{}", &figure[..200]);
                assert_eq!(figure.matches("font-size").count(), 1, "{}", &figure[..200]);
            }
        }
    }
}
