//! A comparison in words.

use isolux_units::digits::shortest;

use super::Compared;

impl Compared {
    /// What it says, a line each.
    pub fn stated(&self) -> Vec<String> {
        let mut lines = Vec::new();
        let number = |value: f64| shortest(value, 5);
        let verdict = |agrees: Option<bool>| match agrees {
            Some(true) => "agrees",
            Some(false) => "DIFFERS",
            None => "not judged",
        };
        for pair in &self.pairs {
            lines.push(format!("{} against {}", pair.name, self.first));
            for row in &pair.rows {
                let e_n = row.e_n.map_or(String::new(), |e_n| format!(", En {e_n:+.2}"));
                let expanded = row.expanded.map_or(String::new(), |u| format!(" ± {}", shortest(u, 2)));
                lines.push(format!(
                    "  {:24} {} → {} {}: {}{expanded}{e_n}: {}",
                    row.quantity,
                    number(row.first),
                    number(row.other),
                    row.unit,
                    shortest(row.difference, 3),
                    verdict(row.agrees)
                ));
            }
            let sphere = &pair.sphere;
            let within = sphere.share_within_u.map_or(String::new(), |share| {
                format!("; {:.1} % of the directions within U", 100.0 * share)
            });
            lines.push(format!(
            "  {:24} rms {:.2} % of the peak, largest {:+.2} % at C {}°, γ {}°; rms {:.2} % where bright{within}: {}",
            "intensities",
            100.0 * sphere.rms_of_peak,
            100.0 * sphere.largest_of_peak,
            sphere.largest_c_deg,
            sphere.largest_gamma_deg,
            100.0 * sphere.rms_rel_where_bright,
            verdict(sphere.agrees)
        ));
        }
        if let Some(series) = &self.series {
            lines.push(format!(
                "{} items; 95 % of all such lie within (95 % confidence)",
                series.count
            ));
            for row in &series.rows {
                lines.push(format!(
                    "  {:24} mean {} {}, s {}: {} to {}",
                    row.quantity,
                    number(row.mean),
                    row.unit,
                    shortest(row.s, 3),
                    number(row.tolerance[0]),
                    number(row.tolerance[1])
                ));
            }
        }
        lines
    }
}
