//! One sweep as it can be used: the line of its positions, the windows of the light that can be relied on, and where
//! there is none.

use isolux_photometry::Ring;
use isolux_record::own_clock::{ByOwnClock, OwnClock};
use isolux_record::plan::Way;
use isolux_record::sweeps::SweepRecord;
use isolux_record::{Electrical, Quality, Reading, ReadingKind, Role, Station};

use super::curve::{Curve, Window};
use super::guard::{self, LeftOut};
use super::track::Track;

/// Noise of a reading where the station states none, relative to it.
const NOISE_REL: f64 = 0.002;
/// Least noise that is believed, relative to the largest light of the sweep.
const NOISE_LEAST: f64 = 1e-5;
/// Before the first γ and behind the last, the axis cruises for so long, s.
const CRUISE_S: f64 = 0.25;
/// Largest way between two conversions, in those between most of them: one that is left out is bridged.
const BRIDGED: f64 = 2.5;

/// A sweep with the line of its positions and the windows of its light, not displaced yet.
pub struct Swept<'a> {
    pub record: &'a SweepRecord,
    pub track: Track,
    pub windows: Vec<Window>,
    /// One digit of the display, in the range that was held, lx.
    pub digit_lx: f64,
    /// Conversions that are not among the windows.
    pub left_out: LeftOut,
    /// The clock of a meter that has one of its own.
    pub clock: Option<OwnClock>,
}

impl<'a> Swept<'a> {
    /// None where there are too few positions.
    pub fn of(record: &'a SweepRecord, station: &Station) -> Option<Self> {
        let track = Track::of(record)?;
        let meter = station.luxmeter();
        let noise = |place: usize, value: f64| {
            let noise = meter.noise_rel.unwrap_or(NOISE_REL) * value.abs();
            let rounding = record.light[place].digit_lx / 12.0_f64.sqrt();
            noise.hypot(meter.noise_lx.unwrap_or(0.0)).hypot(rounding)
        };
        let [from_s, to_s] = record.of.way().moving_deg().map(|place| track.time_s(place));
        let cruise_s = [from_s - CRUISE_S, to_s + CRUISE_S];
        let own = ByOwnClock::of(record);
        let (conversions, left_out) = guard::relied_on(record, own.as_ref(), cruise_s, noise);
        let largest = conversions.iter().map(|one| one.value).fold(0.0, f64::max);
        let windows = conversions.iter().map(|one| Window {
            from_deg: track.place_deg(one.from_s),
            to_deg: track.place_deg(one.to_s),
            value: one.value,
            sigma: one.sigma.hypot(NOISE_LEAST * largest),
        });
        Some(Self {
            record,
            windows: windows.collect(),
            track,
            digit_lx: record.light.iter().map(|sample| sample.digit_lx).fold(0.0, f64::max),
            left_out,
            clock: own.map(|own| own.clock),
        })
    }

    /// The ring, in lx, where it is one that has light all round.
    pub fn ring(&self) -> Option<Ring> {
        let Way::Ring { gamma_deg, .. } = self.record.of.way() else {
            return None;
        };
        Ring::of(
            gamma_deg,
            self.windows.iter().map(|window| (window.middle_deg(), window.value)),
        )
    }

    /// How uncertain the line of its positions and the instants of its light leave the place of all of that, degrees.
    pub fn u_place_deg(&self) -> f64 {
        let of_line = self.track.rms_deg / (self.windows.len() as f64).sqrt();
        let of_clock = self.clock.map_or(0.0, |clock| self.track.speed_deg_s * clock.u_s);
        of_line.hypot(of_clock)
    }

    /// +1 where γ rises, −1 where it falls.
    pub fn sign(&self) -> f64 {
        self.track.speed_deg_s.signum()
    }

    /// The light over those of `gamma_deg` that the sweep reached, displaced by `shift_deg`; none where it does not
    /// determine a curve.
    pub fn along(&self, gamma_deg: &[f64], shift_deg: f64) -> Option<Along> {
        let nodes = self.nodes(gamma_deg);
        let by = self.sign() * shift_deg;
        // Windows reach beyond the ends: without those, the curve would hang free there.
        let knots = with_ends(&nodes)?;
        let (low, high) = (*knots.first()?, *knots.last()?);
        let windows: Vec<Window> = self
            .windows
            .iter()
            .map(|window| Window {
                from_deg: window.from_deg + by,
                to_deg: window.to_deg + by,
                ..*window
            })
            .filter(|window| window.from_deg.min(window.to_deg) >= low && window.from_deg.max(window.to_deg) <= high)
            .collect();
        Some(Along {
            curve: Curve::through(&knots, &windows)?,
            ways: Ways::of(&windows),
            nodes,
        })
    }

    /// The γ of the plan that the sweep was to reach.
    fn nodes(&self, gamma_deg: &[f64]) -> Vec<f64> {
        let [a, b] = self.record.of.gamma_deg;
        let (low, high) = (a.min(b), a.max(b));
        gamma_deg
            .iter()
            .copied()
            .filter(|gamma| (low..=high).contains(gamma))
            .collect()
    }

    /// A reading of `lux` with the uncertainty `u_lx` at the direction of the plan, as if γ had rested there.
    pub fn reading(&self, role: Role, (c_deg, gamma_deg): (f64, f64), time_s: f64, (lux, u_lx): (f64, f64)) -> Reading {
        let of = &self.record.of;
        Reading {
            index: 0,
            block: of.block.clone(),
            kind: ReadingKind::Lit,
            time_s: Some(time_s),
            c_deg: if role == Role::Point { of.c_deg } else { c_deg },
            gamma_deg,
            distance_mm: of.distance_mm,
            // The play is out of it.
            travel: 0,
            range: of.range,
            ambient_c: of.ambient_c,
            illuminance_lx: Some(lux),
            u_lx: Some(u_lx),
            quality: Quality::Ok,
            role,
            point: of.point,
            repeat: 0,
            c_target_deg: c_deg,
            gamma_target_deg: gamma_deg,
            digit_lx: None,
            integration_s: Some(of.integration_s),
            raw: String::new(),
            session: of.session,
            burning: Some(of.burning),
            lamp_s: of.lamp_on_s.map(|on| time_s - on),
            electrical: Electrical::default(),
        }
    }
}

/// `nodes` with one more step at each end; none where they are too few.
fn with_ends(nodes: &[f64]) -> Option<Vec<f64>> {
    let [first, second, .., before, last] = nodes else {
        return None;
    };
    let mut knots = vec![2.0 * first - second];
    knots.extend(nodes);
    knots.push(2.0 * last - before);
    Some(knots)
}

/// The light along a sweep.
pub struct Along {
    pub curve: Curve,
    /// The γ of the plan on the way.
    pub nodes: Vec<f64>,
    /// Where it has light.
    pub ways: Ways,
}

/// Middles of the windows of a sweep, rising, degrees.
pub struct Ways(Vec<f64>);

impl Ways {
    fn of(windows: &[Window]) -> Self {
        let mut middles: Vec<f64> = windows.iter().map(Window::middle_deg).collect();
        middles.sort_by(f64::total_cmp);
        Self(middles)
    }

    /// The way without light in which `gamma_deg` lies, degrees; at the ends of the sweep, where a curve is held
    /// from one side, 1.5 times the way to its nearest light.
    pub fn gap_deg(&self, gamma_deg: f64) -> f64 {
        let next = self.0.partition_point(|middle| *middle < gamma_deg);
        match (next.checked_sub(1).map(|before| self.0[before]), self.0.get(next)) {
            (Some(before), Some(after)) => after - before,
            (Some(one), None) => 1.5 * (gamma_deg - one),
            (None, Some(one)) => 1.5 * (one - gamma_deg),
            (None, None) => f64::INFINITY,
        }
    }

    /// Whether there is light on both sides of `gamma_deg`: what a curve says beyond its last one is drawn straight on.
    pub fn goes_on(&self, gamma_deg: f64) -> bool {
        let is_inside = |(first, last): (&f64, &f64)| *first <= gamma_deg && gamma_deg <= *last;
        self.0.first().zip(self.0.last()).is_some_and(is_inside)
    }

    /// The widest way that the curve bridges without a word.
    pub fn bridged_deg(&self) -> f64 {
        let mut between: Vec<f64> = self.0.windows(2).map(|pair| pair[1] - pair[0]).collect();
        between.sort_by(f64::total_cmp);
        BRIDGED * between.get(between.len() / 2).copied().unwrap_or(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gap_is_the_way_between_the_lights_around_a_direction() {
        let ways = Ways(
            (0..40)
                .map(|k| 2.0 * f64::from(k))
                .filter(|at| !(21.0..27.0).contains(at))
                .collect(),
        );
        assert_eq!(ways.bridged_deg(), 5.0);
        assert_eq!(
            (ways.gap_deg(11.0), ways.gap_deg(24.0), ways.gap_deg(20.5)),
            (2.0, 8.0, 8.0)
        );
        assert_eq!((ways.gap_deg(-1.5), ways.gap_deg(80.0)), (2.25, 3.0));
        assert_eq!(Ways(Vec::new()).gap_deg(0.0), f64::INFINITY);
    }
}
