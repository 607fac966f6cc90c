//! The structure of a PDF for readers who do not see its pages (PDF/UA, ISO 14289-1): headings, paragraphs, tables with
//! named rows and columns, pictures with what they show.

use std::num::NonZeroU16;

use krilla::destination::XyzDestination;
use krilla::geom::Point;
use krilla::outline::{Outline, OutlineNode};
use krilla::tagging::{Identifier, Node, TableHeaderScope, Tag, TagGroup, TagTree};

use crate::paper::{Item, Kind, Of};

/// A part of a block: its pieces on the pages, in order.
#[derive(Default)]
struct Part {
    picture: Option<(Identifier, String)>,
    lines: Vec<Identifier>,
}

struct Block {
    of: Of,
    /// What a heading says.
    words: String,
    parts: Vec<Part>,
}

/// Collects what stands on the pages, in the order of reading.
#[derive(Default)]
pub(super) struct Tags {
    blocks: Vec<Block>,
    /// Block, level, page and height of every heading.
    headings: Vec<(usize, u16, usize, f32)>,
}

impl Tags {
    /// Takes a thing that was drawn on the page with this number.
    pub fn add(&mut self, of: Of, item: &Item, identifier: Identifier, page: usize) {
        if self.blocks.last().is_none_or(|block| block.of.block != of.block) {
            self.blocks.push(Block {
                of,
                words: String::new(),
                parts: Vec::new(),
            });
        }
        let number = self.blocks.len() - 1;
        let Some(block) = self.blocks.last_mut() else { return };
        let (Item::Text { part, .. } | Item::Picture { part, .. }) = item else {
            return;
        };
        while block.parts.len() <= *part {
            block.parts.push(Part::default());
        }
        match item {
            Item::Picture { caption, .. } => block.parts[*part].picture = Some((identifier, caption.clone())),
            Item::Text { text, y, style, .. } => {
                block.parts[*part].lines.push(identifier);
                if let Kind::Heading(level) = of.kind {
                    if block.words.is_empty() {
                        self.headings.push((number, level, page, y - style.size));
                    } else {
                        block.words.push(' ');
                    }
                    block.words.push_str(text);
                }
            }
            Item::Box { .. } => {}
        }
    }

    /// The headings of sections, as bookmarks.
    pub fn outline(&self) -> Outline {
        let mut outline = Outline::new();
        for (block, _, page, y) in self.headings.iter().filter(|(_, level, ..)| *level <= 2) {
            let Some(block) = self.blocks.get(*block) else { continue };
            let there = XyzDestination::new(*page, Point::from_xy(0.0, y.max(0.0)));
            outline.push_child(OutlineNode::new(block.words.clone(), there));
        }
        outline
    }

    /// The tree of a document in this language.
    pub fn tree(self, language: &str) -> TagTree {
        let mut tree = TagTree::new().with_lang(Some(language.to_owned()));
        let mut blocks = self.blocks.into_iter().peekable();
        while let Some(block) = blocks.next() {
            match block.of.kind {
                Kind::Heading(level) => {
                    let level = NonZeroU16::new(level).unwrap_or(NonZeroU16::MIN);
                    tree.push(group(Tag::Hn(level, Some(block.words)), lines(block.parts)));
                }
                Kind::Paragraph => tree.push(group(Tag::P, lines(block.parts))),
                Kind::Paragraphs => {
                    for part in block.parts {
                        tree.push(group(Tag::P, part.lines));
                    }
                }
                Kind::Figures => {
                    for part in block.parts {
                        if let Some((picture, caption)) = part.picture {
                            tree.push(group(Tag::Figure(Some(caption)), vec![picture]));
                        }
                        tree.push(group(Tag::P, part.lines));
                    }
                }
                Kind::Row { table, .. } => {
                    let mut rows = vec![block];
                    let same = |next: &Block| matches!(next.of.kind, Kind::Row { table: other, .. } if other == table);
                    while let Some(row) = blocks.next_if(same) {
                        rows.push(row);
                    }
                    tree.push(of_rows(rows));
                }
            }
        }
        tree
    }
}

fn lines(parts: Vec<Part>) -> Vec<Identifier> {
    parts.into_iter().flat_map(|part| part.lines).collect()
}

fn group(tag: impl Into<krilla::tagging::TagKind>, children: Vec<Identifier>) -> TagGroup {
    TagGroup::with_children(tag, children.into_iter().map(Node::from).collect())
}

fn of_rows(rows: Vec<Block>) -> TagGroup {
    let (mut head, mut body) = (TagGroup::new(Tag::THead), TagGroup::new(Tag::TBody));
    for row in rows {
        let Kind::Row {
            head: is_head, named, ..
        } = row.of.kind
        else {
            continue;
        };
        let mut cells = TagGroup::new(Tag::TR);
        for (column, part) in row.parts.into_iter().enumerate() {
            cells.push(match (is_head, named && column == 0) {
                (true, _) => group(Tag::TH(TableHeaderScope::Column), part.lines),
                (false, true) => group(Tag::TH(TableHeaderScope::Row), part.lines),
                (false, false) => group(Tag::TD, part.lines),
            });
        }
        if is_head { &mut head } else { &mut body }.push(cells);
    }
    let mut table = TagGroup::new(Tag::Table);
    if !head.children.is_empty() {
        table.push(head);
    }
    table.push(body);
    table
}
