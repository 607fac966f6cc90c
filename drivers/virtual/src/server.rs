//! Pumps bytes between links and twins, on the clock of the runtime.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use isolux_darkroom::{Darkroom, FaultKind, Instrument};
use isolux_transport::{MemoryLinks, NameTaken};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::task::JoinSet;
use tokio::time::Instant;

use crate::fault::{Delivery, LinkFaults, Order};
use crate::twin::{Answer, Look, Twin, TwinKind};
use crate::twins::Choice;
use crate::world::World;

/// A virtual darkroom with its instruments. Clones are the same room.
#[derive(Clone)]
pub struct VirtualRoom {
    world: Arc<Mutex<World>>,
    epoch: Instant,
    devices: BTreeMap<Instrument, Device>,
}

/// One twin and its link's faults.
#[derive(Clone)]
struct Device {
    kind: &'static TwinKind,
    twin: Arc<Mutex<Box<dyn Twin>>>,
    faults: Arc<Mutex<LinkFaults>>,
}

/// The tasks that serve a room; dropping it ends them and frees their names.
#[derive(Debug)]
pub struct Serving {
    tasks: JoinSet<()>,
}

impl Serving {
    pub(crate) fn of(tasks: JoinSet<()>) -> Self {
        Self { tasks }
    }

    /// Waits until all its tasks have ended, which they do only when their links end.
    pub async fn finished(mut self) {
        while self.tasks.join_next().await.is_some() {}
    }
}

fn lock<T: ?Sized>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl VirtualRoom {
    /// Name of the pipe of an instrument.
    pub const fn pipe(instrument: Instrument) -> &'static str {
        match instrument {
            Instrument::Spectroradiometer => "spectrometer",
            other => other.name(),
        }
    }

    /// Opens the room that `document` describes, with the default twins; its clock starts now, on the clock of the
    /// present runtime.
    pub fn open(document: Darkroom) -> Self {
        Self::open_with(document, &Choice::default())
    }

    /// The same, with the twins of `choice`.
    pub fn open_with(document: Darkroom, choice: &Choice) -> Self {
        let mut world = World::new(document);
        if choice.twin(Instrument::Supply).is_some() && !world.switches().lamp {
            world.set_supply_v(0.0);
        }
        let document = world.room().document();
        let device = |instrument: Instrument| {
            let kind = choice.twin(instrument)?;
            let faults = LinkFaults::new(&document.fault, instrument, document.seed);
            let device = Device {
                kind,
                twin: Arc::new(Mutex::new((kind.start)(&world))),
                faults: Arc::new(Mutex::new(faults)),
            };
            Some((instrument, device))
        };
        Self {
            devices: choice.instruments().filter_map(device).collect(),
            epoch: Instant::now(),
            world: Arc::new(Mutex::new(world)),
        }
    }

    /// The twin that plays `instrument`; none where the room has no such instrument.
    pub fn twin(&self, instrument: Instrument) -> Option<&'static TwinKind> {
        self.devices.get(&instrument).map(|device| device.kind)
    }

    /// The instruments of the room, in a fixed order.
    pub fn instruments(&self) -> impl Iterator<Item = Instrument> + '_ {
        self.devices.keys().copied()
    }

    /// Serves the instruments as `memory:axes`, `memory:luxmeter`, `memory:spectrometer` and, where there are such,
    /// `memory:outputs`, `memory:powermeter`, `memory:supply` and `memory:oscilloscope` of `links`, on the present
    /// runtime. A pipe opened with other line settings than the instrument has is refused.
    ///
    /// # Errors
    /// A name is served already.
    pub fn listen(&self, links: &MemoryLinks) -> Result<Serving, NameTaken> {
        let mut tasks = JoinSet::new();
        for (&instrument, device) in &self.devices {
            let mut listener = links.listen_at(Self::pipe(instrument), device.kind.line)?;
            let room = self.clone();
            tasks.spawn(async move {
                let mut open = JoinSet::new();
                while let Some(stream) = listener.accept().await {
                    let room = room.clone();
                    open.spawn(async move { room.serve(instrument, stream).await });
                }
                // Nobody is left to open another stream; those that are open go on.
                open.join_all().await;
            });
        }
        Ok(Serving { tasks })
    }

    /// Answers on one stream until it ends.
    pub async fn serve<S: AsyncRead + AsyncWrite + Unpin>(&self, instrument: Instrument, mut stream: S) {
        let Some(device) = self.devices.get(&instrument) else {
            return;
        };
        if lock(&device.faults).refuses(self.now_s()) {
            return;
        }
        let mut inbox = Vec::new();
        let mut buffer = [0; 1024];
        loop {
            match stream.read(&mut buffer).await {
                Ok(0) | Err(_) => return,
                Ok(count) => inbox.extend(&buffer[..count]),
            }
            while let Some(answer) = self.take(device, &mut inbox) {
                let (at_s, make): (f64, Look) = match answer {
                    Answer::At(_, bytes) if bytes.is_empty() => continue,
                    Answer::At(at_s, bytes) => (at_s, Box::new(move |_| bytes)),
                    Answer::When(at_s, make) => (at_s, make),
                };
                self.wait_until(at_s).await;
                let bytes = make(&lock(&self.world));
                let delivery = lock(&device.faults).delivery(bytes, self.now_s());
                match delivery {
                    Delivery::Sent {
                        bytes,
                        delay_s,
                        again_s,
                    } => {
                        for delay_s in [Some(delay_s), again_s].into_iter().flatten() {
                            if delay_s > 0.0 {
                                self.wait_until(self.now_s() + delay_s).await;
                            }
                            if stream.write_all(&bytes).await.is_err() || stream.flush().await.is_err() {
                                return;
                            }
                        }
                    }
                    Delivery::Lost => {}
                    Delivery::Disconnected => return,
                }
            }
        }
    }

    /// Seconds since the room was opened.
    pub fn now_s(&self) -> f64 {
        self.epoch.elapsed().as_secs_f64()
    }

    /// Looks at the room, or reaches into it as a person would.
    pub fn with_world<T>(&self, act: impl FnOnce(&mut World, f64) -> T) -> T {
        let now_s = self.now_s();
        act(&mut lock(&self.world), now_s)
    }

    /// Carries out what a person asks of the instruments' links from now on. False where the room has no such
    /// instrument.
    pub fn order(&self, order: &Order) -> bool {
        let now_s = self.now_s();
        match order {
            Order::Clear(instrument) => {
                for (&name, device) in &self.devices {
                    if instrument.is_none_or(|one| one == name) {
                        lock(&device.faults).clear();
                    }
                }
                lock(&self.world).shade(*instrument);
                instrument.is_none_or(|one| self.devices.contains_key(&one))
            }
            Order::Fault(fault) => {
                let Some(device) = self.devices.get(&fault.instrument) else {
                    return false;
                };
                let mut fault = fault.clone();
                fault.at_s += now_s;
                if fault.kind == FaultKind::Saturate {
                    lock(&self.world).dazzle(fault);
                } else {
                    lock(&device.faults).add(fault);
                }
                true
            }
        }
    }

    fn take(&self, device: &Device, inbox: &mut Vec<u8>) -> Option<Answer> {
        let now_s = self.now_s();
        let mut world = lock(&self.world);
        let mut twin = lock(&device.twin);
        let mut faults = lock(&device.faults);
        if let Some(from_s) = faults.stall_from_s()
            && twin.stall(&mut world, from_s, now_s)
        {
            faults.stalled();
        }
        if faults.alarm_due(now_s) {
            twin.alarm(&mut world, now_s);
        }
        drop(faults);
        twin.receive(inbox, &mut world, now_s)
    }

    async fn wait_until(&self, at_s: f64) {
        let wait = at_s - self.now_s();
        if wait > 0.0 {
            tokio::time::sleep(Duration::from_secs_f64(wait)).await;
        }
    }
}
