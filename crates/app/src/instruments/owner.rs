//! Who owns the instruments of a station, and taking them over.

use isolux_device::Target;
use isolux_record::Station;
use isolux_transport::SystemLinks;
use serde::Serialize;

use crate::{Failure, FailureKind};

/// Instruments that were taken over on demand, for the record.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct TakeOver {
    /// Why, in the words of the person who demanded it.
    pub reason: String,
    /// What was taken from whom; empty where nobody had anything.
    pub from: Vec<String>,
}

/// Becomes the owner of everything that `station` reaches, before anything is opened. With a reason also from a process
/// that gave no sign of life for a while.
///
/// # Errors
/// Exit 3, naming who has an instrument, since when, and what to do.
pub async fn claim(links: &SystemLinks, station: &Station, force: Option<&str>) -> Result<Option<TakeOver>, Failure> {
    let mut from = Vec::new();
    for (role, link) in links_of(station) {
        let taken = links.claim(&link, force.is_some()).await.map_err(|error| Failure {
            kind: FailureKind::Instrument,
            message: format!("{role}: {error}"),
            help: error.advice,
        })?;
        from.extend(taken.map(|held| format!("{role}: {link} from {held}")));
    }
    Ok(force.map(|reason| TakeOver {
        reason: reason.to_owned(),
        from,
    }))
}

/// The links of a station, each with the first part that hangs on it, in an order that all processes share: of two that
/// begin at once, one gets them all.
fn links_of(station: &Station) -> Vec<(&'static str, String)> {
    let open = |access: Option<&isolux_record::station::Access>| access.and_then(|access| access.open.clone());
    let all = [
        ("axis.c", Some(station.axis_c().open.clone())),
        ("axis.gamma", Some(station.axis_gamma().open.clone())),
        ("rail", station.rail().and_then(|rail| rail.open.clone())),
        ("luxmeter", Some(station.luxmeter().open.clone())),
        (
            "spectroradiometer",
            station.spectroradiometer().map(|spectro| spectro.open.clone()),
        ),
        ("powermeter", station.powermeter().map(|meter| meter.open.clone())),
        ("supply", station.supply().map(|supply| supply.open.clone())),
        ("lamp", station.lamp().and_then(|lamp| lamp.open.clone())),
        ("shutter", open(station.shutter())),
        ("baffle", open(station.baffle())),
        ("ambient", open(station.ambient())),
    ];
    let mut links: Vec<(&'static str, String)> = Vec::new();
    for (role, open) in all {
        // What is no address is refused when it is opened, with its reason.
        if let Some(target) = open.and_then(|open| Target::parse(&open).ok())
            && !links.iter().any(|(_, link)| link == target.link())
        {
            links.push((role, target.link().to_owned()));
        }
    }
    links.sort_by(|a, b| a.1.cmp(&b.1));
    links
}
