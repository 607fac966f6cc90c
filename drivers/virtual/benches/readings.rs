//! The software's own share of a reading, driver and bus together: from the call of the driver to the typed value,
//! without the time that the twin takes to answer and without any waiting. `cargo bench -p isolux-virtual --bench
//! readings`
//!
//! The clock of the runtime is paused, so that nobody waits, and each turn of the twin is timed and taken off. Beside
//! it stands what the bytes of the reading take at the line's speed.

#![expect(clippy::print_stdout, reason = "the figures")]
#![allow(clippy::unwrap_used, reason = "a program to run by hand")]

use std::future::Future;
use std::pin::{Pin, pin};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::task::{Context, Poll};
use std::time::Duration;

use async_trait::async_trait;
use isolux_darkroom::Darkroom;
use isolux_device::{AxisScale, AxisSettings, Factories, Sense, Target};
use isolux_transport::{LineSettings, Link, LinkError, Links, Parity, Ports};
use isolux_units::AxisAngle;
use isolux_virtual::twins::{Choice, TWINS, TwinKind};
use isolux_virtual::{Instrument, Switches, VirtualRoom};
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::time::Instant;

const READINGS: u32 = 200;

/// Nanoseconds in the twin, and bytes in both directions.
#[derive(Default)]
struct Meter {
    twin_ns: AtomicU64,
    bytes: AtomicU64,
}

/// A future whose turns are timed.
struct Timed<F>(Pin<Box<F>>, Arc<Meter>);

impl<F: Future> Future for Timed<F> {
    type Output = F::Output;

    fn poll(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<F::Output> {
        let begun = std::time::Instant::now();
        let polled = self.0.as_mut().poll(context);
        let spent = begun.elapsed().as_nanos() as u64;
        self.1.twin_ns.fetch_add(spent, Ordering::Relaxed);
        polled
    }
}

/// A link whose bytes are counted.
struct Counted<L>(L, Arc<Meter>);

impl<L: AsyncRead + Unpin> AsyncRead for Counted<L> {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        into: &mut ReadBuf<'_>,
    ) -> Poll<std::io::Result<()>> {
        let before = into.filled().len();
        let polled = pin!(&mut self.0).poll_read(context, into);
        self.1
            .bytes
            .fetch_add((into.filled().len() - before) as u64, Ordering::Relaxed);
        polled
    }
}

impl<L: AsyncWrite + Unpin> AsyncWrite for Counted<L> {
    fn poll_write(mut self: Pin<&mut Self>, context: &mut Context<'_>, bytes: &[u8]) -> Poll<std::io::Result<usize>> {
        let polled = pin!(&mut self.0).poll_write(context, bytes);
        if let Poll::Ready(Ok(count)) = &polled {
            self.1.bytes.fetch_add(*count as u64, Ordering::Relaxed);
        }
        polled
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<std::io::Result<()>> {
        pin!(&mut self.0).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<std::io::Result<()>> {
        pin!(&mut self.0).poll_shutdown(context)
    }
}

/// Leads to one instrument of the room.
struct ToTwin(VirtualRoom, Instrument, Arc<Meter>);

#[async_trait]
impl Links for ToTwin {
    async fn open(&self, _: &str, _: LineSettings) -> Result<Box<dyn Link>, LinkError> {
        let (host, stream) = tokio::io::duplex(1 << 16);
        let (room, instrument) = (self.0.clone(), self.1);
        let serving = async move { room.serve(instrument, stream).await };
        tokio::spawn(Timed(Box::pin(serving), Arc::clone(&self.2)));
        Ok(Box::new(Counted(host, Arc::clone(&self.2))))
    }
}

fn angle(degrees: f64) -> AxisAngle {
    AxisAngle::new(degrees).unwrap()
}

/// What a byte takes on the line.
fn byte_s(line: LineSettings) -> f64 {
    let parity = u32::from(line.parity != Parity::None);
    f64::from(1 + u32::from(line.data_bits) + parity + u32::from(line.stop_bits)) / f64::from(line.baud)
}

/// Repeats `read` and prints its share.
async fn measured(twin: &TwinKind, what: &str, meter: &Meter, read: impl AsyncFn()) {
    read().await;
    meter.twin_ns.store(0, Ordering::Relaxed);
    meter.bytes.store(0, Ordering::Relaxed);
    let begun = std::time::Instant::now();
    for _ in 0..READINGS {
        read().await;
    }
    let all = begun.elapsed();
    let own = all.saturating_sub(Duration::from_nanos(meter.twin_ns.load(Ordering::Relaxed)));
    let own_us = own.as_secs_f64() * 1e6 / f64::from(READINGS);
    let bytes = meter.bytes.load(Ordering::Relaxed) as f64 / f64::from(READINGS);
    let wire_us = bytes * byte_s(twin.line) * 1e6;
    println!(
        "{:16} {what:9} {own_us:8.1} µs   {bytes:7.0} bytes, {wire_us:9.0} µs at {}   {:.3} %",
        twin.driver,
        twin.line,
        100.0 * own_us / wire_us
    );
}

async fn of(twin: &TwinKind) {
    let mut document = Darkroom::default();
    document.lamp.on_at_start = true;
    let mut choice = Choice::default();
    choice.choose(twin.instrument, twin.driver).unwrap();
    let room = VirtualRoom::open_with(document, &choice);
    let illuminated = Switches {
        lamp: true,
        shutter_open: true,
        baffle_in: false,
    };
    room.with_world(|world, now_s| world.set_switches(illuminated, now_s));
    let meter = Arc::new(Meter::default());
    let links = Arc::new(ToTwin(room, twin.instrument, Arc::clone(&meter)));
    let drivers = [
        isolux_axes::DRIVERS,
        isolux_luxmeter::DRIVERS,
        isolux_spectroradiometer::DRIVERS,
        isolux_electrical::DRIVERS,
    ];
    let mut drivers = drivers.into_iter().flatten();
    let driver = drivers.find(|driver| driver.name == twin.driver).unwrap();
    let factories: Factories = (driver.factories)(Ports::new(links));
    let at = |part: &str| {
        let rest = twin.open(part).unwrap();
        Target::parse(&format!("{}:memory:it{rest}", twin.driver)).unwrap()
    };
    let soon = || Instant::now() + Duration::from_mins(1);
    match twin.instrument {
        Instrument::Axes | Instrument::Outputs => {
            let scale = AxisScale::new(12_800, 3, angle(0.0), Sense::Positive).unwrap();
            let settings = AxisSettings::new(scale, (angle(-180.0), angle(180.0)), 20.0, 40.0).unwrap();
            let factory = factories.axis.unwrap();
            let axis = factory.open_axis(&at("axis.gamma"), settings).await.unwrap();
            let read = async || {
                std::hint::black_box(axis.position().await.unwrap());
            };
            measured(twin, "position", &meter, read).await;
        }
        Instrument::Luxmeter => {
            let factory = factories.lux_meter.unwrap();
            let device = factory.open_lux_meter(&at("luxmeter")).await.unwrap();
            let read = async || {
                std::hint::black_box(device.read(Instant::now(), soon()).await.unwrap());
            };
            measured(twin, "reading", &meter, read).await;
        }
        Instrument::Spectroradiometer => {
            let factory = factories.spectroradiometer.unwrap();
            let device = factory.open_spectroradiometer(&at("spectroradiometer")).await.unwrap();
            let read = async || {
                std::hint::black_box(device.acquire(soon()).await.unwrap());
            };
            measured(twin, "spectrum", &meter, read).await;
        }
        Instrument::Powermeter => {
            let factory = factories.power_meter.unwrap();
            let device = factory.open_power_meter(&at("powermeter")).await.unwrap();
            let read = async || {
                std::hint::black_box(device.read(Instant::now(), soon()).await.unwrap());
            };
            measured(twin, "reading", &meter, read).await;
        }
        Instrument::Supply => {
            let device = factories.switch.unwrap().open_switch(&at("supply")).await.unwrap();
            let read = async || {
                std::hint::black_box(device.state().await.unwrap());
            };
            measured(twin, "state", &meter, read).await;
        }
        Instrument::Oscilloscope => {
            let factory = factories.waveform_recorder.unwrap();
            let device = factory.open_waveform_recorder(&at("oscilloscope")).await.unwrap();
            let read = async || {
                std::hint::black_box(device.record(Duration::from_millis(10), 1e4).await.unwrap());
            };
            measured(twin, "record", &meter, read).await;
        }
    }
}

fn main() {
    println!("own share of a reading, bytes both ways and their time on the line");
    // A spectrometer in the place of the lux meter has the driver of one.
    let is_spectrometer = |driver: &str| isolux_spectroradiometer::DRIVERS.iter().any(|one| one.name == driver);
    let in_place = |twin: &&TwinKind| twin.instrument == Instrument::Luxmeter && is_spectrometer(twin.driver);
    for twin in TWINS.iter().filter(|twin| !in_place(twin)) {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_time()
            .start_paused(true)
            .build()
            .unwrap();
        runtime.block_on(of(twin));
    }
}
