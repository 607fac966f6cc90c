//! `spectra/NNN.csv`: raw counts beside the irradiance made from them.

mod calibration;
mod corrections;
mod error;

use camino::Utf8Path;
use serde::{Deserialize, Serialize};

pub use self::calibration::{corrected_by, parse_calibration};
pub use self::corrections::{
    LINEARITY_FORMAT, LineFound, Linearity, Made, SCATTER_FORMAT, Scatter, SpectralCorrections, WAVELENGTHS_FORMAT,
    WavelengthScale,
};
pub use self::error::SpectrumError;
use crate::reading::ReadingKind;
use crate::row_crc;
use crate::table::{Fields, ObservationError, Problem, Table};

/// What turns the counts of a spectroradiometer into irradiance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpectralCalibration {
    /// Name of the calibration file.
    pub file: String,
    /// SHA-256 of its bytes.
    pub sha256: String,
    /// Raw counts at which a pixel saturates.
    pub saturation_counts: f64,
    /// Counts at which it saturates after scaling.
    pub full_scale_counts: f64,
    /// Non-linearity polynomial of the dark-subtracted scaled counts, lowest power first; the counts are divided by it.
    pub nonlinearity: Vec<f64>,
    /// First and one past the last pixel that no light reaches.
    pub dark_pixels: [usize; 2],
    /// What the laboratory has found of the instrument itself. The irradiance in the files of a run is without it.
    #[serde(default, skip_serializing_if = "SpectralCorrections::is_empty")]
    pub corrections: SpectralCorrections,
    /// By which of them the standard was corrected that the factors were found with, as the table of factors says; none
    /// where it says nothing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub factors_corrected_by: Option<String>,
}

/// One spectrum: the mean of `averages` raw ones, and the mean of as many dark ones with the same integration time.
#[derive(Debug, Clone, PartialEq)]
pub struct SpectrumRecord {
    /// Number in the run, from 0; names the file.
    pub index: u64,
    /// Name of the plan's block.
    pub block: String,
    /// Number of the point in the plan.
    pub point: u64,
    /// What the instrument could see.
    pub kind: ReadingKind,
    /// Middle of the integrations in seconds since the run began.
    pub time_s: Option<f64>,
    /// The same since the lamp was switched on.
    pub lamp_s: Option<f64>,
    /// Read-back C in degrees.
    pub c_deg: f64,
    /// Read-back γ in degrees.
    pub gamma_deg: f64,
    /// Distance of the instrument's reference plane from the intersection of the axes.
    pub distance_mm: f64,
    /// Integration time of each spectrum.
    pub integration_s: f64,
    /// Spectra averaged.
    pub averages: u32,
    /// Temperature of the detector in °C, where it is measured.
    pub detector_c: Option<f64>,
    /// Temperature of the room in °C, where it is measured.
    pub ambient_c: Option<f64>,
    /// One entry a pixel.
    pub pixels: Vec<Pixel>,
}

/// One pixel of a spectrum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pixel {
    /// Wavelength.
    pub wavelength_nm: f64,
    /// Mean raw counts.
    pub counts: f64,
    /// Standard uncertainty of that mean from the scatter of the averages.
    pub u_counts: f64,
    /// Mean raw counts of the dark.
    pub dark_counts: f64,
    /// Standard uncertainty of that mean.
    pub u_dark_counts: f64,
    /// Whether any of the averaged spectra was saturated here: then there is no irradiance.
    pub saturated: bool,
    /// Spectral irradiance of one linear count per second, W/m²/nm.
    pub factor_w_m2_nm: f64,
}

/// Spectral irradiance of a spectrum, one entry a pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct SpectralIrradiance {
    /// W/m²/nm; none where saturated.
    pub irradiance_w_m2_nm: Vec<Option<f64>>,
    /// Its standard uncertainty from the scatter of light and dark.
    pub u_w_m2_nm: Vec<f64>,
}

/// What dark is subtracted when counts become irradiance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DarkSubtraction {
    /// The dark spectrum of the same integration time.
    Spectrum,
    /// Nothing: the correction is switched off.
    Off,
}

impl SpectrumRecord {
    /// Irradiance of every pixel: scale to full scale, subtract dark, divide by the non-linearity polynomial, divide by
    /// the integration time, multiply by the calibration factor (the order of the manufacturer's software).
    ///
    /// # Errors
    /// [`SpectrumError::Polynomial`] when the polynomial is not above zero at a pixel.
    pub fn irradiance(
        &self,
        calibration: &SpectralCalibration,
        dark: DarkSubtraction,
    ) -> Result<SpectralIrradiance, SpectrumError> {
        let scale = calibration.full_scale_counts / calibration.saturation_counts;
        let mut result = SpectralIrradiance {
            irradiance_w_m2_nm: Vec::new(),
            u_w_m2_nm: Vec::new(),
        };
        for pixel in &self.pixels {
            let (dark_counts, u_dark) = match dark {
                DarkSubtraction::Spectrum => (pixel.dark_counts, pixel.u_dark_counts),
                DarkSubtraction::Off => (0.0, 0.0),
            };
            let net = (pixel.counts - dark_counts) * scale;
            let polynomial = if calibration.nonlinearity.is_empty() {
                1.0
            } else {
                calibration
                    .nonlinearity
                    .iter()
                    .rev()
                    .fold(0.0, |sum, coefficient| sum * net + coefficient)
            };
            if !(polynomial.is_finite() && polynomial > 0.0) {
                return Err(SpectrumError::Polynomial {
                    wavelength_nm: pixel.wavelength_nm,
                    value: polynomial,
                });
            }
            let per_count = pixel.factor_w_m2_nm / (polynomial * self.integration_s);
            result
                .irradiance_w_m2_nm
                .push((!pixel.saturated).then_some(net * per_count));
            result
                .u_w_m2_nm
                .push((pixel.u_counts.hypot(u_dark) * scale * per_count).abs());
        }
        Ok(result)
    }

    /// The file's bytes; the irradiance is written beside the counts it was made from.
    ///
    /// # Errors
    /// As [`irradiance`](Self::irradiance).
    pub fn to_csv(&self, calibration: &SpectralCalibration) -> Result<String, SpectrumError> {
        let irradiance = self.irradiance(calibration, DarkSubtraction::Spectrum)?;
        let optional = |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
        let common = format!(
            "{},{},{},{},{},{},{},{},{},{},{},{},{}",
            self.integration_s,
            self.averages,
            optional(self.detector_c),
            optional(self.ambient_c),
            self.block,
            self.point,
            self.kind,
            optional(self.time_s),
            self.c_deg + 0.0,
            self.gamma_deg + 0.0,
            self.distance_mm,
            self.index,
            optional(self.lamp_s),
        );
        let mut text = format!("{HEADER}{LAMP}{CHECKED}\n");
        for (place, pixel) in self.pixels.iter().enumerate() {
            let row = format!(
                "{},{},{},{},{},{},{},{},{},{common},{},",
                pixel.wavelength_nm,
                pixel.counts,
                pixel.u_counts,
                pixel.dark_counts,
                pixel.u_dark_counts,
                u8::from(pixel.saturated),
                pixel.factor_w_m2_nm,
                optional(irradiance.irradiance_w_m2_nm[place]),
                irradiance.u_w_m2_nm[place],
                self.pixels.len(),
            );
            text += &format!("{row}{}\n", row_crc::of(row.as_bytes()));
        }
        Ok(text)
    }

    /// Parses a file of `spectra/`. One of a run of format 3 has no time but that of the lamp.
    ///
    /// # Errors
    /// [`ObservationError`] with line and column.
    pub fn parse(file: &Utf8Path, text: &str) -> Result<Self, ObservationError> {
        let wrong = |line, what: String| ObservationError::new(file, Some(line), Problem::Record(what));
        let header = text.lines().next().unwrap_or_default();
        let has_lamp = header == format!("{HEADER}{LAMP}{CHECKED}");
        if !has_lamp && header != format!("{HEADER}{CHECKED}") {
            return Err(wrong(1, "not the header of a run's spectrum".to_owned()));
        }
        let table = Table::parse(file, text, false)?;
        let columns = table.columns();
        let mut record: Option<Self> = None;
        let mut stated = 0.0;
        for fields in table.rows(file, &columns) {
            fields.checked()?;
            stated = fields.number("pixels")?;
            let pixel = Pixel {
                wavelength_nm: fields.number("wavelength_nm")?,
                counts: fields.number("counts")?,
                u_counts: fields.number("u_counts")?,
                dark_counts: fields.number("dark_counts")?,
                u_dark_counts: fields.number("u_dark_counts")?,
                saturated: fields.text("saturated") == "1",
                factor_w_m2_nm: fields.number("factor_w_m2_nm")?,
            };
            let record = match &mut record {
                Some(record) => record,
                none => none.insert(Self::common(&fields, has_lamp)?),
            };
            if let Some(last) = record.pixels.last() {
                fields.above("wavelength_nm", last.wavelength_nm)?;
            }
            record.pixels.push(pixel);
        }
        let record = record.ok_or_else(|| wrong(1, "the file holds no pixel".to_owned()))?;
        let found = record.pixels.len();
        if stated == found as f64 {
            return Ok(record);
        }
        let message = format!("the file holds {found} pixels of {stated}");
        Err(wrong(found as u64 + 1, message))
    }

    /// What every row of a file says, without its pixel.
    fn common(fields: &Fields<'_>, has_lamp: bool) -> Result<Self, ObservationError> {
        // Without a time of the lamp beside it, the time is that of the lamp.
        let (time_s, lamp_s) = match (has_lamp, fields.optional("time_s")?) {
            (true, time_s) => (time_s, fields.optional("lamp_s")?),
            (false, lamp_s) => (None, lamp_s),
        };
        Ok(Self {
            integration_s: fields.number("integration_s")?,
            averages: fields.number("averages")? as u32,
            detector_c: fields.optional("detector_c")?,
            ambient_c: fields.optional("ambient_c")?,
            block: fields.text("block").to_owned(),
            point: fields.number("point")? as u64,
            kind: fields.word("kind")?,
            time_s,
            lamp_s,
            c_deg: fields.number("c_deg")?,
            gamma_deg: fields.number("gamma_deg")?,
            distance_mm: fields.number("distance_mm")?,
            index: fields.number("index")? as u64,
            pixels: Vec::new(),
        })
    }
}

const HEADER: &str = "wavelength_nm,counts,u_counts,dark_counts,u_dark_counts,saturated,factor_w_m2_nm,irradiance_w_m2_nm,\
u_w_m2_nm,integration_s,averages,detector_c,ambient_c,block,point,kind,time_s,c_deg,gamma_deg,distance_mm,index";

/// The column from format 4 on.
const LAMP: &str = ",lamp_s";

/// The last columns: how many pixels the file has, and CRC-32 of the row up to its last comma.
const CHECKED: &str = ",pixels,row_crc";

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    pub(crate) fn calibration() -> SpectralCalibration {
        SpectralCalibration {
            file: "cal.csv".to_owned(),
            sha256: "00".to_owned(),
            saturation_counts: 32_768.0,
            full_scale_counts: 65_535.0,
            nonlinearity: vec![1.0, -1e-6],
            dark_pixels: [0, 1],
            corrections: SpectralCorrections::default(),
            factors_corrected_by: None,
        }
    }

    pub(crate) fn spectrum() -> SpectrumRecord {
        let pixel = |wavelength_nm, counts, saturated| Pixel {
            wavelength_nm,
            counts,
            u_counts: 3.0,
            dark_counts: 1000.0,
            u_dark_counts: 4.0,
            saturated,
            factor_w_m2_nm: 2e-6,
        };
        SpectrumRecord {
            index: 0,
            block: "spectrum".to_owned(),
            point: 12,
            kind: ReadingKind::Lit,
            time_s: Some(2012.5),
            lamp_s: Some(2000.5),
            c_deg: 0.0,
            gamma_deg: 0.0,
            distance_mm: 500.0,
            integration_s: 0.1,
            averages: 5,
            detector_c: None,
            ambient_c: Some(25.0),
            pixels: vec![
                pixel(450.0, 10_000.0, false),
                pixel(550.0, 900.5, false),
                pixel(650.0, 32_768.0, true),
            ],
        }
    }

    #[test]
    fn counts_become_irradiance_and_survive_the_file() {
        let text = spectrum().to_csv(&calibration()).unwrap();
        let again = SpectrumRecord::parse(Utf8Path::new("000.csv"), &text).unwrap();
        assert_eq!(again, spectrum());
        let light = again.irradiance(&calibration(), DarkSubtraction::Spectrum).unwrap();
        let net = 9000.0 * 65_535.0 / 32_768.0;
        let expected = net / (1.0 - 1e-6 * net) / 0.1 * 2e-6;
        assert!((light.irradiance_w_m2_nm[0].unwrap() - expected).abs() < 1e-12 * expected);
        assert!((light.u_w_m2_nm[0] / expected - 5.0 / 9000.0).abs() < 1e-9);
        assert!(
            light.irradiance_w_m2_nm[1].unwrap() < 0.0,
            "noise below the dark stays negative"
        );
        assert_eq!(light.irradiance_w_m2_nm[2], None, "a saturated pixel has no number");
        let broken = text.replacen("450,", "nan,", 1);
        let error = SpectrumRecord::parse(Utf8Path::new("0.csv"), &broken).unwrap_err();
        assert_eq!(error.line, Some(2));
    }

    #[test]
    fn a_spectrum_that_was_cut_or_changed_is_refused() {
        let parse = |text: &str| SpectrumRecord::parse(Utf8Path::new("0.csv"), text);
        let text = spectrum().to_csv(&calibration()).unwrap();
        let lines: Vec<&str> = text.split_inclusive('\n').collect();
        for kept in 2..lines.len() {
            let error = parse(&lines[..kept].concat()).unwrap_err().to_string();
            assert!(error.contains(&format!("{} pixels of 3", kept - 1)), "{error}");
        }
        assert!(parse(&text.replacen("10000,", "10001,", 1)).is_err());
        // Without a column of its own the time is that of the lamp, as in format 3; without checksums nothing is read.
        let old = |row: &str| {
            let before = row.rsplitn(4, ',').last().unwrap().replace(",2012.5,", ",2000.5,");
            let row = format!("{before},3,");
            format!("{row}{:08x}\n", crc32fast::hash(row.as_bytes()))
        };
        let rows: String = text.lines().skip(1).map(old).collect();
        let without = SpectrumRecord {
            time_s: None,
            ..spectrum()
        };
        assert_eq!(parse(&format!("{HEADER}{CHECKED}\n{rows}")).unwrap(), without);
        assert!(parse(&format!("{HEADER}\n{rows}")).is_err());
    }

    #[test]
    fn a_calibration_is_checked_line_by_line() {
        let parse = |text| parse_calibration(Utf8Path::new("c.csv"), text);
        assert_eq!(
            parse("# made 2026\nwavelength_nm,factor\n350,1e-6\n850,2e-6\n").unwrap()[1],
            (850.0, 2e-6)
        );
        let of_a_spreadsheet = "\u{feff}\"factor\",\"wavelength_nm\"\r\n1e-6, 350\r\n\"2e-6\",850\r\n";
        assert_eq!(parse(of_a_spreadsheet).unwrap(), [(350.0, 1e-6), (850.0, 2e-6)]);
        for (text, line, said) in [
            ("nm,f\n", Some(1), "column `wavelength_nm` is missing"),
            (
                "wavelength_nm,factor\n350,1\n340,1\n",
                Some(3),
                "above that of the row before",
            ),
            (
                "wavelength_nm,factor\n350,NaN\n",
                Some(2),
                "`factor` = `NaN` is no finite number",
            ),
            ("wavelength_nm,factor\n350,1\n", None, "holds no two wavelengths"),
            ("wavelength_nm,factor\n350,0\n450,0\n", None, "`factor` = 0"),
        ] {
            let error = parse(text).unwrap_err();
            assert!(error.line == line && error.to_string().contains(said), "{error}");
        }
    }
}
