//! The driver of the WT300 against scripted frames. The numbers are those of a block answer in the manuals of the
//! family: 230 V is 43660000h, 0.1834 A is 3E3BCD36h, 40.15 W is 4220999Ah.

#![expect(clippy::unwrap_used, reason = "a test")]

use std::sync::{Arc, Mutex};
use std::time::Duration;

use isolux_device::{PowerMeter, Quantity, Target};
use isolux_electrical::DRIVERS;
use isolux_transport::{LineSettings, Link, LinkError, Links, MemoryLinks, Ports};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::time::Instant;

/// Every address is the meter's.
struct OneMeter(MemoryLinks);

#[async_trait::async_trait]
impl Links for OneMeter {
    async fn open(&self, _: &str, line: LineSettings) -> Result<Box<dyn Link>, LinkError> {
        self.0.open("memory:meter", line).await
    }
}

/// A meter whose items are these, and the requests that it heard.
async fn meter(items: [u32; 6]) -> (Box<dyn PowerMeter>, Arc<Mutex<Vec<Vec<u8>>>>) {
    let links = MemoryLinks::default();
    let mut listener = links.listen("meter").unwrap();
    let heard = Arc::new(Mutex::new(Vec::new()));
    let notes = Arc::clone(&heard);
    tokio::spawn(async move {
        let mut stream = listener.accept().await.unwrap();
        let mut request = [0; 12];
        while stream.read_exact(&mut request).await.is_ok() {
            notes.lock().unwrap().push(request.to_vec());
            let count = usize::from(request[11]);
            let registers = items.iter().flat_map(|item| item.to_be_bytes()).take(2 * count);
            let mut answer = [&request[..5], &[3 + 2 * count as u8, request[6], 4, 2 * count as u8]].concat();
            answer.extend(registers);
            tokio::time::sleep(Duration::from_millis(10)).await;
            stream.write_all(&answer).await.unwrap();
        }
    });
    let driver = DRIVERS.iter().find(|driver| driver.name == "yokogawa-wt300").unwrap();
    let factories = (driver.factories)(Ports::new(Arc::new(OneMeter(links))));
    let target = Target::parse("yokogawa-wt300:modbus-tcp://192.168.1.6:502").unwrap();
    let meter = factories.power_meter.unwrap().open_power_meter(&target).await.unwrap();
    (meter, heard)
}

fn soon() -> Instant {
    Instant::now() + Duration::from_secs(10)
}

#[tokio::test(start_paused = true)]
async fn the_request_and_the_numbers_are_those_of_the_manual() {
    let (meter, heard) = meter([0x4366_0000, 0x3E3B_CD36, 0x4220_999A, 0x4228_BA5E, 0, 0x3F73_A92A]).await;
    let before = Instant::now();
    let reading = meter.read(before, soon()).await.unwrap();
    let value = |quantity: Quantity| quantity.value().unwrap();
    assert_eq!(value(reading.voltage), 230.0);
    assert!((value(reading.current) - 0.1834).abs() < 1e-7);
    assert!((value(reading.power) - 40.15).abs() < 1e-5);
    assert!((value(reading.power_factor) - 0.9518).abs() < 1e-4);
    assert!(reading.steady && reading.began >= before);
    let heard = heard.lock().unwrap();
    // Unit 1, function 04, input register 2001 (07D0h), six items of two registers.
    assert_eq!(heard.last().unwrap()[2..], [0, 0, 0, 6, 1, 4, 0x07, 0xD0, 0, 12]);
}

#[tokio::test(start_paused = true)]
async fn the_patterns_of_no_data_and_over_range_are_no_numbers() {
    let over = 0x7E94_F56A;
    let (meter, _) = meter([0x4366_0000, over, over, over, over, 0x7E95_1BEE]).await;
    let reading = meter.read(Instant::now(), soon()).await.unwrap();
    assert_eq!(
        (reading.current, reading.power),
        (Quantity::OverRange, Quantity::OverRange)
    );
    assert_eq!(reading.power_factor, Quantity::NoData);
}

#[tokio::test(start_paused = true)]
async fn items_that_are_not_as_delivered_contradict_each_other() {
    // Item 3 is the energy, say: 400 Wh from 230 V and 0.1834 A.
    let (meter, _) = meter([0x4366_0000, 0x3E3B_CD36, 0x43C8_0000, 0x4228_BA5E, 0, 0x3F73_A92A]).await;
    let error = meter.read(Instant::now(), soon()).await.unwrap_err().to_string();
    assert!(error.contains("cannot be"), "{error}");
}
