//! The fonts of a PDF: those in the program, and one of the system for letters that they lack.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use krilla::text::Font;
use usvg::fontdb::{Database, FaceInfo, Style as Slant};

use super::PdfError;
use crate::paper::{Item, Measure, Placed, Style};

const REGULAR: &[u8] = include_bytes!("../../fonts/LiberationSans-Regular.ttf");
const BOLD: &[u8] = include_bytes!("../../fonts/LiberationSans-Bold.ttf");
/// Name of the fonts.
const FAMILY: &str = "Liberation Sans";

/// The fonts in the program, and what was added to them.
pub(super) struct Fonts {
    own: [Font; 2],
    faces: [ttf_parser::Face<'static>; 2],
    added: Vec<Font>,
    /// Which of the added fonts has a letter, and its advance in em.
    letters: BTreeMap<char, (usize, f32)>,
    svg: usvg::Options<'static>,
}

impl Fonts {
    /// Those in the program.
    pub fn new() -> Result<Self, PdfError> {
        let broken = || PdfError("a font in the program is damaged".to_owned());
        let font = |data: &'static [u8]| Font::new(data.into(), 0).ok_or_else(broken);
        let face = |data: &'static [u8]| ttf_parser::Face::parse(data, 0).map_err(|_| broken());
        let mut known = Database::new();
        known.load_font_data(REGULAR.to_vec());
        known.load_font_data(BOLD.to_vec());
        known.set_sans_serif_family(FAMILY);
        Ok(Self {
            own: [font(REGULAR)?, font(BOLD)?],
            faces: [face(REGULAR)?, face(BOLD)?],
            added: Vec::new(),
            letters: BTreeMap::new(),
            svg: usvg::Options {
                font_family: FAMILY.to_owned(),
                fontdb: Arc::new(known),
                ..usvg::Options::default()
            },
        })
    }

    /// How pictures are read.
    pub const fn svg(&self) -> &usvg::Options<'static> {
        &self.svg
    }

    /// The same, of fonts that are not needed any more.
    pub fn into_svg(self) -> usvg::Options<'static> {
        self.svg
    }

    /// Letters on these pages, pictures included, that no font here has.
    pub fn unknown(&self, pages: &[Vec<Placed>]) -> BTreeSet<char> {
        let texts = pages.iter().flatten().filter_map(|placed| match &placed.item {
            Item::Text { text, .. } => Some(text),
            Item::Picture { svg, .. } => Some(svg),
            Item::Box { .. } => None,
        });
        let mut letters: BTreeSet<char> = texts.flat_map(|text| text.chars()).collect();
        letters.retain(|letter| !letter.is_control() && !self.has(*letter));
        letters
    }

    fn has(&self, letter: char) -> bool {
        self.faces.iter().all(|face| face.glyph_index(letter).is_some()) || self.letters.contains_key(&letter)
    }

    /// Adds fonts of the system that have `letters`, as far as there are any.
    pub fn add_from_system(&mut self, letters: &BTreeSet<char>) {
        let mut system = Database::new();
        system.load_system_fonts();
        self.add(&system, letters);
    }

    fn add(&mut self, database: &Database, letters: &BTreeSet<char>) {
        let mut known = (*self.svg.fontdb).clone();
        for (data, index, found) in covering(database, letters) {
            let Some(font) = Font::new(data.clone().into(), index) else {
                continue;
            };
            let place = self.added.len();
            self.added.push(font);
            self.letters
                .extend(found.into_iter().map(|(letter, em)| (letter, (place, em))));
            known.load_font_data(data);
        }
        self.svg.fontdb = Arc::new(known);
    }

    fn face(&self, style: Style) -> &ttf_parser::Face<'static> {
        &self.faces[usize::from(style.bold)]
    }

    /// A text in pieces of one font each; a letter that no font has is a question mark.
    pub fn runs(&self, text: &str, style: Style) -> Vec<(&Font, String)> {
        let own = &self.own[usize::from(style.bold)];
        let face = self.face(style);
        let mut runs: Vec<(Option<usize>, String)> = Vec::new();
        for letter in text.chars() {
            let (of, letter) = match (face.glyph_index(letter), self.letters.get(&letter)) {
                (Some(_), _) => (None, letter),
                (None, Some((place, _))) => (Some(*place), letter),
                (None, None) => (None, '?'),
            };
            match runs.last_mut() {
                Some((last, words)) if *last == of => words.push(letter),
                _ => runs.push((of, letter.to_string())),
            }
        }
        runs.into_iter()
            .map(|(of, words)| (of.map_or(own, |place| &self.added[place]), words))
            .collect()
    }

    /// Width of a text in points.
    pub fn width_of(&self, text: &str, style: Style) -> f32 {
        let face = self.face(style);
        let own = |letter: char| {
            let glyph = face.glyph_index(letter)?;
            Some(f32::from(face.glyph_hor_advance(glyph)?) / f32::from(face.units_per_em()))
        };
        let added = |letter: char| self.letters.get(&letter).map(|(_, em)| *em);
        let em: f32 = text
            .chars()
            .map(|letter| {
                own(letter)
                    .or_else(|| added(letter))
                    .or_else(|| own('?'))
                    .unwrap_or(0.0)
            })
            .sum();
        em * style.size
    }
}

impl Measure for Fonts {
    fn width(&self, text: &str, style: Style) -> f32 {
        self.width_of(text, style)
    }
}

/// A font file, the number of the face in it, and the letters taken from it with their advances in em.
type Covering = (Vec<u8>, u32, Vec<(char, f32)>);

/// The fewest faces that have `letters`: the one with the most of them first, so that a word is set in one face. Upright
/// and proportional ones of regular weight before others, then by name: the choice does not depend on the order of a
/// folder.
fn covering(database: &Database, letters: &BTreeSet<char>) -> Vec<Covering> {
    let mut faces: Vec<&FaceInfo> = database.faces().collect();
    faces.sort_by_key(|face| {
        (
            face.style != Slant::Normal,
            face.monospaced,
            face.weight.0.abs_diff(400),
            face.post_script_name.clone(),
        )
    });
    let mut left = letters.clone();
    let mut taken = Vec::new();
    while !left.is_empty() {
        let mut best: Option<(&FaceInfo, Vec<(char, f32)>)> = None;
        for face in &faces {
            let found = database.with_face_data(face.id, |data, index| found(data, index, &left));
            let found = found.unwrap_or_default();
            if found.len() > best.as_ref().map_or(0, |(_, best)| best.len()) {
                best = Some((face, found));
            }
        }
        let Some((face, found)) = best else { break };
        left.retain(|letter| !found.iter().any(|(has, _)| has == letter));
        let data = database.with_face_data(face.id, |data, index| (data.to_vec(), index));
        taken.extend(data.map(|(data, index)| (data, index, found)));
    }
    taken
}

/// Those of `letters` that a face has, with their advances in em.
fn found(data: &[u8], index: u32, letters: &BTreeSet<char>) -> Vec<(char, f32)> {
    let Ok(face) = ttf_parser::Face::parse(data, index) else {
        return Vec::new();
    };
    let advance = |letter: char| {
        let glyph = face.glyph_index(letter)?;
        Some(f32::from(face.glyph_hor_advance(glyph)?) / f32::from(face.units_per_em()))
    };
    letters
        .iter()
        .filter_map(|letter| Some((*letter, advance(*letter)?)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paper::Ink;

    const PLAIN: Style = Style {
        size: 10.0,
        bold: false,
        ink: Ink::Text,
    };

    fn liberation() -> Database {
        let mut database = Database::new();
        database.load_font_data(BOLD.to_vec());
        database.load_font_data(REGULAR.to_vec());
        database
    }

    #[test]
    fn the_face_of_regular_weight_is_taken_and_a_letter_that_no_face_has_is_left() {
        let taken = covering(&liberation(), &BTreeSet::from(['a', 'Ж', '照']));
        let [(data, 0, letters)] = &taken[..] else {
            panic!("one face is enough: {} faces", taken.len())
        };
        assert_eq!(data, REGULAR);
        assert_eq!(letters.iter().map(|(letter, _)| *letter).collect::<String>(), "aЖ");
        assert!(covering(&liberation(), &BTreeSet::from(['照'])).is_empty());
    }

    #[test]
    fn a_letter_that_was_added_is_set_in_its_own_font_and_measured_by_it() {
        let mut fonts = Fonts::new().unwrap();
        let before = fonts.width_of("a照b", PLAIN);
        assert_eq!(before, fonts.width_of("a?b", PLAIN));
        assert_eq!(fonts.runs("a照b", PLAIN).len(), 1);
        // No font of this project has the letter: its glyph is that of another one, one em wide.
        fonts.added.push(fonts.own[1].clone());
        fonts.letters.insert('照', (0, 1.0));
        let runs: Vec<String> = fonts.runs("a照b", PLAIN).into_iter().map(|(_, words)| words).collect();
        assert_eq!(runs, ["a", "照", "b"]);
        assert_eq!(fonts.width_of("a照b", PLAIN), fonts.width_of("ab", PLAIN) + 10.0);
        let item = Item::Text {
            x: 0.0,
            y: 0.0,
            style: PLAIN,
            text: "a照\u{e123}".to_owned(),
            part: 0,
        };
        let page = vec![Placed { item, of: None }];
        assert_eq!(fonts.unknown(&[page]), BTreeSet::from(['\u{e123}']));
    }
}
