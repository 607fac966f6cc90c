//! Quantities for a person to read, each with its name and unit. Programs take `--json`, which has every key and digit.

use isolux_formats::spectral::SpectrumFile;
use isolux_formats::{Content, Distribution};
use isolux_units::digits::shortest;
use serde_json::{Map, Value};

use super::inspection::Inspection;

/// Four significant digits are as many as a photometer has.
const DIGITS: i32 = 4;

impl Inspection {
    /// Its quantities for a person: name, value with unit; what could not be computed is left out. A row without a name
    /// goes on with the one above.
    pub fn stated(&self) -> Vec<(String, String)> {
        let mut quantities = Quantities {
            of: &self.quantities,
            rows: Vec::new(),
        };
        match &self.content {
            Some(Content::Distribution(distribution)) => quantities.distribution(distribution),
            Some(Content::Spectrum(file)) => quantities.spectrum(file),
            None => quantities.others(),
        }
        quantities.rows
    }
}

struct Quantities<'q> {
    of: &'q Map<String, Value>,
    rows: Vec<(String, String)>,
}

impl Quantities<'_> {
    fn number(&self, key: &str) -> Option<f64> {
        self.of.get(key).and_then(Value::as_f64)
    }

    fn list(&self, key: &str) -> Vec<f64> {
        let list = self.of.get(key).and_then(Value::as_array);
        list.into_iter().flatten().filter_map(Value::as_f64).collect()
    }

    fn distribution(&mut self, distribution: &Distribution) {
        let about = &distribution.luminaire;
        let names = [&about.manufacturer, &about.name].map(|text| text.trim());
        let names: Vec<&str> = names.into_iter().filter(|text| !text.is_empty()).collect();
        if !names.is_empty() {
            self.line("luminaire", short(&names.join(", ")));
        }
        let units = Units::of(distribution);
        if let Some(flux) = self.number("flux_lm") {
            let stated = self.number("flux_stated_lm");
            let stated = stated.map_or(String::new(), |lamps| {
                format!(", of the lamps {} {}", digits(lamps), units.flux)
            });
            self.line(units.flux_name, format_args!("{} {}{stated}", digits(flux), units.flux));
        }
        if let Some(peak) = self.number("i_max_cd") {
            self.line(
                "maximum intensity",
                format_args!("{} {} at {}", digits(peak), units.intensity, self.direction()),
            );
        }
        self.angle("beam angle (50 %)", "beam_angle_deg", distribution);
        self.angle("field angle (10 %)", "field_angle_deg", distribution);
        if let Some(ratio) = self.number("lorl_percent").filter(|_| !distribution.absolute) {
            self.line("light output ratio", format_args!("{} % (LORL)", digits(ratio)));
        }
        if let Some(down) = self.number("dff_percent") {
            self.line("downward flux", format_args!("{} % of the flux (DFF)", digits(down)));
        }
        let code: Vec<String> = self
            .list("cie_flux_code")
            .iter()
            .map(|part| format!("{part:.0}"))
            .collect();
        if !code.is_empty() {
            self.line("CIE flux code", format_args!("{} (N1 to N5, %)", code.join(" ")));
        }
        if let Some(area) = self.number("luminous_area_mm2") {
            self.line("luminous area", format_args!("{} mm²", digits(area)));
        }
        let of = self.of;
        if let Some(Value::Object(table)) = of.get("ugr").filter(|_| units.luminous()) {
            self.glare(table);
        }
    }

    /// Where the maximum is. On the axis all half-planes meet.
    fn direction(&self) -> String {
        let (c, gamma) = (self.number("i_max_c_deg"), self.number("i_max_gamma_deg"));
        match (c, gamma) {
            (_, Some(gamma)) if gamma == 0.0 || gamma == 180.0 => format!("γ {gamma}°"),
            (Some(c), Some(gamma)) => format!("C {}°, γ {}°", digits(c), digits(gamma)),
            _ => "an unknown direction".to_owned(),
        }
    }

    /// Full angles across C0–C180 and C90–C270; one where all half-planes are alike.
    fn angle(&mut self, name: &str, key: &str, distribution: &Distribution) {
        let Some(angles) = self.of.get(key).and_then(Value::as_array) else {
            return;
        };
        let planes = distribution.intensity.c_deg();
        let at = |c: f64| {
            let plane = distribution.intensity.plane_at(c)?;
            angles.get(plane)?.as_f64().map(digits)
        };
        let said: Vec<String> = match planes.len() {
            1 => at(planes[0])
                .map(|angle| format!("{angle}° in all half-planes"))
                .into_iter()
                .collect(),
            _ => [(0.0, "C0–C180"), (90.0, "C90–C270")]
                .into_iter()
                .filter_map(|(c, pair)| Some(format!("{pair} {}°", at(c)?)))
                .collect(),
        };
        if !said.is_empty() {
            self.line(name, said.join(", "));
        }
    }

    fn spectrum(&mut self, file: &SpectrumFile) {
        if let (Some(first), Some(last)) = (file.wavelength_nm.first(), file.wavelength_nm.last()) {
            let series = match file.series.len() {
                0 | 1 => String::new(),
                count => format!(", the first of {count} series"),
            };
            let points = file.wavelength_nm.len();
            let range = format!("{} to {} nm, {points} points{series}", digits(*first), digits(*last));
            let what = [&file.quantity, &file.unit]
                .into_iter()
                .flatten()
                .map(|text| short(text));
            let what: Vec<String> = what.collect();
            let of = if what.is_empty() {
                String::new()
            } else {
                format!("{}; ", what.join(", "))
            };
            self.line("values", format_args!("{of}{range}"));
        }
        if let Some(cct) = self.number("cct_k") {
            let duv = self
                .number("duv")
                .map_or(String::new(), |duv| format!(", Duv {duv:+.4}"));
            self.line("correlated colour temp.", format_args!("{cct:.0} K{duv}"));
        }
        if let (Some(ra), r) = (self.number("ra"), self.list("r")) {
            let r9 = r.get(8).map_or(String::new(), |r9| format!(", R9 {r9:.0}"));
            self.line("colour rendering", format_args!("Ra {ra:.1}{r9}"));
        }
        if let (Some(rf), Some(rg)) = (self.number("rf"), self.number("rg")) {
            self.line("TM-30", format_args!("Rf {rf:.1}, Rg {rg:.1}"));
        }
        if let (Some(x), Some(y)) = (self.number("x"), self.number("y")) {
            self.line("chromaticity", format_args!("x {x:.4}, y {y:.4}"));
        }
        if let (Some(u), Some(v)) = (self.number("u_prime"), self.number("v_prime")) {
            self.line("", format_args!("u′ {u:.4}, v′ {v:.4}"));
        }
        self.with_unit("peak_nm", "peak wavelength", " nm");
        self.with_unit("centroid_nm", "centroid wavelength", " nm");
        self.with_unit("dominant_nm", "dominant wavelength", " nm");
        self.with_unit("fwhm_nm", "width at half maximum", " nm");
        self.with_unit("ler_lm_per_w", "luminous efficacy", " lm/W (of the radiation)");
        self.with_unit("sp_ratio", "S/P ratio", "");
        if let Some(mismatch) = self.number("f1_prime") {
            self.line(
                "f1′",
                format_args!("{} % (if this is a meter's responsivity)", digits(100.0 * mismatch)),
            );
        }
        self.with_unit("spectral_mismatch", "spectral mismatch factor", "");
    }

    fn with_unit(&mut self, key: &str, name: &str, unit: &str) {
        if let Some(value) = self.number(key) {
            self.line(name, format_args!("{}{unit}", digits(value)));
        }
    }

    fn line(&mut self, name: &str, text: impl ToString) {
        self.rows.push((name.to_owned(), text.to_string()));
    }

    /// The room of 4H × 8H with the reflectances that data sheets quote, from the table of CIE 117.
    fn glare(&mut self, table: &Map<String, Value>) {
        let rows = |name: &str| table.get(name).and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
        let is = |value: &Value, wanted: &[f64]| {
            let numbers: Vec<f64> = value
                .as_array()
                .into_iter()
                .flatten()
                .filter_map(Value::as_f64)
                .collect();
            numbers == wanted
        };
        let room = rows("room_h").iter().position(|room| is(room, &[4.0, 8.0]));
        let set = rows("reflectance_percent")
            .iter()
            .position(|set| is(set, &[70.0, 50.0, 20.0]));
        let (Some(room), Some(set)) = (room, set) else {
            return;
        };
        let value = |name: &str| rows(name).get(room)?.get(set)?.as_f64();
        if let (Some(crosswise), Some(endwise)) = (value("crosswise"), value("endwise")) {
            self.line(
                "UGR",
                format_args!("crosswise {crosswise:.1}, endwise {endwise:.1} (4H × 8H, 70/50/20, spacing 0.25 H)"),
            );
        }
    }

    /// Ray files: their keys carry the units.
    fn others(&mut self) {
        let of = self.of;
        for (key, value) in of.iter().filter(|(_, value)| !value.is_null()) {
            let text = match value {
                Value::Number(number) if number.is_f64() => number.as_f64().map_or_else(String::new, digits),
                Value::String(text) => text.clone(),
                other => other.to_string(),
            };
            self.line(&key.replace('_', " "), text);
        }
    }
}

/// What the file's numbers are: luminous, or what its keywords say.
struct Units {
    flux_name: &'static str,
    flux: String,
    intensity: String,
}

impl Units {
    fn of(distribution: &Distribution) -> Self {
        match distribution.header.get("intensity_unit").and_then(Value::as_str) {
            None => Self {
                flux_name: "luminous flux",
                flux: "lm".to_owned(),
                intensity: "cd".to_owned(),
            },
            // A radiation type without a unit says only that it is not light.
            Some(unit) => Self {
                flux_name: "radiant flux",
                flux: unit.strip_suffix("/sr").unwrap_or("in the file's unit").to_owned(),
                intensity: if unit.ends_with("/sr") {
                    unit
                } else {
                    "in the file's unit"
                }
                .to_owned(),
            },
        }
    }

    fn luminous(&self) -> bool {
        self.intensity == "cd"
    }
}

/// As much of a text as a line of the screen has room for.
fn short(text: &str) -> String {
    const ROOM: usize = 72;
    let mut cut: String = text.chars().take(ROOM).collect();
    if cut.len() < text.len() {
        cut.push('…');
    }
    cut
}

fn digits(value: f64) -> String {
    shortest(value, DIGITS)
}
