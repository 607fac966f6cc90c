//! The state of the room that its instruments share: axes, lamp, shutter, baffle, clock.

use std::cell::Cell;

use isolux_darkroom::electrical::Electrical;
use isolux_darkroom::motion::Motion;
use isolux_darkroom::parts::Axis;
use isolux_darkroom::{Darkroom, Fault, FaultKind, Instrument, Kind, Observation, Room, climate};

/// Which axis of the controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AxisName {
    /// Turns the luminaire about its own axis.
    C,
    /// Turns it before the detector.
    Gamma,
    /// Carries the detector; its position is the distance.
    Rail,
}

impl AxisName {
    /// All, in the controller's order.
    pub const ALL: [Self; 3] = [Self::C, Self::Gamma, Self::Rail];
}

/// One axis: its motion in microsteps of the true position.
#[derive(Debug, Clone)]
pub struct AxisState {
    /// Microsteps per degree (rail: per mm).
    pub counts_per_unit: f64,
    /// Lowest and highest position, microsteps.
    pub limit: [f64; 2],
    /// Fastest speed, microsteps per second.
    pub top_speed: f64,
    /// Largest acceleration, microsteps per second squared.
    pub top_acceleration: f64,
    /// What the axis does, in microsteps.
    pub motion: Motion,
    /// Share of the play taken up, −1 to 1, when the present motion began, and where that was.
    play: (f64, f64),
    /// Play, microsteps.
    play_width: f64,
    /// Wobble at the fastest speed, and the way after which it repeats, microsteps.
    wobble: [f64; 2],
}

impl AxisState {
    fn new(axis: &Axis, play_deg: f64) -> Self {
        let counts_per_unit = axis.counts_per_deg.value();
        let start = (axis.start_deg * counts_per_unit).round();
        Self {
            counts_per_unit,
            limit: axis.limit_deg.map(|limit| (limit * counts_per_unit).round()),
            top_speed: axis.speed_deg_s * counts_per_unit,
            top_acceleration: axis.accel_deg_s2 * counts_per_unit,
            motion: Motion::at_rest(start),
            play: (0.0, start),
            play_width: play_deg.abs() * counts_per_unit,
            wobble: [axis.wobble_deg, axis.wobble_period_deg].map(|degrees| degrees * counts_per_unit),
        }
    }

    fn rail(distance_mm: f64) -> Self {
        let counts_per_unit = 2000.0;
        Self {
            counts_per_unit,
            limit: [100.0 * counts_per_unit, 12_000.0 * counts_per_unit],
            top_speed: 400.0 * counts_per_unit,
            top_acceleration: 800.0 * counts_per_unit,
            motion: Motion::at_rest(distance_mm * counts_per_unit),
            play: (0.0, 0.0),
            play_width: 0.0,
            wobble: [0.0, 1.0],
        }
    }

    /// Takes up `motion` at `now_s`.
    pub fn drive(&mut self, motion: Motion, now_s: f64) {
        self.play = (self.travel(now_s), self.motion.position(now_s));
        self.motion = motion;
    }

    /// Position at `now_s`, degrees (rail: mm).
    pub fn position(&self, now_s: f64) -> f64 {
        self.counts(now_s) / self.counts_per_unit
    }

    /// Position at `now_s` with the wobble of its speed, microsteps.
    pub fn counts(&self, now_s: f64) -> f64 {
        let even = self.motion.position(now_s);
        let [amplitude, period] = self.wobble;
        if amplitude == 0.0 {
            return even;
        }
        let share = self.motion.velocity(now_s).abs() / self.top_speed;
        even + amplitude * share * (std::f64::consts::TAU * even / period).sin()
    }

    /// Share of the play taken up at `now_s`: the sign of the last motion, once it was wide enough.
    pub fn travel(&self, now_s: f64) -> f64 {
        let moved = self.motion.position(now_s) - self.play.1;
        if moved == 0.0 {
            return self.play.0;
        }
        if self.play_width == 0.0 {
            return moved.signum();
        }
        (self.play.0 + moved / (0.5 * self.play_width)).clamp(-1.0, 1.0)
    }
}

/// Lamp, shutter and baffle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Switches {
    /// The lamp has current.
    pub lamp: bool,
    /// The shutter before the detectors is open.
    pub shutter_open: bool,
    /// The baffle stands in the beam.
    pub baffle_in: bool,
}

/// Parts of a window while something moves or is switched.
const PARTS: u32 = 16;
/// Time constants of a lag after which what was before counts no more.
const LAGS: f64 = 8.0;

/// Above the widest range of every meter, lx.
const DAZZLE_LX: f64 = 1e9;

/// The room as it is now.
#[derive(Debug, Clone)]
pub struct World {
    room: Room,
    axes: [AxisState; 3],
    switches: Switches,
    /// (when, what was before), latest last.
    switched: Vec<(f64, Switches)>,
    lamp_since_s: Option<f64>,
    /// Voltage at the lamp's terminals, V.
    supply_v: f64,
    /// Faults that shine on a meter.
    dazzled: Vec<Fault>,
    /// The floor's light where it was last asked for: (C, γ, distance, travel) and lx.
    floor: Cell<Option<([f64; 4], f64)>>,
}

impl World {
    /// The room at the moment it is opened.
    pub fn new(document: Darkroom) -> Self {
        let play_deg = document.injected_effects.backlash.width_deg;
        let axes = [
            AxisState::new(&document.axis.c, 0.0),
            AxisState::new(&document.axis.gamma, play_deg),
            AxisState::rail(document.bench.distance_mm),
        ];
        let lamp = document.lamp.on_at_start;
        let dazzles = |fault: &&Fault| fault.kind == FaultKind::Saturate;
        Self {
            dazzled: document.fault.iter().filter(dazzles).cloned().collect(),
            axes,
            switches: Switches {
                lamp,
                ..Switches::default()
            },
            switched: Vec::new(),
            lamp_since_s: lamp.then_some(0.0),
            supply_v: document.lamp.voltage_v,
            room: Room::new(document),
            floor: Cell::new(None),
        }
    }

    /// The truth.
    pub fn room(&self) -> &Room {
        &self.room
    }

    /// One axis.
    pub fn axis(&self, name: AxisName) -> &AxisState {
        &self.axes[name as usize]
    }

    /// One axis, to drive it.
    pub fn axis_mut(&mut self, name: AxisName) -> &mut AxisState {
        &mut self.axes[name as usize]
    }

    /// The switches.
    pub fn switches(&self) -> Switches {
        self.switches
    }

    /// Sets the switches at `now_s`.
    pub fn set_switches(&mut self, switches: Switches, now_s: f64) {
        if switches == self.switches {
            return;
        }
        if switches.lamp && !self.switches.lamp {
            self.lamp_since_s = Some(now_s);
        }
        // Only what an integration under way can still see is kept.
        self.switched.retain(|(when, _)| now_s - when < 100.0);
        self.switched.push((now_s, self.switches));
        self.switches = switches;
    }

    /// Light that no range shows falls on a meter, as `fault` says when.
    pub(crate) fn dazzle(&mut self, fault: Fault) {
        self.dazzled.push(fault);
    }

    /// That light goes away.
    pub(crate) fn shade(&mut self, instrument: Option<Instrument>) {
        self.dazzled
            .retain(|fault| instrument.is_some_and(|one| one != fault.instrument));
    }

    /// That light, averaged from `from_s` to `to_s` as far as it makes a difference: all of it or none, lx.
    fn dazzle_lx(&self, instrument: Instrument, from_s: f64, to_s: f64) -> f64 {
        let shines = |fault: &Fault| {
            let end_s = fault.for_s.map_or(f64::INFINITY, |for_s| fault.at_s + for_s);
            fault.instrument == instrument && fault.at_s < to_s && from_s < end_s
        };
        if self.dazzled.iter().any(shines) {
            DAZZLE_LX
        } else {
            0.0
        }
    }

    /// Seconds since the lamp was switched on.
    pub fn lamp_time_s(&self, now_s: f64) -> Option<f64> {
        self.lamp_since_s.map(|since| now_s - since)
    }

    /// Output of the lamp relative to the warm one at `at_s`; 0 in the dark.
    pub fn lamp_output(&self, at_s: f64) -> f64 {
        match self.lamp_time_s(at_s) {
            Some(time_s) if self.switches_at(at_s).lamp && time_s >= 0.0 => self.room.lamp_output(time_s),
            _ => 0.0,
        }
    }

    /// Sets the voltage of the lamp's supply, which without this is the rated one.
    pub fn set_supply_v(&mut self, voltage_v: f64) {
        self.supply_v = voltage_v;
    }

    /// The lamp's supply line at `at_s`.
    pub fn electrical(&self, at_s: f64) -> Electrical {
        match self.lamp_time_s(at_s) {
            Some(time_s) if self.switches_at(at_s).lamp && self.supply_v > 0.0 => {
                Electrical::illuminated(self.room.document(), self.supply_v, time_s)
            }
            _ => Electrical::idle(self.supply_v),
        }
    }

    /// Air temperature, °C.
    pub fn temperature_c(&self, now_s: f64) -> f64 {
        climate::temperature_c(&self.room.document().room, now_s)
    }

    /// Illuminance on the lux meter, averaged from `from_s` to `to_s`, lx. Axes that turn and switches that switch in
    /// that time are followed through it; the floor's light, which changes slowly, is that of the middle.
    pub fn meter_lx(&self, from_s: f64, to_s: f64) -> f64 {
        let lag_s = self.room.document().luxmeter.lag_s;
        let floor_lx = self.floor_lx(&self.observation(Kind::Baffled, 0.5 * (from_s + to_s)));
        let dazzle_lx = self.dazzle_lx(Instrument::Luxmeter, from_s, to_s);
        dazzle_lx
            + self.lagged(from_s, to_s, lag_s, |world, at_s, window_s| {
                let switches = world.switches_at(at_s);
                let kind = match switches {
                    Switches {
                        shutter_open: false, ..
                    } => Kind::Capped,
                    Switches { lamp: false, .. } => Kind::LampOff,
                    Switches { baffle_in: true, .. } => Kind::Baffled,
                    _ => Kind::Lit,
                };
                world
                    .room
                    .illuminance_with_floor_lx(&world.observation(kind, at_s), window_s, floor_lx)
            })
    }

    /// Illuminance on the spectroradiometer's entrance, averaged from `from_s` to `to_s`, lx. Shutter and baffle stand
    /// before it as before the meter.
    pub fn spectroradiometer_lx(&self, from_s: f64, to_s: f64) -> f64 {
        let dazzle_lx = self.dazzle_lx(Instrument::Spectroradiometer, from_s, to_s);
        dazzle_lx
            + self.average(from_s, to_s, |world, at_s, window_s| {
                let switches = world.switches_at(at_s);
                if !switches.shutter_open {
                    return 0.0;
                }
                let o = world.observation(Kind::Lit, at_s);
                let direct = switches.lamp && !switches.baffle_in;
                world
                    .room
                    .spectroradiometer_lx(direct, o.c_deg, o.gamma_deg, o.time_s, window_s)
            })
    }

    /// Illuminance of a line lamp before its entrance, behind the shutter, averaged from `from_s` to `to_s`, lx.
    /// Nothing of the room switches it.
    pub fn line_lamp_lx(&self, from_s: f64, to_s: f64) -> f64 {
        let lines_lx = self.room.document().spectroradiometer.line_lamp_lx;
        self.average(from_s, to_s, |world, at_s, _| {
            if world.switches_at(at_s).shutter_open {
                lines_lx
            } else {
                0.0
            }
        })
    }

    /// Phosphor light against the chip's in that light at `at_s`: its colour.
    pub fn spectroradiometer_phosphor(&self, at_s: f64) -> f64 {
        let switches = self.switches_at(at_s);
        let o = self.observation(Kind::Lit, at_s);
        let direct = switches.lamp && !switches.baffle_in;
        self.room
            .spectroradiometer_phosphor(direct, o.c_deg, o.gamma_deg, o.time_s)
    }

    /// The floor's light, remembered while nothing turns: adding up its patches is the dearest thing in the room.
    fn floor_lx(&self, o: &Observation) -> f64 {
        let place = [o.c_deg, o.gamma_deg, o.distance_mm, o.travel];
        match self.floor.get() {
            Some((known, floor_lx)) if known == place => floor_lx,
            _ => {
                let floor_lx = self.room.floor_lx(o);
                self.floor.set(Some((place, floor_lx)));
                floor_lx
            }
        }
    }

    fn observation(&self, kind: Kind, at_s: f64) -> Observation {
        Observation {
            kind,
            time_s: self.lamp_time_s(at_s).unwrap_or(0.0),
            c_deg: self.axis(AxisName::C).position(at_s),
            gamma_deg: self.axis(AxisName::Gamma).position(at_s),
            distance_mm: self.axis(AxisName::Rail).position(at_s),
            travel: self.axis(AxisName::Gamma).travel(at_s),
            range: 0,
            ambient_c: self.temperature_c(at_s),
        }
    }

    /// The switches as they were at `at_s`; the lamp follows its switch late.
    fn switches_at(&self, at_s: f64) -> Switches {
        let set_at = |at_s: f64| {
            self.switched
                .iter()
                .find(|(when, _)| *when > at_s)
                .map_or(self.switches, |(_, before)| *before)
        };
        let lamp = set_at(at_s - self.room.document().lamp.switch_s).lamp;
        Switches { lamp, ..set_at(at_s) }
    }

    /// The average over a window of light that follows with a first-order lag: what came before it counts in part.
    fn lagged(&self, from_s: f64, to_s: f64, lag_s: f64, light: impl Fn(&Self, f64, f64) -> f64) -> f64 {
        let began_s = from_s - LAGS * lag_s;
        if lag_s == 0.0 || !self.changed(began_s) {
            return self.average(from_s, to_s, light);
        }
        // A share of the light of a moment that has gone through the lag by `at_s`.
        let through = |moment_s: f64, at_s: f64| 1.0 - (-(at_s - moment_s).max(0.0) / lag_s).exp();
        let (mut sum, mut total) = (0.0, 0.0);
        for (a, b) in [(began_s, from_s), (from_s, to_s)] {
            let step_s = (b - a) / f64::from(PARTS);
            for part in 0..PARTS {
                let at_s = a + (f64::from(part) + 0.5) * step_s;
                let weight = (through(at_s, to_s) - through(at_s, from_s)) * step_s;
                sum += weight * light(self, at_s, step_s);
                total += weight;
            }
        }
        sum / total
    }

    /// Whether an axis or a switch has moved since `since_s`.
    fn changed(&self, since_s: f64) -> bool {
        let late = self.room.document().lamp.switch_s;
        self.axes.iter().any(|axis| axis.motion.moving(since_s))
            || self.switched.last().is_some_and(|(when, _)| when + late > since_s)
    }

    fn average(&self, from_s: f64, to_s: f64, light: impl Fn(&Self, f64, f64) -> f64) -> f64 {
        let parts = if self.changed(from_s) { PARTS } else { 1 };
        let window_s = (to_s - from_s) / f64::from(parts);
        (0..parts)
            .map(|k| light(self, from_s + (f64::from(k) + 0.5) * window_s, window_s))
            .sum::<f64>()
            / f64::from(parts)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_follows_switches_inside_a_window() {
        let mut document = Darkroom::default();
        document.lamp.switch_s = 0.0;
        let mut world = World::new(document);
        assert_eq!(world.meter_lx(0.0, 0.5), 0.0);
        world.set_switches(
            Switches {
                lamp: true,
                shutter_open: true,
                baffle_in: false,
            },
            1.25,
        );
        let half = world.meter_lx(1.0, 1.5);
        let full = world.meter_lx(1.5, 2.0);
        assert!((half / full - 0.5).abs() < 1e-9);
        assert_eq!(world.lamp_time_s(2.0), Some(0.75));
        world.set_switches(
            Switches {
                lamp: true,
                shutter_open: true,
                baffle_in: true,
            },
            3.0,
        );
        assert_eq!(world.meter_lx(3.5, 4.0), 0.0);
    }

    #[test]
    fn a_reading_while_the_axis_turns_is_the_mean_over_the_way() {
        let mut world = World::new(Darkroom::default());
        world.set_switches(
            Switches {
                lamp: true,
                shutter_open: true,
                baffle_in: false,
            },
            0.0,
        );
        let gamma = world.axis(AxisName::Gamma);
        let motion = gamma.motion.move_to(
            60.0 * gamma.counts_per_unit,
            10.0,
            gamma.top_speed,
            gamma.top_acceleration,
        );
        world.axis_mut(AxisName::Gamma).drive(motion, 10.0);
        let before = world.meter_lx(9.0, 9.5);
        let turning = world.meter_lx(11.0, 11.5);
        let after = world.meter_lx(20.0, 20.5);
        assert!(before > turning && turning > after);
        assert!((after / before - 0.5f64.powf(5.3)).abs() < 0.01);
    }

    #[test]
    fn a_lag_displaces_moving_light_by_its_time_constant() {
        let illuminated = |lag_s: f64| {
            let mut document = Darkroom::default();
            document.luxmeter.lag_s = lag_s;
            let mut world = World::new(document);
            let on = Switches {
                lamp: true,
                shutter_open: true,
                baffle_in: false,
            };
            world.set_switches(on, 0.0);
            let gamma = world.axis(AxisName::Gamma);
            let to = 60.0 * gamma.counts_per_unit;
            let motion = gamma
                .motion
                .move_to(to, 10.0, 0.5 * gamma.top_speed, gamma.top_acceleration);
            world.axis_mut(AxisName::Gamma).drive(motion, 10.0);
            world
        };
        let (quick, slow) = (illuminated(0.0), illuminated(0.08));
        let late = slow.meter_lx(13.0, 13.1);
        let [before, same] = [12.92, 13.0].map(|from_s| quick.meter_lx(from_s, from_s + 0.1));
        assert!(
            (late / before - 1.0).abs() < 2e-3 && late / same > 1.01,
            "{late}, {before}, {same}"
        );
        // At rest there is nothing to lag behind.
        assert_eq!(slow.meter_lx(30.0, 30.1), quick.meter_lx(30.0, 30.1));
    }

    #[test]
    fn a_wobbling_axis_is_where_it_says_and_rests_where_it_was_sent() {
        let mut document = Darkroom::default();
        document.axis.gamma.wobble_deg = 0.2;
        let mut world = World::new(document);
        let gamma = world.axis(AxisName::Gamma);
        let to = 60.0 * gamma.counts_per_unit;
        let motion = gamma.motion.move_to(to, 10.0, gamma.top_speed, gamma.top_acceleration);
        world.axis_mut(AxisName::Gamma).drive(motion, 10.0);
        let gamma = world.axis(AxisName::Gamma);
        let off = |now_s: f64| gamma.counts(now_s) - gamma.motion.position(now_s);
        let worst = (0..200)
            .map(|k| off(11.0 + 0.01 * f64::from(k)).abs())
            .fold(0.0, f64::max)
            / gamma.counts_per_unit;
        assert!((worst - 0.2).abs() < 0.01, "{worst}");
        assert_eq!(gamma.position(30.0), 60.0);
    }

    #[test]
    fn play_is_taken_up_over_its_width() {
        let mut document = Darkroom::default();
        document.injected_effects.backlash.width_deg = 0.4;
        let mut world = World::new(document);
        let drive = |world: &mut World, to: f64, now: f64| {
            let axis = world.axis_mut(AxisName::Gamma);
            let motion = axis
                .motion
                .move_to(to * axis.counts_per_unit, now, axis.top_speed, axis.top_acceleration);
            axis.drive(motion, now);
        };
        assert_eq!(world.axis(AxisName::Gamma).travel(0.0), 0.0);
        drive(&mut world, 10.0, 1.0);
        assert_eq!(world.axis(AxisName::Gamma).travel(20.0), 1.0);
        drive(&mut world, 9.8, 20.0);
        assert!(world.axis(AxisName::Gamma).travel(30.0).abs() < 0.01);
        drive(&mut world, 9.0, 30.0);
        assert_eq!(world.axis(AxisName::Gamma).travel(40.0), -1.0);
    }
}
