//! The driver of Parker XLi axes against its twin, over bytes in memory, on a paused clock.

#![expect(clippy::unwrap_used, reason = "a test")]

use std::sync::Arc;
use std::time::Duration;

use isolux_axes::DRIVERS;
use isolux_darkroom::Darkroom;
use isolux_device::{Axis, AxisScale, AxisSettings, ErrorKind, OpenError, Sense, Target};
use isolux_transport::{MemoryLinks, Ports};
use isolux_units::AxisAngle;
use isolux_virtual::twins::Choice;
use isolux_virtual::{Instrument, Serving, VirtualRoom};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::time::{Instant, sleep};

fn angle(deg: f64) -> AxisAngle {
    AxisAngle::new(deg).unwrap()
}

fn settings(speed_deg_s: f64) -> AxisSettings {
    let scale = AxisScale::new(12_800, 3, angle(0.0), Sense::Positive).unwrap();
    AxisSettings::new(scale, (angle(-180.0), angle(360.0)), speed_deg_s, 40.0).unwrap()
}

struct Bench {
    room: VirtualRoom,
    links: Arc<MemoryLinks>,
    _serving: Serving,
}

fn bench(darkroom: &str) -> Bench {
    let mut choice = Choice::default();
    choice.choose(Instrument::Axes, "parker-easi").unwrap();
    let room = VirtualRoom::open_with(Darkroom::parse(darkroom).unwrap(), &choice);
    let links = Arc::new(MemoryLinks::default());
    let serving = room.listen(&links).unwrap();
    Bench {
        room,
        links,
        _serving: serving,
    }
}

impl Bench {
    async fn open(&self, rest: &str, speed_deg_s: f64) -> Result<Box<dyn Axis>, OpenError> {
        let driver = DRIVERS.iter().find(|driver| driver.name == "parker-easi").unwrap();
        let factory = (driver.factories)(Ports::new(self.links.clone())).axis.unwrap();
        let target = Target::parse(&format!("parker-easi:memory:axes?{rest}")).unwrap();
        factory.open_axis(&target, settings(speed_deg_s)).await
    }

    async fn gamma(&self) -> Box<dyn Axis> {
        self.open("address=2&home=-,0,-10,40,1", 20.0).await.unwrap()
    }

    fn truth_deg(&self) -> f64 {
        self.room
            .with_world(|world, now_s| world.axis(isolux_virtual::AxisName::Gamma).position(now_s))
    }
}

fn soon() -> Instant {
    Instant::now() + Duration::from_mins(2)
}

#[tokio::test(start_paused = true)]
async fn it_homes_moves_and_knows_across_sessions_where_it_is() {
    let bench = bench("[axis.gamma]\nstart_deg = 33.0\n");
    let gamma = bench.gamma().await;
    assert_eq!(
        (gamma.identity().firmware.as_deref(), gamma.identity().serial.as_deref()),
        (Some("2.18"), Some("80042"))
    );
    // 20 °/s are 21.33 rev/s: down to hundredths, never faster.
    assert!(gamma.settings().speed() <= 20.0 && gamma.settings().speed() > 19.98);
    assert!(!gamma.position().await.unwrap().homed);
    let error = gamma.move_to(angle(10.0)).await.unwrap_err();
    assert!(
        error.kind() == ErrorKind::Fault && error.to_string().contains("home the axis first"),
        "{error}"
    );
    assert_eq!(bench.truth_deg(), 33.0, "nothing moved");
    let home = gamma.home(soon()).await.unwrap();
    assert!(home.homed && home.steps == 0);
    for deg in [62.5, -45.0, 180.0, 0.1] {
        let at = gamma.move_to(angle(deg)).await.unwrap();
        assert!(
            (at.place.value() - deg).abs() < 0.000_2 && (bench.truth_deg() - deg).abs() < 0.000_2,
            "{at:?}"
        );
    }
    let out = gamma.move_to(angle(400.0)).await.unwrap_err();
    assert_eq!(out.kind(), ErrorKind::OutOfTravel);
    drop(gamma);
    sleep(Duration::from_secs(1)).await;
    let again = bench.gamma().await.position().await.unwrap();
    assert!(again.homed && (again.place.value() - 0.1).abs() < 0.000_2, "{again:?}");
}

#[tokio::test(start_paused = true)]
async fn a_stop_is_verified_and_a_second_axis_shares_the_line() {
    let bench = bench("");
    let (gamma, c) = (
        bench.gamma().await,
        bench.open("address=1&home=-,0,-10,40,1", 20.0).await.unwrap(),
    );
    gamma.home(soon()).await.unwrap();
    c.home(soon()).await.unwrap();
    gamma.start_move(angle(150.0)).await.unwrap();
    let rest = c.move_to(angle(90.0)).await.unwrap();
    assert!((rest.place.value() - 90.0).abs() < 0.000_2);
    // Another target on the way would be ignored by the drive: it is refused, and the axis stopped.
    let error = gamma.start_move(angle(-150.0)).await.unwrap_err();
    assert!(error.to_string().contains("still moving"), "{error}");
    let stopped = gamma.position().await.unwrap();
    assert!(!stopped.moving && stopped.place.value() < 149.0, "{stopped:?}");
    gamma.start_move(angle(-150.0)).await.unwrap();
    sleep(Duration::from_secs(2)).await;
    let stopped = gamma.stop().await.unwrap();
    assert!(!stopped.moving);
    let there = bench.truth_deg();
    sleep(Duration::from_secs(5)).await;
    assert_eq!(bench.truth_deg(), there);
    assert!((stopped.place.value() - there).abs() < 0.000_2);
}

#[tokio::test(start_paused = true)]
async fn a_tripped_drive_and_a_power_cut_are_told_apart_and_homing_recovers() {
    let bench = bench("[[fault]]\ninstrument = \"axes\"\nkind = \"stall\"\nat_s = 60.0\n");
    let gamma = bench.gamma().await;
    gamma.home(soon()).await.unwrap();
    sleep(Duration::from_mins(1)).await;
    let error = gamma.move_to(angle(120.0)).await.unwrap_err();
    assert!(
        error.kind() == ErrorKind::Fault && error.to_string().contains("over current"),
        "{error}"
    );
    let error = gamma.position().await.unwrap_err().to_string();
    assert!(error.contains("over current"), "{error}");
    let home = gamma.home(soon()).await.unwrap();
    assert!(
        home.homed && bench.truth_deg().abs() < 0.000_2,
        "{home:?} {}",
        bench.truth_deg()
    );
    gamma.move_to(angle(20.0)).await.unwrap();
    drop(gamma);
    sleep(Duration::from_secs(1)).await;
    // Power off and on: the count is 0 wherever the axis stands.
    let mut line = tokio::io::duplex(64);
    let room = bench.room.clone();
    let serving = tokio::spawn(async move { room.serve(Instrument::Axes, line.1).await });
    line.0.write_all(b"2Z\r").await.unwrap();
    sleep(Duration::from_secs(2)).await;
    line.0.write_all(b"2R(PA)\r").await.unwrap();
    let mut stated = [0; 4];
    line.0.read_exact(&mut stated).await.unwrap();
    assert_eq!(&stated, b"2Z\r2");
    drop(line.0);
    serving.await.unwrap();
    let gamma = bench.gamma().await;
    let position = gamma.position().await.unwrap();
    assert!(!position.homed && position.steps == 0, "{position:?}");
    let error = gamma.move_to(angle(20.0)).await.unwrap_err();
    assert!(error.to_string().contains("home the axis first"), "{error}");
}

#[tokio::test(start_paused = true)]
async fn a_dead_drive_and_impossible_dynamics_are_one_message() {
    let bench = bench("");
    let error = bench.open("address=7", 20.0).await.err().unwrap();
    assert!(error.to_string().contains("address=7: no answer to R(EX)"), "{error}");
    let error = bench.open("address=2", 60.0).await.err().unwrap().to_string();
    assert!(
        error.contains("speed_deg_s = 60") && error.contains("this drive can do"),
        "{error}"
    );
}
