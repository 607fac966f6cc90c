//! IES LM-63: 1986, 1991, 1995, 2002 and 2019.
//!
//! A version line (none in 1986), keyword or label lines, `TILT=`, then one stream of numbers separated by blanks or
//! commas: ten of lamp and geometry, ballast factor, ballast-lamp photometric factor and watts, vertical angles,
//! horizontal angles, candela plane by plane. Grammar after the published descriptions of Radiance's `ies2rad` and of
//! I. Ashdown's parser; the standard itself is not free.

mod angles;
mod detect;
mod edition;
mod grid;
mod lamp;
mod layout;
mod native;
mod numbers;
mod own;
mod photometry;
mod preamble;
mod read;
mod scene;
mod shape;
mod tilt;
mod write;

pub use detect::looks_like;
pub use edition::{Edition, GENERATION_TYPES};
pub use own::OwnLight;
pub use photometry::Photometry;
pub use read::{read, read_beside};
pub use shape::Shape;
pub use tilt::TiltFactors;
pub use write::{Facts, write, write_as};
