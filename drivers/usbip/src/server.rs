//! A bench of USB devices on a TCP port: lists them, and lets a host attach each once.

use std::io;
use std::net::SocketAddr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{Notify, mpsc};
use tokio::task::JoinSet;

use crate::device::Device;
use crate::model::Model;
use crate::wire::{self, Answer, Command, Opening};

/// A byte stream to a twin.
pub trait Stream: AsyncRead + AsyncWrite + Send + Unpin {}

impl<T: AsyncRead + AsyncWrite + Send + Unpin> Stream for T {}

/// A device that can be attached, and its faults. Clones are the same device.
#[derive(Clone)]
pub struct Twin {
    model: Model,
    connect: Arc<dyn Fn() -> Box<dyn Stream> + Send + Sync>,
    device: Arc<Mutex<Option<Device>>>,
    unplugged: Arc<Notify>,
    /// Something has changed that is no byte.
    changed: Arc<Notify>,
}

impl Twin {
    /// A device that speaks as what is behind `connect` does: a new stream each time that a host attaches it.
    pub fn new<S: AsyncRead + AsyncWrite + Send + Unpin + 'static>(
        model: Model,
        connect: impl Fn() -> S + Send + Sync + 'static,
    ) -> Self {
        Self {
            model,
            connect: Arc::new(move || Box::new(connect()) as Box<dyn Stream>),
            device: Arc::default(),
            unplugged: Arc::default(),
            changed: Arc::default(),
        }
    }

    /// What the device says of itself.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Whether a host has it.
    pub fn is_attached(&self) -> bool {
        self.device().is_some()
    }

    /// Pulls the cable. The host may attach it again.
    pub fn unplug(&self) {
        self.unplugged.notify_waiters();
    }

    /// Halts an endpoint until the host clears it.
    pub fn stall(&self, endpoint: u8) {
        if let Some(device) = &mut *self.device() {
            device.halt(endpoint, true);
        }
        self.changed.notify_one();
    }

    /// Lets the next packet of an endpoint be longer than a packet may be.
    pub fn overflow(&self, endpoint: u8) {
        if let Some(device) = &mut *self.device() {
            device.overflow(endpoint);
        }
    }

    fn device(&self) -> MutexGuard<'_, Option<Device>> {
        self.device.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Attaches the device for as long as the host wants it.
    async fn serve(&self, stream: TcpStream) -> io::Result<()> {
        let (mut from_host, mut to_host) = stream.into_split();
        let mut twin = (self.connect)();
        let (commands, mut queue) = mpsc::channel(64);
        // A command is read in several steps, which a select would tear apart.
        let mut reading = JoinSet::new();
        reading.spawn(async move {
            while let Ok(command) = wire::command(&mut from_host).await {
                if commands.send(command).await.is_err() {
                    return;
                }
            }
        });
        let unplugged = self.unplugged.notified();
        tokio::pin!(unplugged);
        unplugged.as_mut().enable();
        let mut buffer = vec![0; 1 << 16];
        loop {
            let (answers, bytes) = tokio::select! {
                biased;
                () = &mut unplugged => return Ok(()),
                command = queue.recv() => match command {
                    Some(command) => self.take(command),
                    None => return Ok(()),
                },
                () = self.changed.notified() => (self.with(Device::answers), Vec::new()),
                count = twin.read(&mut buffer) => match count? {
                    // The twin has lost its link, which here is the cable.
                    0 => return Ok(()),
                    count => (self.with(|device| device.stated(&buffer[..count])), Vec::new()),
                },
            };
            if !bytes.is_empty() {
                twin.write_all(&bytes).await?;
                twin.flush().await?;
            }
            for answer in answers {
                to_host.write_all(&answer.encode()).await?;
            }
        }
    }

    fn take(&self, command: Command) -> (Vec<Answer>, Vec<u8>) {
        match &mut *self.device() {
            Some(device) => match command {
                Command::Submit(urb) => device.submit(urb),
                Command::Unlink { number, forget } => (vec![device.unlink(number, forget)], Vec::new()),
            },
            None => (Vec::new(), Vec::new()),
        }
    }

    fn with(&self, act: impl FnOnce(&mut Device) -> Vec<Answer>) -> Vec<Answer> {
        self.device().as_mut().map(act).unwrap_or_default()
    }
}

/// Devices on a TCP port. They are called `1-1`, `1-2`, … in the order of their places.
pub struct Bench {
    listener: TcpListener,
    twins: Vec<Twin>,
}

impl Bench {
    /// Takes `port` of the loopback address, 0 for a free one.
    ///
    /// # Errors
    /// The system refuses the port.
    pub async fn bind(port: u16, twins: Vec<Twin>) -> io::Result<Self> {
        let listener = TcpListener::bind(("127.0.0.1", port)).await?;
        Ok(Self { listener, twins })
    }

    /// Where it listens.
    ///
    /// # Errors
    /// The system does not say.
    pub fn address(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }

    /// Name of the device at `place`, as a host asks for it.
    pub fn name(place: usize) -> String {
        format!("1-{}", place + 1)
    }

    /// Serves hosts until it is dropped.
    pub async fn serve(self) {
        let mut hosts = JoinSet::new();
        loop {
            let Ok((stream, _)) = self.listener.accept().await else {
                continue;
            };
            let _ = stream.set_nodelay(true);
            let twins = self.twins.clone();
            // A host that speaks nonsense loses its connection and nothing else.
            hosts.spawn(async move { host(stream, &twins).await });
        }
    }
}

async fn host(mut stream: TcpStream, twins: &[Twin]) -> io::Result<()> {
    match wire::opening(&mut stream).await? {
        Opening::List => {
            let free = twins.iter().enumerate().filter(|(_, twin)| !twin.is_attached());
            let devices: Vec<_> = free.map(|(place, twin)| (Bench::name(place), &twin.model)).collect();
            stream.write_all(&wire::list(&devices)).await
        }
        Opening::Import(name) => {
            let found = twins.iter().enumerate().find(|(place, _)| Bench::name(*place) == name);
            let Some((place, twin)) = found.filter(|(_, twin)| twin.claim()) else {
                return stream.write_all(&wire::import(None)).await;
            };
            let sent = stream.write_all(&wire::import(Some((&name, place, &twin.model)))).await;
            let served = match sent {
                Ok(()) => twin.serve(stream).await,
                Err(error) => Err(error),
            };
            *twin.device() = None;
            served
        }
    }
}

impl Twin {
    /// Becomes attached; false where it already is.
    fn claim(&self) -> bool {
        let mut device = self.device();
        let free = device.is_none();
        if free {
            *device = Some(Device::new(self.model.clone()));
        }
        free
    }
}
