//! What a report of photometric results has to state: the items of ISO/IEC 17025, 7.8.2.1 and 7.8.3.1, and those that
//! EN 13032-4 and LM-79 ask of a test report, each with what the report states or what is to be done.

use isolux_record::{Event, Logged, Run};
use isolux_reduce::Reduction;
use isolux_units::digits::significant;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::conditions::JudgedCondition;
use crate::decision::Decision;

/// One item.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Item {
    /// What is to be stated.
    pub what: String,
    /// Who asks for it.
    pub asked_by: String,
    /// What the report states; null where it is missing.
    pub stated: Option<String>,
    /// What to do, where it is missing.
    pub remedy: Option<String>,
}

const PHOTOMETRIC: &str = "EN 13032-4, LM-79: test report";

/// Every item of a day.
pub fn checklist(
    run: &Run,
    events: &[Logged],
    reduction: &Reduction,
    conditions: &[JudgedCondition],
    requirements: &[Decision],
) -> Vec<Item> {
    let header = &run.header;
    let (luminaire, report) = (&header.luminaire, &header.report);
    let mut items = Vec::new();
    let mut add = |what: &str, asked_by: &str, stated: Option<String>, remedy: &str| {
        items.push(Item {
            what: what.to_owned(),
            asked_by: asked_by.to_owned(),
            remedy: stated.is_none().then(|| remedy.to_owned()),
            stated,
        });
    };
    let iso = |letter: &str| format!("ISO/IEC 17025, 7.8.2.1 {letter}");
    let key = |table: &str, key: &str| format!("state {key} in [{table}] of the job");
    let texts: [(&str, &str, &Option<String>, &str, &str); 10] = [
        (
            "laboratory and place",
            "b), c)",
            &report.laboratory,
            "report",
            "laboratory",
        ),
        ("number of the report", "d)", &report.number, "report", "number"),
        ("customer", "e)", &report.customer, "report", "customer"),
        (
            "method, edition, deviations",
            "f), n)",
            &report.method,
            "report",
            "method",
        ),
        ("item: maker", "g)", &luminaire.maker, "luminaire", "maker"),
        ("item: name", "g)", &luminaire.name, "luminaire", "name"),
        ("item: sample", "g)", &luminaire.sample, "luminaire", "sample"),
        ("day of receipt", "h)", &report.received, "report", "received"),
        ("day of issue", "j)", &report.issued, "report", "issued"),
        (
            "who answers for the report",
            "o)",
            &report.approved_by,
            "report",
            "approved_by",
        ),
    ];
    for (what, letter, stated, table, name) in texts {
        add(what, &iso(letter), stated.clone(), &key(table, name));
    }
    let first = header.started_utc.get(..10).unwrap_or(&header.started_utc);
    let ended = header.stopped.as_ref().and_then(|stopped| stopped.utc.get(..10));
    add(
        "days of the measurement",
        &iso("i)"),
        Some(format!("{first} to {}", ended.unwrap_or("not ended"))),
        "",
    );
    add(
        "results of this item alone",
        &iso("l)"),
        Some("stated under “Item and report”".to_owned()),
        "",
    );
    let with_u = reduction.flux.u.is_some();
    add(
        "uncertainty of the luminous flux",
        "ISO/IEC 17025, 7.8.3.1 c); EN 13032-4",
        with_u.then(|| reduction.flux.stated()),
        &format!("not known: {}", reduction.flux.missing.join("; ")),
    );
    if !requirements.is_empty() {
        let mut rules: Vec<&str> = requirements.iter().map(|one| one.rule.name()).collect();
        rules.sort_unstable();
        rules.dedup();
        add("decision rule", "ISO/IEC 17025, 7.8.6.2", Some(rules.join(", ")), "");
    }

    for (what, stated, name) in [
        ("rated electrical values", &luminaire.rated, "rated"),
        ("hours of operation before", &luminaire.hours_run, "hours_run"),
        ("burning position", &luminaire.burning_position, "burning_position"),
        ("control gear and dimming", &luminaire.driver, "driver"),
    ] {
        add(what, PHOTOMETRIC, stated.clone(), &key("luminaire", name));
    }
    let remedy = "the run has no record of the lamp; name it in the station as [lamp]";
    add(
        "time in operation, with stabilisation",
        PHOTOMETRIC,
        time_on(run, events),
        remedy,
    );
    for condition in conditions {
        let stated = condition.measured.map(|[least, most]| {
            let number = |value: f64| significant(value, 4);
            let range = if least == most {
                number(least)
            } else {
                format!("{} to {}", number(least), number(most))
            };
            format!("{range} {}", condition.unit).trim_end().to_owned()
        });
        let remedy = condition.reason.clone().unwrap_or_default();
        add(&condition.what, PHOTOMETRIC, stated, &remedy);
    }
    let distance = format!("turning luminaire, detector at {} m", reduction.distance_mm * 1e-3);
    add("type of goniophotometer and distance", PHOTOMETRIC, Some(distance), "");
    let line = reduction.electrical.as_ref();
    add(
        "voltage, current and active power",
        PHOTOMETRIC,
        line.filter(|line| line.voltage_v.is_some() && line.current_a.is_some())
            .map(|line| line.power.stated()),
        "measure them: [powermeter] of the station",
    );
    if reduction.spectral.is_some() {
        let scale = header
            .spectral
            .as_ref()
            .and_then(|spectral| spectral.corrections.wavelengths.as_ref());
        add(
            "bandwidth of the spectroradiometer",
            PHOTOMETRIC,
            scale.map(|scale| format!("{} nm", significant(scale.fwhm_nm, 3))),
            "measure it: isolux calibrate spectroradiometer --lines",
        );
    }
    for (role, what) in [
        ("luxmeter", "traceability of the lux meter"),
        ("spectroradiometer", "traceability of the spectroradiometer"),
        ("powermeter", "traceability of the power meter"),
    ] {
        if let Some(known) = header.station.traceability(role) {
            let certificate = known.certificate.map(|number| format!("certificate {number}"));
            add(
                what,
                PHOTOMETRIC,
                certificate,
                &format!("state {role}.certificate in the station"),
            );
        }
    }
    let off: Vec<&str> = reduction.without.iter().map(|correction| correction.as_str()).collect();
    let corrections = if off.is_empty() {
        "all that the station has".to_owned()
    } else {
        format!("without {}", off.join(", "))
    };
    add("corrections", PHOTOMETRIC, Some(corrections), "");
    items
}

/// How long the lamp was on, over all of its burnings.
fn time_on(run: &Run, events: &[Logged]) -> Option<String> {
    let (mut on_since, mut seconds, mut last) = (None, 0.0, None);
    for logged in events {
        let Some(at) = run.header.seconds(&logged.time_utc) else {
            continue;
        };
        last = Some(at);
        match logged.event {
            Event::Lamp { on: true } => on_since = on_since.or(Some(at)),
            Event::Lamp { on: false } => seconds += on_since.take().map_or(0.0, |since| at - since),
            _ => {}
        }
    }
    seconds += on_since.zip(last).map_or(0.0, |(since, last)| last - since);
    (seconds > 0.0).then(|| format!("{} h", significant(seconds / 3600.0, 3)))
}
