//! What the instrument stores of itself: read twice, compared, and held against what its detector can be.
//!
//! EEPROM slots and irradiance factors come without a checksum. One bit flipped in the first coefficient of the
//! wavelengths shifts a whole spectrum and still looks like an instrument, so no single reading is believed.

use std::collections::BTreeMap;
use std::fmt;

use isolux_device::{DeviceError, ErrorKind};
use isolux_protocol_ooi::{Answer, EepromSlot, FULL_SCALE, IRRADIANCE_BLOCK, PIXELS, Request, slots};

use crate::line::Line;

/// Wavelengths that a silicon detector behind any grating of the maker can see, nm.
const SEEN_NM: (f64, f64) = (175.0, 1200.0);
/// The finest grating spreads more than this over the detector, nm.
const LEAST_SPAN_NM: f64 = 20.0;
/// The dispersion changes over the detector, but no step between pixels is further from the mean than this factor.
const STEP_FACTOR: f64 = 2.5;
/// The correction of a detector's non-linearity is some per cent.
const LINEARITY: (f64, f64) = (0.7, 1.4);
/// Counts below which no detector saturates: a quarter of the converter's range.
const LEAST_SATURATION: u16 = FULL_SCALE / 4;
/// Neighbouring pixels have neighbouring factors: one that is off by this factor between two that agree within 2 is
/// damage.
const SPIKE: f64 = 10.0;

/// Places that are read between two proofs that the answers are in step with the requests.
const A_CHUNK: usize = 8;
/// Readings of such a chunk within which one must be in step.
const MOST_READINGS: usize = 20;

/// Where something is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Place {
    /// An EEPROM slot.
    Slot(u8),
    /// Sixty bytes of the irradiance factors, by their byte address.
    Factors(u16),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Slot(slot) => write!(f, "EEPROM slot {slot}"),
            Self::Factors(address) => write!(f, "the block of irradiance factors at byte {address}"),
        }
    }
}

/// What is stored, as it was read. No factors when the instrument does not know the command.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Stored(BTreeMap<Place, Vec<u8>>);

/// The same as numbers that can be used.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Checked {
    pub serial: Option<String>,
    pub wavelength_nm: Vec<f64>,
    pub nonlinearity: Vec<f64>,
    pub saturation_counts: u16,
    pub irradiance_factor: Option<Vec<f64>>,
}

impl Stored {
    /// Reads everything in two passes, so that a repeated answer cannot confirm itself. Where the two differ a third
    /// reading decides, if it is one of them.
    pub async fn read_twice(line: &Line) -> Result<Self, DeviceError> {
        let (mut first, second) = (Self::read(line).await?, Self::read(line).await?);
        if first.0.len() != second.0.len() {
            let reason = "it gave irradiance factors once and refused them once: check the link, then open it again";
            return Err(line.fault(reason, &[]));
        }
        for (place, data) in &mut first.0 {
            let again = second.0.get(place).cloned().unwrap_or_default();
            if *data != again {
                let third = read_in_step(line, &[*place]).await?.remove(place).unwrap_or_default();
                *data = decide(line, *place, [std::mem::take(data), again, third])?;
            }
        }
        Ok(first)
    }

    async fn read(line: &Line) -> Result<Self, DeviceError> {
        let mut stored = BTreeMap::new();
        let alone = [slots::SERIAL, slots::NONLINEARITY_ORDER, slots::SATURATION];
        let all = alone.into_iter().chain(slots::WAVELENGTH).chain(slots::NONLINEARITY);
        let all: Vec<Place> = all.map(Place::Slot).collect();
        for places in all.chunks(A_CHUNK) {
            stored.extend(read_in_step(line, places).await?);
        }
        let addresses = (0..4 * PIXELS as u16).step_by(usize::from(IRRADIANCE_BLOCK));
        let all: Vec<Place> = addresses.map(Place::Factors).collect();
        for (number, places) in all.chunks(A_CHUNK).enumerate() {
            match read_in_step(line, places).await {
                Ok(found) => stored.extend(found),
                Err(error) if number == 0 && error.kind() == ErrorKind::Timeout => {
                    tracing::warn!(%error, "the instrument gives no irradiance calibration");
                    break;
                }
                Err(error) => return Err(error),
            }
        }
        Ok(Self(stored))
    }

    /// The numbers, if they can be those of such an instrument.
    pub fn checked(&self, line: &Line) -> Result<Checked, DeviceError> {
        let wavelength = slots::WAVELENGTH
            .map(|slot| self.number(line, slot))
            .collect::<Result<Vec<_>, _>>()?;
        let wavelength_nm: Vec<f64> = (0..PIXELS).map(|pixel| polynomial(&wavelength, pixel as f64)).collect();
        wavelengths_can_be(&wavelength_nm)
            .map_err(|reason| line.fault(&format!("EEPROM slots 1 to 4 give {wavelength:?}: {reason}"), &[]))?;

        let order = self.number(line, slots::NONLINEARITY_ORDER)?;
        if order.fract() != 0.0 || !(0.0..=7.0).contains(&order) {
            return Err(line.fault(
                &format!("EEPROM slot 14 gives {order} as the order of a polynomial"),
                &[],
            ));
        }
        let nonlinearity = slots::NONLINEARITY
            .take(order as usize + 1)
            .map(|slot| self.number(line, slot))
            .collect::<Result<Vec<_>, _>>()?;
        linearity_can_be(&nonlinearity, FULL_SCALE)
            .map_err(|reason| line.fault(&format!("EEPROM slots 6 to 13 give {nonlinearity:?}: {reason}"), &[]))?;

        let saturation_counts = self.slot(slots::SATURATION).saturation().unwrap_or(FULL_SCALE);
        if saturation_counts < LEAST_SATURATION {
            let reason =
                format!("EEPROM slot 17 gives saturation at {saturation_counts} counts, below {LEAST_SATURATION}");
            return Err(line.fault(&reason, &self.slot(slots::SATURATION).data));
        }
        let serial = self.slot(slots::SERIAL);
        Ok(Checked {
            serial: serial.text().map(str::to_owned),
            wavelength_nm,
            nonlinearity,
            saturation_counts,
            irradiance_factor: self.factors(line),
        })
    }

    fn slot(&self, slot: u8) -> EepromSlot {
        let stored = self.0.get(&Place::Slot(slot)).map_or(&[][..], Vec::as_slice);
        let mut data = [0; 15];
        data.iter_mut().zip(stored).for_each(|(to, from)| *to = *from);
        EepromSlot { slot, data }
    }

    /// A number of the EEPROM: without it a wavelength or a count would be a guess.
    fn number(&self, line: &Line, slot: u8) -> Result<f64, DeviceError> {
        let stored = self.slot(slot);
        stored
            .number()
            .ok_or_else(|| line.fault(&format!("EEPROM slot {slot} holds no number"), &stored.data))
    }

    /// The irradiance calibration; none when the instrument does not know the command, or stores none that can be one.
    fn factors(&self, line: &Line) -> Option<Vec<f64>> {
        let blocks = self.0.iter().filter(|(place, _)| matches!(place, Place::Factors(_)));
        let bytes: Vec<u8> = blocks.flat_map(|(_, block)| block).copied().take(4 * PIXELS).collect();
        // An erased memory reads as NaN, a blank one as zeros.
        if bytes.iter().all(|byte| *byte == 0xFF) || bytes.iter().all(|byte| *byte == 0) {
            return None;
        }
        let factors: Vec<f64> = bytes
            .chunks_exact(4)
            .map(|word| f64::from(f32::from_be_bytes([word[0], word[1], word[2], word[3]])))
            .collect();
        match factors_can_be(&factors) {
            Ok(()) => Some(factors),
            // An instrument with a calibration of its own in a file can still be used.
            Err(reason) => {
                tracing::warn!(device = line.name, reason, "the stored irradiance factors are not used");
                None
            }
        }
    }
}

/// Reads `places` in a row, again until the answers are known to belong to the requests: nothing came unasked, and the
/// answer after the last is a status, which looks like no other. One old answer would shift all that follow it.
async fn read_in_step(line: &Line, places: &[Place]) -> Result<BTreeMap<Place, Vec<u8>>, DeviceError> {
    for _ in 0..MOST_READINGS {
        let unsolicited = line.unsolicited();
        let mut found = BTreeMap::new();
        for place in places {
            found.insert(*place, read_place(line, *place).await?);
        }
        match line.status_once().await {
            Ok(_) if line.unsolicited() == unsolicited => return Ok(found),
            Err(error) if !matches!(error.kind(), ErrorKind::Timeout | ErrorKind::Malformed) => return Err(error),
            _ => line.status().await.map(|_| ())?,
        }
    }
    Err(line.fault(
        "answers keep coming that nothing had asked for: check the link, then open it again",
        &[],
    ))
}

async fn read_place(line: &Line, place: Place) -> Result<Vec<u8>, DeviceError> {
    let request = match place {
        Place::Slot(slot) => Request::Eeprom(slot),
        Place::Factors(address) => Request::Irradiance(address),
    };
    match line.ask(request).await? {
        Answer::Eeprom(slot) => Ok(slot.data.to_vec()),
        Answer::Irradiance(_, block) => Ok(block),
        _ => Err(line.fault("another answer than what is stored", &[])),
    }
}

/// Two of three equal readings are believed.
fn decide(line: &Line, place: Place, readings: [Vec<u8>; 3]) -> Result<Vec<u8>, DeviceError> {
    tracing::warn!(%place, "two readings differ: a third decides");
    let [first, second, third] = readings;
    if third == first || third == second {
        return Ok(third);
    }
    let reason = format!(
        "{place} was read three times with three answers: \"{}\", \"{}\", \"{}\": check the link, then open it again",
        first.escape_ascii(),
        second.escape_ascii(),
        third.escape_ascii()
    );
    Err(line.fault(&reason, &third))
}

pub(crate) fn polynomial(coefficients: &[f64], at: f64) -> f64 {
    coefficients
        .iter()
        .rev()
        .fold(0.0, |sum, coefficient| sum * at + coefficient)
}

pub(crate) fn wavelengths_can_be(wavelength_nm: &[f64]) -> Result<(), String> {
    let (Some(&first), Some(&last)) = (wavelength_nm.first(), wavelength_nm.last()) else {
        return Err("there are none".to_owned());
    };
    if let Some(pixel) = wavelength_nm
        .windows(2)
        .position(|pair| pair[0] >= pair[1] || pair[1].is_nan())
    {
        return Err(format!("the wavelengths do not rise at pixel {pixel}"));
    }
    if first < SEEN_NM.0 || last > SEEN_NM.1 {
        return Err(format!(
            "{first:.1} nm to {last:.1} nm, outside the {} nm to {} nm that a silicon detector sees",
            SEEN_NM.0, SEEN_NM.1
        ));
    }
    let mean = (last - first) / (wavelength_nm.len() - 1) as f64;
    if last - first < LEAST_SPAN_NM {
        return Err(format!(
            "{first:.1} nm to {last:.1} nm is less than any grating spreads"
        ));
    }
    let odd = |pair: &[f64]| !(mean / STEP_FACTOR..=mean * STEP_FACTOR).contains(&(pair[1] - pair[0]));
    match wavelength_nm.windows(2).position(odd) {
        Some(pixel) => Err(format!(
            "{:.4} nm from pixel {pixel} to the next, {mean:.4} nm on average: no grating does that",
            wavelength_nm[pixel + 1] - wavelength_nm[pixel]
        )),
        None => Ok(()),
    }
}

pub(crate) fn linearity_can_be(coefficients: &[f64], full_scale: u16) -> Result<(), String> {
    for counts in (0..=full_scale).step_by(255) {
        let value = polynomial(coefficients, f64::from(counts));
        if !(LINEARITY.0..=LINEARITY.1).contains(&value) {
            return Err(format!(
                "the correction at {counts} counts would be {value:.4}, not between {} and {}",
                LINEARITY.0, LINEARITY.1
            ));
        }
    }
    Ok(())
}

pub(crate) fn factors_can_be(factors: &[f64]) -> Result<(), String> {
    if let Some(pixel) = factors.iter().position(|factor| !factor.is_finite() || *factor < 0.0) {
        return Err(format!("{} at pixel {pixel}", factors[pixel]));
    }
    let spike = |three: &[f64]| {
        let [left, middle, right] = [three[0], three[1], three[2]];
        let (low, high) = (left.min(right), left.max(right));
        low > 0.0 && high <= 2.0 * low && !(low / SPIKE..=high * SPIKE).contains(&middle)
    };
    match factors.windows(3).position(spike) {
        Some(before) => Err(format!(
            "{:e} at pixel {} between {:e} and {:e}",
            factors[before + 1],
            before + 1,
            factors[before],
            factors[before + 2]
        )),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wavelengths(coefficients: [f64; 4]) -> Result<(), String> {
        let nm: Vec<f64> = (0..PIXELS)
            .map(|pixel| polynomial(&coefficients, pixel as f64))
            .collect();
        wavelengths_can_be(&nm)
    }

    #[test]
    fn wavelengths_of_gratings_pass_and_others_do_not() {
        // 350–1000 nm, a UV-visible bench, a fine grating with 60 nm.
        assert_eq!(wavelengths([339.26, 0.379_4, -1.532e-5, -1.91e-9]), Ok(()));
        assert_eq!(wavelengths([178.3, 0.383, -1.4e-5, -2.2e-9]), Ok(()));
        assert_eq!(wavelengths([430.0, 0.035, -1.0e-6, 0.0]), Ok(()));
        for (coefficients, part) in [
            ([39.26, 0.379_4, -1.532e-5, -1.91e-9], "silicon"),
            ([339.26, 0.479_4, -1.532e-5, -1.91e-9], "silicon"),
            ([339.26, 0.379_4, -1.532e-3, -1.91e-9], "rise"),
            ([339.26, -0.379_4, -1.532e-5, -1.91e-9], "rise"),
            ([339.26, 0.379_4, -1.532e-5, f64::NAN], "rise"),
            ([339.26, 0.000_379_4, 0.0, 0.0], "grating"),
            ([339.26, 0.05, 1.2e-4, 0.0], "no grating"),
        ] {
            let found = wavelengths(coefficients).unwrap_err();
            assert!(found.contains(part), "{coefficients:?}: {found}");
        }
    }

    #[test]
    fn a_polynomial_far_from_one_is_refused() {
        assert_eq!(linearity_can_be(&[1.0], FULL_SCALE), Ok(()));
        assert_eq!(linearity_can_be(&[0.87, 7.6e-6, -1.2e-10, 1.0e-15], FULL_SCALE), Ok(()));
        for damaged in [vec![0.0], vec![8.7e-2], vec![1.0, 7.6e-5], vec![1.0, 0.0, 0.0, -1e-10]] {
            assert!(linearity_can_be(&damaged, FULL_SCALE).is_err(), "{damaged:?}");
        }
    }

    #[test]
    fn factors_are_positive_and_have_no_spike() {
        let smooth: Vec<f64> = (0..200).map(|pixel| 1e-6 * (f64::from(pixel) / 20.0).exp()).collect();
        assert_eq!(factors_can_be(&smooth), Ok(()));
        assert_eq!(
            factors_can_be(&[0.0, 0.0, 5e-5, 1e-6, 1e-6]),
            Ok(()),
            "the edge of the responsivity"
        );
        for damaged in [-1e-6, f64::NAN, f64::INFINITY, 1e3, 1e-20] {
            let mut factors = smooth.clone();
            factors[77] = damaged;
            assert!(
                factors_can_be(&factors).is_err_and(|reason| reason.contains("pixel 77")),
                "{damaged}"
            );
        }
    }
}
