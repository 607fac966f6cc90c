//! The rays of a file, one after the other.

use std::io::Read;

use glam::DVec3;

use super::error::Tm25Error;
use super::header::Header;

/// One ray as the file has it; what is no number stays none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Where it starts, mm.
    pub origin_mm: DVec3,
    /// Direction, of unit length in a good file.
    pub direction: DVec3,
    /// Radiant flux, W, where the file has the column.
    pub radiant_w: Option<f64>,
    /// Luminous flux, lm, where the file has the column.
    pub luminous_lm: Option<f64>,
    /// Wavelength, nm, where the file has the column.
    pub wavelength_nm: Option<f64>,
}

impl Ray {
    /// Luminous flux where the file has it, else radiant.
    pub fn flux(&self) -> f64 {
        self.luminous_lm.or(self.radiant_w).unwrap_or(0.0)
    }

    /// Whether place, direction and flux are numbers, the direction is none of length zero, and the flux is not
    /// negative.
    pub fn is_sound(&self) -> bool {
        self.origin_mm.is_finite()
            && self.direction.is_finite()
            && self.direction != DVec3::ZERO
            && self.flux().is_finite()
            && self.flux() >= 0.0
    }
}

/// Rays are read by this many.
const BLOCK: usize = 4096;

/// A ray file that is being read.
pub struct Reader<R> {
    header: Header,
    from: R,
    block: Vec<u8>,
    at: usize,
    left: u64,
}

impl<R: Read> Reader<R> {
    /// Reads the header. `length` is the file's size in bytes.
    ///
    /// # Errors
    /// [`Tm25Error`] with the bytes that are wrong; [`Tm25Error::Length`] where size and header contradict each other.
    pub fn new(mut from: R, length: u64) -> Result<Self, Tm25Error> {
        let header = Header::read(&mut from)?;
        let expected = header.end();
        if expected != length {
            return Err(Tm25Error::Length {
                rays: header.rays,
                columns: header.columns.count(),
                expected,
                found: length,
            });
        }
        Ok(Self::over(header, from))
    }

    /// The whole rays that are there, whatever the header announces; for looking at a damaged file. `from` stands at
    /// the first ray.
    pub fn over(header: Header, from: R) -> Self {
        Self {
            left: header.rays,
            header,
            from,
            block: Vec::new(),
            at: 0,
        }
    }

    /// What stands before the rays.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// The next ray; `None` after the last one.
    ///
    /// # Errors
    /// [`Tm25Error::Io`].
    pub fn next_ray(&mut self) -> Result<Option<Ray>, Tm25Error> {
        let size = 4 * self.header.columns.count();
        if self.at + size > self.block.len() {
            if self.left == 0 {
                return Ok(None);
            }
            let wanted = self.left.min(BLOCK as u64);
            self.block.clear();
            self.at = 0;
            (&mut self.from)
                .take(wanted * size as u64)
                .read_to_end(&mut self.block)?;
            self.left -= wanted;
            if self.block.len() < size {
                self.left = 0;
                return Ok(None);
            }
        }
        let bytes = &self.block[self.at..self.at + size];
        self.at += size;
        let number = |k: usize| {
            let at = 4 * k;
            f64::from(f32::from_le_bytes([
                bytes[at],
                bytes[at + 1],
                bytes[at + 2],
                bytes[at + 3],
            ]))
        };
        let [radiant_w, wavelength_nm, luminous_lm] = self.header.columns.places().map(|place| place.map(number));
        Ok(Some(Ray {
            origin_mm: DVec3::new(number(0), number(1), number(2)),
            direction: DVec3::new(number(3), number(4), number(5)),
            radiant_w,
            luminous_lm,
            wavelength_nm,
        }))
    }
}
