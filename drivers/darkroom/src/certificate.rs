//! The certificate of a room's lamp as a standard: what a laboratory states of its light at the rated current, wrong by
//! an error that is drawn from the uncertainties which it states.

use crate::document::Darkroom;
use crate::injected_effects::InjectedEffects;
use crate::noise::{Noise, Stream};
use crate::room::Room;

/// Wavelengths of the table, nm: those at which such lamps are certified, ultraviolet to near infrared.
const WAVELENGTHS_NM: [f64; 18] = [
    330.0, 340.0, 350.0, 360.0, 370.0, 380.0, 390.0, 400.0, 450.0, 500.0, 555.0, 600.0, 654.6, 700.0, 800.0, 900.0,
    1050.0, 1150.0,
];

/// Second radiation constant, nm·K.
const C2_NM_K: f64 = 1.438_776_877e7;

/// What the laboratory says of its own work, beside the values.
#[derive(Debug, Clone, PartialEq)]
pub struct Stated {
    /// Number of the certificate.
    pub number: String,
    /// Day of issue and last day of its validity, YYYY-MM-DD.
    pub days: (String, String),
    /// Distance of the spectral irradiance, mm.
    pub distance_mm: f64,
    /// Relative standard uncertainty that all wavelengths share.
    pub u_scale_rel: f64,
    /// Relative standard uncertainty of the temperature of the radiator from which the scale comes.
    pub u_temperature_rel: f64,
    /// Relative standard uncertainty of the rest, smooth over wavelength.
    pub u_rest_rel: f64,
    /// Distance of the illuminance, mm.
    pub illuminance_distance_mm: f64,
    /// Its relative standard uncertainty.
    pub u_illuminance_rel: f64,
    /// How far from its rated value the current may be, relative.
    pub current_tolerance_rel: f64,
    /// Standard uncertainty of the lamp's direction, degrees.
    pub u_alignment_deg: f64,
}

impl Default for Stated {
    fn default() -> Self {
        Self {
            number: "virtual standard".to_owned(),
            days: ("2026-01-01".to_owned(), "2027-01-01".to_owned()),
            distance_mm: 500.0,
            u_scale_rel: 0.004,
            u_temperature_rel: 0.0005,
            u_rest_rel: 0.0015,
            illuminance_distance_mm: 2000.0,
            u_illuminance_rel: 0.0035,
            current_tolerance_rel: 0.002,
            u_alignment_deg: 0.2,
        }
    }
}

/// The two files of a certificate: `isolux-standard/1`, and the table that it names.
#[derive(Debug, Clone, PartialEq)]
pub struct Written {
    /// The document.
    pub document: String,
    /// The table of spectral irradiance.
    pub table: String,
}

/// The certificate of the lamp of `room`, whose table will lie in `table_file` beside it. The same room has the same
/// errors in it.
pub fn write(room: &Darkroom, stated: &Stated, table_file: &str) -> Written {
    let errors = Errors::drawn(room.seed);
    let temperature_k = distribution_temperature_k(room);
    let at_mm = |distance_mm: f64| rated(room, distance_mm);
    let (near, near_lx) = at_mm(stated.distance_mm);
    let mut table = String::from("wavelength_nm,irradiance_w_m2_nm,u_rel\n");
    for nm in WAVELENGTHS_NM {
        let tilt = C2_NM_K / (nm * temperature_k) * stated.u_temperature_rel;
        let error = stated.u_scale_rel * errors.scale + tilt * errors.temperature + stated.u_rest_rel * errors.rest(nm);
        let u_rel = stated.u_scale_rel.hypot(tilt).hypot(stated.u_rest_rel);
        let value = near_lx * near.spectrum().per_lux(nm, 1.0) * (1.0 + error);
        table += &format!("{nm},{value:.5e},{u_rel:.5}\n");
    }
    let (_, far_lx) = at_mm(stated.illuminance_distance_mm);
    let illuminance_lx = far_lx * (1.0 + stated.u_illuminance_rel * errors.illuminance);
    let lamp = &room.lamp;
    let current_a = lamp.power_w / (lamp.voltage_v * lamp.power_factor);
    let document = format!(
        "# The certificate of the lamp of a virtual darkroom: its values are wrong by an error drawn from what it \
         states.\n\
         format = \"isolux-standard/1\"\n\n\
         [lamp]\ndesignation = \"virtual filament lamp\"\nnumber = \"seed {seed}\"\nhours_run = 25.0\n\n\
         [certificate]\nnumber = \"{number}\"\nlaboratory = \"virtual laboratory\"\nissued = \"{issued}\"\n\
         expires = \"{expires}\"                # not used after this day\n\n\
         [conditions]\ncurrent_a = {current_a:.4}\n\
         current_tolerance_a = {tolerance_a:.4}            # the current may differ by this; more is refused\n\
         reference_plane = \"the middle of the filament\" # from which distances count\n\
         u_alignment_deg = {alignment:?}                  # of the lamp's direction in its mount (k = 1)\n\n\
         # At distances in mm; uncertainties are standard ones (k = 1) and relative.\n\
         [spectral_irradiance]\ndistance_mm = {distance:.1}\ntable = {table_file:?}\n\
         u_scale_rel = {scale:?}                    # the part of u_rel that all wavelengths share\n\
         u_temperature_rel = {temperature:?}             # of the temperature of the radiator that carries the \
         scale\n\n\
         [illuminance]\ndistance_mm = {far:.1}\nilluminance_lx = {illuminance_lx:.4}\nu_rel = {u_lx:?}\n\
         colour_temperature_k = {temperature_k:.0}\n",
        seed = room.seed,
        number = stated.number,
        issued = stated.days.0,
        expires = stated.days.1,
        tolerance_a = current_a * stated.current_tolerance_rel,
        alignment = stated.u_alignment_deg,
        distance = stated.distance_mm,
        scale = stated.u_scale_rel,
        temperature = stated.u_temperature_rel,
        far = stated.illuminance_distance_mm,
        u_lx = stated.u_illuminance_rel,
    );
    Written { document, table }
}

/// The lamp at its rated current in an empty room, and its illuminance on the axis at `distance_mm`, lx.
fn rated(room: &Darkroom, distance_mm: f64) -> (Room, f64) {
    let mut document = room.clone();
    document.injected_effects = InjectedEffects::default();
    document.lamp.current_error_rel = 0.0;
    document.spectroradiometer.distance_mm = distance_mm;
    let room = Room::new(document);
    let lx = room.spectroradiometer_lx(true, 0.0, 0.0, 0.0, 0.0);
    (room, lx)
}

/// Temperature of the Planckian radiator with the same ratio of blue (460 nm) to red (660 nm) light, K, where Wien's
/// law holds.
fn distribution_temperature_k(room: &Darkroom) -> f64 {
    let (lamp, _) = rated(room, room.spectroradiometer.distance_mm);
    let at = |nm: f64| (lamp.spectrum().per_lux(nm, 1.0) * (nm / 1000.0).powi(5)).ln();
    C2_NM_K * (1.0 / 460.0 - 1.0 / 660.0) / (at(660.0) - at(460.0))
}

/// Standard normal numbers of one certificate.
struct Errors {
    scale: f64,
    temperature: f64,
    waves: [f64; 2],
    illuminance: f64,
}

impl Errors {
    fn drawn(seed: u64) -> Self {
        let noise = Noise::new(seed, Stream::Certificate);
        let [scale, temperature] = noise.normal_pair(0, 0);
        Self {
            scale,
            temperature,
            waves: noise.normal_pair(1, 0),
            illuminance: noise.normal(2, 0),
        }
    }

    /// One turn of a wave over the table, of any phase: at every wavelength the variance is 1.
    fn rest(&self, wavelength_nm: f64) -> f64 {
        let [first, last] = [WAVELENGTHS_NM[0], WAVELENGTHS_NM[WAVELENGTHS_NM.len() - 1]];
        let (sin, cos) = (std::f64::consts::TAU * (wavelength_nm - first) / (last - first)).sin_cos();
        self.waves[0] * cos + self.waves[1] * sin
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lamp(seed: u64) -> Darkroom {
        let mut room = Darkroom {
            seed,
            ..Darkroom::default()
        };
        room.lamp.temperature_k = 2802.0;
        room.lamp.seed = 1;
        room
    }

    fn values(written: &Written) -> Vec<f64> {
        let rows = written.table.lines().skip(1);
        rows.map(|row| row.split(',').nth(1).unwrap().parse().unwrap())
            .collect()
    }

    #[test]
    fn over_many_rooms_its_values_are_wrong_by_what_it_states() {
        let stated = Stated::default();
        let (room, lx) = rated(&lamp(1), 500.0);
        let n = 400;
        let squares = (1..=n).fold([0.0; 18], |mut sum, seed| {
            for (place, value) in values(&write(&lamp(seed), &stated, "t.csv")).iter().enumerate() {
                // With a seed of its own the lamp is the same in every room.
                let truth = lx * room.spectrum().per_lux(WAVELENGTHS_NM[place], 1.0);
                sum[place] += (value / truth - 1.0).powi(2);
            }
            sum
        });
        let written = write(&lamp(1), &stated, "t.csv");
        for (place, row) in written.table.lines().skip(1).enumerate() {
            let u_rel: f64 = row.split(',').nth(2).unwrap().parse().unwrap();
            let found = (squares[place] / n as f64).sqrt();
            assert!((found / u_rel - 1.0).abs() < 0.2, "{row}: {found}");
        }
    }

    #[test]
    fn it_says_the_temperature_of_illuminant_a_and_not_that_the_current_is_off() {
        let mut room = lamp(3);
        let rated = write(&room, &Stated::default(), "t.csv");
        assert!(
            rated.document.contains("colour_temperature_k = 2856\n"),
            "{}",
            rated.document
        );
        room.lamp.current_error_rel = 0.01;
        assert_eq!(write(&room, &Stated::default(), "t.csv"), rated);
    }
}
