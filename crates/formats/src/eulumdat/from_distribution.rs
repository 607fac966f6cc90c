//! A distribution of any source as an EULUMDAT file.

use super::document::{Header, LampSet};
use super::fields::{HEADER, SET, share};
use super::write::{rewrite, write};
use crate::distribution::Distribution;
use crate::finding::Finding;
use crate::ies::edition::Edition;
use crate::lost::with_losses;
use crate::options::WriteOptions;
use crate::parsed::{Format, Written};

pub(crate) fn encode(distribution: &Distribution, options: &WriteOptions) -> Result<Written, Finding> {
    options.only_for(Format::EULUMDAT)?;
    let written = match &distribution.eulumdat {
        Some(document) if !options.edited => rewrite(document, &distribution.intensity),
        Some(document) => write(&distribution.intensity, &document.header)?,
        None => write(&distribution.intensity, &distribution.eulumdat_header())?,
    };
    Ok(with_losses(written, distribution, Format::EULUMDAT, Edition::E2002))
}

impl Distribution {
    /// The header of an EULUMDAT file. Without a lamp flux, and for absolute photometry, the reference is the
    /// luminaire's own flux: lamp count −1, LORL 100.
    pub fn eulumdat_header(&self) -> Header {
        let luminaire = &self.luminaire;
        let integral = self.intensity.flux_lm();
        let (count, flux, lorl) = match self.lamp_flux_lm {
            Some(flux) if self.absolute => (-luminaire.lamp_count.unwrap_or(1.0), flux, None),
            Some(flux) => (luminaire.lamp_count.unwrap_or(1.0), flux, None),
            None => (-luminaire.lamp_count.unwrap_or(1.0).max(1.0), integral, Some(100.0)),
        };
        let (mut header, mut set) = (Header::default(), LampSet::default());
        let mut shared = luminaire.clone();
        share(HEADER, &mut header, &mut shared, false);
        share(SET, &mut set, &mut shared, false);
        (set.count, set.flux_lm) = (Some(count), Some(flux));
        header.length_mm = luminaire.length_mm.or(luminaire.luminous_length_mm);
        header.width_mm = luminaire.width_mm.or(luminaire.luminous_width_mm);
        header.lorl_percent = lorl;
        header.tilt_deg.get_or_insert(0.0);
        header.lamp_sets.push(set);
        header
    }
}
