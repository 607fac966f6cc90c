//! The one task that owns a port. Several conversations may live on it, of which one has a request in flight at a time.

use std::any::{Any, TypeId};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::Duration;

use isolux_conversation::{Conversation, Event};
use isolux_device::awake;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::sync::{OwnedMutexGuard, mpsc, oneshot};
use tokio::time::Instant;

use crate::Link;
use crate::exchange::{BusError, Exchanged};

type Anything = Box<dyn Any + Send>;

/// A request for one of the conversations of a port.
pub(crate) struct Job {
    /// Which.
    pub place: usize,
    pub request: Anything,
    pub patience: Duration,
    pub deadline: Instant,
    pub reply: oneshot::Sender<Result<Exchanged<Anything>, BusError>>,
}

enum Message {
    Join(Box<dyn Language>),
    Ask(Job),
}

/// A handle to the task that owns a link. Clones reach the same task; it ends, and closes the link, with the last of
/// them.
#[derive(Debug, Clone)]
pub(crate) struct Port {
    messages: mpsc::Sender<Message>,
    unsolicited: Arc<AtomicU64>,
    turn: Arc<tokio::sync::Mutex<()>>,
    /// The conversations in the order of their places.
    joined: Arc<Mutex<Vec<TypeId>>>,
    lost: Arc<OnceLock<BusError>>,
}

impl Port {
    /// Gives `link` to a new task of the current runtime; `address` is for the log.
    pub fn spawn(link: Box<dyn Link>, address: &str) -> Self {
        let (messages, queue) = mpsc::channel(32);
        let unsolicited = Arc::<AtomicU64>::default();
        let lost = Arc::<OnceLock<BusError>>::default();
        let owner = Owner {
            address: address.to_owned(),
            link,
            conversations: Vec::new(),
            quiet: None,
            lost: Arc::clone(&lost),
            unsolicited: Arc::clone(&unsolicited),
        };
        tokio::spawn(owner.serve(queue));
        Self {
            messages,
            unsolicited,
            turn: Arc::default(),
            joined: Arc::default(),
            lost,
        }
    }

    /// Place of the conversation in the language `C`, which is `begin` where this is the first of that language.
    pub async fn join<C: Conversation>(&self, begin: impl FnOnce() -> C) -> usize {
        // Whoever joins has the turn, so that the places are those in which the owner gets to know the conversations.
        let _turn = self.turn().await;
        let known = {
            let mut joined = self.joined.lock().unwrap_or_else(PoisonError::into_inner);
            let known = joined.iter().position(|language| *language == TypeId::of::<C>());
            if known.is_none() {
                joined.push(TypeId::of::<C>());
            }
            known.ok_or(joined.len() - 1)
        };
        match known {
            Ok(place) => place,
            Err(place) => {
                // Where the owner has ended, whoever asks is told.
                let _ = self.messages.send(Message::Join(Box::new(Spoken(begin())))).await;
                place
            }
        }
    }

    pub fn unsolicited(&self) -> u64 {
        self.unsolicited.load(Ordering::Relaxed)
    }

    pub fn is_closed(&self) -> bool {
        self.messages.is_closed()
    }

    /// Why the link is gone.
    pub fn lost(&self) -> BusError {
        let lost = self.lost.get().cloned();
        lost.unwrap_or_else(|| BusError::Disconnected {
            reason: "what served the link has ended".to_owned(),
        })
    }

    /// The right to send; in the order in which it is asked for.
    pub async fn turn(&self) -> OwnedMutexGuard<()> {
        Arc::clone(&self.turn).lock_owned().await
    }

    /// Hands a job to the owner, unless it has ended.
    pub async fn send(&self, job: Job) -> Result<(), ()> {
        self.messages.send(Message::Ask(job)).await.map_err(|_| ())
    }
}

/// A conversation whose language the owner does not know.
trait Language: Send {
    fn ready_at(&self, now: Instant) -> Instant;
    fn start(&mut self, now: Instant, request: Anything) -> Option<(Vec<u8>, Option<Anything>)>;
    fn handle_input(&mut self, now: Instant, bytes: &[u8]) -> Vec<Event<Anything>>;
    fn surplus(&self) -> u64;
    fn abandon(&mut self, now: Instant) -> Vec<u8>;
}

/// The conversation of one language.
struct Spoken<C>(C);

impl<C: Conversation> Language for Spoken<C> {
    fn ready_at(&self, now: Instant) -> Instant {
        Instant::from_std(self.0.ready_at(now.into_std()))
    }

    fn start(&mut self, now: Instant, request: Anything) -> Option<(Vec<u8>, Option<Anything>)> {
        let request = request.downcast::<C::Request>().ok()?;
        let start = self.0.start(now.into_std(), *request);
        Some((start.frame, start.at_once.map(|answer| Box::new(answer) as Anything)))
    }

    fn handle_input(&mut self, now: Instant, bytes: &[u8]) -> Vec<Event<Anything>> {
        let events = self.0.handle_input(now.into_std(), bytes).into_iter();
        let erased = events.map(|event| match event {
            Event::Answer(answer) => Event::Answer(Box::new(answer) as Anything),
            Event::Malformed { reason, frame } => Event::Malformed { reason, frame },
            Event::Remark(text) => Event::Remark(text),
        });
        erased.collect()
    }

    fn surplus(&self) -> u64 {
        self.0.surplus()
    }

    fn abandon(&mut self, now: Instant) -> Vec<u8> {
        self.0.abandon(now.into_std())
    }
}

/// Silence that a line of several languages is given after a failure.
#[derive(Clone, Copy)]
struct Quiet {
    until: Instant,
    span: Duration,
}

struct Owner {
    address: String,
    link: Box<dyn Link>,
    conversations: Vec<Box<dyn Language>>,
    quiet: Option<Quiet>,
    /// Why the link is gone: the reason with which later requests fail too.
    lost: Arc<OnceLock<BusError>>,
    unsolicited: Arc<AtomicU64>,
}

impl Owner {
    async fn serve(mut self, mut queue: mpsc::Receiver<Message>) {
        while self.lost.get().is_none() {
            tokio::select! {
                biased;
                message = queue.recv() => match message {
                    None => return,
                    Some(Message::Join(conversation)) => self.conversations.push(conversation),
                    Some(Message::Ask(job)) if job.reply.is_closed() => {}
                    Some(Message::Ask(job)) => {
                        let result = self.exchange(job.place, job.request, job.patience, job.deadline).await;
                        let _ = job.reply.send(result);
                    }
                },
                // Between requests: late replies and alerts are read and thrown away, and a lost link is noticed.
                input = read(&mut self.link) => self.discard(input),
            }
        }
        queue.close();
        while let Some(message) = queue.recv().await {
            if let (Message::Ask(job), Err(lost)) = (message, self.still_connected()) {
                let _ = job.reply.send(Err(lost));
            }
        }
    }

    async fn exchange(
        &mut self,
        place: usize,
        request: Anything,
        patience: Duration,
        deadline: Instant,
    ) -> Result<Exchanged<Anything>, BusError> {
        self.until_ready(deadline).await?;
        let sent = Instant::now();
        let deadline = if awake::missed(deadline) {
            sent + patience
        } else {
            deadline.min(sent + patience)
        };
        let result = self.ask(place, request, deadline).await;
        if self.conversations.len() > 1 && matches!(result, Err(BusError::Timeout { .. } | BusError::Malformed { .. }))
        {
            // A language that numbers its messages tells its own late answers apart, and no other language does: where
            // they share a line, it is silent for as long as the answer was waited for.
            let until = Instant::now() + patience;
            self.quiet = Some(Quiet { until, span: patience });
        }
        result.map(|answer| Exchanged { answer, sent })
    }

    /// Waits until every conversation on the port is ready, and reads what has arrived by then.
    async fn until_ready(&mut self, deadline: Instant) -> Result<(), BusError> {
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
            let now = Instant::now();
            let conversations = self.conversations.iter().map(|conversation| conversation.ready_at(now));
            let quiet = self.quiet.map(|quiet| quiet.until);
            let ready = conversations.chain(quiet).fold(now, Instant::max);
            if ready <= Instant::now() {
                self.quiet = None;
                return Ok(());
            }
            // A deadline that passed while this program did not run is none.
            if ready >= deadline && !awake::missed(deadline) {
                tokio::time::sleep_until(deadline).await;
                if awake::missed(deadline) {
                    continue;
                }
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
    }

    /// One request and its answer. Where the program did not run when `deadline` passed, the answer has the whole time
    /// once more.
    async fn ask(&mut self, place: usize, request: Anything, mut deadline: Instant) -> Result<Anything, BusError> {
        let began = Instant::now();
        let patience = deadline.saturating_duration_since(began);
        let started = self.conversations.get_mut(place);
        let Some((frame, at_once)) = started.and_then(|conversation| conversation.start(began, request)) else {
            let reason = "this port has no conversation in that language".to_owned();
            return Err(BusError::Disconnected { reason });
        };
        tracing::trace!(address = self.address, bytes = %frame.escape_ascii(), "sent");
        let sent = async {
            self.link.write_all(&frame).await?;
            self.link.flush().await
        };
        match awake::until(deadline, sent).await {
            Some(Ok(())) => {}
            Some(Err(error)) => {
                let lost = BusError::of_link(&error);
                return Err(self.lost.get_or_init(|| lost).clone());
            }
            None => return Err(self.give_up(place, began)),
        }
        if let Some(answer) = at_once {
            return Ok(answer);
        }
        loop {
            tokio::select! {
                biased;
                input = read(&mut self.link) => {
                    let outcome = self.received(input).and_then(|bytes| self.hear(place, &bytes));
                    self.still_connected()?;
                    if let Some(outcome) = outcome {
                        return outcome;
                    }
                }
                () = tokio::time::sleep_until(deadline) => {
                    if patience.is_zero() || !awake::missed(deadline) {
                        return Err(self.give_up(place, began));
                    }
                    deadline = Instant::now() + patience;
                }
            }
        }
    }

    fn give_up(&mut self, place: usize, began: Instant) -> BusError {
        let conversation = self.conversations.get_mut(place);
        BusError::Timeout {
            waited: began.elapsed(),
            received: conversation.map_or_else(Vec::new, |conversation| conversation.abandon(Instant::now())),
        }
    }

    /// Takes what arrived while no request was in flight: it may concern any of the conversations.
    fn discard(&mut self, input: std::io::Result<Vec<u8>>) {
        let Some(bytes) = self.received(input) else { return };
        self.unsolicited.fetch_add(1, Ordering::Relaxed);
        if let Some(quiet) = &mut self.quiet {
            quiet.until = Instant::now() + quiet.span;
        }
        for place in 0..self.conversations.len() {
            self.hear(place, &bytes);
        }
    }

    /// The bytes that were read, unless the link is lost.
    fn received(&mut self, input: std::io::Result<Vec<u8>>) -> Option<Vec<u8>> {
        match input {
            // An unplugged USB adapter reads as an endless end of file.
            Ok(bytes) if bytes.is_empty() => {
                let reason = "the other side closed the link".to_owned();
                let _ = self.lost.set(BusError::Disconnected { reason });
            }
            Ok(bytes) => {
                tracing::trace!(address = self.address, bytes = %bytes.escape_ascii(), "received");
                return Some(bytes);
            }
            Err(error) => {
                let _ = self.lost.set(BusError::of_link(&error));
            }
        }
        None
    }

    /// Gives bytes to one conversation; how the request in flight ended, if it did.
    fn hear(&mut self, place: usize, bytes: &[u8]) -> Option<Result<Anything, BusError>> {
        let conversation = self.conversations.get_mut(place)?;
        let before = conversation.surplus();
        let events = conversation.handle_input(Instant::now(), bytes);
        let surplus = conversation.surplus().saturating_sub(before);
        self.unsolicited.fetch_add(surplus, Ordering::Relaxed);
        let mut outcome = None;
        for event in events {
            match event {
                Event::Answer(answer) => outcome = Some(Ok(answer)),
                Event::Malformed { reason, frame } => outcome = Some(Err(BusError::Malformed { reason, frame })),
                Event::Remark(text) => tracing::warn!(address = self.address, "{text}"),
            }
        }
        outcome
    }

    fn still_connected(&self) -> Result<(), BusError> {
        self.lost.get().cloned().map_or(Ok(()), Err)
    }
}

async fn read(link: &mut Box<dyn Link>) -> std::io::Result<Vec<u8>> {
    let mut buffer = vec![0; 4096];
    let count = link.read(&mut buffer).await?;
    buffer.truncate(count);
    Ok(buffer)
}
