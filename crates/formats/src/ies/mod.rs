//! IES LM-63: 1986, 1991, 1995, 2002 and 2019.
//!
//! A version line (none in 1986), keyword or label lines, `TILT=`, then one stream of numbers separated by blanks or
//! commas: ten of lamp and geometry, ballast factor, ballast-lamp photometric factor and watts, vertical angles,
//! horizontal angles, candela plane by plane. Grammar after the published descriptions of Radiance's `ies2rad` and of
//! I. Ashdown's parser; the standard itself is not free.

mod angles;
mod detect;
pub(crate) mod edition;
mod facts;
mod grid;
mod lamp;
mod layout;
mod light;
mod native;
mod numbers;
mod own;
pub(crate) mod photometry;
mod preamble;
mod read;
mod scene;
mod shape;
mod tilt;
mod write;

pub use detect::looks_like;
pub use edition::{Edition, GENERATION_TYPES};
pub use facts::Facts;
pub use own::OwnLight;
pub use photometry::Photometry;
pub use read::{read, read_beside};
pub use shape::Shape;
pub use tilt::TiltFactors;
pub use write::{write, write_as};

use crate::eulumdat;
use crate::file_format::{self, FileFormat};
use crate::parsed::Format;

pub(crate) const FORMAT: FileFormat = FileFormat {
    format: Format::IES,
    title: "IES LM-63",
    extensions: &["ies"],
    detect: |source| {
        let named = || source.extension == "ies" && !eulumdat::looks_like(source.head());
        looks_like(source.head()) || named()
    },
    read: |source| file_format::distribution(read_beside(source.bytes, source.options, source.beside)),
    write_distribution: Some(write::encode),
    write_spectrum: None,
};
