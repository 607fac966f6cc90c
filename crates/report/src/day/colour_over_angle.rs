//! Colour over angle: what colour the light has in every direction, and all of it together.

use isolux_reduce::{OverAngle, Quantity, Reduction, no_uncertainty};
use isolux_spectrum::Chromaticity;

use crate::document::{Block, Figure, Section};
use crate::plots::{
    ColourDirections, DirectionColour, STEP, SpectrumOptions, cct_over_gamma, colour_over_sphere, colour_steps,
    spectrum_beside,
};

/// Coverage factor of the report.
const K: f64 = 2.0;

/// None without spectra off the axis.
pub fn section(reduction: &Reduction) -> Option<Section> {
    let found = reduction.over_angle.as_ref()?;
    let facts = &found.facts;
    let mut section = Section::new("Colour over angle");
    section.paragraph(sentence(found));
    for pair in figures(reduction).chunks(2) {
        section.add(Block::Figures(pair.to_vec()));
    }
    let stated = |quantity: &Option<Quantity>| quantity.as_ref().map_or_else(|| "none".to_owned(), Quantity::stated);
    let (whole, average) = (&facts.total.colour, &facts.average_lm79);
    section.subheading("The whole light, and the average of LM-79");
    section.table(
        &["", "total spectral flux", "average of x and y (LM-79)"],
        vec![
            row("x (CIE 1931)", stated(&whole.x), stated(&average.x)),
            row("y (CIE 1931)", stated(&whole.y), stated(&average.y)),
            row("u′ (CIE 1976)", stated(&whole.u_prime), stated(&average.u_prime)),
            row("v′ (CIE 1976)", stated(&whole.v_prime), stated(&average.v_prime)),
            row(
                "correlated colour temperature",
                stated(&whole.cct),
                stated(&average.cct),
            ),
            row("Duv", stated(&whole.duv), stated(&average.duv)),
            row("Ra (CIE 13.3)", stated(&whole.ra), String::new()),
            row("R9", stated(&whole.r9), String::new()),
            row("Rf (TM-30, CIE 224)", stated(&whole.rf), String::new()),
            row("Rg (TM-30)", stated(&whole.rg), String::new()),
            row(
                "luminous efficacy of radiation",
                facts.total.efficacy.stated(),
                String::new(),
            ),
            row("radiant flux", facts.total.radiant_flux.stated(), String::new()),
        ],
    );
    let delta = &facts.delta_u_prime_v_prime;
    section.paragraph(format!(
        "Δu′v′ {} at C {}° γ {}°, the largest of {} directions with at least {:.0} % of the largest \
         intensity, from the average of LM-79; read {:.5}, of which noise makes {:.5} and the size of the lamp {:.5}.",
        delta.value.stated(),
        delta.c_deg,
        delta.gamma_deg,
        delta.directions,
        100.0 * delta.least_share,
        delta.read,
        delta.noise_bias,
        delta.lamp_size_bias
    ));
    section.subheading("Every direction");
    section.numbers(
        ["", "cd", "u′", "U", "v′", "U", "CCT in K", "U", "Duv", "Δu′v′"]
            .map(str::to_owned)
            .into(),
        facts.directions.iter().map(direction_row).collect(),
    );
    if !facts.missing.is_empty() {
        section.paragraph(no_uncertainty(
            &facts.missing.iter().map(ToString::to_string).collect::<Vec<_>>(),
        ));
    }
    if !facts.left_out.is_empty() {
        let left_out = facts
            .left_out
            .iter()
            .map(|left| format!("C {}° γ {}°: {}", left.c_deg, left.gamma_deg, left.reason));
        section.paragraph(format!("Not used: {}.", left_out.collect::<Vec<_>>().join("; ")));
    }
    Some(section)
}

fn row(name: &str, whole: String, average: String) -> Vec<String> {
    vec![name.to_owned(), whole, average]
}

fn direction_row(of: &isolux_reduce::DirectionColour) -> Vec<String> {
    let expanded = |u: Option<f64>, digits: usize| {
        let number = u.map(|u| format!("{:.digits$}", K * u));
        number.unwrap_or_else(|| "–".to_owned())
    };
    let optional =
        |value: Option<f64>, digits: usize| value.map_or_else(|| "–".to_owned(), |value| format!("{value:.digits$}"));
    vec![
        format!("C {}° γ {}°", of.c_deg, of.gamma_deg),
        format!("{:.1}", of.intensity_cd),
        format!("{:.4}", of.u_prime),
        expanded(of.u_u_prime, 4),
        format!("{:.4}", of.v_prime),
        expanded(of.u_v_prime, 4),
        optional(of.cct_k, 0),
        expanded(of.u_cct_k, 0),
        optional(of.duv, 4),
        format!("{:.4}", of.delta_u_prime_v_prime),
    ]
}

/// What a reader should take away.
pub fn sentence(found: &OverAngle) -> String {
    let facts = &found.facts;
    let delta = &facts.delta_u_prime_v_prime;
    let steps = delta.value.value / STEP;
    let place = format!("C {}° γ {}°", delta.c_deg, delta.gamma_deg);
    let farthest = facts
        .directions
        .iter()
        .find(|of| (of.c_deg, of.gamma_deg) == (delta.c_deg, delta.gamma_deg));
    let average = &facts.average_lm79;
    let (Some(of), Some(u), Some(v)) = (farthest, &average.u_prime, &average.v_prime) else {
        return format!("The largest difference of colour is at {place}.");
    };
    let (du, dv) = (of.u_prime - u.value, of.v_prime - v.value);
    let word = match (dv.abs() >= du.abs(), du > 0.0, dv > 0.0) {
        (true, _, true) => "yellower",
        (true, _, false) => "bluer",
        (false, true, _) => "redder",
        (false, false, _) => "greener",
    };
    if steps < 1.0 {
        return format!(
            "The light has one colour: no direction that is bright differs from the average by as much as one step of \
             0.0011 in u′v′ (largest {steps:.2}, at {place})."
        );
    }
    format!(
        "The light is not of one colour: at {place} it is {word} than on average, by {steps:.1} steps of 0.0011 in \
         u′v′."
    )
}

/// The pictures; none without spectra off the axis.
pub fn figures(reduction: &Reduction) -> Vec<Figure> {
    let Some(found) = &reduction.over_angle else {
        return Vec::new();
    };
    let mut figures = Vec::new();
    let mut add = |svg: String, caption: &str| {
        figures.push(Figure {
            svg,
            caption: caption.to_owned(),
        });
    };
    if let Some(colours) = colours(reduction, found) {
        add(
            colour_steps(&colours),
            "u′v′ of every direction about the average of LM-79; circles of whole steps of 0.0011.",
        );
        add(
            colour_over_sphere(&colours),
            "Δu′v′ from that average over the sphere; between the dots colours mix by their lumens.",
        );
        if let Some(svg) = cct_over_gamma(&colours) {
            add(svg, "Correlated colour temperature along γ, with U (k = 2).");
        }
    }
    if let Some(spectral) = &reduction.spectral {
        let options = SpectrumOptions {
            title: String::new(),
            value_label: "spectral flux in W/nm".to_owned(),
        };
        let names = ["whole light", "on the axis"];
        add(
            spectrum_beside(&found.total, &spectral.spectrum, &options, names),
            "Total spectral flux, and the spectrum on the axis with the same lumens.",
        );
    }
    figures
}

/// The colours of the directions, as pictures take them.
fn colours(reduction: &Reduction, found: &OverAngle) -> Option<ColourDirections> {
    let facts = &found.facts;
    let peak_cd = reduction.grid.distribution.peak().intensity_cd;
    let least_cd = facts.delta_u_prime_v_prime.least_share * peak_cd;
    let directions = facts.directions.iter().map(|of| DirectionColour {
        at_deg: (of.c_deg, of.gamma_deg),
        chromaticity: Chromaticity { x: of.x, y: of.y },
        expanded_cct_k: of.u_cct_k.map(|u| K * u),
        counts: of.intensity_cd >= least_cd,
    });
    let average = &facts.average_lm79;
    let average = Chromaticity {
        x: average.x.as_ref()?.value,
        y: average.y.as_ref()?.value,
    };
    ColourDirections::new(directions.collect(), average).ok()
}
