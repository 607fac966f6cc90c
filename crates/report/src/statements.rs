//! What a report states, one line each: what a later report is compared with.

use std::collections::BTreeMap;

use crate::document::{Block, Document, ReportTable};

impl Document {
    /// Every statement of the report by its place: section, subheading, row and column. Text, pictures and files are
    /// left out: they follow from these.
    pub fn statements(&self) -> BTreeMap<String, String> {
        let mut all = Statements::default();
        all.add(&["title"], &self.title);
        all.add(&["subtitle"], &self.subtitle);
        all.add(&["language"], self.language.code());
        for section in &self.sections {
            let mut below = "";
            for block in &section.blocks {
                let place = [section.heading.as_str(), below];
                match block {
                    Block::Subheading(text) => below = text,
                    Block::Verdict(text, _) => all.add(&[place[0], place[1], "verdict"], text),
                    Block::Tiles(tiles) => {
                        for tile in tiles {
                            let value = format!("{} ({})", tile.value, tile.note);
                            all.add(&[place[0], place[1], &tile.name], &value);
                        }
                    }
                    Block::ReportTable(table) => rows(&mut all, place, table),
                    Block::Paragraph(_)
                    | Block::Figures(_)
                    | Block::Details(..)
                    | Block::Files(_)
                    | Block::Screen(_) => {}
                }
            }
        }
        all.0
    }
}

fn rows(all: &mut Statements, place: [&str; 2], table: &ReportTable) {
    for row in &table.rows {
        let Some((name, cells)) = row.split_first() else {
            continue;
        };
        for (at, cell) in cells.iter().enumerate() {
            let column = table.head.get(at + 1).map_or("", String::as_str);
            all.add(&[place[0], place[1], name, column], cell);
        }
    }
}

#[derive(Default)]
struct Statements(BTreeMap<String, String>);

impl Statements {
    fn add(&mut self, place: &[&str], value: &str) {
        let parts: Vec<&str> = place.iter().copied().filter(|part| !part.is_empty()).collect();
        let name = parts.join(" · ");
        let mut key = name.clone();
        let mut number = 1;
        while self.0.contains_key(&key) {
            number += 1;
            key = format!("{name} ({number})");
        }
        self.0.insert(key, value.to_owned());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::Section;

    #[test]
    fn every_cell_has_a_place_of_its_own() {
        let mut section = Section::new("Flux");
        section.facts(vec![("maker".to_owned(), "ACME".to_owned())]);
        section.subheading("Zones");
        section.numbers(
            vec!["γ".to_owned(), "lm".to_owned(), "%".to_owned()],
            vec![
                vec!["30°".to_owned(), "12".to_owned(), "4".to_owned()],
                vec!["30°".to_owned(), "13".to_owned(), "5".to_owned()],
            ],
        );
        section.paragraph("no statement");
        let document = Document {
            title: "Lamp".to_owned(),
            sections: vec![section],
            ..Document::default()
        };
        let stated: Vec<(String, String)> = document.statements().into_iter().collect();
        let expected = [
            ("Flux · Zones · 30° · %", "4"),
            ("Flux · Zones · 30° · % (2)", "5"),
            ("Flux · Zones · 30° · lm", "12"),
            ("Flux · Zones · 30° · lm (2)", "13"),
            ("Flux · maker", "ACME"),
            ("language", "en"),
            ("subtitle", ""),
            ("title", "Lamp"),
        ];
        assert_eq!(stated, expected.map(|(key, value)| (key.to_owned(), value.to_owned())));
    }
}
