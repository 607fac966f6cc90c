//! The luminaire classification system for outdoor luminaires (IES TM-15-11) and its backlight and uplight ratings.
//!
//! Forward light lies in the half-planes within 90° of the street side, back light in the others; both are cut at γ
//! 30°, 60°, 80° and 90°. The limits of B and U are those of Addendum A of TM-15-11. Those of the glare rating are not
//! in here: no source could be found for them that agrees with another.

use crate::{IntensityDistribution, Sector};

/// One of the ten parts of the sphere of TM-15-11.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LcsZone {
    /// Forward light, low: γ 0–30°.
    Fl,
    /// Forward light, mid: γ 30–60°.
    Fm,
    /// Forward light, high: γ 60–80°.
    Fh,
    /// Forward light, very high: γ 80–90°.
    Fvh,
    /// Back light, low.
    Bl,
    /// Back light, mid.
    Bm,
    /// Back light, high.
    Bh,
    /// Back light, very high.
    Bvh,
    /// Uplight, low: γ 90–100°.
    Ul,
    /// Uplight, high: γ 100–180°.
    Uh,
}

impl LcsZone {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::Fl,
        Self::Fm,
        Self::Fh,
        Self::Fvh,
        Self::Bl,
        Self::Bm,
        Self::Bh,
        Self::Bvh,
        Self::Ul,
        Self::Uh,
    ];

    /// Its abbreviation.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Fl => "FL",
            Self::Fm => "FM",
            Self::Fh => "FH",
            Self::Fvh => "FVH",
            Self::Bl => "BL",
            Self::Bm => "BM",
            Self::Bh => "BH",
            Self::Bvh => "BVH",
            Self::Ul => "UL",
            Self::Uh => "UH",
        }
    }

    /// Its part of the sphere, with the street at C = `street_side_c_deg`.
    pub const fn sector(self, street_side_c_deg: f64) -> Sector {
        let gamma_deg = match self {
            Self::Fl | Self::Bl => [0.0, 30.0],
            Self::Fm | Self::Bm => [30.0, 60.0],
            Self::Fh | Self::Bh => [60.0, 80.0],
            Self::Fvh | Self::Bvh => [80.0, 90.0],
            Self::Ul => [90.0, 100.0],
            Self::Uh => [100.0, 180.0],
        };
        let (before_deg, c_width_deg) = match self {
            Self::Fl | Self::Fm | Self::Fh | Self::Fvh => (-90.0, 180.0),
            Self::Bl | Self::Bm | Self::Bh | Self::Bvh => (90.0, 180.0),
            Self::Ul | Self::Uh => (-90.0, 360.0),
        };
        Sector {
            c_from_deg: street_side_c_deg + before_deg,
            c_width_deg,
            gamma_deg,
        }
    }
}

/// Luminous flux of every zone of [`LcsZone`], in lumen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ZonalFlux([f64; 10]);

impl ZonalFlux {
    /// Of a distribution that has the street at C = `street_side_c_deg`.
    pub fn of(light: &IntensityDistribution, street_side_c_deg: f64) -> Self {
        Self(LcsZone::ALL.map(|zone| light.sector_flux_lm(&zone.sector(street_side_c_deg))))
    }

    /// Flux of one zone, in lumen.
    pub fn lm(&self, zone: LcsZone) -> f64 {
        self.0[zone as usize]
    }

    /// Towards the street, below the horizontal, in lumen.
    pub fn forward_lm(&self) -> f64 {
        self.0[..4].iter().sum()
    }

    /// Away from it, below the horizontal, in lumen.
    pub fn back_lm(&self) -> f64 {
        self.0[4..8].iter().sum()
    }
}

/// Largest flux in lm of the ratings 0 to 4 (TM-15-11, Addendum A): BH and BL, BM, UL and UH.
const BH_BL_LM: [f64; 5] = [110.0, 500.0, 1000.0, 2500.0, 5000.0];
const BM_LM: [f64; 5] = [220.0, 1000.0, 2500.0, 5000.0, 8500.0];
const UL_UH_LM: [f64; 5] = [0.0, 10.0, 50.0, 500.0, 1000.0];

/// Backlight rating B, 0 to 5, of the flux of BL, BM and BH in lumen: the worst of the three.
pub fn backlight_rating(bl_lm: f64, bm_lm: f64, bh_lm: f64) -> usize {
    let rated = [
        rating(bl_lm, &BH_BL_LM),
        rating(bm_lm, &BM_LM),
        rating(bh_lm, &BH_BL_LM),
    ];
    rated.into_iter().max().unwrap_or(0)
}

/// Uplight rating U, 0 to 5, of the flux of UL and UH in lumen: the worse of the two. Zero is no light at all.
pub fn uplight_rating(ul_lm: f64, uh_lm: f64) -> usize {
    rating(ul_lm, &UL_UH_LM).max(rating(uh_lm, &UL_UH_LM))
}

/// How many limits are exceeded.
fn rating(lm: f64, limits_lm: &[f64; 5]) -> usize {
    limits_lm.iter().take_while(|limit| lm > **limit).count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn of(c_deg: Vec<f64>, f: impl Fn(f64, f64) -> f64) -> IntensityDistribution {
        let gamma_deg: Vec<f64> = (0..=720).map(|step| 0.25 * f64::from(step)).collect();
        let pairs = c_deg.iter().flat_map(|c| gamma_deg.iter().map(|gamma| f(*c, *gamma)));
        let intensity_cd = pairs.collect();
        IntensityDistribution::new(c_deg, gamma_deg, intensity_cd).unwrap()
    }

    #[test]
    fn zones_of_a_flat_emitter_and_of_a_sphere_are_those_of_the_integrals() {
        // I = cos γ: half of the circle from a to b is π/2·(sin²b − sin²a).
        let flat = of(vec![0.0], |_, gamma: f64| 100.0 * gamma.to_radians().cos().max(0.0));
        let zones = ZonalFlux::of(&flat, 90.0);
        let half = |a: f64, b: f64| 50.0 * PI * (b.to_radians().sin().powi(2) - a.to_radians().sin().powi(2));
        let edges = [(0.0, 30.0), (30.0, 60.0), (60.0, 80.0), (80.0, 90.0)];
        for (place, (a, b)) in edges.into_iter().chain(edges).enumerate() {
            let zone = LcsZone::ALL[place];
            let relative = zones.lm(zone) / half(a, b) - 1.0;
            assert!(relative.abs() < 1e-4, "{}: {relative}", zone.name());
        }
        assert!(
            zones.lm(LcsZone::Ul) < 1e-3 && zones.lm(LcsZone::Uh) == 0.0,
            "{zones:?}"
        );
        let sphere = ZonalFlux::of(&of(vec![0.0, 120.0, 240.0], |_, _| 1.0), 17.0);
        let band = |a: f64, b: f64| 2.0 * PI * (a.to_radians().cos() - b.to_radians().cos());
        assert!((sphere.lm(LcsZone::Uh) - band(100.0, 180.0)).abs() < 1e-9);
        assert!((sphere.lm(LcsZone::Ul) - band(90.0, 100.0)).abs() < 1e-9);
        assert!((sphere.lm(LcsZone::Bh) - 0.5 * band(60.0, 80.0)).abs() < 1e-9);
    }

    #[test]
    fn the_street_side_says_which_half_is_forward() {
        // All light around C90, as road luminaires have it in EULUMDAT.
        let c_deg: Vec<f64> = (0..72).map(|plane| 5.0 * f64::from(plane)).collect();
        let road = of(c_deg, |c, _| (c - 90.0).to_radians().cos().max(0.0));
        let share = |street| {
            let zones = ZonalFlux::of(&road, street);
            zones.forward_lm() / (zones.forward_lm() + zones.back_lm())
        };
        assert!((share(90.0) - 1.0).abs() < 1e-9, "{}", share(90.0));
        assert!(share(270.0).abs() < 1e-9, "{}", share(270.0));
        assert!((share(0.0) - 0.5).abs() < 1e-9, "{}", share(0.0));
    }

    /// Rows of B and U of another program (eulumdat 0.7.0, bug_rating.rs, read and not copied), at and above the
    /// limits.
    #[test]
    fn the_worst_zone_rates() {
        for (rating, [bl, bm, bh]) in [[110.0, 220.0, 110.0], [500.0, 1000.0, 500.0], [1000.0, 2500.0, 1000.0]]
            .into_iter()
            .enumerate()
        {
            assert_eq!(backlight_rating(bl, bm, bh), rating);
            for [bl, bm, bh] in [[bl + 0.1, bm, bh], [bl, bm + 0.1, bh], [bl, bm, bh + 0.1]] {
                assert_eq!(backlight_rating(bl, bm, bh), rating + 1, "{bl} {bm} {bh}");
            }
        }
        assert_eq!(backlight_rating(5000.0, 8500.0, 5000.0), 4);
        assert_eq!(backlight_rating(0.0, 8501.0, 0.0), 5);
        for (lm, rating) in [
            (0.0, 0),
            (0.01, 1),
            (10.0, 1),
            (50.0, 2),
            (500.0, 3),
            (1000.0, 4),
            (1001.0, 5),
        ] {
            assert_eq!((uplight_rating(lm, 0.0), uplight_rating(0.0, lm)), (rating, rating));
        }
    }
}
