//! What the meter shows without direct light: offset (capped), room light (lamp off), lamp-made stray light (baffled).

use isolux_record::{Reading, ReadingKind};

use crate::correction::{Correction, Switches};
use crate::point::{Point, mean};

/// A level that was read, with its standard uncertainty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Level {
    /// Mean illuminance shown, in lx.
    pub illuminance_lx: f64,
    /// Its standard uncertainty (noise and rounding), in lx.
    pub u_lx: f64,
    /// One digit of the meter, in lx.
    pub digit_lx: f64,
}

/// The levels of a run; what was not read is missing, never zero.
#[derive(Debug, Clone, PartialEq)]
pub struct Levels {
    /// Detector capped: offset.
    pub capped: Option<Level>,
    /// Lamp off: offset + room light.
    pub lamp_off: Option<Level>,
    /// Direct path blocked, against unsigned γ: offset + room light + lamp-made stray light.
    pub baffled: Vec<(f64, Level)>,
}

/// What is subtracted at one γ, and by how much each level's error moves it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Subtrahend {
    /// To subtract, in lx.
    pub illuminance_lx: f64,
    /// Effect of one standard uncertainty of the capped, the lamp-off and the baffled level, in lx.
    pub effect_lx: [f64; 3],
}

impl From<Point> for Level {
    fn from(point: Point) -> Self {
        Self {
            illuminance_lx: point.illuminance_lx,
            u_lx: point.u.noise.hypot(point.u.rounding),
            digit_lx: point.digit_lx,
        }
    }
}

impl Levels {
    /// The levels among `readings`; baffled ones at `distance_mm` alone, because stray light depends on it.
    pub(crate) fn among(readings: &[Reading], distance_mm: f64) -> Self {
        let of = |kind: ReadingKind| readings.iter().filter(move |reading| reading.kind == kind);
        let mut gammas: Vec<i64> = Vec::new();
        let here = |reading: &&Reading| (reading.distance_mm - distance_mm).abs() < 0.5;
        let gamma_key = |reading: &Reading| (reading.gamma_target_deg.abs() * 1000.0).round() as i64;
        gammas.extend(of(ReadingKind::Baffled).filter(here).map(gamma_key));
        gammas.sort_unstable();
        gammas.dedup();
        let baffled = gammas
            .into_iter()
            .filter_map(|gamma| {
                let at = of(ReadingKind::Baffled)
                    .filter(here)
                    .filter(|reading| gamma_key(reading) == gamma);
                Some((gamma as f64 / 1000.0, mean(at)?.into()))
            })
            .collect();
        Self {
            capped: mean(of(ReadingKind::Capped)).map(Level::from),
            lamp_off: mean(of(ReadingKind::LampOff)).map(Level::from),
            baffled,
        }
    }

    /// Whether a correction can be made from what was read, given the others that are on.
    ///
    /// The corrections add up: dark takes the capped level D away, ambient the difference L − D to the lamp-off level, stray
    /// the difference B − L to the baffled level. With all three on, B alone is subtracted, and D and L cancel.
    pub(crate) fn possible(&self, switches: &Switches, correction: Correction) -> bool {
        match correction {
            // Room light is only known beside the offset; without a capped reading both go together.
            Correction::Dark => self.capped.is_some() || (switches.on(Correction::Ambient) && self.lamp_off.is_some()),
            Correction::Ambient => self.lamp_off.is_some() && (self.capped.is_some() || switches.on(Correction::Dark)),
            Correction::Stray => {
                !self.baffled.is_empty()
                    && (self.lamp_off.is_some() || (switches.on(Correction::Ambient) && switches.on(Correction::Dark)))
            }
            Correction::Drift | Correction::SpectralDark => true,
        }
    }

    /// What is subtracted from a lit reading at an unsigned γ.
    pub(crate) fn subtrahend(&self, switches: &Switches, gamma_deg: f64) -> Subtrahend {
        let on = |correction| f64::from(u8::from(switches.on(correction) && self.possible(switches, correction)));
        let (dark, ambient, stray) = (on(Correction::Dark), on(Correction::Ambient), on(Correction::Stray));
        let nothing = Level {
            illuminance_lx: 0.0,
            u_lx: 0.0,
            digit_lx: 0.0,
        };
        let baffled = interpolate(&self.baffled, gamma_deg).unwrap_or(nothing);
        // Without a lamp-off block, all three on still means: the baffled level. Without a capped one, dark and ambient
        // together mean the lamp-off level.
        let capped = self.capped.unwrap_or(nothing);
        let lamp_off = self.lamp_off.unwrap_or(nothing);
        let weights = if self.lamp_off.is_none() {
            if stray > 0.0 { [0.0, 0.0, 1.0] } else { [dark, 0.0, 0.0] }
        } else if self.capped.is_none() {
            [0.0, dark.min(ambient) - stray, stray]
        } else {
            [dark - ambient, ambient - stray, stray]
        };
        let levels = [capped, lamp_off, baffled];
        Subtrahend {
            illuminance_lx: weights
                .iter()
                .zip(levels)
                .map(|(w, level)| w * level.illuminance_lx)
                .sum(),
            effect_lx: std::array::from_fn(|i| weights[i] * levels[i].u_lx),
        }
    }
}

/// Linear between the γ that were read, constant beyond them.
fn interpolate(levels: &[(f64, Level)], gamma_deg: f64) -> Option<Level> {
    let after = levels.partition_point(|(gamma, _)| *gamma < gamma_deg);
    match (after.checked_sub(1).and_then(|i| levels.get(i)), levels.get(after)) {
        (Some((from, a)), Some((to, b))) => {
            let t = (gamma_deg - from) / (to - from);
            let mix = |x: f64, y: f64| x + t * (y - x);
            Some(Level {
                illuminance_lx: mix(a.illuminance_lx, b.illuminance_lx),
                // Rounding of equal levels is equal: the two do not average out.
                u_lx: mix(a.u_lx, b.u_lx),
                digit_lx: a.digit_lx.max(b.digit_lx),
            })
        }
        (Some((_, only)), None) | (None, Some((_, only))) => Some(*only),
        (None, None) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn level(illuminance_lx: f64) -> Level {
        Level {
            illuminance_lx,
            u_lx: 0.1,
            digit_lx: 0.01,
        }
    }

    fn all() -> Levels {
        Levels {
            capped: Some(level(1.0)),
            lamp_off: Some(level(3.0)),
            baffled: vec![(0.0, level(7.0)), (90.0, level(5.0))],
        }
    }

    fn subtracted(levels: &Levels, off: &[Correction]) -> f64 {
        levels
            .subtrahend(&Switches::without(off.iter().copied()), 45.0)
            .illuminance_lx
    }

    #[test]
    fn each_switch_leaves_out_its_own_light() {
        use Correction::{Ambient, Dark, Stray};
        assert_eq!(subtracted(&all(), &[]), 6.0, "offset 1 + room 2 + stray 3");
        assert_eq!(subtracted(&all(), &[Stray]), 3.0);
        assert_eq!(subtracted(&all(), &[Ambient]), 4.0);
        assert_eq!(subtracted(&all(), &[Dark]), 5.0);
        assert_eq!(subtracted(&all(), &[Dark, Ambient, Stray]), 0.0);
    }

    #[test]
    fn what_was_not_read_is_not_invented() {
        let none = Levels {
            capped: None,
            lamp_off: None,
            baffled: Vec::new(),
        };
        assert_eq!(subtracted(&none, &[]), 0.0);
        for correction in [Correction::Dark, Correction::Ambient, Correction::Stray] {
            assert!(!none.possible(&Switches::default(), correction));
        }
        let no_cap = Levels { capped: None, ..all() };
        assert_eq!(subtracted(&no_cap, &[]), 6.0);
        assert_eq!(
            subtracted(&no_cap, &[Correction::Stray]),
            3.0,
            "offset and room light go together"
        );
        assert!(!no_cap.possible(&Switches::without([Correction::Dark]), Correction::Ambient));
        let only_cap = Levels {
            lamp_off: None,
            baffled: Vec::new(),
            ..all()
        };
        assert_eq!(subtracted(&only_cap, &[]), 1.0);
    }

    #[test]
    fn with_everything_on_only_the_baffled_level_is_uncertain() {
        let subtrahend = all().subtrahend(&Switches::default(), 10.0);
        assert_eq!(subtrahend.effect_lx, [0.0, 0.0, 0.1]);
    }
}
