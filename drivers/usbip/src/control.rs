//! Requests on endpoint 0 (USB 2.0, 9.4).

use std::collections::BTreeSet;

use crate::model::Model;

const TO_HOST: u8 = 0x80;
const GET_STATUS: u8 = 0;
const CLEAR_FEATURE: u8 = 1;
const SET_FEATURE: u8 = 3;
const GET_DESCRIPTOR: u8 = 6;
const GET_CONFIGURATION: u8 = 8;
const SET_CONFIGURATION: u8 = 9;
const GET_INTERFACE: u8 = 10;
const SET_INTERFACE: u8 = 11;
/// Recipient of a request in the low bits of its type.
const ENDPOINT: u8 = 2;
/// The one feature of an endpoint.
const ENDPOINT_HALT: u16 = 0;

/// The answer to a setup packet, cut to what the host takes; `None` is a stall. Endpoints in `halted` stall until the
/// host clears them.
pub fn answer(model: &Model, halted: &mut BTreeSet<u8>, setup: [u8; 8]) -> Option<Vec<u8>> {
    let [
        kind,
        request,
        value_low,
        value_high,
        index_low,
        _,
        length_low,
        length_high,
    ] = setup;
    let value = u16::from_le_bytes([value_low, value_high]);
    let length = usize::from(u16::from_le_bytes([length_low, length_high]));
    // Bits 5 and 6: the standard's own requests; instruments here have none of their vendor's.
    if kind & 0x60 != 0 {
        return None;
    }
    let mut bytes = match (kind & TO_HOST != 0, request) {
        (true, GET_DESCRIPTOR) => model.descriptor(value_high, value_low)?,
        (true, GET_STATUS) if kind & 0x1F == ENDPOINT => vec![u8::from(halted.contains(&index_low)), 0],
        (true, GET_STATUS) => vec![0, 0],
        (true, GET_CONFIGURATION) => vec![1],
        (true, GET_INTERFACE) => vec![0],
        (false, SET_CONFIGURATION) if value <= 1 => Vec::new(),
        (false, SET_INTERFACE) if value == 0 => Vec::new(),
        (false, CLEAR_FEATURE) if kind & 0x1F == ENDPOINT && value == ENDPOINT_HALT => {
            halted.remove(&index_low);
            Vec::new()
        }
        (false, SET_FEATURE) if kind & 0x1F == ENDPOINT && value == ENDPOINT_HALT => {
            halted.insert(index_low);
            Vec::new()
        }
        _ => return None,
    };
    bytes.truncate(length);
    Some(bytes)
}
