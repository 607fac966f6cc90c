//! The header of a ray file, tables and texts included.

use std::io::Read;

use super::error::Tm25Error;

pub(super) const FLAGS: usize = 256;
pub(super) const TEXTS: usize = 288;
pub(super) const TEXT: usize = 4000;
pub(super) const DATA: usize = TEXTS + 9 * TEXT;

/// Most that tables and texts beside the rays may take: a spectrum of a million points fits, a damaged count does not.
const LARGEST: u64 = 16 * 1024 * 1024;

/// What a file says of its rays' wavelengths (4.7.1.9).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Spectral {
    /// Nothing.
    None,
    /// All have this one, nm.
    Single(f64),
    /// Each has its own.
    PerRay,
    /// One spectrum for all.
    Table,
    /// Each names one of several spectra.
    Tables,
}

impl Spectral {
    /// A word for it.
    pub fn word(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Single(_) => "single wavelength",
            Self::PerRay => "wavelength per ray",
            Self::Table => "spectrum",
            Self::Tables => "spectra by index",
        }
    }
}

/// Which numbers a ray has, beside three of its place and three of its direction, in this order (4.7.2).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[expect(clippy::struct_excessive_bools, reason = "the file's own flags")]
pub struct Columns {
    /// Radiant flux, W.
    pub radiant: bool,
    /// Wavelength, nm.
    pub wavelength: bool,
    /// Luminous flux, lm.
    pub luminous: bool,
    /// Six numbers of polarisation.
    pub stokes: bool,
    /// Tristimulus X and Z.
    pub tristimulus: bool,
    /// Index of a spectrum, from 1.
    pub spectrum: bool,
    /// Columns with names of their own.
    pub additional: usize,
}

impl Columns {
    /// Numbers a ray.
    pub fn count(&self) -> usize {
        6 + usize::from(self.radiant)
            + usize::from(self.wavelength)
            + usize::from(self.luminous)
            + 6 * usize::from(self.stokes)
            + 2 * usize::from(self.tristimulus)
            + usize::from(self.spectrum)
            + self.additional
    }

    /// Where flux (radiant, luminous) and wavelength stand in a ray.
    pub(super) fn places(&self) -> [Option<usize>; 3] {
        let mut next = 6;
        [self.radiant, self.wavelength, self.luminous].map(|present| {
            next += usize::from(present);
            present.then(|| next - 1)
        })
    }
}

/// A spectrum within the file (4.7.4).
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    /// Wavelengths, nm.
    pub wavelength_nm: Vec<f64>,
    /// Relative weights.
    pub weight: Vec<f64>,
}

/// What stands before the rays.
#[derive(Debug, Clone, PartialEq)]
pub struct Header {
    /// Creation method: 0 simulation, 1 measurement (4.7.1.3).
    pub method: i32,
    /// Luminous flux of all rays, lm; none where the file holds NaN.
    pub luminous_flux_lm: Option<f64>,
    /// Radiant flux of all rays, W.
    pub radiant_flux_w: Option<f64>,
    /// How many rays follow.
    pub rays: u64,
    /// ISO 8601 time.
    pub created: String,
    /// Where rays start, 0 (unknown) to 7 (4.7.1.8).
    pub start: i32,
    /// Wavelengths.
    pub spectral: Spectral,
    /// Shortest and longest wavelength, nm, where given.
    pub range_nm: [Option<f64>; 2],
    /// Numbers of a ray.
    pub columns: Columns,
    /// Name, manufacturer, creator of the model, creator of the file, equipment, camera, operation, more, reference
    /// (4.7.3).
    pub texts: [String; 9],
    /// Spectra.
    pub tables: Vec<Table>,
    /// Names of the additional columns.
    pub names: Vec<String>,
    /// Where the first ray begins.
    pub data: u64,
}

impl Header {
    /// Reads everything up to the first ray.
    ///
    /// # Errors
    /// [`Tm25Error`] with the bytes that are wrong.
    pub fn read(from: &mut impl Read) -> Result<Self, Tm25Error> {
        let mut source = Source { from, at: 0 };
        let fixed = Fixed::read(&mut source)?;
        let (spectra, additional, text) = (
            fixed.size(76, "number of spectra")?,
            fixed.size(80, "number of additional columns")?,
            fixed.size(84, "size of the additional text")?,
        );
        let columns = fixed.columns(additional)?;
        let spectral = fixed.spectral(columns)?;
        let mut tables = Vec::new();
        for _ in 0..spectra {
            tables.push(source.table()?);
        }
        let spent = source.at - DATA as u64;
        source.exactly(spent.next_multiple_of(32) - spent, "the padding of the spectra")?;
        let mut names = Vec::new();
        for _ in 0..additional {
            names.push(utf32(&source.exactly(512, "the names of additional columns")?));
        }
        source.exactly(text as u64, "the additional text")?;
        let Fixed(head) = &fixed;
        let created: Vec<u8> = head[28..56].iter().copied().take_while(|byte| *byte != 0).collect();
        Ok(Self {
            method: fixed.int(8),
            luminous_flux_lm: fixed.known(12),
            radiant_flux_w: fixed.known(16),
            rays: u64::from_le_bytes(std::array::from_fn(|k| head[20 + k])),
            created: String::from_utf8_lossy(&created).into_owned(),
            start: fixed.int(56),
            spectral,
            range_nm: [fixed.known(68), fixed.known(72)],
            columns,
            texts: std::array::from_fn(|k| utf32(&head[TEXTS + k * TEXT..TEXTS + (k + 1) * TEXT])),
            tables,
            names,
            data: source.at,
        })
    }

    /// Where the rays end by this header.
    pub fn end(&self) -> u64 {
        let ray = 4 * self.columns.count() as u64;
        self.data.saturating_add(self.rays.saturating_mul(ray))
    }
}

/// The part of a header that every file has, all [`DATA`] bytes of it, of the version that is read here.
struct Fixed(Vec<u8>);

impl Fixed {
    fn read(source: &mut Source<'_, impl Read>) -> Result<Self, Tm25Error> {
        let head = source.take(DATA as u64, "the header")?;
        if head.get(..4) != Some(b"TM25") {
            return Err(Tm25Error::Magic {
                found: head[..head.len().min(4)].to_vec(),
            });
        }
        if head.len() < DATA {
            return Err(Tm25Error::Truncated {
                within: "the header",
                expected: DATA as u64,
                found: head.len() as u64,
            });
        }
        let fixed = Self(head);
        match fixed.int(4) {
            2013 => Ok(fixed),
            version => Err(Tm25Error::Version { version }),
        }
    }

    fn word(&self, at: usize) -> [u8; 4] {
        std::array::from_fn(|k| self.0[at + k])
    }

    fn int(&self, at: usize) -> i32 {
        i32::from_le_bytes(self.word(at))
    }

    fn float(&self, at: usize) -> f64 {
        f64::from(f32::from_le_bytes(self.word(at)))
    }

    /// A number that is NaN where it is not known.
    fn known(&self, at: usize) -> Option<f64> {
        Some(self.float(at)).filter(|value| !value.is_nan())
    }

    fn wrong(&self, at: usize, name: &'static str, need: &'static str) -> Tm25Error {
        Tm25Error::Field {
            span: [at as u64, at as u64 + 4],
            name,
            value: i64::from(self.int(at)),
            need,
        }
    }

    fn size(&self, at: usize, name: &'static str) -> Result<usize, Tm25Error> {
        usize::try_from(self.int(at)).map_err(|_| self.wrong(at, name, ": a count is not negative"))
    }

    fn columns(&self, additional: usize) -> Result<Columns, Tm25Error> {
        let mut flags = [false; 8];
        for (k, flag) in flags.iter_mut().enumerate() {
            let at = FLAGS + 4 * k;
            *flag = match self.int(at) {
                0 => false,
                1 => true,
                _ => return Err(self.wrong(at, "column flag", ": 0 or 1")),
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
        if !position || !direction {
            let at = if position { FLAGS + 4 } else { FLAGS };
            return Err(self.wrong(at, "flag of place or direction", ": both are needed"));
        }
        if !radiant && !luminous {
            let need = ": radiant or luminous flux is needed";
            return Err(self.wrong(FLAGS + 8, "flags of flux", need));
        }
        Ok(Columns {
            radiant,
            wavelength,
            luminous,
            stokes,
            tristimulus,
            spectrum,
            additional,
        })
    }

    fn spectral(&self, columns: Columns) -> Result<Spectral, Tm25Error> {
        match self.int(60) {
            0 => Ok(Spectral::None),
            1 => Ok(Spectral::Single(self.float(64))),
            2 if columns.wavelength => Ok(Spectral::PerRay),
            2 => Err(self.wrong(FLAGS + 12, "wavelength flag", ": spectral type 2 needs it")),
            3 => Ok(Spectral::Table),
            4 => Ok(Spectral::Tables),
            _ => Err(self.wrong(60, "spectral type", ": 0 to 4")),
        }
    }
}

/// A stream and how far it was read.
struct Source<'a, R> {
    from: &'a mut R,
    at: u64,
}

impl<R: Read> Source<'_, R> {
    /// Up to `count` bytes.
    fn take(&mut self, count: u64, within: &'static str) -> Result<Vec<u8>, Tm25Error> {
        if count > LARGEST {
            return Err(Tm25Error::Truncated {
                within,
                expected: self.at.saturating_add(count),
                found: self.at,
            });
        }
        let mut bytes = Vec::new();
        self.from.take(count).read_to_end(&mut bytes)?;
        self.at += bytes.len() as u64;
        Ok(bytes)
    }

    fn exactly(&mut self, count: u64, within: &'static str) -> Result<Vec<u8>, Tm25Error> {
        let start = self.at;
        let bytes = self.take(count, within)?;
        if (bytes.len() as u64) < count {
            return Err(Tm25Error::Truncated {
                within,
                expected: start + count,
                found: self.at,
            });
        }
        Ok(bytes)
    }

    fn table(&mut self) -> Result<Table, Tm25Error> {
        let start = self.at;
        let head = self.exactly(4, "a spectrum")?;
        let points = i32::from_le_bytes([head[0], head[1], head[2], head[3]]);
        let count = u64::try_from(points)
            .ok()
            .filter(|points| *points > 0)
            .ok_or(Tm25Error::Field {
                span: [start, start + 4],
                name: "points of a spectrum",
                value: i64::from(points),
                need: ": at least one",
            })?;
        let bytes = self.exactly(count * 8, "a spectrum")?;
        let mut table = Table::default();
        for pair in bytes.chunks_exact(8) {
            let at = |k: usize| f64::from(f32::from_le_bytes([pair[k], pair[k + 1], pair[k + 2], pair[k + 3]]));
            table.wavelength_nm.push(at(0));
            table.weight.push(at(4));
        }
        Ok(table)
    }
}

/// A text of four-byte letters up to the first zero.
fn utf32(bytes: &[u8]) -> String {
    bytes
        .chunks_exact(4)
        .map(|four| u32::from_le_bytes([four[0], four[1], four[2], four[3]]))
        .take_while(|letter| *letter != 0)
        .map(|letter| char::from_u32(letter).unwrap_or(char::REPLACEMENT_CHARACTER))
        .collect()
}
