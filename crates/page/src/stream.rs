//! Events out: one stream a browser, at most ten messages a second, from where the browser stands.

use std::convert::Infallible;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};
use std::time::Duration;

use axum::extract::{Query, State};
use axum::http::HeaderMap;
use axum::response::sse::{Event, KeepAlive, Sse};
use futures_core::Stream;
use serde::Deserialize;
use tokio::sync::mpsc::{Receiver, Sender, channel};
use tokio::time::sleep_until;

use crate::broadcast::Broadcast;
use crate::shared::Shared;

/// Not more often than a screen can follow.
const BETWEEN_MESSAGES: Duration = Duration::from_millis(100);
/// A connection that says nothing for so long is taken for lost by the page.
const SIGN_OF_LIFE: Duration = Duration::from_secs(5);

/// Where a reader stands.
#[derive(Debug, Default, Deserialize)]
pub struct From {
    /// The scan.
    #[serde(default)]
    pub session: u64,
    /// Number of the first event that it lacks.
    #[serde(default)]
    pub from: usize,
}

/// Where a reader stands by its headers: the last id that it has seen is of the event before.
fn last_event(headers: &HeaderMap) -> Option<(u64, usize)> {
    let id = headers.get("last-event-id")?.to_str().ok()?;
    let (session, next) = id.split_once('-')?;
    Some((session.parse().ok()?, next.parse().ok()?))
}

/// Messages on their way to one browser.
struct Messages(Receiver<Event>);

impl Stream for Messages {
    type Item = Result<Event, Infallible>;

    fn poll_next(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<Self::Item>> {
        self.0.poll_recv(context).map(|event| event.map(Ok))
    }
}

/// `GET /api/stream`, from `Last-Event-ID` or `?session=&from=` on.
pub async fn stream(
    State(shared): State<Arc<Shared>>,
    Query(from): Query<From>,
    headers: HeaderMap,
) -> Sse<impl Stream<Item = Result<Event, Infallible>>> {
    let (session, next) = last_event(&headers).unwrap_or((from.session, from.from));
    // A slow browser is waited for: it gets fewer and larger messages.
    let (sender, receiver) = channel(1);
    let broadcast = shared.controller.broadcast().clone();
    tokio::spawn(async move { send(&broadcast, session, next, &sender).await });
    Sse::new(Messages(receiver)).keep_alive(KeepAlive::new().interval(SIGN_OF_LIFE).text("alive"))
}

/// Until the browser goes away.
async fn send(broadcast: &Arc<Broadcast>, mut session: u64, mut next: usize, sender: &Sender<Event>) {
    let _reader = broadcast.reader();
    let mut changes = broadcast.changes();

    loop {
        changes.mark_unchanged();
        let message = broadcast.message(session, next);
        (session, next) = (message.session, message.next);
        let event = Event::default().id(format!("{session}-{next}")).data(message.text);
        if sender.send(event).await.is_err() {
            return;
        }
        if message.more {
            continue;
        }
        let last = tokio::time::Instant::now();
        tokio::select! {
            changed = changes.changed() => if changed.is_err() { return },
            () = sender.closed() => return,
        }
        tokio::select! {
            () = sleep_until(last + BETWEEN_MESSAGES) => {}
            () = sender.closed() => return,
        }
    }
}
