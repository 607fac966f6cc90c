//! The fields of the header: one table that reading, writing, JSON, edits and conversions to other formats go by.

use super::document::{Header, LampSet};
use crate::luminaire::Luminaire;
use crate::parsed::Format;

/// A field of the header, or of a set of lamps.
pub(crate) struct Field<T> {
    /// Zero-based line; of a set, from its first.
    pub line: usize,
    /// Its key in `header` of the JSON documents.
    pub key: &'static str,
    /// Characters that it has room for.
    pub width: usize,
    /// Whether a file of another format can say it; true too where it follows from the light.
    pub elsewhere: fn(Format) -> bool,
    pub value: Value<T>,
}

/// Where a value is kept: in the document, and in the description that formats share if it is part of that.
pub(crate) enum Value<T> {
    Text(Place<T, String>, Shared<String>),
    /// What the number is, and what is written where it is not known.
    Number(&'static str, Blank, Place<T, Option<f64>>, Shared<Option<f64>>),
}

type Place<T, V> = fn(&mut T) -> &mut V;

/// Name and place in [`Luminaire`].
type Shared<V> = Option<(&'static str, Place<Luminaire, V>)>;

/// What is written for a number that is not known.
pub(crate) enum Blank {
    /// This, in every file.
    Is(f64),
    /// 0 in a new file: readers that skip blank lines would take every number after one for its neighbour.
    Zero,
    /// Nothing.
    Stays,
}

use Blank::{Is, Stays, Zero};

const ALL: fn(Format) -> bool = |_| true;
const NONE: fn(Format) -> bool = |_| false;
const IES: fn(Format) -> bool = |format| format == Format::IES;
const BUT_IES: fn(Format) -> bool = |format| format != Format::IES;

macro_rules! shared {
    () => {
        None
    };
    ($field:ident $([$place:literal])?) => {
        Some((stringify!($field), |of| &mut of.$field$([$place])?))
    };
}

/// Line, key, width, formats that have it, field of the document = field of the description.
macro_rules! text {
    ($line:literal, $key:literal, $width:literal, $elsewhere:expr, $own:ident $(= $shared:ident)?) => {
        Field {
            line: $line,
            key: $key,
            width: $width,
            elsewhere: $elsewhere,
            value: Value::Text(|of| &mut of.$own, shared!($($shared)?)),
        }
    };
}

/// The same with what the number is and what stands for one that is not known.
macro_rules! number {
    ($line:literal, $key:literal, $width:literal, $what:expr, $blank:expr, $elsewhere:expr,
        $own:ident $([$at:literal])? $(= $shared:ident $([$place:literal])?)?) => {
        Field {
            line: $line,
            key: $key,
            width: $width,
            elsewhere: $elsewhere,
            value: Value::Number($what, $blank, |of| &mut of.$own$([$at])?, shared!($($shared$([$place])?)?)),
        }
    };
}

const LUMINOUS_HEIGHT: &str = "the height of the luminous area";

/// Lines 1 to 25, the counts of lines 3, 4 and 6 aside.
#[rustfmt::skip]
pub(crate) const HEADER: &[Field<Header>] = &[
    text!(0, "company", 78, ALL, company = manufacturer),
    number!(1, "type_indicator", 4, "the type indicator", Is(0.0), ALL, type_indicator),
    number!(4, "c_step_deg", 5, "the distance between C planes", Is(0.0), ALL, c_step_deg),
    number!(6, "gamma_step_deg", 5, "the distance between γ angles", Is(0.0), ALL, gamma_step_deg),
    text!(7, "report_number", 78, ALL, report = report),
    text!(8, "luminaire_name", 78, ALL, name = name),
    text!(9, "luminaire_number", 78, ALL, number = number),
    text!(10, "file_name", 8, NONE, file_name),
    text!(11, "date_user", 78, ALL, date_user = date),
    number!(12, "length_mm", 4, "the length of the luminaire", Zero, BUT_IES, length_mm = length_mm),
    number!(13, "width_mm", 4, "the width of the luminaire", Zero, BUT_IES, width_mm = width_mm),
    number!(14, "height_mm", 4, "the height of the luminaire", Zero, BUT_IES, height_mm = height_mm),
    number!(15, "luminous_length_mm", 4, "the length of the luminous area", Zero, ALL,
        luminous_length_mm = luminous_length_mm),
    number!(16, "luminous_width_mm", 4, "the width of the luminous area", Zero, ALL,
        luminous_width_mm = luminous_width_mm),
    number!(17, "luminous_height_c0_mm", 4, LUMINOUS_HEIGHT, Zero, IES, luminous_height_mm[0] = luminous_height_mm[0]),
    number!(18, "luminous_height_c90_mm", 4, LUMINOUS_HEIGHT, Zero, IES, luminous_height_mm[1] = luminous_height_mm[1]),
    number!(19, "luminous_height_c180_mm", 4, LUMINOUS_HEIGHT, Zero, IES, luminous_height_mm[2] = luminous_height_mm[2]),
    number!(20, "luminous_height_c270_mm", 4, LUMINOUS_HEIGHT, Zero, IES, luminous_height_mm[3] = luminous_height_mm[3]),
    number!(21, "dff_percent", 4, "the downward flux fraction", Zero, ALL, dff_percent),
    number!(22, "lorl_percent", 4, "the light output ratio", Zero, ALL, lorl_percent),
    number!(23, "conversion_factor", 6, "the conversion factor", Is(1.0), ALL, conversion_factor),
    number!(24, "tilt_deg", 6, "the tilt", Zero, NONE, tilt_deg = tilt_deg),
];

/// The six lines of a set of lamps. What other formats have of its texts depends on them: see `lost`.
#[rustfmt::skip]
pub(crate) const SET: &[Field<LampSet>] = &[
    number!(0, "lamp_count", 4, "the number of lamps", Stays, ALL, count),
    text!(1, "lamp_type", 24, ALL, lamp = lamp),
    number!(2, "flux_lm", 12, "the flux of the lamps", Stays, ALL, flux_lm),
    text!(3, "colour_appearance", 16, ALL, colour = colour),
    text!(4, "colour_rendering", 6, ALL, rendering = rendering),
    number!(5, "power_w", 8, "the power", Zero, ALL, watts = watts),
];

/// What formats share, from the document to the description or the other way.
pub(super) fn share<T>(fields: &[Field<T>], of: &mut T, luminaire: &mut Luminaire, to_luminaire: bool) {
    fn copy<V: Clone>(own: &mut V, shared: &mut V, to_shared: bool) {
        let (from, to) = if to_shared { (own, shared) } else { (shared, own) };
        to.clone_from(from);
    }
    for field in fields {
        match field.value {
            Value::Text(own, Some((_, shared))) => copy(own(of), shared(luminaire), to_luminaire),
            Value::Number(_, _, own, Some((_, shared))) => copy(own(of), shared(luminaire), to_luminaire),
            Value::Text(_, None) | Value::Number(_, _, _, None) => {}
        }
    }
}
