//! What each block of a report looks like on paper.

use std::cell::Cell;

use super::piece::{
    BODY, CELL, Ink, Item, Kind, LEFT, Measure, Of, Piece, SMALL, Style, WIDTH, fitted, in_part, style, text, wrapped,
};
use crate::document::{Block, Document, Figure, Section};
use crate::html::Tile;

/// Sets the parts of a report as pieces.
pub(super) struct Layout<'a> {
    pub fonts: &'a dyn Measure,
    blocks: Cell<usize>,
}

impl<'a> Layout<'a> {
    pub fn new(fonts: &'a dyn Measure) -> Self {
        Self {
            fonts,
            blocks: Cell::new(0),
        }
    }
}

impl Layout<'_> {
    /// A number that no block has yet.
    pub fn next(&self) -> usize {
        self.blocks.set(self.blocks.get() + 1);
        self.blocks.get()
    }

    /// The place of a block of its own.
    pub fn own(&self, kind: Kind) -> Of {
        Of {
            block: self.next(),
            kind,
        }
    }

    pub fn title(&self, document: &Document) -> Vec<Piece> {
        let mut pieces: Vec<Piece> = self.clothes(document).into_iter().collect();
        for (words, style, kind) in [
            (&document.title, style(18.0, true, Ink::Text), Kind::Heading(1)),
            (&document.subtitle, style(9.0, false, Ink::Muted), Kind::Paragraph),
        ] {
            let mut piece = Piece {
                with_next: true,
                of: Some(self.own(kind)),
                ..Piece::default()
            };
            for line in wrapped(words, WIDTH, style, self.fonts) {
                piece.height += 1.25 * style.size;
                piece
                    .items
                    .push(text(LEFT, piece.height - 0.3 * style.size, style, line));
            }
            pieces.push(piece);
        }
        pieces
    }

    /// Logo at the left, address, mark of accreditation at the right.
    fn clothes(&self, document: &Document) -> Option<Piece> {
        const TALL: f32 = 42.0;
        let clothes = &document.clothes;
        let mut items = Vec::new();
        let mut fit = |svg: &Option<String>, caption: &str, part: usize| {
            let svg = svg.as_ref()?;
            let (w, h) = extent(svg);
            let scale = (TALL / h).min(0.3 * WIDTH / w);
            let x = if part == 0 { LEFT } else { LEFT + WIDTH - w * scale };
            items.push(Item::Picture {
                at: [x, 0.0, w * scale, h * scale],
                svg: svg.clone(),
                caption: caption.to_owned(),
                part,
            });
            Some(w * scale + 12.0)
        };
        let left = fit(&clothes.logo, "logo", 0);
        let right = fit(&clothes.accreditation_mark, "accreditation", 2);
        let x = LEFT + left.unwrap_or(0.0);
        let room = WIDTH - left.unwrap_or(0.0) - right.unwrap_or(0.0);
        let mut y = 0.0;
        for line in &clothes.address {
            for line in wrapped(line, room, SMALL, self.fonts) {
                y += 1.3 * SMALL.size;
                items.push(in_part(text(x, y, SMALL, line), 1));
            }
        }
        let pictures: f32 = if left.is_some() || right.is_some() { TALL } else { 0.0 };
        (!items.is_empty()).then(|| Piece {
            items,
            of: Some(self.own(Kind::Figures)),
            height: y.max(pictures) + 10.0,
            ..Piece::default()
        })
    }

    pub fn section(&self, section: &Section, pieces: &mut Vec<Piece>) {
        if !section.heading.is_empty() {
            pieces.push(self.heading(&section.heading, style(13.0, true, Ink::Text), 18.0, 2));
        }
        for block in &section.blocks {
            self.block(block, pieces);
        }
        // A heading that nothing follows stands alone.
        if let Some(last) = pieces.last_mut() {
            last.with_next = false;
        }
    }

    fn heading(&self, words: &str, style: Style, above: f32, level: u16) -> Piece {
        let mut items = vec![text(LEFT, style.size, style, fitted(words, WIDTH, style, self.fonts))];
        if level == 2 {
            items.push(Item::Box {
                at: [LEFT, style.size + 4.0, WIDTH, 0.6],
                ink: Ink::Line,
            });
        }
        Piece {
            items,
            of: Some(self.own(Kind::Heading(level))),
            height: style.size + 9.0,
            above,
            with_next: true,
            head: None,
        }
    }

    fn block(&self, block: &Block, pieces: &mut Vec<Piece>) {
        match block {
            Block::Paragraph(words) => self.paragraph(words, BODY, pieces),
            Block::Subheading(words) => pieces.push(self.heading(words, style(10.0, true, Ink::Text), 10.0, 3)),
            Block::Verdict(words, good) => pieces.push(self.verdict(words, *good)),
            Block::Tiles(tiles) => self.tiles(tiles, pieces),
            Block::ReportTable(table) => self.table(table, pieces),
            Block::Figures(figures) => self.figures(figures, pieces),
            Block::Details(summary, lines) => {
                pieces.push(self.heading(summary, style(9.0, true, Ink::Muted), 6.0, 3));
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
        let of = Some(self.own(Kind::Paragraph));
        for (place, line) in lines.into_iter().enumerate() {
            pieces.push(Piece {
                items: vec![text(LEFT, style.size, style, line)],
                of,
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
            of: Some(self.own(Kind::Paragraph)),
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
                        items.push(in_part(text(x, y - 0.2 * style.size, style, line), place));
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
                of: Some(self.own(Kind::Paragraphs)),
                height: tallest + 1.0,
                above: 7.0,
                ..Piece::default()
            });
        }
    }

    /// Pictures beside each other, two in a row, each with its caption below. One that has a row for itself is no
    /// larger: its text is as large as that of the others.
    fn figures(&self, figures: &[Figure], pieces: &mut Vec<Piece>) {
        const GAP: f32 = 14.0;
        const TALLEST: f32 = 300.0;
        let width = (WIDTH - GAP) / 2.0;
        for row in figures.chunks(2) {
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
                    caption: figure.caption.clone(),
                    part: place,
                });
                let mut y = tallest + 2.0;
                for line in wrapped(&figure.caption, width, SMALL, self.fonts) {
                    y += 1.3 * SMALL.size;
                    items.push(in_part(text(x, y, SMALL, line), place));
                }
                height = height.max(y + 3.0);
            }
            pieces.push(Piece {
                items,
                of: Some(self.own(Kind::Figures)),
                height,
                above: 8.0,
                ..Piece::default()
            });
        }
    }
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
