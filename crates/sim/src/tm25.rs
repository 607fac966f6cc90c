//! Ray files of IES TM-25-13: 36 288 bytes of header, then little-endian float32 rays.

use glam::DVec3;

/// One ray of a file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FileRay {
    /// Where it leaves, mm.
    pub origin_mm: DVec3,
    /// Unit direction.
    pub direction: DVec3,
    /// Its flux: lm where the file says luminous, W where radiant.
    pub flux: f64,
    /// Wavelength, where the file gives one a ray.
    pub wavelength_nm: Option<f64>,
}

/// Rays and what the header says of them.
#[derive(Debug, Clone, PartialEq)]
pub struct RaySet {
    /// The rays.
    pub rays: Vec<FileRay>,
    /// Luminous flux of the header, lm.
    pub luminous_flux_lm: Option<f64>,
    /// Radiant flux of the header, W.
    pub radiant_flux_w: Option<f64>,
    /// Whether [`FileRay::flux`] is luminous.
    pub luminous: bool,
}

/// Why bytes are no TM-25 ray file.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Tm25Error {
    /// The first four bytes.
    #[error("byte 0: `TM25` expected, found {found:?}: this is no TM-25 ray file")]
    Magic {
        /// What stands there.
        found: Vec<u8>,
    },
    /// A version that this reader does not know.
    #[error("byte 4: version {version}: only 2013 is known")]
    Version {
        /// What stands there.
        version: i32,
    },
    /// The file ends early or is longer than its header says.
    #[error("the file has {found} bytes, its header asks for {expected}")]
    Length {
        /// Bytes by the header.
        expected: u64,
        /// Bytes that there are.
        found: u64,
    },
    /// A flag or count outside what the standard allows.
    #[error("byte {offset}: {name} = {value} is not allowed")]
    Field {
        /// Where.
        offset: usize,
        /// Which.
        name: &'static str,
        /// What stands there.
        value: i64,
    },
}

const FLAGS: usize = 256;
const TEXTS: usize = 288;
const TEXT: usize = 4000;
const DATA: usize = TEXTS + 9 * TEXT;

/// The bytes of a ray file with `rays`; `created` is the ISO 8601 time of the header (TM-25 wants one: give a fixed one
/// where bytes have to repeat).
pub fn write(set: &RaySet, created: &str, light_source: &str) -> Vec<u8> {
    let with_wavelength = !set.rays.is_empty() && set.rays.iter().all(|ray| ray.wavelength_nm.is_some());
    let mut out = vec![0_u8; DATA];
    let mut put = |at: usize, bytes: &[u8]| out[at..at + bytes.len()].copy_from_slice(bytes);
    put(0, b"TM25");
    put(4, &2013_i32.to_le_bytes());
    // Creation method 0: simulation.
    let flux = |value: Option<f64>| value.map_or(f32::NAN, |value| value as f32).to_le_bytes();
    put(12, &flux(set.luminous_flux_lm));
    put(16, &flux(set.radiant_flux_w));
    put(20, &(set.rays.len() as u64).to_le_bytes());
    let time = &created.as_bytes()[..created.len().min(28)];
    put(28, time);
    // Start position 7: on the surface of the source. Spectrum 2: a wavelength a ray; 0: none known.
    put(56, &7_i32.to_le_bytes());
    put(60, &if with_wavelength { 2_i32 } else { 0 }.to_le_bytes());
    for at in [64, 68, 72] {
        put(at, &f32::NAN.to_le_bytes());
    }
    // Position, direction, radiant flux, wavelength, luminous flux, Stokes, tristimulus, spectrum index.
    let flags = [
        1,
        1,
        i32::from(!set.luminous),
        i32::from(with_wavelength),
        i32::from(set.luminous),
        0,
        0,
        0,
    ];
    for (k, flag) in flags.iter().enumerate() {
        put(FLAGS + 4 * k, &flag.to_le_bytes());
    }
    for (block, text) in [(0, "isolux"), (3, "isolux"), (6, light_source)] {
        for (k, letter) in text.chars().take(TEXT / 4 - 1).enumerate() {
            put(TEXTS + block * TEXT + 4 * k, &(letter as u32).to_le_bytes());
        }
    }
    for ray in &set.rays {
        let mut numbers = vec![
            ray.origin_mm.x,
            ray.origin_mm.y,
            ray.origin_mm.z,
            ray.direction.x,
            ray.direction.y,
            ray.direction.z,
        ];
        // The order of TM-25: radiant flux, wavelength, luminous flux.
        if !set.luminous {
            numbers.push(ray.flux);
        }
        if with_wavelength {
            numbers.extend(ray.wavelength_nm);
        }
        if set.luminous {
            numbers.push(ray.flux);
        }
        for number in numbers {
            out.extend_from_slice(&(number as f32).to_le_bytes());
        }
    }
    out
}

/// Reads a ray file.
///
/// # Errors
/// [`Tm25Error`] with the byte that is wrong.
pub fn read(bytes: &[u8]) -> Result<RaySet, Tm25Error> {
    if bytes.get(..4) != Some(b"TM25") {
        return Err(Tm25Error::Magic {
            found: bytes[..bytes.len().min(4)].to_vec(),
        });
    }
    let short = |expected: usize| Tm25Error::Length {
        expected: expected as u64,
        found: bytes.len() as u64,
    };
    if bytes.len() < DATA {
        return Err(short(DATA));
    }
    let word = |at: usize| -> [u8; 4] { std::array::from_fn(|k| bytes[at + k]) };
    let int = |at: usize| i32::from_le_bytes(word(at));
    let float = |at: usize| f64::from(f32::from_le_bytes(word(at)));
    if int(4) != 2013 {
        return Err(Tm25Error::Version { version: int(4) });
    }
    let count = u64::from_le_bytes(std::array::from_fn(|k| bytes[20 + k]));
    let size = |at: usize, name: &'static str| {
        usize::try_from(int(at)).map_err(|_| Tm25Error::Field {
            offset: at,
            name,
            value: i64::from(int(at)),
        })
    };
    let (spectra, extra, text) = (
        size(76, "number of spectra")?,
        size(80, "number of additional columns")?,
        size(84, "size of additional text")?,
    );
    let mut flags = [false; 8];
    for (k, flag) in flags.iter_mut().enumerate() {
        let at = FLAGS + 4 * k;
        *flag = match int(at) {
            0 => false,
            1 => true,
            value => {
                return Err(Tm25Error::Field {
                    offset: at,
                    name: "column flag",
                    value: i64::from(value),
                });
            }
        };
    }
    let [
        position,
        direction,
        radiant,
        wavelength,
        luminous,
        stokes,
        tristimulus,
        spectrum,
    ] = flags;
    if !position || !direction || !(radiant || luminous) {
        return Err(Tm25Error::Field {
            offset: FLAGS,
            name: "position, direction and a flux are needed; flag",
            value: 0,
        });
    }
    // Spectral tables, padded to 32 bytes together; names of 512 bytes; text.
    let mut at = DATA;
    for _ in 0..spectra {
        if at + 4 > bytes.len() {
            return Err(short(at + 4));
        }
        let points = size(at, "points of a spectrum")?;
        at = at.saturating_add(4).saturating_add(points.saturating_mul(8));
    }
    let data = (at - DATA).next_multiple_of(32) + DATA + extra.saturating_mul(512) + text;
    let columns = 6
        + usize::from(radiant)
        + usize::from(wavelength)
        + usize::from(luminous)
        + 6 * usize::from(stokes)
        + 2 * usize::from(tristimulus)
        + usize::from(spectrum)
        + extra;
    let expected = (data as u64).saturating_add(count.saturating_mul(4 * columns as u64));
    if expected != bytes.len() as u64 {
        return Err(Tm25Error::Length {
            expected,
            found: bytes.len() as u64,
        });
    }
    let rays = (0..count as usize)
        .map(|index| {
            let at = |column: usize| float(data + 4 * (index * columns + column));
            let mut next = 6;
            let mut take = |present: bool| {
                next += usize::from(present);
                present.then(|| at(next - 1))
            };
            let (power, nm, light) = (take(radiant), take(wavelength), take(luminous));
            FileRay {
                origin_mm: DVec3::new(at(0), at(1), at(2)),
                direction: DVec3::new(at(3), at(4), at(5)),
                flux: light.or(power).unwrap_or(0.0),
                wavelength_nm: nm,
            }
        })
        .collect();
    let known = |at: usize| Some(float(at)).filter(|value| value.is_finite());
    Ok(RaySet {
        rays,
        luminous_flux_lm: known(12),
        radiant_flux_w: known(16),
        luminous,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn set(wavelength: Option<f64>) -> RaySet {
        let ray = |x: f64| FileRay {
            origin_mm: DVec3::new(x, 0.5, 0.0),
            direction: DVec3::new(0.0, 0.0, 1.0),
            flux: 0.25,
            wavelength_nm: wavelength,
        };
        RaySet {
            rays: vec![ray(0.0), ray(-0.25)],
            luminous_flux_lm: Some(0.5),
            radiant_flux_w: None,
            luminous: true,
        }
    }

    #[test]
    fn what_is_written_is_read() {
        for wavelength in [None, Some(455.0)] {
            let bytes = write(&set(wavelength), "2013-09-04T08:30:29+01:00", "ring");
            assert_eq!(bytes.len(), 36_288 + 2 * 4 * (7 + usize::from(wavelength.is_some())));
            assert_eq!(read(&bytes).unwrap(), set(wavelength));
        }
    }

    #[test]
    fn damage_is_named_with_its_place() {
        let bytes = write(&set(None), "2013-09-04T08:30:29+01:00", "ring");
        assert!(matches!(read(&bytes[..bytes.len() - 1]), Err(Tm25Error::Length { .. })));
        assert!(matches!(read(b"TM24"), Err(Tm25Error::Magic { .. })));
        assert!(matches!(read(b""), Err(Tm25Error::Magic { .. })));
        let mut version = bytes.clone();
        version[4] = 0;
        assert!(matches!(read(&version), Err(Tm25Error::Version { .. })));
        let mut flag = bytes.clone();
        flag[256] = 7;
        assert_eq!(
            read(&flag),
            Err(Tm25Error::Field {
                offset: 256,
                name: "column flag",
                value: 7
            })
        );
        let mut count = bytes;
        count[27] = 0xff;
        assert!(matches!(read(&count), Err(Tm25Error::Length { .. })));
    }
}
