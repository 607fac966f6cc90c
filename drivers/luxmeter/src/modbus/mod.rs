//! Any lux meter on Modbus, by a profile: `modbus-lux:LINK?profile=rs485-u32&unit=1`.
//!
//! `profile` is the name of one that comes with the program, or the path of a TOML file, from the folder of the station
//! file.
//!
//! The meter converts all the time, and a request gets the latest value: light of the update interval and the
//! integration before the request. What an answer is believed for is said in `confirmed.rs`. On a line in doubt the
//! meter is asked for another number of registers: neither the answer to that nor an exception can be a reading that
//! comes late. A meter that does not answer such a request is left to the silence after a failure alone; opening finds
//! that out.

mod profile;

use std::time::Duration;

use async_trait::async_trait;
use isolux_device::{DeviceError, ErrorKind, Identity, Kind, LuxRange, OpenError, Target};
use isolux_modbus::{ANSWER, Data, Modbus, Reply, Request, unit_number};
use isolux_transport::{Driver, LineSettings, Parity, Place, Probe};
use tokio::time::Instant;

use crate::language::{Converts, Failure, Language, Link, Said, Step, Timing};
use crate::meter;
use profile::Profile;

/// For the first proof, silence of the line before included.
const OPENING: Duration = Duration::from_secs(10);

/// Lux meters on Modbus.
pub const MODBUS_LUX: Driver = Driver {
    name: ModbusLux::NAME,
    speaks_to: "lux meters on Modbus by a profile",
    examples: &[(Kind::LuxMeter, "modbus-lux:/dev/ttyUSB0?profile=rs485-u32&unit=1")],
    seen_with: "🧪 its virtual twin; pymodbus 3.16.1, mbpoll; a published exchange",
    usb: &[],
    identify: &[Probe {
        line: LineSettings {
            baud: 9600,
            data_bits: 8,
            parity: Parity::None,
            stop_bits: 1,
        },
        // Holding registers 0007h and 0008h of unit 1.
        request: &[0x01, 0x03, 0x00, 0x07, 0x00, 0x02, 0x75, 0xCA],
        read: isolux_modbus::unit_of,
    }],
    place: meter::place::<ModbusLux>,
    display_lx: meter::display_lx::<ModbusLux>,
    factories: meter::factories::<ModbusLux>,
};

struct ModbusLux {
    place: Place,
    profile: Profile,
    reading: Request,
    /// For another number of registers; none where the meter does not answer it, or would have to pass register FFFFh.
    proof: Option<Request>,
}

#[async_trait]
impl Language for ModbusLux {
    type Conversation = Modbus;

    const NAME: &'static str = "modbus-lux";

    fn of(target: &Target) -> Result<Self, OpenError> {
        target.only(&["profile", "unit"])?;
        let (profile, unit) = (Profile::of(target)?, unit_number(target)?);
        let request = |count| Request::new(unit, profile.table.ask(profile.register, count));
        let count = profile.encoding.number.registers();
        Ok(Self {
            place: isolux_modbus::place(target, profile.line)?,
            reading: request(count).map_err(|error| target.wrong(error.to_string()))?,
            proof: request(3 - count).ok(),
            profile,
        })
    }

    fn place(&self) -> Place {
        self.place.clone()
    }

    fn conversation(&self, target: &Target) -> Modbus {
        isolux_modbus::conversation(target, self.place.line)
    }

    fn model(&self) -> String {
        self.profile.model.clone()
    }

    fn ranges_lx(&self) -> Vec<(f64, Option<f64>)> {
        vec![(self.profile.range_lx.1, Some(self.profile.resolution_lx))]
    }

    fn timing(&self) -> Timing {
        Timing {
            update_interval: self.profile.update_interval,
            integration: self.profile.integration,
            converts: Converts::Always,
            answer: ANSWER,
        }
    }

    /// A first reading, of any light, says whether the meter is there and has the register.
    fn opening(&self) -> Vec<Step<Self>> {
        self.reading(LuxRange::Auto)
    }

    fn taken(&self, _: &Request, reply: &Reply, _: &mut Identity) -> Result<(), Failure> {
        words(reply).map(|_| ())
    }

    fn reading(&self, _: LuxRange) -> Vec<Step<Self>> {
        vec![(self.reading.clone(), "read".to_owned())]
    }

    fn stated(&self, _: LuxRange, answers: &[Reply]) -> Result<Said, Failure> {
        let words = answers.first().map_or(Ok(&[][..]), words)?;
        let meaning = self.profile.meaning(words);
        Ok(Said {
            meaning: meaning.ok_or_else(|| Failure::malformed("another number of registers than the type takes"))?,
            digit_lx: self.profile.resolution_lx,
            range: 0,
            caution: None,
        })
    }

    fn bytes(reply: &Reply) -> &[u8] {
        &reply.frame
    }

    fn proof(&self) -> Option<Step<Self>> {
        let proof = self.proof.clone()?;
        Some((proof, "put the line in step".to_owned()))
    }

    async fn put_in_service(&mut self, link: &Link<Modbus>, identity: &mut Identity) -> Result<(), DeviceError> {
        let proof = self.proof.take();
        for step in self.opening() {
            link.settle(self, step, identity).await?;
        }
        self.proof = proof;
        match self.put_in_step(link, Instant::now() + OPENING).await {
            Err(error) if error.kind() == ErrorKind::Timeout => {
                tracing::warn!(%error, "answers of this meter that are late by more than the silence cannot be told apart");
                self.proof = None;
                Ok(())
            }
            proved => proved,
        }
    }
}

/// The registers of an answer.
fn words(reply: &Reply) -> Result<&[u16], Failure> {
    match &reply.outcome {
        Ok(Data::Registers(words)) => Ok(words),
        Ok(_) => Err(Failure::malformed("no registers")),
        Err(exception) => Err(Failure::Refused(exception.to_string())),
    }
}
