//! A sensor's map to look into: the value under the pointer, movable sections, a logarithmic scale and contours by one
//! click. Values are means of as many pixels as a screen shows as one.

use base64::Engine as _;
use serde::Serialize;

use super::{MAP, inlined};
use crate::html::Page;
use crate::map::{Map, viridis};
use crate::svg::escape;

/// Points along the longer side.
const MOST: usize = 160;

/// What `map.js` draws a map from.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Explored {
    /// Columns.
    nx: usize,
    /// Rows.
    ny: usize,
    /// Edges in mm.
    size: [f64; 2],
    unit: String,
    /// Significant digits of a value.
    digits: usize,
    /// Base64 of 32-bit floats in `unit`, row by row from the lower edge.
    values: String,
    /// Red, green and blue from the smallest to the largest value.
    colours: Vec<[u8; 3]>,
}

impl Explored {
    /// Of a map, with so many significant digits of a value.
    pub fn of(map: &Map<'_>, digits: usize) -> Self {
        let (nx, ny) = (map.nx.min(MOST), map.ny.min(MOST));
        let places = (0..ny).flat_map(|iy| (0..nx).map(move |ix| (ix, iy)));
        let bytes: Vec<u8> = places
            .flat_map(|(ix, iy)| (map.mean_over(ix, iy, nx, ny) as f32).to_le_bytes())
            .collect();
        Self {
            nx,
            ny,
            size: map.size_mm,
            unit: map.unit.to_owned(),
            digits: digits.clamp(2, 9),
            values: base64::engine::general_purpose::STANDARD.encode(bytes),
            colours: (0..256).map(|k| viridis(f64::from(k) / 255.0)).collect(),
        }
    }
}

/// Adds the map to `page`, beside a `summary` of names with values. `id` is unique in the page; `digits` are those of a
/// value.
///
/// # Errors
/// When a number cannot be written as JSON.
pub fn add(
    page: &mut Page,
    map: &Map<'_>,
    summary: &[(String, String)],
    digits: usize,
    id: &str,
) -> Result<(), serde_json::Error> {
    let rows = summary.iter().fold(String::new(), |rows, (name, value)| {
        rows + &format!("<tr><td>{}</td><td>{}</td></tr>", escape(name), escape(value))
    });
    page.raw(&format!(
        "<div class=\"explorer\"><div id=\"{id}\"></div><div><p class=\"hint\">Sections through the place under the pointer; a click \
         holds it, another lets it go.</p><table class=\"facts\"><tbody>{rows}</tbody></table></div></div>"
    ));
    let data = serde_json::to_string(&Explored::of(map, digits))?;
    let call = format!("new SensorMap(document.getElementById(\"{id}\")).show({data});");
    page.module(&inlined(&[MAP], &call));
    Ok(())
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
        let summary = [("distance".to_owned(), "<500 mm".to_owned())];
        add(&mut page, &map, &summary, 4, "m").unwrap();
        let html = page.finish();
        assert!(
            html.contains("&lt;500 mm") && html.contains("\"nx\":160") && html.contains("<script type=\"module\">")
        );
        let mut bytes = 1f32.to_le_bytes().repeat(160);
        bytes.extend(3f32.to_le_bytes().repeat(160));
        assert!(html.contains(&base64::engine::general_purpose::STANDARD.encode(bytes)));
    }
}
