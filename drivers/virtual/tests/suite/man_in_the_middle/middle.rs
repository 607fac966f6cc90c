//! A man in the middle: a link that carries every byte between driver and twin, and damages, delays, repeats and plays
//! back some of them. What it does follows from its seed.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use async_trait::async_trait;
use isolux_transport::{LineSettings, Link, LinkError, Links, MemoryLinks};
use tokio::io::{AsyncReadExt, AsyncWriteExt, ReadHalf, WriteHalf};
use tokio::sync::mpsc;
use tokio::time::{Instant, sleep};

/// Frames that are remembered to be played back, across reopenings too.
const REMEMBERED: usize = 400;

/// An answer is replaced by an old one at most once in so many. Twice in a row, both times at the right moment and with
/// the same value, is what no check can tell from the truth; the book says so.
const BETWEEN_REPLACEMENTS: u64 = 8;

/// Numbers from a seed (splitmix64).
pub struct Dice(u64);

impl Dice {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    fn word(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    pub fn below(&mut self, end: usize) -> usize {
        (self.word() % end.max(1) as u64) as usize
    }

    /// From `from` to `to`.
    pub fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * (self.word() >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn chance(&mut self, probability: f64) -> bool {
        self.between(0.0, 1.0) < probability
    }

    /// Short and long times alike.
    fn seconds(&mut self, from: f64, to: f64) -> Duration {
        Duration::from_secs_f64(self.between(from.ln(), to.ln()).exp())
    }
}

struct Mind {
    dice: Dice,
    /// Share of the answers that meet a fault; of the requests a third of that.
    rate: f64,
    history: VecDeque<(Instant, Vec<u8>)>,
    held: Option<Vec<u8>>,
    last_request: Vec<u8>,
    replaced_at: u64,
    requests: u64,
    answers: u64,
    faults: BTreeMap<&'static str, u64>,
}

/// Links that pass through the man in the middle. Clones share him.
#[derive(Clone)]
pub struct Middle {
    inner: MemoryLinks,
    mind: Arc<Mutex<Mind>>,
}

/// What becomes of one frame.
#[derive(Default)]
struct Delivery {
    /// The whole line waits.
    stall: Duration,
    /// What is delivered, each after so long.
    pieces: Vec<(Duration, Vec<u8>)>,
}

impl Middle {
    pub fn new(inner: MemoryLinks, seed: u64, rate: f64) -> Self {
        let mind = Mind {
            dice: Dice::new(seed),
            rate,
            history: VecDeque::new(),
            held: None,
            last_request: Vec::new(),
            replaced_at: 0,
            requests: 0,
            answers: 0,
            faults: BTreeMap::new(),
        };
        Self {
            inner,
            mind: Arc::new(Mutex::new(mind)),
        }
    }

    /// Requests that went through so far.
    pub fn exchanges(&self) -> u64 {
        self.mind.lock().unwrap().requests
    }

    pub fn faults(&self) -> BTreeMap<&'static str, u64> {
        self.mind.lock().unwrap().faults.clone()
    }

    async fn requests(self, mut host: ReadHalf<impl Link>, mut device: WriteHalf<Box<dyn Link>>) {
        let mut buffer = vec![0; 1024];
        while let Ok(count @ 1..) = host.read(&mut buffer).await {
            let delivery = self.mind.lock().unwrap().of_request(&buffer[..count]);
            sleep(delivery.stall).await;
            for (_, bytes) in delivery.pieces {
                let _ = device.write_all(&bytes).await;
            }
        }
        let _ = device.shutdown().await;
    }

    async fn answers(self, mut device: ReadHalf<Box<dyn Link>>, host: mpsc::UnboundedSender<Vec<u8>>) {
        let mut buffer = vec![0; 16 * 1024];
        while let Ok(count @ 1..) = device.read(&mut buffer).await {
            let delivery = self.mind.lock().unwrap().of_answer(&buffer[..count]);
            sleep(delivery.stall).await;
            deliver(&host, delivery.pieces);
        }
    }
}

fn deliver(host: &mpsc::UnboundedSender<Vec<u8>>, pieces: Vec<(Duration, Vec<u8>)>) {
    for (delay, bytes) in pieces {
        if delay.is_zero() {
            let _ = host.send(bytes);
        } else {
            let host = host.clone();
            tokio::spawn(async move {
                sleep(delay).await;
                let _ = host.send(bytes);
            });
        }
    }
}

async fn write(mut host: WriteHalf<impl Link>, mut frames: mpsc::UnboundedReceiver<Vec<u8>>) {
    while let Some(frame) = frames.recv().await {
        if host.write_all(&frame).await.is_err() {
            return;
        }
    }
}

#[async_trait]
impl Links for Middle {
    async fn open(&self, address: &str, line: LineSettings) -> Result<Box<dyn Link>, LinkError> {
        let device = self.inner.open(address, line).await?;
        let (host, ours) = tokio::io::duplex(64 * 1024);
        let (from_host, to_host) = tokio::io::split(ours);
        let (from_device, to_device) = tokio::io::split(device);
        let (sender, receiver) = mpsc::unbounded_channel();
        tokio::spawn(write(to_host, receiver));
        // What was said before the link was closed arrives after it was opened again.
        let late = self.mind.lock().unwrap().of_opening();
        deliver(&sender, late);
        tokio::spawn(self.clone().requests(from_host, to_device));
        tokio::spawn(self.clone().answers(from_device, sender));
        Ok(Box::new(host))
    }
}

impl Mind {
    fn count(&mut self, fault: &'static str) {
        *self.faults.entry(fault).or_default() += 1;
    }

    fn of_opening(&mut self) -> Vec<(Duration, Vec<u8>)> {
        let mut pieces = Vec::new();
        while !self.history.is_empty() && self.dice.chance(0.5) {
            let at = self.dice.below(self.history.len());
            self.count("old answer after reopening");
            pieces.push((self.dice.seconds(0.001, 3.0), self.history[at].1.clone()));
        }
        pieces
    }

    fn of_request(&mut self, bytes: &[u8]) -> Delivery {
        self.requests += 1;
        self.last_request = bytes.to_vec();
        let mut delivery = Delivery {
            pieces: vec![(Duration::ZERO, bytes.to_vec())],
            ..Delivery::default()
        };
        if !self.dice.chance(self.rate / 3.0) {
            return delivery;
        }
        match self.dice.below(5) {
            0 => {
                self.count("request lost");
                delivery.pieces.clear();
            }
            1 => {
                self.count("request late");
                delivery.stall = self.dice.seconds(0.001, 0.3);
            }
            2 => {
                self.count("request twice");
                delivery.pieces.push(delivery.pieces[0].clone());
            }
            3 => {
                self.count("bits of a request flipped");
                self.flip(&mut delivery.pieces[0].1);
            }
            _ => {
                self.count("garbage before a request");
                let garbage = self.garbage();
                delivery.pieces.insert(0, (Duration::ZERO, garbage));
            }
        }
        delivery
    }

    fn of_answer(&mut self, bytes: &[u8]) -> Delivery {
        self.answers += 1;
        let now = Instant::now();
        let mut delivery = Delivery {
            pieces: vec![(Duration::ZERO, bytes.to_vec())],
            ..Delivery::default()
        };
        // An answer that was held back comes after this one.
        let held = self.held.take();
        while self.dice.chance(self.rate) {
            self.damage(bytes, &mut delivery);
        }
        delivery.pieces.extend(held.map(|held| (Duration::ZERO, held)));
        self.history.push_back((now, bytes.to_vec()));
        if self.history.len() > REMEMBERED {
            self.history.pop_front();
        }
        delivery
    }

    fn damage(&mut self, bytes: &[u8], delivery: &mut Delivery) {
        let zero = Duration::ZERO;
        match self.dice.below(14) {
            0 => {
                self.count("lost");
                delivery.pieces.clear();
            }
            1 => {
                self.count("late, out of order");
                let delay = self.dice.seconds(0.02, 5.0);
                delivery.pieces.iter_mut().for_each(|piece| piece.0 += delay);
            }
            2 => {
                self.count("the line stands still");
                delivery.stall += self.dice.seconds(0.02, 1.5);
            }
            3 => {
                self.count("twice");
                let delay = if self.dice.chance(0.3) {
                    zero
                } else {
                    self.dice.seconds(0.001, 1.0)
                };
                delivery.pieces.push((delay, bytes.to_vec()));
            }
            4 | 5 => {
                if let Some(old) = self.old(bytes) {
                    self.count("old answer before the true one");
                    delivery.pieces.insert(0, (zero, old));
                }
            }
            6 => {
                if let Some(old) = self.old(bytes) {
                    self.count("old answer later");
                    delivery.pieces.push((self.dice.seconds(0.001, 5.0), old));
                }
            }
            7 => {
                if self.answers >= self.replaced_at + BETWEEN_REPLACEMENTS
                    && let Some(old) = self.old(bytes)
                {
                    self.replaced_at = self.answers;
                    self.count("old answer instead of the true one");
                    delivery.pieces = vec![(zero, old)];
                }
            }
            8 => {
                self.count("bits flipped");
                if let Some(piece) = delivery.pieces.first_mut() {
                    let mut bytes = std::mem::take(&mut piece.1);
                    self.flip(&mut bytes);
                    delivery.pieces[0].1 = bytes;
                }
            }
            9 => {
                self.count("torn in two");
                if let Some((delay, whole)) = delivery.pieces.pop() {
                    let at = self.dice.below(whole.len());
                    let gap = self.dice.seconds(0.001, 0.6);
                    delivery.pieces.push((delay, whole[..at].to_vec()));
                    delivery.pieces.push((delay + gap, whole[at..].to_vec()));
                }
            }
            10 => {
                self.count("cut short");
                if let Some(piece) = delivery.pieces.last_mut() {
                    piece.1.truncate(self.dice.below(piece.1.len()));
                }
            }
            11 => {
                self.count("garbage");
                let at = self.dice.below(delivery.pieces.len() + 1);
                let garbage = self.garbage();
                delivery.pieces.insert(at, (zero, garbage));
            }
            12 => {
                self.count("request echoed");
                let at = self.dice.below(delivery.pieces.len() + 1);
                delivery.pieces.insert(at, (zero, self.last_request.clone()));
            }
            _ => {
                self.count("held back until after the next");
                delivery.pieces.clear();
                self.held = Some(bytes.to_vec());
            }
        }
    }

    /// An answer of before: 0.1 s to 5 s old, or any that begins or is as long as this one, so that it fits the
    /// request.
    fn old(&mut self, like: &[u8]) -> Option<Vec<u8>> {
        let begins = |frame: &[u8]| frame.len() >= 8 && frame.get(..8) == like.get(..8) && frame != like;
        let age = self.dice.seconds(0.1, 5.0);
        let way = self.dice.below(3);
        let fits = |(at, frame): &&(Instant, Vec<u8>)| match way {
            0 => at.elapsed() >= age,
            1 => begins(frame),
            _ => frame.len() == like.len() && at.elapsed() >= age,
        };
        self.history.iter().rev().find(fits).map(|(_, frame)| frame.clone())
    }

    /// One to three bits.
    fn flip(&mut self, bytes: &mut [u8]) {
        if bytes.is_empty() {
            return;
        }
        for _ in 0..=self.dice.below(3) {
            let at = self.dice.below(bytes.len());
            bytes[at] ^= 1 << self.dice.below(8);
        }
    }

    fn garbage(&mut self) -> Vec<u8> {
        (0..=self.dice.below(40)).map(|_| self.dice.word() as u8).collect()
    }
}
