//! `isolux devices`.

use clap::Args;
use isolux_app::Failure;
use isolux_app::devices;

use crate::screen;

/// Drivers, found ports, what is missing and how to mend it.
#[derive(Debug, Args)]
#[command(after_help = "Example: isolux devices --json\n\
Nothing is sent to any port. `isolux check STATION.toml` talks to the instruments.")]
pub struct Devices {
    /// One JSON object.
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(arguments: &Devices) -> Result<(), Failure> {
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
        wanting(port.missing.as_deref(), port.mend.as_deref())?;
    }
    for device in &found.usb {
        screen::say(format_args!(
            "  USB {} {} {}",
            device.id,
            device.what,
            device.serial.as_deref().unwrap_or("")
        ))?;
        wanting(device.missing.as_deref(), device.mend.as_deref())?;
    }
    Ok(())
}

fn wanting(missing: Option<&str>, mend: Option<&str>) -> Result<(), Failure> {
    if let Some(missing) = missing {
        screen::say(format_args!("  {:12} missing: {missing}", ""))?;
    }
    if let Some(mend) = mend {
        screen::say(format_args!("  {:12} to mend it: {mend}", ""))?;
    }
    Ok(())
}
