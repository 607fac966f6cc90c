//! Writing a ray file.

use super::header::{DATA, FLAGS, TEXT, TEXTS};
use super::reader::Ray;

/// Rays and what the header says of them.
#[derive(Debug, Clone, PartialEq)]
pub struct RaySet {
    /// The rays. With a wavelength each carries radiant flux alone, as the standard has it (4.7.2.5); without,
    /// luminous.
    pub rays: Vec<Ray>,
    /// Luminous flux of the header, lm.
    pub luminous_flux_lm: Option<f64>,
    /// Radiant flux of the header, W.
    pub radiant_flux_w: Option<f64>,
}

/// The bytes of a ray file; `created` is the ISO 8601 time of the header (give a fixed one where bytes have to repeat).
/// Columns are those that all rays have.
pub fn write(set: &RaySet, created: &str, light_source: &str) -> Vec<u8> {
    let all = |has: fn(&Ray) -> bool| !set.rays.is_empty() && set.rays.iter().all(has);
    let wavelength = all(|ray| ray.wavelength_nm.is_some());
    let radiant = wavelength || all(|ray| ray.radiant_w.is_some());
    let luminous = !radiant;
    let mut out = vec![0_u8; DATA];
    let mut put = |at: usize, bytes: &[u8]| out[at..at + bytes.len()].copy_from_slice(bytes);
    let number = |value: Option<f64>| value.map_or(f32::NAN, |value| value as f32).to_le_bytes();
    put(0, b"TM25");
    put(4, &2013_i32.to_le_bytes());
    // Creation method 0: simulation.
    put(12, &number(set.luminous_flux_lm));
    put(16, &number(set.radiant_flux_w));
    put(20, &(set.rays.len() as u64).to_le_bytes());
    put(28, &created.as_bytes()[..created.len().min(28)]);
    // Start position 7: on the surface of the source. Spectrum 2: a wavelength a ray; 0: none known.
    put(56, &7_i32.to_le_bytes());
    put(60, &if wavelength { 2_i32 } else { 0 }.to_le_bytes());
    put(64, &number(None));
    let range = |pick: fn(f64, f64) -> f64| set.rays.iter().filter_map(|ray| ray.wavelength_nm).reduce(pick);
    put(68, &number(range(f64::min).filter(|_| wavelength)));
    put(72, &number(range(f64::max).filter(|_| wavelength)));
    // Position, direction, radiant flux, wavelength, luminous flux, Stokes, tristimulus, spectrum index.
    for (k, flag) in [true, true, radiant, wavelength, luminous].into_iter().enumerate() {
        put(FLAGS + 4 * k, &i32::from(flag).to_le_bytes());
    }
    for (block, text) in [(0, light_source), (3, "isolux"), (4, "isolux")] {
        for (k, letter) in text.chars().take(TEXT / 4 - 1).enumerate() {
            put(TEXTS + block * TEXT + 4 * k, &(letter as u32).to_le_bytes());
        }
    }
    for ray in &set.rays {
        let (origin, direction) = (ray.origin_mm, ray.direction);
        let mut numbers = vec![origin.x, origin.y, origin.z, direction.x, direction.y, direction.z];
        if radiant {
            numbers.push(ray.radiant_w.unwrap_or(0.0));
        }
        if wavelength {
            numbers.extend(ray.wavelength_nm);
        }
        if luminous {
            numbers.push(ray.luminous_lm.unwrap_or(0.0));
        }
        for number in numbers {
            out.extend_from_slice(&(number as f32).to_le_bytes());
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::super::{Reader, Spectral, Survey, Tm25Error};
    use super::*;

    fn set(wavelength_nm: Option<f64>) -> RaySet {
        let flux = 0.25;
        let ray = |x: f64| Ray {
            origin_mm: DVec3::new(x, 0.5, 0.0),
            direction: DVec3::new(0.6, 0.0, 0.8),
            radiant_w: wavelength_nm.map(|_| flux),
            luminous_lm: if wavelength_nm.is_none() { Some(flux) } else { None },
            wavelength_nm,
        };
        RaySet {
            rays: vec![ray(0.0), ray(-0.25)],
            luminous_flux_lm: Some(0.5),
            radiant_flux_w: None,
        }
    }

    fn bytes(wavelength_nm: Option<f64>) -> Vec<u8> {
        write(&set(wavelength_nm), "2013-09-04T08:30:29+01:00", "ring")
    }

    fn read(bytes: &[u8]) -> Result<Reader<&[u8]>, Tm25Error> {
        Reader::new(bytes, bytes.len() as u64)
    }

    #[test]
    fn what_is_written_is_read() {
        for wavelength in [None, Some(455.0)] {
            let bytes = bytes(wavelength);
            assert_eq!(bytes.len(), 36_288 + 2 * 4 * (7 + usize::from(wavelength.is_some())));
            let mut reader = read(&bytes).unwrap();
            let header = reader.header().clone();
            assert_eq!(header.doubts(), []);
            assert_eq!((header.luminous_flux_lm, header.radiant_flux_w), (Some(0.5), None));
            assert_eq!((header.texts[0].as_str(), header.texts[4].as_str()), ("ring", "isolux"));
            assert_eq!(
                header.spectral,
                if wavelength.is_some() {
                    Spectral::PerRay
                } else {
                    Spectral::None
                }
            );
            for wanted in set(wavelength).rays {
                let found = reader.next_ray().unwrap().unwrap();
                // float32 on disk.
                assert!((found.direction - wanted.direction).length() < 1e-7);
                assert_eq!(
                    Ray {
                        direction: wanted.direction,
                        ..found
                    },
                    wanted
                );
            }
            assert_eq!(reader.next_ray().unwrap(), None);
        }
    }

    #[test]
    fn a_survey_is_the_rays_sums() {
        let bytes = bytes(Some(455.0));
        let survey = Survey::of(&mut read(&bytes).unwrap()).unwrap();
        assert_eq!(
            (survey.rays, survey.radiant_w, survey.luminous_lm),
            (2, Some(0.5), None)
        );
        assert_eq!(
            survey.bounds_mm,
            Some([DVec3::new(-0.25, 0.5, 0.0), DVec3::new(0.0, 0.5, 0.0)])
        );
        assert_eq!(survey.centroid_mm, Some(DVec3::new(-0.125, 0.5, 0.0)));
        assert_eq!(survey.wavelength_nm, Some([455.0; 2]));
        // acos 0.8 = 36.87°.
        assert!((survey.zones[3] - 1.0).abs() < 1e-12);
        assert!((survey.half_flux_gamma_deg.unwrap() - 36.85).abs() < 0.06);
        let mut damaged = bytes;
        damaged.splice(36_288 + 12..36_288 + 24, [0; 12]);
        damaged.splice(36_288 + 32 + 24..36_288 + 32 + 28, (-1.0_f32).to_le_bytes());
        let survey = Survey::of(&mut read(&damaged).unwrap()).unwrap();
        assert_eq!((survey.no_direction.rays, survey.no_direction.first), (1, 0));
        assert_eq!((survey.negative.rays, survey.negative.first), (1, 1));
        assert_eq!(survey.centroid_mm, None);
    }

    #[test]
    fn damage_is_named_with_its_bytes() {
        let good = bytes(None);
        let fails = |change: &dyn Fn(&mut Vec<u8>)| {
            let mut bytes = good.clone();
            change(&mut bytes);
            let error = read(&bytes).err().expect("refused");
            (error.code(), error.span().unwrap())
        };
        let end = good.len() as u64;
        assert_eq!(
            fails(&|b| b.truncate(end as usize - 1)),
            ("tm25-length", [end - 1, end])
        );
        assert_eq!(fails(&|b| b.truncate(300)), ("tm25-truncated", [300, 36_288]));
        assert_eq!(fails(&|b| b[3] = b'4'), ("tm25-magic", [0, 4]));
        assert_eq!(fails(&|b| b.clear()), ("tm25-magic", [0, 0]));
        assert_eq!(fails(&|b| b[4] = 0), ("tm25-version", [4, 8]));
        assert_eq!(fails(&|b| b[256] = 7), ("tm25-field", [256, 260]));
        assert_eq!(fails(&|b| b[256 + 16] = 0), ("tm25-field", [264, 268]));
        assert_eq!(fails(&|b| b[60] = 9), ("tm25-field", [60, 64]));
        assert_eq!(fails(&|b| b[79] = 0xff), ("tm25-field", [76, 80]));
        // A count of spectra that the file does not hold reads the rays as one: it does not fit whatever it makes of
        // them.
        assert!(matches!(fails(&|b| b[76] = 1).0, "tm25-field" | "tm25-truncated"));
        assert_eq!(fails(&|b| b[27] = 0xff).0, "tm25-length");
        // What can be read but is against the standard.
        let mut odd = good;
        odd[8] = 9;
        odd[256 + 28] = 1;
        odd.extend([0; 8]);
        let reader = read(&odd).unwrap();
        let spans: Vec<[u64; 2]> = reader.header().doubts().iter().map(|doubt| doubt.span).collect();
        assert_eq!(spans, [[8, 12], [284, 288]]);
    }
}
