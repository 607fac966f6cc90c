//! What in a header the standard does not allow although the rays can be read.

use super::header::{DATA, Header, Spectral};

/// Something in a header that the standard does not allow although the rays can be read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Doubt {
    /// Bytes.
    pub span: [u64; 2],
    /// One sentence in lower case, no full stop.
    pub message: String,
}

impl Header {
    /// What the standard does not allow although the rays can be read.
    pub fn doubts(&self) -> Vec<Doubt> {
        let mut doubts = Vec::new();
        let mut say = |wrong: bool, span: [u64; 2], message: String| {
            if wrong {
                doubts.push(Doubt { span, message });
            }
        };
        let columns = &self.columns;
        let flag = |k: u64| [256 + 4 * k, 260 + 4 * k];
        say(
            !(0..=1).contains(&self.method),
            [8, 12],
            format!(
                "creation method {} is neither 0 (simulation) nor 1 (measurement)",
                self.method
            ),
        );
        for (flux, span, name) in [
            (self.luminous_flux_lm, [12, 16], "luminous"),
            (self.radiant_flux_w, [16, 20], "radiant"),
        ] {
            let wrong = flux.is_some_and(|flux| flux < 0.0 || flux.is_infinite());
            say(
                wrong,
                span,
                format!("{name} flux {} of the header is no flux", flux.unwrap_or(0.0)),
            );
        }
        say(self.rays == 0, [20, 28], "the header announces no rays".to_owned());
        say(
            !(0..=7).contains(&self.start),
            [56, 60],
            format!("start of rays {} is none of 0 to 7", self.start),
        );
        if let Spectral::Single(nm) = self.spectral {
            say(
                !(nm > 0.0 && nm.is_finite()),
                [64, 68],
                format!("the single wavelength is {nm} nm"),
            );
        }
        let several = matches!(self.spectral, Spectral::PerRay | Spectral::Table | Spectral::Tables);
        for (value, span, name) in [
            (self.range_nm[0], [68, 72], "shortest"),
            (self.range_nm[1], [72, 76], "longest"),
        ] {
            let given = value.is_some_and(|nm| nm > 0.0 && nm.is_finite());
            say(
                several && !given,
                span,
                format!("the {name} wavelength is needed with spectral data"),
            );
        }
        let by_wavelength = matches!(self.spectral, Spectral::PerRay | Spectral::Tables);
        say(
            by_wavelength && (columns.luminous || !columns.radiant),
            flag(2),
            "rays with wavelengths or spectra of their own carry radiant flux alone".to_owned(),
        );
        say(
            matches!(self.spectral, Spectral::Table | Spectral::Tables) && self.tables.is_empty(),
            [76, 80],
            "the spectral type needs a table, there is none".to_owned(),
        );
        say(
            columns.stokes && !columns.radiant,
            flag(5),
            "polarisation is given without radiant flux".to_owned(),
        );
        say(
            columns.tristimulus && !(columns.luminous && self.spectral == Spectral::None),
            flag(6),
            "tristimulus X and Z go with luminous flux and no spectrum".to_owned(),
        );
        say(
            columns.spectrum != (self.spectral == Spectral::Tables),
            flag(7),
            "an index of spectra goes with spectral type 4 and with no other".to_owned(),
        );
        for table in &self.tables {
            let wrong = table.wavelength_nm.iter().any(|nm| !(*nm > 0.0 && nm.is_finite()))
                || table
                    .weight
                    .iter()
                    .any(|weight| !(*weight >= 0.0 && weight.is_finite()));
            say(
                wrong,
                [DATA as u64, self.data],
                "a spectrum has a wavelength that is not above zero, or a weight below zero".to_owned(),
            );
        }
        doubts
    }
}
