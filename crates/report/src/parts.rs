//! Every figure and table of a report as files of their own: SVG, PNG and CSV.

use isolux_reduce::eu_label::quoted;
use resvg::tiny_skia::{Pixmap, Transform};

use crate::document::{Block, Document};
use crate::pdf::PdfError;

/// Pixels of a picture for one of its own lengths.
const SCALE: f32 = 2.0;

/// A part of a report as a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PartFile {
    /// Its name: place, section, number.
    pub name: String,
    /// What is in it.
    pub bytes: Vec<u8>,
}

impl Document {
    /// The figures as SVG and as PNG of twice their size, the tables as CSV, in the language of the report.
    ///
    /// # Errors
    /// [`PdfError`] for a picture that is no SVG.
    pub fn parts(&self) -> Result<Vec<PartFile>, PdfError> {
        let document = self.in_its_language();
        let options = crate::pdf::picture_options()?;
        let mut files = Vec::new();
        let (mut figures, mut tables) = (0, 0);
        // Names are English whatever the language: scripts find them.
        for (section, english) in document.sections.iter().zip(&self.sections) {
            let of = slug(&english.heading);
            for block in &section.blocks {
                match block {
                    Block::Figures(list) => {
                        for figure in list {
                            figures += 1;
                            let name = format!("figure-{figures:02}-{of}");
                            let png = png(&figure.svg, &options)?;
                            files.push(file(&name, "svg", figure.svg.clone().into_bytes()));
                            files.push(file(&name, "png", png));
                        }
                    }
                    Block::ReportTable(table) => {
                        tables += 1;
                        let rows = std::iter::once(&table.head)
                            .chain(&table.rows)
                            .filter(|row| !row.is_empty());
                        let text: String = rows.map(|row| csv_line(row)).collect();
                        files.push(file(&format!("table-{tables:02}-{of}"), "csv", text.into_bytes()));
                    }
                    _ => {}
                }
            }
        }
        Ok(files)
    }
}

fn file(name: &str, end: &str, bytes: Vec<u8>) -> PartFile {
    PartFile {
        name: format!("{name}.{end}"),
        bytes,
    }
}

/// A heading as part of a name.
fn slug(heading: &str) -> String {
    let words = heading
        .split(|letter: char| !letter.is_ascii_alphanumeric())
        .filter(|word| !word.is_empty());
    let words: Vec<String> = words.map(str::to_lowercase).collect();
    if words.is_empty() {
        "summary".to_owned()
    } else {
        words.join("-")
    }
}

/// A row as RFC 4180 has it.
fn csv_line(cells: &[String]) -> String {
    let cells: Vec<String> = cells.iter().map(|cell| quoted(cell)).collect();
    cells.join(",") + "\n"
}

fn png(svg: &str, options: &usvg::Options<'_>) -> Result<Vec<u8>, PdfError> {
    let tree = usvg::Tree::from_str(svg, options).map_err(|error| PdfError::new(format!("a picture: {error}")))?;
    let size = tree.size();
    let (w, h) = ((SCALE * size.width()).ceil(), (SCALE * size.height()).ceil());
    let mut pixels = Pixmap::new(w as u32, h as u32).ok_or_else(|| PdfError::new("a picture without a size"))?;
    pixels.fill(resvg::tiny_skia::Color::WHITE);
    resvg::render(&tree, Transform::from_scale(SCALE, SCALE), &mut pixels.as_mut());
    pixels
        .encode_png()
        .map_err(|error| PdfError::new(format!("a picture: {error}")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::Section;
    use crate::svg::{Anchor, Svg};

    #[test]
    fn figures_and_tables_become_files_that_others_read() {
        let mut picture = Svg::new(200.0, 100.0, "picture");
        picture.text((20.0, 50.0), Anchor::Start, "#000000", "I in cd");
        let mut section = Section::new("Flux & zones");
        section.figures([(picture.finish(), "a picture")]);
        section.table(&["a", "b"], vec![vec!["1, 2".to_owned(), "\"x\"".to_owned()]]);
        let document = Document {
            sections: vec![section],
            ..Document::default()
        };
        let files = document.parts().unwrap();
        let names: Vec<&str> = files.iter().map(|file| file.name.as_str()).collect();
        assert_eq!(
            names,
            [
                "figure-01-flux-zones.svg",
                "figure-01-flux-zones.png",
                "table-01-flux-zones.csv"
            ]
        );
        assert_eq!(files[2].bytes, b"a,b\n\"1, 2\",\"\"\"x\"\"\"\n");
        let reader = png::Decoder::new(std::io::Cursor::new(&files[1].bytes))
            .read_info()
            .unwrap();
        assert_eq!((reader.info().width, reader.info().height), (400, 200));
        // Text was drawn: not every pixel is white.
        let mut reader = reader;
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut pixels).unwrap();
        assert!(pixels.iter().any(|value| *value < 100));
    }
}
