//! The station file of a virtual darkroom: what an operator of it would have written.

use isolux_darkroom::illuminator::Illuminator;
use isolux_darkroom::parts::Axis;
use isolux_darkroom::{Darkroom, InjectedEffects, Instrument, Room, head};

use crate::VirtualRoom;
use crate::outlet::Outlet;
use crate::twins::{Choice, InMotion, TWINS, TwinKind};

/// Name of the calibration file that [`station`] refers to.
pub const CALIBRATION_FILE: &str = "spectroradiometer.csv";

/// Name of the file with the responsivity of the lux meter's head that [`station`] refers to.
pub const RESPONSIVITY_FILE: &str = "luxmeter.csv";

/// Addresses of the pipes of [`VirtualRoom::listen`].
pub fn in_memory(choice: &Choice) -> Vec<Outlet> {
    let outlet = |instrument: Instrument| {
        choice.twin(instrument).map(|twin| Outlet {
            instrument,
            driver: twin.driver,
            address: format!("memory:{}", VirtualRoom::pipe(instrument)),
        })
    };
    choice.instruments().filter_map(outlet).collect()
}

/// Text of a station file (`isolux-station/1`) for the instruments at `outlets`. It says what an operator knows:
/// nominal distances, the certificates with their uncertainties, no injected effect.
///
/// `darkroom` names the room's file where it is not the built-in one and the instruments are in memory.
pub fn station_in(darkroom: Option<&str>, document: &Darkroom, outlets: &[Outlet]) -> String {
    let text = station(document, outlets);
    match darkroom {
        Some(file) => text.replacen("\n\n", &format!("\ndarkroom = {file:?}\n\n"), 1),
        None => text,
    }
}

/// The twin at an outlet. What hangs on a controller of axes is such a controller.
pub fn twin(outlet: &Outlet) -> Option<&'static TwinKind> {
    let mut speaking = TWINS.iter().filter(|twin| twin.driver == outlet.driver);
    let own = speaking.clone().find(|twin| twin.instrument == outlet.instrument);
    own.or_else(|| speaking.next())
}

/// `open` of a part of the station, at the first outlet that can be it.
pub fn open(part: &str, outlets: &[Outlet]) -> Option<String> {
    outlets.iter().find_map(|outlet| {
        let rest = twin(outlet)?.open(part)?;
        Some(format!("{}:{}{rest}", outlet.driver, outlet.address))
    })
}

/// The text of a station with `outlets`, for a plan that reads while γ moves.
pub fn for_sweeps(text: &str, outlets: &[Outlet]) -> String {
    let mut text = text.to_owned();
    for outlet in outlets {
        let Some((twin, Some(InMotion::OnRequest { open: more, .. }))) = twin(outlet).map(|twin| (twin, twin.sweeps))
        else {
            continue;
        };
        for (_, rest) in twin.opens {
            let open = format!("{}:{}{rest}", outlet.driver, outlet.address);
            text = text.replace(&format!("{open}\""), &format!("{open}{more}\""));
        }
    }
    text
}

/// As [`station_in`], without naming the room's file.
pub fn station(document: &Darkroom, outlets: &[Outlet]) -> String {
    let open = |part: &str| open(part, outlets);
    let mut text = format!(
        "format = \"isolux-station/1\"\nname = \"virtual darkroom\"\n\n[bench]\ntype = \"turning_luminaire\"\n\
         distance_mm = {:.1}\nu_distance_mm = 2.0\nu_gamma_deg = 0.03\nfloor_mm = {:.1}\n",
        document.bench.distance_mm, document.injected_effects.floor_reflection.height_mm
    );
    for (name, settings) in [("c", &document.axis.c), ("gamma", &document.axis.gamma)] {
        if let Some(open) = open(&format!("axis.{name}")) {
            text.push_str(&axis(name, settings, &open));
        }
    }
    if let Some(open) = open("luxmeter") {
        let of_twin = outlets.iter().find_map(|outlet| twin(outlet)?.noise_lx);
        let noise_lx = of_twin.map_or(document.luxmeter.noise_lx, |noise_lx| two_digits(noise_lx(document)));
        text.push_str(&format!(
            "\n[luxmeter]\nopen = \"{open}\"\ncalibration_factor = 1.0\nu_rel = 0.004\n\
             certificate = \"virtual 1\"\nnoise_rel = {:?}\nnoise_lx = {:?}\n",
            document.luxmeter.noise_rel, noise_lx
        ));
        if !head::is_perfect(&document.luxmeter) {
            text.push_str(&format!("responsivity = \"{RESPONSIVITY_FILE}\"\n"));
        }
    }
    if let Some(open) = open("spectroradiometer") {
        let calibration = match calibrated(outlets) {
            Some(_) => CALIBRATION_FILE,
            None => "device",
        };
        text.push_str(&format!(
            "\n[spectroradiometer]\nopen = \"{open}\"\ndistance_mm = {:.1}\nu_distance_mm = 0.5\n\
             calibration = \"{calibration}\"\nu_rel = 0.004\nu_shape_rel = 0.004\nu_wavelength_nm = 0.1\n\
             stray_max_rel = 0.001\n",
            document.spectroradiometer.distance_mm
        ));
    }
    if let Some(open) = open("powermeter") {
        text.push_str(&format!(
            "\n# In the supply line of the lamp: volts, amperes and watts with every reading.\n\
             [powermeter]\nopen = \"{open}\"\nu_power_rel = 0.001\nu_voltage_rel = 0.0005\nu_current_rel = 0.0005\n"
        ));
    }
    let supply = open("supply");
    if let Some(open) = &supply {
        text.push_str(&format!(
            "\n# Feeds the lamp at these levels, and switches it: [lamp] has no switch of its own then.\n\
             [supply]\nopen = \"{open}\"\n"
        ));
    }
    let switch = open("lamp").map(|open| format!("open = \"{open}\"\n"));
    if let Some(switch) = supply.map(|_| String::new()).or(switch) {
        let nominal = Illuminator::new(&document.lamp, &InjectedEffects::default(), document.seed);
        let estimates = [("flux_lm", document.lamp.flux_lm), ("peak_cd", nominal.peak_cd())]
            .into_iter()
            .filter(|(_, value)| *value > 0.0)
            .fold(String::new(), |text, (key, value)| {
                text + &format!("{key} = {:?}\n", two_digits(value))
            });
        let diameter = document.lamp.diameter_mm();
        text.push_str(&format!(
            "\n# Digital outputs of the axes' controller: lamp, shutter (on = open), baffle (on = in the beam).\n\
             [lamp]\n{switch}diameter_mm = {diameter:.1}\n\
             # Estimates, as a data sheet gives them: `isolux plan` says with them what a distance costs.\n\
             {estimates}"
        ));
    }
    for part in ["shutter", "baffle"] {
        if let Some(open) = open(part) {
            text.push_str(&format!("\n[{part}]\nopen = \"{open}\"\n"));
        }
    }
    if let Some(open) = open("rail") {
        text.push_str(&format!(
            "\n# The detector's carriage, in mm from the intersection of the axes: 2000 microsteps a millimetre.\n\
             [rail]\nopen = \"{open}\"\ncounts_per_mm = \"2000/1\"\nzero_mm = 0.0\n\
             limit_mm = [100.0, 12000.0]\nspeed_mm_s = 400.0\naccel_mm_s2 = 800.0\n"
        ));
    }
    if let Some(open) = open("ambient") {
        text.push_str(&format!(
            "\n# A 0–10 V temperature transmitter on the controller's first analogue input.\n[ambient]\nopen = \"{open}\"\n"
        ));
    }
    text
}

/// What writes the calibration of the spectroradiometer among `outlets`; none where it keeps its own.
fn calibrated(outlets: &[Outlet]) -> Option<fn(&Room) -> String> {
    outlets.iter().find_map(|outlet| twin(outlet)?.calibration)
}

/// Text of the spectroradiometer's calibration, of the one among `outlets`; none where it keeps its own.
pub fn calibration(room: &Room, outlets: &[Outlet]) -> Option<String> {
    calibrated(outlets).map(|write| write(room))
}

/// Text of the responsivity of the lux meter's head, as an institute measures it; none for a head that is V(λ).
pub fn responsivity(document: &Darkroom) -> Option<String> {
    let meter = &document.luxmeter;
    let row = |step: i32| {
        let nm = 360.0 + 5.0 * f64::from(step);
        format!("{nm:.0},{:.6},0.005\n", head::responsivity(meter, nm))
    };
    let rows = || (0..=94).map(row).collect::<String>();
    (!head::is_perfect(meter)).then(|| format!("wavelength_nm,responsivity,u_rel\n{}", rows()))
}

/// A positive number to two digits.
fn two_digits(value: f64) -> f64 {
    let unit = 10_f64.powf(value.log10().floor() - 1.0);
    (value / unit).round() * unit
}

fn axis(name: &str, axis: &Axis, open: &str) -> String {
    let [low, high] = axis.limit_deg;
    format!(
        "\n[axis.{name}]\nopen = \"{open}\"\ncounts_per_deg = \"{}/{}\"\nzero_deg = 0.0\nsense = 1\n\
         limit_deg = [{low:.1}, {high:.1}]\nspeed_deg_s = {:?}\naccel_deg_s2 = {:?}\n",
        axis.counts_per_deg.numerator, axis.counts_per_deg.denominator, axis.speed_deg_s, axis.accel_deg_s2
    )
}
