//! How far the light of a sweep is displaced against the positions, by a pair of sweeps in both directions.
//!
//! Measurements that begin a time τ after their request (the latency, less the lag of the meter) at the speed v, and
//! play b between encoder and luminaire, displace a forward sweep by s = v·τ + b/2 and a backward one by −s. At one
//! speed they cannot be separated, and need not be: s is what is corrected. At two speeds τ = (s₁ − s₂)/(v₁ − v₂) and
//! b = 2·(s₁ − v₁·τ); light that shows neither leaves the play that benches have.

use super::curve::Curve;

/// Steps at both ends that are left out: there the curve is held from one side alone.
const MARGIN: usize = 3;
const ROUNDS: usize = 6;
/// Play of benches, as a standard deviation about 0: a measured one is far better known. By hand.
const PLAY_DEG: f64 = 0.5;

/// The displacement of one pair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shift {
    /// Speed of the pair, °/s.
    pub speed_deg_s: f64,
    /// What is added to the γ of a forward sweep and taken from that of a backward one, degrees.
    pub shift_deg: f64,
    /// Its standard uncertainty.
    pub u_deg: f64,
}

/// Delay and play, by pairs at two speeds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Delay {
    /// From a request to its measurement, less the lag of the meter, and its standard uncertainty, s.
    pub delay_s: (f64, f64),
    /// Play between encoder and luminaire, and its standard uncertainty, degrees.
    pub play_deg: (f64, f64),
}

impl Shift {
    /// By the curves of a forward and a backward sweep over `gamma_deg`; none where no slope of the light shows it.
    pub fn between(forward: &Curve, backward: &Curve, gamma_deg: &[f64], speed_deg_s: f64) -> Option<Self> {
        let inner = gamma_deg.get(MARGIN..gamma_deg.len().checked_sub(MARGIN)?)?;
        let (mut shift, mut scale) = (0.0, 1.0);
        let mut u_deg = f64::INFINITY;
        for _ in 0..ROUNDS {
            // The lamp may have changed between the two: a factor is found beside the displacement.
            let (mut ss, mut sk, mut kk, mut sr, mut kr, mut rr, mut count) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
            for gamma in inner {
                let (there, back) = (gamma - shift, gamma + shift);
                let u2 = forward.u_noise(there).powi(2) + backward.u_noise(back).powi(2);
                let u2 = u2 + forward.u_smoothing(there).powi(2) + backward.u_smoothing(back).powi(2);
                let weight = 1.0 / u2.max(f64::MIN_POSITIVE);
                let residual = forward.at(there) - scale * backward.at(back);
                let by_shift = forward.slope(there) + scale * backward.slope(back);
                let by_scale = backward.at(back);
                ss += weight * by_shift * by_shift;
                sk += weight * by_shift * by_scale;
                kk += weight * by_scale * by_scale;
                sr += weight * by_shift * residual;
                kr += weight * by_scale * residual;
                rr += weight * residual * residual;
                count += 1.0;
            }
            let determinant = ss * kk - sk * sk;
            if determinant <= 1e-12 * ss * kk || count < 8.0 {
                return None;
            }
            shift += (sr * kk - kr * sk) / determinant;
            scale += (ss * kr - sk * sr) / determinant;
            u_deg = (kk / determinant * (rr / (count - 2.0)).max(1.0)).sqrt();
        }
        (shift.is_finite() && u_deg.is_finite()).then_some(Self {
            speed_deg_s,
            shift_deg: shift,
            u_deg,
        })
    }
}

impl Delay {
    /// By the displacements at two speeds.
    pub fn of(fast: &Shift, slow: &Shift) -> Option<Self> {
        let difference = fast.speed_deg_s - slow.speed_deg_s;
        if difference.abs() < 0.05 * fast.speed_deg_s {
            return None;
        }
        let (a, b) = (slow.speed_deg_s / difference, fast.speed_deg_s / difference);
        let play = 2.0 * (b * slow.shift_deg - a * fast.shift_deg);
        let u_play = 2.0 * (a * fast.u_deg).hypot(b * slow.u_deg);
        // Light that hardly changes along γ says nothing of the play: then what benches have does.
        let share = PLAY_DEG * PLAY_DEG / (PLAY_DEG * PLAY_DEG + u_play * u_play);
        let (play, u_play) = (share * play, share.sqrt() * u_play);
        Some(Self {
            delay_s: (
                (fast.shift_deg - 0.5 * play) / fast.speed_deg_s,
                fast.u_deg.hypot(0.5 * u_play) / fast.speed_deg_s,
            ),
            play_deg: (play, u_play),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::curve::Window;
    use super::*;

    fn light(gamma: f64) -> f64 {
        100.0 * (1.0 + 0.4 * (gamma / 20.0).sin()) * 0.5f64.powf((gamma / 30.0).powi(2))
    }

    /// Curves of a pair whose γ are taken `shift` too small on the way forward, the lamp 0.1 % darker on the way back.
    fn pair(shift: f64, gamma: &[f64]) -> (Curve, Curve) {
        let curve = |sign: f64, level: f64| {
            let windows: Vec<Window> = (0..140)
                .map(|k| {
                    let from_deg = -88.0 + 1.25 * f64::from(k);
                    let value = (0..20)
                        .map(|part| level * light(from_deg + f64::from(part) / 20.0 + sign * shift))
                        .sum::<f64>()
                        / 20.0;
                    let noise = 0.02 * (f64::from(k) * 12.9898 + sign).sin();
                    Window {
                        from_deg,
                        to_deg: from_deg + 1.0,
                        value: value + noise,
                        sigma: 0.015,
                    }
                })
                .collect();
            Curve::through(gamma, &windows).unwrap()
        };
        (curve(1.0, 1.0), curve(-1.0, 0.999))
    }

    #[test]
    fn delay_and_play_are_found_and_separated_by_two_speeds() {
        let gamma: Vec<f64> = (0..89).map(|k| -88.0 + 2.0 * f64::from(k)).collect();
        let (delay_s, play_deg) = (0.063, 0.2);
        let shift = |speed: f64| {
            let (forward, backward) = pair(speed * delay_s + 0.5 * play_deg, &gamma);
            Shift::between(&forward, &backward, &gamma, speed).unwrap()
        };
        let (fast, slow) = (shift(10.0), shift(5.0));
        assert!((fast.shift_deg - 0.73).abs() < 3.0 * fast.u_deg + 0.002, "{fast:?}");
        let found = Delay::of(&fast, &slow).unwrap();
        assert!((found.delay_s.0 - delay_s).abs() < 0.003, "{found:?}");
        assert!((found.play_deg.0 - play_deg).abs() < 0.02, "{found:?}");
        assert!(found.delay_s.1 < 0.003 && found.play_deg.1 < 0.03, "{found:?}");
        assert_eq!(Delay::of(&fast, &fast), None);
    }

    #[test]
    fn light_without_a_slope_shows_no_displacement() {
        let gamma: Vec<f64> = (0..40).map(|k| 2.0 * f64::from(k)).collect();
        let windows: Vec<Window> = (0..70)
            .map(|k| Window {
                from_deg: f64::from(k),
                to_deg: f64::from(k) + 1.0,
                value: 0.0,
                sigma: 0.01,
            })
            .collect();
        let dark = Curve::through(&gamma, &windows).unwrap();
        assert_eq!(Shift::between(&dark, &dark, &gamma, 10.0), None);
    }
}
