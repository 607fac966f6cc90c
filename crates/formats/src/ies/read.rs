//! LM-63 bytes to absolute candela.

use super::layout;
use super::numbers::Reader;
use super::preamble::{self, Tilt};
use super::scene::Scene;
use super::tilt::tilt_file;
use crate::distribution::Distribution;
use crate::finding::{Finding, Findings};
use crate::options::{Beside, ReadOptions};
use crate::parsed::{Format, Kind, Parsed};
use crate::plausible::{self, Stored};
use crate::text::Text;
use crate::unfinished::unfinished_line;

/// Reads bytes to absolute candela; a tilt file is named, not opened.
pub fn read(bytes: &[u8], options: ReadOptions) -> Parsed<Distribution> {
    read_beside(bytes, options, &|_| Err("only the file itself was given".to_owned()))
}

/// [`read`], and `beside` opens the tilt file.
pub fn read_beside(bytes: &[u8], options: ReadOptions, beside: Beside<'_>) -> Parsed<Distribution> {
    let mut findings = Findings::new();
    let text = Text::decode(bytes, &mut findings);
    unfinished_line(&text, &mut findings);
    let distribution = distribution(&text, options, beside, &mut findings);
    Parsed::new(Format::IES, Kind::Distribution, distribution, findings)
}

fn distribution(
    text: &Text<'_>,
    options: ReadOptions,
    beside: Beside<'_>,
    findings: &mut Findings,
) -> Option<Distribution> {
    let Some(preamble) = preamble::read(text, findings) else {
        findings.push(
            Finding::error("ies-truncated", "no line begins with TILT= and no line holds numbers")
                .at(text.len().max(1), 1)
                .raw(text.line(text.len().saturating_sub(1)))
                .fix("fetch the file again"),
        );
        return None;
    };
    let tokens = layout::tokens(text, preamble.numbers_from, findings);
    let mut reader = Reader {
        tokens: &tokens,
        findings,
    };
    let (tilt, start) = match &preamble.tilt {
        Tilt::None => (None, 0),
        Tilt::Include => reader.tilt().map(|(tilt, start)| (Some(tilt), start))?,
        Tilt::File(name) => {
            let place = (preamble.tilt_line.unwrap_or(0) + 1, 6);
            (tilt_file(name, place, beside, reader.findings), 0)
        }
    };
    let layout = layout::find(&tokens, start, text, reader.findings)?;
    let vertical = reader.block(layout.vertical, layout.nv, "vertical angle", "ies-angle-number");
    let horizontal = reader.block(layout.horizontal, layout.nh, "horizontal angle", "ies-angle-number");
    let values = reader.block(
        layout.candela,
        layout.nv * layout.nh,
        "candela value",
        "ies-candela-number",
    );
    let lamp = reader.lamp(start, &layout, preamble.edition, options);
    let (vertical, horizontal, values) = (vertical?, horizontal?, values?);
    let (lamp, factor) = lamp?;
    let candela: Vec<f64> = values.iter().map(|value| value * factor).collect();
    let places: Vec<(usize, usize)> = tokens[layout.candela..]
        .iter()
        .take(values.len())
        .map(|token| (token.line + 1, token.column))
        .collect();
    let scene = Scene {
        text,
        preamble: &preamble,
        lamp: &lamp,
        layout: &layout,
        tokens: &tokens,
    };
    scene.unit(findings);
    let (grid, symmetry, native) = scene.grid(&vertical, &horizontal, &candela, findings)?;
    let raws = |index: usize| tokens[layout.candela + index].text;
    plausible::check(
        &Stored {
            planes_deg: &horizontal,
            angles_deg: &vertical,
            values: &values,
            places: &places,
            raw: &raws,
            poles: lamp.photometric_type == 'C',
        },
        findings,
    );
    let lumens_at = tokens.get(start + 1).map(|token| (token.line + 1, token.column));
    plausible::flux(&grid, lamp.flux_lm(), lumens_at, None, findings);
    let header = scene.header(tilt.as_ref(), &vertical, &horizontal);
    Some(Distribution {
        intensity: grid,
        symmetry,
        lamp_flux_lm: lamp.flux_lm(),
        absolute: lamp.absolute,
        native,
        luminaire: scene.luminaire(),
        header,
        eulumdat: None,
    })
}
