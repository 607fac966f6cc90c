//! Draws every plot of a made-up luminaire into a folder, to look at.

use std::path::Path;

use isolux_photometry::IntensityDistribution;
use isolux_report::plots::{self, PolarOptions, SpectrumOptions};
use isolux_spectrum::Spectrum;

fn main() -> std::io::Result<()> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| "target/pictures".into());
    let folder = Path::new(&folder);
    std::fs::create_dir_all(folder)?;
    let c: Vec<f64> = (0..24).map(|i| 15.0 * f64::from(i)).collect();
    let gamma: Vec<f64> = (0..=90).map(|i| 2.0 * f64::from(i)).collect();
    let street = |c: f64, g: f64| {
        let (x, y) = (
            g.to_radians().sin() * c.to_radians().cos(),
            g.to_radians().sin() * c.to_radians().sin(),
        );
        let down = g.to_radians().cos().max(0.0);
        1000.0 * down.powf(0.8) * (0.25 + 2.0 * x * x + 0.35 * y + 0.2 * y * y)
            + if g > 90.0 {
                40.0 * (g - 90.0).to_radians().sin()
            } else {
                0.0
            }
    };
    let cd = c
        .iter()
        .flat_map(|&c| gamma.iter().map(move |&g| street(c, g)))
        .collect();
    let Ok(d) = IntensityDistribution::new(c, gamma, cd) else {
        return Ok(());
    };
    let nm: Vec<f64> = (380..=780).map(f64::from).collect();
    let led = nm
        .iter()
        .map(|w| {
            0.9 * (-0.5 * ((w - 452.0) / 10.0f64).powi(2)).exp() + 0.75 * (-0.5 * ((w - 570.0) / 52.0f64).powi(2)).exp()
        })
        .collect();
    let Ok(s) = Spectrum::new(nm, led) else { return Ok(()) };
    let options = PolarOptions {
        title: "Street light, made up".into(),
        per_lamp_flux_lm: Some(d.flux_lm()),
        doubtful_cd: None,
    };
    let spectrum = SpectrumOptions {
        title: "Cool white LED, made up".into(),
        value_label: "spectral irradiance in W/(m²·nm)".into(),
    };
    for (name, svg) in [
        ("isocandela", plots::isocandela(&d, &options)),
        (
            "isolux",
            plots::isolux(&d, &plots::IsoluxOptions::at_one_metre(&d, "Street light, made up")),
        ),
        ("solid", plots::solid(&d, &options)),
        (
            "cie1931",
            plots::chromaticity(&s, plots::Diagram::Cie1931, "Cool white LED, made up"),
        ),
        (
            "cie1976",
            plots::chromaticity(&s, plots::Diagram::Cie1976, "Cool white LED, made up"),
        ),
        ("tm30", plots::tm30(&s, "Cool white LED, made up").unwrap_or_default()),
        ("polar", plots::polar(&d, &options)),
        ("cartesian", plots::cartesian(&d, &options)),
        ("spectrum", plots::spectrum(&s, &spectrum)),
    ] {
        std::fs::write(folder.join(format!("{name}.svg")), svg)?;
    }
    Ok(())
}
