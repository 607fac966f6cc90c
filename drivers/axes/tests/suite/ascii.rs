//! Axes by a profile against a scripted turntable on an in-memory link, with the clock paused.
//!
//! The turntable speaks degrees with three digits, echoes what it is sent, and has no word for its reference: what the
//! template of the program does not show. It answers by its own code.

#![expect(clippy::unwrap_used, reason = "a test")]

use std::collections::VecDeque;
use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use isolux_axes::ASCII_AXIS;
use isolux_device::{Axis, AxisFactory, AxisScale, AxisSettings, ErrorKind, Kind, OpenError, Sense, Target};
use isolux_transport::{MemoryLinks, Ports, TRIES};
use isolux_units::{AxisAngle, Millimetre};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::time::{Instant, sleep};

const PROFILE: &str = r#"format = "isolux-ascii-axis/1"
model = "a turntable"
[line]
baud = 57600
data_bits = 8
parity = "even"
stop_bits = 1
[messages]
terminator = "lf"
echo = true
answer_s = 0.3
[identity]
command = "VE"
reply = "VE {model} {firmware}"
[speed]
command = "VA{value}"
query = "VA?"
query_reply = "VA{value}"
decimals = 2
range = [0.1, 30.0]
[position]
command = "TP"
reply = "TP{position}"
decimals = 3
tolerance = 2
[move]
command = "PA{target}"
reply = "OK"
[stop]
command = "ST"
reply = "OK"
[home]
command = "OR"
reply = "OK"
position = 12.5
[state]
command = "TS"
reply = "TS{state}"
moving = ["M"]
resting = ["R"]
[state.faults]
"motor over temperature" = "E"
[errors]
"busy" = "?B"
"out of its own limits" = "?L"
"#;

/// What becomes of the next answer.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Fault {
    Normal,
    Silent,
    Late(u64),
    Twice(u64),
    Replaced,
    Torn,
    GarbageBefore,
    GarbageAfter,
    NoEcho,
    Split(usize),
    Flipped(usize, u8),
    Disconnect,
}

struct Table {
    /// Position at `since` and target, °.
    from: f64,
    target: f64,
    since: Instant,
    speed: f64,
    hot: bool,
    stall_at: Option<f64>,
    deaf_to_stop: bool,
    ignores_moves: bool,
    dead: bool,
    heard: Vec<String>,
    faults: VecDeque<Fault>,
    old: Vec<u8>,
}

impl Table {
    fn position(&self) -> f64 {
        let way = self.since.elapsed().as_secs_f64() * self.speed;
        let distance = self.target - self.from;
        let here = self.from + distance.signum() * way.min(distance.abs());
        match self.stall_at {
            Some(wall) if (self.from < wall) == (here >= wall) && distance != 0.0 => wall,
            _ => here,
        }
    }

    fn moving(&self) -> bool {
        self.position() != self.target
    }

    fn go(&mut self, target: f64) {
        (self.from, self.since, self.target) = (self.position(), Instant::now(), target);
    }

    fn answer(&mut self, command: &str) -> Option<String> {
        let stated = match command {
            "VE" => "VE TT9 2.1".to_owned(),
            "VA?" => format!("VA{:.2}", self.speed),
            "TP" => format!("TP{:.3}", self.position()),
            "TS" if self.hot => "TSE".to_owned(),
            "TS" => if self.moving() { "TSM" } else { "TSR" }.to_owned(),
            "ST" => {
                if !self.deaf_to_stop {
                    let here = self.position();
                    (self.from, self.target) = (here, here);
                }
                "OK".to_owned()
            }
            "OR" => {
                self.go(12.5);
                "OK".to_owned()
            }
            _ if command.starts_with("VA") => {
                self.speed = command[2..].parse().unwrap();
                return None;
            }
            _ if command.starts_with("PA") => {
                let target: f64 = command[2..].parse().unwrap();
                if self.moving() {
                    "?B".to_owned()
                } else if target.abs() > 170.0 {
                    "?L".to_owned()
                } else {
                    if !self.ignores_moves {
                        self.go(target);
                    }
                    "OK".to_owned()
                }
            }
            _ => "?C".to_owned(),
        };
        Some(stated)
    }
}

type Shared = Arc<Mutex<Table>>;

struct Bench {
    links: Arc<MemoryLinks>,
    table: Shared,
    folder: tempfile::TempDir,
}

fn bench() -> Bench {
    let links = MemoryLinks::default();
    let mut listener = links.listen("table").unwrap();
    let table = Arc::new(Mutex::new(Table {
        from: 33.0,
        target: 33.0,
        since: Instant::now(),
        speed: 5.0,
        hot: false,
        stall_at: None,
        deaf_to_stop: false,
        ignores_moves: false,
        dead: false,
        heard: vec![],
        faults: VecDeque::new(),
        old: vec![],
    }));
    let twin = Arc::clone(&table);
    tokio::spawn(async move {
        while let Some(mut stream) = listener.accept().await {
            let twin = Arc::clone(&twin);
            tokio::spawn(async move {
                let (mut inbox, mut buffer) = (Vec::new(), [0; 64]);
                loop {
                    let Ok(count @ 1..) = stream.read(&mut buffer).await else {
                        return;
                    };
                    inbox.extend(&buffer[..count]);
                    while let Some(end) = inbox.iter().position(|byte| *byte == b'\n') {
                        let line: Vec<u8> = inbox.drain(..=end).collect();
                        let command = String::from_utf8(line[..end].to_vec()).unwrap();
                        let (mut bytes, fault, old) = {
                            let mut table = twin.lock().unwrap();
                            table.heard.push(command.clone());
                            if table.dead {
                                continue;
                            }
                            let stated = table.answer(&command).map_or(String::new(), |text| text + "\n");
                            let bytes = [&line[..], stated.as_bytes()].concat();
                            let old = std::mem::replace(&mut table.old, bytes.clone());
                            (bytes, table.faults.pop_front().unwrap_or(Fault::Normal), old)
                        };
                        let (mut wait, mut later) = (5, None);
                        match fault {
                            Fault::Normal => {}
                            Fault::Silent => continue,
                            Fault::Disconnect => return,
                            Fault::Late(milliseconds) => wait = milliseconds,
                            Fault::Twice(milliseconds) => later = Some((milliseconds, bytes.clone())),
                            Fault::Replaced => bytes = old,
                            Fault::Torn => drop(bytes.remove(bytes.len() / 2)),
                            Fault::GarbageBefore => bytes.splice(..0, *b"\x00\xff").for_each(drop),
                            Fault::GarbageAfter => bytes.extend(b"?\x80"),
                            Fault::NoEcho => drop(bytes.drain(..line.len())),
                            Fault::Split(at) => later = Some((30, bytes.split_off(at.min(bytes.len())))),
                            Fault::Flipped(at, bit) => {
                                let at = at % bytes.len();
                                bytes[at] ^= 1 << bit;
                            }
                        }
                        sleep(Duration::from_millis(wait)).await;
                        if stream.write_all(&bytes).await.is_err() {
                            return;
                        }
                        if let Some((milliseconds, bytes)) = later {
                            sleep(Duration::from_millis(milliseconds)).await;
                            let _ = stream.write_all(&bytes).await;
                        }
                    }
                }
            });
        }
    });
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("table.toml"), PROFILE).unwrap();
    Bench {
        links: Arc::new(links),
        table,
        folder,
    }
}

fn angle(deg: f64) -> AxisAngle {
    AxisAngle::new(deg).unwrap()
}

impl Bench {
    fn factory(&self) -> Arc<dyn AxisFactory> {
        (ASCII_AXIS.factories)(Ports::new(self.links.clone())).axis.unwrap()
    }

    async fn open(&self, rest: &str, speed_deg_s: f64) -> Result<Box<dyn Axis>, OpenError> {
        let target = target(rest, self.folder.path());
        let scale = AxisScale::new(1000, 1, angle(0.0), Sense::Positive).unwrap();
        let settings = AxisSettings::new(scale, (angle(-180.0), angle(180.0)), speed_deg_s, 50.0).unwrap();
        self.factory().open_axis(&target, settings).await
    }

    async fn axis(&self) -> Box<dyn Axis> {
        self.open("profile=table.toml", 10.0).await.unwrap()
    }

    async fn homed(&self) -> Box<dyn Axis> {
        let axis = self.axis().await;
        axis.home(soon()).await.unwrap();
        axis
    }

    fn with<T>(&self, act: impl FnOnce(&mut Table) -> T) -> T {
        act(&mut self.table.lock().unwrap())
    }
}

fn target(rest: &str, folder: &Path) -> Target {
    Target::parse(&format!("ascii-axis:memory:table?{rest}"))
        .unwrap()
        .within(folder)
}

fn soon() -> Instant {
    Instant::now() + Duration::from_mins(1)
}

#[tokio::test(start_paused = true)]
async fn it_homes_moves_stops_and_must_be_homed_in_every_session() {
    let bench = bench();
    let axis = bench.axis().await;
    assert_eq!(axis.identity().model, "a turntable (TT9)");
    assert_eq!(axis.identity().firmware.as_deref(), Some("2.1"));
    assert_eq!(bench.with(|table| table.heard.clone()), ["VE", "VA10.00", "VA?", "VA?"]);
    let error = axis.move_to(angle(10.0)).await.unwrap_err();
    assert!(error.to_string().contains("home the axis first"), "{error}");
    assert_eq!(bench.with(|table| table.position()), 33.0, "nothing moved");
    let home = axis.home(soon()).await.unwrap();
    assert!(home.homed && home.steps == 12_500 && home.place.value() == 12.5);
    for deg in [-45.125, 90.001, 0.0, -0.005] {
        let at = axis.move_to(angle(deg)).await.unwrap();
        assert!((at.place.value() - deg).abs() < 1e-9, "{at:?}");
        assert!((bench.with(|table| table.position()) - deg).abs() < 1e-9);
    }
    assert_eq!(
        axis.move_to(angle(181.0)).await.unwrap_err().kind(),
        ErrorKind::OutOfTravel
    );
    let refused = axis.move_to(angle(175.0)).await.unwrap_err();
    assert!(
        refused.kind() == ErrorKind::Refused && refused.to_string().contains("out of its own limits"),
        "{refused}"
    );
    axis.start_move(angle(100.0)).await.unwrap();
    sleep(Duration::from_secs(3)).await;
    let error = axis.start_move(angle(-100.0)).await.unwrap_err();
    assert!(error.to_string().contains("still moving"), "{error}");
    let stopped = axis.stop().await.unwrap();
    let there = bench.with(|table| table.position());
    assert!(!stopped.moving && (29.0..32.0).contains(&there));
    // The turntable counts in whole digits.
    assert!((stopped.place.value() - there).abs() <= 0.0005);
    let again = bench.axis().await.position().await.unwrap();
    assert!(!again.homed, "{again:?}");
    let linear = AxisScale::new(1000, 1, Millimetre::new(0.0).unwrap(), Sense::Positive).unwrap();
    let mm = |value: f64| Millimetre::new(value).unwrap();
    let rail = AxisSettings::new(linear, (mm(0.0), mm(100.0)), 10.0, 50.0).unwrap();
    let open = target("profile=table.toml", bench.folder.path());
    let rail = bench.factory().open_linear_axis(&open, rail).await.unwrap();
    rail.home(soon()).await.unwrap();
    assert_eq!(rail.move_to(mm(50.0)).await.unwrap().place, mm(50.0));
}

#[tokio::test(start_paused = true)]
async fn faults_stalls_and_what_does_not_obey_are_told() {
    let described = async |prepare: fn(&mut Table), words: &str| {
        let bench = bench();
        let axis = bench.homed().await;
        bench.with(prepare);
        let error = axis.move_to(angle(-90.0)).await.unwrap_err();
        assert!(error.to_string().contains(words), "{words}: {error}");
    };
    described(|table| table.stall_at = Some(-20.0), "stalled").await;
    described(
        |table| table.ignores_moves = true,
        "it came to rest at 12500 and not at -90000",
    )
    .await;
    described(|table| table.hot = true, "motor over temperature").await;
    let bench = bench();
    let axis = bench.homed().await;
    axis.start_move(angle(-90.0)).await.unwrap();
    bench.with(|table| table.deaf_to_stop = true);
    let error = axis.stop().await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Timeout, "not at rest is no success: {error}");
}

#[tokio::test(start_paused = true)]
async fn no_damage_to_an_answer_moves_the_axis_elsewhere_or_gives_a_wrong_position() {
    let flipped = (0..14).flat_map(|at| (0..8).map(move |bit| Fault::Flipped(at, bit)));
    let faults = [
        Fault::Silent,
        Fault::Late(250),
        Fault::Late(350),
        Fault::Late(900),
        Fault::Twice(1),
        Fault::Twice(400),
        Fault::Replaced,
        Fault::Torn,
        Fault::GarbageBefore,
        Fault::GarbageAfter,
        Fault::NoEcho,
    ];
    for fault in faults.into_iter().chain((1..14).map(Fault::Split)).chain(flipped) {
        for at in 0..4 {
            let bench = bench();
            let axis = bench.homed().await;
            let to = -30.0 + f64::from(at);
            let spoilt: Vec<Fault> = std::iter::repeat_n(Fault::Normal, at as usize).chain([fault]).collect();
            bench.with(|table| table.faults.extend(spoilt.clone()));
            match axis.move_to(angle(to)).await {
                Ok(position) => {
                    assert_eq!(position.place, angle(to), "{fault:?} at {at}");
                    assert!(
                        (bench.with(|table| table.position()) - to).abs() < 0.003,
                        "{fault:?} at {at}"
                    );
                }
                // A failed move has left the axis at rest.
                Err(_) => assert!(!bench.with(|table| table.moving()), "{fault:?} at {at}"),
            }
            bench.with(|table| {
                table.faults.clear();
                table.faults.extend(spoilt);
            });
            if let Ok(position) = axis.position().await {
                let truth = bench.with(|table| table.position());
                assert!(
                    (position.place.value() - truth).abs() <= 0.003,
                    "{fault:?} at {at}: {position:?} {truth}"
                );
            }
        }
    }
}

#[tokio::test(start_paused = true)]
async fn a_dead_table_is_asked_four_times_and_wrong_addresses_are_one_message() {
    let bench = bench();
    let axis = bench.homed().await;
    bench.with(|table| {
        table.dead = true;
        table.heard.clear();
    });
    let error = axis.position().await.unwrap_err();
    assert_eq!(
        (error.kind(), bench.with(|table| table.heard.len())),
        (ErrorKind::Timeout, TRIES as usize)
    );
    bench.with(|table| {
        table.dead = false;
        table.faults.push_back(Fault::Disconnect);
    });
    assert_eq!(axis.position().await.unwrap_err().kind(), ErrorKind::Disconnected);
    let error = bench.open("profile=table.toml", 40.0).await.err().unwrap().to_string();
    assert!(
        error.contains("speed_deg_s = 40") && error.contains("0.1 to 30"),
        "{error}"
    );
    for (rest, word) in [
        ("profile=table.toml&axis=1", "unknown option axis"),
        ("profile=table.toml&address=1", "address=1 is given, and no command"),
        ("profile=template", "add address="),
        ("profile=nowhere.toml", "nowhere.toml"),
        ("", "profile=NAME (template)"),
    ] {
        let error = bench.open(rest, 10.0).await.err().unwrap();
        assert!(
            matches!(error, OpenError::Address { .. }) && error.to_string().contains(word),
            "{error}"
        );
    }
    let place = (ASCII_AXIS.place)(&target("profile=template&address=2", Path::new("")), Kind::Axis).unwrap();
    assert_eq!(
        (place.channel.as_str(), place.line.to_string().as_str()),
        ("drive 2", "19200 8N1")
    );
}
