//! Serial ports of this computer: their names, what opens them, what their errors mean.

#[cfg_attr(unix, path = "unix.rs")]
#[cfg_attr(windows, path = "windows.rs")]
mod system;

use std::io;

use tokio_serial::SerialStream;

use crate::users::users_of;
use crate::{LineSettings, LinkError, Parity};

pub(crate) use system::{advice, one_name, probe};

/// Opens a port that no other program uses, unless it is opened `alone` = false.
///
/// # Errors
/// [`LinkError`] with what to do.
pub(crate) async fn open(path: &str, line: LineSettings, alone: bool) -> Result<SerialStream, LinkError> {
    let failed = |reason: String, advice: Option<String>| LinkError {
        address: path.to_owned(),
        reason,
        advice,
    };
    // A pseudo-terminal carries whole bytes and nothing else: asked for parity, it refuses or ignores it.
    let line = if system::is_pty(path) {
        LineSettings {
            data_bits: 8,
            parity: Parity::None,
            stop_bits: 1,
            ..line
        }
    } else {
        line
    };
    let data_bits = match line.data_bits {
        7 => tokio_serial::DataBits::Seven,
        8 => tokio_serial::DataBits::Eight,
        other => return Err(failed(format!("{other} data bits are not supported"), None)),
    };
    let stop_bits = match line.stop_bits {
        1 => tokio_serial::StopBits::One,
        2 => tokio_serial::StopBits::Two,
        other => return Err(failed(format!("{other} stop bits are not supported"), None)),
    };
    let parity = match line.parity {
        Parity::None => tokio_serial::Parity::None,
        Parity::Even => tokio_serial::Parity::Even,
        Parity::Odd => tokio_serial::Parity::Odd,
    };
    let builder = tokio_serial::new(path, line.baud)
        .data_bits(data_bits)
        .stop_bits(stop_bits)
        .parity(parity);
    system::open(builder, path, alone).await.map_err(|error| {
        let kind = match error.kind {
            // What the library says of a port that another program has, too.
            tokio_serial::ErrorKind::NoDevice if system::is_busy(path) => io::ErrorKind::ResourceBusy,
            tokio_serial::ErrorKind::NoDevice => io::ErrorKind::NotFound,
            tokio_serial::ErrorKind::Io(kind) => kind,
            _ => io::ErrorKind::Other,
        };
        let reason = match kind {
            io::ErrorKind::ResourceBusy => busy(path),
            _ => error.to_string(),
        };
        failed(reason, advice(kind).map(str::to_owned))
    })
}

/// That a port is busy, and who uses it where that can be known.
pub(crate) fn busy(path: &str) -> String {
    match users_of(path) {
        users if users.is_empty() => "the port is busy: another program has it open".to_owned(),
        users => format!("the port is busy: {} has it open", users.join(", ")),
    }
}

/// The name of a COM port without what a person may put before it (`\\.\COM12`), in capitals; none for anything else.
#[cfg(any(windows, test))]
fn com_name(path: &str) -> Option<String> {
    let bare = [r"\\.\", r"\\?\"].iter().find_map(|prefix| path.strip_prefix(prefix));
    let name = bare.unwrap_or(path).to_ascii_uppercase();
    let number = name.strip_prefix("COM")?;
    (!number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit())).then_some(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_com_port_has_one_name_however_it_is_written() {
        for written in ["COM12", "com12", r"\\.\COM12", r"\\?\com12"] {
            assert_eq!(com_name(written).as_deref(), Some("COM12"), "{written}");
        }
        for other in ["/dev/ttyUSB0", "COM", "COMX", "COM1:", r"\\.\CNCA0", r"\\server\COM1"] {
            assert_eq!(com_name(other), None, "{other}");
        }
    }
}
