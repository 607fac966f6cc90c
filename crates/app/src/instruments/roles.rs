//! Every role of a station has an instrument of its own: two that share one would move, switch or read each other.

use std::collections::BTreeSet;

use camino::Utf8Path;
use isolux_device::{Kind, Target};
use isolux_record::Station;
use isolux_record::document::Fault;
use isolux_record::station::Access;
use isolux_transport::{Place, conflict as line_conflict, things};

use crate::instruments::catalogue;

/// Whether a station lives in the virtual darkroom of this process, in virtual time: every instrument that it opens is
/// a twin.
pub fn is_virtual(station: &Station) -> bool {
    let mut opened = opened(station);
    opened.all(|(_, _, open)| in_memory(open))
}

/// Whether a station has twins of this process, beside real instruments perhaps.
pub fn has_twins(station: &Station) -> bool {
    opened(station).any(|(_, _, open)| in_memory(open))
}

pub fn in_memory(open: &str) -> bool {
    Target::parse(open).is_ok_and(|target| target.link().starts_with("memory:"))
}

/// A role with what its address leads to.
struct Role<'a> {
    /// Key of the station, as `axis.c.open`.
    key: &'static str,
    open: &'a str,
    target: Target,
    /// What it uses there, by the word of its driver.
    place: Place,
    /// The device behind the link, by all its names; none for a host that cannot be asked.
    device: BTreeSet<String>,
}

/// Whether every role of `station` has an instrument of its own. Nothing is opened; links to a port are followed, and a
/// host is resolved where it can be.
///
/// # Errors
/// The later of two keys that name the same thing, and what to do.
pub(crate) fn distinct(station: &Station, file: &Utf8Path) -> Result<(), Fault> {
    // A thread of its own: the caller may be on a runtime already, which cannot wait for a second one.
    let resolve = || {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
        runtime.map_or(Ok(()), |runtime| runtime.block_on(compare(station, file)))
    };
    std::thread::scope(|scope| scope.spawn(resolve).join().unwrap_or(Ok(())))
}

async fn compare(station: &Station, file: &Utf8Path) -> Result<(), Fault> {
    let mut earlier: Vec<Role<'_>> = Vec::new();
    for (key, kind, open) in opened(station) {
        // An address that is none is told when it is opened.
        let Ok(target) = catalogue::target(open, file) else {
            continue;
        };
        let Ok(place) = catalogue::placed(&target, kind) else {
            continue;
        };
        let device = things(target.link()).await.unwrap_or_default();
        let role = Role {
            key,
            open,
            target,
            place,
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
    let channels = (first.place.channel.as_str(), second.place.channel.as_str());
    match channels {
        // The link leads to one thing only.
        ("", _) | (_, "") => Some(format!(
            "{same}: the same instrument cannot be both; correct the address of one of the two"
        )),
        (one, other) if one == other => Some(format!(
            "{same}: {one} cannot be both; correct the number or the address of one of the two"
        )),
        _ => line_conflict(&first.target, first.place.line, &second.target, second.place.line)
            .map(|reason| format!("{same}, but {reason}")),
    }
}

fn open(access: Option<&Access>) -> Option<&str> {
    access?.open.as_deref()
}

/// The roles that are opened, in the order of the station file.
pub(crate) fn opened(station: &Station) -> impl Iterator<Item = (&'static str, Kind, &str)> {
    [
        ("axis.c.open", Kind::Axis, Some(station.axis_c().open.as_str())),
        ("axis.gamma.open", Kind::Axis, Some(station.axis_gamma().open.as_str())),
        ("luxmeter.open", Kind::LuxMeter, Some(station.luxmeter().open.as_str())),
        (
            "spectroradiometer.open",
            Kind::Spectroradiometer,
            station.spectroradiometer().map(|spectro| spectro.open.as_str()),
        ),
        (
            "powermeter.open",
            Kind::PowerMeter,
            station.powermeter().map(|meter| meter.open.as_str()),
        ),
        (
            "supply.open",
            Kind::Switch,
            station.supply().map(|supply| supply.open.as_str()),
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
    use isolux_virtual::twins::Choice;

    fn stated(from: &str, to: &str) -> Option<String> {
        let text = virtual_station(&Choice::default()).unwrap().0;
        assert!(text.contains(from), "{from} is not in {text}");
        let station = Station::parse(Utf8Path::new("s.toml"), &text.replacen(from, to, 1)).unwrap();
        distinct(&station, Utf8Path::new(""))
            .err()
            .map(|fault| fault.to_string())
    }

    #[test]
    fn two_roles_on_one_thing_are_refused_by_both_keys() {
        assert_eq!(stated("axis=1", "axis=1"), None);
        let axes = stated("axis=2", "axis=1").unwrap();
        assert!(
            axes.starts_with("axis.gamma.open: ") && axes.contains("axis.c.open"),
            "{axes}"
        );
        assert!(
            stated("axis=2", "axis=01").is_some(),
            "the number counts, not how it is written"
        );
        assert!(
            stated("?axis=1", "").is_none() && stated("?axis=2", "").is_some(),
            "1 is the default"
        );
        assert!(stated("axis=3", "axis=2").unwrap().starts_with("rail.open: "));
        assert!(stated("do=3", "do=1").unwrap().contains("lamp.open"));
        let settings = stated("memory:luxmeter", "memory:axes").unwrap();
        assert!(
            settings.starts_with("luxmeter.open: ") && settings.contains("9600 7E1") && settings.contains("115200 8N1"),
            "{settings}"
        );
        let alone = stated("memory:spectrometer", "memory:luxmeter").unwrap();
        assert!(alone.contains("the same instrument cannot be both"), "{alone}");
    }

    #[test]
    fn two_languages_share_a_port_where_its_settings_are_the_same() {
        let role = |key, open, channel: &str, baud| {
            let line = isolux_transport::LineSettings {
                baud,
                data_bits: 8,
                parity: isolux_transport::Parity::None,
                stop_bits: 1,
            };
            Role {
                key,
                open,
                target: Target::parse(open).unwrap(),
                place: Place {
                    channel: channel.to_owned(),
                    line,
                },
                device: BTreeSet::new(),
            }
        };
        let axis = role("axis.c.open", "drive:/dev/x", "axis 1", 9600);
        let meter = |channel, baud| role("luxmeter.open", "meter:/dev/x", channel, baud);
        assert_eq!(conflict(&axis, &meter("head 0", 9600)), None);
        let refused = conflict(&axis, &meter("head 0", 19_200)).unwrap();
        assert!(
            refused.contains("9600 8N1") && refused.contains("19200 8N1"),
            "{refused}"
        );
        assert!(
            conflict(&axis, &meter("axis 1", 9600)).is_some(),
            "one number, one thing"
        );
        assert!(conflict(&axis, &meter("", 9600)).is_some());
    }

    #[cfg(unix)]
    #[test]
    fn links_to_one_port_are_one_port() {
        let keep = tempfile::tempdir().unwrap();
        let folder = Utf8Path::from_path(keep.path()).unwrap();
        let port = folder.join("port");
        std::fs::write(&port, "").unwrap();
        std::os::unix::fs::symlink(&port, folder.join("other")).unwrap();
        let text = virtual_station(&Choice::default()).unwrap().0;
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
            let fault = distinct(&station, Utf8Path::new("")).unwrap_err();
            assert_eq!(fault.path, "axis.gamma.open", "{fault}");
        }
    }
}
