//! `isolux virtual`.

use std::time::Duration;

use camino::Utf8PathBuf;
use clap::{Args, Subcommand, ValueEnum};
use isolux_app::Failure;
use isolux_app::darkroom::capture::{self, CaptureUnit, Series};
use isolux_app::darkroom::twins::{self, Twins};
use isolux_app::files::Overwrite;
use isolux_app::init::Instruments;

use crate::screen;

/// The virtual darkroom: twins of the instruments, and what a camera there would record.
#[derive(Debug, Args)]
pub struct Virtual {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    /// All instruments of one virtual room, until interrupted.
    Darkroom(Serve),
    /// The axes' controller with its outputs for lamp, shutter and baffle.
    Axis(Serve),
    /// The lux meter, under a lit lamp.
    Luxmeter(Serve),
    /// The spectroradiometer, under a lit lamp.
    Spectroradiometer(Serve),
    /// The power meter, with the lamp on.
    Powermeter(Serve),
    /// The lamp's supply.
    Supply(Serve),
    /// An oscilloscope with a photodiode that sees the lamp, which is on.
    Oscilloscope(Serve),
    Capture(Capture),
}

/// Serves twins until interrupted.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: isolux virtual darkroom darkroom.toml --tcp 0 --station-out station.toml\n\
Each twin is offered on a pty, or with --tcp on the loopback address. A darkroom.toml holds the seed, the lamp, the \
instruments, their faults and their injected effects; without one it is the built-in darkroom. Ends with 130 when \
interrupted.\n\n\
With --faults, lines on standard input are faults from then on: `luxmeter silent`, `luxmeter late delay_s=0.8 for_s=10`, \
`axes flip_bit probability=0.2 for_s=60`, `axes stall at_s=5`. Kinds: drop_byte, flip_bit, wrong_digit, late, double, silent, \
disconnect; stall, alarm (axes); saturate (meters). Without for_s a fault happens once; disconnect and saturate last. `clear` ends all of them."
)]
struct Serve {
    /// The room; without it the built-in one.
    darkroom: Option<Utf8PathBuf>,
    /// Offer the twins over TCP from this port on (0: any free port).
    #[arg(long, value_name = "PORT")]
    tcp: Option<u16>,
    /// Offer the spectroradiometer as a USB device over USB/IP on this port (0: any free port); a kernel with vhci-hcd
    /// attaches it.
    #[arg(long, value_name = "PORT")]
    usbip: Option<u16>,
    /// Write a station file for these twins, and the spectroradiometer's calibration beside it.
    #[arg(long, value_name = "FILE")]
    station_out: Option<Utf8PathBuf>,
    /// Serve nothing: the station of --station-out keeps the room in the memory of the process that opens it, in
    /// virtual time.
    #[arg(long, requires = "station_out", conflicts_with_all = ["tcp", "usbip", "faults", "lasts_s"])]
    in_memory: bool,
    /// Take faults while the twins serve, one a line on standard input.
    #[arg(long)]
    faults: bool,
    /// End by itself after this many seconds.
    #[arg(long, value_name = "SECONDS")]
    lasts_s: Option<f64>,
    /// One JSON object a twin.
    #[arg(long)]
    json: bool,
    /// Replace an existing station file.
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    played: Played,
}

/// Which twins play the instruments of the room; `isolux devices` lists the drivers.
#[derive(Debug, Args)]
pub struct Played {
    /// Driver whose twin plays the axes.
    #[arg(long, value_name = "DRIVER")]
    axes: Option<String>,
    /// Driver whose twin plays the lux meter.
    #[arg(long, value_name = "DRIVER")]
    luxmeter: Option<String>,
    /// Driver whose twin plays the spectroradiometer.
    #[arg(long, value_name = "DRIVER")]
    spectroradiometer: Option<String>,
    /// Driver whose twin plays a power meter; without it the room has none.
    #[arg(long, value_name = "DRIVER")]
    powermeter: Option<String>,
    /// Driver whose twin plays a supply that feeds the lamp; without it the lamp is switched by an output.
    #[arg(long, value_name = "DRIVER")]
    supply: Option<String>,
}

impl Played {
    /// As the use cases take them.
    pub fn instruments(&self) -> Instruments {
        Instruments {
            axes: self.axes.clone(),
            luxmeter: self.luxmeter.clone(),
            spectroradiometer: self.spectroradiometer.clone(),
            powermeter: self.powermeter.clone(),
            supply: self.supply.clone(),
            in_motion: false,
            colour: false,
        }
    }
}

/// What a camera in the virtual darkroom records: maps.toml and maps.csv.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: isolux virtual capture darkroom.toml scene.toml --out maps.toml --designed\n\
SCENE is a scene, or a maps.toml whose poses are taken. The lamp is computed LED by LED; the scene's model is not used."
)]
struct Capture {
    /// The room.
    darkroom: Utf8PathBuf,
    /// A scene, or a maps.toml with poses.
    scene: Utf8PathBuf,
    /// The maps.toml to write; the values go to the .csv beside it.
    #[arg(long)]
    out: Utf8PathBuf,
    /// Unit of the maps of a scene (a maps.toml has its own).
    #[arg(long, value_enum, default_value = "relative")]
    unit: UnitName,
    /// Bins along x and y: N or N,M; as many as pixels, at most 64, when left out.
    #[arg(long, value_delimiter = ',', num_args = 1..=2, value_name = "N[,M]")]
    bins: Vec<usize>,
    /// Nine exposures about the scene's pose: half exposure, nearer, tilted, turned, lamp off, capped.
    #[arg(long, conflicts_with_all = ["lamp_off", "capped"])]
    designed: bool,
    /// With the lamp off.
    #[arg(long)]
    lamp_off: bool,
    /// With the cap on.
    #[arg(long)]
    capped: bool,
    /// Relative exposure of the scene's pose.
    #[arg(long, default_value_t = 1.0)]
    exposure: f64,
    /// One JSON object.
    #[arg(long)]
    json: bool,
    /// Replace existing files.
    #[arg(long)]
    force: bool,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum UnitName {
    /// Relative to the camera's full scale.
    Relative,
    /// Illuminance in lx.
    Lx,
    /// Irradiance in W/m².
    #[value(name = "W/m2")]
    WattPerSquareMetre,
}

/// Runs the command.
pub fn run(arguments: &Virtual) -> Result<(), Failure> {
    match &arguments.what {
        What::Darkroom(serving) => serve(serving, Twins::All),
        What::Axis(serving) => serve(serving, Twins::Axes),
        What::Luxmeter(serving) => serve(serving, Twins::LuxMeter),
        What::Spectroradiometer(serving) => serve(serving, Twins::Spectroradiometer),
        What::Powermeter(serving) => serve(serving, Twins::PowerMeter),
        What::Supply(serving) => serve(serving, Twins::Supply),
        What::Oscilloscope(serving) => serve(serving, Twins::Oscilloscope),
        What::Capture(capturing) => capture(capturing),
    }
}

fn serve(arguments: &Serve, twins: Twins) -> Result<(), Failure> {
    if let (true, Some(station)) = (arguments.in_memory, &arguments.station_out) {
        if twins != Twins::All {
            return Err(Failure::bad_input("--in-memory is for a whole darkroom"));
        }
        twins::write_in_memory(
            arguments.darkroom.as_deref(),
            &arguments.played.instruments(),
            station,
            Overwrite::requested(arguments.force),
            &screen::Bars::default(),
        )?;
        screen::say(format_args!("{:18} {station}", "station"))?;
        return Ok(());
    }
    let lasts = match arguments.lasts_s {
        Some(seconds) => Some(
            Duration::try_from_secs_f64(seconds)
                .map_err(|_| Failure::bad_input(format!("--lasts-s {seconds} is no number of seconds")))?,
        ),
        None => None,
    };
    let requested = twins::Options {
        darkroom: arguments.darkroom.clone(),
        twins,
        instruments: arguments.played.instruments(),
        tcp_port: arguments.tcp,
        usbip_port: arguments.usbip,
        station_out: arguments.station_out.clone(),
        overwrite: Overwrite::requested(arguments.force),
        faults: arguments.faults,
        lasts,
    };
    twins::serve(&requested, &screen::Bars::default(), |reachable| {
        for twin in reachable {
            match serde_json::to_string(twin) {
                Ok(line) if arguments.json => screen::say(line)?,
                _ => screen::say(format_args!("{:18} {}", twin.instrument, twin.open))?,
            }
            if let Some(attach) = twin.attach.as_ref().filter(|_| !arguments.json) {
                screen::say(format_args!("{:18} modprobe vhci-hcd; {attach}", ""))?;
            }
        }
        if let Some(path) = &arguments.station_out
            && !arguments.json
        {
            screen::say(format_args!("{:18} {path}", "station"))?;
        }
        Ok(())
    })
}

fn capture(arguments: &Capture) -> Result<(), Failure> {
    let bins = match arguments.bins[..] {
        [] => None,
        [both] => Some([both, both]),
        [x, y, ..] => Some([x, y]),
    };
    if bins.is_some_and(|bins| bins.contains(&0)) {
        return Err(Failure::bad_input("--bins must be above zero"));
    }
    let requested = capture::Options {
        unit: match arguments.unit {
            UnitName::Relative => CaptureUnit::Relative,
            UnitName::Lx => CaptureUnit::Lux,
            UnitName::WattPerSquareMetre => CaptureUnit::WattPerSquareMetre,
        },
        bins,
        series: if arguments.designed {
            Series::Designed
        } else {
            Series::Single {
                lamp: !arguments.lamp_off,
                capped: arguments.capped,
            }
        },
        exposure: arguments.exposure,
        overwrite: Overwrite::requested(arguments.force),
    };
    let bars = screen::Bars::default();
    let captured = capture::capture(&arguments.darkroom, &arguments.scene, &arguments.out, &requested, &bars)?;
    if arguments.json {
        let facts = serde_json::json!({ "maps": captured.maps, "bins": captured.bins, "unit": captured.unit, "mean": captured.mean });
        screen::say(facts)?;
        return Ok(());
    }
    for (name, mean) in captured.maps.iter().zip(&captured.mean) {
        screen::say(format_args!("{name:12} mean {mean:.5} {}", captured.unit))?;
    }
    screen::say(format_args!(
        "{} with {} × {} bins a map",
        arguments.out, captured.bins[0], captured.bins[1]
    ))?;
    Ok(())
}
