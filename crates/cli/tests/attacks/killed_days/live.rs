//! A bench whose twins outlive the program, in real time: where its axes come to rest when the program is killed in a
//! sweep. In the memory of the program they would die with it.

use std::io::{BufRead, BufReader, Write};
use std::net::TcpStream;
use std::process::{Child, ChildStdout};
use std::time::Duration;

use crate::folder::Folder;

/// Sweeps that come as near to the limits as their run-out allows: 44° + v²/2a + v·0.25 s = 52.7°.
const PLAN: &str = r#"format = "isolux-plan/1"
[[block]]
name = "distribution"
kind = "lit"
mode = "sweep"
speed_deg_s = 18.0
c_deg = [0, 50]
gamma_range = [-44, 44, 4]
distance_mm = 9900.0
"#;
/// Of both axes, degrees.
const LIMIT_DEG: [f64; 2] = [-55.0, 55.0];
/// Microsteps of the twin's axes.
const COUNTS_PER_DEG: f64 = 12800.0 / 3.0;

/// Twins that serve over TCP, with a station and a plan in their folder.
pub struct Live {
    folder: Folder,
    twins: Child,
    _stated: BufReader<ChildStdout>,
    axes: BufReader<TcpStream>,
}

impl Drop for Live {
    fn drop(&mut self) {
        let _ = self.twins.kill();
        let _ = self.twins.wait();
    }
}

/// Where an axis is.
struct Place {
    is_moving: bool,
    deg: f64,
}

impl Live {
    pub fn new() -> Self {
        let folder = Folder::in_memory();
        let mut twins = folder.start(&[
            "virtual",
            "darkroom",
            "--tcp",
            "0",
            "--station-out",
            "served.toml",
            "--axes",
            "zaber",
            "--luxmeter",
            "gigahertz-p9710",
            "--json",
            "--lasts-s",
            "300",
        ]);
        let mut stated = BufReader::new(twins.stdout.take().unwrap());
        let mut line = String::new();
        while !line.contains("spectroradiometer") {
            assert!(stated.read_line(&mut line).unwrap() > 0, "{line}");
        }
        let (_, address) = line.split_once("tcp://").unwrap();
        let link = TcpStream::connect(address.split('"').next().unwrap()).unwrap();
        link.set_read_timeout(Some(Duration::from_mins(1))).unwrap();
        let station = folder.read("served.toml");
        let mut changed: String = station
            .lines()
            .map(|line| match line {
                _ if line.starts_with("limit_deg") => format!("limit_deg = {LIMIT_DEG:?}\n"),
                _ => line.replace("?a_per_lx=3e-10", "?a_per_lx=3e-10&integration_ms=100") + "\n",
            })
            .collect();
        assert_eq!(
            changed.matches(&format!("limit_deg = {LIMIT_DEG:?}")).count(),
            2,
            "{changed}"
        );
        changed += "[lamp.stable]\nleast_s = 1.0\nwindow_s = 1.0\nspread_rel = 0.5\n";
        folder.write("station.toml", &changed);
        folder.write("plan.toml", PLAN);
        Self {
            folder,
            twins,
            _stated: stated,
            axes: BufReader::new(link),
        }
    }

    /// Kills a scan so long after its sweeps began and follows the axes until they rest; none of their positions on the
    /// way is outside the limits. Whether an axis moved when the program was killed.
    pub fn kill_and_follow(&mut self, after: Duration) -> bool {
        let mut scan = self
            .folder
            .start(&["scan", "station.toml", "plan.toml", "--out", "run"]);
        let events = self.folder.path("run/events.jsonl");
        let has_begun = || std::fs::read_to_string(&events).is_ok_and(|text| text.contains("\"event\":\"block\""));
        while !has_begun() {
            assert!(
                scan.try_wait().unwrap().is_none(),
                "the scan has ended before its sweeps"
            );
            std::thread::sleep(Duration::from_millis(20));
        }
        std::thread::sleep(after);
        scan.kill().unwrap();
        scan.wait().unwrap();
        let mut moved = None;
        loop {
            let places = [1, 2].map(|axis| self.place(axis));
            for (axis, place) in ["C", "γ"].iter().zip(&places) {
                let inside = (LIMIT_DEG[0]..=LIMIT_DEG[1]).contains(&place.deg);
                assert!(inside, "killed after {after:?}: {axis} is at {}°", place.deg);
            }
            let moves = places.iter().any(|place| place.is_moving);
            let moved = *moved.get_or_insert(moves);
            if !moves {
                println!(
                    "killed after {after:?}: C {:.2}°, γ {:.2}°",
                    places[0].deg, places[1].deg
                );
                return moved;
            }
        }
    }

    /// By the words of the drive, "@01 2 OK BUSY -- -210556:36".
    fn place(&mut self, axis: u8) -> Place {
        writeln!(self.axes.get_mut(), "/1 {axis} get pos").unwrap();
        let mut answer = String::new();
        self.axes.read_line(&mut answer).unwrap();
        let words: Vec<&str> = answer.split([' ', ':']).collect();
        let ["@01", _, "OK", state, _, counts, ..] = words[..] else {
            panic!("{answer:?}");
        };
        Place {
            is_moving: state == "BUSY",
            deg: counts.parse::<f64>().unwrap() / COUNTS_PER_DEG,
        }
    }
}
