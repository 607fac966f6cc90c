//! Serial ports as files below `/dev`.

use std::fs::{File, OpenOptions};
use std::io;
use std::os::unix::fs::OpenOptionsExt as _;
use std::path::Path;

use tokio_serial::{SerialPortBuilder, SerialPortBuilderExt as _, SerialStream};

/// The one name of a port, whatever it is called by: links are followed.
pub(crate) fn one_name(path: &str) -> String {
    // A port that is not there has no other names.
    let real = std::fs::canonicalize(path).map_or_else(|_| path.to_owned(), |real| real.display().to_string());
    // macOS has two names for the same port.
    match real.strip_prefix("/dev/cu.") {
        Some(port) if cfg!(target_os = "macos") => format!("/dev/tty.{port}"),
        _ => real,
    }
}

/// Whether it is a pseudo-terminal.
pub(super) fn is_pty(path: &str) -> bool {
    std::fs::canonicalize(path).is_ok_and(|real| real.starts_with("/dev/pts") || real.starts_with("/dev/ttys"))
}

#[expect(clippy::unused_async, reason = "on Windows it may take a while")]
pub(super) async fn open(builder: SerialPortBuilder, _path: &str, alone: bool) -> tokio_serial::Result<SerialStream> {
    let mut port = builder.exclusive(alone).open_native_async()?;
    // That nobody else uses it was seen on opening. From now on `isolux stop` must be able to open it too; programs
    // that lock the port (flock) are kept away still.
    port.set_exclusive(false)?;
    Ok(port)
}

/// Whether a port that could not be opened, as if it was not there, is there (EBUSY of TIOCEXCL, flock).
pub(super) fn is_busy(path: &str) -> bool {
    Path::new(path).exists()
}

/// Opens the file and closes it again; no line setting is touched.
///
/// # Errors
/// What the system says.
pub(crate) fn probe(path: &str) -> io::Result<()> {
    // O_NONBLOCK (Linux 0o4000, macOS 0x4): without it the open waits for a modem's carrier.
    let nonblocking = if cfg!(target_os = "macos") { 0x4 } else { 0o4000 };
    let mut options = OpenOptions::new();
    options.read(true).write(true).custom_flags(nonblocking);
    options.open(path).map(|_: File| ())
}

/// What to do about a port that does not open.
pub(crate) fn advice(kind: io::ErrorKind) -> Option<&'static str> {
    match kind {
        io::ErrorKind::PermissionDenied => Some(
            "this account may not use the port: join its group (Debian: sudo usermod -aG dialout $USER), then log in \
             again",
        ),
        io::ErrorKind::NotFound => Some("no such port: `isolux devices` lists those found; check cable and power"),
        io::ErrorKind::ResourceBusy => {
            Some("close the program that uses it (a terminal, a modem manager), then start again")
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_port_that_this_account_may_not_use_names_its_group() {
        let advice = advice(io::ErrorKind::PermissionDenied).unwrap();
        assert!(
            advice.contains("dialout") && advice.contains("log in again"),
            "{advice}"
        );
    }
}
