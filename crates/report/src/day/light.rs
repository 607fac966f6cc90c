//! The distribution, its flux, glare, and the table of intensities.

use crate::document::Section;
use crate::plots::{IsoluxOptions, PolarOptions, cartesian, cone, cones, isocandela, isolux, zones};
use isolux_formats::{GlareTable, LuminanceTable, SCREEN_LIMITS_CD_M2, SCREEN_LUMINANCE_CD_M2};
use isolux_photometry::IntensityDistribution;
use isolux_reduce::{Quantity, Reduction};
use isolux_units::digits::significant;

use super::results::DayResults;
use super::words::{angle, direction, quantities};

/// Step of the zones of flux.
const ZONE_DEG: f64 = 10.0;

pub fn distribution(day_results: &DayResults) -> Section {
    let reduction = &day_results.reduction;
    let shown = &reduction.grid.distribution;
    let options = PolarOptions {
        title: String::new(),
        per_lamp_flux_lm: Some(reduction.flux.value),
        doubtful_cd: Some(doubtful_cd(day_results)),
    };
    let mut section = Section::new("Luminous intensity distribution");
    // The polar diagram and the solid stand on the first page.
    section.figures([
        (
            cartesian(shown, &options),
            "Intensity over γ: how steep the edges of the beam are. The polar diagram is on the first page.",
        ),
        (
            isocandela(shown, &options),
            "Lines of equal intensity over (C, γ): a luminaire that is alike all around has level lines.",
        ),
    ]);
    let at = IsoluxOptions::at_one_metre(shown, "");
    let plane = (
        isolux(shown, &at),
        "Illuminance on a plane at 1 m; E falls with the square of the height.",
    );
    match cone(shown) {
        Some(cone) => section.figures([
            plane,
            (
                cone,
                "Cone of the beam (50 % of the largest intensity) and illuminance on its axis.",
            ),
        ]),
        None => section.figures([plane]),
    }
    beam_and_field(&mut section, reduction);
    let (c_deg, gamma_deg) = reduction.i_max_deg;
    section.paragraph(format!(
        "Largest intensity {} {}; on the axis {} cd.",
        reduction.i_max.stated(),
        direction(c_deg, gamma_deg),
        significant(shown.intensity_cd_at(0.0, 0.0), 4)
    ));
    illuminance_on_the_axis(&mut section, shown);
    section
}

fn beam_and_field(section: &mut Section, reduction: &Reduction) {
    section.subheading("Beam and field");
    let stated = |angle: &Option<Quantity>| angle.as_ref().map_or_else(|| "none".to_owned(), Quantity::stated);
    let shown = &reduction.grid.distribution;
    let rows = reduction.angles.iter().filter_map(|plane| {
        let row = shown.row(shown.plane_at(plane.c_deg)?);
        Some(vec![
            plane.name(),
            stated(&plane.beam),
            stated(&plane.field),
            format!("{} cd", significant(row.iter().copied().fold(0.0, f64::max), 4)),
        ])
    });
    let rows = rows.collect();
    section.numbers(
        [
            "plane",
            "beam angle (50 %)",
            "field angle (10 %)",
            "largest intensity, half-plane",
        ]
        .map(str::to_owned)
        .to_vec(),
        rows,
    );
}

fn illuminance_on_the_axis(section: &mut Section, shown: &IntensityDistribution) {
    if let Some(cones) = cones(shown) {
        let rows = cones
            .iter()
            .map(|cone| {
                let [c0, c90] = cone.width_m.map(|width| format!("{width:.2} m"));
                vec![
                    format!("{} m", cone.distance_m),
                    format!("{} lx", significant(cone.axis_lx, 3)),
                    c0,
                    c90,
                ]
            })
            .collect();
        section.numbers(
            [
                "distance",
                "illuminance on the axis",
                "width in C0–C180",
                "width in C90–C270",
            ]
            .map(str::to_owned)
            .to_vec(),
            rows,
        );
    }
}

/// Two standard uncertainties of a direction without light: intensities up to this cannot be told from none.
pub fn doubtful_cd(day_results: &DayResults) -> f64 {
    let reduction = &day_results.reduction;
    let nodes = reduction.grid.nodes.iter();
    let own = nodes.map(isolux_reduce::Sample::u_own_cd).fold(f64::INFINITY, f64::min);
    let common = reduction.common.dark_noise_cd.hypot(reduction.common.dark_digit_cd);
    2.0 * own.hypot(common)
}

/// The same in words.
pub fn below(day_results: &DayResults) -> String {
    let per_klm = 1000.0 * doubtful_cd(day_results) / day_results.reduction.flux.value;
    format!(
        "Dotted grey, within the shade: below {} cd/klm, the expanded uncertainty (k = 2) of no light.",
        significant(per_klm, 2)
    )
}

pub fn flux(day_results: &DayResults) -> Section {
    let reduction = &day_results.reduction;
    let shown = &reduction.grid.distribution;
    let mut section = Section::new("Luminous flux");
    section.paragraph(format!("Luminous flux {}.", reduction.flux.stated()));
    let total = shown.flux_lm();
    let row = |name: &str, from: f64, to: f64| {
        let lm = shown.flux_between_lm(from, to);
        vec![
            name.to_owned(),
            format!("{} lm", flux_digits(lm, day_results)),
            format!("{:.1} %", 100.0 * lm / total),
        ]
    };
    let rows = vec![
        row("lower hemisphere, γ 0–90°", 0.0, 90.0),
        row("upper hemisphere, γ 90–180°", 90.0, 180.0),
        row("zone 0–30°", 0.0, 30.0),
        row("zone 0–40°", 0.0, 40.0),
        row("zone 0–60°", 0.0, 60.0),
        row("zone 60–90°", 60.0, 90.0),
        row("in a cone of 90°", 0.0, 45.0),
        row("in a cone of 120°", 0.0, 60.0),
    ];
    section.numbers(["", "flux", "of the total"].map(str::to_owned).to_vec(), rows);
    section.figures([(
        zones(&shown.zonal_flux_lm(ZONE_DEG), ZONE_DEG),
        "Zonal luminous flux in steps of 10° of γ.",
    )]);
    if let Some(code) = quantities(day_results).cie_flux_code {
        let code = code.map(|share| format!("{share:.0}"));
        section.paragraph(format!("CIE flux code (CIE 52) {}.", code.join(" ")));
    }
    section
}

/// Lumen to the place that the flux's own uncertainty leaves, and one digit more for the parts of it.
fn flux_digits(lm: f64, day_results: &DayResults) -> String {
    let flux = &day_results.reduction.flux;
    isolux_units::digits::value_at(lm, 0.2 * flux.u_of_parts, -3)
}

pub fn glare(day_results: &DayResults) -> Section {
    let mut section = Section::new("Glare");
    let quantities = quantities(day_results);
    let Some(area_mm2) = quantities.luminous_area_mm2 else {
        section.paragraph("The station states no luminous area: neither luminance nor UGR can be given.");
        return section;
    };
    section.paragraph(format!(
        "Mean luminance of the luminous area of {} mm² as it is seen from C and γ, in cd/m². U is not evaluated: the area is a \
         stated one.",
        significant(area_mm2, 4)
    ));
    if let Some(table) = &quantities.luminance {
        luminance(&mut section, table);
    }
    match &quantities.ugr {
        Some(table) => {
            let (head, rows, note) = ugr(table);
            section.subheading("UGR, corrected for the luminous flux (CIE 117, CIE 190)");
            section.numbers(head, rows);
            section.paragraph(note);
        }
        None => section.paragraph("UGR is not given: it needs light below the horizontal."),
    }
    section
}

/// The table by γ and half-plane, and what luminaires that are mirrored in screens may have.
fn luminance(section: &mut Section, table: &LuminanceTable) {
    const PLANES: usize = 12;
    let every = table.c_deg.len().div_ceil(PLANES);
    let planes = || (0..table.c_deg.len()).step_by(every);
    let head = std::iter::once(String::new()).chain(planes().map(|plane| format!("C {}", angle(table.c_deg[plane]))));
    let rows = table.gamma_deg.iter().zip(&table.cd_m2).map(|(gamma, row)| {
        let cells = planes().map(|plane| row[plane].map_or_else(|| "–".to_owned(), |value| significant(value, 3)));
        std::iter::once(format!("γ {gamma}°")).chain(cells).collect()
    });
    let rows = rows.collect();
    section.numbers(head.collect(), rows);
    let words = |limit: f64| {
        if table.largest_from_65_cd_m2 <= limit {
            "kept"
        } else {
            "exceeded"
        }
    };
    let [bright, other] = SCREEN_LIMITS_CD_M2;
    section.paragraph(format!(
        "From γ 65° on at most {} cd/m². EN 12464-1:2011 (case A: dark characters on light ground) allows \
         {bright:.0} cd/m² where screens are brighter than {SCREEN_LUMINANCE_CD_M2:.0} cd/m²: {}; else {other:.0} cd/m²: {}.",
        significant(table.largest_from_65_cd_m2, 3),
        words(bright),
        words(other)
    ));
}

/// The table of 19 rooms: crosswise for the five sets of reflectances, then endwise.
fn ugr(table: &GlareTable) -> (Vec<String>, Vec<Vec<String>>, &'static str) {
    let set = |set: &[f64; 3]| set.map(|part| format!("{part:.0}")).join("/");
    let sets = &table.reflectance_percent;
    let mut head = vec!["room".to_owned()];
    head.extend(sets.iter().map(|one| format!("× {}", set(one))));
    head.extend(sets.iter().map(|one| format!("= {}", set(one))));
    let number = |value: &Option<f64>| value.map_or_else(|| "–".to_owned(), |ugr| format!("{ugr:.1}"));
    let rows = table.room_h.iter().zip(&table.crosswise).zip(&table.endwise);
    let rows = rows
        .map(|((room, crosswise), endwise)| {
            let room = room.map(|side| format!("{side:.0}H")).join(" × ");
            let numbers = crosswise.iter().chain(endwise).map(number);
            std::iter::once(room).chain(numbers).collect()
        })
        .collect();
    let note = "× crosswise, = endwise; reflectances of ceiling, walls and floor in %; spacing 0.25 H. It assumes luminaires of one \
        kind in a regular array, as the standard rooms have them.";
    (head, rows, note)
}

/// Intensities, at most so many γ and half-planes that a page can hold; the files have all of them.
pub fn tables(day_results: &DayResults) -> Section {
    const PLANES: usize = 12;
    const STEP_DEG: f64 = 5.0;
    let shown = &day_results.reduction.grid.distribution;
    let mut section = Section::new("Table of luminous intensity");
    let high = shown.peak().intensity_cd;
    let gammas: Vec<f64> = shown
        .gamma_deg()
        .iter()
        .copied()
        .filter(|gamma| (gamma / STEP_DEG).fract().abs() < 1e-9)
        .collect();
    let gammas = if gammas.len() < 5 {
        shown.gamma_deg().to_vec()
    } else {
        gammas
    };
    let illuminated = |gamma: f64| {
        shown
            .c_deg()
            .iter()
            .any(|c| shown.intensity_cd_at(*c, gamma) > 5e-4 * high)
    };
    let last = gammas
        .iter()
        .rposition(|gamma| illuminated(*gamma))
        .map_or(gammas.len(), |last| last + 1);
    for planes in chosen(shown).chunks(PLANES) {
        let head = std::iter::once("γ".to_owned()).chain(planes.iter().map(|c| format!("C {}", angle(*c))));
        let rows = gammas
            .iter()
            .take(last)
            .map(|gamma| {
                let cells = planes.iter().map(|c| candela(shown.intensity_cd_at(*c, *gamma), high));
                std::iter::once(angle(*gamma)).chain(cells).collect()
            })
            .collect();
        section.numbers(head.collect(), rows);
    }
    section.paragraph(format!(
        "Luminous intensity in cd. {} Every direction that was measured is in luminaire.ldt, luminaire.ies and luminaire.xml.",
        if last < gammas.len() {
            format!("Above γ {} it is less than 0.05 % of the largest.", angle(gammas[last.saturating_sub(1)]))
        } else {
            String::new()
        }
    ));
    section
}

/// All half-planes, or every second, third … of many.
fn chosen(shown: &IntensityDistribution) -> Vec<f64> {
    const MOST: usize = 24;
    if shown.is_rotational() {
        return vec![0.0];
    }
    let stride = shown.c_deg().len().div_ceil(MOST).max(1);
    shown.c_deg().iter().copied().step_by(stride).collect()
}

/// To a hundredth of a per cent of the largest: finer digits are noise.
fn candela(cd: f64, high: f64) -> String {
    isolux_units::digits::value_at(cd, 1e-3 * high, -4)
}
