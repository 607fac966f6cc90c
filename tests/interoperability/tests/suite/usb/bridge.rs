//! Compiles the bridge and starts programs below it.
#![allow(clippy::print_stderr, reason = "a skipped test says so")]

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;
use std::time::Duration;

use isolux_usbip::{Bench, Twin};
use tokio::io::{AsyncBufReadExt, AsyncWriteExt, BufReader, Lines};
use tokio::process::{Child, ChildStdin, ChildStdout};

/// The compiled bridge; `None` where umockdev is missing, which fails where `ISOLUX_NO_SKIP` is set.
pub fn bridge() -> Option<PathBuf> {
    static BRIDGE: OnceLock<Option<PathBuf>> = OnceLock::new();
    let found = BRIDGE.get_or_init(|| if cfg!(target_os = "linux") { compile() } else { None });
    if found.is_none() {
        let reason = "no umockdev here (Debian: apt-get install libumockdev-dev umockdev pkg-config gcc)";
        assert!(std::env::var_os("ISOLUX_NO_SKIP").is_none(), "{reason}");
        eprintln!("skipped: {reason}");
    }
    found.clone()
}

fn compile() -> Option<PathBuf> {
    let flags = Command::new("pkg-config")
        .args(["--cflags", "--libs", "umockdev-1.0"])
        .output()
        .ok()?;
    if !flags.status.success() {
        return None;
    }
    let flags = String::from_utf8(flags.stdout).ok()?;
    let bridge = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("bridge-{}", std::process::id()));
    let source = concat!(env!("CARGO_MANIFEST_DIR"), "/bridge.c");
    let compiled = Command::new("cc")
        .args(["-O1", "-Wall", "-Wextra", "-Werror", source, "-o"])
        .arg(&bridge)
        .args(flags.split_whitespace())
        .output()
        .expect("a C compiler");
    assert!(
        compiled.status.success(),
        "{}",
        String::from_utf8_lossy(&compiled.stderr)
    );
    Some(bridge)
}

/// Offers devices on a free port.
pub async fn offered(twins: Vec<Twin>) -> u16 {
    let bench = Bench::bind(0, twins).await.expect("a port");
    let port = bench.address().expect("an address").port();
    tokio::spawn(bench.serve());
    port
}

/// A command line below the bridge, with the first device of `port` in this socket.
pub fn below(bridge: &Path, port: u16, socket: u8, program: impl AsRef<OsStr>) -> tokio::process::Command {
    let mut command = tokio::process::Command::new(bridge);
    command
        .args([&port.to_string(), "1-1", &socket.to_string()])
        .arg(program);
    command.env("LD_PRELOAD", "libumockdev-preload.so.0").kill_on_drop(true);
    command
}

/// The client of this crate below the bridge.
pub struct Below {
    _process: Child,
    questions: ChildStdin,
    answers: Lines<BufReader<ChildStdout>>,
}

impl Below {
    /// Starts it.
    pub fn start(bridge: &Path, port: u16) -> Self {
        Self::start_in_socket(bridge, port, 1)
    }

    /// Starts it with its device in this socket, which one process may own.
    pub fn start_in_socket(bridge: &Path, port: u16, socket: u8) -> Self {
        let mut process = below(bridge, port, socket, env!("CARGO_BIN_EXE_isolux-usb-client"))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("the bridge starts");
        let questions = process.stdin.take().expect("a pipe");
        let answers = BufReader::new(process.stdout.take().expect("a pipe")).lines();
        Self {
            _process: process,
            questions,
            answers,
        }
    }

    /// One line, and the line that answers it.
    pub async fn ask(&mut self, line: &str) -> String {
        self.questions
            .write_all(format!("{line}\n").as_bytes())
            .await
            .expect("it reads");
        let answer = tokio::time::timeout(Duration::from_mins(1), self.answers.next_line()).await;
        answer
            .expect("an answer within a minute")
            .expect("text")
            .expect("it is still running")
    }
}
