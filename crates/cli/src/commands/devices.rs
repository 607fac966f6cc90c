//! `isolux devices`.

use clap::Args;
use isolux_app::Failure;
use isolux_app::instruments::{devices, identify};

use crate::screen::{self, Bars};

/// Drivers, found ports, what is missing and what to do about it.
#[derive(Debug, Args)]
#[command(after_help = "Example: isolux devices --json\n\
Nothing is sent to any port, but to those named after --identify: each is asked with the line settings of every \
language for what its instruments say of themselves. Nothing is set and nothing moves; a T-10A goes into its PC mode. \
`isolux check STATION.toml` talks to the instruments of a station.")]
pub struct Devices {
    /// Ask these ports which instrument is there: serial ports or tcp://host:port.
    #[arg(long, value_name = "PORT", num_args = 1..)]
    identify: Vec<String>,
    /// One JSON object.
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(arguments: &Devices) -> Result<(), Failure> {
    if !arguments.identify.is_empty() {
        return ask(&arguments.identify, arguments.json);
    }
    let found = devices::devices()?;
    if arguments.json {
        screen::say(serde_json::to_string(&found).map_err(Failure::instrument)?)?;
        return Ok(());
    }
    screen::say("drivers")?;
    for driver in &found.drivers {
        screen::say(format_args!(
            "  {:12} {} ({})",
            driver.name,
            driver.speaks_to,
            driver.kinds.join(", ")
        ))?;
        screen::say(format_args!("  {:12} seen with: {}", "", driver.seen_with))?;
        for example in &driver.examples {
            screen::say(format_args!("  {:12} open = \"{example}\"", ""))?;
        }
    }
    screen::say(if found.ports.is_empty() {
        "serial ports: none found"
    } else {
        "serial ports"
    })?;
    for port in &found.ports {
        let usb = port.usb.as_ref().map_or(String::new(), |usb| format!(" {usb}"));
        let serial = port
            .serial
            .as_ref()
            .map_or(String::new(), |serial| format!(" serial {serial}"));
        screen::say(format_args!("  {:12} {}{usb}{serial}", port.path, port.description))?;
        wanting(port.missing.as_deref(), port.remedy.as_deref())?;
    }
    for device in &found.usb {
        screen::say(format_args!(
            "  USB {} {} {}",
            device.id,
            device.what,
            device.serial.as_deref().unwrap_or("")
        ))?;
        wanting(device.missing.as_deref(), device.remedy.as_deref())?;
    }
    Ok(())
}

/// Asks the ports; exit 3 where one could not be asked.
fn ask(ports: &[String], json: bool) -> Result<(), Failure> {
    let requested = identify::identify(ports, &Bars::default())?;
    for port in &requested {
        if json {
            screen::say(serde_json::to_string(port).map_err(Failure::instrument)?)?;
            continue;
        }
        screen::say(&port.port)?;
        for found in &port.found {
            screen::say(format_args!("  {:16} {} ({})", found.driver, found.says, found.line))?;
        }
        if port.found.is_empty() && port.error.is_none() {
            screen::say("  nobody answered; check power, cable and the line settings of the instrument")?;
        }
        if let Some(error) = &port.error {
            screen::say(format_args!("  {:16} {error}", "error"))?;
        }
        for tried in &port.tried {
            screen::say(format_args!("  {:16} {tried}", "asked with"))?;
        }
    }
    let not_asked: Vec<&str> = requested
        .iter()
        .filter(|port| port.error.is_some())
        .map(|port| port.port.as_str())
        .collect();
    if not_asked.is_empty() {
        return Ok(());
    }
    Err(Failure::instrument(format_args!(
        "could not be asked: {}; the reasons stand beside the ports",
        not_asked.join(", ")
    )))
}

fn wanting(missing: Option<&str>, remedy: Option<&str>) -> Result<(), Failure> {
    if let Some(missing) = missing {
        screen::say(format_args!("  {:12} missing: {missing}", ""))?;
    }
    if let Some(remedy) = remedy {
        screen::say(format_args!("  {:12} what to do: {remedy}", ""))?;
    }
    Ok(())
}
