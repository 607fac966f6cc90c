//! A handle on a port in one language: asking, asking again, and keeping the line for a while.

use std::any::Any;
use std::marker::PhantomData;
use std::time::Duration;

use isolux_conversation::Conversation;
use isolux_device::awake;
use tokio::sync::{OwnedMutexGuard, oneshot};
use tokio::time::Instant;

use crate::exchange::{BusError, Exchanged};
use crate::port::{Job, Port};

/// A request whose answer is lost or damaged is made so often in all before its failure is told. Drivers count to the
/// same number where they have to look at an answer to know that it is none; nothing above them asks again.
pub const TRIES: u32 = 4;

/// A handle on the task that owns a port, in the language `C`. Clones share it, and the conversation too.
#[derive(Debug)]
pub struct Bus<C: Conversation> {
    port: Port,
    /// Place of the conversation among those of the port.
    place: usize,
    language: PhantomData<fn() -> C>,
}

impl<C: Conversation> Clone for Bus<C> {
    fn clone(&self) -> Self {
        Self {
            port: self.port.clone(),
            place: self.place,
            language: PhantomData,
        }
    }
}

impl<C: Conversation> Bus<C> {
    /// A handle on `port`. The first of a language brings its conversation, `begin`; the others share it.
    pub(crate) async fn on(port: Port, begin: impl FnOnce() -> C) -> Self {
        let place = port.join(begin).await;
        Self {
            port,
            place,
            language: PhantomData,
        }
    }

    /// How often bytes have arrived on this port while no request was in flight, and second answers to a request.
    /// Either means that an answer that was believed may have belonged to another request: compare before and after
    /// reading a value.
    pub fn unsolicited(&self) -> u64 {
        self.port.unsolicited()
    }

    /// Whether the link is gone: open it again.
    pub fn is_closed(&self) -> bool {
        self.port.is_closed()
    }

    /// Asks, and waits for the answer until `deadline`. If the caller goes away in the middle, the exchange is still
    /// brought to its end, so that its answer cannot reach anybody else.
    ///
    /// # Errors
    /// [`BusError`].
    pub async fn ask(&self, request: C::Request, deadline: Instant) -> Result<C::Answer, BusError> {
        self.ask_within(request, deadline.saturating_duration_since(Instant::now()), deadline)
            .await
    }

    /// The same, with at most `patience` from when the request was sent: time spent in the queue, or on draining the
    /// line after an earlier failure, does not count.
    ///
    /// # Errors
    /// [`BusError`].
    pub async fn ask_within(
        &self,
        request: C::Request,
        patience: Duration,
        deadline: Instant,
    ) -> Result<C::Answer, BusError> {
        let line = self.exclusive(deadline).await?;
        Ok(line.exchange(request, patience, deadline).await?.answer)
    }

    /// The same, [`TRIES`] times in all where the answer is lost or damaged. The codec drains the line in between. In a
    /// language whose answers carry no number that is not enough: there `prove` is a request whose answer looks like no
    /// other, and it must be answered before `request` is made again; it counts as a try.
    ///
    /// # Errors
    /// [`BusError`] of the last try.
    pub async fn ask_again(
        &self,
        request: C::Request,
        prove: Option<C::Request>,
        patience: Duration,
        deadline: Instant,
    ) -> Result<C::Answer, BusError>
    where
        C::Request: Clone,
    {
        let (mut tries, mut in_step) = (1, true);
        loop {
            let proof = prove.as_ref().filter(|_| !in_step);
            let next = proof.unwrap_or(&request).clone();
            match self.ask_within(next, patience, deadline).await {
                Ok(answer) if in_step || proof.is_none() => return Ok(answer),
                Ok(_) => in_step = true,
                Err(error) if tries < TRIES && error.is_worth_another_try() => {
                    tracing::warn!(?error, tries, "asking again");
                    tries += 1;
                    in_step = false;
                }
                Err(error) => return Err(error),
            }
        }
    }

    /// Keeps the port to the caller until what is returned is dropped: the requests of every other handle wait, so that
    /// all bytes that arrive in that time concern the caller's requests. For languages without request numbers, around
    /// an exchange and the time in which its true answer would still arrive. Everything else on the line waits, a
    /// `stop` too: keep it short.
    ///
    /// # Errors
    /// [`BusError::Timeout`] when others keep the port until `deadline`.
    pub async fn exclusive(&self, deadline: Instant) -> Result<ExclusiveAccess<'_, C>, BusError> {
        let began = Instant::now();
        match awake::until(deadline, self.port.turn()).await {
            Some(turn) => Ok(ExclusiveAccess { bus: self, _turn: turn }),
            None => Err(BusError::Timeout {
                waited: began.elapsed(),
                received: Vec::new(),
            }),
        }
    }
}

/// A port that one caller has to itself; see [`Bus::exclusive`].
#[derive(Debug)]
pub struct ExclusiveAccess<'a, C: Conversation> {
    bus: &'a Bus<C>,
    _turn: OwnedMutexGuard<()>,
}

impl<C: Conversation> ExclusiveAccess<'_, C> {
    /// As [`Bus::ask_within`], with the moment at which the request was sent.
    ///
    /// # Errors
    /// [`BusError`].
    pub async fn exchange(
        &self,
        request: C::Request,
        patience: Duration,
        deadline: Instant,
    ) -> Result<Exchanged<C::Answer>, BusError> {
        let gone = || self.bus.port.lost();
        let (reply, answer) = oneshot::channel();
        let job = Job {
            place: self.bus.place,
            request: Box::new(request),
            patience,
            deadline,
            reply,
        };
        self.bus.port.send(job).await.map_err(|()| gone())?;
        let Exchanged { answer, sent } = answer.await.unwrap_or_else(|_| Err(gone()))?;
        let answer: Box<dyn Any + Send> = answer;
        match answer.downcast() {
            Ok(answer) => Ok(Exchanged { answer: *answer, sent }),
            // The place of a handle is that of a conversation of its language.
            Err(_) => Err(gone()),
        }
    }
}

#[cfg(test)]
mod tests;
