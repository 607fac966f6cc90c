//! `devices --identify PORT…`: asks the ports that a person names which of our languages answers there.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Duration;

use isolux_transport::{LineSettings, Link, Links, Probe, SystemLinks, things};
use serde::Serialize;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::task::JoinSet;
use tokio::time::{Instant, timeout_at};

use crate::Failure;
use crate::front_end::progress::{Event, Progress};
use crate::instruments::{catalogue, session};

/// What was found at one port.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct PortReport {
    /// The port, as it was named.
    pub port: String,
    /// Who answered.
    pub found: Vec<FoundInstrument>,
    /// Line settings and the drivers whose question was asked with them, in this order.
    pub tried: Vec<String>,
    /// Why it could not be asked, and what to do.
    pub error: Option<String>,
}

/// An instrument that answered.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct FoundInstrument {
    /// The driver whose question it answers.
    pub driver: &'static str,
    /// What it said of itself.
    pub says: String,
    /// The settings of the line.
    pub line: String,
}

/// For an answer: the slowest of these instruments takes half of it.
const PATIENCE: Duration = Duration::from_millis(700);

/// The line is silent for so long before the next question.
const SILENCE: Duration = Duration::from_millis(150);

/// Asks the ports side by side, each with the settings of every language; nothing is sent to any other port. A port
/// that another program has is not asked. The reports are in the order of the ports.
///
/// # Errors
/// Exit 3 when the system gives no runtime or a question panics. What a port refuses stands in its entry.
pub fn identify(ports: &[String], progress: &dyn Progress) -> Result<Vec<PortReport>, Failure> {
    progress.event(Event::Began {
        step: "identify",
        total: None,
    });
    session::run(false, async {
        let links: Arc<dyn Links> = Arc::new(SystemLinks::default());
        let mut asked = JoinSet::new();
        for device in by_device(ports).await {
            let links = Arc::clone(&links);
            asked.spawn(async move {
                let mut reports = Vec::new();
                for (number, port) in device {
                    reports.push((number, ask(links.as_ref(), &port).await));
                }
                reports
            });
        }
        let mut reports: Vec<(usize, PortReport)> = Vec::new();
        while let Some(of_device) = asked.join_next().await {
            reports.extend(of_device.map_err(Failure::instrument)?);
            progress.event(Event::At {
                done: reports.len() as u64,
                what: &format!("{} of {} ports", reports.len(), ports.len()),
            });
        }
        reports.sort_by_key(|(number, _)| *number);
        let answered = reports.iter().filter(|(_, report)| !report.found.is_empty()).count();
        progress.event(Event::Ended(&format!(
            "an instrument at {answered} of {} ports",
            ports.len()
        )));
        Ok(reports.into_iter().map(|(_, report)| report).collect())
    })
}

/// The ports with their numbers, those that lead to one device together: it is asked by one name after the other.
async fn by_device(ports: &[String]) -> Vec<Vec<(usize, String)>> {
    let (mut devices, mut names_of) = (Vec::new(), Vec::<BTreeSet<String>>::new());
    for (number, port) in ports.iter().enumerate() {
        // What has no such names is refused when it is opened.
        let names = things(port).await.unwrap_or_else(|_| [port.clone()].into());
        let known = names_of.iter().position(|known| !known.is_disjoint(&names));
        let device = known.unwrap_or(devices.len());
        if known.is_none() {
            devices.push(Vec::new());
            names_of.push(names);
        }
        devices[device].push((number, port.clone()));
    }
    devices
}

/// The settings that drivers ask with, each once, and their questions. A bridge on the network has settings of its own:
/// there all questions stand together, and none of a driver twice.
fn questions(behind_bridge: bool) -> Vec<(LineSettings, Vec<(&'static str, &'static Probe)>)> {
    let mut questions: Vec<(LineSettings, Vec<(&'static str, &'static Probe)>)> = Vec::new();
    for driver in catalogue::drivers() {
        for probe in driver.identify {
            let is_asked = |(name, known): &(&str, &Probe)| *name == driver.name && known.request == probe.request;
            match questions
                .iter_mut()
                .find(|(line, _)| behind_bridge || *line == probe.line)
            {
                Some((_, probes)) if probes.iter().any(is_asked) => {}
                Some((_, probes)) => probes.push((driver.name, probe)),
                None => questions.push((probe.line, vec![(driver.name, probe)])),
            }
        }
    }
    questions
}

async fn ask(links: &dyn Links, port: &str) -> PortReport {
    let mut requested = PortReport {
        port: port.to_owned(),
        found: Vec::new(),
        tried: Vec::new(),
        error: None,
    };
    for scheme in ["modbus-tcp://", "usb:", "memory:"] {
        if port.starts_with(scheme) {
            requested.error = Some(format!(
                "{scheme} cannot be asked, only serial ports and tcp://host:port; `isolux devices` shows USB instruments by their ids"
            ));
            return requested;
        }
    }
    let network = port.starts_with("tcp://");
    for (line, probes) in questions(network) {
        let settings = if network {
            "the bridge's line settings".to_owned()
        } else {
            line.to_string()
        };
        let names: Vec<&str> = probes.iter().map(|(name, _)| *name).collect();
        let mut link = match links.open(port, line).await {
            Ok(link) => link,
            Err(error) => {
                let advice = error
                    .advice
                    .as_deref()
                    .map_or(String::new(), |advice| format!(" ({advice})"));
                requested.error = Some(format!("{error}{advice}"));
                return requested;
            }
        };
        requested.tried.push(format!("{settings}: {}", names.join(", ")));
        for (driver, probe) in probes {
            let mut answer = exchange(link.as_mut(), probe).await;
            if matches!(answer, Ok(None)) {
                // The first question may have ended what another one had left in the instrument.
                answer = exchange(link.as_mut(), probe).await;
            }
            match answer {
                Ok(Some(says)) => requested.found.push(FoundInstrument {
                    driver,
                    says,
                    line: settings.clone(),
                }),
                Ok(None) => {}
                Err(error) => {
                    requested.error = Some(format!("{port}: the link ended: {error}"));
                    return requested;
                }
            }
        }
        // What answers with one setting of the line does not answer with another.
        if !requested.found.is_empty() {
            break;
        }
    }
    requested
}

/// One question. Whatever comes before it or in doubt after it is thrown away.
async fn exchange(link: &mut dyn Link, probe: &Probe) -> std::io::Result<Option<String>> {
    let mut buffer = [0; 512];
    let drained = Instant::now() + SILENCE;
    while let Ok(count) = timeout_at(drained, link.read(&mut buffer)).await {
        if count? == 0 {
            return Err(std::io::ErrorKind::UnexpectedEof.into());
        }
    }
    link.write_all(probe.request).await?;
    link.flush().await?;
    let (mut deadline, mut received) = (Instant::now() + PATIENCE, Vec::new());
    let mut says = None;
    while let Ok(count) = timeout_at(deadline, link.read(&mut buffer)).await {
        match count? {
            0 => return Err(std::io::ErrorKind::UnexpectedEof.into()),
            count => received.extend(&buffer[..count]),
        }
        // What is an answer already may have an end that is still on its way.
        if let Some(answer) = (probe.read)(&received) {
            says = Some(answer);
            deadline = deadline.min(Instant::now() + SILENCE);
        }
    }
    Ok(says)
}
