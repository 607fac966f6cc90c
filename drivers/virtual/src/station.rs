//! The station file of a virtual darkroom: what an operator of it would have written.

use isolux_darkroom::document::{Axis, Darkroom};
use isolux_darkroom::illuminator::Illuminator;
use isolux_darkroom::spectrograph::{PIXELS, wavelength_nm};
use isolux_darkroom::{Flaws, Room, document::Instrument};

use crate::VirtualRoom;
use crate::outlet::Outlet;

/// Name of the calibration file that [`station`] refers to.
pub const CALIBRATION_FILE: &str = "spectroradiometer.csv";

/// Addresses of the pipes of [`VirtualRoom::listen`].
pub fn in_memory() -> Vec<Outlet> {
    [
        (Instrument::Axes, VirtualRoom::AXES),
        (Instrument::Luxmeter, VirtualRoom::LUXMETER),
        (Instrument::Spectroradiometer, VirtualRoom::SPECTROMETER),
    ]
    .map(|(instrument, name)| Outlet {
        instrument,
        address: format!("memory:{name}"),
    })
    .to_vec()
}

/// Text of a station file (`isolux-station/1`) for the instruments at `outlets`. It says what an operator knows: nominal
/// distances, the certificates with their uncertainties, no flaw.
///
/// `darkroom` names the room's file where it is not the built-in one and the instruments are in memory.
pub fn station_in(darkroom: Option<&str>, document: &Darkroom, outlets: &[Outlet]) -> String {
    let text = station(document, outlets);
    match darkroom {
        Some(file) => text.replacen("\n\n", &format!("\ndarkroom = {file:?}\n\n"), 1),
        None => text,
    }
}

/// As [`station_in`], without naming the room's file.
pub fn station(document: &Darkroom, outlets: &[Outlet]) -> String {
    let address = |instrument: Instrument| {
        outlets
            .iter()
            .find(|outlet| outlet.instrument == instrument)
            .map(|outlet| outlet.address.as_str())
    };
    let mut text = format!(
        "format = \"isolux-station/1\"\nname = \"virtual darkroom\"\n\n[bench]\ntype = \"turning_luminaire\"\n\
         distance_mm = {:.1}\nu_distance_mm = 2.0\nfloor_mm = {:.1}\n",
        document.bench.distance_mm, document.flaws.floor_reflection.height_mm
    );
    if let Some(axes) = address(Instrument::Axes) {
        text.push_str(&axis("c", &document.axis.c, axes, 1));
        text.push_str(&axis("gamma", &document.axis.gamma, axes, 2));
    }
    if let Some(meter) = address(Instrument::Luxmeter) {
        text.push_str(&format!(
            "\n[luxmeter]\nopen = \"konica-t10a:{meter}?head=0\"\ncalibration_factor = 1.0\nu_rel = 0.004\n\
             certificate = \"virtual 1\"\nnoise_rel = {:?}\nnoise_lx = {:?}\n",
            document.luxmeter.noise_rel, document.luxmeter.noise_lx
        ));
    }
    if let Some(spectrometer) = address(Instrument::Spectroradiometer) {
        text.push_str(&format!(
            "\n[spectroradiometer]\nopen = \"ocean-ooi:{spectrometer}\"\ndistance_mm = {:.1}\nu_distance_mm = 0.5\n\
             calibration = \"{CALIBRATION_FILE}\"\nu_rel = 0.004\nu_shape_rel = 0.004\nu_wavelength_nm = 0.1\n\
             stray_max_rel = 0.001\n",
            document.spectroradiometer.distance_mm
        ));
    }
    if let Some(axes) = address(Instrument::Axes) {
        let nominal = Illuminator::new(&document.lamp, &Flaws::default(), document.seed);
        let estimates = [("flux_lm", document.lamp.flux_lm), ("peak_cd", nominal.axial_cd())]
            .into_iter()
            .filter(|(_, value)| *value > 0.0)
            .fold(String::new(), |text, (key, value)| {
                text + &format!("{key} = {:?}\n", two_digits(value))
            });
        let diameter = document.lamp.ring_diameter_mm.iter().copied().fold(0.0, f64::max) + 5.0;
        text.push_str(&format!(
            "\n# Digital outputs of the axes' controller: lamp, shutter (on = open), baffle (on = in the beam).\n\
             [lamp]\nopen = \"zaber:{axes}?do=1\"\ndiameter_mm = {diameter:.1}\n\
             # Estimates, as a data sheet gives them: `isolux plan` says with them what a distance costs.\n\
             {estimates}\n[shutter]\nopen = \"zaber:{axes}?do=2\"\n\n\
             [baffle]\nopen = \"zaber:{axes}?do=3\"\n\n\
             # The detector's carriage, in mm from the intersection of the axes: 2000 microsteps a millimetre.\n\
             [rail]\nopen = \"zaber:{axes}?axis=3\"\ncounts_per_mm = \"2000/1\"\nzero_mm = 0.0\n\
             limit_mm = [100.0, 12000.0]\nspeed_mm_s = 400.0\naccel_mm_s2 = 800.0\n\n\
             # A 0–10 V temperature transmitter on the controller's first analogue input.\n\
             [ambient]\nopen = \"zaber:{axes}?ai=1&c_at_0v=-50&c_at_10v=100\"\n"
        ));
    }
    text
}

/// A positive number to two digits.
fn two_digits(value: f64) -> f64 {
    let unit = 10_f64.powf(value.log10().floor() - 1.0);
    (value / unit).round() * unit
}

fn axis(name: &str, axis: &Axis, address: &str, number: u8) -> String {
    let [low, high] = axis.limit_deg;
    format!(
        "\n[axis.{name}]\nopen = \"zaber:{address}?axis={number}\"\ncounts_per_deg = \"{}/{}\"\nzero_deg = 0.0\nsense = 1\n\
         limit_deg = [{low:.1}, {high:.1}]\nspeed_deg_s = {:?}\naccel_deg_s2 = {:?}\n",
        axis.counts_per_deg.numerator, axis.counts_per_deg.denominator, axis.speed_deg_s, axis.accel_deg_s2
    )
}

/// Text of the spectroradiometer's calibration: `wavelength_nm,factor`, W/(m² nm) for one linear count per second, over the
/// pixels that have a responsivity.
pub fn calibration(room: &Room) -> String {
    let coefficients = room.document().spectroradiometer.wavelength_nm;
    let mut text = String::from("wavelength_nm,factor\n");
    for pixel in 0..PIXELS {
        let factor = room.calibration(pixel);
        if factor > 0.0 {
            text.push_str(&format!(
                "{:.4},{factor:.6e}\n",
                wavelength_nm(coefficients, pixel as f64)
            ));
        }
    }
    text
}
