//! Every role of a station has an instrument of its own: two that share one would move, switch or read each other.

use std::collections::BTreeSet;
use std::path::PathBuf;

use isolux_device::Target;
use isolux_record::Station;
use isolux_record::document::Fault;
use isolux_record::station::Access;
use isolux_transport::lock_files;

/// A role with what its address leads to.
struct Role<'a> {
    /// Key of the station, as `axis.c.open`.
    key: &'static str,
    open: &'a str,
    target: Target,
    /// Which of the things behind the link: an axis, an output, an input.
    channel: String,
    /// The device behind the link, by all its names; none for a pipe in memory and for a host that cannot be asked.
    device: BTreeSet<PathBuf>,
}

/// Whether every role of `station` has an instrument of its own. Nothing is opened; links to a port are followed, and a
/// host is resolved where it can be.
///
/// # Errors
/// The later of two keys that name the same thing, and what to do.
pub(crate) fn distinct(station: &Station) -> Result<(), Fault> {
    // A thread of its own: the caller may be on a runtime already, which cannot wait for a second one.
    let resolve = || {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
        runtime.map_or(Ok(()), |runtime| runtime.block_on(compare(station)))
    };
    std::thread::scope(|scope| scope.spawn(resolve).join().unwrap_or(Ok(())))
}

async fn compare(station: &Station) -> Result<(), Fault> {
    let mut earlier: Vec<Role<'_>> = Vec::new();
    for (key, kind, open) in opened(station) {
        // An address that is none is told by the driver.
        let Ok(target) = Target::parse(open) else { continue };
        let channel = channel(kind, &target).unwrap_or_default();
        let device = lock_files(target.link())
            .await
            .unwrap_or_default()
            .into_iter()
            .collect();
        let role = Role {
            key,
            open,
            target,
            channel,
            device,
        };
        for other in &earlier {
            if let Some(message) = conflict(other, &role) {
                return Err(Fault {
                    path: key.to_owned(),
                    message,
                });
            }
        }
        earlier.push(role);
    }
    Ok(())
}

/// What is wrong with two roles, if something is.
fn conflict(first: &Role<'_>, second: &Role<'_>) -> Option<String> {
    let one_link = first.target.link() == second.target.link() || !first.device.is_disjoint(&second.device);
    if !one_link {
        return None;
    }
    let same = format!(
        "`{}` leads to what `{}` of {} leads to",
        second.open, first.open, first.key
    );
    if first.target.driver() != second.target.driver() {
        return Some(format!(
            "{same}, but one line cannot carry two languages; correct the address of one of the two"
        ));
    }
    (first.channel == second.channel).then(|| {
        let what = if first.channel.is_empty() {
            "the same instrument"
        } else {
            &first.channel
        };
        format!("{same}: {what} cannot be both; correct the number or the address of one of the two")
    })
}

/// The number of what a role uses behind its link, with the driver's default where none is written. `None`: not a number.
fn channel(kind: Kind, target: &Target) -> Option<String> {
    let number = |key: &str, default: u32| target.option(key).map_or(Some(default), |text| text.parse().ok());
    let device = number("device", 1)?;
    Some(match kind {
        Kind::Axis => format!("axis {} of device {device}", number("axis", 1)?),
        Kind::Switch => format!("output {} of device {device}", number("do", 0)?),
        Kind::Thermometer => format!("input {} of device {device}", number("ai", 0)?),
        // A line has one of these.
        Kind::Instrument => String::new(),
    })
}

#[derive(Debug, Clone, Copy)]
enum Kind {
    Axis,
    Switch,
    Thermometer,
    Instrument,
}

fn open(access: Option<&Access>) -> Option<&str> {
    access?.open.as_deref()
}

/// The roles that are opened, in the order of the station file.
fn opened(station: &Station) -> impl Iterator<Item = (&'static str, Kind, &str)> {
    [
        ("axis.c.open", Kind::Axis, Some(station.axis_c().open.as_str())),
        ("axis.gamma.open", Kind::Axis, Some(station.axis_gamma().open.as_str())),
        (
            "luxmeter.open",
            Kind::Instrument,
            Some(station.luxmeter().open.as_str()),
        ),
        (
            "spectroradiometer.open",
            Kind::Instrument,
            station.spectroradiometer().map(|spectro| spectro.open.as_str()),
        ),
        (
            "lamp.open",
            Kind::Switch,
            station.lamp().and_then(|lamp| lamp.open.as_deref()),
        ),
        ("shutter.open", Kind::Switch, open(station.shutter())),
        ("baffle.open", Kind::Switch, open(station.baffle())),
        (
            "rail.open",
            Kind::Axis,
            station.rail().and_then(|rail| rail.open.as_deref()),
        ),
        ("ambient.open", Kind::Thermometer, open(station.ambient())),
    ]
    .into_iter()
    .filter_map(|(key, kind, open)| Some((key, kind, open?)))
}

#[cfg(test)]
mod tests {
    use camino::Utf8Path;

    use super::*;
    use crate::init::virtual_station;

    fn said(from: &str, to: &str) -> Option<String> {
        let text = virtual_station().unwrap().0;
        assert!(text.contains(from), "{from} is not in {text}");
        let station = Station::parse(Utf8Path::new("s.toml"), &text.replacen(from, to, 1)).unwrap();
        distinct(&station).err().map(|fault| fault.to_string())
    }

    #[test]
    fn two_roles_on_one_thing_are_refused_by_both_keys() {
        assert_eq!(said("axis=1", "axis=1"), None);
        let axes = said("axis=2", "axis=1").unwrap();
        assert!(
            axes.starts_with("axis.gamma.open: ") && axes.contains("axis.c.open"),
            "{axes}"
        );
        assert!(
            said("axis=2", "axis=01").is_some(),
            "the number counts, not how it is written"
        );
        assert!(
            said("?axis=1", "").is_none() && said("?axis=2", "").is_some(),
            "1 is the default"
        );
        assert!(said("axis=3", "axis=2").unwrap().starts_with("rail.open: "));
        assert!(said("do=3", "do=1").unwrap().contains("lamp.open"));
        let languages = said("memory:luxmeter", "memory:axes").unwrap();
        assert!(languages.contains("two languages"), "{languages}");
    }

    #[cfg(unix)]
    #[test]
    fn links_to_one_port_are_one_port() {
        let keep = tempfile::tempdir().unwrap();
        let folder = Utf8Path::from_path(keep.path()).unwrap();
        let port = folder.join("port");
        std::fs::write(&port, "").unwrap();
        std::os::unix::fs::symlink(&port, folder.join("other")).unwrap();
        let text = virtual_station().unwrap().0;
        for (c, gamma) in [
            (format!("zaber:{port}?axis=1"), format!("zaber:{folder}/other?axis=1")),
            (
                "zaber:tcp://localhost:4001?axis=1".to_owned(),
                "zaber:tcp://127.0.0.1:4001?axis=1".to_owned(),
            ),
        ] {
            let mut station: toml::Table = text.parse().unwrap();
            for (axis, open) in [("c", c), ("gamma", gamma)] {
                station["axis"][axis]["open"] = open.into();
            }
            let station = Station::parse(Utf8Path::new("s.toml"), &station.to_string()).unwrap();
            let fault = distinct(&station).unwrap_err();
            assert_eq!(fault.path, "axis.gamma.open", "{fault}");
        }
    }
}
