//! The station of the built-in virtual darkroom.

use isolux_darkroom::{Darkroom, Room};
use isolux_virtual::station::{calibration, in_memory, station};
use isolux_virtual::twins::Choice;

use crate::Failure;

/// The station of the built-in virtual darkroom with the twins of `choice`, and the calibration that it names, if it
/// does.
///
/// # Errors
/// Never for the darkroom as it is shipped.
pub fn virtual_station(choice: &Choice) -> Result<(String, Option<String>), Failure> {
    let document = Darkroom::built_in().map_err(Failure::bad_input)?;
    let outlets = in_memory(choice);
    let text = station(&document, &outlets);
    Ok((text, calibration(&Room::new(document), &outlets)))
}
