//! Quantities for a person to read, each with its name and unit. Programs take `--json`, which has every key and digit.

use isolux_formats::spectral::SpectrumFile;
use isolux_formats::{
    Content, Distribution, GlareTable, LuminanceTable, Outdoor, Quantities as DistributionQuantities,
    SCREEN_LIMITS_CD_M2, SCREEN_LUMINANCE_CD_M2,
};
use isolux_units::digits::{shortest, significant};
use serde_json::Value;

use super::coloured::{AngularColour, ColourOfDirection};
use super::inspection::{Inspection, Quantities, SpectrumQuantities};
use super::ray_quantities::RayQuantities;

/// Four significant digits are as many as a photometer has.
const DIGITS: i32 = 4;

impl Inspection {
    /// Its quantities for a person: name, value with unit; what could not be computed is left out. A row without a name
    /// goes on with the one above.
    pub fn stated(&self) -> Vec<(String, String)> {
        let mut rows = Rows::default();
        match (&self.quantities, &self.content) {
            (Quantities::Distribution(of), Some(Content::Distribution(distribution))) => {
                rows.distribution(of, distribution);
            }
            (Quantities::Coloured(all), Some(Content::Distribution(distribution))) => {
                rows.distribution(&all.of, distribution);
                rows.colour(&all.colour_over_angle);
            }
            (Quantities::Spectrum(of), Some(Content::Spectrum(file))) => rows.spectrum(of, file),
            (Quantities::Rays(of), _) => rows.rays(of),
            _ => {}
        }
        rows.0
    }
}

#[derive(Default)]
struct Rows(Vec<(String, String)>);

impl Rows {
    fn distribution(&mut self, of: &DistributionQuantities, distribution: &Distribution) {
        let about = &distribution.luminaire;
        let names = [&about.manufacturer, &about.name].map(|text| text.trim());
        let names: Vec<&str> = names.into_iter().filter(|text| !text.is_empty()).collect();
        if !names.is_empty() {
            self.line("luminaire", short(&names.join(", ")));
        }
        let units = Units::of(distribution);
        let stated = of.flux_stated_lm.map_or(String::new(), |lamps| {
            format!(", of the lamps {} {}", digits(lamps), units.flux)
        });
        self.line(
            units.flux_name,
            format_args!("{} {}{stated}", digits(of.flux_lm), units.flux),
        );
        self.line(
            "maximum intensity",
            format_args!("{} {} at {}", digits(of.i_max_cd), units.intensity, direction(of)),
        );
        self.angle("beam angle (50 %)", &of.beam_angle_deg, distribution);
        self.angle("field angle (10 %)", &of.field_angle_deg, distribution);
        if let Some(ratio) = of.lorl_percent.filter(|_| !distribution.absolute) {
            self.line("light output ratio", format_args!("{} % (LORL)", digits(ratio)));
        }
        if let Some(down) = of.dff_percent {
            self.line("downward flux", format_args!("{} % of the flux (DFF)", digits(down)));
        }
        if let Some(code) = of.cie_flux_code {
            let code = code.map(|part| format!("{part:.0}"));
            self.line("CIE flux code", format_args!("{} (N1 to N5, %)", code.join(" ")));
        }
        if let Some(area) = of.luminous_area_mm2 {
            self.line("luminous area", format_args!("{} mm²", digits(area)));
        }
        if let Some(table) = &of.luminance {
            self.luminance(table);
        }
        if let Some(table) = of.ugr.as_ref().filter(|_| units.luminous()) {
            self.glare(table);
        }
        if let Some(outdoor) = &of.outdoor {
            self.outdoor(outdoor);
        }
    }

    /// A row a γ, the largest over the half-planes, and what screens allow.
    fn luminance(&mut self, table: &LuminanceTable) {
        let rows = table.gamma_deg.iter().zip(&table.cd_m2);
        let most = |row: &Vec<Option<f64>>| row.iter().flatten().copied().fold(0.0, f64::max);
        let rows: Vec<String> = rows
            .map(|(gamma, row)| format!("γ {gamma}° {}", significant(most(row), 3)))
            .collect();
        self.line(
            "mean luminance",
            format_args!("{} cd/m² (largest over C)", rows.join(", ")),
        );
        let limits = SCREEN_LIMITS_CD_M2.map(|limit| {
            let kept = table.largest_from_65_cd_m2 <= limit;
            format!("{} {limit:.0} cd/m²", if kept { "within" } else { "above" })
        });
        self.line(
            "",
            format_args!(
                "from γ 65° {}, {} (EN 12464-1, screens above and up to {SCREEN_LUMINANCE_CD_M2:.0} cd/m²)",
                limits[0], limits[1]
            ),
        );
    }

    /// The zones of TM-15 and their ratings.
    fn outdoor(&mut self, of: &Outdoor) {
        let street = digits(of.street_side_c_deg);
        let zones = |zones: [(&str, f64); 4]| zones.map(|(name, lm)| format!("{name} {}", digits(lm))).join(", ");
        let forward = [("FL", of.fl_lm), ("FM", of.fm_lm), ("FH", of.fh_lm), ("FVH", of.fvh_lm)];
        let back = [("BL", of.bl_lm), ("BM", of.bm_lm), ("BH", of.bh_lm), ("BVH", of.bvh_lm)];
        self.line(
            "outdoor zones (TM-15)",
            format_args!("{} lm (street side C {street}°)", zones(forward)),
        );
        self.line("", format_args!("{} lm", zones(back)));
        let (ul, uh) = (of.ul_lm.map(digits), of.uh_lm.map(digits));
        match (ul, uh, of.uplight_rating) {
            (Some(ul), Some(uh), Some(uplight)) => {
                self.line("", format_args!("UL {ul}, UH {uh} lm"));
                self.line(
                    "ratings B, U",
                    format_args!("B{} U{uplight} (G is not rated)", of.backlight_rating),
                );
            }
            _ => self.line(
                "ratings B, U",
                format_args!(
                    "B{}; no U: the file ends at γ below 180° in light (G is not rated)",
                    of.backlight_rating
                ),
            ),
        }
    }

    /// Full angles across C0–C180 and C90–C270; one where all half-planes are alike.
    fn angle(&mut self, name: &str, angles: &[Option<f64>], distribution: &Distribution) {
        let planes = distribution.intensity.c_deg();
        let at = |c: f64| {
            let plane = distribution.intensity.plane_at(c)?;
            (*angles.get(plane)?).map(digits)
        };
        let stated: Vec<String> = match planes.len() {
            1 => at(planes[0])
                .map(|angle| format!("{angle}° in all half-planes"))
                .into_iter()
                .collect(),
            _ => [(0.0, "C0–C180"), (90.0, "C90–C270")]
                .into_iter()
                .filter_map(|(c, pair)| Some(format!("{pair} {}°", at(c)?)))
                .collect(),
        };
        if !stated.is_empty() {
            self.line(name, stated.join(", "));
        }
    }

    fn colour(&mut self, of: &AngularColour) {
        let chromaticity = |of: &ColourOfDirection| format!("u′ {:.4}, v′ {:.4}", of.u_prime, of.v_prime);
        let cct = of.total.cct_k.map_or(String::new(), |cct| format!(", {cct:.0} K"));
        self.line("colour of all the light", chromaticity(&of.total) + &cct);
        let ccts = of.directions.iter().filter_map(|of| of.cct_k);
        let (low, high) = ccts.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), cct| {
            (low.min(cct), high.max(cct))
        });
        let range = if low <= high {
            format!(", {low:.0} to {high:.0} K")
        } else {
            String::new()
        };
        self.line(
            "spectra over angle",
            format!("{} directions{range}", of.directions.len()),
        );
        self.line(
            "Δu′v′ over angle",
            format!("{:.4} (not corrected for noise)", of.delta_u_prime_v_prime),
        );
    }

    fn spectrum(&mut self, quantities: &SpectrumQuantities, file: &SpectrumFile) {
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
        let of = &quantities.of;
        if let Some(cct) = of.cct_k {
            let duv = of.duv.map_or(String::new(), |duv| format!(", Duv {duv:+.4}"));
            self.line("correlated colour temp.", format_args!("{cct:.0} K{duv}"));
        }
        if let Some(ra) = of.ra {
            let r9 = of.r.map_or(String::new(), |r| format!(", R9 {:.0}", r[8]));
            self.line("colour rendering", format_args!("Ra {ra:.1}{r9}"));
        }
        if let (Some(rf), Some(rg)) = (of.rf, of.rg) {
            self.line("TM-30", format_args!("Rf {rf:.1}, Rg {rg:.1}"));
        }
        if let (Some(x), Some(y)) = (of.x, of.y) {
            self.line("chromaticity", format_args!("x {x:.4}, y {y:.4}"));
        }
        if let (Some(u), Some(v)) = (of.u_prime, of.v_prime) {
            self.line("", format_args!("u′ {u:.4}, v′ {v:.4}"));
        }
        self.with_unit(of.peak_nm, "peak wavelength", " nm");
        self.with_unit(of.centroid_nm, "centroid wavelength", " nm");
        self.with_unit(of.dominant_nm, "dominant wavelength", " nm");
        self.with_unit(of.fwhm_nm, "width at half maximum", " nm");
        self.with_unit(of.ler_lm_per_w, "luminous efficacy", " lm/W (of the radiation)");
        self.with_unit(of.sp_ratio, "S/P ratio", "");
        if let (Some(k_bv), Some(e_thr)) = (of.k_bv_mw_per_lm, of.e_thr_lx) {
            self.line(
                "blue-light hazard",
                format_args!("K_B,v {} mW/lm, E_thr {} lx", digits(k_bv), digits(e_thr)),
            );
        }
        self.with_unit(
            of.photons_umol_per_s_klm,
            "photons, 400–700 nm",
            " µmol/s for each 1000 lm",
        );
        if let Some(rated) = &quantities.rated_colour {
            self.line(
                "rated colour",
                format_args!(
                    "{} steps from the {} of {} K (u′v′)",
                    digits(rated.steps),
                    rated.of,
                    rated.cct_k
                ),
            );
        }
        self.with_unit(
            quantities.daylight_efficacy_ratio.flatten(),
            "daylight efficacy ratio",
            " (of the action spectrum that was given)",
        );
        if let Some(mismatch) = of.f1_prime {
            self.line(
                "f1′",
                format_args!("{} % (if this is a meter's responsivity)", digits(100.0 * mismatch)),
            );
        }
        self.with_unit(quantities.spectral_mismatch.flatten(), "spectral mismatch factor", "");
    }

    fn with_unit(&mut self, value: Option<f64>, name: &str, unit: &str) {
        if let Some(value) = value {
            self.line(name, format_args!("{}{unit}", digits(value)));
        }
    }

    fn line(&mut self, name: &str, text: impl ToString) {
        self.0.push((name.to_owned(), text.to_string()));
    }

    /// The room of 4H × 8H with the reflectances that data sheets quote, from the table of CIE 117.
    fn glare(&mut self, table: &GlareTable) {
        let room = table.room_h.iter().position(|room| *room == [4.0, 8.0]);
        let sets = &table.reflectance_percent;
        let set = sets.iter().position(|set| *set == [70.0, 50.0, 20.0]);
        let (Some(room), Some(set)) = (room, set) else {
            return;
        };
        if let (Some(crosswise), Some(endwise)) = (table.crosswise[room][set], table.endwise[room][set]) {
            self.line(
                "UGR",
                format_args!("crosswise {crosswise:.1}, endwise {endwise:.1} (4H × 8H, 70/50/20, spacing 0.25 H)"),
            );
        }
    }

    /// The keys of a ray file carry the units.
    fn rays(&mut self, of: &RayQuantities) {
        let all = serde_json::to_value(of).unwrap_or_default();
        for (key, value) in all
            .as_object()
            .into_iter()
            .flatten()
            .filter(|(_, value)| !value.is_null())
        {
            let text = match value {
                Value::Number(number) if number.is_f64() => number.as_f64().map_or_else(String::new, digits),
                Value::String(text) => text.clone(),
                other => other.to_string(),
            };
            self.line(&key.replace('_', " "), text);
        }
    }
}

/// Where the maximum is. On the axis all half-planes meet.
fn direction(of: &DistributionQuantities) -> String {
    match (of.i_max_c_deg, of.i_max_gamma_deg) {
        (_, gamma) if gamma == 0.0 || gamma == 180.0 => format!("γ {gamma}°"),
        (c, gamma) => format!("C {}°, γ {}°", digits(c), digits(gamma)),
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
