//! A report as PDF, with its fonts inside and without a browser: the pages of `paper` drawn by krilla, tagged for
//! readers who do not see them (PDF/UA-1) and for archives (PDF/A-2a).

mod fonts;
mod tags;

use std::collections::BTreeSet;

use krilla::SerializeSettings;
use krilla::color::rgb;
use krilla::configure::{Accessibility, Archival, ConfigurationBuilder};
use krilla::geom::{PathBuilder, Point, Rect, Size, Transform};
use krilla::metadata::{DateTime, Metadata};
use krilla::page::PageSettings;
use krilla::paint::Fill;
use krilla::surface::Surface;
use krilla::tagging::{Artifact, ArtifactType, ContentTag, SpanTag};
use krilla::text::TextDirection;
use krilla_svg::{SurfaceExt as _, SvgSettings};

use self::fonts::Fonts;
use self::tags::Tags;
use crate::document::Document;
use crate::paper::{self, A4, Ink, Item, Placed};

/// Why there is no PDF.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PdfError(String);

impl std::fmt::Display for PdfError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "the report cannot be set as PDF: {}", self.0)
    }
}

impl std::error::Error for PdfError {}

impl PdfError {
    pub(crate) fn new(why: impl Into<String>) -> Self {
        Self(why.into())
    }
}

/// How pictures are read: with the fonts in the program.
pub(crate) fn picture_options() -> Result<usvg::Options<'static>, PdfError> {
    Ok(Fonts::new()?.into_svg())
}

/// A report on paper.
#[derive(Debug, Clone)]
pub struct Pdf {
    /// The file.
    pub bytes: Vec<u8>,
    /// Number of its pages.
    pub pages: usize,
    /// Characters that neither the own fonts nor one of the system has: they are drawn as question marks.
    pub unknown: BTreeSet<char>,
    /// What keeps it from being PDF/A-2a and PDF/UA-1; none where it is both.
    pub not_archival: Option<String>,
}

impl Document {
    /// The report on A4. The same report gives the same bytes, on one machine where it needs a font of the system.
    ///
    /// # Errors
    /// [`PdfError`] for a picture that is no SVG.
    pub fn pdf(&self) -> Result<Pdf, PdfError> {
        self.in_its_language().paper()
    }

    fn paper(&self) -> Result<Pdf, PdfError> {
        let mut fonts = Fonts::new()?;
        let mut pages = paper::pages(self, &fonts);
        let mut unknown = fonts.unknown(&pages);
        if !unknown.is_empty() {
            fonts.add_from_system(&unknown);
            // The letters that were added are wider or narrower than the question marks in their places.
            pages = paper::pages(self, &fonts);
            unknown = fonts.unknown(&pages);
        }
        let (bytes, not_archival) = match self.set(&pages, &fonts, true)? {
            Ok(bytes) => (bytes, None),
            // A font of the system may not be one that an archive takes.
            Err(why) => {
                let plain = self.set(&pages, &fonts, false)?;
                (plain.map_err(PdfError)?, Some(why))
            }
        };
        Ok(Pdf {
            bytes,
            pages: pages.len(),
            unknown,
            not_archival,
        })
    }

    /// The pages as a file; as PDF/A-2a and PDF/UA-1 where `archival`, or why they cannot be that.
    fn set(&self, pages: &[Vec<Placed>], fonts: &Fonts, archival: bool) -> Result<Result<Vec<u8>, String>, PdfError> {
        let mut configuration = ConfigurationBuilder::new();
        if archival {
            configuration = configuration
                .with_archival_validator(Archival::A2_A)
                .with_accessibility_validator(Accessibility::UA1);
        }
        let configuration = configuration.finish().map_err(|error| PdfError(format!("{error:?}")))?;
        let mut file = krilla::Document::new_with(SerializeSettings {
            configuration,
            enable_tagging: true,
            ..SerializeSettings::default()
        });
        let language = self.language.code();
        let mut metadata = Metadata::new()
            .title(self.title.clone())
            .language(language.to_owned())
            .creator(concat!("isolux ", env!("CARGO_PKG_VERSION")).to_owned());
        if let Some(date) = self.date {
            metadata = metadata.creation_date(DateTime::new(date.0).month(date.1).day(date.2));
        }
        file.set_metadata(metadata);
        let mut tags = Tags::default();
        let settings = PageSettings::from_wh(A4.0, A4.1).ok_or_else(|| PdfError("no page of this size".to_owned()))?;
        for (number, items) in pages.iter().enumerate() {
            let mut page = file.start_page_with(settings.clone());
            let mut surface = page.surface();
            for Placed { item, of } in items {
                let tag = match (of, item) {
                    (Some(_), Item::Text { .. }) => ContentTag::Span(SpanTag::empty()),
                    (Some(_), _) => ContentTag::Other,
                    (None, Item::Text { .. }) => artifact(ArtifactType::PaginationOther),
                    (None, _) => artifact(ArtifactType::Layout),
                };
                let identifier = surface.start_tagged(tag);
                draw(item, fonts, &mut surface)?;
                surface.end_tagged();
                if let Some(of) = of {
                    tags.add(*of, item, identifier, number);
                }
            }
            surface.finish();
            page.finish();
        }
        file.set_outline(tags.outline());
        file.set_tag_tree(tags.tree(language));
        Ok(file.finish().map_err(|error| format!("{error:?}")))
    }
}

/// What a reader is not read.
fn artifact(kind: ArtifactType) -> ContentTag<'static> {
    ContentTag::Artifact(Artifact { kind, bbox: None })
}

fn draw(item: &Item, fonts: &Fonts, surface: &mut Surface<'_>) -> Result<(), PdfError> {
    match item {
        Item::Text { x, y, style, text, .. } => {
            surface.set_fill(Some(fill(style.ink)));
            let mut x = *x;
            for (font, words) in fonts.runs(text, *style) {
                let at = Point::from_xy(x, *y);
                surface.draw_text(at, font.clone(), style.size, &words, false, TextDirection::LeftToRight);
                x += fonts.width_of(&words, *style);
            }
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
        Item::Picture {
            at: [x, y, w, h], svg, ..
        } => {
            let tree =
                usvg::Tree::from_str(svg, fonts.svg()).map_err(|error| PdfError(format!("a picture: {error}")))?;
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
        picture.text((20.0, 50.0), Anchor::Start, "#000000", "I in cd");
        let mut section = Section::new("Flux");
        section.paragraph(words);
        section.table(&["γ", "I"], vec![vec!["0°".to_owned(), "1".to_owned()]]);
        section.facts(vec![("maker".to_owned(), "ACME".to_owned())]);
        section.figures([(picture.finish(), "a picture")]);
        Document {
            title: "Lamp".to_owned(),
            date: Some((2026, 11, 28)),
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
        assert_eq!(first.not_archival, None);
        assert_eq!(document(words).pdf().unwrap().bytes, first.bytes);
        // The structure that a screen reader needs, and the marks of both standards.
        let holds = |part: &str| first.bytes.windows(part.len()).any(|found| found == part.as_bytes());
        for part in [
            "/H1",
            "/H2",
            "/THead",
            "/TH",
            "/TD",
            "/Scope/Row",
            "/Scope/Column",
            "/Figure",
            "/Alt(a picture)",
            "pdfuaid:part",
            "pdfaid:part",
        ] {
            assert!(holds(part), "{part}");
        }
        // A letter of no writing system: no font has it.
        assert_eq!(
            document("\u{e123}").pdf().unwrap().unknown,
            BTreeSet::from(['\u{e123}'])
        );
    }
}
