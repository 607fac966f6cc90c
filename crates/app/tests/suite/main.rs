//! The use cases in the virtual room, on fake and on real links. One test program, so that the tests that wait for
//! instruments run beside those that compute.

mod any_record;
mod bench;
mod calibration;
mod colour_of_a_day;
mod colour_over_angle;
mod conformity;
mod draws;
mod every_section;
mod every_twin;
mod feasibility;
mod identify;
mod in_room;
mod interference;
mod languages;
mod light_modulation;
mod links;
mod lux_meter;
mod read_spectrum;
mod record_as_live;
mod results_are_types;
mod room_interpolation;
mod room_smoothing;
mod sweeps;
mod uncertainty;
