//! A sensor's map to look into: the value under the pointer, movable sections, a logarithmic scale and contours by one
//! click. Values are means of as many pixels as a screen shows as one.

use base64::Engine as _;

use crate::html::Page;
use crate::map::{Map, viridis};
use crate::svg::escape;

/// Points along the longer side.
const MOST: usize = 160;

/// Adds the map to `page`, beside a `summary` of names with values. `id` is unique in the page; `digits` are those of a
/// value.
pub fn add(page: &mut Page, map: &Map<'_>, summary: &[(String, String)], digits: usize, id: &str) {
    let (nx, ny) = (map.nx.min(MOST), map.ny.min(MOST));
    let mut bytes = Vec::with_capacity(4 * nx * ny);
    let mut sum = 0.0;
    for iy in 0..ny {
        for ix in 0..nx {
            let mean = map.mean_over(ix, iy, nx, ny);
            sum += mean;
            bytes.extend((mean as f32).to_le_bytes());
        }
    }
    let tall = 420.0 * map.size_mm[1] / map.size_mm[0].max(map.size_mm[1]);
    let wide = 420.0 * map.size_mm[0] / map.size_mm[0].max(map.size_mm[1]);
    let rows = summary.iter().fold(String::new(), |rows, (name, value)| {
        rows + &format!("<tr><td>{}</td><td>{}</td></tr>", escape(name), escape(value))
    });
    page.raw(&format!(
        "<div class=\"explorer\" id=\"{id}\"><div><canvas tabindex=\"0\" role=\"img\" aria-label=\"map of the sensor; arrow keys move \
         the place that is read\" width=\"{wide:.0}\" height=\"{tall:.0}\"></canvas><p><label><input type=\"checkbox\" name=\"log\"> \
         logarithmic</label> <label><input type=\"checkbox\" name=\"contour\"> contours</label></p><p class=\"said\" \
         aria-live=\"polite\"></p></div><div><canvas width=\"420\" height=\"260\" aria-hidden=\"true\"></canvas><p class=\"hint\">Sections \
         through the place under the pointer; a click holds it, another lets it go.</p><table class=\"facts\"><tbody>{rows}</tbody></table>\
         </div></div>"
    ));
    let data = serde_json::json!({
        "nx": nx,
        "ny": ny,
        "size": map.size_mm,
        "unit": map.unit,
        "mean": sum / (nx * ny).max(1) as f64,
        "digits": digits.clamp(2, 9),
        "values": base64::engine::general_purpose::STANDARD.encode(bytes),
        "colours": (0..256).map(|k| viridis(f64::from(k) / 255.0)).collect::<Vec<_>>(),
    });
    let code = include_str!("explorer.js").trim_end();
    page.script(&format!("{code}({data}, document.getElementById(\"{id}\"));"));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_values_are_means_of_the_pixels_below_a_point_in_the_order_of_the_map() {
        let values: Vec<f32> = (0..400 * 2).map(|k| if k < 400 { 1.0 } else { 3.0 }).collect();
        let map = Map {
            values: &values,
            nx: 400,
            ny: 2,
            size_mm: [40.0, 0.2],
            quantity: "irradiance",
            unit: "W/m²",
            u: None,
        };
        let mut page = Page::new("t");
        add(
            &mut page,
            &map,
            &[("distance".to_owned(), "<500 mm".to_owned())],
            4,
            "m",
        );
        let html = page.finish();
        assert!(html.contains("&lt;500 mm") && html.contains("\"nx\":160") && html.contains("\"mean\":2.0"));
        let mut bytes = 1f32.to_le_bytes().repeat(160);
        bytes.extend(3f32.to_le_bytes().repeat(160));
        assert!(html.contains(&base64::engine::general_purpose::STANDARD.encode(bytes)));
    }
}
