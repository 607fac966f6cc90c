//! The Oriental Motor driver against a scripted drive on an in-memory line, with the clock paused.
//!
//! The drive below was written from the register map, not from the codec: it has its own check and parser.

use std::collections::{HashMap, VecDeque};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use isolux_axes::OrientalAzDriver;
use isolux_device::{Axis, AxisFactory, AxisScale, AxisSettings, DeviceError, ErrorKind, OpenError, Sense, Target};
use isolux_transport::{MemoryLinks, Ports, TRIES};
use isolux_units::AxisAngle;
use tokio::io::{AsyncReadExt, AsyncWriteExt, DuplexStream};
use tokio::time::Instant;

/// What goes wrong with the next answer to a request at a register.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Fault {
    Silent,
    Late(u64),
    FlipBit,
    Disconnect,
    Garbage,
    /// The request comes back instead of the answer.
    Echo,
    /// Another unit answers.
    OtherUnit,
    /// The answer to an earlier request like this one comes first, the true one after it.
    Replayed,
    /// The answer to an earlier request like this one comes instead of the true one.
    Replaced,
    /// Exception 04.
    Refused,
}

const OUTPUTS: u16 = 0x0178;
const POSITIONS: u16 = 0x00C6;
const INPUTS: u16 = 0x007C;
const DIRECT: u16 = 0x0058;

struct Room {
    /// Position at `since`, target, steps a second.
    from: f64,
    since: Instant,
    target: f64,
    speed: f64,
    home_end: bool,
    coordinates_set: bool,
    alarm: u16,
    stall_at: Option<f64>,
    /// The shaft was turned by so many steps by hand.
    pushed: i32,
    deaf_to_stop: bool,
    deaf_to_zero: bool,
    ignores_moves: bool,
    ignores_home: bool,
    has_limits: bool,
    registers: HashMap<u16, u16>,
    faults: VecDeque<(u16, Fault)>,
    /// (first register, values) of every write.
    written: Vec<(u16, Vec<u16>)>,
    read: usize,
}

impl Room {
    fn new() -> Self {
        let mut room = Self {
            from: 777.0,
            since: Instant::now(),
            target: 777.0,
            speed: 1280.0,
            home_end: false,
            coordinates_set: false,
            alarm: 0,
            stall_at: None,
            pushed: 0,
            deaf_to_stop: false,
            deaf_to_zero: false,
            ignores_moves: false,
            ignores_home: false,
            has_limits: true,
            registers: HashMap::new(),
            faults: VecDeque::new(),
            written: vec![],
            read: 0,
        };
        room.power_on();
        room
    }

    /// What the drive's memory holds at power-on.
    fn power_on(&mut self) {
        self.registers.clear();
        for (at, value) in [(0x5E, 1000), (0x60, 1_000_000), (0x62, 1_000_000)] {
            self.set_long(at, value);
        }
        self.go_to_rest();
    }

    fn set_long(&mut self, at: u16, value: i32) {
        self.registers.insert(at, (value >> 16) as u16);
        self.registers.insert(at + 1, value as u16);
    }

    fn position(&self) -> f64 {
        let way = self.since.elapsed().as_secs_f64() * self.speed;
        let distance = self.target - self.from;
        let here = self.from + distance.signum() * way.min(distance.abs());
        match self.stall_at {
            Some(wall) if (self.from < wall) == (here >= wall) && distance != 0.0 => wall,
            _ => here.round(),
        }
    }

    fn moving(&self) -> bool {
        self.position() != self.target
    }

    fn go(&mut self, target: f64) {
        (self.from, self.since, self.target) = (self.position(), Instant::now(), target);
    }

    fn go_to_rest(&mut self) {
        let here = self.position();
        self.go(here);
        (self.from, self.target) = (here, here);
    }

    fn stop_held(&self) -> bool {
        self.registers
            .get(&(INPUTS + 1))
            .is_some_and(|inputs| inputs >> 5 & 1 == 1)
            && !self.deaf_to_stop
    }

    fn word(&mut self, at: u16) -> u16 {
        let long = |value: i32, low: bool| if low { value as u16 } else { (value >> 16) as u16 };
        let low = at % 2 == 1;
        let (position, pushed) = (self.position() as i32, self.pushed);
        match at & !1 {
            OUTPUTS => {
                let upper = u32::from(self.home_end) | u32::from(self.coordinates_set) << 1;
                let ready = !self.moving() && !self.stop_held() && self.alarm == 0;
                let lower = u32::from(self.alarm != 0) << 1
                    | u32::from(ready) << 4
                    | u32::from(self.moving()) << 6
                    | u32::from(!self.moving() && pushed == 0) << 10;
                long((upper << 16 | lower) as i32, low)
            }
            0x80 => long(self.alarm.into(), low),
            POSITIONS => long(position, low),
            0xCC => long(position + pushed, low),
            0x386 => long(if self.has_limits { 1 } else { -1 }, low),
            0x388 => long(100_000, low),
            0x38A => long(-100_000, low),
            _ => self.registers.get(&at).copied().unwrap_or(0),
        }
    }

    fn write(&mut self, from: u16, values: &[u16]) {
        if from == INPUTS {
            let before = self.registers.get(&(INPUTS + 1)).copied().unwrap_or(0);
            if values[1] >> 4 & 1 == 1 && before >> 4 & 1 == 0 && !self.ignores_home {
                (self.coordinates_set, self.home_end) = (true, true);
                self.go(0.0);
            }
            if values[1] >> 5 & 1 == 1 && !self.deaf_to_stop {
                self.go_to_rest();
            }
        }
        if from == 0x180 && values[1] == 1 {
            self.alarm = 0;
        }
        for (n, value) in values.iter().enumerate() {
            self.registers.insert(from + n as u16, *value);
        }
        if from == DIRECT && values[15] == 1 && !self.ignores_moves && !self.stop_held() && self.alarm == 0 {
            let long = |n: usize| (u32::from(values[2 * n]) << 16 | u32::from(values[2 * n + 1])) as i32;
            assert_eq!((long(1), long(6)), (1, 1000), "absolute positioning, full current");
            match long(3) {
                0 if self.deaf_to_zero => {}
                0 => self.go_to_rest(),
                _ => self.go(f64::from(long(2))),
            }
        }
    }
}

fn check(bytes: &[u8]) -> [u8; 2] {
    let mut register = 0xFFFF_u32;
    for byte in bytes {
        register ^= u32::from(*byte);
        for _ in 0..8 {
            let carry = register & 1;
            register >>= 1;
            if carry == 1 {
                register ^= 0xA001;
            }
        }
    }
    [register as u8, (register >> 8) as u8]
}

fn checked(mut body: Vec<u8>) -> Vec<u8> {
    body.extend(check(&body));
    body
}

async fn serve(room: Arc<Mutex<Room>>, mut stream: DuplexStream) {
    let mut inbox: Vec<u8> = Vec::new();
    let mut before: HashMap<Vec<u8>, Vec<u8>> = HashMap::new();
    let mut buffer = [0; 256];
    loop {
        match stream.read(&mut buffer).await {
            Ok(0) | Err(_) => return,
            Ok(count) => inbox.extend(&buffer[..count]),
        }
        let length = match inbox.get(1) {
            Some(0x10) if inbox.len() > 6 => 9 + usize::from(inbox[6]),
            Some(0x10) | None => continue,
            Some(_) => 8,
        };
        if inbox.len() < length {
            continue;
        }
        let request: Vec<u8> = inbox.drain(..length).collect();
        let (body, crc) = request.split_at(length - 2);
        assert_eq!(check(body), crc, "the host's check");
        if body[0] != 1 {
            continue;
        }
        let word = |at: usize| u16::from_be_bytes([body[at], body[at + 1]]);
        let (from, count) = (word(2), word(4));
        let (answer, fault) = {
            let mut room = room.lock().unwrap();
            let fault = room
                .faults
                .front()
                .copied()
                .filter(|(at, _)| *at == from)
                .map(|(_, fault)| fault);
            if fault.is_some() {
                room.faults.pop_front();
            }
            let mut answer = vec![1, body[1]];
            if fault == Some(Fault::Refused) {
                answer = vec![1, body[1] | 0x80, 4];
            } else if body[1] == 3 {
                room.read += 1;
                answer.push(count as u8 * 2);
                for at in from..from + count {
                    answer.extend(room.word(at).to_be_bytes());
                }
            } else {
                let values: Vec<u16> = body[7..]
                    .chunks(2)
                    .map(|pair| u16::from_be_bytes([pair[0], pair[1]]))
                    .collect();
                room.write(from, &values);
                room.written.push((from, values));
                answer.extend(&body[2..6]);
            }
            (checked(answer), fault)
        };
        let old = before.insert(request.clone(), answer.clone());
        let mut frame = answer;
        match fault {
            Some(Fault::Silent) => continue,
            Some(Fault::Disconnect) => return,
            Some(Fault::FlipBit) => {
                let at = frame.len() - 3;
                frame[at] ^= 4;
            }
            Some(Fault::Replayed) => frame = [old.unwrap_or_default(), frame].concat(),
            Some(Fault::Replaced) => frame = old.unwrap_or_default(),
            Some(Fault::Echo) => frame = request,
            Some(Fault::OtherUnit) => {
                frame.truncate(frame.len() - 2);
                frame[0] = 2;
                frame = checked(frame);
            }
            Some(Fault::Garbage) => frame = b"\x00\xFF\x01\x03garbage".to_vec(),
            Some(Fault::Late(milliseconds)) => tokio::time::sleep(Duration::from_millis(milliseconds)).await,
            Some(Fault::Refused) | None => tokio::time::sleep(Duration::from_millis(2)).await,
        }
        if stream.write_all(&frame).await.is_err() {
            return;
        }
    }
}

fn bench() -> (OrientalAzDriver, Arc<Mutex<Room>>) {
    let links = MemoryLinks::default();
    let mut listener = links.listen("axes").unwrap();
    let room = Arc::new(Mutex::new(Room::new()));
    let twin = Arc::clone(&room);
    tokio::spawn(async move {
        while let Some(stream) = listener.accept().await {
            tokio::spawn(serve(Arc::clone(&twin), stream));
        }
    });
    (OrientalAzDriver::new(Ports::new(Arc::new(links))), room)
}

fn angle(degrees: f64) -> AxisAngle {
    AxisAngle::new(degrees).unwrap()
}

/// 1280 steps a degree: 1 °/s is 1280 Hz, as the room moves.
fn settings(limit: (f64, f64)) -> AxisSettings {
    let scale = AxisScale::new(1280, 1, angle(0.0), Sense::Positive).unwrap();
    AxisSettings::new(scale, (angle(limit.0), angle(limit.1)), 1.0, 10.0).unwrap()
}

fn target(text: &str) -> Target {
    Target::parse(text).unwrap()
}

async fn open(driver: &OrientalAzDriver) -> Box<dyn Axis> {
    let target = target("oriental-az:memory:axes?unit=1");
    driver.open_axis(&target, settings((-75.0, 75.0))).await.unwrap()
}

fn soon() -> Instant {
    Instant::now() + Duration::from_mins(1)
}

async fn homed() -> (Box<dyn Axis>, Arc<Mutex<Room>>) {
    let (driver, room) = bench();
    let axis = open(&driver).await;
    axis.home(soon()).await.unwrap();
    (axis, room)
}

/// Every write that starts a motion.
fn moves(room: &Mutex<Room>) -> usize {
    let room = room.lock().unwrap();
    room.written
        .iter()
        .filter(|(from, values)| *from == DIRECT && values[15] == 1)
        .count()
}

/// How many requests the drive has understood.
fn requested(room: &Mutex<Room>) -> usize {
    let room = room.lock().unwrap();
    room.read + room.written.len()
}

fn stopped(room: &Mutex<Room>) -> bool {
    room.lock().unwrap().written.contains(&(INPUTS, vec![0, 0x20]))
}

#[tokio::test(start_paused = true)]
async fn opens_homes_moves_and_reads_back() {
    let (driver, room) = bench();
    let axis = open(&driver).await;
    assert_eq!(axis.identity().model, "Oriental Motor AZ");
    {
        let room = room.lock().unwrap();
        // 1280 Hz and 12800 Hz/s, upper word first, with the trigger off.
        assert!(room.written.contains(&(0x66, vec![0, 0])));
        assert!(room.written.contains(&(0x5E, vec![0, 1280, 0, 12_800, 0, 12_800])));
    }
    assert!(!axis.position().await.unwrap().homed);
    let refused = axis.move_to(angle(10.0)).await.unwrap_err();
    assert!(
        refused.kind() == ErrorKind::Fault && refused.to_string().contains("home the axis"),
        "{refused}"
    );
    assert_eq!(moves(&room), 0, "nothing moved");

    let home = axis.home(soon()).await.unwrap();
    assert!(home.homed && home.steps == 0 && !home.moving);
    assert_eq!(
        room.lock().unwrap().written.last(),
        Some(&(INPUTS, vec![0, 0])),
        "ZHOME is released"
    );
    let motion = axis.start_move(angle(12.5)).await.unwrap();
    assert_eq!(
        (motion.from_steps, motion.target_steps, motion.target),
        (0, 16_000, angle(12.5))
    );
    assert!(axis.position().await.unwrap().moving);
    let there = axis.finish_move(motion).await.unwrap();
    assert_eq!((there.steps, there.place, there.moving), (16_000, angle(12.5), false));
    assert_eq!(
        axis.move_to(angle(12.5)).await.unwrap().steps,
        16_000,
        "a move to where it is ends at once"
    );
    assert_eq!(axis.move_to(angle(-12.5)).await.unwrap().steps, -16_000);
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
    assert_eq!(moves(&room), 0);
    let (driver, room) = bench();
    let at = target("oriental-az:memory:axes");
    let error = driver.open_axis(&at, settings((-180.0, 180.0))).await.err().unwrap();
    assert!(
        matches!(error, OpenError::Device(DeviceError::OutOfTravel { .. })),
        "{error}"
    );
    // Without limits of the drive's own those of its counter remain: ±2³¹ steps are 1.7 million degrees.
    room.lock().unwrap().has_limits = false;
    assert!(driver.open_axis(&at, settings((-180.0, 180.0))).await.is_ok());
    assert!(driver.open_axis(&at, settings((-180.0, 1.8e6))).await.is_err());
}

#[tokio::test(start_paused = true)]
async fn dynamics_that_the_drive_cannot_do_are_refused() {
    let (driver, _room) = bench();
    let scale = AxisScale::new(1280, 1, angle(0.0), Sense::Positive).unwrap();
    for (speed, accel, key) in [
        (1e-4, 1.0, "speed_deg_s"),
        (1e4, 1.0, "speed_deg_s"),
        (1.0, 1e-4, "accel_deg_s2"),
    ] {
        let settings = AxisSettings::new(scale, (angle(-1.0), angle(1.0)), speed, accel).unwrap();
        let error = driver
            .open_axis(&target("oriental-az:memory:axes"), settings)
            .await
            .err()
            .unwrap();
        assert!(error.to_string().contains(key), "{error}");
    }
}

#[tokio::test(start_paused = true)]
async fn damaged_late_and_missing_answers_are_asked_for_again() {
    let (axis, room) = homed().await;
    axis.move_to(angle(10.0)).await.unwrap();
    for fault in [
        Fault::FlipBit,
        Fault::Silent,
        Fault::Garbage,
        Fault::Echo,
        Fault::OtherUnit,
        Fault::Late(700),
        Fault::Replayed,
    ] {
        for at in [POSITIONS, OUTPUTS, 0x60] {
            room.lock().unwrap().faults.extend([(at, fault), (at, fault)]);
            let position = axis.position().await.unwrap();
            assert_eq!(position.steps, 12_800, "{fault:?}");
            assert!(room.lock().unwrap().faults.is_empty());
        }
    }
    for (fault, kind) in [
        (Fault::Silent, ErrorKind::Timeout),
        (Fault::FlipBit, ErrorKind::Malformed),
    ] {
        room.lock().unwrap().faults.extend([(POSITIONS, fault); TRIES as usize]);
        assert_eq!(axis.position().await.unwrap_err().kind(), kind);
    }
    room.lock().unwrap().faults.push_back((POSITIONS, Fault::Refused));
    let error = axis.position().await.unwrap_err();
    assert!(
        error.to_string().contains("exception 04h (server device failure)"),
        "{error}"
    );
    room.lock()
        .unwrap()
        .faults
        .extend([(POSITIONS, Fault::Echo); TRIES as usize]);
    let error = axis.position().await.unwrap_err();
    assert!(error.to_string().contains("switch off the echo"), "{error}");
}

#[tokio::test(start_paused = true)]
async fn a_late_position_never_becomes_the_next_one() {
    let (axis, room) = homed().await;
    axis.move_to(angle(1.0)).await.unwrap();
    // The first answer is held back for 700 ms; meanwhile the axis is somewhere else.
    room.lock().unwrap().faults.push_back((POSITIONS, Fault::Late(700)));
    assert_eq!(axis.position().await.unwrap().steps, 1280);
    assert_eq!(axis.move_to(angle(5.0)).await.unwrap().steps, 6400);
    for _ in 0..10 {
        assert_eq!(axis.position().await.unwrap().steps, 6400);
    }
}

/// RTU has no request numbers: an old answer of the same form fits every request.
#[tokio::test(start_paused = true)]
async fn an_old_answer_is_never_believed() {
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
        assert_eq!(axis.move_to(angle(1.0)).await.unwrap().steps, 1280);
        assert_eq!(axis.position().await.unwrap().steps, 1280);
        // By another hand.
        room.lock().unwrap().go(6400.0);
        tokio::time::sleep(Duration::from_secs(10)).await;
        let faults = faults.iter().map(|fault| (POSITIONS, *fault));
        room.lock().unwrap().faults.extend(faults);
        assert_eq!(axis.position().await.unwrap().steps, 6400);
        assert!(room.lock().unwrap().faults.is_empty());
    }
}

#[tokio::test(start_paused = true)]
async fn a_command_that_is_acknowledged_and_ignored_is_seen() {
    let (axis, room) = homed().await;
    room.lock().unwrap().ignores_moves = true;
    let error = axis.start_move(angle(20.0)).await.unwrap_err();
    assert!(
        error.kind() == ErrorKind::Fault && error.to_string().contains("acknowledged and ignored"),
        "{error}"
    );
    room.lock().unwrap().ignores_moves = false;
    axis.move_to(angle(2.0)).await.unwrap();
    // The home command, too.
    room.lock().unwrap().ignores_home = true;
    let error = axis.home(soon()).await.unwrap_err();
    assert!(error.to_string().contains("stayed at 2560"), "{error}");
    // And one that is ignored because STOP is held says why.
    room.lock().unwrap().registers.insert(INPUTS + 1, 0x20);
    let error = axis.start_move(angle(20.0)).await.unwrap_err();
    assert!(error.to_string().contains("STOP or FREE is held"), "{error}");
}

#[tokio::test(start_paused = true)]
async fn a_stall_is_seen_with_and_without_an_alarm() {
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
    assert!(stopped(&room), "the axis was stopped");

    let (axis, room) = homed().await;
    let motion = axis.start_move(angle(20.0)).await.unwrap();
    room.lock().unwrap().alarm = 0x30;
    let error = axis.finish_move(motion).await.unwrap_err();
    assert!(error.to_string().contains("alarm 30h (overload"), "{error}");
    assert_eq!(axis.position().await.unwrap_err().kind(), ErrorKind::Fault);
    let error = axis.start_move(angle(1.0)).await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Fault, "no move under an alarm");
    axis.home(soon()).await.unwrap();
    axis.move_to(angle(1.0)).await.unwrap();
}

#[tokio::test(start_paused = true)]
async fn a_limit_a_lost_reference_and_a_wrong_end_are_told_apart() {
    let (axis, room) = homed().await;
    let motion = axis.start_move(angle(20.0)).await.unwrap();
    room.lock().unwrap().alarm = 0x67;
    let error = axis.finish_move(motion).await.unwrap_err();
    assert!(error.to_string().contains("software limit reached"), "{error}");

    let (axis, room) = homed().await;
    let motion = axis.start_move(angle(20.0)).await.unwrap();
    tokio::time::sleep(Duration::from_secs(1)).await;
    room.lock().unwrap().coordinates_set = false;
    let error = axis.finish_move(motion).await.unwrap_err();
    assert!(error.to_string().contains("reference was lost"), "{error}");

    let (axis, room) = homed().await;
    let motion = axis.start_move(angle(20.0)).await.unwrap();
    tokio::time::sleep(Duration::from_secs(1)).await;
    room.lock().unwrap().go_to_rest();
    let error = axis.finish_move(motion).await.unwrap_err();
    assert!(error.to_string().contains("came to rest at 1"), "{error}");
}

#[tokio::test(start_paused = true)]
async fn a_shaft_pushed_at_rest_and_a_cut_of_power_are_told_apart() {
    let (axis, room) = homed().await;
    axis.move_to(angle(2.0)).await.unwrap();
    room.lock().unwrap().pushed = 40;
    for error in [
        axis.position().await.unwrap_err(),
        axis.start_move(angle(1.0)).await.unwrap_err(),
    ] {
        let stated = error.to_string();
        assert!(
            stated.contains("displaced while stationary: it is at 2600, the drive holds 2560"),
            "{stated}"
        );
    }
    room.lock().unwrap().pushed = 0;
    assert_eq!(axis.position().await.unwrap().steps, 2560);

    // The absolute encoder keeps its coordinates; what was in between nobody knows.
    room.lock().unwrap().power_on();
    assert!(!axis.position().await.unwrap().homed);
    let error = axis.start_move(angle(1.0)).await.unwrap_err();
    assert!(error.to_string().contains("without power: home the axis"), "{error}");
    assert!(axis.home(soon()).await.unwrap().homed);
    axis.move_to(angle(1.0)).await.unwrap();

    let motion = axis.start_move(angle(20.0)).await.unwrap();
    tokio::time::sleep(Duration::from_secs(1)).await;
    room.lock().unwrap().power_on();
    let error = axis.finish_move(motion).await.unwrap_err();
    assert!(error.to_string().contains("reference was lost"), "{error}");
}

#[tokio::test(start_paused = true)]
async fn stop_works_in_every_state() {
    let (driver, room) = bench();
    let axis = open(&driver).await;
    assert!(!axis.stop().await.unwrap().moving, "never homed");
    axis.home(soon()).await.unwrap();
    axis.stop().await.unwrap();
    axis.start_move(angle(30.0)).await.unwrap();
    tokio::time::sleep(Duration::from_secs(3)).await;
    let rest = axis.stop().await.unwrap();
    assert!(!rest.moving && (3000..6000).contains(&rest.steps), "{rest:?}");
    assert_eq!(
        room.lock().unwrap().written.last(),
        Some(&(INPUTS, vec![0, 0])),
        "STOP is released"
    );
    room.lock().unwrap().alarm = 0x30;
    axis.stop().await.unwrap();
    room.lock().unwrap().alarm = 0;
    // Where STOP is assigned to something else, a move at speed 0 stops it.
    room.lock().unwrap().deaf_to_stop = true;
    axis.start_move(angle(-30.0)).await.unwrap();
    assert!(!axis.stop().await.unwrap().moving);
    // One that does not obey at all is not verified at rest.
    room.lock().unwrap().deaf_to_zero = true;
    axis.start_move(angle(30.0)).await.unwrap();
    assert_eq!(axis.stop().await.unwrap_err().kind(), ErrorKind::Timeout);
    room.lock().unwrap().deaf_to_stop = false;
    axis.stop().await.unwrap();
    // During another task's move, and with damaged answers.
    let motion = axis.start_move(angle(-30.0)).await.unwrap();
    room.lock()
        .unwrap()
        .faults
        .extend([(INPUTS, Fault::FlipBit), (INPUTS, Fault::Silent)]);
    let (moved, stopped) = tokio::join!(axis.finish_move(motion), async {
        tokio::time::sleep(Duration::from_secs(2)).await;
        axis.stop().await
    });
    assert!(stopped.is_ok() && moved.is_err(), "{stopped:?} {moved:?}");
    // Without an answer standstill is not verified.
    room.lock()
        .unwrap()
        .faults
        .extend([(INPUTS, Fault::Silent); TRIES as usize]);
    assert_eq!(axis.stop().await.unwrap_err().kind(), ErrorKind::Timeout);
}

#[tokio::test(start_paused = true)]
async fn a_home_that_takes_too_long_or_finds_nothing_is_stopped() {
    let (driver, room) = bench();
    let axis = open(&driver).await;
    room.lock().unwrap().speed = 1.0;
    let error = axis.home(Instant::now() + Duration::from_secs(5)).await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Timeout);
    assert!(stopped(&room));

    let (driver, room) = bench();
    let axis = open(&driver).await;
    room.lock().unwrap().ignores_home = true;
    let error = axis.home(soon()).await.unwrap_err();
    assert!(error.to_string().contains("without a reference"), "{error}");
    assert!(stopped(&room));
}

#[tokio::test(start_paused = true)]
async fn a_lost_link_says_so_and_can_be_opened_again() {
    let (driver, room) = bench();
    let axis = open(&driver).await;
    axis.home(soon()).await.unwrap();
    let motion = axis.start_move(angle(20.0)).await.unwrap();
    room.lock().unwrap().faults.push_back((POSITIONS, Fault::Disconnect));
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
async fn wrong_addresses_are_refused_before_anything_is_opened() {
    let (driver, room) = bench();
    for (text, part) in [
        ("oriental-az:memory:axes?unit=0", "unit=0 is not 1 to 247"),
        ("oriental-az:memory:axes?unit=248", "unit=248 is not 1 to 247"),
        ("oriental-az:memory:axes?unit=x", "unit=x"),
        (
            "oriental-az:memory:axes?axis=1",
            "unknown option axis; known: unit, baud, tolerance",
        ),
        (
            "oriental-az:memory:axes?baud=4800",
            "baud=4800: the drive has 9600, 19200",
        ),
    ] {
        let error = driver
            .open_axis(&target(text), settings((-1.0, 1.0)))
            .await
            .err()
            .unwrap();
        assert!(
            matches!(&error, OpenError::Address { .. }) && error.to_string().contains(part),
            "{text}: {error}"
        );
    }
    let nowhere = driver
        .open_axis(&target("oriental-az:memory:nowhere"), settings((-1.0, 1.0)))
        .await;
    assert!(matches!(nowhere, Err(OpenError::Link { .. })));
    assert_eq!(room.lock().unwrap().read, 0);
    // A unit that is not there does not answer.
    let absent = driver
        .open_axis(&target("oriental-az:memory:axes?unit=9"), settings((-1.0, 1.0)))
        .await;
    let error = absent.err().unwrap().to_string();
    assert!(error.contains("no answer"), "{error}");
}

#[tokio::test(start_paused = true)]
async fn a_dead_drive_is_asked_as_often_as_is_stated() {
    let (axis, room) = homed().await;
    for (at, reads) in [(OUTPUTS, true), (INPUTS, false)] {
        let before = requested(&room);
        room.lock().unwrap().faults = [(at, Fault::Silent); 40].into();
        let error = if reads {
            axis.position().await
        } else {
            axis.stop().await
        };
        assert_eq!(error.unwrap_err().kind(), ErrorKind::Timeout);
        assert_eq!(requested(&room) - before, TRIES as usize, "{at:04X}");
    }
}
