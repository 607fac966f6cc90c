//! A report laid out on A4: which line of text, rule and picture stands where on which page.
//!
//! Lengths are in points, y downwards from the upper edge. Headings stay with what follows them, rows of tables and
//! pictures are never split, a table that goes on over the page repeats its head.

mod blocks;
mod piece;
mod tables;

use self::blocks::Layout;
pub use self::piece::{A4, Ink, Item, Kind, Measure, Of, Placed, Style, WIDTH};
use self::piece::{BOTTOM, FOOT, LEFT, Piece, SMALL, TOP, fitted, text};
use crate::document::Document;

/// The pages of a report; the foot of each says what the report is and its number of how many.
pub fn pages(document: &Document, fonts: &dyn Measure) -> Vec<Vec<Placed>> {
    let layout = Layout::new(fonts);
    let mut pieces = layout.title(document);
    for section in &document.sections {
        layout.section(section, &mut pieces);
    }
    let mut pages = broken(pieces);
    let count = pages.len();
    for (place, page) in pages.iter_mut().enumerate() {
        let number = format!("{} / {count}", place + 1);
        let x = LEFT + WIDTH - fonts.width(&number, SMALL);
        let rule = Item::Box {
            at: [LEFT, FOOT - 11.0, WIDTH, 0.5],
            ink: Ink::Line,
        };
        let foot = fitted(&document.foot, WIDTH - 60.0, SMALL, fonts);
        let items = [rule, text(LEFT, FOOT, SMALL, foot), text(x, FOOT, SMALL, number)];
        page.extend(items.map(|item| Placed { item, of: None }));
    }
    pages
}

/// Pieces one under the other; one that does not fit begins a page, and takes with it what must stay with it.
fn broken(pieces: Vec<Piece>) -> Vec<Vec<Placed>> {
    let mut pages: Vec<Vec<Placed>> = vec![Vec::new()];
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
        let first = |page: &[Placed]| page.is_empty();
        if !pages.last().is_none_or(|page| first(page)) && y + height > BOTTOM {
            pages.push(Vec::new());
            y = TOP;
        }
        for piece in group {
            let Some(page) = pages.last_mut() else { continue };
            if first(page) {
                if let Some(head) = &piece.head {
                    // A head that is repeated says nothing new.
                    page.extend(head.items.iter().map(|item| moved(item, y, None)));
                    y += head.height;
                }
            } else {
                y += piece.above;
            }
            page.extend(piece.items.iter().map(|item| moved(item, y, piece.of)));
            y += piece.height;
        }
        place = last + 1;
    }
    pages
}

fn moved(item: &Item, by: f32, of: Option<Of>) -> Placed {
    let mut item = item.clone();
    match &mut item {
        Item::Text { y, .. } => *y += by,
        Item::Box { at, .. } | Item::Picture { at, .. } => at[1] += by,
    }
    let of = of.filter(|_| !matches!(item, Item::Box { .. }));
    Placed { item, of }
}

#[cfg(test)]
mod tests {
    use super::piece::{BODY, wrapped};
    use super::*;
    use crate::document::{Block, ReportTable, Section};

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

    fn stated(page: &[Placed]) -> Vec<&str> {
        page.iter()
            .filter_map(|placed| match &placed.item {
                Item::Text { text, .. } => Some(text.as_str()),
                _ => None,
            })
            .collect()
    }

    #[test]
    fn a_table_goes_on_over_the_page_with_its_head_and_nothing_leaves_the_page() {
        let rows = (0..200).map(|k| vec![format!("row {k}"), "value".to_owned()]).collect();
        let table = ReportTable {
            head: vec!["what".to_owned(), "how much".to_owned()],
            rows,
            numbers: false,
        };
        let pages = pages(&document(vec![Block::ReportTable(table)]), &Typewriter);
        assert!(pages.len() > 2);
        let mut rows = 0;
        for (place, page) in pages.iter().enumerate() {
            let stated = stated(page);
            assert_eq!(
                stated.iter().filter(|text| **text == "how much").count(),
                1,
                "page {place}"
            );
            assert!(stated.contains(&format!("{} / {}", place + 1, pages.len()).as_str()));
            assert!(stated.contains(&"report 7"));
            rows += stated.iter().filter(|text| text.starts_with("row ")).count();
            for Placed { item, .. } in page {
                let (bottom, right) = match item {
                    Item::Text { x, y, style, text, .. } => (*y, x + Typewriter.width(text, *style)),
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
            let holds = |page: &Vec<Placed>, words: &str| stated(page).contains(&words);
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
