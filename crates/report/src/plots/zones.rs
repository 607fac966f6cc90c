//! Zonal flux as bars, from γ = 0 up.

use crate::svg::{Anchor, Stroke, Svg, WIDTH, colour};

/// One bar a zone of `step_deg` with its lumen, zones without light at the end left out.
pub fn zones(flux_lm: &[f64], step_deg: f64) -> String {
    let high = flux_lm.iter().copied().fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    let shown = flux_lm
        .iter()
        .rposition(|lm| *lm > 1e-3 * high)
        .map_or(1, |last| last + 1);
    let height = 46.0 + 22.0 * shown as f64;
    let mut svg = Svg::new(WIDTH, height, "Zonal luminous flux");
    svg.text((76.0, 18.0), Anchor::End, colour::MUTED, "γ in °");
    svg.text((86.0, 18.0), Anchor::Start, colour::MUTED, "luminous flux in lm");
    for (place, lm) in flux_lm.iter().take(shown).enumerate() {
        let y = 28.0 + 22.0 * place as f64;
        let zone = format!("{}–{}", step_deg * place as f64, step_deg * (place as f64 + 1.0));
        svg.text((76.0, y + 13.0), Anchor::End, colour::INK, &zone);
        let width = 340.0 * lm.max(0.0) / high;
        svg.rectangle(84.0, y, width, 17.0, colour::DATA, None);
        svg.text(
            (90.0 + width, y + 13.0),
            Anchor::Start,
            colour::INK,
            &isolux_units::digits::significant(*lm, 3),
        );
    }
    svg.line((84.0, 24.0), (84.0, height - 12.0), Stroke::solid(colour::INK, 1.0));
    svg.finish()
}
