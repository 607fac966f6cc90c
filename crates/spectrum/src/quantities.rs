//! Everything a photometrist asks of a spectrum, with the names that `inspect --json` prints.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{EQUAL_ENERGY, Spectrum, action, dominant, fidelity, meter, rendering};

/// The quantities of one spectrum. What the data do not allow is none.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Quantities {
    /// ∫S dλ over 360–830 nm, in the file's unit × nm.
    pub integral: f64,
    /// 683 lm/W × ∫SV dλ likewise.
    pub luminous_integral: f64,
    /// Luminous efficacy of radiation, lm/W.
    pub ler_lm_per_w: Option<f64>,
    /// CIE 1931 x.
    pub x: Option<f64>,
    /// CIE 1931 y.
    pub y: Option<f64>,
    /// CIE 1976 u′.
    pub u_prime: Option<f64>,
    /// CIE 1976 v′.
    pub v_prime: Option<f64>,
    /// Correlated colour temperature, K; none farther than 0.05 from the Planckian locus.
    pub cct_k: Option<f64>,
    /// Signed distance from the Planckian locus in (u, v) 1960.
    pub duv: Option<f64>,
    /// Dominant wavelength against equal energy, nm; none for a purple.
    pub dominant_nm: Option<f64>,
    /// Complementary wavelength of a purple, nm.
    pub complementary_nm: Option<f64>,
    /// Wavelength of the highest point, nm.
    pub peak_nm: Option<f64>,
    /// Centroid wavelength over the whole range of the data, nm.
    pub centroid_nm: Option<f64>,
    /// Full width at half maximum about the peak, nm.
    pub fwhm_nm: Option<f64>,
    /// Excitation purity against equal energy, 0 to 1.
    pub purity: Option<f64>,
    /// General colour rendering index.
    pub ra: Option<f64>,
    /// Special colour rendering indices R1–R15.
    pub r: Option<[f64; 15]>,
    /// Colour fidelity index (CIE 224, TM-30).
    pub rf: Option<f64>,
    /// Gamut index (TM-30).
    pub rg: Option<f64>,
    /// Local fidelity of the sixteen hue bins.
    pub rf_hue: Option<[f64; 16]>,
    /// Local chroma shift of the sixteen hue bins, percent.
    pub rcs_hue_percent: Option<[f64; 16]>,
    /// S/P ratio.
    pub sp_ratio: Option<f64>,
    /// Blue-light hazard efficacy of luminous radiation K_B,v, mW/lm (IEC TR 62778).
    #[serde(default)]
    pub k_bv_mw_per_lm: Option<f64>,
    /// Illuminance below which the light is of no higher risk group than 1 whatever the size of its source, lx.
    #[serde(default)]
    pub e_thr_lx: Option<f64>,
    /// Photons of 400–700 nm for each 1000 lm, µmol/s.
    #[serde(default)]
    pub photons_umol_per_s_klm: Option<f64>,
    /// f1′ if these values are a meter's responsivity, as a fraction.
    pub f1_prime: Option<f64>,
}

/// Computes all quantities of a spectrum.
pub fn quantities(data: &Spectrum) -> Quantities {
    // All but the peak and the centroid rest on the entries at whole nanometres: of fine data these are integrated
    // once.
    let entries = Spectrum::from_1_nm(&data.per_nm());
    let spectrum = entries.as_ref().unwrap_or(data);
    let chromaticity = spectrum.chromaticity();
    let uv = chromaticity.map(crate::Chromaticity::uv_1976);
    let colour = chromaticity.and_then(|c| dominant(c, EQUAL_ENERGY));
    let rendering = rendering::rendering(spectrum);
    let fidelity = fidelity::fidelity(spectrum);
    let k_bv = spectrum.k_bv_w_per_lm();
    Quantities {
        integral: spectrum.integral(),
        luminous_integral: spectrum.luminous_integral(),
        ler_lm_per_w: spectrum.ler_lm_per_w(),
        x: chromaticity.map(|c| c.x),
        y: chromaticity.map(|c| c.y),
        u_prime: uv.map(|uv| uv.0),
        v_prime: uv.map(|uv| uv.1),
        cct_k: spectrum.cct().map(|c| c.cct_k),
        duv: spectrum.nearest_planckian().map(|c| c.duv),
        dominant_nm: colour.and_then(|d| d.dominant_nm),
        complementary_nm: colour.and_then(|d| d.complementary_nm),
        peak_nm: data.peak_nm(),
        centroid_nm: data.centroid_nm(),
        fwhm_nm: data.fwhm_nm(),
        purity: colour.map(|d| d.purity),
        ra: rendering.map(|r| r.ra),
        r: rendering.map(|r| r.r),
        rf: fidelity.as_ref().map(|f| f.rf),
        rg: fidelity.as_ref().map(|f| f.rg),
        rf_hue: fidelity.as_ref().map(|f| f.bins.map(|b| b.rf)),
        rcs_hue_percent: fidelity.as_ref().map(|f| f.bins.map(|b| b.chroma_shift_percent)),
        sp_ratio: spectrum.sp_ratio(),
        k_bv_mw_per_lm: k_bv.map(|k_bv| 1e3 * k_bv),
        e_thr_lx: k_bv.filter(|k_bv| *k_bv > 0.0).map(action::threshold_illuminance_lx),
        photons_umol_per_s_klm: spectrum.photons_umol_per_s_lm().map(|photons| 1e3 * photons),
        f1_prime: meter::f1_prime(spectrum),
    }
}
