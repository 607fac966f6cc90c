//! A light meter on a spectroradiometer whose counts are written down.

use std::sync::{Arc, Mutex as StdMutex};

use isolux_device::{SpectroradiometerProperties, Target};
use tokio::time::sleep;

use super::*;

const PIXELS: usize = 600;
const OFFSET: f64 = 1000.0;

/// What falls on it.
#[derive(Default)]
struct Light {
    /// Counts a second at 555 nm and at 350 nm.
    visible: f64,
    ultraviolet: f64,
    /// And in every pixel.
    all: f64,
    unsteady: bool,
}

struct Fake {
    identity: Identity,
    properties: SpectroradiometerProperties,
    time: StdMutex<Duration>,
    light: Arc<StdMutex<Light>>,
}

#[async_trait]
impl Spectroradiometer for Fake {
    fn identity(&self) -> &Identity {
        &self.identity
    }
    fn properties(&self) -> &SpectroradiometerProperties {
        &self.properties
    }
    async fn set_integration_time(&self, time: Duration) -> Result<Duration, DeviceError> {
        *self.time.lock().unwrap() = time;
        Ok(time)
    }
    async fn acquire(&self, _: Instant) -> Result<RawSpectrum, DeviceError> {
        let (began, time) = (Instant::now(), *self.time.lock().unwrap());
        sleep(time + Duration::from_millis(3)).await;
        let light = self.light.lock().unwrap();
        if light.unsteady {
            return Err(DeviceError::malformed("fake", "spectrum", "no two agree", Vec::new()));
        }
        let counts = self.properties.wavelength_nm.iter().map(|nm| {
            let line = match *nm {
                555.0 => light.visible,
                350.0 => light.ultraviolet,
                _ => 0.0,
            };
            let rate = line + light.all;
            (OFFSET + rate * time.as_secs_f64()).min(65_535.0) as u16
        });
        Ok(RawSpectrum {
            counts: counts.collect(),
            integration_time: time,
            detector_c: None,
            began,
            ended: Instant::now(),
        })
    }
    async fn sample(&self, deadline: Instant) -> Result<RawSpectrum, DeviceError> {
        self.acquire(deadline).await
    }
}

/// A meter of 100 ms whose brightest pixel is full at 1000 lx, by the address.
async fn meter() -> (SpectralLuxMeter, Arc<StdMutex<Light>>) {
    let light = Arc::<StdMutex<Light>>::default();
    let device = Fake {
        identity: Identity {
            driver: "fake",
            target: "fake:x".to_owned(),
            model: "fake".to_owned(),
            serial: None,
            firmware: None,
        },
        properties: SpectroradiometerProperties {
            wavelength_nm: (0..PIXELS).map(|pixel| 300.0 + pixel as f64).collect(),
            dark_pixels: 0..0,
            integration_limits: (Duration::from_millis(4), Duration::from_secs(1)),
            saturation_counts: 65_535,
            full_scale_counts: 65_535,
            nonlinearity: Vec::new(),
            irradiance_factor: Some(vec![1e-6; PIXELS]),
        },
        time: StdMutex::new(Duration::from_millis(10)),
        light: Arc::clone(&light),
    };
    let open = "fake:x?calibration=device&integration_ms=100&full_scale_lx=1000";
    let (settings, instrument) = Settings::of(&Target::parse(open).unwrap()).unwrap();
    assert_eq!(instrument.to_string(), "fake:x");
    (SpectralLuxMeter::open(Box::new(device), settings).await.unwrap(), light)
}

fn soon() -> Instant {
    Instant::now() + Duration::from_mins(1)
}

async fn read(meter: &SpectralLuxMeter) -> LuxReading {
    meter.read(Instant::now(), soon()).await.unwrap()
}

#[test]
fn an_address_without_calibration_or_time_is_refused_by_the_option() {
    for (open, word) in [
        ("fake:x?integration_ms=100", "calibration=device"),
        ("fake:x?calibration=device", "needs integration_ms"),
        (
            "fake:x?calibration=device&integration_ms=0",
            "integration_ms is a number",
        ),
        (
            "fake:x?calibration=device&integration_ms=100&full_scale_lx=-1",
            "full_scale_lx is a number",
        ),
    ] {
        let error = Settings::of(&Target::parse(open).unwrap()).err().unwrap().to_string();
        assert!(error.contains(word), "{open}: {error}");
    }
}

#[tokio::test(start_paused = true)]
async fn its_ranges_are_integration_times_down_to_the_shortest_of_the_instrument() {
    let (meter, _) = meter().await;
    let properties = meter.properties();
    let times: Vec<u128> = (1..=5)
        .map(|range| properties.integration_in(range).as_millis())
        .collect();
    assert_eq!(times, [100, 50, 20, 10, 5]);
    let tops: Vec<f64> = properties
        .range_full_scale
        .iter()
        .map(|top| top.value().round())
        .collect();
    assert_eq!(tops, [1000.0, 2000.0, 5000.0, 10_000.0, 20_000.0]);
    assert_eq!(properties.update_interval.as_millis(), 103);
    let refused = meter.set_range(LuxRange::Fixed(6)).await.unwrap_err();
    assert!(refused.to_string().contains("ranges 1 (100ms) to 5"), "{refused}");
}

#[tokio::test(start_paused = true)]
async fn it_gives_no_number_before_its_dark_and_none_for_a_dark_with_light() {
    let (meter, light) = meter().await;
    let without = meter.sample(soon()).await.unwrap_err();
    assert!(without.to_string().contains("no dark yet"), "{without}");
    light.lock().unwrap().all = 4e3;
    let lit = meter.take_dark(soon()).await.unwrap_err();
    assert!(lit.to_string().contains("380 counts more at 100ms"), "{lit}");
    assert!(meter.sample(soon()).await.is_err(), "it is no dark");
    // Two hot pixels of 600.
    *light.lock().unwrap() = Light {
        visible: 1e5,
        ultraviolet: 1e5,
        ..Light::default()
    };
    meter.take_dark(soon()).await.unwrap();
    *light.lock().unwrap() = Light::default();
    let said = meter.take_dark(soon()).await.unwrap().unwrap();
    assert!(
        said.contains("1000.0 at 100ms") && said.contains("1000.0 at 5ms"),
        "{said}"
    );
    light.lock().unwrap().visible = 1e5;
    // One pixel of 1 nm: 683 lm/W · V(555 nm) · 1e-6 W/(m²·nm) · 1e5 counts/s.
    let LuxOutcome::Measured(lux) = meter.sample(soon()).await.unwrap().outcome else {
        panic!("no number");
    };
    assert!((lux.value() - 68.3).abs() < 1e-9, "{lux:?}");
}

#[tokio::test(start_paused = true)]
async fn a_full_pixel_is_over_range_where_v_lambda_sees_it() {
    let (meter, light) = meter().await;
    meter.take_dark(soon()).await.unwrap();
    meter.set_range(LuxRange::Fixed(1)).await.unwrap();
    *light.lock().unwrap() = Light {
        visible: 6.4e5,
        ultraviolet: 1e7,
        ..Light::default()
    };
    let sample = meter.sample(soon()).await.unwrap();
    assert!(matches!(sample.outcome, LuxOutcome::Measured(_)), "{sample:?}");
    assert_eq!((sample.range, sample.evidence.len()), (1, 10));
    assert_eq!(sample.evidence[..2], 65_535_u16.to_be_bytes());
    light.lock().unwrap().visible = 6.5e5;
    assert_eq!(meter.sample(soon()).await.unwrap().outcome, LuxOutcome::OverRange);
    assert_eq!(read(&meter).await.outcome, LuxOutcome::OverRange, "the range is held");
}

#[tokio::test(start_paused = true)]
async fn the_automatic_range_follows_the_light_and_a_change_is_unsteady() {
    let (meter, light) = meter().await;
    meter.take_dark(soon()).await.unwrap();
    for (visible, range) in [(5e5, 1), (5e6, 5), (1.1e7, 5), (3e7, 5), (1e6, 3), (1e3, 1)] {
        light.lock().unwrap().visible = visible;
        let reading = read(&meter).await;
        assert_eq!(reading.range, range, "{visible}");
        match reading.outcome {
            LuxOutcome::Measured(lux) => assert!((lux.value() / (683e-6 * visible) - 1.0).abs() < 0.01, "{visible}"),
            other => assert!(visible > 2e7, "{visible}: {other:?}"),
        }
    }
    light.lock().unwrap().unsteady = true;
    assert_eq!(read(&meter).await.outcome, LuxOutcome::Unsteady);
}
