//! `inspect` through the program: pipes, and what is refused.

#![cfg(unix)]

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

const LAMP: &str = "IES:LM-63-2019\n[TEST] 1\n[TESTLAB] a\n[ISSUEDATE] 01-JAN-2025\n[MANUFAC] c\n[FILEGENTYPE] 1.10000\nTILT=NONE\n1 1000 1 3 1 1 2 0 0 0\n1 1 10\n\
0 45 90\n0\n100 70 0\n";

fn isolux(folder: &Path, arguments: &[&str], stdin: Option<&[u8]>) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_isolux"));
    command
        .args(arguments)
        .current_dir(folder)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    let Some(bytes) = stdin else {
        return command.stdin(Stdio::null()).output().unwrap();
    };
    let mut child = command.stdin(Stdio::piped()).spawn().unwrap();
    let mut pipe = child.stdin.take().unwrap();
    let bytes = bytes.to_vec();
    let writer = std::thread::spawn(move || {
        // The reader may leave before the end.
        let _ = pipe.write_all(&bytes);
    });
    let output = child.wait_with_output().unwrap();
    writer.join().unwrap();
    output
}

/// The one line of `inspect --json`, without the file's name.
fn inspected(output: &Output) -> serde_json::Value {
    let mut value: serde_json::Value = serde_json::from_slice(&output.stdout)
        .unwrap_or_else(|error| panic!("{error}: {}", String::from_utf8_lossy(&output.stderr)));
    value.as_object_mut().unwrap().remove("file");
    value
}

fn write(folder: &Path, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, bytes).unwrap();
    path
}

#[test]
fn a_pipe_says_what_the_file_says() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, "lamp.ies", LAMP);
    write(
        folder,
        "led.csv",
        "wavelength,value\n380,0\n420,1\n460,3\n500,2\n540,3\n580,4\n620,3\n660,2\n700,1\n740,0\n",
    );
    for name in ["lamp.ies", "led.csv"] {
        let bytes = std::fs::read(folder.join(name)).unwrap();
        let file = inspected(&isolux(folder, &["inspect", "--json", name], None));
        let pipe = inspected(&isolux(folder, &["inspect", "--json", "/dev/stdin"], Some(&bytes)));
        assert_eq!(file["readable"], true, "{name}");
        assert_eq!(file, pipe, "{name}");
    }
}

#[test]
fn a_simulation_refuses_a_pipe_and_says_why() {
    let folder = tempfile::tempdir().unwrap();
    let done = isolux(
        folder.path(),
        &["simulate", "/dev/stdin", "--out", "out"],
        Some(LAMP.as_bytes()),
    );
    assert_eq!(done.status.code(), Some(2));
    let stated = String::from_utf8_lossy(&done.stderr).into_owned();
    assert!(stated.contains("pipe"), "{stated}");
    assert!(!folder.path().join("out").exists());
}

#[test]
fn a_named_pipe_is_read_once_too() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, "lamp.ies", LAMP);
    let file = inspected(&isolux(folder, &["inspect", "--json", "lamp.ies"], None));
    let made = Command::new("mkfifo").arg(folder.join("pipe.ies")).status();
    if !made.is_ok_and(|status| status.success()) {
        return;
    }
    let target = folder.join("pipe.ies");
    let writer = std::thread::spawn(move || std::fs::write(target, LAMP).unwrap());
    let pipe = inspected(&isolux(folder, &["inspect", "--json", "pipe.ies"], None));
    writer.join().unwrap();
    assert_eq!(file, pipe);
}

#[test]
fn rays_stream_from_a_pipe() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, "lamp.ies", LAMP);
    write(
        folder,
        "scene.toml",
        "format = \"isolux-scene/1\"\n[luminaire]\ndistribution = \"lamp.ies\"\nler_lm_per_w = 320.0\n\
         [sensor]\nsize_mm = [60.0, 60.0]\npixels = [8, 8]\ndistance_mm = 150.0\n",
    );
    let done = isolux(
        folder,
        &[
            "simulate",
            "scene.toml",
            "--out",
            "out",
            "--rays-out",
            "rays.tm25ray",
            "9000",
        ],
        None,
    );
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let whole = std::fs::read(folder.join("rays.tm25ray")).unwrap();
    // Whole, cut inside a ray, and longer than the header says.
    let longer = [whole.clone(), vec![0; 70_000]].concat();
    for bytes in [whole.clone(), whole[..whole.len() - 70_001].to_vec(), longer] {
        write(folder, "rays.tm25ray", &bytes);
        let file = inspected(&isolux(folder, &["inspect", "--json", "rays.tm25ray"], None));
        let pipe = inspected(&isolux(folder, &["inspect", "--json", "/dev/stdin"], Some(&bytes)));
        assert_eq!(file["readable"], bytes == whole);
        assert_eq!(file, pipe);
    }
}

const LED: &str = "wavelength_nm,value\n380,0\n420,1\n460,3\n500,2\n540,3\n580,4\n620,3\n660,2\n700,1\n740,0\n";

#[test]
fn what_a_meters_file_leaves_open_is_told_beside_the_source() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, "led.csv", LED);
    // µm are assumed, with a warning; and the responsivity ends where the eye still sees.
    write(
        folder,
        "meter.csv",
        LED.replace("_nm", "")
            .replace("\n3", "\n0.3")
            .replace("\n4", "\n0.4")
            .replace("\n5", "\n0.5")
            .replace("\n6", "\n0.6")
            .replace("\n7", "\n0.7"),
    );
    write(
        folder,
        "uv.csv",
        "wavelength_nm,s\n200,0\n220,1\n240,2\n260,3\n280,2\n300,1\n310,0.5\n320,0\n",
    );

    let seen = inspected(&isolux(
        folder,
        &["inspect", "--json", "led.csv", "--meter", "meter.csv"],
        None,
    ));
    let described = seen["findings"].as_array().unwrap();
    let described = |code: &str| {
        described
            .iter()
            .find(|f| f["code"] == code)
            .map(|f| f["message"].as_str().unwrap())
    };
    assert!(
        described("spectrum-axis-unit").is_some_and(|message| message.starts_with("meter.csv:2:1: ")),
        "{seen}"
    );
    assert!(seen["quantities"]["spectral_mismatch"].is_f64(), "{seen}");

    let text = isolux(folder, &["inspect", "led.csv", "--meter", "uv.csv"], None);
    let text = String::from_utf8_lossy(&text.stdout).into_owned();
    assert!(
        text.contains("warning[meter-no-factor]") && text.contains("does not see the light of its calibration"),
        "{text}"
    );
}

#[test]
fn two_files_of_one_name_are_refused_before_a_picture_is_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for name in ["a", "b"] {
        std::fs::create_dir(folder.join(name)).unwrap();
        write(&folder.join(name), "led.csv", LED);
    }
    for more in [&["--plot", "p"][..], &["--plot", "p", "--force"]] {
        let done = isolux(folder, &[&["inspect", "a/led.csv", "b/led.csv"], more].concat(), None);
        assert_eq!(done.status.code(), Some(2));
        assert!(!folder.join("p").exists(), "nothing is drawn");
    }
    let drawn = isolux(folder, &["inspect", "a/led.csv", "--plot", "p"], None);
    assert_eq!(drawn.status.code(), Some(0));
    write(folder, "other.csv", LED);
    let again = isolux(folder, &["inspect", "other.csv", "a/led.csv", "--plot", "p"], None);
    assert_eq!(again.status.code(), Some(2));
    assert!(
        !folder.join("p/other.csv.spectrum.svg").exists(),
        "a later picture that exists stops the first too"
    );
}

#[test]
fn an_option_that_does_not_apply_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, "lamp.ies", LAMP);
    write(folder, "led.csv", LED);
    for (source, target, option, value) in [
        ("led.csv", "o.spdx", "--edition", "2019"),
        ("led.csv", "o.spdx", "--generation", "1.10000"),
        ("led.csv", "o.spdx", "--photometry", "b"),
        ("lamp.ies", "o.ldt", "--generation", "1.10000"),
        ("lamp.ies", "o.ldt", "--edition", "2019"),
    ] {
        let done = isolux(folder, &["convert", source, target, option, value], None);
        assert_eq!(done.status.code(), Some(2), "{source} {option}");
        assert!(
            String::from_utf8_lossy(&done.stderr).contains(option),
            "{source} {option}"
        );
        assert!(!folder.join(target).exists());
    }
}

#[test]
fn ratings_need_what_the_person_gives() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, "lamp.ies", LAMP.replace("100 70 0", "1000 700 100"));
    let plain = inspected(&isolux(folder, &["inspect", "--json", "lamp.ies"], None));
    assert_eq!(plain["quantities"].get("outdoor"), None, "{plain}");
    let street = ["inspect", "--json", "lamp.ies", "--street-side", "90"];
    let found = inspected(&isolux(folder, &street, None));
    let outdoor = &found["quantities"]["outdoor"];
    assert_eq!(outdoor["street_side_c_deg"], 90.0, "{found}");
    // The file ends at the horizontal in light.
    assert!(
        outdoor["uplight_rating"].is_null() && outdoor["backlight_rating"] == 1,
        "{found}"
    );
    let refused = isolux(folder, &["inspect", "lamp.ies", "--street-side", "360"], None);
    assert_eq!(refused.status.code(), Some(2), "{refused:?}");

    write(
        folder,
        "led.csv",
        "wavelength_nm,value\n380,0\n450,3\n500,1\n560,2\n780,0\n",
    );
    // V(λ), roughly: of every light its daylight efficacy ratio is near one.
    write(
        folder,
        "v.csv",
        "wavelength_nm,value\n450,0\n500,0.32\n520,0.71\n555,1\n590,0.76\n620,0.38\n680,0\n",
    );
    let spectrum = [
        "inspect",
        "--json",
        "led.csv",
        "--rated-cct",
        "6000",
        "--action",
        "v.csv",
    ];
    let found = inspected(&isolux(folder, &spectrum, None));
    let of = &found["quantities"];
    assert_eq!(of["rated_colour"]["of"], "CIE daylight", "{found}");
    assert!(of["rated_colour"]["steps"].as_f64().unwrap() > 1.0, "{found}");
    assert!(
        (of["daylight_efficacy_ratio"].as_f64().unwrap() - 1.0).abs() < 0.03,
        "{found}"
    );
    let k_bv = of["k_bv_mw_per_lm"].as_f64().unwrap();
    assert!(
        (of["e_thr_lx"].as_f64().unwrap() * k_bv / 1000.0 - 1.0).abs() < 1e-12,
        "{found}"
    );
    let refused = isolux(folder, &["inspect", "led.csv", "--rated-cct", "warm"], None);
    assert_eq!(refused.status.code(), Some(2), "{refused:?}");
}
