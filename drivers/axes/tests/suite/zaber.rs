//! The Zaber driver against a scripted controller on an in-memory link, with the clock paused.
//!
//! The controller below was written from the manual's text, not from the codec: it has its own checksum and parser.

use std::collections::{HashMap, VecDeque};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use isolux_axes::ZaberDriver;
use isolux_device::{
    Axis, AxisFactory, AxisScale, AxisSettings, DeviceError, ErrorKind, OpenError, Sense, SwitchFactory, Target,
    ThermometerFactory,
};
use isolux_transport::{MemoryLinks, Ports, TRIES};
use isolux_units::{AxisAngle, Millimetre};
use tokio::io::{AsyncReadExt, AsyncWriteExt, DuplexStream};
use tokio::time::Instant;

/// What goes wrong with the next reply to a command that begins with the text.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Fault {
    Silent,
    Late(u64),
    FlipBit,
    DropChecksum,
    Disconnect,
    Garbage,
    /// The reply that last had this id comes first, the true one after it.
    Replayed,
    /// The reply that last had this id comes instead of the true one.
    Replaced,
}

struct Room {
    /// Position at `since`, target, microsteps a second.
    from: f64,
    since: Instant,
    target: f64,
    speed: f64,
    unreferenced: bool,
    flags: Vec<&'static str>,
    stall_at: Option<f64>,
    deaf_to_stop: bool,
    outputs: [bool; 4],
    stuck_output: bool,
    volts: f64,
    maxspeed: f64,
    accel: f64,
    checksums: bool,
    faults: VecDeque<(&'static str, Fault)>,
    heard: Vec<String>,
}

impl Room {
    fn new() -> Self {
        Self {
            from: 777.0,
            since: Instant::now(),
            target: 777.0,
            speed: 1280.0,
            unreferenced: true,
            flags: vec![],
            stall_at: None,
            deaf_to_stop: false,
            outputs: [false; 4],
            stuck_output: false,
            volts: 5.0,
            maxspeed: 0.0,
            accel: 0.0,
            checksums: false,
            faults: VecDeque::new(),
            heard: vec![],
        }
    }

    fn position(&mut self) -> f64 {
        let way = self.since.elapsed().as_secs_f64() * self.speed;
        let distance = self.target - self.from;
        let here = self.from + distance.signum() * way.min(distance.abs());
        match self.stall_at {
            Some(wall) if (self.from < wall) == (here >= wall) && distance != 0.0 => wall,
            _ => here.round(),
        }
    }

    fn moving(&mut self) -> bool {
        self.position() != self.target
    }

    fn go(&mut self, target: f64) {
        (self.from, self.since, self.target) = (self.position(), Instant::now(), target);
    }

    /// Reply words after the address, without checksum.
    fn answer(&mut self, axis: &str, words: &[&str]) -> String {
        let mut outcome = "OK";
        let data = match words {
            [] => "0".to_owned(),
            ["set", "comm.checksum", value] => {
                self.checksums = *value == "1";
                "0".into()
            }
            ["get", "device.id"] => "30341".into(),
            ["get", "system.serial"] => "98765".into(),
            ["get", "version"] => "7.33".into(),
            ["get", "pos"] => format!("{:.0}", self.position()),
            ["get", "limit.min"] => "-100000".into(),
            ["get", "limit.max"] => "100000".into(),
            ["set", "maxspeed", value] => {
                self.maxspeed = value.parse().unwrap();
                "0".into()
            }
            ["get", "maxspeed"] => self.maxspeed.to_string(),
            ["set", "accel", value] => {
                self.accel = value.parse().unwrap();
                "0".into()
            }
            ["get", "accel"] => self.accel.to_string(),
            ["home"] => {
                self.unreferenced = false;
                self.go(0.0);
                "0".into()
            }
            ["move", "abs", target] => {
                self.go(target.parse().unwrap());
                "0".into()
            }
            ["stop" | "estop"] => {
                if !(self.deaf_to_stop && words == ["stop"]) {
                    let here = self.position();
                    self.go(here);
                    (self.from, self.target) = (here, here);
                }
                "0".into()
            }
            ["warnings"] => {
                let mut all = self.flags.clone();
                if self.unreferenced {
                    all.extend(["WR", "WH"]);
                }
                std::iter::once(format!("{:02}", all.len()))
                    .chain(all.iter().map(ToString::to_string))
                    .collect::<Vec<_>>()
                    .join(" ")
            }
            ["warnings", "clear"] => {
                self.flags.clear();
                "00".into()
            }
            ["io", "set", "do", n, value] => {
                let n: usize = n.parse().unwrap();
                if n > 4 {
                    outcome = "RJ";
                    "BADDATA".into()
                } else {
                    self.outputs[n - 1] = *value == "1" && !self.stuck_output;
                    "0".into()
                }
            }
            ["io", "get", "do", n] => u8::from(self.outputs[n.parse::<usize>().unwrap() - 1]).to_string(),
            ["io", "get", "ai", _] => self.volts.to_string(),
            _ => {
                outcome = "RJ";
                "BADCOMMAND".into()
            }
        };
        let status = if axis != "0" && self.moving() { "BUSY" } else { "IDLE" };
        let flag = self
            .flags
            .first()
            .copied()
            .unwrap_or(if self.unreferenced { "WR" } else { "--" });
        format!("{outcome} {status} {flag} {data}")
    }
}

fn lrc(text: &str) -> String {
    let sum: u32 = text.bytes().map(u32::from).sum();
    format!("{:02X}", ((sum & 0xFF) ^ 0xFF).wrapping_add(1) & 0xFF)
}

async fn serve(room: Arc<Mutex<Room>>, mut stream: DuplexStream) {
    let mut line = String::new();
    let mut by_id: HashMap<String, Vec<u8>> = HashMap::new();
    while let Ok(byte) = stream.read_u8().await {
        if byte != b'\n' {
            line.push(char::from(byte));
            continue;
        }
        let frame = std::mem::take(&mut line);
        let (body, check) = frame.strip_prefix('/').unwrap().rsplit_once(':').unwrap();
        assert_eq!(check, lrc(body), "the host's checksum");
        let mut words = body.split(' ');
        let (device, axis, id) = (words.next().unwrap(), words.next().unwrap(), words.next().unwrap());
        let words: Vec<&str> = words.collect();
        let text = words.join(" ");
        let (body, fault, checksums) = {
            let mut room = room.lock().unwrap();
            room.heard.push(text.clone());
            let fault = room
                .faults
                .front()
                .copied()
                .filter(|(prefix, _)| text.starts_with(prefix))
                .map(|(_, fault)| fault);
            if fault.is_some() {
                room.faults.pop_front();
            }
            let stated = room.answer(axis, &words);
            (format!("{device:0>2} {axis} {id:0>2} {stated}"), fault, room.checksums)
        };
        let mut frame = format!("@{body}:{}\r\n", lrc(&body)).into_bytes();
        let old = by_id.insert(body[..7].to_owned(), frame.clone());
        if !checksums || fault == Some(Fault::DropChecksum) {
            frame = format!("@{body}\r\n").into_bytes();
        }
        match fault {
            Some(Fault::Silent) => continue,
            Some(Fault::Disconnect) => return,
            Some(Fault::FlipBit) => {
                let at = frame.len() - 6;
                frame[at] ^= 1;
            }
            Some(Fault::Replayed) => frame = [old.unwrap_or_default(), frame].concat(),
            Some(Fault::Replaced) => frame = old.unwrap_or_default(),
            Some(Fault::Garbage) => frame = b"\x00\xFF#!@garbage\r\n".to_vec(),
            Some(Fault::Late(milliseconds)) => {
                tokio::time::sleep(Duration::from_millis(milliseconds)).await;
            }
            Some(Fault::DropChecksum) | None => tokio::time::sleep(Duration::from_millis(2)).await,
        }
        if stream.write_all(&frame).await.is_err() {
            return;
        }
    }
}

fn bench() -> (ZaberDriver, Arc<Mutex<Room>>) {
    let links = MemoryLinks::default();
    let mut listener = links.listen("axes").unwrap();
    let room = Arc::new(Mutex::new(Room::new()));
    let twin = Arc::clone(&room);
    tokio::spawn(async move {
        while let Some(stream) = listener.accept().await {
            tokio::spawn(serve(Arc::clone(&twin), stream));
        }
    });
    (ZaberDriver::new(Ports::new(Arc::new(links))), room)
}

fn angle(degrees: f64) -> AxisAngle {
    AxisAngle::new(degrees).unwrap()
}

/// 1280 microsteps a degree: 128 °/s² is more than one device unit, 1 °/s = 1280 steps/s as the room moves.
fn settings(limit: (f64, f64)) -> AxisSettings {
    let scale = AxisScale::new(1280, 1, angle(0.0), Sense::Positive).unwrap();
    AxisSettings::new(scale, (angle(limit.0), angle(limit.1)), 1.0, 10.0).unwrap()
}

async fn open(driver: &ZaberDriver) -> Box<dyn Axis> {
    let target = Target::parse("zaber:memory:axes?axis=1").unwrap();
    driver.open_axis(&target, settings((-75.0, 75.0))).await.unwrap()
}

async fn homed() -> (Box<dyn Axis>, Arc<Mutex<Room>>) {
    let (driver, room) = bench();
    let axis = open(&driver).await;
    axis.home(Instant::now() + Duration::from_mins(1)).await.unwrap();
    (axis, room)
}

#[tokio::test(start_paused = true)]
async fn opens_homes_moves_and_reads_back() {
    let (driver, room) = bench();
    let axis = open(&driver).await;
    assert_eq!(axis.identity().serial.as_deref(), Some("98765"));
    assert_eq!(axis.identity().firmware.as_deref(), Some("7.33"));
    // Speed 1280·1.6384 = 2097.152 and acceleration 12800·1.6384/10000 = 2.097 device units, rounded down.
    assert_eq!(room.lock().unwrap().maxspeed, 2097.0);
    assert_eq!(room.lock().unwrap().accel, 2.0);
    assert!(axis.settings().speed() <= 1.0 && axis.settings().speed() > 0.999);

    assert!(!axis.position().await.unwrap().homed);
    let refused = axis.move_to(angle(10.0)).await.unwrap_err();
    assert!(
        refused.kind() == ErrorKind::Fault && refused.to_string().contains("home"),
        "{refused}"
    );
    assert!(
        !room.lock().unwrap().heard.iter().any(|text| text.starts_with("move")),
        "nothing moved"
    );

    let home = axis.home(Instant::now() + Duration::from_mins(1)).await.unwrap();
    assert!(home.homed && home.steps == 0 && !home.moving);
    let motion = axis.start_move(angle(12.5)).await.unwrap();
    assert_eq!(
        (motion.from_steps, motion.target_steps, motion.target),
        (0, 16_000, angle(12.5))
    );
    assert!(axis.position().await.unwrap().moving);
    let there = axis.finish_move(motion).await.unwrap();
    assert_eq!((there.steps, there.place, there.moving), (16_000, angle(12.5), false));
    // 12.5° at 1 °/s: the driver waited for it, not for a fixed time.
    assert_eq!(
        axis.move_to(angle(12.5)).await.unwrap().steps,
        16_000,
        "a move to where it is ends at once"
    );
}

#[tokio::test(start_paused = true)]
async fn outside_the_travel_nothing_moves() {
    let (axis, room) = homed().await;
    for wanted in [75.1, -75.1, 1e9] {
        assert_eq!(
            axis.start_move(angle(wanted)).await.unwrap_err().kind(),
            ErrorKind::OutOfTravel
        );
    }
    assert!(!room.lock().unwrap().heard.iter().any(|text| text.starts_with("move")));
    let (driver, _room) = bench();
    let target = Target::parse("zaber:memory:axes?axis=1").unwrap();
    let Err(error) = driver.open_axis(&target, settings((-180.0, 180.0))).await else {
        panic!("opened")
    };
    assert!(
        matches!(error, OpenError::Device(DeviceError::OutOfTravel { .. })),
        "{error}"
    );
}

#[tokio::test(start_paused = true)]
async fn damaged_late_and_missing_replies_are_asked_for_again() {
    let (axis, room) = homed().await;
    axis.move_to(angle(10.0)).await.unwrap();
    for fault in [
        Fault::FlipBit,
        Fault::DropChecksum,
        Fault::Silent,
        Fault::Garbage,
        Fault::Late(700),
    ] {
        room.lock()
            .unwrap()
            .faults
            .extend([("get pos", fault), ("get pos", fault)]);
        let position = axis.position().await.unwrap();
        assert_eq!(position.steps, 12_800, "{fault:?}");
        assert!(room.lock().unwrap().faults.is_empty());
    }
    for (fault, kind) in [
        (Fault::Silent, ErrorKind::Timeout),
        (Fault::FlipBit, ErrorKind::Malformed),
    ] {
        room.lock().unwrap().faults.extend([("get pos", fault); TRIES as usize]);
        assert_eq!(axis.position().await.unwrap_err().kind(), kind);
    }
}

#[tokio::test(start_paused = true)]
async fn a_late_position_never_becomes_the_next_one() {
    let (axis, room) = homed().await;
    axis.move_to(angle(1.0)).await.unwrap();
    // The first answer is held back for 700 ms; meanwhile the axis is somewhere else.
    room.lock().unwrap().faults.push_back(("get pos", Fault::Late(700)));
    assert_eq!(axis.position().await.unwrap().steps, 1280);
    assert_eq!(axis.move_to(angle(5.0)).await.unwrap().steps, 6400);
    for _ in 0..10 {
        assert_eq!(axis.position().await.unwrap().steps, 6400);
    }
}

#[tokio::test(start_paused = true)]
async fn a_stall_is_seen_with_and_without_a_flag() {
    let (axis, room) = homed().await;
    room.lock().unwrap().stall_at = Some(5000.0);
    let began = Instant::now();
    let error = axis.move_to(angle(20.0)).await.unwrap_err();
    assert!(
        error.kind() == ErrorKind::Fault && error.to_string().contains("no progress"),
        "{error}"
    );
    assert!(
        began.elapsed() < Duration::from_secs(8),
        "it did not wait for the deadline"
    );
    assert!(
        room.lock().unwrap().heard.contains(&"stop".to_owned()),
        "the axis was stopped"
    );

    let (axis, room) = homed().await;
    let motion = axis.start_move(angle(20.0)).await.unwrap();
    room.lock().unwrap().flags.push("FS");
    let error = axis.finish_move(motion).await.unwrap_err();
    assert!(error.to_string().contains("FS (stalled and stopped)"), "{error}");
    assert_eq!(axis.position().await.unwrap_err().kind(), ErrorKind::Fault);
    assert_eq!(
        axis.start_move(angle(1.0)).await.unwrap_err().kind(),
        ErrorKind::Fault,
        "no move on a lost count"
    );
    axis.home(Instant::now() + Duration::from_mins(1)).await.unwrap();
    axis.move_to(angle(1.0)).await.unwrap();
}

#[tokio::test(start_paused = true)]
async fn a_lost_reference_and_a_wrong_end_fail_the_move() {
    let (axis, room) = homed().await;
    let motion = axis.start_move(angle(20.0)).await.unwrap();
    tokio::time::sleep(Duration::from_secs(1)).await;
    room.lock().unwrap().unreferenced = true;
    let error = axis.finish_move(motion).await.unwrap_err();
    assert!(error.to_string().contains("reference was lost"), "{error}");

    let (axis, room) = homed().await;
    let motion = axis.start_move(angle(20.0)).await.unwrap();
    tokio::time::sleep(Duration::from_secs(1)).await;
    room.lock().unwrap().answer("1", &["estop"]);
    let error = axis.finish_move(motion).await.unwrap_err();
    assert!(error.to_string().contains("came to rest at 1"), "{error}");
}

#[tokio::test(start_paused = true)]
async fn stop_works_in_every_state() {
    let (driver, room) = bench();
    let axis = open(&driver).await;
    assert!(!axis.stop().await.unwrap().moving, "never homed");
    axis.home(Instant::now() + Duration::from_mins(1)).await.unwrap();
    axis.stop().await.unwrap();
    axis.start_move(angle(30.0)).await.unwrap();
    tokio::time::sleep(Duration::from_secs(3)).await;
    let stopped = axis.stop().await.unwrap();
    assert!(!stopped.moving && (3000..6000).contains(&stopped.steps), "{stopped:?}");
    room.lock().unwrap().flags.push("FS");
    axis.stop().await.unwrap();
    room.lock().unwrap().flags.clear();
    // An axis that does not brake gets the emergency stop.
    room.lock().unwrap().deaf_to_stop = true;
    axis.start_move(angle(-30.0)).await.unwrap();
    assert!(!axis.stop().await.unwrap().moving);
    assert!(room.lock().unwrap().heard.contains(&"estop".to_owned()));
    // During another task's move, and with damaged replies.
    room.lock().unwrap().deaf_to_stop = false;
    let motion = axis.start_move(angle(30.0)).await.unwrap();
    room.lock()
        .unwrap()
        .faults
        .extend([("stop", Fault::FlipBit), ("stop", Fault::Silent)]);
    let (moved, stopped) = tokio::join!(axis.finish_move(motion), async {
        tokio::time::sleep(Duration::from_secs(2)).await;
        axis.stop().await
    });
    assert!(stopped.is_ok() && moved.is_err());
    // Without an answer standstill is not verified.
    room.lock()
        .unwrap()
        .faults
        .extend([("stop", Fault::Silent); TRIES as usize]);
    assert_eq!(axis.stop().await.unwrap_err().kind(), ErrorKind::Timeout);
}

#[tokio::test(start_paused = true)]
async fn a_home_that_takes_too_long_is_stopped() {
    let (driver, room) = bench();
    let axis = open(&driver).await;
    room.lock().unwrap().speed = 1.0;
    let error = axis.home(Instant::now() + Duration::from_secs(5)).await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Timeout);
    assert!(room.lock().unwrap().heard.contains(&"stop".to_owned()));
}

#[tokio::test(start_paused = true)]
async fn a_lost_link_says_so_and_can_be_opened_again() {
    let (driver, room) = bench();
    let axis = open(&driver).await;
    axis.home(Instant::now() + Duration::from_mins(1)).await.unwrap();
    let motion = axis.start_move(angle(20.0)).await.unwrap();
    room.lock().unwrap().faults.push_back(("get pos", Fault::Disconnect));
    assert_eq!(
        axis.finish_move(motion).await.unwrap_err().kind(),
        ErrorKind::Disconnected
    );
    assert_eq!(axis.stop().await.unwrap_err().kind(), ErrorKind::Disconnected);
    let again = open(&driver).await;
    assert_eq!(again.identity(), axis.identity());
    again.stop().await.unwrap();
}

#[tokio::test(start_paused = true)]
async fn axes_switches_and_thermometer_share_one_bus() {
    let (driver, room) = bench();
    let axis = open(&driver).await;
    let switch = driver
        .open_switch(&Target::parse("zaber:memory:axes?do=2").unwrap())
        .await
        .unwrap();
    let target = Target::parse("zaber:memory:axes?ai=1&c_at_0v=-50&c_at_10v=100").unwrap();
    let thermometer = driver.open_thermometer(&target).await.unwrap();
    assert!(!switch.state().await.unwrap());
    switch.set(true).await.unwrap();
    assert!(switch.state().await.unwrap() && room.lock().unwrap().outputs == [false, true, false, false]);
    assert_eq!(thermometer.read().await.unwrap().temperature.value(), 25.0);
    let (position, temperature, state) = tokio::join!(axis.position(), thermometer.read(), switch.state());
    assert!(position.is_ok() && temperature.is_ok() && state.is_ok());

    room.lock().unwrap().stuck_output = true;
    assert_eq!(
        switch.set(true).await.unwrap_err().kind(),
        ErrorKind::Fault,
        "set, but not followed"
    );
    room.lock().unwrap().volts = 0.0;
    assert_eq!(
        thermometer.read().await.unwrap_err().kind(),
        ErrorKind::Fault,
        "a broken wire is no −50 °C"
    );
    let absent = driver
        .open_switch(&Target::parse("zaber:memory:axes?do=9").unwrap())
        .await
        .unwrap();
    assert_eq!(absent.set(true).await.unwrap_err().kind(), ErrorKind::Refused);
}

#[tokio::test(start_paused = true)]
async fn wrong_addresses_are_refused_before_anything_is_opened() {
    let (driver, room) = bench();
    let open = |text: &str| Target::parse(text).unwrap();
    for text in [
        "zaber:memory:axes?axis=0",
        "zaber:memory:axes?axs=1",
        "zaber:memory:axes?device=100",
        "zaber:memory:axes?axis=x",
    ] {
        let error = driver
            .open_axis(&open(text), settings((-1.0, 1.0)))
            .await
            .err()
            .unwrap();
        assert!(matches!(error, OpenError::Address { .. }), "{text}: {error}");
    }
    assert!(matches!(
        driver.open_switch(&open("zaber:memory:axes")).await,
        Err(OpenError::Address { .. })
    ));
    assert!(matches!(
        driver.open_thermometer(&open("zaber:memory:axes?ai=1")).await,
        Err(OpenError::Address { .. })
    ));
    let nowhere = driver.open_switch(&open("zaber:memory:nowhere?do=1")).await;
    assert!(matches!(nowhere, Err(OpenError::Link { .. })));
    assert!(room.lock().unwrap().heard.is_empty());
}

/// Ids repeat after a hundred requests: a reply that old fits the request.
#[tokio::test(start_paused = true)]
async fn a_reply_a_hundred_requests_old_is_never_believed() {
    use Fault::{Replaced, Replayed};
    let faults: [&[Fault]; 6] = [
        &[Replayed],
        &[Replaced],
        &[Fault::Late(2), Replayed],
        &[Fault::Late(2), Replaced],
        &[Replayed, Replayed],
        &[Fault::Silent, Replaced],
    ];
    for faults in faults {
        let (axis, room) = homed().await;
        axis.move_to(angle(1.0)).await.unwrap();
        // Every id has now been used for a position.
        for _ in 0..60 {
            assert_eq!(axis.position().await.unwrap().steps, 1280);
        }
        // By another hand.
        room.lock().unwrap().go(6400.0);
        tokio::time::sleep(Duration::from_secs(10)).await;
        let faults = faults.iter().map(|fault| ("get pos", *fault));
        room.lock().unwrap().faults.extend(faults);
        assert_eq!(axis.position().await.unwrap().steps, 6400);
        assert!(room.lock().unwrap().faults.is_empty());
    }
}

#[tokio::test(start_paused = true)]
async fn outputs_and_temperatures_are_asked_twice() {
    use Fault::{Late, Replaced, Replayed};
    for faults in [
        [Replayed, Late(2)],
        [Replaced, Late(2)],
        [Late(2), Replayed],
        [Late(2), Replaced],
    ] {
        let (driver, room) = bench();
        let switch = driver
            .open_switch(&Target::parse("zaber:memory:axes?do=2").unwrap())
            .await
            .unwrap();
        let at = "zaber:memory:axes?ai=1&c_at_0v=-50&c_at_10v=100";
        let thermometer = driver.open_thermometer(&Target::parse(at).unwrap()).await.unwrap();
        for _ in 0..60 {
            assert!(!switch.state().await.unwrap());
        }
        room.lock().unwrap().outputs[1] = true;
        let next = |text: &'static str| faults.map(|fault| (text, fault));
        room.lock().unwrap().faults.extend(next("io get do"));
        assert!(switch.state().await.unwrap());
        for _ in 0..60 {
            assert_eq!(thermometer.read().await.unwrap().temperature.value(), 25.0);
        }
        room.lock().unwrap().volts = 6.0;
        room.lock().unwrap().faults.extend(next("io get ai"));
        assert_eq!(thermometer.read().await.unwrap().temperature.value(), 40.0);
    }
}

#[tokio::test(start_paused = true)]
async fn a_dead_controller_is_asked_as_often_as_is_stated() {
    let (axis, room) = homed().await;
    for action in ["get pos", "stop"] {
        room.lock().unwrap().heard.clear();
        room.lock().unwrap().faults = [(action, Fault::Silent); 40].into();
        let error = match action {
            "stop" => axis.stop().await.unwrap_err(),
            _ => axis.position().await.unwrap_err(),
        };
        assert_eq!(error.kind(), ErrorKind::Timeout, "{error}");
        assert_eq!(room.lock().unwrap().heard.len(), TRIES as usize, "{action}");
    }
}

/// What the driver says of a rail is in millimetres.
#[tokio::test(start_paused = true)]
async fn a_rail_is_no_angle_in_any_message() {
    let (driver, room) = bench();
    let mm = |value: f64| Millimetre::new(value).unwrap();
    let scale = AxisScale::new(100, 1, mm(0.0), Sense::Positive).unwrap();
    let rail = |limit: (f64, f64), acceleration: f64| {
        AxisSettings::new(scale, (mm(limit.0), mm(limit.1)), 10.0, acceleration).unwrap()
    };
    let target = Target::parse("zaber:memory:axes?axis=3").unwrap();
    let mut stated = Vec::new();
    for settings in [rail((100.0, 9000.0), 200.0), rail((100.0, 900.0), 1e-9)] {
        stated.push(
            driver
                .open_linear_axis(&target, settings)
                .await
                .err()
                .unwrap()
                .to_string(),
        );
    }
    let axis = driver
        .open_linear_axis(&target, rail((100.0, 900.0), 200.0))
        .await
        .unwrap();
    axis.home(Instant::now() + Duration::from_mins(1)).await.unwrap();
    stated.push(axis.start_move(mm(50.0)).await.unwrap_err().to_string());
    let there = axis.move_to(mm(150.0)).await.unwrap();
    assert_eq!((there.steps, there.place), (15_000, mm(150.0)));
    stated.push(there.place.to_string());
    room.lock().unwrap().stall_at = Some(20_000.0);
    stated.push(axis.move_to(mm(300.0)).await.unwrap_err().to_string());
    for text in &stated {
        assert!(!text.contains('°') && !text.contains("deg"), "{text}");
    }
    assert!(
        stated[0].contains("limit_mm") && stated[0].contains("9000 mm is outside"),
        "{}",
        stated[0]
    );
    assert!(
        stated[1].contains("accel_mm_s2") && stated[2].contains("100 mm to 900 mm"),
        "{stated:?}"
    );
}
