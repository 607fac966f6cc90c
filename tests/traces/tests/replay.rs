//! Every driver says today, byte for byte, what it said when its session was recorded, and makes the same of the
//! answers.
//!
//! The sessions under `recorded/` come from the virtual darkroom: no instrument has been at hand. A session with an
//! instrument is recorded by `isolux check --record` and put beside them. To record the virtual ones anew after an
//! intended change: `cargo test -p isolux-traces -- --ignored record`.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use isolux_axes::ZaberDriver;
use isolux_darkroom::Darkroom;
use isolux_device::{
    AxisFactory, AxisScale, AxisSettings, Sense, SpectroradiometerFactory, SwitchFactory, Target, ThermometerFactory,
};
use isolux_luxmeter::KONICA_T10A;
use isolux_spectroradiometer::OceanOoiDriver;
use isolux_transport::{Links, MemoryLinks, Ports, Recorder, Trace};
use isolux_units::AxisAngle;
use isolux_virtual::{BUILT_IN, VirtualRoom};
use tokio::time::Instant;

fn target(text: &str) -> Target {
    Target::parse(text).unwrap()
}

fn angle(degrees: f64) -> AxisAngle {
    AxisAngle::new(degrees).unwrap()
}

/// Home, move, read back, switch, read the temperature, stop: what an operator does first. Returns what was found.
async fn zaber(links: Arc<dyn Links>) -> Vec<String> {
    let driver = ZaberDriver::new(Ports::new(links));
    let scale = AxisScale::new(12_800, 3, angle(0.0), Sense::Positive).unwrap();
    let settings = AxisSettings::new(scale, (angle(-90.0), angle(90.0)), 20.0, 40.0).unwrap();
    let axis = driver
        .open_axis(&target("zaber:memory:axes?axis=2"), settings)
        .await
        .unwrap();
    let lamp = driver.open_switch(&target("zaber:memory:axes?do=1")).await.unwrap();
    let thermometer = driver
        .open_thermometer(&target("zaber:memory:axes?ai=1&c_at_0v=-50&c_at_10v=100"))
        .await
        .unwrap();
    let mut found = vec![format!("{:?}", axis.identity())];
    found.push(format!(
        "homed at {}",
        axis.home(Instant::now() + Duration::from_mins(2)).await.unwrap().steps
    ));
    let motion = axis.start_move(angle(33.3)).await.unwrap();
    // The clock of a replay does not run as that of the recording did: one look at the end, when both have arrived.
    tokio::time::sleep(2 * motion.expected).await;
    let there = axis.finish_move(motion).await.unwrap();
    found.push(format!("at {} = {}, moving {}", there.steps, there.place, there.moving));
    lamp.set(true).await.unwrap();
    found.push(format!("lamp {}", lamp.state().await.unwrap()));
    found.push(format!("room {:.3}", thermometer.read().await.unwrap().temperature));
    found.push(format!("stopped at {}", axis.stop().await.unwrap().steps));
    found
}

async fn t10a(links: Arc<dyn Links>) -> Vec<String> {
    let meter = (KONICA_T10A.factories)(Ports::new(links))
        .lux_meter
        .unwrap()
        .open_lux_meter(&target("konica-t10a:memory:luxmeter?head=0"))
        .await
        .unwrap();
    let mut found = vec![];
    for _ in 0..3 {
        let reading = meter
            .read(Instant::now(), Instant::now() + Duration::from_secs(10))
            .await
            .unwrap();
        found.push(format!(
            "{:?} in range {}, digit {}",
            reading.outcome, reading.range, reading.digit
        ));
    }
    found
}

async fn ooi(links: Arc<dyn Links>) -> Vec<String> {
    let driver = OceanOoiDriver::new(Ports::new(links));
    let spectro = driver
        .open_spectroradiometer(&target("ocean-ooi:memory:spectrometer"))
        .await
        .unwrap();
    spectro.set_integration_time(Duration::from_millis(20)).await.unwrap();
    let raw = spectro.acquire(Instant::now() + Duration::from_secs(10)).await.unwrap();
    let properties = spectro.properties();
    let linear = properties.linear_counts(&raw, None).unwrap();
    vec![
        format!("{:?}", spectro.identity()),
        format!(
            "{:.6} to {:.6} nm",
            properties.wavelength_nm[0], properties.wavelength_nm[2047]
        ),
        format!(
            "{} raw, {:.3} linear counts in all",
            raw.counts.iter().map(|count| u64::from(*count)).sum::<u64>(),
            linear.iter().sum::<f64>()
        ),
        format!("{:?}", properties.irradiance_factor.as_ref().map(Vec::len)),
    ]
}

#[derive(Clone, Default)]
struct Text(Arc<Mutex<Vec<u8>>>);

impl Write for Text {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.lock().unwrap().write(bytes)
    }
    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("recorded").join(name)
}

/// What was found stands at the end of the trace, as comments.
fn check(name: &str, text: &str, found: &[String]) {
    let recorded: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix("# found: ")).collect();
    assert_eq!(recorded, found, "{name}");
}

fn trace(name: &str) -> (String, Arc<dyn Links>) {
    let text = std::fs::read_to_string(file(name)).unwrap();
    let trace: Trace = text.parse().unwrap();
    (text, Arc::new(trace))
}

#[tokio::test(start_paused = true)]
async fn zaber_says_what_it_said() {
    let (text, links) = trace("zaber-virtual.trace");
    check("zaber", &text, &zaber(links).await);
}

#[tokio::test(start_paused = true)]
async fn t10a_says_what_it_said() {
    let (text, links) = trace("t10a-virtual.trace");
    check("t10a", &text, &t10a(links).await);
}

#[tokio::test(start_paused = true)]
async fn ooi_says_what_it_said() {
    let (text, links) = trace("ooi-virtual.trace");
    check("ooi", &text, &ooi(links).await);
}

#[tokio::test(start_paused = true)]
#[ignore = "writes the recorded sessions anew"]
async fn record() {
    for name in ["zaber-virtual.trace", "t10a-virtual.trace", "ooi-virtual.trace"] {
        let room = VirtualRoom::open(Darkroom::parse(BUILT_IN).unwrap());
        let memory = MemoryLinks::default();
        let _serving = room.listen(&memory).unwrap();
        let written = Text::default();
        let recorder = Arc::new(Recorder::new(memory, Box::new(written.clone())).unwrap());
        let found = match name {
            "zaber-virtual.trace" => zaber(recorder).await,
            "t10a-virtual.trace" => t10a(recorder).await,
            _ => ooi(recorder).await,
        };
        let mut text = written.0.lock().unwrap().clone();
        for line in found {
            writeln!(text, "# found: {line}").unwrap();
        }
        std::fs::create_dir_all(file("")).unwrap();
        std::fs::write(file(name), text).unwrap();
    }
}
