//! The three-dimensional view of a lit sensor: illuminator, photometric solid, sensor with its map, and rays that can
//! be turned, followed and filtered by wavelength. Drawn by WebGL through the vendored regl 2.1.1 (MIT,
//! `regl-2.1.1.min.js`, byte for byte as its package has it), and on a 2-D canvas where there is no WebGL, so that a
//! report opens anywhere.

pub mod explorer;

use isolux_photometry::IntensityDistribution;
use serde::Serialize;

use crate::map::{Map, viridis};
use crate::svg::data_uri;

/// A ray from the emitter to the sensor, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Where it leaves.
    pub origin_mm: [f64; 3],
    /// Where it meets the sensor.
    pub end_mm: [f64; 3],
    /// Pixel along x and y.
    pub pixel: [usize; 2],
    /// Its wavelength, where a spectrum is known.
    pub wavelength_nm: Option<f64>,
}

/// What is shown, in the luminaire frame.
#[derive(Debug, Clone)]
pub struct View<'a> {
    /// Far field; its shape is drawn as a solid.
    pub distribution: &'a IntensityDistribution,
    /// Outlines of the emitter's parts, mm.
    pub emitter_mm: Vec<Vec<[f64; 3]>>,
    /// Corners of the sensor: (0, 0), (nx, 0), (nx, ny), (0, ny), mm.
    pub corners_mm: [[f64; 3]; 4],
    /// Its map.
    pub map: Map<'a>,
    /// Rays, a few hundred.
    pub rays: Vec<Ray>,
}

#[derive(Serialize)]
struct Scene {
    reach: f64,
    emitter: Vec<Vec<[f64; 3]>>,
    solid: Vec<Quad>,
    corners: [[f64; 3]; 4],
    picture: String,
    cells: Vec<Cell>,
    rays: Vec<RayRow>,
}

#[derive(Serialize)]
struct Quad {
    points: [[f64; 3]; 4],
}

#[derive(Serialize)]
struct Cell {
    points: [[f64; 3]; 4],
    colour: String,
}

#[derive(Serialize)]
struct RayRow {
    a: [f64; 3],
    b: [f64; 3],
    nm: Option<f64>,
    pixel: [usize; 2],
}

/// Cells of the map along each side, on the 2-D canvas.
const SIDE: usize = 24;
/// Points of the map's picture along its longer side.
const PICTURE: usize = 256;

/// The library that draws: for [`crate::html::Page::library`], before any view's own script. The one address in it,
/// part of a message, is left out, so that a page names nothing outside itself.
pub fn library() -> String {
    include_str!("regl-2.1.1.min.js").replace(" http://get.webgl.org", "")
}

impl View<'_> {
    /// The elements of the view, for [`crate::html::Page::raw`]. `id` is unique in the page.
    pub fn html(&self, id: &str) -> String {
        format!(
            r#"<div class="viewer" id="{id}"><div style="position:relative;border:1px solid #d9dee4;line-height:0"><canvas class="gl" width="1100" height="620" style="width:100%;position:absolute;left:0;top:0"></canvas><canvas class="pen" width="1100" height="620" style="width:100%;position:relative;touch-action:none;cursor:grab"></canvas></div>
<p class="mode"></p>
<p><button name="reset">oblique</button> <button name="lamp">as the lamp sees it</button> <button name="side">from the side</button> <button name="sensor">at the sensor</button>
<label><input type="checkbox" name="solid" checked> photometric solid</label> <label><input type="checkbox" name="map" checked> map</label> <label><input type="checkbox" name="rays" checked> rays</label>
<label>from <input type="range" class="low" min="360" max="830" value="360"></label> <label>to <input type="range" class="high" min="360" max="830" value="830"></label> <span class="band"></span></p>
<p class="ray-note"></p></div>"#
        )
    }

    /// The script that fills it, for [`crate::html::Page::script`].
    ///
    /// # Errors
    /// When a number cannot be written as JSON.
    pub fn script(&self, id: &str) -> Result<String, serde_json::Error> {
        let scene = serde_json::to_string(&self.scene())?;
        let code = include_str!("viewer.js").trim_end();
        Ok(format!("{code}({scene}, document.getElementById(\"{id}\"));"))
    }

    fn scene(&self) -> Scene {
        let length = |p: &[f64; 3]| p.iter().map(|v| v * v).sum::<f64>().sqrt();
        let reach = self.corners_mm.iter().map(length).fold(1.0, f64::max);
        let rays = self
            .rays
            .iter()
            .map(|ray| RayRow {
                a: rounded(ray.origin_mm),
                b: rounded(ray.end_mm),
                nm: ray.wavelength_nm.map(|nm| (nm * 10.0).round() / 10.0),
                pixel: ray.pixel,
            })
            .collect();
        Scene {
            reach,
            emitter: self.emitter_mm.clone(),
            solid: self.solid(0.35 * reach),
            corners: self.corners_mm.map(rounded),
            picture: data_uri(&self.map.bare_png(PICTURE)),
            cells: self.cells(),
            rays,
        }
    }

    /// The photometric solid with `size` mm at its peak, every 15° in C and 5° in γ.
    fn solid(&self, size: f64) -> Vec<Quad> {
        let peak = self.distribution.peak().intensity_cd;
        if peak <= 0.0 {
            return Vec::new();
        }
        let at = |c: f64, gamma: f64| {
            let radius = size * self.distribution.intensity_cd_at(c, gamma).max(0.0) / peak;
            let ((sin_c, cos_c), (sin, cos)) = (c.to_radians().sin_cos(), gamma.to_radians().sin_cos());
            rounded([radius * sin * cos_c, radius * sin * sin_c, radius * cos])
        };
        let mut quads = Vec::new();
        for ic in 0..24 {
            for ig in 0..36 {
                let (c, g) = (15.0 * f64::from(ic), 5.0 * f64::from(ig));
                let points = [at(c, g), at(c, g + 5.0), at(c + 15.0, g + 5.0), at(c + 15.0, g)];
                if points.iter().flatten().any(|v| v.abs() > 1e-3 * size) {
                    quads.push(Quad { points });
                }
            }
        }
        quads
    }

    /// The map as coloured cells on the sensor.
    fn cells(&self) -> Vec<Cell> {
        let (low, high) = self.map.range();
        let [origin, right, _, up] = self.corners_mm;
        let place = |s: f64, t: f64| {
            rounded(std::array::from_fn(|k| {
                origin[k] + s * (right[k] - origin[k]) + t * (up[k] - origin[k])
            }))
        };
        let (nx, ny) = (SIDE.min(self.map.nx), SIDE.min(self.map.ny));
        let mut cells = Vec::new();
        for iy in 0..ny {
            for ix in 0..nx {
                let (mut sum, mut count) = (0.0, 0.0);
                for y in iy * self.map.ny / ny..(iy + 1) * self.map.ny / ny {
                    for x in ix * self.map.nx / nx..(ix + 1) * self.map.nx / nx {
                        sum += f64::from(self.map.values[y * self.map.nx + x]);
                        count += 1.0;
                    }
                }
                let [r, g, b] = viridis((sum / count - low) / (high - low));
                let at = |x: usize, y: usize| place(x as f64 / nx as f64, y as f64 / ny as f64);
                cells.push(Cell {
                    points: [at(ix, iy), at(ix + 1, iy), at(ix + 1, iy + 1), at(ix, iy + 1)],
                    colour: format!("rgb({r},{g},{b})"),
                });
            }
        }
        cells
    }
}

/// Micrometres are enough for a picture.
fn rounded(p: [f64; 3]) -> [f64; 3] {
    p.map(|v| (v * 1000.0).round() / 1000.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scene_holds_what_it_shows() {
        let distribution = IntensityDistribution::new(vec![0.0], vec![0.0, 90.0], vec![100.0, 0.0]).unwrap();
        let values = [1.0, 2.0, 3.0, 4.0];
        let map = Map {
            values: &values,
            nx: 2,
            ny: 2,
            size_mm: [20.0; 2],
            quantity: "irradiance",
            unit: "W/m²",
            u: None,
        };
        let ray = Ray {
            origin_mm: [0.0; 3],
            end_mm: [1.0, 2.0, 500.0],
            pixel: [1, 1],
            wavelength_nm: Some(455.0),
        };
        let view = View {
            distribution: &distribution,
            emitter_mm: vec![vec![[0.0; 3]; 3]],
            corners_mm: [
                [-10.0, -10.0, 500.0],
                [10.0, -10.0, 500.0],
                [10.0, 10.0, 500.0],
                [-10.0, 10.0, 500.0],
            ],
            map,
            rays: vec![ray],
        };
        let scene = view.scene();
        assert_eq!(scene.cells.len(), 4);
        // Row 0 is the smallest y.
        assert_eq!(scene.cells[0].points[0], [-10.0, -10.0, 500.0]);
        assert!(scene.solid.len() > 100);
        assert!(!library().contains("http") && library().len() > 80_000);
        assert!(scene.picture.starts_with("data:image/png;base64,"));
        assert!(view.html("v").contains("id=\"v\"") && view.script("v").unwrap().contains("455"));
    }
}
