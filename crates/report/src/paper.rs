//! A report laid out on A4: which line of text, rule and picture stands where on which page.
//!
//! Lengths are in points, y downwards from the upper edge. Headings stay with what follows them, rows of tables and
//! pictures are never split, a table that goes on over the page repeats its head.

mod tables;

use crate::document::{Block, Document, Figure, Section};
use crate::html::Tile;

/// Width and height of A4.
pub const A4: (f32, f32) = (595.28, 841.89);
const LEFT: f32 = 45.0;
const TOP: f32 = 45.0;
/// Lowest baseline of the text; the foot is below.
const BOTTOM: f32 = 785.0;
/// Width of the text.
pub const WIDTH: f32 = A4.0 - 2.0 * LEFT;
/// Baseline of the foot.
const FOOT: f32 = 808.0;

/// Colours of text and rules.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ink {
    /// Text.
    Text,
    /// What is less important.
    Muted,
    /// Rules.
    Line,
    /// Ground of a verdict.
    Card,
    /// A good verdict.
    Good,
    /// A bad verdict.
    Bad,
}

/// How a line of text is set.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Style {
    /// Size in points.
    pub size: f32,
    /// Whether it is bold.
    pub bold: bool,
    /// Its colour.
    pub ink: Ink,
}

/// A thing on a page.
#[derive(Debug, Clone, PartialEq)]
pub enum Item {
    /// A line of text at its baseline.
    Text {
        /// Its left end.
        x: f32,
        /// Its baseline.
        y: f32,
        /// How it is set.
        style: Style,
        /// What it says.
        text: String,
    },
    /// A filled rectangle: rules are thin ones.
    Box {
        /// Left, top, width, height.
        at: [f32; 4],
        /// Its colour.
        ink: Ink,
    },
    /// A picture.
    Picture {
        /// Left, top, width, height.
        at: [f32; 4],
        /// Its SVG.
        svg: String,
    },
}

/// Widths of letters, as the fonts have them.
pub trait Measure {
    /// Width of a text in points.
    fn width(&self, text: &str, style: Style) -> f32;
}

const fn style(size: f32, bold: bool, ink: Ink) -> Style {
    Style { size, bold, ink }
}

const BODY: Style = style(9.0, false, Ink::Text);
const SMALL: Style = style(7.5, false, Ink::Muted);
const CELL: Style = style(8.0, false, Ink::Text);

/// Things that stay together, measured from their own top.
#[derive(Debug, Clone, Default)]
struct Piece {
    items: Vec<Item>,
    height: f32,
    /// Room left free above, not at the top of a page.
    above: f32,
    /// Whether the next piece must begin on the same page.
    with_next: bool,
    /// What is repeated where this piece is the first on a page: the head of its table.
    head: Option<Box<Piece>>,
}

/// The pages of a report; the foot of each says what the report is and its number of how many.
pub fn pages(document: &Document, fonts: &dyn Measure) -> Vec<Vec<Item>> {
    let layout = Layout { fonts };
    let mut pieces = layout.title(document);
    for section in &document.sections {
        layout.section(section, &mut pieces);
    }
    let mut pages = broken(pieces);
    let count = pages.len();
    for (place, page) in pages.iter_mut().enumerate() {
        let number = format!("{} / {count}", place + 1);
        let x = LEFT + WIDTH - fonts.width(&number, SMALL);
        page.push(Item::Box {
            at: [LEFT, FOOT - 11.0, WIDTH, 0.5],
            ink: Ink::Line,
        });
        page.push(text(
            LEFT,
            FOOT,
            SMALL,
            fitted(&document.foot, WIDTH - 60.0, SMALL, fonts),
        ));
        page.push(text(x, FOOT, SMALL, number));
    }
    pages
}

/// Pieces one under the other; one that does not fit begins a page, and takes with it what must stay with it.
fn broken(pieces: Vec<Piece>) -> Vec<Vec<Item>> {
    let mut pages: Vec<Vec<Item>> = vec![Vec::new()];
    let mut y = TOP;
    let mut place = 0;
    while place < pieces.len() {
        // A heading and what it is of.
        let mut last = place;
        while pieces[last].with_next && last + 1 < pieces.len() {
            last += 1;
        }
        let group = &pieces[place..=last];
        let height: f32 = group.iter().map(|piece| piece.above + piece.height).sum();
        let first = |page: &[Item]| page.is_empty();
        if !pages.last().is_none_or(|page| first(page)) && y + height > BOTTOM {
            pages.push(Vec::new());
            y = TOP;
        }
        for piece in group {
            let Some(page) = pages.last_mut() else { continue };
            if first(page) {
                if let Some(head) = &piece.head {
                    page.extend(head.items.iter().map(|item| moved(item, y)));
                    y += head.height;
                }
            } else {
                y += piece.above;
            }
            page.extend(piece.items.iter().map(|item| moved(item, y)));
            y += piece.height;
        }
        place = last + 1;
    }
    pages
}

fn moved(item: &Item, by: f32) -> Item {
    let mut item = item.clone();
    match &mut item {
        Item::Text { y, .. } => *y += by,
        Item::Box { at, .. } | Item::Picture { at, .. } => at[1] += by,
    }
    item
}

fn text(x: f32, y: f32, style: Style, text: impl Into<String>) -> Item {
    Item::Text {
        x,
        y,
        style,
        text: text.into(),
    }
}

/// The text, cut with an ellipsis where it is wider.
fn fitted(words: &str, width: f32, style: Style, fonts: &dyn Measure) -> String {
    if fonts.width(words, style) <= width {
        return words.to_owned();
    }
    let mut cut = words.to_owned();
    while !cut.is_empty() && fonts.width(&format!("{cut}…"), style) > width {
        cut.pop();
    }
    format!("{}…", cut.trim_end())
}

/// The text in lines of at most `width`; words that are wider are broken.
fn wrapped(words: &str, width: f32, style: Style, fonts: &dyn Measure) -> Vec<String> {
    let mut lines = Vec::new();
    for paragraph in words.split('\n') {
        let mut line = String::new();
        for word in paragraph.split(' ') {
            let longer = if line.is_empty() {
                word.to_owned()
            } else {
                format!("{line} {word}")
            };
            if fonts.width(&longer, style) <= width {
                line = longer;
                continue;
            }
            if !line.is_empty() {
                lines.push(std::mem::take(&mut line));
            }
            for letter in word.chars() {
                line.push(letter);
                if fonts.width(&line, style) > width && line.chars().count() > 1 {
                    line.pop();
                    lines.push(std::mem::replace(&mut line, letter.to_string()));
                }
            }
        }
        lines.push(line);
    }
    lines
}

/// Width and height that a picture states for itself.
fn extent(svg: &str) -> (f32, f32) {
    let number = |key: &str| -> Option<f32> {
        let from = svg.split_once(&format!(" {key}=\""))?.1;
        from.split_once('"')?.0.parse().ok()
    };
    (
        number("width").filter(|w| *w > 0.0).unwrap_or(400.0),
        number("height").filter(|h| *h > 0.0).unwrap_or(300.0),
    )
}

struct Layout<'a> {
    fonts: &'a dyn Measure,
}

impl Layout<'_> {
    fn title(&self, document: &Document) -> Vec<Piece> {
        let mut piece = Piece {
            with_next: true,
            ..Piece::default()
        };
        for (words, style) in [
            (&document.title, style(18.0, true, Ink::Text)),
            (&document.subtitle, style(9.0, false, Ink::Muted)),
        ] {
            for line in wrapped(words, WIDTH, style, self.fonts) {
                piece.height += 1.25 * style.size;
                piece
                    .items
                    .push(text(LEFT, piece.height - 0.3 * style.size, style, line));
            }
        }
        vec![piece]
    }

    fn section(&self, section: &Section, pieces: &mut Vec<Piece>) {
        if !section.heading.is_empty() {
            pieces.push(self.heading(&section.heading, style(13.0, true, Ink::Text), 18.0, true));
        }
        for block in &section.blocks {
            self.block(block, pieces);
        }
        // A heading that nothing follows stands alone.
        if let Some(last) = pieces.last_mut() {
            last.with_next = false;
        }
    }

    fn heading(&self, words: &str, style: Style, above: f32, rule: bool) -> Piece {
        let mut items = vec![text(LEFT, style.size, style, fitted(words, WIDTH, style, self.fonts))];
        if rule {
            items.push(Item::Box {
                at: [LEFT, style.size + 4.0, WIDTH, 0.6],
                ink: Ink::Line,
            });
        }
        Piece {
            items,
            height: style.size + 9.0,
            above,
            with_next: true,
            head: None,
        }
    }

    fn block(&self, block: &Block, pieces: &mut Vec<Piece>) {
        match block {
            Block::Paragraph(words) => self.paragraph(words, BODY, pieces),
            Block::Subheading(words) => pieces.push(self.heading(words, style(10.0, true, Ink::Text), 10.0, false)),
            Block::Verdict(words, good) => pieces.push(self.verdict(words, *good)),
            Block::Tiles(tiles) => self.tiles(tiles, pieces),
            Block::Table(table) => self.table(table, pieces),
            Block::Figures(figures) => self.figures(figures, pieces),
            Block::Details(summary, lines) => {
                pieces.push(self.heading(summary, style(9.0, true, Ink::Muted), 6.0, false));
                for line in lines {
                    self.paragraph(line, SMALL, pieces);
                }
            }
            Block::Files(files) => {
                for (name, what) in files {
                    self.paragraph(&format!("{name}: {what}"), CELL, pieces);
                }
            }
            Block::Screen(_) => {}
        }
    }

    /// Lines; the first two and the last two stay together.
    fn paragraph(&self, words: &str, style: Style, pieces: &mut Vec<Piece>) {
        let lines = wrapped(words, WIDTH, style, self.fonts);
        let count = lines.len();
        for (place, line) in lines.into_iter().enumerate() {
            pieces.push(Piece {
                items: vec![text(LEFT, style.size, style, line)],
                height: 1.35 * style.size,
                above: if place == 0 { 0.45 * style.size } else { 0.0 },
                with_next: place + 1 < count && (place == 0 || place + 2 == count),
                head: None,
            });
        }
    }

    fn verdict(&self, words: &str, good: bool) -> Piece {
        let style = style(9.5, false, Ink::Text);
        let lines = wrapped(words, WIDTH - 20.0, style, self.fonts);
        let height = 12.0 + 13.0 * lines.len() as f32;
        let mut items = vec![
            Item::Box {
                at: [LEFT, 0.0, WIDTH, height - 4.0],
                ink: Ink::Card,
            },
            Item::Box {
                at: [LEFT, 0.0, 3.0, height - 4.0],
                ink: if good { Ink::Good } else { Ink::Bad },
            },
        ];
        for (place, line) in lines.into_iter().enumerate() {
            items.push(text(LEFT + 11.0, 13.0 + 13.0 * place as f32, style, line));
        }
        Piece {
            items,
            height,
            above: 6.0,
            ..Piece::default()
        }
    }

    /// Four beside each other; value above its note, both in as many lines as they need.
    fn tiles(&self, tiles: &[Tile], pieces: &mut Vec<Piece>) {
        const COLUMNS: usize = 4;
        const GAP: f32 = 8.0;
        let width = (WIDTH - GAP * (COLUMNS as f32 - 1.0)) / COLUMNS as f32;
        let (name, value) = (style(7.5, false, Ink::Muted), style(11.0, true, Ink::Text));
        for row in tiles.chunks(COLUMNS) {
            let mut items = Vec::new();
            let mut tallest: f32 = 0.0;
            for (place, tile) in row.iter().enumerate() {
                let x = LEFT + place as f32 * (width + GAP) + 6.0;
                let mut y = 5.0;
                for (words, style) in [(&tile.name, name), (&tile.value, value), (&tile.note, name)] {
                    for line in wrapped(words, width - 12.0, style, self.fonts) {
                        y += 1.25 * style.size;
                        items.push(text(x, y - 0.2 * style.size, style, line));
                    }
                }
                tallest = tallest.max(y + 5.0);
            }
            for place in 0..row.len() {
                let x = LEFT + place as f32 * (width + GAP);
                for at in [
                    [x, 0.0, width, 0.5],
                    [x, tallest, width, 0.5],
                    [x, 0.0, 0.5, tallest],
                    [x + width, 0.0, 0.5, tallest + 0.5],
                ] {
                    items.push(Item::Box { at, ink: Ink::Line });
                }
            }
            pieces.push(Piece {
                items,
                height: tallest + 1.0,
                above: 7.0,
                ..Piece::default()
            });
        }
    }

    /// Pictures beside each other, two in a row, each with its caption below.
    fn figures(&self, figures: &[Figure], pieces: &mut Vec<Piece>) {
        const GAP: f32 = 14.0;
        const TALLEST: f32 = 300.0;
        for row in figures.chunks(2) {
            let width = (WIDTH - GAP * (row.len() as f32 - 1.0)) / row.len() as f32;
            let sizes: Vec<(f32, f32)> = row
                .iter()
                .map(|figure| {
                    let (w, h) = extent(&figure.svg);
                    // Pictures are drawn for a screen of 96 dots an inch; larger than 0.9 of that they look coarse.
                    let scale = (width / w).min(TALLEST / h).min(0.9);
                    (w * scale, h * scale)
                })
                .collect();
            let tallest = sizes.iter().map(|size| size.1).fold(0.0, f32::max);
            let mut items = Vec::new();
            let mut height = tallest;
            for (place, (figure, (w, h))) in row.iter().zip(sizes).enumerate() {
                let x = LEFT + place as f32 * (width + GAP);
                items.push(Item::Picture {
                    at: [x, tallest - h, w, h],
                    svg: figure.svg.clone(),
                });
                let mut y = tallest + 2.0;
                for line in wrapped(&figure.caption, width, SMALL, self.fonts) {
                    y += 1.3 * SMALL.size;
                    items.push(text(x, y, SMALL, line));
                }
                height = height.max(y + 3.0);
            }
            pieces.push(Piece {
                items,
                height,
                above: 8.0,
                ..Piece::default()
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::Table;

    /// Every letter half as wide as it is high.
    struct Typewriter;

    impl Measure for Typewriter {
        fn width(&self, text: &str, style: Style) -> f32 {
            0.5 * style.size * text.chars().count() as f32
        }
    }

    fn document(blocks: Vec<Block>) -> Document {
        Document {
            title: "Lamp".to_owned(),
            foot: "report 7".to_owned(),
            sections: vec![Section {
                heading: "Section".to_owned(),
                blocks,
            }],
            ..Document::default()
        }
    }

    fn said(page: &[Item]) -> Vec<&str> {
        page.iter()
            .filter_map(|item| match item {
                Item::Text { text, .. } => Some(text.as_str()),
                _ => None,
            })
            .collect()
    }

    #[test]
    fn a_table_goes_on_over_the_page_with_its_head_and_nothing_leaves_the_page() {
        let rows = (0..200).map(|k| vec![format!("row {k}"), "value".to_owned()]).collect();
        let table = Table {
            head: vec!["what".to_owned(), "how much".to_owned()],
            rows,
            numbers: false,
        };
        let pages = pages(&document(vec![Block::Table(table)]), &Typewriter);
        assert!(pages.len() > 2);
        let mut rows = 0;
        for (place, page) in pages.iter().enumerate() {
            let said = said(page);
            assert_eq!(
                said.iter().filter(|text| **text == "how much").count(),
                1,
                "page {place}"
            );
            assert!(said.contains(&format!("{} / {}", place + 1, pages.len()).as_str()));
            assert!(said.contains(&"report 7"));
            rows += said.iter().filter(|text| text.starts_with("row ")).count();
            for item in page {
                let (bottom, right) = match item {
                    Item::Text { x, y, style, text } => (*y, x + Typewriter.width(text, *style)),
                    Item::Box { at, .. } | Item::Picture { at, .. } => (at[1] + at[3], at[0] + at[2]),
                };
                assert!(bottom <= FOOT && right <= LEFT + WIDTH + 1.0, "{item:?}");
            }
        }
        assert_eq!(rows, 200);
    }

    #[test]
    fn a_heading_is_never_the_last_thing_on_a_page() {
        for lines in 30..90 {
            let mut blocks: Vec<Block> = (0..lines).map(|k| Block::Paragraph(format!("line {k}"))).collect();
            blocks.push(Block::Subheading("below".to_owned()));
            blocks.push(Block::Paragraph("what it is of".to_owned()));
            let pages = pages(&document(blocks), &Typewriter);
            let holds = |page: &Vec<Item>, words: &str| said(page).contains(&words);
            assert!(
                pages
                    .iter()
                    .any(|page| holds(page, "below") && holds(page, "what it is of")),
                "{lines} lines"
            );
        }
    }

    #[test]
    fn a_word_that_is_wider_than_the_page_is_broken() {
        let word = "x".repeat(500);
        let lines = wrapped(&word, WIDTH, BODY, &Typewriter);
        assert!(lines.len() > 3 && lines.concat() == word);
        assert!(lines.iter().all(|line| Typewriter.width(line, BODY) <= WIDTH));
    }
}
