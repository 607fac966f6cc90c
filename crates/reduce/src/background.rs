//! What the meter shows without the lamp's direct light: offset, ambient, stray.

use isolux_record::{Quality, Reading, ReadingKind};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The mean of readings of one kind, and what is known of it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Level {
    /// Mean.
    pub mean_lx: f64,
    /// Standard uncertainty of the mean from the scatter.
    pub u_noise_lx: f64,
    /// Standard uncertainty of the mean from the rounding of the display.
    pub u_digit_lx: f64,
    /// Readings.
    pub readings: usize,
}

impl Level {
    /// The level of readings of the same light. Rounding is rectangular with half-width digit/2, so its standard
    /// uncertainty is digit/√12; repeats reduce it only where the scatter spans the digit.
    pub fn of<'a>(readings: impl IntoIterator<Item = &'a Reading>) -> Option<Self> {
        let usable: Vec<(f64, f64, f64)> = readings
            .into_iter()
            .filter(|reading| reading.quality == Quality::Ok)
            .filter_map(|reading| {
                let value = reading.illuminance_lx?;
                Some((value, reading.u_lx.unwrap_or(0.0), reading.digit_lx.unwrap_or(0.0)))
            })
            .collect();
        if usable.is_empty() {
            return None;
        }
        let n = usable.len() as f64;
        let mean_lx = usable.iter().map(|(value, _, _)| value).sum::<f64>() / n;
        let digit = usable.iter().map(|(_, _, digit)| *digit).fold(0.0, f64::max);
        let scatter = if usable.len() > 1 {
            (usable
                .iter()
                .map(|(value, _, _)| (value - mean_lx).powi(2))
                .sum::<f64>()
                / (n - 1.0))
                .sqrt()
        } else {
            noise_of_one(usable[0].1, digit)
        };
        Some(Self {
            mean_lx,
            u_noise_lx: scatter / n.sqrt(),
            u_digit_lx: rounding(digit, scatter, usable.len()),
            readings: usable.len(),
        })
    }

    /// Standard uncertainty of the mean.
    pub fn u_lx(&self) -> f64 {
        self.u_noise_lx.hypot(self.u_digit_lx)
    }
}

/// Standard uncertainty of the rounding in the mean of `count` readings with `scatter`.
pub fn rounding(digit: f64, scatter: f64, count: usize) -> f64 {
    let one = digit / 12.0_f64.sqrt();
    // A scatter of half a digit and more dithers the rounding away; below it, every repeat is rounded alike.
    if scatter > 0.5 * digit {
        one / (count as f64).sqrt()
    } else {
        one
    }
}

/// What of a stated uncertainty is no rounding.
pub fn noise_of_one(u_lx: f64, digit_lx: f64) -> f64 {
    (u_lx * u_lx - digit_lx * digit_lx / 12.0).max(0.0).sqrt()
}

/// The levels of a run at one distance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema, Default)]
pub struct Background {
    /// Capped: the meter's offset.
    pub capped: Option<Level>,
    /// Lamp off: offset and ambient.
    pub lamp_off: Option<Level>,
    /// Baffled, by γ rising: offset, ambient and lamp-made stray light.
    pub baffled: Vec<(f64, Level)>,
    /// What had to be assumed.
    pub notes: Vec<String>,
}

/// Which of the three are subtracted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Subtract {
    /// Offset.
    pub dark: bool,
    /// Ambient.
    pub ambient: bool,
    /// Stray.
    pub stray: bool,
}

impl Background {
    /// The levels among `readings`; ambient and stray light only from those at `distance_mm`, where there are any.
    pub fn of(readings: &[Reading], distance_mm: f64) -> Self {
        let mut background = Self {
            capped: Level::of(of_kind(readings, ReadingKind::Capped)),
            ..Self::default()
        };
        let mut near = |kind: ReadingKind| -> Vec<&Reading> {
            let here: Vec<&Reading> = of_kind(readings, kind)
                .filter(|reading| reading.distance_mm == distance_mm)
                .collect();
            let all: Vec<&Reading> = of_kind(readings, kind).collect();
            if here.is_empty() && !all.is_empty() {
                background.notes.push(format!(
                    "{kind} readings were taken at another distance than {distance_mm} mm"
                ));
                return all;
            }
            here
        };
        let lamp_off = Level::of(near(ReadingKind::LampOff));
        let mut baffled = near(ReadingKind::Baffled);
        background.lamp_off = lamp_off;
        baffled.sort_by(|a, b| a.gamma_target_deg.abs().total_cmp(&b.gamma_target_deg.abs()));
        for group in baffled.chunk_by(|a, b| a.gamma_target_deg.abs() == b.gamma_target_deg.abs()) {
            if let Some(level) = Level::of(group.iter().copied()) {
                background.baffled.push((group[0].gamma_target_deg.abs(), level));
            }
        }
        if background.capped.is_none() && background.lamp_off.is_some() {
            background
                .notes
                .push("no capped readings: offset and ambient light are not told apart".to_owned());
        }
        if background.capped.is_none() && background.lamp_off.is_none() && !background.baffled.is_empty() {
            background.notes.push(
                "no lamp_off and no capped readings: offset, ambient and stray light are not told apart".to_owned(),
            );
        }
        if background.baffled.len() == 1 {
            background
                .notes
                .push("baffled readings at one γ only: the stray light is taken as constant".to_owned());
        }
        background
    }

    /// What is subtracted from a reading at `gamma_deg`, in lx: offset (capped), ambient (lamp_off − capped), stray
    /// (baffled − lamp_off), each where it is known and asked for.
    pub fn subtracted_lx(&self, gamma_deg: f64, subtract: Subtract) -> f64 {
        Self::coefficients(subtract)
            .iter()
            .zip(self.at(gamma_deg))
            .map(|(coefficient, level)| coefficient * level.mean_lx)
            .sum()
    }

    /// How much of offset, ambient and stray light is left in a reading after the subtraction: 1 where a part was not
    /// measured or its correction is off, 0 where it was taken out.
    pub fn left(&self, subtract: Subtract) -> [f64; 3] {
        let coefficients = Self::coefficients(subtract);
        let slots = self.slots();
        // Capped readings hold the offset, lamp_off ones the ambient light too, baffled ones all three.
        [0, 1, 2].map(|part| {
            let taken: f64 = (0..3)
                .filter(|&kind| slots[kind].is_some_and(|slot| slot >= part))
                .map(|kind| coefficients[kind])
                .sum();
            1.0 - taken
        })
    }

    /// Its standard uncertainty, as (noise, digit). Where all three are subtracted, only the baffled level remains in
    /// the sum, and only its uncertainty.
    pub fn u_lx(&self, gamma_deg: f64, subtract: Subtract) -> (f64, f64) {
        let (mut noise, mut digit) = (0.0_f64, 0.0_f64);
        let background = self.at(gamma_deg);
        let coefficients = Self::coefficients(subtract);
        // A missing kind stands for the one before it: their coefficients add up before they are squared.
        let slots = self.slots();
        for (slot, level) in background.iter().enumerate() {
            let coefficient: f64 = (0..3)
                .filter(|&kind| slots[kind] == Some(slot))
                .map(|kind| coefficients[kind])
                .sum();
            noise = noise.hypot(coefficient * level.u_noise_lx);
            digit = digit.hypot(coefficient * level.u_digit_lx);
        }
        (noise, digit)
    }

    /// Offset, ambient and stray light on their own, where they are known.
    pub fn parts_lx(&self, gamma_deg: f64) -> [Option<f64>; 3] {
        let [dark, off, baffled] = self.at(gamma_deg).map(|level| level.mean_lx);
        let [has_dark, has_off, has_baffled] = self.slots();
        [
            has_dark.map(|_| dark),
            (has_off == Some(1) && has_dark == Some(0)).then_some(off - dark),
            (has_baffled == Some(2)).then_some(baffled - off),
        ]
    }

    fn coefficients(subtract: Subtract) -> [f64; 3] {
        let on = |flag: bool| if flag { 1.0 } else { 0.0 };
        let [dark, ambient, stray] = [on(subtract.dark), on(subtract.ambient), on(subtract.stray)];
        [dark - ambient, ambient - stray, stray]
    }

    /// Which measured level stands for offset, lamp_off and baffled.
    fn slots(&self) -> [Option<usize>; 3] {
        let capped = self.capped.map(|_| 0);
        let lamp_off = self.lamp_off.map(|_| 1);
        let dark = capped.or(lamp_off);
        let off = lamp_off.or(capped);
        let baffled = if self.baffled.is_empty() { off } else { Some(2) };
        [dark.or(baffled), off.or(baffled), baffled]
    }

    fn at(&self, gamma_deg: f64) -> [Level; 3] {
        let nothing = Level {
            mean_lx: 0.0,
            u_noise_lx: 0.0,
            u_digit_lx: 0.0,
            readings: 0,
        };
        let measured = [
            self.capped.unwrap_or(nothing),
            self.lamp_off.unwrap_or(nothing),
            self.baffled_at(gamma_deg.abs()).unwrap_or(nothing),
        ];
        self.slots().map(|slot| slot.map_or(nothing, |slot| measured[slot]))
    }

    fn baffled_at(&self, gamma_deg: f64) -> Option<Level> {
        let above = self.baffled.partition_point(|(at, _)| *at < gamma_deg);
        let below = above.checked_sub(1).and_then(|index| self.baffled.get(index));
        match (below, self.baffled.get(above)) {
            (Some((low, first)), Some((high, second))) => {
                let share = (gamma_deg - low) / (high - low);
                let mix = |a: f64, b: f64| a + share * (b - a);
                Some(Level {
                    mean_lx: mix(first.mean_lx, second.mean_lx),
                    u_noise_lx: first.u_noise_lx.max(second.u_noise_lx),
                    u_digit_lx: first.u_digit_lx.max(second.u_digit_lx),
                    readings: first.readings + second.readings,
                })
            }
            (Some((_, level)), None) | (None, Some((_, level))) => Some(*level),
            (None, None) => None,
        }
    }
}

fn of_kind(readings: &[Reading], kind: ReadingKind) -> impl Iterator<Item = &Reading> {
    readings
        .iter()
        .filter(move |reading| reading.kind == kind && reading.quality == Quality::Ok)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::reading;

    const ALL: Subtract = Subtract {
        dark: true,
        ambient: true,
        stray: true,
    };

    fn dark(kind: ReadingKind, values: &[f64]) -> Vec<Reading> {
        values
            .iter()
            .map(|&value| Reading {
                kind,
                ..reading(0.0, 0.0, value)
            })
            .collect()
    }

    #[test]
    fn the_digit_stays_however_often_it_is_read() {
        let quiet = Level::of(&dark(ReadingKind::Capped, &[0.05; 400])).unwrap();
        assert!((quiet.u_lx() - 0.01 / 12.0_f64.sqrt()).abs() < 1e-15);
        // Scatter over several digits dithers the rounding: then 400 repeats help, by 20.
        let noisy: Vec<f64> = (0..400).map(|i| 0.05 + 0.01 * f64::from(i % 7 - 3)).collect();
        let noisy = Level::of(&dark(ReadingKind::Capped, &noisy)).unwrap();
        assert!((noisy.u_digit_lx - 0.01 / 12.0_f64.sqrt() / 20.0).abs() < 1e-15);
    }

    #[test]
    fn each_switch_takes_its_own_part() {
        let mut readings = dark(ReadingKind::Capped, &[0.05]);
        readings.extend(dark(ReadingKind::LampOff, &[0.07]));
        readings.extend(dark(ReadingKind::Baffled, &[0.12]));
        let background = Background::of(&readings, 10_000.0);
        let close = |value: f64, expected: f64| assert!((value - expected).abs() < 1e-12, "{value} {expected}");
        close(background.subtracted_lx(30.0, ALL), 0.12);
        close(background.subtracted_lx(30.0, Subtract { dark: false, ..ALL }), 0.07);
        close(background.subtracted_lx(30.0, Subtract { ambient: false, ..ALL }), 0.10);
        close(background.subtracted_lx(30.0, Subtract { stray: false, ..ALL }), 0.07);
        // All three: E − baffled, whose digit alone remains.
        close(background.u_lx(0.0, ALL).1, 0.01 / 12.0_f64.sqrt());
        close(
            background.u_lx(0.0, Subtract { ambient: false, ..ALL }).1,
            0.01 / 4.0_f64.sqrt(),
        );
        assert_eq!(background.left(ALL), [0.0; 3]);
        assert_eq!(background.left(Subtract { dark: false, ..ALL }), [1.0, 0.0, 0.0]);
        assert_eq!(background.left(Subtract { stray: false, ..ALL }), [0.0, 0.0, 1.0]);
        let capped = Background::of(&dark(ReadingKind::Capped, &[0.05]), 10_000.0);
        assert_eq!(capped.left(ALL), [0.0, 1.0, 1.0]);
        assert_eq!(Background::default().left(ALL), [1.0; 3]);
        let only_off = Background::of(&dark(ReadingKind::LampOff, &[0.07]), 10_000.0);
        close(only_off.subtracted_lx(0.0, ALL), 0.07);
        close(only_off.u_lx(0.0, ALL).1, 0.01 / 12.0_f64.sqrt());
        assert_eq!(only_off.left(ALL), [0.0, 0.0, 1.0]);
        assert_eq!(only_off.parts_lx(0.0), [Some(0.07), None, None]);
        close(Background::default().subtracted_lx(0.0, ALL), 0.0);
    }

    #[test]
    fn stray_light_is_interpolated_over_gamma() {
        let mut readings = dark(ReadingKind::LampOff, &[0.0]);
        for (gamma, value) in [(0.0, 0.10), (90.0, 0.40), (-90.0, 0.20)] {
            readings.push(Reading {
                kind: ReadingKind::Baffled,
                ..reading(0.0, gamma, value)
            });
        }
        let background = Background::of(&readings, 10_000.0);
        assert!((background.subtracted_lx(45.0, ALL) - 0.20).abs() < 1e-12);
        assert!((background.subtracted_lx(180.0, ALL) - 0.30).abs() < 1e-12);
    }
}
