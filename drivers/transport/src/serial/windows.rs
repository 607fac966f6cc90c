//! COM ports. Windows gives a port to one program at a time.

use std::fs::{File, OpenOptions};
use std::io;
use std::os::windows::fs::OpenOptionsExt as _;
use std::time::Duration;

use tokio::time::{Instant, sleep};
use tokio_serial::{SerialPortBuilder, SerialPortBuilderExt as _, SerialStream};

use super::com_name;

/// How long a program that has lost its instruments to `isolux stop` may take to notice it and to end.
const LET_GO: Duration = Duration::from_secs(5);
const BETWEEN_TRIES: Duration = Duration::from_millis(50);

const ERROR_ACCESS_DENIED: i32 = 5;
const ERROR_SHARING_VIOLATION: i32 = 32;

/// The one name of a port, whatever it is called by.
pub(crate) fn one_name(path: &str) -> String {
    com_name(path).unwrap_or_else(|| path.to_owned())
}

/// Windows has no pseudo-terminals that could be opened as ports.
pub(super) fn is_pty(_: &str) -> bool {
    false
}

/// Opens a port; `alone` = false waits until its former owner lets go of it, because two programs cannot have it open.
pub(super) async fn open(builder: SerialPortBuilder, path: &str, alone: bool) -> tokio_serial::Result<SerialStream> {
    // The library puts `\\\\.\\` before whatever it is given.
    let builder = builder.path(one_name(path));
    let deadline = Instant::now() + if alone { Duration::ZERO } else { LET_GO };
    loop {
        match builder.clone().open_native_async() {
            Err(_) if Instant::now() < deadline && is_busy(path) => sleep(BETWEEN_TRIES).await,
            opened => return opened,
        }
    }
}

/// Whether another program has a port that could not be opened.
pub(super) fn is_busy(path: &str) -> bool {
    probe(path).is_err_and(|error| error.kind() == io::ErrorKind::ResourceBusy)
}

/// Opens the port and closes it again; no line setting is touched.
///
/// # Errors
/// What the system says; `ResourceBusy` for a port that another program has.
pub(crate) fn probe(path: &str) -> io::Result<()> {
    let mut options = OpenOptions::new();
    // A port cannot be shared (CreateFileW, "Communications Resources").
    options.read(true).write(true).share_mode(0);
    let opened = options.open(format!(r"\\.\{}", one_name(path))).map(|_: File| ());
    opened.map_err(|error| match error.raw_os_error() {
        Some(ERROR_ACCESS_DENIED | ERROR_SHARING_VIOLATION) => io::Error::new(io::ErrorKind::ResourceBusy, error),
        _ => error,
    })
}

/// What to do about a port that does not open.
pub(crate) fn advice(kind: io::ErrorKind) -> Option<&'static str> {
    match kind {
        io::ErrorKind::NotFound => Some(
            "no such port: `isolux devices` lists those found, the Device Manager too; check cable, power and the \
             adapter's driver",
        ),
        io::ErrorKind::ResourceBusy => Some(
            "close the program that uses it (isolux: press Ctrl-C in its window, which stops the axes), then start \
             again",
        ),
        _ => None,
    }
}
