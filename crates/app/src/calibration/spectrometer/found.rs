//! What a procedure found of a spectroradiometer: files, lines of the station and of the diary, sentences.

use camino::Utf8Path;
use isolux_record::spectra::{Linearity, Made, Scatter, WavelengthScale};
use jiff::Timestamp;
use serde::Serialize;

use crate::Failure;
use crate::history::{Entry, Kind};

/// Wavelengths of the scale that are followed, nm.
const AT_NM: [f64; 3] = [450.0, 550.0, 650.0];
/// Where the uncertainty of the scale counts for colour, nm.
const VISIBLE_NM: std::ops::RangeInclusive<u32> = 400..=700;
/// Counts over full scale at which the linearity is followed.
const AT_REL: [f64; 2] = [0.25, 0.7];

/// What a procedure found.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Found {
    /// Wavelength scale and bandpass.
    Wavelengths(WavelengthScale),
    /// Scattered light.
    Scatter(Scatter),
    /// Linearity.
    Linearity(Linearity),
}

impl Found {
    /// Its key in `[spectroradiometer]`, which names its file too.
    const fn key(&self) -> &'static str {
        match self {
            Self::Wavelengths(_) => "wavelengths",
            Self::Scatter(_) => "scatter",
            Self::Linearity(_) => "linearity",
        }
    }

    /// Where it comes from.
    pub const fn made(&self) -> &Made {
        match self {
            Self::Wavelengths(found) => &found.made,
            Self::Scatter(found) => &found.made,
            Self::Linearity(found) => &found.made,
        }
    }

    pub(super) const fn made_mut(&mut self) -> &mut Made {
        match self {
            Self::Wavelengths(found) => &mut found.made,
            Self::Scatter(found) => &mut found.made,
            Self::Linearity(found) => &mut found.made,
        }
    }

    /// The file that the station names, and the lines for it.
    ///
    /// # Errors
    /// Exit 3 for a file that no station would read.
    pub(super) fn files(&self) -> Result<Vec<(String, String)>, Failure> {
        let name = format!("{}.toml", self.key());
        let file = Utf8Path::new(&name);
        let (words, text) = match self {
            Self::Wavelengths(found) => (
                "# True wavelength = stated + Σ offset_nm[k]·tᵏ, t = (stated − 550 nm)/300 nm. Wavelengths in air.\n\
                 # fwhm_nm is that of the triangle with the variance of the lines' images.\n",
                toml::to_string(found),
            ),
            Self::Scatter(found) => (
                "# share_rel[i][j]: counts that light of band j leaves, evenly over the pixels of band i, over its \
                 own; one band: all pixels.\n",
                toml::to_string(found),
            ),
            Self::Linearity(found) => (
                "# Linear counts = counts ÷ (1 + Σ coefficient[k]·xᵏ⁺¹), x = counts over full scale.\n",
                toml::to_string(found),
            ),
        };
        let text = text.map_err(Failure::instrument)?;
        let text = format!("{words}# Standard uncertainties (k = 1).\n{text}");
        let read = match self {
            Self::Wavelengths(_) => WavelengthScale::parse(file, &text).map(drop),
            Self::Scatter(_) => Scatter::parse(file, &text).map(drop),
            Self::Linearity(_) => Linearity::parse(file, &text).map(drop),
        };
        read.map_err(Failure::instrument)?;
        let lines = self.station_lines().join("\n") + "\n";
        Ok(vec![(name, text), ("station-lines.toml".to_owned(), lines)])
    }

    /// Lines for `[spectroradiometer]` in STATION.toml.
    pub fn station_lines(&self) -> Vec<String> {
        let key = self.key();
        let mut lines = vec!["[spectroradiometer]".to_owned(), format!("{key} = \"{key}.toml\"")];
        if let Self::Wavelengths(scale) = self {
            let visible = VISIBLE_NM.map(|nm| scale.u_nm(f64::from(nm)));
            lines.push(format!("u_wavelength_nm = {:.4}", visible.fold(0.0, f64::max)));
        }
        lines
    }

    /// Lines of the diary; `run` is the record as it was called.
    pub(super) fn entries(&self, run: &Utf8Path) -> Vec<Entry> {
        let entry = |quantity: String, value: f64, unit: &str, u: f64| Entry {
            time_utc: Timestamp::now().to_string(),
            kind: Kind::Calibration,
            quantity: format!("spectroradiometer: {quantity}"),
            value,
            unit: unit.to_owned(),
            u,
            run: run.to_string(),
            record_sha256: self.made().record_sha256.clone(),
        };
        match self {
            Self::Wavelengths(scale) => {
                let offset = |nm: f64| {
                    let quantity = format!("true less stated wavelength at {nm:.0} nm");
                    entry(quantity, scale.true_nm(nm) - nm, "nm", scale.u_nm(nm))
                };
                let mut entries = AT_NM.map(offset).to_vec();
                entries.push(entry("bandpass".to_owned(), scale.fwhm_nm, "nm", scale.u_fwhm_nm));
                entries
            }
            Self::Scatter(scatter) => {
                let (share, u) = most(scatter);
                vec![entry("scattered light".to_owned(), share, "", u)]
            }
            Self::Linearity(linearity) => {
                let at = |x: f64| {
                    let quantity = format!("non-linearity at {x} of full scale");
                    entry(quantity, linearity.divisor(x) - 1.0, "", linearity.u_rel(x))
                };
                AT_REL.map(at).to_vec()
            }
        }
    }

    /// What a person reads first, a sentence each.
    pub fn sentences(&self) -> Vec<String> {
        let made = self.made();
        let head = format!("{} with {}", made.instrument, made.with);
        match self {
            Self::Wavelengths(scale) => of_scale(scale, &head),
            Self::Scatter(scatter) => {
                let (share, u) = most(scatter);
                let found = format!(
                    "scattered light {share:.2e} ± {:.1e} of all light, evenly over the pixels (k = 2)",
                    2.0 * u
                );
                vec![head, found]
            }
            Self::Linearity(linearity) => {
                let at = |x: f64| {
                    format!(
                        "{:+.3} ± {:.3} % at {x} of full scale",
                        100.0 * (linearity.divisor(x) - 1.0),
                        200.0 * linearity.u_rel(x)
                    )
                };
                vec![
                    head,
                    format!("counts over linear ones, less 1 (k = 2): {}", AT_REL.map(at).join(", ")),
                ]
            }
        }
    }
}

/// The largest share and its uncertainty.
fn most(scatter: &Scatter) -> (f64, f64) {
    let shares = scatter.share_rel.iter().flatten().copied();
    let shares = shares.zip(scatter.u_share_rel.iter().flatten().copied());
    shares
        .max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))
        .unwrap_or_default()
}

fn of_scale(scale: &WavelengthScale, head: &str) -> Vec<String> {
    let [first_nm, last_nm] = scale.range_nm;
    let offset = |nm: f64| {
        format!(
            "{:+.3} ± {:.3} nm at {nm:.0} nm",
            scale.true_nm(nm) - nm,
            2.0 * scale.u_nm(nm)
        )
    };
    let residual =
        |line: &isolux_record::spectra::LineFound| format!("{:.3} nm {:+.3}", line.wavelength_nm, line.residual_nm);
    let residuals: Vec<String> = scale.line.iter().map(residual).collect();
    vec![
        format!(
            "{head}: {} lines from {first_nm:.1} nm to {last_nm:.1} nm",
            scale.line.len()
        ),
        format!("true less stated wavelength (k = 2): {}", AT_NM.map(offset).join(", ")),
        format!(
            "bandpass {:.3} ± {:.3} nm (k = 2)",
            scale.fwhm_nm,
            2.0 * scale.u_fwhm_nm
        ),
        format!("lines off the corrected scale, nm: {}", residuals.join(", ")),
    ]
}
