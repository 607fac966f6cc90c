//! Colour of a spectrum, with uncertainty: every number is computed again from the spectrum with one
//! thing after the other moved, by its standard uncertainty or by a small step (JCGM 100, 5.1.3, note 2).

use isolux_spectrum::Spectrum;
use isolux_spectrum::cct::{Cct, nearest_planckian};
use isolux_spectrum::fidelity::fidelity_of;
use isolux_spectrum::rendering::rendering_of;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::known::Known;
use crate::quantity::Quantity;

/// Colour by CIE 15, CIE 13.3 and CIE 224; none where the light has no such number.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Colour {
    /// Correlated colour temperature in K.
    pub cct: Option<Quantity>,
    /// Distance from the Planckian locus, CIE 1960 UCS; above it is positive.
    pub duv: Option<Quantity>,
    /// Chromaticity x of CIE 1931.
    pub x: Option<Quantity>,
    /// Chromaticity y of CIE 1931.
    pub y: Option<Quantity>,
    /// Chromaticity u′ of CIE 1976.
    pub u_prime: Option<Quantity>,
    /// Chromaticity v′ of CIE 1976.
    pub v_prime: Option<Quantity>,
    /// General colour rendering index.
    pub ra: Option<Quantity>,
    /// Special colour rendering index of the saturated red sample.
    pub r9: Option<Quantity>,
    /// Colour fidelity index.
    pub rf: Option<Quantity>,
    /// Colour gamut index.
    pub rg: Option<Quantity>,
    /// Blue-light hazard efficacy of luminous radiation K_B,v, mW/lm.
    pub k_bv: Option<Quantity>,
    /// Photons of 400–700 nm for each 1000 lm, µmol/s/klm.
    pub photons: Option<Quantity>,
}

/// How many numbers.
pub const COUNT: usize = 12;
/// Values of the spectrum (1 nm) that share a slope.
const EVERY: usize = 10;
/// By what a value is moved, relative to the largest.
const STEP_REL: f64 = 1e-4;

impl Colour {
    /// Of a spectrum whose values have the standard uncertainties `u_w_m2_nm` from their scatter; `moved` is it with
    /// corrections of the instrument moved by theirs, each by its part.
    pub fn of(spectrum: &Spectrum, u_w_m2_nm: &[f64], known: &Known, moved: &[(&'static str, Spectrum)]) -> Self {
        let centre = numbers(spectrum);
        let change = |changed: Option<Spectrum>| changes(&centre, changed.as_ref());
        let shape = change(shape_changed(spectrum, known.shape_rel));
        let bow = change(bow_changed(spectrum, known.shape_rel));
        let wavelength = change(wavelengths_changed(spectrum, known.wavelength_nm));
        let mut parts = vec![
            ("noise", noise(spectrum, u_w_m2_nm, &centre)),
            ("calibration_shape", shape),
            ("calibration_bow", bow),
            ("wavelength", wavelength),
        ];
        parts.extend(moved.iter().map(|(part, there)| (*part, changes(&centre, Some(there)))));
        Self::from_parts(&centre, &parts, &known.colour)
    }

    /// Of the numbers of a spectrum, the parts of their uncertainty, and what is missing in it.
    pub fn from_parts(
        centre: &[Option<f64>; COUNT],
        parts: &[(&'static str, [f64; COUNT])],
        missing: &[String],
    ) -> Self {
        let quantity = |number: usize, unit| {
            let parts = parts.iter().map(|(name, part)| (*name, part[number]));
            Some(Quantity::new(centre[number]?, unit, parts).lacking(missing.iter().cloned()))
        };
        Self {
            cct: quantity(0, "K"),
            duv: quantity(1, ""),
            x: quantity(2, ""),
            y: quantity(3, ""),
            u_prime: quantity(4, ""),
            v_prime: quantity(5, ""),
            ra: quantity(6, ""),
            r9: quantity(7, ""),
            rf: quantity(8, ""),
            rg: quantity(9, ""),
            k_bv: quantity(10, "mW/lm"),
            photons: quantity(11, "µmol/s/klm"),
        }
    }
}

/// What the scatter of the values leaves in each number. Its slope is taken every [`EVERY`] values and held between
/// them: colour matching functions and test colours are tens of nanometres wide.
pub fn noise(spectrum: &Spectrum, u_w_m2_nm: &[f64], centre: &[Option<f64>; COUNT]) -> [f64; COUNT] {
    let largest = spectrum
        .value()
        .iter()
        .fold(0.0_f64, |most, value| most.max(value.abs()));
    let step = STEP_REL * largest;
    let mut squares = [0.0; COUNT];
    for (run, u) in u_w_m2_nm.chunks(EVERY).enumerate() {
        let u2: f64 = u.iter().map(|u| u * u).sum();
        if u2 == 0.0 {
            continue;
        }
        let mut value = spectrum.value().to_vec();
        value[run * EVERY + u.len() / 2] += step;
        let moved = Spectrum::new(spectrum.wavelength_nm().to_vec(), value).ok();
        for (sum, change) in squares.iter_mut().zip(changes(centre, moved.as_ref())) {
            *sum += (change / step).powi(2) * u2;
        }
    }
    squares.map(f64::sqrt)
}

/// CCT, Duv, x, y, u′, v′, Ra, R9, Rf, Rg, K_B,v and photons; none where the light has no such number.
pub fn numbers(spectrum: &Spectrum) -> [Option<f64>; COUNT] {
    let chromaticity = spectrum.chromaticity();
    let uv = chromaticity.map(isolux_spectrum::Chromaticity::uv_1976);
    let nearest = chromaticity.and_then(nearest_planckian);
    let per_nm = spectrum.per_nm();
    let rendering = nearest.and_then(|nearest| rendering_of(&per_nm, nearest));
    let fidelity = nearest.and_then(|nearest| fidelity_of(&per_nm, nearest));
    [
        nearest.and_then(Cct::meaningful).map(|cct| cct.cct_k),
        nearest.map(|nearest| nearest.duv),
        chromaticity.map(|c| c.x),
        chromaticity.map(|c| c.y),
        uv.map(|uv| uv.0),
        uv.map(|uv| uv.1),
        rendering.as_ref().map(|rendering| rendering.ra),
        rendering.as_ref().map(|rendering| rendering.r[8]),
        fidelity.as_ref().map(|fidelity| fidelity.rf),
        fidelity.as_ref().map(|fidelity| fidelity.rg),
        spectrum.k_bv_w_per_lm().map(|k_bv| 1e3 * k_bv),
        spectrum.photons_umol_per_s_lm().map(|photons| 1e3 * photons),
    ]
}

/// By what each number of `changed` differs from `centre`; zero where one of them is none.
pub fn changes(centre: &[Option<f64>; COUNT], changed: Option<&Spectrum>) -> [f64; COUNT] {
    let there = changed.map_or([None; COUNT], numbers);
    std::array::from_fn(|number| match (there[number], centre[number]) {
        (Some(there), Some(centre)) => there - centre,
        _ => 0.0,
    })
}

/// The spectrum with a calibration whose ratio of 700 nm to 400 nm is off by `rel`, linear in the wavelength.
pub fn shape_changed(spectrum: &Spectrum, rel: f64) -> Option<Spectrum> {
    scaled(spectrum, |nm| 1.0 + rel * (nm - 550.0) / 300.0)
}

/// The spectrum with a calibration whose ratio of 550 nm to 400 nm and 700 nm is off by `rel`, along a parabola. A tilt
/// alone moves the light along the Planckian locus, and Duv and colour rendering would look better than they are.
pub fn bow_changed(spectrum: &Spectrum, rel: f64) -> Option<Spectrum> {
    let factor = |nm: f64| 1.0 + 0.5 * rel * (1.0 - 8.0 * ((nm - 550.0) / 300.0).powi(2));
    scaled(spectrum, factor)
}

fn scaled(spectrum: &Spectrum, factor: impl Fn(f64) -> f64) -> Option<Spectrum> {
    let pairs = spectrum.wavelength_nm().iter().zip(spectrum.value());
    let value = pairs.map(|(nm, value)| value * factor(*nm)).collect();
    Spectrum::new(spectrum.wavelength_nm().to_vec(), value).ok()
}

/// The spectrum on a wavelength scale that is off by `nm`, at the wavelengths that it had.
pub fn wavelengths_changed(spectrum: &Spectrum, nm: f64) -> Option<Spectrum> {
    let at = spectrum.wavelength_nm();
    let value = spectrum.value();
    let slope = |place: usize| {
        let (low, high) = (place.saturating_sub(1), (place + 1).min(at.len() - 1));
        (value[high] - value[low]) / (at[high] - at[low])
    };
    Spectrum::new(
        at.to_vec(),
        (0..at.len()).map(|place| value[place] - nm * slope(place)).collect(),
    )
    .ok()
}
