//! The local page: what the bench does, live, and the operator's commands, on the loopback interface.
//!
//! One process serves one controller. Everything that moves an axis goes through [`isolux_app`]; this crate holds no physics
//! and opens no instrument. The order of the checks before a route is in `guard.rs`.

mod assets;
mod broadcast;
mod command;
mod controller;
mod guard;
mod runs;
mod server;
mod shared;
mod so_far;
mod stream;
mod study;

use std::net::{SocketAddr, TcpListener};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread::sleep;
use std::time::{Duration, Instant};

use broadcast::TabProgress;
use camino::Utf8Path;
use command::Order;
use controller::Controller;
use guard::Guard;
use isolux_app::day::{self, Options};
use isolux_app::front_end::control::{Control, Pace};
use isolux_app::front_end::live::{Live, State};
use isolux_app::front_end::progress::{Event, Progress};
use isolux_app::study::next;
use isolux_app::study::what_if::WhatIf;
use isolux_app::system::signals::OnSignals;
use isolux_app::{Failure, FailureKind};
pub use runs::BUILT_IN;
use shared::Shared;

/// Where and for whom the page is served.
#[derive(Debug, Clone, Copy)]
pub struct Place<'a> {
    /// Address and port; port 0 for a free one.
    pub listen: SocketAddr,
    /// Whether everybody who reaches the address and has its code may drive the axes.
    pub others_may_drive: bool,
    /// The folder of jobs and runs.
    pub folder: &'a Utf8Path,
    /// How a virtual bench runs.
    pub pace: Pace,
}

/// How often what lies on the disk is looked at.
const BETWEEN_LOOKS: Duration = Duration::from_secs(1);
/// How often the state of the control is looked at.
const BETWEEN_TICKS: Duration = Duration::from_millis(100);
/// A browser may take so long to open the page, or to come back to it.
const NOBODY_LOOKS: Duration = Duration::from_secs(10);

/// A page that is served, until the program ends.
pub struct Page {
    controller: Arc<Controller>,
    url: String,
}

impl Page {
    /// Serves a page beside a scan of the command line.
    ///
    /// # Errors
    /// Bad input (exit 2) for an address beyond loopback without the flag; exit 3 when the system refuses the port.
    pub fn beside_a_scan(place: &Place<'_>, say: impl Fn(&str) + Send + Sync + 'static) -> Result<Self, Failure> {
        let controller = Arc::new(Controller::new(place.folder, place.pace, None));
        Self::serve(place, controller, say)
    }

    fn serve(
        place: &Place<'_>,
        controller: Arc<Controller>,
        say: impl Fn(&str) + Send + Sync + 'static,
    ) -> Result<Self, Failure> {
        let ip = place.listen.ip();
        if !ip.is_loopback() && !place.others_may_drive {
            let message =
                format!("{ip} can be reached by other machines, and whoever has the page's code may drive the axes");
            return Err(Failure::bad_input(message).help(
                "leave --listen out for this machine alone, or give --others-may-drive-the-axes; what is sent is not encrypted",
            ));
        }
        let refused = |error: std::io::Error| Failure::instrument(format!("{}: cannot listen: {error}", place.listen));
        let listener = TcpListener::bind(place.listen).map_err(refused)?;
        listener.set_nonblocking(true).map_err(refused)?;
        let guard = Guard::new(listener.local_addr().map_err(refused)?)?;
        let url = guard.launch_url();
        let shared = Arc::new(Shared {
            guard,
            controller: controller.clone(),
            what_if: WhatIf::default(),
            say: Box::new(move |url| say(&format!("for another browser: {url}"))),
        });
        // A thread and a runtime of its own: the runtime of a scan may be in virtual time.
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .map_err(Failure::instrument)?;
        let looking = controller.clone();
        controller.look();
        std::thread::spawn(move || {
            runtime.block_on(async {
                let Ok(listener) = tokio::net::TcpListener::from_std(listener) else {
                    return;
                };
                tokio::spawn(look(looking));
                let _ = axum::serve(listener, server::router(shared)).await;
            });
        });
        Ok(Self { controller, url })
    }

    /// The address that opens the page once.
    pub fn url(&self) -> &str {
        &self.url
    }

    /// Opens the page in the browser that `BROWSER` names or in that of the desktop; whether one was started.
    pub fn open(&self) -> bool {
        // A list of browsers is no program: the desktop reads it then.
        let named = std::env::var("BROWSER").is_ok_and(|browser| open::with_detached(&self.url, browser).is_ok());
        named || open::that_detached(&self.url).is_ok()
    }

    /// Carries out a scan that this page shows and commands, under `control`.
    ///
    /// # Errors
    /// Those of `work`.
    pub fn show<T>(
        &self,
        control: &Control,
        beside: &dyn Progress,
        work: impl FnOnce(&dyn Progress) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        self.controller.began(control);
        let outcome = work(&Steps {
            tabs: TabProgress {
                broadcast: self.controller.broadcast(),
                beside,
            },
        });
        self.controller.ended(outcome.as_ref().err());
        outcome
    }

    /// Returns when no browser has shown the page for a while, or when a signal comes.
    ///
    /// # Errors
    /// Exit 3 when the system refuses the signal handlers.
    pub fn until_nobody_looks(&self) -> Result<(), Failure> {
        let signals = OnSignals::listen()?;
        let mut seen = Instant::now();
        while signals.reason().is_none() && seen.elapsed() < NOBODY_LOOKS {
            if self.controller.broadcast().readers() > 0 {
                seen = Instant::now();
            }
            sleep(BETWEEN_TICKS);
        }
        Ok(())
    }
}

async fn look(controller: Arc<Controller>) {
    let mut looked = Instant::now();
    loop {
        tokio::time::sleep(BETWEEN_TICKS).await;
        controller.tick();
        if looked.elapsed() > BETWEEN_LOOKS {
            let controller = controller.clone();
            let _ = tokio::task::spawn_blocking(move || {
                controller.look();
                controller.so_far().follow();
            })
            .await;
            looked = Instant::now();
        }
    }
}

/// Serves the page until a signal comes: `isolux serve`. `say` prints a line; `opened` is told the page once it can be
/// opened.
///
/// # Errors
/// As [`Page::beside_a_scan`].
pub fn serve(
    place: &Place<'_>,
    beside: &dyn Progress,
    say: impl Fn(&str) + Send + Sync + 'static,
    opened: impl FnOnce(&Page) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let signals = OnSignals::listen()?;
    let (sender, orders) = channel();
    let controller = Arc::new(Controller::new(place.folder, place.pace, Some(sender)));
    let page = Page::serve(place, controller, say)?;
    opened(&page)?;
    while signals.reason().is_none() {
        if let Some(order) = next(&orders)? {
            carry_out(&page, &order, beside);
        }
    }
    Ok(())
}

/// The next order, if one comes soon.
fn next(orders: &Receiver<Order>) -> Result<Option<Order>, Failure> {
    match orders.recv_timeout(BETWEEN_TICKS) {
        Ok(order) => Ok(Some(order)),
        Err(RecvTimeoutError::Timeout) => Ok(None),
        Err(RecvTimeoutError::Disconnected) => Err(Failure::instrument("the page ended")),
    }
}

fn carry_out(page: &Page, order: &Order, beside: &dyn Progress) {
    let (operator, control) = (page.controller.operator(), page.controller.accepted());
    let outcome = page.show(&control, beside, |progress| match order {
        Order::Day { job, out } => {
            let options = Options {
                job: job.clone(),
                out: Some(out.clone()),
                ..Options::default()
            };
            let day = day::run(&options, Some(&operator), &control, progress)?;
            let results = format!("results in {}", day.folder.join("results"));
            Ok((day.sentences, results))
        }
        Order::Measurement { run, shown, out } => {
            next::carry_out(run, shown, out, Some(&operator), &control, progress)?;
            Ok((Vec::new(), format!("{run} is diagnosed again, with {out}")))
        }
    });
    match outcome {
        Ok((sentences, last)) => {
            if let Order::Measurement { run, .. } = order {
                page.controller.back_to(run);
            }
            for sentence in &sentences {
                page.controller.say(&Live::now(None, sentence));
            }
            page.controller.say(&Live::now(Some(State::Completed), &last));
        }
        Err(failure) => {
            let state = match failure.kind {
                FailureKind::Interrupted => State::Interrupted,
                _ => State::Failed,
            };
            page.controller.say(&Live::now(Some(state), &failure.message));
            beside.event(Event::Note(&failure.message));
        }
    }
}

/// What follows a scan, told as its state.
struct Steps<'a> {
    tabs: TabProgress<'a>,
}

impl Progress for Steps<'_> {
    fn event(&self, event: Event<'_>) {
        if let Event::Began { step, .. } = &event
            && !["home", "warm up", "scan"].contains(step)
        {
            self.tabs.broadcast.publish(&Live::now(Some(State::Evaluating), step));
        }
        self.tabs.event(event);
    }
}
