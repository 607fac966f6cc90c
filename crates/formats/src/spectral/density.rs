//! Values per µm, per Å or per 1/cm become values per nm with their abscissa: S(λ) dλ = S(ν) dν.

use super::axis::AxisUnit;
use super::quantity::{is_radiometric, quantity_of};

/// Where in a unit or heading it stands of what the values are a density: the unit, and the bytes that name it.
struct Density {
    unit: AxisUnit,
    from: usize,
    to: usize,
}

/// Unit names as they stand behind a stroke or before ⁻¹.
const NAMES: [(AxisUnit, &[&str]); 4] = [
    (
        AxisUnit::PerCentimetre,
        &["cm-1", "cm^-1", "cm⁻¹", "cm^(-1)", "cm^{-1}"],
    ),
    (AxisUnit::Nanometre, &["nanometer", "nanometre", "nm"]),
    (
        AxisUnit::Micrometre,
        &["micrometer", "micrometre", "micron", "µm", "μm", "um"],
    ),
    (AxisUnit::Angstrom, &["angstrom", "ångström", "Å", "å"]),
];

fn density(text: &str) -> Option<Density> {
    // ASCII alone changes its case, so that places stay.
    let lower = text.to_ascii_lowercase();
    let letter = |c: char| c.is_alphabetic();
    NAMES.iter().find_map(|(unit, names)| {
        names.iter().find_map(|name| {
            lower.match_indices(name).find_map(|(from, _)| {
                let to = from + name.len();
                let (before, after) = (&lower[..from], &lower[to..]);
                if before.ends_with(letter) || after.starts_with(letter) {
                    return None;
                }
                let inverse = |text: &str| ["-1", "^-1", "⁻¹"].iter().any(|power| text.starts_with(power));
                let below = before.contains('/')
                    || before.trim_end().ends_with("per")
                    || inverse(after)
                    || after.strip_prefix([')', ']']).is_some_and(inverse);
                below.then_some(Density { unit: *unit, from, to })
            })
        })
    })
}

/// What the values of one series are a density of, as its heading and the file's unit say.
pub(super) enum Stated {
    /// Nothing: a ratio, a responsivity, counts; or they are per nm already.
    Nothing,
    /// Per another unit than nm.
    Per(AxisUnit),
    /// A quantity of light that must be a density, and none is named.
    Unsaid,
}

/// Reads heading and unit of a series whose abscissa is in `axis`.
pub(super) fn stated(name: &str, quantity: Option<&str>, unit: Option<&str>, axis: AxisUnit) -> Stated {
    let light = is_radiometric(name)
        || quantity.is_some_and(is_radiometric)
        || [name, unit.unwrap_or("")].iter().any(|text| watts(text));
    let found = density(name).or_else(|| unit.and_then(density));
    match found {
        Some(density) if light && density.unit != AxisUnit::Nanometre => Stated::Per(density.unit),
        Some(_) => Stated::Nothing,
        None if axis == AxisUnit::Nanometre => Stated::Nothing,
        None if light => Stated::Unsaid,
        // A factor between µm and nm changes no colour; ν² between 1/cm and nm does, whatever the values are.
        None => {
            let known = quantity.is_some() || quantity_of(name).0.is_some();
            if axis == AxisUnit::PerCentimetre && !known {
                Stated::Unsaid
            } else {
                Stated::Nothing
            }
        }
    }
}

/// `W/m2`, `mW m-2`, `Wm-2`.
fn watts(text: &str) -> bool {
    ["W/", "W m", "W·m", "W*m", "Wm", "W cm", "Wcm", "W sr"]
        .iter()
        .any(|unit| text.contains(unit))
}

/// Factor from a density per `unit` to one per nm at a wavelength.
pub(super) fn to_per_nm(unit: AxisUnit, wavelength_nm: f64) -> f64 {
    match unit {
        AxisUnit::Micrometre => 1e-3,
        AxisUnit::Angstrom => 10.0,
        AxisUnit::Metre => 1e-9,
        // |dν/dλ| with ν in 1/cm and λ in nm: 10⁷/λ².
        AxisUnit::PerCentimetre => 1e7 / (wavelength_nm * wavelength_nm),
        AxisUnit::Nanometre | AxisUnit::Other(_) => 1.0,
    }
}

/// A unit or heading with nm in place of what the values were a density of.
pub(super) fn renamed(text: &str) -> String {
    match density(text) {
        Some(Density { from, to, .. }) => format!("{}nm{}", &text[..from], &text[to..]),
        None => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn per(name: &str, axis: AxisUnit) -> Option<AxisUnit> {
        match stated(
            name,
            quantity_of(name).0.as_deref(),
            quantity_of(name).1.as_deref(),
            axis,
        ) {
            Stated::Per(unit) => Some(unit),
            Stated::Unsaid => Some(AxisUnit::Other("unsaid")),
            Stated::Nothing => None,
        }
    }

    #[test]
    fn what_a_heading_says_the_values_are_per() {
        use AxisUnit::{Angstrom, Micrometre, Other, PerCentimetre};
        for (name, axis, expected) in [
            ("irradiance W/m2/um", Micrometre, Some(Micrometre)),
            ("Spectral Irradiance [W m^-2 µm^-1]", Micrometre, Some(Micrometre)),
            ("radiance W/m2/sr/cm-1", PerCentimetre, Some(PerCentimetre)),
            ("Radiance (mW/(m2 sr cm-1))", PerCentimetre, Some(PerCentimetre)),
            ("flux (W m-2 Å-1)", Angstrom, Some(Angstrom)),
            ("irradiance (W/m2/nm)", Micrometre, None),
            ("irradiance", Micrometre, Some(Other("unsaid"))),
            ("photon flux (umol/m2/s)", AxisUnit::Nanometre, None),
            ("absorption coefficient (cm-1)", PerCentimetre, None),
            ("reflectance", PerCentimetre, None),
            ("value", PerCentimetre, Some(Other("unsaid"))),
            ("value", Micrometre, None),
        ] {
            assert_eq!(per(name, axis), expected, "{name}");
        }
        assert_eq!(renamed("W m-2 sr-1 µm-1"), "W m-2 sr-1 nm-1");
        assert_eq!(renamed("W/m2/sr/cm-1"), "W/m2/sr/nm");
    }
}
