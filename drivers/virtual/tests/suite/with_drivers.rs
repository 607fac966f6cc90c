//! The drivers against the twins, over bytes in memory, on a paused clock: hours in seconds.

use std::sync::Arc;
use std::time::Duration;

use isolux_axes::ZaberDriver;
use isolux_darkroom::{Darkroom, Kind, Observation};
use isolux_device::{
    Axis, AxisFactory, AxisScale, AxisSettings, DeviceError, LuxMeter, LuxRange, Sense, SpectroradiometerFactory,
    Switch, SwitchFactory, Target, ThermometerFactory,
};
use isolux_luxmeter::KONICA_T10A;
use isolux_spectroradiometer::OceanOoiDriver;
use isolux_transport::{MemoryLinks, Ports, SystemLinks};
use isolux_units::AxisAngle;
use isolux_virtual::outlet::{Offer, offer};
use isolux_virtual::{BUILT_IN, Instrument, Serving, Switches, VirtualRoom};
use tokio::time::Instant;

struct Bench {
    room: VirtualRoom,
    c: Box<dyn Axis>,
    gamma: Box<dyn Axis>,
    lamp: Box<dyn Switch>,
    shutter: Box<dyn Switch>,
    baffle: Box<dyn Switch>,
    meter: Box<dyn LuxMeter>,
    zaber: ZaberDriver,
    _serving: Serving,
}

async fn bench(darkroom: &str) -> Bench {
    let room = VirtualRoom::open(Darkroom::parse(darkroom).unwrap());
    let links = MemoryLinks::default();
    let serving = room.listen(&links).unwrap();
    let ports = Ports::new(Arc::new(links));
    let zaber = ZaberDriver::new(ports.clone());
    let angle = |deg: f64| AxisAngle::new(deg).unwrap();
    let scale = AxisScale::new(12_800, 3, angle(0.0), Sense::Positive).unwrap();
    let settings = AxisSettings::new(scale, (angle(-180.0), angle(360.0)), 20.0, 40.0).unwrap();
    let target = |text: &str| Target::parse(text).unwrap();
    Bench {
        c: zaber
            .open_axis(&target("zaber:memory:axes?axis=1"), settings)
            .await
            .unwrap(),
        gamma: zaber
            .open_axis(&target("zaber:memory:axes?axis=2"), settings)
            .await
            .unwrap(),
        lamp: zaber.open_switch(&target("zaber:memory:axes?do=1")).await.unwrap(),
        shutter: zaber.open_switch(&target("zaber:memory:axes?do=2")).await.unwrap(),
        baffle: zaber.open_switch(&target("zaber:memory:axes?do=3")).await.unwrap(),
        meter: (KONICA_T10A.factories)(ports)
            .lux_meter
            .unwrap()
            .open_lux_meter(&target("konica-t10a:memory:luxmeter?head=0"))
            .await
            .unwrap(),
        zaber,
        room,
        _serving: serving,
    }
}

fn soon() -> Instant {
    Instant::now() + Duration::from_mins(1)
}

impl Bench {
    async fn light_up(&self) {
        self.c.home(soon()).await.unwrap();
        self.gamma.home(soon()).await.unwrap();
        self.lamp.set(true).await.unwrap();
        self.shutter.set(true).await.unwrap();
        self.meter.set_range(LuxRange::Auto).await.unwrap();
    }

    async fn point(&self, c_deg: f64, gamma_deg: f64) -> Observation {
        let c = self.c.move_to(AxisAngle::new(c_deg).unwrap()).await.unwrap();
        let gamma = self.gamma.move_to(AxisAngle::new(gamma_deg).unwrap()).await.unwrap();
        self.room.with_world(|world, now_s| Observation {
            kind: Kind::Lit,
            time_s: world.lamp_time_s(now_s).unwrap(),
            c_deg: c.place.value(),
            gamma_deg: gamma.place.value(),
            distance_mm: 10_000.0,
            travel: 1.0,
            range: 0,
            ambient_c: world.temperature_c(now_s),
        })
    }

    async fn read_lx(&self) -> Result<f64, DeviceError> {
        self.meter
            .read(Instant::now(), soon())
            .await
            .map(|reading| reading.illuminance().unwrap().value())
    }

    fn truth_lx(&self, o: &Observation) -> f64 {
        self.room.with_world(|world, _| world.room().indicated_lx(o))
    }
}

#[tokio::test(start_paused = true)]
async fn what_the_drivers_read_is_what_the_room_holds() {
    let bench = bench(BUILT_IN).await;
    bench.light_up().await;
    tokio::time::sleep(Duration::from_hours(1)).await;
    for (c, gamma) in [(0.0, 0.0), (90.0, 30.0), (255.0, 62.0), (15.0, 95.0)] {
        let o = bench.point(c, gamma).await;
        let read = bench.read_lx().await.unwrap();
        let truth = bench.truth_lx(&o);
        // Half a digit of 0.01 lx and five standard deviations of the meter.
        assert!(
            (read - truth).abs() < 0.005 + 5.0 * (0.0008 * truth).hypot(0.0008),
            "{c} {gamma}: {read} {truth}"
        );
    }
    // Behind the baffle the floor, the room and the offset are left; with the shutter closed the offset.
    let o = bench.point(0.0, 45.0).await;
    bench.baffle.set(true).await.unwrap();
    let baffled = bench.read_lx().await.unwrap();
    assert!(
        (baffled
            - bench.truth_lx(&Observation {
                kind: Kind::Baffled,
                ..o
            }))
        .abs()
            < 0.01,
        "{baffled}"
    );
    bench.shutter.set(false).await.unwrap();
    assert!((bench.read_lx().await.unwrap() - 0.006).abs() < 0.01);
    let thermometer = bench
        .zaber
        .open_thermometer(&Target::parse("zaber:memory:axes?ai=1&c_at_0v=-50&c_at_10v=100").unwrap())
        .await
        .unwrap();
    let celsius = thermometer.read().await.unwrap().temperature.value();
    let truth = bench.room.with_world(|world, now_s| world.temperature_c(now_s));
    assert!((celsius - truth).abs() < 0.1, "{celsius} {truth}");
}

#[tokio::test(start_paused = true)]
async fn the_same_day_gives_the_same_readings() {
    let day = async || {
        let bench = bench(BUILT_IN).await;
        bench.light_up().await;
        let mut readings = Vec::new();
        for gamma in [0.0, 10.0, 20.0] {
            bench.point(0.0, gamma).await;
            readings.push(bench.read_lx().await.unwrap());
        }
        (readings, bench.room.now_s())
    };
    assert_eq!(day().await, day().await);
}

/// A damaged or late reply costs time, never a wrong number.
#[tokio::test(start_paused = true)]
async fn faults_on_the_lux_meters_link_never_become_readings() {
    for kind in ["drop_byte", "flip_bit", "late", "silent"] {
        let fault = format!(
            "{BUILT_IN}\n[[fault]]\ninstrument = \"luxmeter\"\nkind = \"{kind}\"\nat_s = 600.0\nfor_s = 400.0\n\
             delay_s = 1.3\nprobability = 0.3\n"
        );
        let bench = bench(&fault).await;
        bench.light_up().await;
        tokio::time::sleep(Duration::from_secs(590)).await;
        let mut good = 0;
        for step in 0..20 {
            let gamma = f64::from(step) * 3.0;
            let o = bench.point(0.0, gamma).await;
            // An error is an answer, too; a wrong number is not.
            if let Ok(read) = bench.read_lx().await {
                let truth = bench.truth_lx(&o);
                assert!((read - truth).abs() < 0.02, "{kind} at {gamma}: {read} is not {truth}");
                good += 1;
            }
        }
        assert!(good >= 10, "{kind}: {good}");
    }
}

#[tokio::test(start_paused = true)]
async fn an_axis_that_is_stopped_short_is_a_fault() {
    let bench = bench(&format!(
        "{BUILT_IN}\n[[fault]]\ninstrument = \"axes\"\nkind = \"stall\"\nat_s = 100.0\n"
    ))
    .await;
    bench.light_up().await;
    tokio::time::sleep(Duration::from_secs(110)).await;
    let stalled = bench.gamma.move_to(AxisAngle::new(90.0).unwrap()).await;
    assert!(matches!(stalled, Err(DeviceError::Fault { .. })), "{stalled:?}");
}

/// From the lamp through counts, dark, linearity and the factors in the instrument back to irradiance.
#[tokio::test(start_paused = true)]
async fn the_spectrum_leads_back_to_the_irradiance_at_the_entrance() {
    let room = VirtualRoom::open(Darkroom::default());
    let links = MemoryLinks::default();
    let _serving = room.listen(&links).unwrap();
    let target = Target::parse("ocean-ooi:memory:spectrometer").unwrap();
    let driver = OceanOoiDriver::new(Ports::new(Arc::new(links)));
    let instrument = driver.open_spectroradiometer(&target).await.unwrap();
    let illuminated = Switches {
        lamp: true,
        shutter_open: true,
        baffle_in: false,
    };
    instrument
        .set_integration_time(Duration::from_millis(400))
        .await
        .unwrap();
    let dark = instrument.acquire(soon()).await.unwrap();
    room.with_world(|world, now_s| world.set_switches(illuminated, now_s));
    tokio::time::sleep(Duration::from_secs(1)).await;
    let light = instrument.acquire(soon()).await.unwrap();
    let properties = instrument.properties();
    assert!(properties.saturated(&light).is_empty());
    let linear = properties.linear_counts(&light, Some(&dark)).unwrap();
    let factors = properties.irradiance_factor.as_ref().unwrap();
    let (mut sum, mut truth) = (0.0, 0.0);
    room.with_world(|world, now_s| {
        let lx = world.spectroradiometer_lx(now_s - 0.5, now_s);
        for pixel in 200..1100 {
            let nm = properties.wavelength_nm[pixel];
            let step = properties.wavelength_nm[pixel + 1] - nm;
            sum += linear[pixel] / 0.4 * factors[pixel] * step;
            truth += world.room().indicated_spectral_irradiance(nm, lx) * step;
        }
    });
    // 4.2 to 4.4 W/m² is what an honest cool white gives at 500 mm.
    assert!((4.1..4.4).contains(&truth), "{truth}");
    assert!((sum / truth - 1.0).abs() < 1e-3, "{sum} {truth}");
}

/// In real time: the axes answer another program over TCP and on a pty.
#[tokio::test]
async fn twins_answer_on_real_links() {
    let mut document = Darkroom::default();
    document.axis.c.speed_deg_s = 2000.0;
    document.axis.c.accel_deg_s2 = 20_000.0;
    let offers = if cfg!(unix) {
        vec![Offer::Tcp { port: 0 }, Offer::Pty]
    } else {
        vec![Offer::Tcp { port: 0 }]
    };
    for kind in offers {
        let room = VirtualRoom::open(document.clone());
        let (outlets, _serving) = offer(&room, &[Instrument::Axes], kind).await.unwrap();
        let target = Target::parse(&format!("zaber:{}?axis=1", outlets[0].address)).unwrap();
        let angle = |deg: f64| AxisAngle::new(deg).unwrap();
        let scale = AxisScale::new(12_800, 3, angle(0.0), Sense::Positive).unwrap();
        let settings = AxisSettings::new(scale, (angle(-180.0), angle(360.0)), 2000.0, 20_000.0).unwrap();
        // A second client after the first finds the same axis where it was left.
        for at in [30.0, 60.0] {
            let driver = ZaberDriver::new(Ports::new(Arc::new(SystemLinks::default())));
            let axis = driver.open_axis(&target, settings).await.unwrap();
            if at == 30.0 {
                axis.home(soon()).await.unwrap();
            } else {
                assert_eq!(axis.position().await.unwrap().place.value(), 30.0);
            }
            assert_eq!(axis.move_to(angle(at)).await.unwrap().place.value(), at);
            // The driver's link closes when its owner task has seen that nobody is left.
            drop((axis, driver));
            tokio::time::sleep(Duration::from_millis(100)).await;
        }
    }
}
