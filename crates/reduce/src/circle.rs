//! Words for a circle that was not measured all round.

use isolux_photometry::Symmetry;

/// What a symmetry that was assumed means, for a note; none where nothing was assumed.
pub fn note(assumed: Symmetry) -> Option<String> {
    let (part, about) = match assumed {
        Symmetry::None => return None,
        Symmetry::Rotational => {
            return Some(
                "symmetry assumed: one half-plane was measured, and the lamp is taken as rotationally symmetric; \
                 where it is not, measure half-planes all round, C 0° to 360°"
                    .to_owned(),
            );
        }
        Symmetry::C0C180 => ("one half", "the plane C 0°–C 180°"),
        Symmetry::C90C270 => ("one half", "the plane C 90°–C 270°"),
        Symmetry::Quadrant => ("one quadrant", "both planes C 0°–C 180° and C 90°–C 270°"),
    };
    Some(format!(
        "symmetry assumed: {part} of the circle was measured, and the lamp is taken as symmetric about {about}; \
         where it is not, measure half-planes all round, C 0° to 360°"
    ))
}
