//! Our client against pymodbus' servers, on a pty and over TCP.

use std::sync::Arc;
use std::time::Duration;

use async_trait::async_trait;
use isolux_device::{DeviceError, LuxOutcome, Target};
use isolux_luxmeter::MODBUS_LUX;
use isolux_modbus::{ANSWER, Ask, Table, Unit};
use isolux_protocol_modbus::{Data, Exception, Reply};
use isolux_transport::{LineSettings, Link, LinkError, Links, Parity, Ports, SystemLinks};
use tokio::sync::Mutex;
use tokio::time::Instant;
use tokio_serial::{SerialPort, SerialStream};

use crate::peers;

const LINE: LineSettings = LineSettings {
    baud: 9600,
    data_bits: 8,
    parity: Parity::None,
    stop_bits: 1,
};

/// Hands out one end of a pty, once.
struct OneEnd(Mutex<Option<SerialStream>>);

#[async_trait]
impl Links for OneEnd {
    async fn open(&self, address: &str, _: LineSettings) -> Result<Box<dyn Link>, LinkError> {
        let end = self.0.lock().await.take();
        end.map(|end| Box::new(end) as Box<dyn Link>).ok_or_else(|| LinkError {
            address: address.to_owned(),
            reason: "the pty is in use".to_owned(),
            advice: None,
        })
    }
}

/// What both frames are asked for: `link` leads to a server of `tests/peers/modbus.py`.
async fn everything(ports: Arc<Ports>, link: &str) {
    let target = Target::parse(&format!("modbus-lux:{link}?profile=rs485-u32&unit=1")).unwrap();
    let unit = Unit::open(&ports, &target, LINE).await.unwrap();
    let ask = async |ask: Ask| {
        let request = unit.request(ask, "ask").unwrap();
        let deadline = Instant::now() + Duration::from_secs(5);
        let Reply { outcome, .. } = unit.bus().ask_within(request, ANSWER, deadline).await.unwrap();
        outcome
    };
    let places = 100..220_u16;
    let (from, count) = (100, 120);
    // Each function, and what it wrote read back.
    let holding = places.clone().map(|n| 3 * n).collect();
    assert_eq!(
        ask(Ask::ReadHoldingRegisters { from, count }).await,
        Ok(Data::Registers(holding))
    );
    let input = places.clone().map(|n| 5 * n).collect();
    assert_eq!(
        ask(Ask::ReadInputRegisters { from, count }).await,
        Ok(Data::Registers(input))
    );
    let coils = places.clone().map(|n| n % 3 == 0).collect();
    assert_eq!(ask(Ask::ReadCoils { from, count }).await, Ok(Data::Bits(coils)));
    let discrete = places.clone().map(|n| n % 7 == 0).collect();
    assert_eq!(
        ask(Ask::ReadDiscreteInputs { from, count }).await,
        Ok(Data::Bits(discrete))
    );
    for write in [
        Ask::WriteRegister { at: 300, value: 0xABCD },
        Ask::WriteRegisters {
            from: 301,
            values: vec![1, 0xFFFF, 3],
        },
        Ask::WriteCoil { at: 400, on: true },
        Ask::WriteCoils {
            from: 401,
            on: vec![true, false, true, true, false, true, true, true, false, true],
        },
    ] {
        assert_eq!(ask(write).await, Ok(Data::Written));
    }
    let written = ask(Ask::ReadHoldingRegisters { from: 300, count: 4 }).await;
    assert_eq!(written, Ok(Data::Registers(vec![0xABCD, 1, 0xFFFF, 3])));
    let bits = "11011011101".bytes().map(|byte| byte == b'1').collect();
    assert_eq!(ask(Ask::ReadCoils { from: 400, count: 11 }).await, Ok(Data::Bits(bits)));
    // An address that is not there, and a unit that is not.
    assert_eq!(
        ask(Ask::ReadHoldingRegisters { from: 5000, count: 1 }).await,
        Err(Exception(2))
    );

    // 0.8 s late, each time: nothing that comes is the answer to a request before it.
    let late = unit.read(Table::Holding, 1000, 1, "read the counter").await;
    assert!(matches!(late, Err(DeviceError::Timeout { .. })), "{late:?}");
    let after = unit.read(Table::Holding, 300, 1, "read").await.unwrap();
    assert_eq!(after.words, [0xABCD]);

    let meter = (MODBUS_LUX.factories)(ports)
        .lux_meter
        .unwrap()
        .open_lux_meter(&target)
        .await
        .unwrap();
    let reading = meter
        .read(Instant::now(), Instant::now() + Duration::from_secs(15))
        .await
        .unwrap();
    let LuxOutcome::Measured(lux) = reading.outcome else {
        panic!("{reading:?}")
    };
    assert_eq!(lux.value(), 132_854.0);
}

pub async fn pymodbus_serves_us_over_tcp() {
    let Some(mut server) = peers::pymodbus(&["serve-tcp"]) else {
        return;
    };
    let port = server.line().await;
    everything(
        Ports::new(Arc::new(SystemLinks::default())),
        &format!("modbus-tcp://127.0.0.1:{port}"),
    )
    .await;
}

pub async fn pymodbus_serves_us_on_a_pty() {
    let (ours, theirs) = SerialStream::pair().unwrap();
    let path = theirs.name().unwrap();
    let Some(mut server) = peers::pymodbus(&["serve-rtu", &path]) else {
        return;
    };
    assert_eq!(server.line().await, "ready");
    everything(Ports::new(Arc::new(OneEnd(Mutex::new(Some(ours))))), "memory:pty").await;
    drop(theirs);
}
