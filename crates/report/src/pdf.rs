//! A report as PDF, with its fonts inside and without a browser: the pages of `paper` drawn by krilla.

use std::collections::BTreeSet;
use std::sync::Arc;

use krilla::color::rgb;
use krilla::geom::{PathBuilder, Point, Rect, Size, Transform};
use krilla::metadata::Metadata;
use krilla::page::PageSettings;
use krilla::paint::Fill;
use krilla::surface::Surface;
use krilla::text::{Font, TextDirection};
use krilla_svg::{SurfaceExt as _, SvgSettings};

use crate::document::Document;
use crate::paper::{self, A4, Ink, Item, Measure, Style};

const REGULAR: &[u8] = include_bytes!("../fonts/LiberationSans-Regular.ttf");
const BOLD: &[u8] = include_bytes!("../fonts/LiberationSans-Bold.ttf");
/// Name of the fonts.
const FAMILY: &str = "Liberation Sans";

/// Why there is no PDF.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PdfError(String);

impl std::fmt::Display for PdfError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "the report cannot be set as PDF: {}", self.0)
    }
}

impl std::error::Error for PdfError {}

/// A report on paper.
#[derive(Debug, Clone)]
pub struct Pdf {
    /// The file.
    pub bytes: Vec<u8>,
    /// Number of its pages.
    pub pages: usize,
    /// Characters that the fonts do not have: they are drawn as question marks.
    pub unknown: BTreeSet<char>,
}

impl Document {
    /// The report on A4. The same report gives the same bytes.
    ///
    /// # Errors
    /// [`PdfError`] for a picture that is no SVG.
    pub fn pdf(&self) -> Result<Pdf, PdfError> {
        let fonts = Fonts::new()?;
        let pages = paper::pages(self, &fonts);
        let mut unknown = BTreeSet::new();
        let mut file = krilla::Document::new();
        file.set_metadata(
            Metadata::new()
                .title(self.title.clone())
                .language("en".to_owned())
                .creator(concat!("isolux ", env!("CARGO_PKG_VERSION")).to_owned()),
        );
        let settings = PageSettings::from_wh(A4.0, A4.1).ok_or_else(|| PdfError("no page of this size".to_owned()))?;
        for items in &pages {
            let mut page = file.start_page_with(settings.clone());
            let mut surface = page.surface();
            for item in items {
                fonts.draw(item, &mut surface, &mut unknown)?;
            }
            surface.finish();
            page.finish();
        }
        let bytes = file.finish().map_err(|error| PdfError(format!("{error:?}")))?;
        Ok(Pdf {
            bytes,
            pages: pages.len(),
            unknown,
        })
    }
}

struct Fonts {
    regular: Font,
    bold: Font,
    faces: [ttf_parser::Face<'static>; 2],
    svg: usvg::Options<'static>,
}

impl Fonts {
    fn new() -> Result<Self, PdfError> {
        let broken = || PdfError("a font in the program is damaged".to_owned());
        let font = |data: &'static [u8]| Font::new(data.into(), 0).ok_or_else(broken);
        let face = |data: &'static [u8]| ttf_parser::Face::parse(data, 0).map_err(|_| broken());
        let mut known = usvg::fontdb::Database::new();
        known.load_font_data(REGULAR.to_vec());
        known.load_font_data(BOLD.to_vec());
        known.set_sans_serif_family(FAMILY);
        Ok(Self {
            regular: font(REGULAR)?,
            bold: font(BOLD)?,
            faces: [face(REGULAR)?, face(BOLD)?],
            svg: usvg::Options {
                font_family: FAMILY.to_owned(),
                fontdb: Arc::new(known),
                ..usvg::Options::default()
            },
        })
    }

    fn face(&self, style: Style) -> &ttf_parser::Face<'static> {
        &self.faces[usize::from(style.bold)]
    }

    fn draw(&self, item: &Item, surface: &mut Surface<'_>, unknown: &mut BTreeSet<char>) -> Result<(), PdfError> {
        match item {
            Item::Text { x, y, style, text } => {
                let face = self.face(*style);
                let text: String = text
                    .chars()
                    .map(|letter| {
                        if face.glyph_index(letter).is_some() {
                            return letter;
                        }
                        unknown.insert(letter);
                        '?'
                    })
                    .collect();
                surface.set_fill(Some(fill(style.ink)));
                let font = if style.bold { &self.bold } else { &self.regular };
                let at = Point::from_xy(*x, *y);
                surface.draw_text(at, font.clone(), style.size, &text, false, TextDirection::LeftToRight);
            }
            Item::Box { at: [x, y, w, h], ink } => {
                let Some(rect) = Rect::from_xywh(*x, *y, *w, *h) else {
                    return Ok(());
                };
                let mut path = PathBuilder::new();
                path.push_rect(rect);
                if let Some(path) = path.finish() {
                    surface.set_fill(Some(fill(*ink)));
                    surface.draw_path(&path);
                }
            }
            Item::Picture { at: [x, y, w, h], svg } => {
                let tree =
                    usvg::Tree::from_str(svg, &self.svg).map_err(|error| PdfError(format!("a picture: {error}")))?;
                let Some(size) = Size::from_wh(*w, *h) else {
                    return Ok(());
                };
                surface.push_transform(&Transform::from_translate(*x, *y));
                surface.draw_svg(&tree, size, SvgSettings::default());
                surface.pop();
            }
        }
        Ok(())
    }
}

impl Measure for Fonts {
    fn width(&self, text: &str, style: Style) -> f32 {
        let face = self.face(style);
        let units: f32 = text
            .chars()
            .map(|letter| {
                let glyph = face.glyph_index(letter).or_else(|| face.glyph_index('?'));
                glyph
                    .and_then(|glyph| face.glyph_hor_advance(glyph))
                    .map_or(0.0, f32::from)
            })
            .sum();
        units * style.size / f32::from(face.units_per_em())
    }
}

fn fill(ink: Ink) -> Fill {
    let [r, g, b] = match ink {
        Ink::Text => [0x22, 0x28, 0x31],
        Ink::Muted => [0x5b, 0x65, 0x70],
        Ink::Line => [0xc9, 0xcf, 0xd6],
        Ink::Card => [0xf3, 0xf5, 0xf7],
        Ink::Good => [0x2e, 0x7d, 0x4f],
        Ink::Bad => [0xb3, 0x26, 0x1e],
    };
    Fill {
        paint: rgb::Color::new(r, g, b).into(),
        ..Fill::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::Section;
    use crate::svg::{Anchor, Svg};

    fn document(words: &str) -> Document {
        let mut picture = Svg::new(200.0, 100.0, "picture");
        picture.text((20.0, 50.0), 12.0, Anchor::Start, "#000000", "I in cd");
        let mut section = Section::new("Flux");
        section.paragraph(words);
        section.figures([(picture.finish(), "a picture")]);
        Document {
            title: "Lamp".to_owned(),
            sections: vec![section],
            ..Document::default()
        }
    }

    #[test]
    fn the_same_report_gives_the_same_bytes_and_has_every_letter_of_the_field() {
        let words = "Φ ± 2σ, W/m², °, γ, λ, Δu′v′, µm, ÷, ×, ≥, ≤, –, …, → √ Σ";
        let first = document(words).pdf().unwrap();
        assert!(first.bytes.starts_with(b"%PDF-") && first.pages == 1);
        assert_eq!(first.unknown, BTreeSet::new());
        assert_eq!(document(words).pdf().unwrap().bytes, first.bytes);
        assert_eq!(document("灯").pdf().unwrap().unknown, BTreeSet::from(['灯']));
    }
}
