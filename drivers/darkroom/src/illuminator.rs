//! The lamp: LEDs one by one, each with its place, its axis and its share of the flux; or a disc of points that all
//! radiate with the lamp's table of intensities.
//!
//! Frame of the luminaire: light centre at the origin, z along γ = 0, direction (C, γ) = (sin γ cos C, sin γ sin
//! C, cos γ).

use std::sync::Arc;

use glam::DVec3;

use crate::injected_effects::{DeadSector, InjectedEffects, SelfAbsorption};
use crate::noise::{Noise, Stream};
use crate::parts::Lamp;
use crate::table::LampTable;

/// One LED, or one point of a luminous disc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Led {
    /// Place, mm.
    pub position_mm: DVec3,
    /// Unit vector along its lobe.
    pub axis: DVec3,
    /// Unit vector across its lobe, towards the wide side of its lens.
    pub wide: DVec3,
    /// Luminous intensity along its axis, cd; of a point of a disc, its share of the lamp's table.
    pub axial_cd: f64,
}

/// How every point of the lamp radiates.
#[derive(Debug, Clone, PartialEq)]
enum Shape {
    /// With the lobe of an LED.
    Lobe { power: PowerTable, ellipticity: f64 },
    /// With a table, seen from the light centre.
    Table(Arc<LampTable>),
}

/// Rings of points on a luminous disc beside the one in its middle: 6, 12, 18 and 24 points, each for the same area.
const DISC_RINGS: u32 = 4;

/// Light of one LED on its way to one point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Unit vector from the LED to the point.
    pub direction: DVec3,
    /// Distance, mm.
    pub distance_mm: f64,
    /// Luminous intensity of the LED in that direction, cd; losses near the lamp and in the air are taken off.
    pub intensity_cd: f64,
    /// Its phosphor light against the chip's, 1 along the LED's axis.
    pub phosphor: f64,
}

impl Ray {
    /// Illuminance on a surface with the unit normal `normal`, lx; zero from behind.
    pub fn illuminance_lx(&self, normal: DVec3) -> f64 {
        self.normal_illuminance_lx() * self.incidence_cos(normal)
    }

    /// Illuminance on a surface that faces the LED, lx.
    pub fn normal_illuminance_lx(&self) -> f64 {
        self.intensity_cd * 1e6 / (self.distance_mm * self.distance_mm)
    }

    /// Cosine of the angle of incidence, zero from behind.
    pub fn incidence_cos(&self, normal: DVec3) -> f64 {
        (-self.direction.dot(normal)).max(0.0)
    }
}

/// All LEDs of the lamp, and what stands close before them.
#[derive(Debug, Clone, PartialEq)]
pub struct Illuminator {
    leds: Vec<Led>,
    shape: Shape,
    phosphor: Phosphor,
    absorber: Option<Absorber>,
    absorption_per_mm: f64,
    /// Sine of the largest lean of an LED (of the last light of a table beyond the horizon), the largest distance of a
    /// point from the light centre, and the distance from which the lamp lights the floor as a point, mm.
    behind_per_mm: f64,
    reach_mm: f64,
    far_mm: f64,
}

/// Distance in radii of the lamp from which its light on the floor is taken as that of a point: the inverse-square law
/// is then right to about a percent of light that is itself a few thousandths of a reading.
const FAR_RADII: f64 = 15.0;

impl Illuminator {
    /// Builds the lamp with the injected effects that belong to it; `seed` is the room's, for a lamp without one of
    /// its own.
    pub fn new(lamp: &Lamp, injected_effects: &InjectedEffects, seed: u64) -> Self {
        match &lamp.intensities {
            Some(table) => Self::disc(lamp, table, injected_effects),
            None => Self::rings(lamp, injected_effects, seed),
        }
    }

    /// A disc across the lamp's axis that radiates with `table` from every point.
    fn disc(lamp: &Lamp, table: &Arc<LampTable>, injected_effects: &InjectedEffects) -> Self {
        let diameter_mm = lamp.diameter_mm();
        let rings = if diameter_mm > 0.0 { DISC_RINGS } else { 0 };
        let total = f64::from(1 + 3 * rings * (rings + 1));
        let place = |ring: u32, k: u32| {
            let azimuth = std::f64::consts::TAU * (f64::from(k) + 0.5 * f64::from(ring % 2)) / f64::from(6 * ring);
            // Ring n is the annulus between √(1 + 3n(n − 1)) and √(1 + 3n(n + 1)) of √total; its mean square
            // is this.
            let radius = 0.5 * diameter_mm * ((1.0 + f64::from(3 * ring * ring)) / total).sqrt();
            (radius, azimuth)
        };
        let places: Vec<(f64, f64)> = std::iter::once((0.0, 0.0))
            .chain((1..=rings).flat_map(|ring| (0..6 * ring).map(move |k| place(ring, k))))
            .collect();
        let leds = places
            .iter()
            .map(|&(radius, azimuth)| Led {
                position_mm: DVec3::new(azimuth.cos(), azimuth.sin(), 0.0) * radius,
                axis: DVec3::Z,
                wide: DVec3::X,
                axial_cd: (1.0 - dead_share(&injected_effects.dead_sector, azimuth)) / total,
            })
            .collect();
        Self {
            leds,
            behind_per_mm: (-table.last_lit_deg().to_radians().cos()).max(0.0),
            reach_mm: 0.5 * diameter_mm,
            // Its light on the floor is that of a point: a luminaire may be as large as the floor is near.
            far_mm: 0.0,
            shape: Shape::Table(table.clone()),
            phosphor: Phosphor::of(lamp),
            absorber: Absorber::new(&injected_effects.self_absorption),
            absorption_per_mm: injected_effects.air_absorption.coefficient_per_m / 1000.0,
        }
    }

    fn rings(lamp: &Lamp, injected_effects: &InjectedEffects, seed: u64) -> Self {
        let noise = Noise::new(if lamp.seed == 0 { seed } else { lamp.seed }, Stream::Leds);
        let mut places = Vec::new();
        for (ring, (&diameter, &count)) in lamp.ring_diameter_mm.iter().zip(&lamp.leds_per_ring).enumerate() {
            for k in 0..count {
                // Rings start half a step apart, as boards are laid out.
                let azimuth = std::f64::consts::TAU * (k as f64 + 0.5 * ring as f64) / count as f64;
                places.push((0.5 * diameter, azimuth));
            }
        }
        let spread: Vec<[f64; 2]> = (0..places.len()).map(|k| noise.normal_pair(k as u64, 0)).collect();
        let mean = spread
            .iter()
            .fold([0.0; 2], |sum, s| [sum[0] + s[0], sum[1] + s[1]])
            .map(|s| s / places.len() as f64);
        let (sin, cos) = lamp.ellipticity_azimuth_deg.to_radians().sin_cos();
        let wide_side = DVec3::new(cos, sin, 0.0);
        let weights: Vec<f64> = (0..places.len())
            .map(|k| (1.0 + lamp.flux_spread_rel * noise.normal(k as u64, 1)).max(0.0))
            .collect();
        let total: f64 = weights.iter().sum();
        // One LED's lobe cosⁿθ holds 2π/(n+1) · its axial intensity; the elliptic term integrates to nothing.
        let axial_per_lm = (lamp.exponent + 1.0) / std::f64::consts::TAU;
        let leds: Vec<Led> = places
            .iter()
            .zip(&weights)
            .zip(&spread)
            .map(|((&(radius, azimuth), weight), spread)| {
                let (sin, cos) = azimuth.sin_cos();
                let outward = DVec3::new(cos, sin, 0.0);
                let aim = lamp.aim_deg.to_radians();
                let stray = lamp.aim_spread_deg.to_radians();
                let lean = DVec3::new(spread[0] - mean[0], spread[1] - mean[1], 0.0) * stray;
                let axis = (DVec3::Z * aim.cos() - outward * aim.sin() + lean).normalize();
                let wide = (wide_side - axis * wide_side.dot(axis)).normalize();
                let dimmed = 1.0 - dead_share(&injected_effects.dead_sector, azimuth);
                Led {
                    position_mm: outward * radius,
                    axis,
                    wide,
                    axial_cd: lamp.flux_lm * weight / total * axial_per_lm * dimmed,
                }
            })
            .collect();
        let reach_mm = leds.iter().map(|led| led.position_mm.length()).fold(0.0, f64::max);
        Self {
            behind_per_mm: leds.iter().map(|led| led.axis.truncate().length()).fold(0.0, f64::max),
            reach_mm,
            far_mm: FAR_RADII * reach_mm,
            leds,
            shape: Shape::Lobe {
                power: PowerTable::new(lamp.exponent),
                ellipticity: lamp.ellipticity_rel,
            },
            phosphor: Phosphor::of(lamp),
            absorber: Absorber::new(&injected_effects.self_absorption),
            absorption_per_mm: injected_effects.air_absorption.coefficient_per_m / 1000.0,
        }
    }

    /// The LEDs.
    pub fn leds(&self) -> &[Led] {
        &self.leds
    }

    /// Light of every LED on its way to `point_mm` (luminaire frame).
    pub fn rays_to(&self, point_mm: DVec3) -> impl Iterator<Item = Ray> + '_ {
        self.leds.iter().map(move |led| {
            let path = point_mm - led.position_mm;
            let distance_mm = path.length();
            let direction = path / distance_mm;
            let mut intensity_cd = self.intensity_cd(led, direction);
            if let Some(absorber) = &self.absorber {
                intensity_cd *= absorber.transmittance(led.position_mm, direction);
            }
            if self.absorption_per_mm != 0.0 {
                intensity_cd *= (-self.absorption_per_mm * distance_mm).exp();
            }
            Ray {
                direction,
                distance_mm,
                intensity_cd,
                phosphor: self.phosphor.towards(led.axis, direction),
            }
        })
    }

    /// Distance from the light centre beyond which the floor takes the lamp as a point, mm.
    pub fn far_mm(&self) -> f64 {
        self.far_mm
    }

    /// False if no LED can light the point `point_mm` (luminaire frame), because it lies behind all of them.
    pub fn may_light(&self, point_mm: DVec3) -> bool {
        point_mm.z > -self.behind_per_mm * point_mm.length() - self.reach_mm
    }

    /// Luminous intensity towards the unit vector `direction` from infinitely far away, cd.
    pub fn far_field_cd(&self, direction: DVec3) -> f64 {
        self.far_field_parts(direction)
            .map(|(intensity_cd, _)| intensity_cd)
            .sum()
    }

    /// Intensity in cd and phosphor light of each LED towards the unit vector `direction` from infinitely far away.
    pub fn far_field_parts(&self, direction: DVec3) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.leds.iter().map(move |led| {
            let seen = self
                .absorber
                .as_ref()
                .map_or(1.0, |a| a.transmittance(led.position_mm, direction));
            let phosphor = self.phosphor.towards(led.axis, direction);
            (self.intensity_cd(led, direction) * seen, phosphor)
        })
    }

    /// Whether the colour of its light depends on the direction.
    pub fn has_colours(&self) -> bool {
        self.phosphor.rise != 0.0 || self.phosphor.lean != DVec3::ZERO
    }

    /// Luminous intensity along γ = 0 from infinitely far away, cd.
    pub fn axial_cd(&self) -> f64 {
        self.far_field_cd(DVec3::Z)
    }

    /// The largest luminous intensity from infinitely far away, cd: of a table its own, of LEDs that along γ = 0.
    pub fn peak_cd(&self) -> f64 {
        match &self.shape {
            Shape::Table(table) => table.peak_cd(),
            Shape::Lobe { .. } => self.axial_cd(),
        }
    }

    fn intensity_cd(&self, led: &Led, direction: DVec3) -> f64 {
        let (power, ellipticity) = match &self.shape {
            Shape::Table(table) => return led.axial_cd * table.intensity_cd(direction),
            Shape::Lobe { power, ellipticity } => (power, ellipticity),
        };
        let cos = direction.dot(led.axis);
        if cos <= 0.0 {
            return 0.0;
        }
        // sin²θ cos 2(φ − φ₀) = u² − v², with u and v along the wide and the narrow side of the lens.
        let u = direction.dot(led.wide);
        let narrow_square = 1.0 - cos * cos - u * u;
        led.axial_cd * power.at(cos) * (1.0 + ellipticity * (u * u - narrow_square))
    }
}

/// Share of its flux that an LED at `azimuth` (rad) has lost: a raised cosine over twice the sector's width at half
/// depth.
fn dead_share(sector: &DeadSector, azimuth: f64) -> f64 {
    let width = sector.width_deg.to_radians();
    let from_middle = (azimuth - sector.azimuth_deg.to_radians())
        .sin()
        .atan2((azimuth - sector.azimuth_deg.to_radians()).cos())
        .abs();
    if from_middle >= width {
        return 0.0;
    }
    sector.depth_rel * 0.5 * (1.0 + (std::f64::consts::PI * from_middle / width).cos())
}

/// The phosphor's light against the chip's, by the angle from an LED's axis.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Phosphor {
    rise: f64,
    /// Across the lamp's axis, towards the thicker side, as long as the lean.
    lean: DVec3,
}

impl Phosphor {
    fn of(lamp: &Lamp) -> Self {
        let (sin, cos) = lamp.phosphor_lean_azimuth_deg.to_radians().sin_cos();
        Self {
            rise: lamp.phosphor_rise_rel,
            lean: DVec3::new(cos, sin, 0.0) * lamp.phosphor_lean_rel,
        }
    }

    /// Never below a twentieth of what it is along the axis: no LED is without its phosphor.
    fn towards(&self, axis: DVec3, direction: DVec3) -> f64 {
        let cos = direction.dot(axis);
        (1.0 + self.rise * (1.0 - cos * cos) + self.lean.dot(direction)).max(0.05)
    }
}

/// A soft-edged obstacle on a plane close before the lamp, across its own direction.
#[derive(Debug, Clone, PartialEq)]
struct Absorber {
    centre_mm: DVec3,
    normal: DVec3,
    depth: f64,
    inverse_variance: f64,
}

impl Absorber {
    /// Distance of the obstacle from the light centre: a mount's arm.
    const DISTANCE_MM: f64 = 500.0;

    fn new(effect: &SelfAbsorption) -> Option<Self> {
        if effect.depth_rel == 0.0 {
            return None;
        }
        let (gamma, c) = InjectedEffects::polar(effect.gamma_deg, effect.azimuth_deg);
        let normal = DVec3::new(gamma.sin() * c.cos(), gamma.sin() * c.sin(), gamma.cos());
        // Half depth at half the width: exp(−ρ²/2σ²) = ½.
        let half_mm = Self::DISTANCE_MM * (0.5 * effect.width_deg).to_radians().tan();
        Some(Self {
            centre_mm: normal * Self::DISTANCE_MM,
            normal,
            depth: effect.depth_rel,
            inverse_variance: 2.0 * std::f64::consts::LN_2 / (half_mm * half_mm),
        })
    }

    fn transmittance(&self, from_mm: DVec3, direction: DVec3) -> f64 {
        let approach = direction.dot(self.normal);
        if approach <= 0.0 {
            return 1.0;
        }
        let to_plane = (self.centre_mm - from_mm).dot(self.normal) / approach;
        let miss = from_mm + direction * to_plane - self.centre_mm;
        1.0 - self.depth * (-0.5 * miss.length_squared() * self.inverse_variance).exp()
    }
}

/// xⁿ on [0, 1], tabulated: a lobe is asked for a hundred times a reading.
#[derive(Debug, Clone, PartialEq)]
struct PowerTable {
    values: Vec<f64>,
}

impl PowerTable {
    const CELLS: usize = 8192;

    fn new(exponent: f64) -> Self {
        Self {
            values: (0..=Self::CELLS)
                .map(|k| (k as f64 / Self::CELLS as f64).powf(exponent))
                .collect(),
        }
    }

    fn at(&self, x: f64) -> f64 {
        let place = x * Self::CELLS as f64;
        let cell = (place as usize).min(Self::CELLS - 1);
        let low = self.values[cell];
        low + (place - cell as f64) * (self.values[cell + 1] - low)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::Darkroom;

    fn direction(c: f64, gamma: f64) -> DVec3 {
        DVec3::new(gamma.sin() * c.cos(), gamma.sin() * c.sin(), gamma.cos())
    }

    fn flux_lm(lamp: &Illuminator) -> f64 {
        let (nc, ng) = (36, 800);
        let mut sum = 0.0;
        for j in 0..ng {
            let gamma = std::f64::consts::PI * (j as f64 + 0.5) / ng as f64;
            for i in 0..nc {
                sum += lamp.far_field_cd(direction(std::f64::consts::TAU * i as f64 / nc as f64, gamma)) * gamma.sin();
            }
        }
        sum * (std::f64::consts::TAU / nc as f64) * (std::f64::consts::PI / ng as f64)
    }

    #[test]
    fn the_lamp_gives_its_flux_and_about_a_thousand_candela_per_kilolumen() {
        let room = Darkroom::default();
        let lamp = Illuminator::new(&room.lamp, &room.injected_effects, room.seed);
        assert!((flux_lm(&lamp) / 337.0 - 1.0).abs() < 2e-5, "{}", flux_lm(&lamp));
        let peak = lamp.far_field_cd(DVec3::Z) / 0.337;
        assert!((peak - 1000.0).abs() < 10.0, "{peak}");
        assert_eq!(lamp.leds().len(), 60);
        assert_eq!(lamp.far_field_cd(direction(0.3, 1.7)), 0.0);
    }

    /// simulation.md, section 2: cosⁿ with n = 5.3 on parallel rings is −1.3 % at 500 mm and −13.5 % at 150 mm.
    #[test]
    fn parallel_rings_fall_below_the_inverse_square() {
        let mut room = Darkroom::default();
        room.lamp.flux_spread_rel = 0.0;
        room.lamp.aim_spread_deg = 0.0;
        room.lamp.ellipticity_rel = 0.0;
        let lamp = Illuminator::new(&room.lamp, &room.injected_effects, 1);
        let gap = |d: f64| {
            let near: f64 = lamp
                .rays_to(DVec3::Z * d)
                .map(|ray| ray.illuminance_lx(-DVec3::Z))
                .sum();
            near * d * d / 1e6 / lamp.far_field_cd(DVec3::Z) - 1.0
        };
        let exact = |d: f64| {
            [22.0f64, 28.0, 34.0]
                .iter()
                .map(|r| 1.0 / 3.0 * (1.0 + (r / d).powi(2)).powf(-0.5 * (5.3 + 3.0)))
                .sum::<f64>()
                - 1.0
        };
        for d in [150.0, 500.0, 2000.0] {
            assert!((gap(d) - exact(d)).abs() < 2e-6, "{d}: {} against {}", gap(d), exact(d));
        }
        assert!((gap(500.0) + 0.013).abs() < 5e-4 && (gap(150.0) + 0.135).abs() < 5e-4);
    }

    #[test]
    fn the_elliptic_lens_makes_a_second_harmonic_only() {
        let mut room = Darkroom::default();
        room.lamp.aim_spread_deg = 0.0;
        room.lamp.ellipticity_rel = 0.1;
        let lamp = Illuminator::new(&room.lamp, &room.injected_effects, 1);
        let gamma = 0.6f64;
        let at = |c_deg: f64| lamp.far_field_cd(direction(c_deg.to_radians(), gamma));
        let mean = 0.5 * (at(0.0) + at(90.0));
        assert!((at(0.0) / mean - 1.0 - 0.1 * gamma.sin().powi(2)).abs() < 1e-6);
        assert!((at(45.0) / mean - 1.0).abs() < 1e-6);
        assert!((at(180.0) / at(0.0) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn dimmed_leds_shift_the_light_centre_not_the_far_field() {
        let mut room = Darkroom::default();
        let whole = Illuminator::new(&room.lamp, &room.injected_effects, 1);
        room.injected_effects.dead_sector.depth_rel = 0.3;
        let dimmed = Illuminator::new(&room.lamp, &room.injected_effects, 1);
        let ratio = |c: f64| dimmed.far_field_cd(direction(c, 0.5)) / whole.far_field_cd(direction(c, 0.5));
        assert!(ratio(0.0) < 1.0);
        assert!((ratio(0.0) / ratio(std::f64::consts::PI) - 1.0).abs() < 2e-3);
        // With outward aim the same LEDs are missed in their own half-plane.
        room.lamp.aim_deg = -10.0;
        let aimed = Illuminator::new(&room.lamp, &room.injected_effects, 1);
        room.injected_effects.dead_sector.depth_rel = 0.0;
        let aimed_whole = Illuminator::new(&room.lamp, &room.injected_effects, 1);
        let ratio = |c: f64| aimed.far_field_cd(direction(c, 0.8)) / aimed_whole.far_field_cd(direction(c, 0.8));
        assert!(ratio(0.0) < ratio(std::f64::consts::PI) - 0.02);
    }

    #[test]
    fn a_disc_with_a_table_is_the_table_from_far_and_a_disc_from_near() {
        let mut room = Darkroom::default();
        let text = (0..=90).fold(format!("{}\n", crate::table::HEAD), |text, gamma| {
            text + &format!("0,{gamma},{}\n", 500.0 * f64::from(gamma).to_radians().cos().max(0.0))
        });
        room.lamp.luminous_diameter_mm = Some(200.0);
        room.lamp.intensities = Some(Arc::new(LampTable::parse(&text).unwrap()));
        let lamp = Illuminator::new(&room.lamp, &room.injected_effects, 1);
        let far = lamp.far_field_cd(direction(0.4, 0.7));
        assert!((far / (500.0 * 0.7f64.cos()) - 1.0).abs() < 1e-4, "{far}");
        assert_eq!(lamp.peak_cd(), 500.0);
        // A Lambertian disc of radius a lights a point on its axis by I / (d² + a²).
        let near = |d: f64| -> f64 {
            lamp.rays_to(DVec3::Z * d)
                .map(|ray| ray.illuminance_lx(-DVec3::Z))
                .sum()
        };
        for d in [150.0f64, 500.0, 2000.0] {
            let exact = 500.0e6 / (d * d + 100.0 * 100.0);
            assert!((near(d) / exact - 1.0).abs() < 3e-3, "{d}: {} against {exact}", near(d));
        }
        assert!(!lamp.may_light(DVec3::new(10.0, 0.0, -500.0)) && lamp.may_light(DVec3::new(10.0, 0.0, 500.0)));
    }

    #[test]
    fn a_lamp_with_a_seed_of_its_own_is_the_same_in_every_room() {
        let mut room = Darkroom::default();
        let of = |room: &Darkroom, seed| Illuminator::new(&room.lamp, &room.injected_effects, seed);
        assert_ne!(of(&room, 1), of(&room, 2));
        room.lamp.seed = 1;
        assert_eq!(of(&room, 1), of(&room, 2));
    }

    #[test]
    fn an_obstacle_takes_its_depth_in_its_direction() {
        let mut room = Darkroom::default();
        let open = Illuminator::new(&room.lamp, &room.injected_effects, 1);
        room.injected_effects.self_absorption = SelfAbsorption {
            depth_rel: 0.2,
            azimuth_deg: 90.0,
            gamma_deg: 40.0,
            width_deg: 20.0,
        };
        let shaded = Illuminator::new(&room.lamp, &room.injected_effects, 1);
        let ratio = |c_deg: f64, g_deg: f64| {
            let d = direction(c_deg.to_radians(), g_deg.to_radians());
            shaded.far_field_cd(d) / open.far_field_cd(d)
        };
        assert!((ratio(90.0, 40.0) - 0.8).abs() < 0.02);
        assert!((ratio(90.0, 50.0) - 0.9).abs() < 0.02);
        assert!((ratio(270.0, 40.0) - 1.0).abs() < 1e-4);
    }
}
