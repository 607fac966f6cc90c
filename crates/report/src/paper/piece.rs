//! What stands on a page, and lines of text as wide as a column.

/// Width and height of A4.
pub const A4: (f32, f32) = (595.28, 841.89);
pub const LEFT: f32 = 45.0;
pub const TOP: f32 = 45.0;
/// Lowest baseline of the text; the foot is below.
pub const BOTTOM: f32 = 785.0;
/// Width of the text.
pub const WIDTH: f32 = A4.0 - 2.0 * LEFT;
/// Baseline of the foot.
pub const FOOT: f32 = 808.0;

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
        /// Which part of what it belongs to it is of: the column of a row, the tile, the picture.
        part: usize,
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
        /// What a reader should see in it.
        caption: String,
        /// As that of a text.
        part: usize,
    },
}

/// What a thing on a page is to a reader who does not see the page.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A heading of this level, from 1.
    Heading(u16),
    /// Lines of text.
    Paragraph,
    /// Paragraphs beside each other, one a part.
    Paragraphs,
    /// Pictures beside each other, each a part with its caption.
    Figures,
    /// A row of a table, one cell a part.
    Row {
        /// Whether it names the columns.
        head: bool,
        /// Whether its first cell names the row.
        named: bool,
        /// Which table it is of.
        table: usize,
    },
}

/// Where a thing belongs: things of one block have one number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Of {
    /// The block.
    pub block: usize,
    /// What it is.
    pub kind: Kind,
}

/// A thing on a page and where it belongs; none for what only decorates or repeats.
#[derive(Debug, Clone, PartialEq)]
pub struct Placed {
    /// The thing.
    pub item: Item,
    /// Where it belongs.
    pub of: Option<Of>,
}

/// Widths of letters, as the fonts have them.
pub trait Measure {
    /// Width of a text in points.
    fn width(&self, text: &str, style: Style) -> f32;
}

pub const fn style(size: f32, bold: bool, ink: Ink) -> Style {
    Style { size, bold, ink }
}

pub const BODY: Style = style(9.0, false, Ink::Text);
pub const SMALL: Style = style(7.5, false, Ink::Muted);
pub const CELL: Style = style(8.0, false, Ink::Text);

/// Things that stay together, measured from their own top.
#[derive(Debug, Clone, Default)]
pub struct Piece {
    pub items: Vec<Item>,
    /// Where its texts and pictures belong.
    pub of: Option<Of>,
    pub height: f32,
    /// Room left free above, not at the top of a page.
    pub above: f32,
    /// Whether the next piece must begin on the same page.
    pub with_next: bool,
    /// What is repeated where this piece is the first on a page: the head of its table.
    pub head: Option<Box<Piece>>,
}

pub fn text(x: f32, y: f32, style: Style, text: impl Into<String>) -> Item {
    Item::Text {
        x,
        y,
        style,
        text: text.into(),
        part: 0,
    }
}

/// The same as a part of its block.
pub fn in_part(mut item: Item, of: usize) -> Item {
    if let Item::Text { part, .. } | Item::Picture { part, .. } = &mut item {
        *part = of;
    }
    item
}

/// The text, cut with an ellipsis where it is wider.
pub fn fitted(words: &str, width: f32, style: Style, fonts: &dyn Measure) -> String {
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
pub fn wrapped(words: &str, width: f32, style: Style, fonts: &dyn Measure) -> Vec<String> {
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
