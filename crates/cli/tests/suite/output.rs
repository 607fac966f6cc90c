//! Standard output that takes nothing more: a command that cannot say what it found does not end as if it had.

#![cfg(unix)]

use std::fs::OpenOptions;
use std::io::{BufRead, BufReader};
use std::process::Stdio;

use crate::folder::Folder;

fn files() -> Folder {
    let folder = Folder::new();
    folder.write("lamp.csv", "gamma_deg,intensity_cd\n0,300\n30,200\n90,0\n");
    folder.write(
        "model.toml",
        "format = \"isolux-model/1\"\n[luminaire]\ndistribution = \"lamp.csv\"\n",
    );
    folder.write(
        "scene.toml",
        "format = \"isolux-scene/1\"\nmodel = \"model.toml\"\n[sensor]\nsize_mm = 20\npixels = 4\ndistance_mm = 500\n",
    );
    folder.isolux(&["init", "bench"], 0);
    folder
}

#[test]
fn a_full_disk_behind_standard_output_is_exit_3_with_a_message() {
    let folder = files();
    for arguments in [
        &["--help"][..],
        &["--version"],
        &["inspect", "lamp.csv"],
        &["inspect", "lamp.csv", "--json"],
        &["convert", "lamp.csv", "lamp.ldt"],
        &["devices"],
        &["check", "bench/station.toml"],
        &["plan", "bench/station.toml", "bench/plan.toml"],
        &["simulate", "scene.toml", "--out", "lit"],
        &["simulate", "scene.toml", "--out", "lit-2", "--json"],
        &["init", "other"],
        &["read", "bench/station.toml"],
        &["virtual", "darkroom", "--in-memory", "--station-out", "s.toml"],
        &["virtual", "darkroom", "--tcp", "0", "--lasts-s", "0.1"],
    ] {
        let full = OpenOptions::new().write(true).open("/dev/full").unwrap();
        let output = folder.command(arguments).stdout(full).output().unwrap();
        let stated = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(3), "{arguments:?}: {stated}");
        assert!(
            stated.contains("cannot write to standard output"),
            "{arguments:?}: {stated}"
        );
    }
}

#[test]
fn a_reader_that_goes_ends_the_command_quietly() {
    let folder = files();
    let names: Vec<String> = (0..200).map(|k| format!("lamp-{k}.csv")).collect();
    for name in &names {
        std::fs::copy(folder.path("lamp.csv"), folder.path(name)).unwrap();
    }
    let arguments: Vec<&str> = std::iter::once("inspect")
        .chain(names.iter().map(String::as_str))
        .collect();
    let mut child = folder
        .command(&arguments)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // `head -1`.
    let mut first = String::new();
    BufReader::new(child.stdout.take().unwrap())
        .read_line(&mut first)
        .unwrap();
    assert!(first.starts_with("lamp-0.csv: "), "{first}");
    let output = child.wait_with_output().unwrap();
    let stated = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), stated.as_str()), (Some(141), ""));
}

#[test]
fn verbose_shows_the_bytes_of_the_links_and_a_wrong_filter_is_bad_input() {
    let folder = Folder::new();
    folder.isolux(&["init", "bench"], 0);
    let log = |arguments: &[&str], filter: &str, code: i32| {
        let output = folder.command(arguments).env("ISOLUX_LOG", filter).output().unwrap();
        let stated = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(code), "{arguments:?} {filter}: {stated}");
        stated
    };
    // 00100200 is the request of a reading of head 00 of a T-10A (communication specifications, command 10).
    let bytes = log(&["-vv", "read", "bench/station.toml"], "", 0);
    assert!(
        bytes.contains("sent") && bytes.contains("00100200") && bytes.contains("received"),
        "{bytes}"
    );
    let by_variable = log(&["read", "bench/station.toml"], "trace", 0);
    assert!(by_variable.contains("00100200"), "{by_variable}");
    let plain = log(&["read", "bench/station.toml"], "", 0);
    assert!(!plain.contains("received"), "{plain}");
    assert!(log(&["read", "bench/station.toml"], "isolux=loud", 2).contains("ISOLUX_LOG=isolux=loud"));
}
