//! The signal of every bin of a set of sensor maps.

use glam::{DMat3, DVec2, DVec3};
use isolux_photometry::angles_deg;
use isolux_record::observation::{Cell, MapPose, MapSet, MapUnit};

use crate::effects::{Act, LampLaw, PairLaw, Pixel, Placement, Values};
use crate::model::Model;
use crate::pose::SensorPose;
use crate::prepared::PreparedModel;

/// A bin counts as a point where (side/distance)² is below this: its mean differs from its middle by about 0.7 times
/// that.
const POINT_LIKE: f64 = 5e-6;

/// The distance at which the peak intensity fills a sensor whose file gives no `full_scale` and whose unit is absolute.
const FULL_SCALE_DISTANCE_MM: f64 = 500.0;

type Law<'m, F> = Vec<(F, &'m Values)>;

/// The acts on maps, sorted by kind.
#[derive(Default)]
struct Chain<'m> {
    placement: Law<'m, fn(&Values, &mut Placement)>,
    lamp: Law<'m, LampLaw>,
    pixel: Law<'m, fn(&Values, &Pixel) -> f64>,
    background: Law<'m, PairLaw>,
    exposure: Law<'m, fn(&Values, f64) -> f64>,
    signal: Law<'m, fn(&Values, f64) -> f64>,
    zero: Law<'m, fn(&Values) -> f64>,
    readout: Law<'m, fn(&Values, f64) -> f64>,
    blur: Law<'m, fn(&Values) -> f64>,
}

impl<'m> Chain<'m> {
    fn new(model: &'m Model) -> Self {
        let mut chain = Self::default();
        for (act, values) in model.acts() {
            match *act {
                Act::Placement(law) => chain.placement.push((law, values)),
                Act::Lamp(law) => chain.lamp.push((law, values)),
                Act::Pixel(law) => chain.pixel.push((law, values)),
                Act::Background(law) => chain.background.push((law, values)),
                Act::Exposure(law) => chain.exposure.push((law, values)),
                Act::Signal(law) => chain.signal.push((law, values)),
                Act::SignalZero(law) => chain.zero.push((law, values)),
                Act::Readout(law) => chain.readout.push((law, values)),
                Act::Blur(law) => chain.blur.push((law, values)),
                _ => {}
            }
        }
        chain
    }
}

impl Model {
    /// The signal of every cell of `maps`, in its order and unit: the mean over the bin.
    ///
    /// Irradiance needs the model's spectrum or efficacy; without one, maps in W/m² are NaN: ask
    /// [`Model::ler_lm_per_w`] first.
    pub fn predict_maps(&self, maps: &MapSet) -> Vec<f64> {
        let chain = Chain::new(self);
        let prepared = PreparedModel::new(self);
        let ler = self.ler_lm_per_w();
        // From lx to the unit of the maps.
        let scale = match maps.unit() {
            MapUnit::Relative => self.refined().map_gain,
            MapUnit::Lux => 1.0,
            MapUnit::WattPerSquareMetre => ler.map_or(f64::NAN, f64::recip),
        };
        let full_scale = maps.full_scale().unwrap_or_else(|| match maps.unit() {
            MapUnit::Relative => 1.0,
            MapUnit::Lux | MapUnit::WattPerSquareMetre => {
                let peak_cd = self.luminaire().grid().peak().intensity_cd;
                peak_cd / (FULL_SCALE_DISTANCE_MM * FULL_SCALE_DISTANCE_MM) * 1e6 * scale
            }
        });
        let background_lx: f64 = chain
            .background
            .iter()
            .map(|(law, values)| {
                let (lx, w_m2) = law(values);
                lx + if w_m2 == 0.0 {
                    0.0
                } else {
                    w_m2 * ler.unwrap_or(f64::NAN)
                }
            })
            .sum();

        let mut signal = vec![0.0; maps.cells().len()];
        let mut of_map: Vec<Vec<usize>> = vec![Vec::new(); maps.maps().len()];
        for (index, cell) in maps.cells().iter().enumerate() {
            of_map[cell.map as usize].push(index);
        }
        for (map, indices) in maps.maps().iter().zip(&of_map) {
            let bench = Bench::new(&chain, &prepared, map, maps);
            let mut exposure = map.exposure;
            for (law, values) in &chain.exposure {
                exposure = law(values, exposure);
            }
            let lamp: f64 = chain.lamp.iter().map(|(law, values)| law(values, map.time_s)).product();
            let mut lights = vec![if map.capped { 0.0 } else { background_lx }; indices.len()];
            if map.lamp && !map.capped {
                let cells = indices.iter().map(|&index| {
                    let cell = &maps.cells()[index];
                    (
                        DVec2::from_array(maps.place_mm(index)),
                        [cell.ix as usize, cell.iy as usize],
                    )
                });
                let watts = |index: usize| {
                    let place = DVec2::from_array(maps.place_mm(index)).extend(0.0);
                    self.signal_of_a_lumen(maps.unit(), bench.rotation * place + bench.centre_mm)
                };
                let from_lamp = bench.lamp_lx(cells).into_iter().zip(indices);
                for (light_lx, (from_lamp_lx, &index)) in lights.iter_mut().zip(from_lamp) {
                    *light_lx += from_lamp_lx * lamp * watts(index);
                }
            }
            for (law, values) in &chain.blur {
                lights = blur(
                    &lights,
                    indices.iter().map(|&index| &maps.cells()[index]),
                    maps.bins(),
                    law(values),
                );
            }
            for (&index, light_lx) in indices.iter().zip(lights) {
                let mut share = light_lx * exposure * scale / full_scale;
                for (law, values) in &chain.signal {
                    share = law(values, share);
                }
                share += chain.zero.iter().map(|(law, values)| law(values)).sum::<f64>();
                for (law, values) in &chain.readout {
                    share = law(values, share);
                }
                signal[index] = share * full_scale;
            }
        }
        signal
    }

    /// Signal of a lumen of the light towards a place (mm, the luminaire's frame), over that on the axis: its watts, or
    /// what the sensor makes of its spectrum. A map in lx has none of it.
    fn signal_of_a_lumen(&self, unit: MapUnit, place_mm: DVec3) -> f64 {
        if unit == MapUnit::Lux {
            return 1.0;
        }
        let changed = self.watts_of_a_lumen(place_mm.z / place_mm.length());
        let Some(colour) = self.colour().filter(|_| unit == MapUnit::WattPerSquareMetre) else {
            return changed;
        };
        let (c_deg, gamma_deg) = angles_deg(place_mm);
        let axis = self.luminaire().ler_lm_per_w().unwrap_or(f64::NAN);
        changed * axis * colour.watt_per_lumen(c_deg, gamma_deg)
    }

    /// Where each cell truly is in the luminaire's frame (mm), the direction that meets it at right angles, and the
    /// signal of one lux there in the unit of the maps, the sensor's own factors apart; none where no light of the lamp
    /// comes.
    pub(crate) fn cell_places(&self, maps: &MapSet) -> Vec<Option<(DVec3, DVec3, f64)>> {
        let chain = Chain::default();
        let prepared = PreparedModel::new(self);
        let scale = match maps.unit() {
            MapUnit::Relative => self.refined().map_gain,
            MapUnit::Lux => 1.0,
            MapUnit::WattPerSquareMetre => self.ler_lm_per_w().map_or(f64::NAN, f64::recip),
        };
        let benches: Vec<Bench<'_>> = maps
            .maps()
            .iter()
            .map(|map| Bench::new(&chain, &prepared, map, maps))
            .collect();
        let place = |index: usize| {
            let number = maps.cells()[index].map as usize;
            let (map, bench) = (&maps.maps()[number], &benches[number]);
            let place = DVec2::from_array(maps.place_mm(index)).extend(0.0);
            (map.lamp && !map.capped).then(|| {
                let point_mm = bench.rotation * place + bench.centre_mm;
                let watts = self.signal_of_a_lumen(maps.unit(), point_mm);
                (
                    point_mm,
                    bench.facing,
                    scale * watts * map.exposure * self.lamp_factor(map.time_s),
                )
            })
        };
        (0..maps.cells().len()).map(place).collect()
    }

    /// The placement of a sensor with the effects on it: where it truly stands, and the source before it.
    pub fn placement(&self, pose: SensorPose) -> Placement {
        let mut placement = Placement {
            pose,
            luminaire_from_room: DMat3::IDENTITY,
        };
        for (act, values) in self.acts() {
            if let Act::Placement(law) = act {
                law(values, &mut placement);
            }
        }
        placement
    }

    /// Factor on the lamp's light at a place of a sensor: glass, acceptance, vignetting and the like.
    pub fn pixel_factor(&self, pixel: &Pixel) -> f64 {
        self.acts().fold(1.0, |factor, (act, values)| match act {
            Act::Pixel(law) => factor * law(values, pixel),
            _ => factor,
        })
    }

    /// Uniform light on a sensor that the effects add, in lx; `None` where it is given in W/m² and no efficacy is
    /// known.
    pub fn background_lx(&self) -> Option<f64> {
        let mut sum = 0.0;
        for (act, values) in self.acts() {
            if let Act::Background(law) = act {
                let (lx, w_m2) = law(values);
                sum += lx + if w_m2 == 0.0 { 0.0 } else { w_m2 * self.ler_lm_per_w()? };
            }
        }
        Some(sum)
    }
}

/// One sensor before the luminaire.
struct Bench<'a> {
    chain: &'a Chain<'a>,
    prepared: &'a PreparedModel<'a>,
    rotation: DMat3,
    centre_mm: DVec3,
    facing: DVec3,
    bin_mm: DVec2,
    bins: [usize; 2],
    size_mm: DVec2,
    /// The light in the middle of a bin is that of the whole bin.
    point_like: bool,
    /// The light has no edges at the directions of the file.
    smooth: bool,
}

/// A place within this share of a bin of its middle is the middle.
const SHARED: f64 = 1e-9;
/// Gauss–Legendre of order 2 along both sides, from the middle of a bin, in bins: 1/√12.
const INSIDE: [[f64; 2]; 4] = {
    const AT: f64 = 0.288_675_134_594_812_9;
    [[-AT, -AT], [AT, -AT], [-AT, AT], [AT, AT]]
};
/// Of a bin: before, after, below, above, in bins.
const NEIGHBOURS: [[isize; 2]; 4] = [[-1, 0], [1, 0], [0, -1], [0, 1]];

impl<'a> Bench<'a> {
    fn new(chain: &'a Chain<'a>, prepared: &'a PreparedModel<'a>, map: &MapPose, maps: &MapSet) -> Self {
        let pose = SensorPose {
            distance_mm: map.distance_mm,
            tilt_x_deg: map.tilt_x_deg,
            tilt_y_deg: map.tilt_y_deg,
            rot_z_deg: map.rot_z_deg,
            offset_mm: DVec2::from_array(map.offset_mm),
            mount_tilt_deg: [0.0; 2],
        };
        let mut placement = Placement {
            pose,
            luminaire_from_room: DMat3::IDENTITY,
        };
        for (law, values) in &chain.placement {
            law(values, &mut placement);
        }
        let turn = placement.luminaire_from_room;
        let size_mm = DVec2::from_array(maps.sensor_mm());
        let [nx, ny] = maps.bins();
        let bin_mm = size_mm / DVec2::new(nx as f64, ny as f64);
        let centre_mm = turn * placement.pose.centre_mm();
        let reach = bin_mm.max_element() / centre_mm.length();
        Self {
            chain,
            prepared,
            rotation: turn * placement.pose.rotation(),
            centre_mm,
            facing: -(turn * placement.pose.normal()),
            bin_mm,
            bins: [nx, ny],
            size_mm,
            point_like: reach * reach < POINT_LIKE,
            smooth: prepared.is_smooth(),
        }
    }

    /// Mean over every bin (its middle and its place among the bins) of the lamp's illuminance times the sensor's
    /// factors, the lamp being stable.
    ///
    /// Of a smooth luminaire the mean is the middle and 1/24 of the second differences along x and y: exact for cubic
    /// light, and most of the neighbours are bins themselves. One that is linear between its directions has edges there,
    /// which second differences would carry into the bins beside them: its mean is taken within the bin.
    fn lamp_lx(&self, bins: impl Iterator<Item = (DVec2, [usize; 2])>) -> Vec<f64> {
        let (middles, bins): (Vec<DVec2>, Vec<[usize; 2]>) = bins.unzip();
        if self.point_like {
            return self.at_places_lx(&middles);
        }
        if !self.smooth {
            let within = |middle: &DVec2| INSIDE.map(|from| *middle + self.bin_mm * DVec2::from_array(from));
            let places: Vec<DVec2> = middles.iter().flat_map(within).collect();
            let light_lx = self.at_places_lx(&places);
            return light_lx
                .chunks_exact(INSIDE.len())
                .map(|of_bin| of_bin.iter().sum::<f64>() / 4.0)
                .collect();
        }
        let mut places = middles;
        // With one bin more on each side.
        let across = self.bins[0] + 2;
        let number_at = |[ix, iy]: [usize; 2], [dx, dy]: [isize; 2]| {
            (iy + 1).wrapping_add_signed(dy) * across + (ix + 1).wrapping_add_signed(dx)
        };
        let mut number_of = vec![usize::MAX; across * (self.bins[1] + 2)];
        // A bin of which pixels are left out has its mean elsewhere, and neighbours of its own.
        let is_middle = |place: DVec2, [ix, iy]: [usize; 2]| {
            let middle = (DVec2::new(ix as f64, iy as f64) + 0.5) * self.bin_mm - 0.5 * self.size_mm;
            (place - middle).length() < SHARED * self.bin_mm.min_element()
        };
        let shared: Vec<bool> = places
            .iter()
            .zip(&bins)
            .map(|(place, bin)| is_middle(*place, *bin))
            .collect();
        for (number, bin) in bins.iter().enumerate().filter(|(number, _)| shared[*number]) {
            number_of[number_at(*bin, [0, 0])] = number;
        }
        let mut neighbours = Vec::with_capacity(bins.len());
        for (number, bin) in bins.iter().enumerate() {
            neighbours.push(NEIGHBOURS.map(|to| {
                let mut own = usize::MAX;
                let known = if shared[number] {
                    &mut number_of[number_at(*bin, to)]
                } else {
                    &mut own
                };
                if *known == usize::MAX {
                    *known = places.len();
                    places.push(places[number] + self.bin_mm * DVec2::new(to[0] as f64, to[1] as f64));
                }
                *known
            }));
        }
        let light_lx = self.at_places_lx(&places);
        let mean = |(middle, neighbours): (&f64, &[usize; 4])| {
            let sum: f64 = neighbours.iter().map(|&number| light_lx[number]).sum();
            middle + (sum - 4.0 * middle) / 24.0
        };
        light_lx.iter().zip(&neighbours).map(mean).collect()
    }

    fn at_places_lx(&self, places: &[DVec2]) -> Vec<f64> {
        let points_mm: Vec<DVec3> = places
            .iter()
            .map(|place| self.rotation * place.extend(0.0) + self.centre_mm)
            .collect();
        let seen = self.prepared.seen(&points_mm, self.facing);
        let mut illuminance_lx = self.prepared.illuminances_lx(&points_mm, self.facing, &seen);
        if !self.chain.pixel.is_empty() {
            for ((light, place), point_mm) in illuminance_lx.iter_mut().zip(places).zip(&points_mm) {
                let pixel = Pixel {
                    x_mm: place.x,
                    y_mm: place.y,
                    half_width_mm: 0.5 * self.size_mm.x,
                    cos_incidence: point_mm.dot(self.facing) / point_mm.length(),
                };
                for (law, values) in &self.chain.pixel {
                    *light *= law(values, &pixel);
                }
            }
        }
        illuminance_lx
    }
}

/// A Gaussian of standard deviation `width` bins over the bins of one map; beyond its edge the map goes on as it ends.
fn blur<'c>(lights: &[f64], cells: impl Iterator<Item = &'c Cell> + Clone, bins: [usize; 2], width: f64) -> Vec<f64> {
    if width == 0.0 {
        return lights.to_vec();
    }
    let [nx, ny] = bins;
    let mut grid = vec![f64::NAN; nx * ny];
    for (cell, light) in cells.clone().zip(lights) {
        grid[cell.iy as usize * nx + cell.ix as usize] = *light;
    }
    let reach = (4.0 * width).ceil() as isize;
    let kernel: Vec<f64> = (-reach..=reach)
        .map(|k| (-0.5 * (k as f64 / width).powi(2)).exp())
        .collect();
    let pass = |grid: &[f64], along_x: bool| -> Vec<f64> {
        let at = |ix: isize, iy: isize| {
            grid[iy.clamp(0, ny as isize - 1) as usize * nx + ix.clamp(0, nx as isize - 1) as usize]
        };
        let mut out = vec![f64::NAN; nx * ny];
        for iy in 0..ny as isize {
            for ix in 0..nx as isize {
                let (mut sum, mut weights) = (0.0, 0.0);
                for (weight, k) in kernel.iter().zip(-reach..=reach) {
                    let value = if along_x { at(ix + k, iy) } else { at(ix, iy + k) };
                    // Bins that the file leaves out lend nothing.
                    if value.is_finite() {
                        sum += weight * value;
                        weights += weight;
                    }
                }
                out[iy as usize * nx + ix as usize] = if weights > 0.0 { sum / weights } else { f64::NAN };
            }
        }
        out
    };
    let blurred = pass(&pass(&grid, true), false);
    cells
        .map(|cell| blurred[cell.iy as usize * nx + cell.ix as usize])
        .collect()
}
