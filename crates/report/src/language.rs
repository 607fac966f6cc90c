//! The report in other languages: every text by the table `language/texts.tsv`, which a translator can edit.
//!
//! A line of the table has the English text, the German and the French one, with tabs between. `{1}`, `{2}`, … stand
//! for what changes from report to report; what stands there is translated in turn. A text that the table does not have
//! stays English. Numbers keep their decimal point, as the files have it.

use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::LazyLock;

use crate::document::{Block, Document, Figure, ReportTable, Section};
use crate::html::Tile;
use crate::svg::escape;

pub use isolux_record::layout::Language;

/// English, German, French.
const TABLE: &str = include_str!("language/texts.tsv");
/// What joins texts that are translated each by itself, in the order in which they are tried.
const JOINTS: [&str; 6] = [" · ", ". ", "; ", ": ", " / ", ", "];

/// An English text with places for what changes, and its translation.
struct Pattern {
    /// The texts between the places.
    literal: Vec<String>,
    /// The number of each place.
    place: Vec<usize>,
    translation: String,
}

struct Texts {
    exact: HashMap<&'static str, &'static str>,
    /// Those that begin with the most letters of their own first, then those with the most in all.
    patterns: Vec<Pattern>,
}

static GERMAN: LazyLock<Texts> = LazyLock::new(|| Texts::of(1));
static FRENCH: LazyLock<Texts> = LazyLock::new(|| Texts::of(2));

impl Texts {
    fn of(column: usize) -> Self {
        let mut texts = Self {
            exact: HashMap::new(),
            patterns: Vec::new(),
        };
        for line in TABLE.lines().filter(|line| !line.is_empty() && !line.starts_with('#')) {
            let cells: Vec<&'static str> = line.split('\t').collect();
            let (Some(&english), Some(&other)) = (cells.first(), cells.get(column)) else {
                continue;
            };
            if english.contains("{1}") {
                texts.patterns.push(Pattern::new(english, other));
            } else {
                texts.exact.insert(english, other);
            }
        }
        texts.patterns.sort_by_key(|pattern| {
            let letters = pattern.literal.iter().map(String::len);
            std::cmp::Reverse((pattern.literal.first().map_or(0, String::len), letters.sum::<usize>()))
        });
        texts
    }

    /// The translation; none where the table has none.
    fn find(&self, text: &str) -> Option<String> {
        if let Some(found) = self.exact.get(text) {
            return Some((*found).to_owned());
        }
        let found = (self.patterns.iter()).find_map(|pattern| Some((pattern, pattern.places(text)?)));
        if let Some((pattern, places)) = found {
            let filled = pattern.place.iter().zip(places);
            return Some(filled.fold(pattern.translation.clone(), |text, (number, what)| {
                text.replace(&format!("{{{number}}}"), &self.translated(what))
            }));
        }
        JOINTS.iter().find_map(|joint| {
            let parts: Vec<&str> = text.split(joint).collect();
            if parts.len() < 2 {
                return None;
            }
            let known: Vec<Option<String>> = parts.iter().map(|part| self.find(part)).collect();
            known.iter().any(Option::is_some).then(|| {
                let parts = known.into_iter().zip(parts);
                let parts: Vec<String> = parts
                    .map(|(known, part)| known.unwrap_or_else(|| part.to_owned()))
                    .collect();
                parts.join(joint)
            })
        })
    }

    /// Whether a part of the text that has words is not in the table.
    fn lacks(&self, text: &str) -> bool {
        if !has_words(text) || self.exact.contains_key(text) {
            return false;
        }
        if self.patterns.iter().any(|pattern| pattern.places(text).is_some()) {
            return false;
        }
        let joint = JOINTS.iter().find(|joint| {
            let mut parts = text.split(**joint);
            text.contains(**joint) && parts.any(|part| self.find(part).is_some())
        });
        joint.is_none_or(|joint| text.split(joint).any(|part| self.lacks(part)))
    }

    fn translated(&self, text: &str) -> String {
        let inner = text.trim();
        match self.find(inner) {
            Some(found) => text.replacen(inner, &found, 1),
            None => text.to_owned(),
        }
    }
}

impl Pattern {
    fn new(english: &str, translation: &str) -> Self {
        let (mut literal, mut place) = (Vec::new(), Vec::new());
        let mut rest = english;
        while let Some((before, number, after)) = rest.split_once('{').and_then(|(before, after)| {
            let (number, after) = after.split_once('}')?;
            Some((before, number.parse().ok()?, after))
        }) {
            literal.push(before.to_owned());
            place.push(number);
            rest = after;
        }
        literal.push(rest.to_owned());
        Self {
            literal,
            place,
            translation: translation.to_owned(),
        }
    }

    /// What stands at the places, where the text is one of this pattern.
    fn places<'a>(&self, text: &'a str) -> Option<Vec<&'a str>> {
        let (first, between) = self.literal.split_first()?;
        let (last, between) = between.split_last()?;
        let mut rest = text.strip_prefix(first.as_str())?.strip_suffix(last.as_str())?;
        let mut places = Vec::new();
        // The last one as far back as it stands: what may hold it itself, a list, comes before it.
        for (number, literal) in between.iter().enumerate() {
            let (place, after) = if number + 1 == between.len() {
                rest.rsplit_once(literal.as_str())?
            } else {
                rest.split_once(literal.as_str())?
            };
            places.push(place);
            rest = after;
        }
        places.push(rest);
        // Few letters of its own fit sentences that say something else: then numbers alone change.
        let letters = self.literal.iter().flat_map(|literal| literal.chars());
        let few = letters.filter(|letter| letter.is_alphabetic()).count() < 5;
        let fits = |place: &&str| {
            let first = place.chars().next();
            first.is_some_and(|first| !few || first.is_ascii_digit() || "+-−±<".contains(first))
        };
        places.iter().all(fits).then_some(places)
    }
}

/// The text in a language.
fn translated(language: Language, text: &str) -> Cow<'_, str> {
    let texts = match language {
        Language::En => return Cow::Borrowed(text),
        Language::De => &GERMAN,
        Language::Fr => &FRENCH,
    };
    Cow::Owned(texts.translated(text))
}

/// Whether a text says something in English that the table does not have.
fn is_untranslated(language: Language, text: &str) -> bool {
    let texts = match language {
        Language::En => return false,
        Language::De => &GERMAN,
        Language::Fr => &FRENCH,
    };
    texts.lacks(text.trim())
}

/// Whether a text has words, not units and symbols alone.
fn has_words(text: &str) -> bool {
    let mut words = text.split(|letter: char| !letter.is_alphabetic());
    words.any(|word| word.chars().count() > 3)
}

impl Document {
    /// The report in its language.
    #[must_use]
    pub fn in_its_language(&self) -> Cow<'_, Self> {
        if self.language == Language::En {
            return Cow::Borrowed(self);
        }
        let mut document = self.clone();
        let language = self.language;
        document.each_text(&mut |text| *text = translated(language, text).into_owned());
        Cow::Owned(document)
    }

    /// Texts of the report that its language lacks.
    pub fn untranslated(&self) -> Vec<String> {
        let mut document = self.clone();
        let mut found = Vec::new();
        document.each_text(&mut |text| {
            if is_untranslated(self.language, text) && !found.contains(text) {
                found.push(text.clone());
            }
        });
        found
    }

    /// Every text but those of files and what only a screen shows.
    fn each_text(&mut self, each: &mut dyn FnMut(&mut String)) {
        each(&mut self.title);
        each(&mut self.subtitle);
        each(&mut self.foot);
        for Section { heading, blocks } in &mut self.sections {
            each(heading);
            for block in blocks {
                match block {
                    Block::Paragraph(text) | Block::Subheading(text) | Block::Verdict(text, _) => each(text),
                    Block::Tiles(tiles) => {
                        for Tile { name, value, note } in tiles {
                            [name, value, note].into_iter().for_each(&mut *each);
                        }
                    }
                    Block::ReportTable(ReportTable { head, rows, .. }) => {
                        head.iter_mut().chain(rows.iter_mut().flatten()).for_each(&mut *each);
                    }
                    Block::Figures(figures) => {
                        for Figure { svg, caption } in figures {
                            each(caption);
                            *svg = in_picture(svg, each);
                        }
                    }
                    Block::Details(summary, lines) => {
                        each(summary);
                        lines.iter_mut().for_each(&mut *each);
                    }
                    Block::Files(files) => files.iter_mut().for_each(|(_, what)| each(what)),
                    Block::Screen(_) => {}
                }
            }
        }
    }
}

/// A picture with `each` applied to its texts.
fn in_picture(svg: &str, each: &mut dyn FnMut(&mut String)) -> String {
    let mut made = String::with_capacity(svg.len());
    let mut rest = svg;
    while let Some(open) = ["<text", "<title"].iter().filter_map(|tag| rest.find(tag)).min() {
        let Some(begin) = rest[open..].find('>').map(|at| open + at + 1) else {
            break;
        };
        let Some(end) = rest[begin..].find('<').map(|at| begin + at) else {
            break;
        };
        made.push_str(&rest[..begin]);
        let mut text = rest[begin..end]
            .replace("&lt;", "<")
            .replace("&gt;", ">")
            .replace("&quot;", "\"")
            .replace("&amp;", "&");
        each(&mut text);
        made.push_str(&escape(&text));
        rest = &rest[end..];
    }
    made.push_str(rest);
    made
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_of_the_table_has_three_texts_with_the_same_places() {
        let mut seen = Vec::new();
        for (number, line) in TABLE.lines().enumerate() {
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            let cells: Vec<&str> = line.split('\t').collect();
            assert_eq!(cells.len(), 3, "line {}: {line}", number + 1);
            assert!(
                !seen.contains(&cells[0]),
                "line {}: {} is there twice",
                number + 1,
                cells[0]
            );
            seen.push(cells[0]);
            let places = |text: &str| {
                (1..9)
                    .filter(|k| text.contains(&format!("{{{k}}}")))
                    .collect::<Vec<_>>()
            };
            for cell in &cells[1..] {
                assert_eq!(places(cell), places(cells[0]), "line {}: {cell}", number + 1);
                assert!(!cell.trim().is_empty(), "line {}", number + 1);
            }
        }
    }

    #[test]
    fn what_changes_keeps_its_place_and_what_is_not_known_stays() {
        let pattern = Pattern::new("{1} of {2} items", "von {2} sind {1} da");
        assert_eq!(pattern.places("3 of 4 items"), Some(vec!["3", "4"]));
        assert_eq!(pattern.places("3 of 4"), None);
        assert_eq!(translated(Language::De, "luminous flux"), "Lichtstrom");
        assert_eq!(translated(Language::Fr, "luminous flux"), "flux lumineux");
        assert_eq!(translated(Language::De, "ACME Spot 12"), "ACME Spot 12");
        assert_eq!(translated(Language::En, "luminous flux"), "luminous flux");
        let picture = "<svg><title>luminous flux</title><text x=\"1\">a &lt; b</text></svg>";
        let german = in_picture(picture, &mut |text| *text = translated(Language::De, text).into_owned());
        assert_eq!(
            german,
            "<svg><title>Lichtstrom</title><text x=\"1\">a &lt; b</text></svg>"
        );
    }
}
