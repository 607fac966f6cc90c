//! Programs of others. Where they are missing a test says that it was skipped, and fails where `ISOLUX_NO_SKIP` is set.

#![allow(clippy::print_stderr, reason = "a skipped test says so")]

use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::Duration;

use tokio::io::{AsyncBufReadExt, BufReader, Lines};
use tokio::process::{Child, ChildStdout, Command};

/// A program that runs, and what it says.
pub struct Peer {
    stated: Lines<BufReader<ChildStdout>>,
    _child: Child,
}

impl Peer {
    /// The next line that it says.
    pub async fn line(&mut self) -> String {
        let line = tokio::time::timeout(Duration::from_secs(30), self.stated.next_line()).await;
        line.expect("it says something within 30 s")
            .unwrap()
            .expect("it goes on")
    }
}

fn missing(what: &str) {
    assert!(std::env::var_os("ISOLUX_NO_SKIP").is_none(), "{what}");
    eprintln!("skipped 1 test: {what}");
}

/// The Python that has the pinned packages.
pub fn python() -> Option<PathBuf> {
    let home = Path::new(env!("CARGO_TARGET_TMPDIR")).join("../peers-python");
    let installed = std::fs::read_to_string(home.join("requirements.txt"));
    if installed.is_ok_and(|installed| installed == include_str!("../../../peers/requirements.txt")) {
        return Some(home.join("bin/python"));
    }
    missing("not all Python packages are here (tests/peers/python.sh installs them)");
    None
}

fn script(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../peers").join(name)
}

/// `tests/peers/modbus.py` as a server.
pub fn pymodbus(arguments: &[&str]) -> Option<Peer> {
    let mut child = Command::new(python()?)
        .args(["-W", "ignore"])
        .arg(script("modbus.py"))
        .args(arguments)
        .stdout(Stdio::piped())
        .kill_on_drop(true)
        .spawn()
        .unwrap();
    let stated = BufReader::new(child.stdout.take().unwrap()).lines();
    Some(Peer { stated, _child: child })
}

/// `tests/peers/modbus.py` as a client: all that it says.
pub async fn pymodbus_says(arguments: &[&str]) -> Option<String> {
    python_says("modbus.py", arguments).await.map(Result::unwrap)
}

/// What a script of `tests/peers` says as a client: its output, or where it failed what it had against it.
pub async fn python_says(name: &str, arguments: &[&str]) -> Option<Result<String, String>> {
    let mut command = Command::new(python()?);
    command.args(["-W", "ignore"]).arg(script(name)).args(arguments);
    Some(stated(command).await)
}

/// What `mbpoll` says.
pub async fn mbpoll(arguments: &[&str]) -> Option<String> {
    if std::process::Command::new("mbpoll").arg("-V").output().is_err() {
        missing("no mbpoll here (Debian: apt-get install mbpoll)");
        return None;
    }
    let mut command = Command::new("mbpoll");
    command.args(arguments);
    Some(stated(command).await.unwrap())
}

async fn stated(mut command: Command) -> Result<String, String> {
    let output = tokio::time::timeout(Duration::from_mins(1), command.kill_on_drop(true).output()).await;
    let output = output.expect("it ends within 60 s").unwrap();
    let stated = String::from_utf8_lossy(&output.stdout).into_owned();
    if output.status.success() {
        return Ok(stated);
    }
    Err(stated + &String::from_utf8_lossy(&output.stderr))
}
