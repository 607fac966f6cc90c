//! What stands on the abscissa: nm, or something that becomes nm, or no wavelength at all.

/// A unit of the abscissa.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum AxisUnit {
    Nanometre,
    Micrometre,
    Angstrom,
    Metre,
    PerCentimetre,
    /// No wavelength: Hz, m/z, ppm, s, eV, pixels.
    Other(&'static str),
}

impl AxisUnit {
    /// Wavelength in nm, as exact as the text that it came from: `text` is the number as written.
    pub fn to_nm(self, value: f64) -> f64 {
        // Twelve digits hide the dust of a product such as 0.55·1000.
        let clean = |v: f64| format!("{v:.11e}").parse().unwrap_or(v);
        match self {
            Self::Nanometre | Self::Other(_) => value,
            Self::Micrometre => clean(value * 1e3),
            Self::Angstrom => clean(value * 0.1),
            Self::Metre => clean(value * 1e9),
            Self::PerCentimetre => 1e7 / value,
        }
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::Nanometre => "nm",
            Self::Micrometre => "µm",
            Self::Angstrom => "Å",
            Self::Metre => "m",
            Self::PerCentimetre => "1/cm",
            Self::Other(name) => name,
        }
    }

    /// The unit that a heading, or a unit alone, names: `Wavelength (nm)`, `wavelength_nm`, `µm`, `Wavenumber [cm-1]`,
    /// `Frequency (Hz)`. None where it names none.
    pub fn of(heading: &str) -> Option<Self> {
        let lower = heading.to_lowercase().replace('μ', "µ");
        let words: Vec<&str> = lower
            .split(|c: char| !(c.is_alphanumeric() || "µå/^-".contains(c)))
            .filter(|w| !w.is_empty())
            .collect();
        let words = if is_wavelength_heading(heading) {
            words
                .iter()
                .flat_map(|w| w.split('/'))
                .chain(words.iter().copied())
                .collect()
        } else {
            words
        };
        let has = |list: &[&str]| words.iter().any(|w| list.contains(w));
        let begins = |list: &[&str]| words.iter().any(|w| list.iter().any(|l| w.starts_with(l)));
        if lower.contains("1/cm")
            || has(&["cm-1", "cm^-1", "cm⁻¹", "cm^–1", "/cm", "kayser"])
            || lower.contains("cm⁻¹")
            || begins(&["wavenumber"])
            || lower.contains("wave number")
        {
            return Some(Self::PerCentimetre);
        }
        if has(&["nm"]) || begins(&["nanomet"]) || lower.ends_with("(nm)") || lower.ends_with("[nm]") {
            return Some(Self::Nanometre);
        }
        if has(&["µm", "um"]) || begins(&["micron", "micromet"]) {
            return Some(Self::Micrometre);
        }
        if has(&["å"]) || begins(&["angstr", "ångstr"]) || heading.contains("(A)") || heading.contains("[A]") {
            return Some(Self::Angstrom);
        }
        for (words, name) in [
            (&["hz", "khz", "mhz", "ghz", "thz"][..], "Hz"),
            (&["ppm"], "ppm"),
            (&["m/z", "mz", "m/e"], "m/z"),
            (&["ev", "mev", "kev"], "eV"),
            (&["s", "sec", "ms", "second", "seconds", "minutes", "min"], "s"),
        ] {
            if has(words) {
                return Some(Self::Other(name));
            }
        }
        for (starts, name) in [
            (&["frequency"][..], "Hz"),
            (&["chemical"], "ppm"),
            (&["time", "retention"], "s"),
            (&["mass"], "m/z"),
            (&["energy"], "eV"),
        ] {
            if begins(starts) {
                return Some(Self::Other(name));
            }
        }
        has(&["m", "meter", "metre", "meters", "metres"]).then_some(Self::Metre)
    }
}

/// Whether a heading names the wavelength (or what stands in its place).
pub(super) fn is_wavelength_heading(heading: &str) -> bool {
    let lower = heading.trim().to_lowercase();
    let word = lower.split(|c: char| !c.is_alphanumeric()).next().unwrap_or("");
    [
        "wavelength",
        "wavelengths",
        "wave",
        "lambda",
        "λ",
        "wl",
        "nm",
        "wellenlänge",
        "wellenlaenge",
        "longueur",
        "longitud",
        "lunghezza",
        "lamda",
        "wavenumber",
        "wlen",
        "wvl",
        "microns",
        "um",
        "µm",
        "w",
    ]
    .contains(&word)
        || lower.starts_with("wavel")
        || lower.starts_with('λ')
        || lower.contains("wavelength")
        || ["lower wvl", "upper wvl"].contains(&lower.as_str())
        || lower.starts_with("(nm")
        || lower.starts_with("[nm")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_in_headings() {
        for (heading, unit) in [
            ("Wavelength (nm)", AxisUnit::Nanometre),
            ("wavelength_nm", AxisUnit::Nanometre),
            ("Wavelength [µm]", AxisUnit::Micrometre),
            ("lambda/um", AxisUnit::Micrometre),
            ("Wavenumber (cm-1)", AxisUnit::PerCentimetre),
            ("1/CM", AxisUnit::PerCentimetre),
            ("Wavelength (Å)", AxisUnit::Angstrom),
            ("Frequency (THz)", AxisUnit::Other("Hz")),
            ("m/z", AxisUnit::Other("m/z")),
            ("time_s", AxisUnit::Other("s")),
            ("wavelength (m)", AxisUnit::Metre),
        ] {
            assert_eq!(AxisUnit::of(heading), Some(unit), "{heading}");
        }
        assert_eq!(AxisUnit::of("Wavelength"), None);
        assert!(
            is_wavelength_heading("Wavelength (nm)") && is_wavelength_heading("λ") && !is_wavelength_heading("value")
        );
    }

    #[test]
    fn micrometres_without_dust() {
        assert_eq!(AxisUnit::Micrometre.to_nm(0.555), 555.0);
        assert_eq!(AxisUnit::PerCentimetre.to_nm(20_000.0), 500.0);
    }
}
