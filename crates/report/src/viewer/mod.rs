//! What a browser draws of a lit sensor, one set of modules for the report and for the page: `map.js`, a map to look
//! into, on a 2-D canvas; `stage.js` and `scene.js`, three dimensions by the vendored three 0.187.0 (MIT, `vendor/`).
//!
//! A report is one file that fetches nothing: it holds the modules as they are, and the library compressed, which the
//! browser unpacks. Where there is no WebGL the library's SVG renderer draws the same scene.

pub mod explorer;

use std::io::Write as _;
use std::sync::LazyLock;

use base64::Engine as _;
use flate2::Compression;
use flate2::write::GzEncoder;
use isolux_photometry::IntensityDistribution;
use serde::Serialize;

use crate::html::Page;
use crate::map::Map;
use crate::svg::data_uri;

/// `map.js`: `SensorMap`.
pub const MAP: &str = include_str!("map.js");
/// The style of what the modules make.
pub const STYLE: &str = include_str!("viewer.css");
/// `stage.js`: `Stage` and the photometric solid.
pub const STAGE: &str = include_str!("stage.js");
/// The library of `stage.js`.
pub const THREE: &str = include_str!("vendor/three.min.js");
const SCENE: &str = include_str!("scene.js");

/// Modules as one, followed by `call`: inside one file nothing is imported by its address.
fn inlined(modules: &[&str], call: &str) -> String {
    let lines = modules.iter().flat_map(|module| module.lines());
    let own = lines.filter(|line| !line.starts_with("import "));
    own.chain([call]).flat_map(|line| [line, "\n"]).collect()
}

/// The library for [`Page::data`]: gzip in base64.
static PACKED: LazyLock<String> = LazyLock::new(|| {
    let mut gzip = GzEncoder::new(Vec::new(), Compression::best());
    // Writing to memory cannot fail.
    let _ = gzip.write_all(THREE.as_bytes());
    base64::engine::general_purpose::STANDARD.encode(gzip.finish().unwrap_or_default())
});

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
    solid: Solid,
    corners: [[f64; 3]; 4],
    picture: String,
    rays: Vec<RayRow>,
}

/// A distribution as half-planes of γ: what a photometric solid is drawn from.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Solid {
    /// C in degrees.
    pub c_deg: Vec<f64>,
    /// γ in degrees.
    pub gamma_deg: Vec<f64>,
    /// Intensity in cd, half-plane by half-plane.
    pub intensity_cd: Vec<f64>,
}

impl Solid {
    /// Every 15° in C and 5° in γ: enough for the eye.
    fn coarse(distribution: &IntensityDistribution) -> Self {
        let steps = |count: u32, step: f64| -> Vec<f64> { (0..count).map(|k| step * f64::from(k)).collect() };
        let (c_deg, gamma_deg) = (steps(24, 15.0), steps(37, 5.0));
        let at = |c: f64, gamma: f64| (1000.0 * distribution.intensity_cd_at(c, gamma)).round() / 1000.0;
        let intensity_cd = c_deg
            .iter()
            .flat_map(|c| gamma_deg.iter().map(move |gamma| at(*c, *gamma)));
        Self {
            intensity_cd: intensity_cd.collect(),
            c_deg,
            gamma_deg,
        }
    }
}

#[derive(Serialize)]
struct RayRow {
    a: [f64; 3],
    b: [f64; 3],
    nm: Option<f64>,
    pixel: [usize; 2],
}

/// Points of the map's picture along its longer side.
const PICTURE: usize = 256;

/// Unpacks the library, which the page holds as data, and calls the scene with it.
const UNPACK: &str = r#"
const packed = Uint8Array.from(atob(document.getElementById("three").textContent), (letter) => letter.charCodeAt(0));
const unpacked = await new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"))).text();
const three = await import(URL.createObjectURL(new Blob([unpacked], { type: "text/javascript" })));
"#;

impl View<'_> {
    /// Adds the view to `page`; `id` is unique in it.
    ///
    /// # Errors
    /// When a number cannot be written as JSON.
    pub fn add(&self, page: &mut Page, id: &str) -> Result<(), serde_json::Error> {
        page.raw(&format!(
            r#"<div class="viewer" id="{id}"><div class="stage" tabindex="0" role="group" aria-label="The scene in three dimensions, turned by the arrow keys"></div>
<p class="mode"></p>
<p><button name="reset">oblique</button> <button name="lamp">as the lamp sees it</button> <button name="side">from the side</button> <button name="sensor">at the sensor</button>
<label><input type="checkbox" name="solid" checked> photometric solid</label> <label><input type="checkbox" name="map" checked> map</label> <label><input type="checkbox" name="rays" checked> rays</label>
<label>from <input type="range" class="low" min="360" max="830" value="360"></label> <label>to <input type="range" class="high" min="360" max="830" value="830"></label> <span class="band"></span></p>
<p class="ray-note"></p></div>"#
        ));
        page.data("three", &PACKED);
        let scene = serde_json::to_string(&self.scene())?;
        let call = format!("{UNPACK}await showScene(three, {scene}, document.getElementById(\"{id}\"));");
        page.module(&inlined(&[STAGE, SCENE], &call));
        Ok(())
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
            solid: Solid::coarse(self.distribution),
            corners: self.corners_mm.map(rounded),
            picture: data_uri(&self.map.bare_png(PICTURE)),
            rays,
        }
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
        assert!(scene.picture.starts_with("data:image/png;base64,"));
        // C 30°, γ 45°: half of the way from 100 cd to none.
        assert_eq!(scene.solid.intensity_cd[2 * 37 + 9], 50.0);
        let mut page = Page::new("t");
        view.add(&mut page, "v").unwrap();
        view.add(&mut page, "w").unwrap();
        let html = page.finish();
        assert!(html.contains("id=\"v\"") && html.contains("455"));
        assert_eq!(html.matches(PACKED.as_str()).count(), 1, "the library is there once");
        assert!(!html.contains("http") && !html.contains("\nimport ") && !html.contains("eval("));
    }

    #[test]
    fn every_colour_of_a_figure_has_another_in_the_dark() {
        use crate::svg::colour::{BAD, C0, C90, DATA, GOOD, GRID, INK, MODEL, MUTED, NOW};
        let dark = include_str!("../html/report.css");
        for colour in [BAD, C0, C90, DATA, GOOD, GRID, INK, MODEL, MUTED, NOW] {
            for part in ["fill", "stroke"] {
                let rule = STYLE
                    .lines()
                    .find(|line| line.contains(&format!("[{part}=\"{colour}\"]")));
                let name = rule.and_then(|rule| rule.split("var(").nth(1)?.split(',').next());
                assert!(
                    name.is_some_and(|name| dark.contains(&format!("{name}:"))),
                    "{part} {colour}"
                );
            }
        }
    }

    #[test]
    fn the_library_is_what_was_taken() {
        use std::io::Read as _;
        let bytes = base64::engine::general_purpose::STANDARD
            .decode(PACKED.as_bytes())
            .unwrap();
        let mut text = String::new();
        flate2::read::GzDecoder::new(&bytes[..])
            .read_to_string(&mut text)
            .unwrap();
        assert_eq!(text, THREE);
    }
}
