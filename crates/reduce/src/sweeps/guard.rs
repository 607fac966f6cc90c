//! Which conversions of a sweep can be relied on.
//!
//! A meter without a checksum may send a number with a wrong digit, and an answer that came twice answers the next
//! request too. At rest two answers must agree; in motion each conversion is compared with a polynomial through its
//! neighbours without it. One that alone explains why it and its neighbours do not fit together is left out; an edge of
//! the light is not, for no single conversion explains it.

use isolux_record::own_clock::ByOwnClock;
use isolux_record::sweeps::SweepRecord;

/// Neighbours to each side that the polynomial goes through.
const NEIGHBOURS: usize = 3;
/// Neighbours to each side whose misfits say how well a polynomial follows the light there.
const AROUND: usize = 5;
/// Standard deviations from its neighbours beyond which a conversion is damaged.
const BEYOND: f64 = 5.0;
/// By how much the misfit of a polynomial may exceed the median of those around.
const UNEVEN: f64 = 1.5;
/// Standard deviations within which its neighbours fit together without it, or this share of its own misfit.
const FITS: f64 = 4.0;
const SHARE: f64 = 1.0 / 6.0;

/// How many conversions of sweeps are left out, and why.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LeftOut {
    /// No number: no answer, a late one, or bytes that nobody asked for.
    pub without_number: usize,
    /// Answered before the light could be integrated, with those up to the next proof of the line: answers to earlier
    /// requests.
    pub early: usize,
    /// Not what the neighbours say: a wrong digit.
    pub astray: usize,
    /// Periods of the meter's own clock in which its answers differ.
    pub unclear: usize,
}

impl LeftOut {
    /// All of them.
    pub fn count(&self) -> usize {
        self.without_number + self.early + self.astray + self.unclear
    }
}

impl std::ops::AddAssign for LeftOut {
    fn add_assign(&mut self, other: Self) {
        self.without_number += other.without_number;
        self.early += other.early;
        self.astray += other.astray;
        self.unclear += other.unclear;
    }
}

/// One conversion with a number: its place in the sweep, when its light began and ended (as from its request on, or by
/// the meter's own clock), what it said and the standard deviation of its noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conversion {
    pub place: usize,
    pub from_s: f64,
    pub to_s: f64,
    pub value: f64,
    pub sigma: f64,
}

/// The conversions of `record` between two instants that can be relied on, and what is left out of them: before and
/// after, the axis does not cruise. `own` are those of a meter with a clock of its own; `sigma` gives the standard
/// deviation of the noise of a value, by its place.
pub fn relied_on(
    record: &SweepRecord,
    own: Option<&ByOwnClock>,
    cruise_s: [f64; 2],
    sigma: impl Fn(usize, f64) -> f64,
) -> (Vec<Conversion>, LeftOut) {
    let (mut conversions, mut left_out) = match own {
        Some(own) => by_own_clock(record, own, cruise_s, sigma),
        None => on_request(record, cruise_s, sigma),
    };
    let before = conversions.len();
    while let Some(astray) = astray(&conversions) {
        let mut place = 0;
        conversions.retain(|_| {
            place += 1;
            !astray.contains(&(place - 1))
        });
    }
    left_out.astray = before - conversions.len();
    (conversions, left_out)
}

/// Those of a meter with a clock of its own.
fn by_own_clock(
    record: &SweepRecord,
    own: &ByOwnClock,
    [from_s, to_s]: [f64; 2],
    sigma: impl Fn(usize, f64) -> f64,
) -> (Vec<Conversion>, LeftOut) {
    let cruises = |at_s: f64| (from_s..=to_s).contains(&at_s);
    let lost = record.light.iter().filter(|sample| sample.illuminance_lx.is_none());
    let whole = own
        .conversions
        .iter()
        .filter(|one| cruises(one.from_s) && cruises(one.to_s));
    let conversions = whole.map(|one| Conversion {
        place: one.place,
        from_s: one.from_s,
        to_s: one.to_s,
        value: one.illuminance_lx,
        sigma: sigma(one.place, one.illuminance_lx),
    });
    let left_out = LeftOut {
        without_number: lost.filter(|sample| cruises(sample.asked_s)).count(),
        unclear: own.unclear,
        ..LeftOut::default()
    };
    (conversions.collect(), left_out)
}

/// Those that their requests began.
fn on_request(
    record: &SweepRecord,
    [from_s, to_s]: [f64; 2],
    sigma: impl Fn(usize, f64) -> f64,
) -> (Vec<Conversion>, LeftOut) {
    let mut left_out = LeftOut::default();
    let mut conversions = Vec::with_capacity(record.light.len());
    let (mut out_of_step, mut before_s) = (false, f64::NEG_INFINITY);
    for (place, sample) in record.light.iter().enumerate() {
        let cruises = (from_s..=to_s - record.of.integration_s).contains(&sample.asked_s);
        let Some(value) = sample.illuminance_lx else {
            // The line is proved before the next request.
            out_of_step = false;
            left_out.without_number += usize::from(cruises);
            continue;
        };
        let least_s = sample.asked_s.max(before_s) + record.of.integration_s;
        before_s = sample.answered_s;
        // Times are kept to a microsecond.
        out_of_step |= sample.answered_s < least_s - 2e-6;
        if out_of_step || !cruises {
            left_out.early += usize::from(out_of_step && cruises);
            continue;
        }
        conversions.push(Conversion {
            place,
            from_s: sample.asked_s,
            to_s: sample.asked_s + record.of.integration_s,
            value,
            sigma: sigma(place, value),
        });
    }
    (conversions, left_out)
}

/// How far a conversion lies from the polynomial through its neighbours, and the standard deviation of that by noise.
#[derive(Debug, Clone, Copy)]
struct Misfit {
    value: f64,
    noise: f64,
}

/// The conversion that fits its neighbours least and alone, or with another one near by, is to blame for it.
fn astray(conversions: &[Conversion]) -> Option<Vec<usize>> {
    if conversions.len() < 2 * AROUND + 2 {
        return None;
    }
    let count = conversions.len();
    let misfits: Vec<Misfit> = (0..count).map(|at| misfit(conversions, at, &[])).collect();
    let far = |at: usize| misfits[at].value.abs() / misfits[at].noise;
    let mut suspects: Vec<usize> = (0..count).filter(|&at| far(at) > BEYOND).collect();
    // The damaged one is farther off than the neighbours that it spoils.
    suspects.sort_by(|a, b| misfits[*b].value.abs().total_cmp(&misfits[*a].value.abs()));
    suspects.into_iter().find_map(|at| {
        let near = near(count, at, NEIGHBOURS);
        let alone = std::iter::once(vec![at]);
        let pairs = near.filter(|&other| other != at).map(|other| vec![at, other]);
        alone.chain(pairs).find(|blamed| explains(conversions, blamed))
    })
}

/// Whether without `blamed` their neighbours fit together, and each of them is far from what these say.
fn explains(conversions: &[Conversion], blamed: &[usize]) -> bool {
    let count = conversions.len();
    blamed.iter().all(|&at| {
        let own = misfit(conversions, at, blamed);
        let others = |reach| {
            near(count, at, reach)
                .filter(|other| !blamed.contains(other))
                .map(|other| misfit(conversions, other, blamed))
        };
        let mut around: Vec<f64> = others(AROUND).map(|other| other.value.abs()).collect();
        around.sort_by(f64::total_cmp);
        let usual = around.get(around.len() / 2).copied().unwrap_or(f64::INFINITY);
        let far = own.value.abs() > BEYOND * own.noise.hypot(UNEVEN * usual);
        far && others(NEIGHBOURS).all(|other| other.value.abs() < (FITS * other.noise).max(SHARE * own.value.abs()))
    })
}

fn near(count: usize, at: usize, reach: usize) -> std::ops::RangeInclusive<usize> {
    at.saturating_sub(reach)..=(at + reach).min(count - 1)
}

/// A conversion against Lagrange's polynomial through its neighbours, without it and without those `but`. At the ends
/// of a sweep the neighbours are those of one side.
fn misfit(conversions: &[Conversion], at: usize, but: &[usize]) -> Misfit {
    let through = |other: &usize| *other != at && !but.contains(other);
    let below = (0..at).rev().filter(through).take(NEIGHBOURS);
    let above = (at + 1..conversions.len()).filter(through).take(NEIGHBOURS);
    let nodes: Vec<&Conversion> = below.chain(above).map(|other| &conversions[other]).collect();
    let own = conversions[at];
    let (mut value, mut variance) = (own.value, own.sigma * own.sigma);
    for (k, node) in nodes.iter().enumerate() {
        let others = nodes.iter().enumerate().filter(|(other, _)| *other != k);
        let weight: f64 = others
            .map(|(_, other)| (own.from_s - other.from_s) / (node.from_s - other.from_s))
            .product();
        value -= weight * node.value;
        variance += (weight * node.sigma).powi(2);
    }
    Misfit {
        value,
        noise: variance.sqrt().max(f64::MIN_POSITIVE),
    }
}

#[cfg(test)]
mod tests {
    use isolux_record::own_clock::OwnClock;
    use isolux_record::sweeps::{LightSample, SweepOf};

    use super::*;

    const NOISE_REL: f64 = 8e-4;

    /// Illuminance over γ.
    type Form = fn(f64) -> f64;

    /// A conversion each 0.19 s at 10 °/s of the light `of` γ, with noise.
    fn sweep(light: impl Fn(f64) -> f64) -> SweepRecord {
        let of = SweepOf {
            index: 0,
            block: "lit".to_owned(),
            point: 0,
            torn: None,
            c_deg: 0.0,
            c_target_deg: 0.0,
            ring_to_c_deg: None,
            gamma_deg: [-180.0, 180.0],
            speed_deg_s: 10.0,
            distance_mm: 3000.0,
            range: 4,
            integration_s: 0.1,
            update_interval_s: None,
            lamp_on_s: None,
            ambient_c: None,
            session: 0,
            burning: 1,
        };
        let sample = |k: i32| {
            let asked_s = 0.19 * f64::from(k);
            let value = light(10.0 * asked_s - 180.0);
            // The same in every run, and of this standard deviation.
            let noise = 1.4 * (f64::from(k) * 78.233).sin();
            LightSample {
                asked_s,
                answered_s: asked_s + 0.185,
                illuminance_lx: Some(value + noise * (NOISE_REL * value).hypot(1e-3)),
                digit_lx: 0.001,
                raw: String::new(),
            }
        };
        SweepRecord {
            of,
            positions: Vec::new(),
            light: (0..190).map(sample).collect(),
        }
    }

    fn lost(record: &SweepRecord) -> (Vec<usize>, LeftOut) {
        let (kept, left_out) = relied_on(record, None, [f64::NEG_INFINITY, f64::INFINITY], |_, value| {
            (NOISE_REL * value).hypot(1e-3)
        });
        let kept: Vec<usize> = kept.iter().map(|one| one.place).collect();
        (
            (0..record.light.len()).filter(|at| !kept.contains(at)).collect(),
            left_out,
        )
    }

    fn batwing(gamma: f64) -> f64 {
        let wing = |at: f64| (-((gamma - at) / 22.0).powi(2)).exp();
        80.0 * (wing(30.0) + wing(-30.0))
    }

    #[test]
    fn light_of_any_form_is_left_as_it_is() {
        let forms: [(&str, Form); 6] = [
            ("batwing", batwing),
            ("spot", |gamma| 100.0 * 0.5f64.powf((gamma / 7.5).powi(2))),
            ("narrow spot", |gamma| 100.0 * 0.5f64.powf((gamma / 3.5).powi(2))),
            ("edge", |gamma| if gamma.abs() < 40.3 { 100.0 } else { 0.2 }),
            ("soft edge", |gamma| {
                100.0 * ((40.3 - gamma.abs()) / 2.0).clamp(0.0, 1.0)
            }),
            ("dark", |_| 0.0),
        ];
        for (name, form) in forms {
            assert_eq!(lost(&sweep(form)), (vec![], LeftOut::default()), "{name}");
        }
    }

    #[test]
    fn a_wrong_value_is_left_out_wherever_it_stands() {
        for at in (2..188).step_by(3) {
            for factor in [1.05, 0.9, 10.0, 1e-3, -1.0, 1e5] {
                let mut record = sweep(batwing);
                let lux = &mut record.light[at].illuminance_lx;
                let (before, wrong) = (lux.unwrap(), lux.unwrap() * factor);
                // What the noise hides does no harm.
                if (before - wrong).abs() < 25.0 * (NOISE_REL * before).hypot(1e-3) {
                    continue;
                }
                *lux = Some(wrong);
                let astray = 1;
                assert_eq!(
                    lost(&record),
                    (
                        vec![at],
                        LeftOut {
                            astray,
                            ..LeftOut::default()
                        }
                    ),
                    "{at}: {before} became {wrong}"
                );
            }
        }
    }

    #[test]
    fn two_wrong_values_side_by_side_are_both_left_out() {
        for apart in [1, 2, 3, 4, 6] {
            let mut record = sweep(batwing);
            record.light[100].illuminance_lx = Some(1e4);
            record.light[100 + apart].illuminance_lx = Some(1.0);
            assert_eq!(lost(&record).0, [100, 100 + apart]);
        }
    }

    #[test]
    fn answers_to_earlier_requests_are_left_out_until_the_line_is_proved() {
        let mut record = sweep(batwing);
        // The answer before came once more: from here on each answer is that to the request before.
        record.light[90].answered_s = record.light[90].asked_s + 0.01;
        record.light[96].illuminance_lx = None;
        let (lost, left_out) = lost(&record);
        assert_eq!(lost, (90..=96).collect::<Vec<usize>>());
        assert_eq!((left_out.early, left_out.without_number, left_out.count()), (6, 1, 7));
        // Two answers nearer than one integration.
        let mut record = sweep(batwing);
        record.light[90].answered_s = record.light[91].answered_s - 0.05;
        assert_eq!(lost_from(&record), Some(91));
    }

    /// The conversions of `sweep(light)` as those of a meter with a clock of its own, one each 0.5 s at 3 °/s.
    fn by_own_clock(light: impl Fn(f64) -> f64) -> ByOwnClock {
        let record = sweep(light);
        let conversion = |(place, sample): (usize, &LightSample)| isolux_record::own_clock::Conversion {
            place,
            from_s: 0.5 * place as f64,
            to_s: 0.5 * (place + 1) as f64,
            illuminance_lx: sample.illuminance_lx.unwrap(),
        };
        ByOwnClock {
            clock: OwnClock {
                period_s: 0.5,
                end_s: 0.0,
                u_s: 0.001,
            },
            conversions: record.light.iter().enumerate().map(conversion).collect(),
            unclear: 0,
        }
    }

    #[test]
    fn a_conversion_given_twice_is_left_out_where_the_light_changes() {
        let record = sweep(batwing);
        let left_out = |own: &ByOwnClock| {
            let sigma = |_: usize, value: f64| (NOISE_REL * value).hypot(1e-3);
            let (kept, left_out) = relied_on(&record, Some(own), [f64::NEG_INFINITY, f64::INFINITY], sigma);
            let kept: Vec<usize> = kept.iter().map(|one| one.place).collect();
            let lost: Vec<usize> = (0..190).filter(|at| !kept.contains(at)).collect();
            assert_eq!(lost.len(), left_out.astray);
            lost
        };
        let whole = by_own_clock(batwing);
        assert_eq!(left_out(&whole), [0; 0]);
        for at in 3..187 {
            let mut own = whole.clone();
            let (before, here) = (
                own.conversions[at - 1].illuminance_lx,
                own.conversions[at].illuminance_lx,
            );
            own.conversions[at].illuminance_lx = before;
            let change = (here - before).abs() / (NOISE_REL * here).hypot(1e-3);
            let lost = left_out(&own);
            // Where it changes little, the one given twice is as good.
            assert!(
                lost == [at] || lost.is_empty() && change < 25.0,
                "{at}: {lost:?} {change}"
            );
        }
    }

    fn lost_from(record: &SweepRecord) -> Option<usize> {
        lost(record).0.first().copied()
    }
}
