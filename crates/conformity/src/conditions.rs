//! The conditions of a measurement against their limits: met where the whole range that was measured keeps them by its
//! expanded uncertainty (CIE S 025, annex A: a tolerance interval is of the true value).

use isolux_photometry::IntensityDistribution;
use isolux_record::conditions::{Condition, ConditionKey};
use isolux_record::{Bounds, Conditions, DistanceClass, Event, Logged, Run};
use isolux_reduce::Reduction;
use isolux_units::digits::K;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Whether a condition is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Standing {
    /// With its uncertainty within the limits.
    Met,
    /// Not within the limits by its uncertainty.
    NotMet,
    /// A limit, a value or its uncertainty is missing.
    NotKnown,
}

impl Standing {
    /// As a table has it.
    pub const fn words(self) -> &'static str {
        match self {
            Self::Met => "met",
            Self::NotMet => "not met",
            Self::NotKnown => "not known",
        }
    }
}

/// A condition as it was, and whether it was kept.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct JudgedCondition {
    /// Its key in `[conditions]`, with its unit.
    pub key: String,
    /// What it is.
    pub what: String,
    /// Its unit.
    pub unit: String,
    /// Smallest and largest value during the measurement; null where it was not measured.
    pub measured: Option<[f64; 2]>,
    /// Expanded uncertainty (k = 2); null where it is not known.
    pub expanded: Option<f64>,
    /// Smallest value that is allowed.
    pub smallest: Option<f64>,
    /// Largest value that is allowed.
    pub largest: Option<f64>,
    /// Where the limit comes from.
    pub clause: Option<String>,
    /// Whether it was kept.
    pub standing: Standing,
    /// Why, where it was not, or is not known.
    pub reason: Option<String>,
}

/// What is known of a condition.
#[derive(Default)]
struct Found {
    measured: Option<[f64; 2]>,
    u: Option<f64>,
    limits: Option<(Bounds, String)>,
    /// Why there is no value.
    not_measured: String,
    /// Why there is no uncertainty.
    no_u: String,
}

/// Every condition of a run.
pub fn judge(stated: &Conditions, run: &Run, events: &[Logged], reduction: &Reduction) -> Vec<JudgedCondition> {
    let burnings = Burning::all(events);
    let judged = stated.all().into_iter().map(|(key, stated)| {
        let nothing = Condition::default();
        let stated = stated.unwrap_or(&nothing);
        let found = match key.name {
            "ambient_c" => ambient(stated, run),
            "supply_voltage_v" => voltage(stated, run, reduction),
            "operating_time_min" => operating_time(&burnings),
            "stabilisation_rel" => spread(&burnings, |burning| Some(burning.light_rel)),
            "power_stabilisation_rel" => spread(&burnings, |burning| burning.power_rel),
            "distance_ratio" => distance(run, reduction),
            name => by_hand(stated, name),
        };
        judged(key, stated, found)
    });
    judged.collect()
}

fn judged(key: ConditionKey, stated: &Condition, found: Found) -> JudgedCondition {
    // A job was checked when it was read.
    let limits = stated.limits(key.name).ok().flatten();
    let (limits, clause) = match (limits, found.limits) {
        (Some(limits), _) => (Some(limits), stated.clause.clone()),
        (None, Some((limits, clause))) => (Some(limits), Some(clause)),
        (None, None) => (None, None),
    };
    let expanded = found.u.map(|u| K * u);
    let (standing, reason) = match (limits, found.measured, expanded) {
        (None, ..) => (
            Standing::NotKnown,
            Some(format!("no limit is stated in [conditions.{}]", key.name)),
        ),
        (_, None, _) => (Standing::NotKnown, Some(found.not_measured)),
        (_, _, None) => (Standing::NotKnown, Some(found.no_u)),
        (Some(limits), Some([least, most]), Some(expanded)) => {
            let allowed = limits.narrowed(expanded);
            if allowed.hold(least) && allowed.hold(most) {
                (Standing::Met, None)
            } else if limits.hold(least) && limits.hold(most) {
                let reason = "within the limits, but not by its uncertainty";
                (Standing::NotMet, Some(reason.to_owned()))
            } else {
                (Standing::NotMet, Some("outside of the limits".to_owned()))
            }
        }
    };
    JudgedCondition {
        key: key.name.to_owned(),
        what: key.what.to_owned(),
        unit: key.unit.to_owned(),
        measured: found.measured,
        expanded,
        smallest: limits.and_then(|limits| limits.smallest),
        largest: limits.and_then(|limits| limits.largest),
        clause,
        standing,
        reason,
    }
}

fn ambient(stated: &Condition, run: &Run) -> Found {
    let read = range(run.readings.rows.iter().filter_map(|row| row.ambient_c));
    Found {
        measured: read.or(stated.measured),
        u: stated.u,
        not_measured: "no reading has an ambient temperature: the station has no thermometer, or none that answered"
            .to_owned(),
        no_u: "state conditions.ambient_c.u, the standard uncertainty of the thermometer".to_owned(),
        ..Found::default()
    }
}

fn voltage(stated: &Condition, run: &Run, reduction: &Reduction) -> Found {
    let read = reduction.electrical.as_ref().and_then(|line| line.voltage_v);
    let meter = run.header.station.powermeter();
    let u_read = read.and_then(|over| Some(over.mean * meter?.u_voltage_rel?));
    Found {
        measured: read.map(|over| [over.least, over.most]).or(stated.measured),
        u: stated.u.or(u_read),
        not_measured: "the bench has no power meter that reads a voltage".to_owned(),
        no_u: "the station states no powermeter.u_voltage_rel, the job no conditions.supply_voltage_v.u".to_owned(),
        ..Found::default()
    }
}

/// What no instrument of the bench measures.
fn by_hand(stated: &Condition, name: &str) -> Found {
    Found {
        measured: stated.measured,
        u: stated.u,
        not_measured: format!("no instrument of the bench measures it; state conditions.{name}.measured"),
        no_u: format!("state conditions.{name}.u, its standard uncertainty"),
        ..Found::default()
    }
}

fn operating_time(burnings: &[Burning]) -> Found {
    Found {
        measured: range(burnings.iter().map(|burning| burning.stable_after_min)),
        u: Some(0.0),
        not_measured: NOT_RECORDED.to_owned(),
        ..Found::default()
    }
}

/// The clause asks for the spread of the readings themselves, so it has no uncertainty to be kept by.
fn spread(burnings: &[Burning], of: impl Fn(&Burning) -> Option<f64>) -> Found {
    // Where one burning has none, the run has none.
    let every: Option<Vec<f64>> = burnings.iter().map(of).collect();
    Found {
        measured: every.and_then(|every| range(every.into_iter())),
        u: Some(0.0),
        not_measured: if burnings.is_empty() {
            NOT_RECORDED.to_owned()
        } else {
            "no power was read while the lamp warmed up".to_owned()
        },
        ..Found::default()
    }
}

const NOT_RECORDED: &str = "the run has no record of a lamp that became stable";

fn distance(run: &Run, reduction: &Reduction) -> Found {
    let station = &run.header.station;
    let extent_mm = station.lamp().and_then(|lamp| lamp.diameter_mm);
    let ratio = DistanceClass::of(reduction.distance_mm, extent_mm).ratio();
    let narrowest = narrowest_beam_deg(&reduction.grid.distribution);
    let beam = narrowest.map_or_else(|| "no beam".to_owned(), |beam| format!("narrowest beam {beam:.0}°"));
    Found {
        measured: ratio.map(|ratio| [ratio, ratio]),
        u: ratio
            .zip(station.bench().u_distance_mm)
            .map(|(ratio, u_mm)| ratio * u_mm / reduction.distance_mm),
        limits: Some((
            Bounds {
                smallest: Some(DistanceClass::wanted(narrowest)),
                largest: None,
            },
            format!("CIE S 025, 4.5.2, {beam}"),
        )),
        not_measured: "the station states no lamp.diameter_mm".to_owned(),
        no_u: "the station states no bench.u_distance_mm".to_owned(),
    }
}

fn narrowest_beam_deg(shown: &IntensityDistribution) -> Option<f64> {
    (0..shown.c_deg().len())
        .filter_map(|plane| shown.beam_angle(plane))
        .map(|beam| beam.full_angle_deg())
        .min_by(f64::total_cmp)
}

fn range(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    values.fold(None, |range, value| {
        let [least, most] = range.unwrap_or([value, value]);
        Some([least.min(value), most.max(value)])
    })
}

/// A lamp from its switching on to where it was called stable.
struct Burning {
    stable_after_min: f64,
    light_rel: f64,
    power_rel: Option<f64>,
}

impl Burning {
    fn all(events: &[Logged]) -> Vec<Self> {
        let mut power_rel = None;
        let mut burnings = Vec::new();
        for logged in events {
            match &logged.event {
                Event::Lamp { on: true } => power_rel = None,
                Event::WarmUp(look) => power_rel = look.power.and_then(|power| power.power_spread_rel),
                Event::Stable { lamp_s, spread_rel, .. } => burnings.push(Self {
                    stable_after_min: lamp_s / 60.0,
                    light_rel: *spread_rel,
                    power_rel,
                }),
                _ => {}
            }
        }
        burnings
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use isolux_record::conditions::KEYS;
    use isolux_record::event::{PowerSample, WarmUp};

    fn of(stated: &str, measured: Option<[f64; 2]>, u: Option<f64>) -> JudgedCondition {
        let found = Found {
            measured,
            u,
            not_measured: "not measured".to_owned(),
            no_u: "no u".to_owned(),
            ..Found::default()
        };
        judged(KEYS[0], &toml::from_str(stated).unwrap(), found)
    }

    #[test]
    fn a_range_is_met_where_it_keeps_the_limits_by_its_uncertainty() {
        let limits = "nominal = 25.0\ntolerance = 1.2\n";
        for (measured, u, standing) in [
            ([24.5, 25.5], 0.1, Standing::Met),
            // 25.9 + 0.2 is within 26.2, 26.1 + 0.2 is not.
            ([24.5, 25.9], 0.1, Standing::Met),
            ([24.5, 26.1], 0.1, Standing::NotMet),
            ([23.9, 25.0], 0.1, Standing::NotMet),
            ([24.5, 27.0], 0.1, Standing::NotMet),
            ([24.5, 26.1], 0.0, Standing::Met),
        ] {
            let found = of(limits, Some(measured), Some(u));
            assert_eq!(found.standing, standing, "{measured:?} u {u}");
            assert_eq!(found.expanded, Some(2.0 * u));
        }
        let reason = |measured| of(limits, Some(measured), Some(0.1)).reason.unwrap();
        assert!(reason([24.5, 26.1]).contains("uncertainty") && reason([24.5, 27.0]).contains("outside"));
        for (stated, measured, u, words) in [
            ("", Some([25.0, 25.0]), Some(0.1), "no limit"),
            (limits, None, Some(0.1), "not measured"),
            (limits, Some([25.0, 25.0]), None, "no u"),
        ] {
            let found = of(stated, measured, u);
            assert_eq!(found.standing, Standing::NotKnown);
            assert!(found.reason.unwrap().contains(words), "{words}");
        }
    }

    #[test]
    fn every_burning_is_judged_and_the_worst_counts() {
        let logged = |event| Logged {
            time_utc: String::new(),
            event,
        };
        let look = |spread: f64| {
            logged(Event::WarmUp(WarmUp {
                lamp_s: 60.0,
                illuminance_lx: 1.0,
                spread_rel: None,
                power: Some(PowerSample {
                    power_w: Some(4.0),
                    power_spread_rel: Some(spread),
                }),
            }))
        };
        let stable = |lamp_s: f64, spread_rel: f64| {
            logged(Event::Stable {
                lamp_s,
                spread_rel,
                noise_rel: 0.0,
            })
        };
        let on = || logged(Event::Lamp { on: true });
        let two = [
            on(),
            look(0.001),
            stable(1900.0, 0.004),
            on(),
            look(0.002),
            stable(1860.0, 0.003),
        ];
        let burnings = Burning::all(&two);
        assert_eq!(
            spread(&burnings, |one| Some(one.light_rel)).measured,
            Some([0.003, 0.004])
        );
        assert_eq!(spread(&burnings, |one| one.power_rel).measured, Some([0.001, 0.002]));
        assert_eq!(operating_time(&burnings).measured, Some([31.0, 1900.0 / 60.0]));
        // The power of one burning alone says nothing of the run.
        let one = [on(), look(0.001), stable(1900.0, 0.004), on(), stable(1860.0, 0.003)];
        assert_eq!(spread(&Burning::all(&one), |one| one.power_rel).measured, None);
        assert_eq!(spread(&[], |one| Some(one.light_rel)).measured, None);
    }
}
