//! One goniometer reading: where the detector really is, what light reaches it, what the meter says.

use glam::DVec3;
use isolux_photometry::{angles_deg, direction};
use isolux_record::ReadingKind;
use isolux_record::observation::ReadingCoordinates;

use crate::attitude::Attitude;
use crate::effect::Effect;
use crate::effects::{Act, Axes, BelongsTo, DetectorView, LampLaw, Mounting, PairLaw, Values};
use crate::floor::OverFloor;
use crate::model::Model;
use crate::prepared::PreparedModel;

/// A reading with the bench's effects taken out: an intensity and the direction that it truly belongs to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CorrectedReading {
    /// Half-plane, in (−180, 180].
    pub c_deg: f64,
    /// Polar angle, not negative.
    pub gamma_deg: f64,
    /// From the light centre to the detector.
    pub distance_mm: f64,
    /// The illuminance that the light alone makes at the detector.
    pub illuminance_lx: f64,
    /// Luminous intensity in that direction.
    pub intensity_cd: f64,
}

/// An effect that cannot be taken out of a reading.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("effect `{effect}` has no inverse: it cannot be removed from readings")]
pub struct NoInverse {
    /// Its name.
    pub effect: &'static str,
}

type Law<F> = Vec<(F, usize)>;

/// The acts on readings, sorted by kind; values by index to keep the laws small.
struct Chain<'m> {
    values: Vec<&'m Values>,
    axes: Law<fn(&Values, &ReadingCoordinates, &mut Axes)>,
    mount: Law<fn(&Values, &mut Mounting)>,
    lamp: Law<LampLaw>,
    detector: Law<fn(&Values, &DetectorView) -> f64>,
    aperture: Law<fn(&Values) -> f64>,
    floor: Law<PairLaw>,
    ambient: Law<fn(&Values) -> f64>,
    response: Law<(Response, Response)>,
    zero: Law<fn(&Values) -> f64>,
}

type Response = fn(&Values, f64, &ReadingCoordinates) -> f64;

impl<'m> Chain<'m> {
    fn new(model: &'m Model) -> Self {
        let mut chain = Self {
            values: Vec::new(),
            axes: Vec::new(),
            mount: Vec::new(),
            lamp: Vec::new(),
            detector: Vec::new(),
            aperture: Vec::new(),
            floor: Vec::new(),
            ambient: Vec::new(),
            response: Vec::new(),
            zero: Vec::new(),
        };
        for (act, values) in model.acts() {
            let index = chain.values.len();
            match *act {
                Act::Axes(law) => chain.axes.push((law, index)),
                Act::Mount(law) => chain.mount.push((law, index)),
                Act::Lamp(law) => chain.lamp.push((law, index)),
                Act::Detector(law) => chain.detector.push((law, index)),
                Act::Aperture(law) => chain.aperture.push((law, index)),
                Act::Floor(law) => chain.floor.push((law, index)),
                Act::Ambient(law) => chain.ambient.push((law, index)),
                Act::Response { apply, invert } => chain.response.push(((apply, invert), index)),
                Act::Zero(law) => chain.zero.push((law, index)),
                _ => continue,
            }
            chain.values.push(values);
        }
        chain
    }

    fn axes(&self, at: &ReadingCoordinates) -> Axes {
        let mut axes = Axes {
            c_deg: at.c_deg,
            gamma_deg: at.gamma_deg,
            distance_mm: at.distance_mm,
            nonperp_deg: 0.0,
        };
        for (law, index) in &self.axes {
            law(self.values[*index], at, &mut axes);
        }
        axes
    }

    fn mounting(&self, axes: &Axes) -> Mounting {
        let facing = toward(axes);
        let mut mounting = Mounting {
            detector_mm: axes.distance_mm * facing,
            facing,
        };
        for (law, index) in &self.mount {
            law(self.values[*index], &mut mounting);
        }
        mounting
    }

    fn detector_factor(&self, axes: &Axes, mounting: &Mounting, head: u32) -> f64 {
        if self.detector.is_empty() {
            return 1.0;
        }
        let cos_incidence = mounting.detector_mm.normalize_or(mounting.facing).dot(mounting.facing);
        let view = DetectorView {
            c_deg: axes.c_deg,
            gamma_deg: axes.gamma_deg,
            cos_incidence,
            head,
        };
        self.detector
            .iter()
            .map(|(law, index)| law(self.values[*index], &view))
            .product()
    }

    fn direct_lx(&self, prepared: &PreparedModel<'_>, at: &ReadingCoordinates) -> f64 {
        let axes = self.axes(at);
        let mounting = self.mounting(&axes);
        let mut direct_lx = prepared.illuminance_lx(mounting.detector_mm, mounting.facing);
        for (law, index) in &self.aperture {
            let radius_mm = law(self.values[*index]);
            if radius_mm != 0.0 {
                let angle = radius_mm / axes.distance_mm;
                // The second term is the flat disc's: at its edge cos³ ε of the incidence.
                direct_lx += angle * angle * (laplacian(prepared, &mounting) / 8.0 - 0.75 * direct_lx);
            }
        }
        direct_lx * self.detector_factor(&axes, &mounting, at.head)
    }

    fn lamp_factor(&self, lamp_age_s: Option<f64>) -> f64 {
        self.lamp
            .iter()
            .map(|(law, index)| law(self.values[*index], lamp_age_s))
            .product()
    }

    fn ambient_lx(&self) -> f64 {
        self.ambient.iter().map(|(law, index)| law(self.values[*index])).sum()
    }

    fn zero_lx(&self) -> f64 {
        self.zero.iter().map(|(law, index)| law(self.values[*index])).sum()
    }
}

/// Direction of the detector in the luminaire frame, exact for a leaning axis.
fn toward(axes: &Axes) -> DVec3 {
    if axes.nonperp_deg == 0.0 {
        return direction(axes.c_deg, axes.gamma_deg);
    }
    Attitude::new(axes.c_deg, axes.gamma_deg, axes.nonperp_deg).luminaire_from_room(DVec3::X)
}

/// Second differences of I over the sphere at this step: the grid of a file is rarely finer.
const LAPLACE_STEP_DEG: f64 = 1.0;

impl Model {
    /// The illuminance in lx that the meter would show at each of these coordinates, noise apart.
    pub fn predict_readings(&self, readings: &[ReadingCoordinates]) -> Vec<f64> {
        let chain = Chain::new(self);
        let prepared = PreparedModel::new(self);
        let directions = self.directions();
        let gain = |head| self.refined().head_gain(head);
        let floor_lx = |at: &ReadingCoordinates| -> f64 {
            if chain.floor.is_empty() {
                return 0.0;
            }
            let Axes {
                c_deg,
                gamma_deg,
                distance_mm,
                nonperp_deg,
            } = chain.axes(at);
            let of_floor = |(law, index): &(PairLaw, usize)| {
                let (albedo, height_mm) = law(chain.values[*index]);
                let place = OverFloor {
                    c_deg,
                    gamma_deg,
                    nonperp_deg,
                    distance_mm,
                    stated_distance_mm: at.distance_mm,
                    height_mm,
                };
                let light = place.light(self.luminaire());
                let (c_deg, gamma_deg) = angles_deg(light.whence);
                // What was refitted changes this small light as it changes the direction that most of it takes.
                albedo * light.illuminance_lx * directions.factor(c_deg, gamma_deg)
            };
            chain.floor.iter().map(of_floor).sum()
        };

        readings
            .iter()
            .map(|at| {
                let mut light_lx = match at.kind {
                    ReadingKind::Lit => {
                        let direct_lx = chain.direct_lx(&prepared, at);
                        (direct_lx + floor_lx(at)) * chain.lamp_factor(at.lamp_age_s()) + chain.ambient_lx()
                    }
                    ReadingKind::Baffled => floor_lx(at) * chain.lamp_factor(at.lamp_age_s()) + chain.ambient_lx(),
                    ReadingKind::LampOff => chain.ambient_lx(),
                    ReadingKind::Capped => 0.0,
                };
                for ((apply, _), index) in &chain.response {
                    light_lx = apply(chain.values[*index], light_lx, at);
                }
                (light_lx + chain.zero_lx()) * gain(at.head)
            })
            .collect()
    }

    /// Where the detector truly is in the luminaire's frame (mm), and the direction that meets it at right angles.
    pub(crate) fn detector_places(&self, readings: &[ReadingCoordinates]) -> Vec<(DVec3, DVec3)> {
        let chain = Chain::new(self);
        let place = |at: &ReadingCoordinates| {
            let mounting = chain.mounting(&chain.axes(at));
            (mounting.detector_mm, mounting.facing)
        };
        readings.iter().map(place).collect()
    }

    /// The illuminance in lx that the meter would show at one coordinate. For many, [`Model::predict_readings`] is
    /// quicker.
    pub fn predict_reading(&self, at: &ReadingCoordinates) -> f64 {
        self.predict_readings(std::slice::from_ref(at))[0]
    }

    /// Takes the bench's effects out of a lit reading: the intensity and the direction that it belongs to.
    ///
    /// Effects of the luminaire, the path and the sensor stay: they are no property of the bench.
    ///
    /// # Errors
    /// [`NoInverse`] names the first effect that cannot be taken out.
    pub fn correct_reading(&self, at: &ReadingCoordinates, reading_lx: f64) -> Result<CorrectedReading, NoInverse> {
        self.correct_readings(std::slice::from_ref(at), &[reading_lx])
            .map(|corrected| corrected[0])
    }

    /// As [`Model::correct_reading`], for many.
    ///
    /// # Errors
    /// [`NoInverse`] names the first effect that cannot be taken out.
    pub fn correct_readings(
        &self,
        at: &[ReadingCoordinates],
        reading_lx: &[f64],
    ) -> Result<Vec<CorrectedReading>, NoInverse> {
        for effect in self.effects() {
            if !effect.is_null() && effect.acts().any(|(act, _)| matches!(act, Act::Aperture(_))) {
                return Err(NoInverse { effect: effect.name() });
            }
        }
        let chain = Chain::new(self);
        let gain = |head| self.refined().head_gain(head);
        // The floor's light is what the model says it is; everything else is turned around.
        let floor_only: Vec<_> = self
            .effects()
            .iter()
            .filter(|effect| !is_luminaires(effect))
            .cloned()
            .collect();
        let floor_lx = if chain.floor.is_empty() {
            vec![0.0; at.len()]
        } else {
            let baffled: Vec<_> = at
                .iter()
                .map(|at| ReadingCoordinates {
                    kind: ReadingKind::Baffled,
                    ..*at
                })
                .collect();
            let keep: Vec<_> = floor_only
                .into_iter()
                .filter(|effect| {
                    effect
                        .acts()
                        .any(|(act, _)| matches!(act, Act::Floor(_) | Act::Axes(_)))
                })
                .collect();
            self.with_effects(keep).predict_readings(&baffled)
        };
        let corrected = at
            .iter()
            .zip(reading_lx)
            .zip(floor_lx)
            .map(|((at, reading_lx), floor_lx)| {
                let mut light_lx = reading_lx / gain(at.head) - chain.zero_lx();
                for ((_, invert), index) in chain.response.iter().rev() {
                    light_lx = invert(chain.values[*index], light_lx, at);
                }
                let axes = chain.axes(at);
                let mounting = chain.mounting(&axes);
                let detector = chain.detector_factor(&axes, &mounting, at.head);
                let direct_lx = (light_lx - chain.ambient_lx() - floor_lx) / detector;
                let distance_mm = mounting.detector_mm.length();
                let cos_incidence = mounting.detector_mm.dot(mounting.facing) / distance_mm;
                let (c_deg, gamma_deg) = angles_deg(mounting.detector_mm);
                let illuminance_lx = direct_lx / cos_incidence;
                let intensity_cd = illuminance_lx * distance_mm * distance_mm * 1e-6;
                CorrectedReading {
                    c_deg,
                    gamma_deg,
                    distance_mm,
                    illuminance_lx,
                    intensity_cd,
                }
            });
        Ok(corrected.collect())
    }
}

fn is_luminaires(effect: &Effect) -> bool {
    effect.spec().belongs_to(BelongsTo::Luminaire)
}

/// ∇²E over the sphere of directions, by second differences in two perpendicular great circles.
fn laplacian(prepared: &PreparedModel<'_>, mounting: &Mounting) -> f64 {
    let distance_mm = mounting.detector_mm.length();
    let centre = mounting.detector_mm / distance_mm;
    let aside = centre.any_orthonormal_vector();
    let across = centre.cross(aside);
    let step = LAPLACE_STEP_DEG.to_radians();
    let at = |tangent: DVec3| {
        let direction = step.cos() * centre + step.sin() * tangent;
        prepared.illuminance_lx(distance_mm * direction, direction)
    };
    let here = prepared.illuminance_lx(mounting.detector_mm, centre);
    (at(aside) + at(-aside) + at(across) + at(-across) - 4.0 * here) / (step * step)
}
