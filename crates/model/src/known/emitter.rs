//! What is not known of where the light leaves a luminous area: what a measurement from far away does not see.

use isolux_photometry::{IntensityDistribution, direction};

use super::KnownError;
use crate::emitter::Emitter;
use crate::model::Model;
use crate::prepared::PreparedModel;
use crate::refined::Refined;

/// Rings of equal width into which a luminous area of stated diameter is divided. Their shares of the light are drawn
/// by a Dirichlet law whose mean is an even area and whose concentration is this: a thin ring and a point in the middle
/// lie two standard uncertainties away from it ([`luminous_area_rel`]).
const RINGS: usize = 4;
const CONCENTRATION: f64 = 0.5;
/// LEDs that stand for a ring.
const LEDS: usize = 12;
/// Standard uncertainty of the inward aim of the parts of a luminous area: those of ring lights lean by any angle of 0
/// to 10° (the range that `near_field` has, rms 10°/√3), and the far field does not show by how much; see [`aim_deg`].
const AIM_DEG: f64 = 5.8;
/// At most, in shares of the angle at which a lobe has half its light: parts that lean by much more make a beam with a
/// hole in its middle. By hand.
const AIM_OF_LOBE: f64 = 0.4;
/// Standard uncertainty of the square of the aim, in squares of [`aim_deg`]: √3 for a normal law.
const AIM_BEND: f64 = 1.732_050_807_568_877_2;
/// The same of the aim along a diameter against that across it: twenty-four LEDs whose aims differ by 1.5°.
const AIM_UNEVEN_DEG: f64 = 0.5;
/// Steps of C and γ at which two emitters' far fields are compared: what they differ by is as smooth as their lobes.
const STEP_DEG: [f64; 2] = [15.0, 2.5];
/// Largest factor between two emitters' far fields.
const MOST_CORRECTED: f64 = 1.5;
/// Relative amplitude of the light around the luminous area, in each of the first orders: twenty-four LEDs whose flux
/// differs by 5 %.
const AROUND_REL: f64 = 0.0145;
const AROUND_ORDERS: [f64; 2] = [1.0, 2.0];

/// Relative standard uncertainty of the light on the axis at `distance_mm` from a luminous area of which the diameter
/// alone is known, for a lobe of exponent n. The axis sees −½(n + 3)·r²/d², r² being the mean square radius; by the law
/// of the shares it is R²/2 with a standard deviation of R²/√(12·(1 + concentration)). Parts at r that lean inwards by ψ
/// add n·ψ·r/d.
pub fn luminous_area_rel(diameter_mm: f64, lobe_exponent: f64, distance_mm: f64) -> f64 {
    let reach = 0.5 * diameter_mm / distance_mm;
    let shares = 0.5 * (lobe_exponent + 3.0) * reach * reach / (12.0 * (1.0 + CONCENTRATION)).sqrt();
    let aim = lobe_exponent * aim_deg(lobe_exponent).to_radians() * reach / 2_f64.sqrt();
    shares.hypot(aim)
}

/// Standard uncertainty of the inward aim of parts whose lobe is cosⁿ, degrees.
fn aim_deg(lobe_exponent: f64) -> f64 {
    let half_deg = 0.5_f64.powf(1.0 / lobe_exponent).acos().to_degrees();
    AIM_DEG.min(AIM_OF_LOBE * half_deg)
}

impl Model {
    /// The same light at the distance at which it was measured, from another emitter.
    fn with_emitter(&self, emitter: Emitter, measured: Option<&Measured>) -> Self {
        let far = self.with_luminaire(self.luminaire().with_emitter(emitter.clone(), None));
        match measured.and_then(|measured| measured.factor(&far)) {
            Some(factor) => self.with_luminaire(self.luminaire().with_emitter(emitter, Some(factor))),
            None => far,
        }
    }

    /// Where in a luminous area of this diameter the light leaves, how its parts are aimed and how evenly they are lit:
    /// what a measurement from far away does not see. Nothing where the model has single LEDs, a ring or a rectangle:
    /// then somebody said where they are.
    pub(super) fn emitter_errors(&self, diameter_mm: f64) -> Vec<KnownError> {
        if let Some(rings) = self.effective_emitter() {
            // An effect says where its parts are; how even they are nobody said.
            return self.without_emitter_effects().unevenness(rings.extent_mm());
        }
        if !matches!(self.luminaire().emitter(), Emitter::Point {} | Emitter::Disc { .. }) {
            return Vec::new();
        }
        let measured = Measured::of(self);
        let measured = measured.as_ref();
        let mut known = Vec::new();
        for ring in 0..RINGS {
            let edge_mm = |k: usize| diameter_mm * k as f64 / RINGS as f64;
            let share = (edge_mm(ring + 1).powi(2) - edge_mm(ring).powi(2)) / diameter_mm.powi(2);
            let emitter = if ring == 0 {
                Emitter::Disc {
                    diameter_mm: edge_mm(1),
                }
            } else {
                Emitter::Ring {
                    inner_diameter_mm: edge_mm(ring),
                    outer_diameter_mm: edge_mm(ring + 1),
                }
            };
            let per_u = (share / (1.0 + CONCENTRATION)).sqrt();
            let u_share = (share * (1.0 - share) / (1.0 + CONCENTRATION)).sqrt();
            known.push(assumed(
                &format!(
                    "the share of the light from {:.0} to {:.0} mm of radius",
                    0.5 * edge_mm(ring),
                    0.5 * edge_mm(ring + 1)
                ),
                u_share,
                "",
                vec![(per_u, self.with_emitter(emitter, measured)), (-per_u, self.clone())],
            ));
        }
        known.extend(self.aim_errors(diameter_mm, measured));
        known.extend(self.unevenness(circles_mm(diameter_mm)[1]));
        known
    }

    /// Without the effects that say where the light leaves.
    fn without_emitter_effects(&self) -> Self {
        let others = self.effects().iter().filter(|effect| !effect.spec().replaces_emitter());
        self.with_effects(others.cloned().collect())
    }

    /// How evenly parts on a circle are lit around it, and how evenly they lean.
    fn unevenness(&self, radius_mm: f64) -> Vec<KnownError> {
        let measured = Measured::of(self);
        let measured = measured.as_ref();
        let mut known = Vec::new();
        for order in AROUND_ORDERS {
            for wave in [f64::cos, f64::sin] {
                let uneven = |amplitude: f64| {
                    let weight = |azimuth: f64| 1.0 + amplitude * wave(order * azimuth);
                    self.with_emitter(uneven_circle(radius_mm, weight), measured)
                };
                let change = vec![(1.0, uneven(AROUND_REL)), (-1.0, uneven(0.0))];
                known.push(assumed("how even the luminous area is", AROUND_REL, "", change));
            }
        }
        for from_deg in [0.0, 45.0] {
            let pair = |at_deg: f64, aim_deg: f64| {
                let place = |turn: f64| {
                    let (sin, cos) = (at_deg + turn).to_radians().sin_cos();
                    vec![radius_mm * cos, radius_mm * sin]
                };
                let emitter = Emitter::Leds {
                    position_mm: vec![place(0.0), place(180.0)],
                    weight: Vec::new(),
                    radius_mm: Vec::new(),
                    count: Vec::new(),
                    aim_deg,
                };
                self.with_emitter(emitter, measured)
            };
            let across = from_deg + 90.0;
            let change = vec![
                (0.25, pair(from_deg, AIM_UNEVEN_DEG)),
                (-0.25, pair(from_deg, -AIM_UNEVEN_DEG)),
                (-0.25, pair(across, AIM_UNEVEN_DEG)),
                (0.25, pair(across, -AIM_UNEVEN_DEG)),
            ];
            known.push(assumed("how evenly the parts lean", AIM_UNEVEN_DEG, "°", change));
        }
        known
    }

    /// The inward aim of the parts of a luminous area: on two circles that stand for an even area together, on one of
    /// them more than on the other, and its square.
    fn aim_errors(&self, diameter_mm: f64, measured: Option<&Measured>) -> Vec<KnownError> {
        let [inner_mm, outer_mm] = circles_mm(diameter_mm);
        let u_deg = aim_deg(self.luminaire().distribution().lobe_exponent());
        let circle = |radius_mm: f64, aim_deg: f64| {
            let emitter = Emitter::Leds {
                position_mm: Vec::new(),
                weight: Vec::new(),
                radius_mm: vec![radius_mm],
                count: vec![LEDS],
                aim_deg,
            };
            self.with_emitter(emitter, measured)
        };
        let lean = |factor: f64, radius_mm: f64| {
            let half = 0.5 * factor;
            [(half, circle(radius_mm, u_deg)), (-half, circle(radius_mm, -u_deg))]
        };
        let both = |inner: f64, outer: f64| [lean(inner, inner_mm), lean(outer, outer_mm)].concat();
        let bend = vec![
            (0.5 * AIM_BEND, circle(outer_mm, u_deg)),
            (0.5 * AIM_BEND, circle(outer_mm, -u_deg)),
            (-AIM_BEND, circle(outer_mm, 0.0)),
        ];
        vec![
            assumed("the inward aim of the parts", u_deg, "°", both(0.5, 0.5)),
            assumed("where the parts lean inwards", u_deg, "°", both(-1.0, 1.0)),
            assumed("the square of the inward aim", u_deg, "°", bend),
        ]
    }
}

/// Two circles that stand for an even area together: Gauss–Legendre of order 2 in the square of the radius.
fn circles_mm(diameter_mm: f64) -> [f64; 2] {
    [-1.0, 1.0].map(|sign| 0.5 * diameter_mm * (0.5 * (1.0 + sign / 3_f64.sqrt())).sqrt())
}

/// An error that the file does not state.
fn assumed(what: &str, u: f64, unit: &'static str, change: Vec<(f64, Model)>) -> KnownError {
    KnownError {
        what: what.to_owned(),
        u,
        unit,
        assumed: true,
        change,
    }
}

/// What the emitter of a model shows where its intensities were measured: another emitter that is to agree with that
/// measurement has another far field.
struct Measured {
    distance_mm: f64,
    c_deg: Vec<f64>,
    gamma_deg: Vec<f64>,
    illuminance_lx: Vec<f64>,
}

impl Measured {
    /// None where the file does not say at which distance it was measured.
    fn of(model: &Model) -> Option<Self> {
        let distribution = model.luminaire().distribution();
        let gamma_deg = distribution.gamma_deg();
        let (first, last) = (gamma_deg[0], gamma_deg[gamma_deg.len() - 1]);
        let steps = ((last - first) / STEP_DEG[1]).ceil().max(1.0);
        let planes = distribution.c_deg().len().min((360.0 / STEP_DEG[0]) as usize);
        let mut measured = Self {
            distance_mm: model.uncertainty()?.measured_at_mm.filter(|mm| *mm > 0.0)?,
            c_deg: (0..planes).map(|k| 360.0 * k as f64 / planes as f64).collect(),
            gamma_deg: (0..=steps as usize)
                .map(|k| first + (last - first) * k as f64 / steps)
                .collect(),
            illuminance_lx: Vec::new(),
        };
        measured.illuminance_lx = measured.shown_lx(model);
        Some(measured)
    }

    /// The light of the luminaire alone in every direction, `[ic * ng + ig]`.
    fn shown_lx(&self, model: &Model) -> Vec<f64> {
        let bare = model.with_effects(Vec::new()).with_refined(Refined::default());
        let prepared = PreparedModel::new(&bare);
        let directions = self
            .c_deg
            .iter()
            .flat_map(|c| self.gamma_deg.iter().map(move |gamma| (c, gamma)));
        let lux = |(c_deg, gamma_deg): (&f64, &f64)| {
            let out = direction(*c_deg, *gamma_deg);
            prepared.illuminance_lx(self.distance_mm * out, out)
        };
        directions.map(lux).collect()
    }

    /// By what the far field of `other` is to be multiplied in each direction to agree; none where there is nothing to
    /// be done.
    fn factor(&self, other: &Model) -> Option<IntensityDistribution> {
        // Where there is next to no light the one is many times the other, and it does not matter.
        let factor = |(own, other): (&f64, f64)| {
            let factor = own / other;
            if (1.0 / MOST_CORRECTED..=MOST_CORRECTED).contains(&factor) {
                factor
            } else {
                1.0
            }
        };
        let factors = self
            .illuminance_lx
            .iter()
            .zip(self.shown_lx(other))
            .map(factor)
            .collect();
        IntensityDistribution::new(self.c_deg.clone(), self.gamma_deg.clone(), factors).ok()
    }
}

/// LEDs evenly on a circle, weighted by their azimuth in rad.
fn uneven_circle(radius_mm: f64, weight: impl Fn(f64) -> f64) -> Emitter {
    let azimuths: Vec<f64> = (0..LEDS)
        .map(|led| std::f64::consts::TAU * led as f64 / LEDS as f64)
        .collect();
    Emitter::Leds {
        position_mm: azimuths
            .iter()
            .map(|at| vec![radius_mm * at.cos(), radius_mm * at.sin()])
            .collect(),
        weight: azimuths.iter().map(|at| weight(*at)).collect(),
        radius_mm: Vec::new(),
        count: Vec::new(),
        aim_deg: 0.0,
    }
}
