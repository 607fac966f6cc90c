//! One owner a link: callers send requests, the owner pumps the codec.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use isolux_device::DeviceError;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::sync::{mpsc, oneshot};
use tokio::time::Instant;

use crate::Link;

/// What a codec must be able to do to own a bus: say which bytes ask, and which bytes answer.
pub trait Conversation: Send + 'static {
    /// One request.
    type Request: Send + 'static;
    /// One answer.
    type Answer: Send + 'static;

    /// Earliest moment at which a request may be sent: after a timeout the line is drained first.
    fn ready_at(&self, now: Instant) -> Instant;

    /// Begins a request; returns the bytes to send. An outcome at once is for requests that nobody answers.
    fn start(&mut self, now: Instant, request: Self::Request) -> (Vec<u8>, Option<Self::Answer>);

    /// Takes bytes as they arrive; the outcome of the request in flight, if they decide it. Called between requests too.
    fn handle_input(&mut self, now: Instant, bytes: &[u8]) -> Option<Outcome<Self::Answer>>;

    /// Answers so far beyond the first to one request, where the language can tell.
    fn surplus(&self) -> u64 {
        0
    }

    /// The deadline has passed: nothing that arrives from now on may answer anything. Returns what had arrived.
    fn abandon(&mut self, now: Instant) -> Vec<u8>;
}

/// How a request ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Outcome<A> {
    /// With its answer.
    Answer(A),
    /// With bytes that are none.
    Malformed {
        /// What is wrong with them.
        reason: String,
        /// The bytes.
        frame: Vec<u8>,
    },
}

/// Why a request has no answer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum BusError {
    /// None came in time.
    Timeout {
        /// How long was waited.
        waited: Duration,
        /// What had arrived by then.
        received: Vec<u8>,
    },
    /// The link is gone; this bus will not come back.
    Disconnected {
        /// What the system said.
        reason: String,
    },
    /// Bytes came that are none.
    Malformed {
        /// What is wrong with them.
        reason: String,
        /// The bytes.
        frame: Vec<u8>,
    },
}

impl BusError {
    /// The same, as the failure of `action` on `device`.
    pub fn during(self, device: &str, action: &str) -> DeviceError {
        let (device, action) = (device.to_owned(), action.to_owned());
        match self {
            Self::Timeout { waited, received } => DeviceError::Timeout {
                device,
                action,
                waited,
                received,
            },
            Self::Disconnected { reason } => DeviceError::Disconnected { device, action, reason },
            Self::Malformed { reason, frame } => DeviceError::Malformed {
                device,
                action,
                reason,
                frame,
            },
        }
    }
}

struct Job<C: Conversation> {
    request: C::Request,
    patience: Duration,
    deadline: Instant,
    reply: oneshot::Sender<Result<C::Answer, BusError>>,
}

/// A handle to the task that owns a link. Clones reach the same task; it ends, and closes the link, with the last of them.
#[derive(Debug)]
pub struct Bus<C: Conversation> {
    jobs: mpsc::Sender<Job<C>>,
    unsolicited: Arc<AtomicU64>,
}

impl<C: Conversation> Clone for Bus<C> {
    fn clone(&self) -> Self {
        Self {
            jobs: self.jobs.clone(),
            unsolicited: Arc::clone(&self.unsolicited),
        }
    }
}

impl<C: Conversation> Bus<C> {
    /// Gives `link` to a new task of the current runtime.
    pub fn spawn(link: Box<dyn Link>, conversation: C) -> Self {
        let (jobs, queue) = mpsc::channel(32);
        let unsolicited = Arc::<AtomicU64>::default();
        tokio::spawn(
            Owner {
                link,
                conversation,
                lost: None,
                unsolicited: Arc::clone(&unsolicited),
            }
            .serve(queue),
        );
        Self { jobs, unsolicited }
    }

    /// How often bytes have arrived while no request was in flight, and second answers to a request. Either means that an
    /// answer that was believed may have belonged to another request: compare before and after reading a value.
    pub fn unsolicited(&self) -> u64 {
        self.unsolicited.load(Ordering::Relaxed)
    }

    /// Whether the link is gone: open it again.
    pub fn is_closed(&self) -> bool {
        self.jobs.is_closed()
    }

    /// Asks, and waits for the answer until `deadline`. If the caller goes away in the middle, the exchange is still brought
    /// to its end, so that its answer cannot reach anybody else.
    ///
    /// # Errors
    /// [`BusError`].
    pub async fn ask(&self, request: C::Request, deadline: Instant) -> Result<C::Answer, BusError> {
        self.ask_within(request, deadline.saturating_duration_since(Instant::now()), deadline)
            .await
    }

    /// The same, with at most `patience` from when the request was sent: time spent in the queue, or on draining the line
    /// after an earlier failure, does not count.
    ///
    /// # Errors
    /// [`BusError`].
    pub async fn ask_within(
        &self,
        request: C::Request,
        patience: Duration,
        deadline: Instant,
    ) -> Result<C::Answer, BusError> {
        let gone = || BusError::Disconnected {
            reason: "the link was lost before".to_owned(),
        };
        let (reply, answer) = oneshot::channel();
        self.jobs
            .send(Job {
                request,
                patience,
                deadline,
                reply,
            })
            .await
            .map_err(|_| gone())?;
        answer.await.unwrap_or_else(|_| Err(gone()))
    }
}

struct Owner<C: Conversation> {
    link: Box<dyn Link>,
    conversation: C,
    lost: Option<String>,
    unsolicited: Arc<AtomicU64>,
}

impl<C: Conversation> Owner<C> {
    async fn serve(mut self, mut queue: mpsc::Receiver<Job<C>>) {
        while self.lost.is_none() {
            tokio::select! {
                biased;
                job = queue.recv() => {
                    let Some(job) = job else { return };
                    if !job.reply.is_closed() {
                        let result = self.exchange(job.request, job.patience, job.deadline).await;
                        let _ = job.reply.send(result);
                    }
                }
                // Between requests: late replies and alerts are read and thrown away, and a lost link is noticed.
                input = read(&mut self.link) => self.discard(input),
            }
        }
        queue.close();
        let reason = self.lost.unwrap_or_default();
        while let Some(job) = queue.recv().await {
            let _ = job.reply.send(Err(BusError::Disconnected { reason: reason.clone() }));
        }
    }

    async fn exchange(
        &mut self,
        request: C::Request,
        patience: Duration,
        deadline: Instant,
    ) -> Result<C::Answer, BusError> {
        let began = Instant::now();
        loop {
            // What has arrived by now was sent before this request: it must not be read as the answer to it.
            let arrived = tokio::select! {
                biased;
                input = read(&mut self.link) => Some(input),
                () = std::future::ready(()) => None,
            };
            if let Some(input) = arrived {
                self.discard(input);
                self.still_connected()?;
                if Instant::now() < deadline {
                    continue;
                }
            }
            let ready = self.conversation.ready_at(Instant::now());
            if ready <= Instant::now() {
                break;
            }
            if ready >= deadline {
                tokio::time::sleep_until(deadline).await;
                return Err(BusError::Timeout {
                    waited: began.elapsed(),
                    received: Vec::new(),
                });
            }
            tokio::select! {
                () = tokio::time::sleep_until(ready) => {}
                input = read(&mut self.link) => self.discard(input),
            }
            self.still_connected()?;
        }
        let deadline = deadline.min(Instant::now() + patience);
        let (frame, at_once) = self.conversation.start(Instant::now(), request);
        let sent = async {
            self.link.write_all(&frame).await?;
            self.link.flush().await
        };
        match tokio::time::timeout_at(deadline, sent).await {
            Ok(Ok(())) => {}
            Ok(Err(error)) => {
                let reason = error.to_string();
                self.lost = Some(reason.clone());
                return Err(BusError::Disconnected { reason });
            }
            Err(_) => {
                let received = self.conversation.abandon(Instant::now());
                return Err(BusError::Timeout {
                    waited: began.elapsed(),
                    received,
                });
            }
        }
        if let Some(answer) = at_once {
            return Ok(answer);
        }
        loop {
            tokio::select! {
                biased;
                input = read(&mut self.link) => {
                    let outcome = self.take(input);
                    self.still_connected()?;
                    match outcome {
                        Some(Outcome::Answer(answer)) => return Ok(answer),
                        Some(Outcome::Malformed { reason, frame }) => return Err(BusError::Malformed { reason, frame }),
                        None => {}
                    }
                }
                () = tokio::time::sleep_until(deadline) => {
                    let received = self.conversation.abandon(Instant::now());
                    return Err(BusError::Timeout { waited: began.elapsed(), received });
                }
            }
        }
    }

    /// Takes what arrived while no request was in flight.
    fn discard(&mut self, input: std::io::Result<Vec<u8>>) {
        if input.as_ref().is_ok_and(|bytes| !bytes.is_empty()) {
            self.unsolicited.fetch_add(1, Ordering::Relaxed);
        }
        self.take(input);
    }

    fn take(&mut self, input: std::io::Result<Vec<u8>>) -> Option<Outcome<C::Answer>> {
        match input {
            // An unplugged USB adapter reads as an endless end of file.
            Ok(bytes) if bytes.is_empty() => {
                self.lost = Some("the other side closed the link".to_owned());
                None
            }
            Ok(bytes) => {
                tracing::trace!(bytes = %bytes.escape_ascii(), "received");
                let before = self.conversation.surplus();
                let outcome = self.conversation.handle_input(Instant::now(), &bytes);
                let surplus = self.conversation.surplus() - before;
                self.unsolicited.fetch_add(surplus, Ordering::Relaxed);
                outcome
            }
            Err(error) => {
                self.lost = Some(error.to_string());
                None
            }
        }
    }

    fn still_connected(&self) -> Result<(), BusError> {
        match &self.lost {
            None => Ok(()),
            Some(reason) => Err(BusError::Disconnected { reason: reason.clone() }),
        }
    }
}

async fn read(link: &mut Box<dyn Link>) -> std::io::Result<Vec<u8>> {
    let mut buffer = vec![0; 4096];
    let count = link.read(&mut buffer).await?;
    buffer.truncate(count);
    Ok(buffer)
}

#[cfg(test)]
mod tests {
    use super::*;
    use tokio::io::DuplexStream;

    /// A toy language: one byte asks, the byte after it answers, 0xFF is damage; quiet for 100 ms after a timeout.
    #[derive(Default)]
    struct Successor {
        waiting: Option<u8>,
        quiet_until: Option<Instant>,
    }

    impl Conversation for Successor {
        type Request = u8;
        type Answer = u8;

        fn ready_at(&self, now: Instant) -> Instant {
            self.quiet_until.unwrap_or(now)
        }

        fn start(&mut self, _: Instant, request: u8) -> (Vec<u8>, Option<u8>) {
            self.waiting = Some(request);
            (vec![request], None)
        }

        fn handle_input(&mut self, now: Instant, bytes: &[u8]) -> Option<Outcome<u8>> {
            if self.waiting.take().is_none() {
                self.quiet_until = Some(now + Duration::from_millis(100));
                return None;
            }
            Some(match bytes[0] {
                0xFF => Outcome::Malformed {
                    reason: "damage".into(),
                    frame: bytes.to_vec(),
                },
                byte => Outcome::Answer(byte),
            })
        }

        fn abandon(&mut self, now: Instant) -> Vec<u8> {
            self.waiting = None;
            self.quiet_until = Some(now + Duration::from_millis(100));
            Vec::new()
        }
    }

    fn bus() -> (Bus<Successor>, DuplexStream) {
        let (host, twin) = tokio::io::duplex(64);
        (Bus::spawn(Box::new(host), Successor::default()), twin)
    }

    fn soon() -> Instant {
        Instant::now() + Duration::from_millis(50)
    }

    #[tokio::test(start_paused = true)]
    async fn many_callers_each_get_their_own_answer() {
        let (bus, mut twin) = bus();
        tokio::spawn(async move {
            while let Ok(byte) = twin.read_u8().await {
                tokio::time::sleep(Duration::from_millis(1)).await;
                let _ = twin.write_u8(byte + 1).await;
            }
        });
        let askers: Vec<_> = (0..20_u8)
            .map(|n| {
                let bus = bus.clone();
                tokio::spawn(async move { (n, bus.ask(n, soon()).await) })
            })
            .collect();
        for asker in askers {
            let (n, answer) = asker.await.unwrap();
            assert_eq!(answer, Ok(n + 1));
        }
    }

    #[tokio::test(start_paused = true)]
    async fn a_late_answer_is_drained_and_a_caller_who_leaves_takes_his_answer_along() {
        let (bus, mut twin) = bus();
        let began = Instant::now();
        let error = bus.ask(1, soon()).await.unwrap_err();
        assert_eq!(
            error,
            BusError::Timeout {
                waited: Duration::from_millis(50),
                received: vec![]
            }
        );
        twin.write_u8(2).await.unwrap();
        let next = bus.ask(10, Instant::now() + Duration::from_secs(1));
        let answer = async {
            assert_eq!(twin.read_u8().await.unwrap(), 1);
            assert_eq!(twin.read_u8().await.unwrap(), 10);
            assert!(
                began.elapsed() >= Duration::from_millis(150),
                "the line was silent first"
            );
            twin.write_u8(11).await.unwrap();
        };
        assert_eq!(tokio::join!(next, answer).0, Ok(11));

        let left = tokio::time::timeout(Duration::from_millis(5), bus.ask(20, soon())).await;
        assert!(left.is_err());
        let next = bus.ask(30, Instant::now() + Duration::from_secs(1));
        let answer = async {
            assert_eq!(twin.read_u8().await.unwrap(), 20);
            twin.write_u8(21).await.unwrap();
            assert_eq!(twin.read_u8().await.unwrap(), 30);
            twin.write_u8(31).await.unwrap();
        };
        assert_eq!(tokio::join!(next, answer).0, Ok(31));
    }

    #[tokio::test(start_paused = true)]
    async fn damage_and_a_lost_link_are_told_apart() {
        let (bus, mut twin) = bus();
        let damage = async {
            assert_eq!(twin.read_u8().await.unwrap(), 1);
            twin.write_u8(0xFF).await.unwrap();
        };
        let (answer, ()) = tokio::join!(bus.ask(1, soon()), damage);
        assert!(matches!(answer, Err(BusError::Malformed { .. })));
        drop(twin);
        assert!(matches!(bus.ask(1, soon()).await, Err(BusError::Disconnected { .. })));
        assert!(matches!(bus.ask(1, soon()).await, Err(BusError::Disconnected { .. })));
        assert!(bus.is_closed());
    }

    #[tokio::test(start_paused = true)]
    async fn what_arrived_before_a_request_never_answers_it_and_is_counted() {
        let (bus, mut twin) = bus();
        // The request is queued and the bytes lie in the link before the owner of the link runs at all.
        twin.write_u8(99).await.unwrap();
        let answer = async {
            assert_eq!(twin.read_u8().await.unwrap(), 1);
            twin.write_u8(2).await.unwrap();
        };
        let deadline = Instant::now() + Duration::from_secs(1);
        assert_eq!(tokio::join!(bus.ask(1, deadline), answer).0, Ok(2));
        assert_eq!(bus.unsolicited(), 1);
        twin.write_u8(3).await.unwrap();
        tokio::time::sleep(Duration::from_millis(1)).await;
        assert_eq!(bus.unsolicited(), 2);
    }

    #[tokio::test(start_paused = true)]
    async fn a_deadline_inside_the_quarantine_is_kept() {
        let (bus, _twin) = bus();
        bus.ask(1, soon()).await.unwrap_err();
        let began = Instant::now();
        assert!(matches!(bus.ask(2, soon()).await, Err(BusError::Timeout { .. })));
        assert_eq!(began.elapsed(), Duration::from_millis(50));
    }
}
