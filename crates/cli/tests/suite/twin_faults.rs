//! Faults that are switched on while a twin serves as a process, by lines on its standard input.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

/// PC mode, the first thing that a T-10A is asked.
const PC_MODE: &[u8] = b"\x0200541   \x0313\r\n";

/// Ends the twin with the test.
struct Twin(Child);

impl Drop for Twin {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// What the twin answers; none where it hangs up.
fn requested(link: &mut TcpStream) -> Option<[u8; 14]> {
    let mut answer = [0; 14];
    link.write_all(PC_MODE).ok()?;
    link.read_exact(&mut answer).ok()?;
    Some(answer)
}

#[test]
fn a_line_on_standard_input_is_a_fault_from_then_on() {
    let mut twin = Twin(
        Command::new(env!("CARGO_BIN_EXE_isolux"))
            .args([
                "virtual",
                "luxmeter",
                "--tcp",
                "0",
                "--json",
                "--faults",
                "--lasts-s",
                "120",
            ])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap(),
    );
    let mut first = String::new();
    let mut stated = BufReader::new(twin.0.stdout.take().unwrap());
    stated.read_line(&mut first).unwrap();
    let (_, address) = first.split_once("tcp://").unwrap_or_else(|| panic!("{first}"));
    let address = address.split('"').next().unwrap();
    let mut notes = BufReader::new(twin.0.stderr.take().unwrap());
    let mut orders = twin.0.stdin.take().unwrap();
    // What it says to a line is said once the line has its effect.
    let mut order = |line: &str| {
        writeln!(orders, "{line}").unwrap();
        let mut note = String::new();
        notes.read_line(&mut note).unwrap();
        note
    };
    let connect = || {
        let link = TcpStream::connect(address).unwrap();
        link.set_read_timeout(Some(Duration::from_mins(1))).unwrap();
        link
    };
    let mut link = connect();
    assert!(requested(&mut link).is_some_and(|answer| answer.starts_with(b"\x020054")));
    let note = order("luxmeter disconnect");
    assert!(note.contains("luxmeter disconnect"), "{note}");
    assert_eq!(requested(&mut link), None, "the link ends");
    assert_eq!(requested(&mut connect()), None, "and stays lost");
    for (line, word) in [
        ("luxmeter burn", "flip_bit"),
        ("luxmeter alarm", "one of axes"),
        ("meter late", "spectroradiometer"),
    ] {
        let note = order(line);
        assert!(note.contains(word), "{line}: {note}");
    }
    order("clear");
    assert!(requested(&mut connect()).is_some(), "all faults have ended");
}
