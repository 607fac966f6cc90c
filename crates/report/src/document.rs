//! A report as sections of blocks, from which both its forms are made: the HTML page and the PDF.

use base64::Engine as _;
use isolux_record::Language;

use crate::clothes::Clothes;
use crate::html::{Page, Tile};
use crate::svg::escape;

/// A report.
#[derive(Debug, Clone, Default)]
pub struct Document {
    /// What it is of.
    pub title: String,
    /// The line below the title.
    pub subtitle: String,
    /// What stands at the foot of each page of paper: number of the report, laboratory.
    pub foot: String,
    /// Year, month and day of its metadata; without them it is no document for an archive.
    pub date: Option<(u16, u8, u8)>,
    /// The language that it is set in; its texts here are English.
    pub language: Language,
    /// Whose it is.
    pub clothes: Clothes,
    /// Its sections in order; the first has no heading of its own.
    pub sections: Vec<Section>,
}

/// A part of a report.
#[derive(Debug, Clone, Default)]
pub struct Section {
    /// Its heading; none for the first.
    pub heading: String,
    /// What it holds, in order.
    pub blocks: Vec<Block>,
}

/// One thing in a section.
#[derive(Debug, Clone)]
pub enum Block {
    /// Text.
    Paragraph(String),
    /// A heading below that of the section.
    Subheading(String),
    /// The sentence that a reader should take away, and whether all is well.
    Verdict(String, bool),
    /// Headline numbers.
    Tiles(Vec<Tile>),
    /// A table; without a head its first column names the others.
    ReportTable(ReportTable),
    /// Pictures beside each other.
    Figures(Vec<Figure>),
    /// Text for the curious, closed on a screen: its summary and its lines.
    Details(String, Vec<String>),
    /// Files beside the report, each with what it is.
    Files(Vec<(String, String)>),
    /// What only a screen can show.
    Screen(Page),
}

/// Rows of cells.
#[derive(Debug, Clone, Default)]
pub struct ReportTable {
    /// Names of the columns; empty where the first column names the rows.
    pub head: Vec<String>,
    /// The rows, each as long as the head.
    pub rows: Vec<Vec<String>>,
    /// Whether all columns but the first hold numbers, which are aligned at the right.
    pub numbers: bool,
}

/// A picture with what a reader should see in it.
#[derive(Debug, Clone)]
pub struct Figure {
    /// The picture.
    pub svg: String,
    /// One sentence.
    pub caption: String,
}

impl Section {
    /// An empty section.
    pub fn new(heading: &str) -> Self {
        Self {
            heading: heading.to_owned(),
            blocks: Vec::new(),
        }
    }

    /// Adds a block.
    pub fn add(&mut self, block: Block) {
        self.blocks.push(block);
    }

    /// Adds text.
    pub fn paragraph(&mut self, text: impl Into<String>) {
        self.add(Block::Paragraph(text.into()));
    }

    /// Adds a heading below that of the section.
    pub fn subheading(&mut self, text: impl Into<String>) {
        self.add(Block::Subheading(text.into()));
    }

    /// Adds pictures beside each other.
    pub fn figures<const N: usize>(&mut self, figures: [(String, &str); N]) {
        let figures = figures.into_iter().map(|(svg, caption)| Figure {
            svg,
            caption: caption.to_owned(),
        });
        self.add(Block::Figures(figures.collect()));
    }

    /// Adds a table whose columns have names.
    pub fn table(&mut self, head: &[&str], rows: Vec<Vec<String>>) {
        self.add(Block::ReportTable(ReportTable {
            head: head.iter().map(|cell| (*cell).to_owned()).collect(),
            rows,
            numbers: false,
        }));
    }

    /// Adds a table of numbers, aligned at the right but for the first column.
    pub fn numbers(&mut self, head: Vec<String>, rows: Vec<Vec<String>>) {
        self.add(Block::ReportTable(ReportTable {
            head,
            rows,
            numbers: true,
        }));
    }

    /// Adds names with what belongs to them.
    pub fn facts(&mut self, facts: Vec<(String, String)>) {
        self.add(Block::ReportTable(ReportTable {
            head: Vec::new(),
            rows: facts.into_iter().map(|(name, value)| vec![name, value]).collect(),
            numbers: false,
        }));
    }
}

impl Document {
    /// The report as one HTML page that fetches nothing.
    pub fn html(&self) -> String {
        let document = self.in_its_language();
        let mut page = Page::new(&document.title);
        page.dress(document.language.code(), &document.clothes.style);
        page.foot(&document.foot);
        document.html_of(page)
    }

    fn html_of(&self, mut page: Page) -> String {
        head(&mut page, &self.clothes);
        if !self.subtitle.is_empty() {
            page.raw(&format!("<p class=\"subtitle\">{}</p>", escape(&self.subtitle)));
        }
        for section in &self.sections {
            page.raw("<section>");
            if !section.heading.is_empty() {
                page.heading(&section.heading);
            }
            for block in &section.blocks {
                add(&mut page, block);
            }
            page.raw("</section>");
        }
        page.finish()
    }
}

/// Logo, address and mark beside each other. Pictures as images: nothing in them is carried out.
fn head(page: &mut Page, clothes: &Clothes) {
    if *clothes == Clothes::default() {
        return;
    }
    let image = |svg: &Option<String>, what: &str| {
        svg.as_ref().map_or_else(String::new, |svg| {
            let data = base64::engine::general_purpose::STANDARD.encode(svg);
            format!("<img alt=\"{what}\" src=\"data:image/svg+xml;base64,{data}\">")
        })
    };
    let address: Vec<String> = clothes.address.iter().map(|line| escape(line)).collect();
    page.raw(&format!(
        "<header class=\"clothes\">{}<address>{}</address>{}</header>",
        image(&clothes.logo, "logo"),
        address.join("<br>"),
        image(&clothes.accreditation_mark, "accreditation")
    ));
}

fn add(page: &mut Page, block: &Block) {
    match block {
        Block::Paragraph(text) => page.paragraph(text),
        Block::Subheading(text) => page.raw(&format!("<h3>{}</h3>", escape(text))),
        Block::Verdict(text, good) => page.verdict(text, *good),
        Block::Tiles(tiles) => page.tiles(tiles),
        Block::ReportTable(table) => page.raw(&html_table(table)),
        Block::Figures(figures) => {
            page.raw(if figures.len() > 1 {
                "<div class=\"pair\">"
            } else {
                "<div>"
            });
            for figure in figures {
                page.figure(&figure.svg, &figure.caption);
            }
            page.raw("</div>");
        }
        Block::Details(summary, lines) => page.details(summary, &lines.join("\n")),
        Block::Files(files) => {
            let files: Vec<(&str, &str)> = files
                .iter()
                .map(|(name, what)| (name.as_str(), what.as_str()))
                .collect();
            page.files(&files);
        }
        Block::Screen(part) => page.append(part),
    }
}

fn html_table(table: &ReportTable) -> String {
    let row = |cells: &[String], tag: &str| {
        let cells = cells.iter().map(|cell| format!("<{tag}>{}</{tag}>", escape(cell)));
        format!("<tr>{}</tr>\n", cells.collect::<String>())
    };
    let class = match (table.head.is_empty(), table.numbers) {
        (true, _) => " class=\"facts\"",
        (false, true) => " class=\"numbers\"",
        (false, false) => "",
    };
    let head = if table.head.is_empty() {
        String::new()
    } else {
        format!("<thead>{}</thead>", row(&table.head, "th"))
    };
    let body: String = table.rows.iter().map(|cells| row(cells, "td")).collect();
    format!("<div class=\"scroll\"><table{class}>{head}<tbody>\n{body}</tbody></table></div>")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_block_reaches_the_page_escaped() {
        let mut section = Section::new("Flux & zones");
        section.paragraph("a < b");
        section.facts(vec![("maker".to_owned(), "<ACME>".to_owned())]);
        section.numbers(
            vec!["γ".to_owned(), "cd".to_owned()],
            vec![vec!["0".to_owned(), "337".to_owned()]],
        );
        section.figures([("<svg/>".to_owned(), "caption"), ("<svg/>".to_owned(), "other")]);
        section.add(Block::Details(
            "more".to_owned(),
            vec!["one".to_owned(), "two".to_owned()],
        ));
        let html = Document {
            title: "Lamp".to_owned(),
            foot: "report \"7\"".to_owned(),
            sections: vec![section],
            ..Document::default()
        }
        .html();
        for part in [
            "<h2>Flux &amp; zones</h2>",
            "<p>a &lt; b</p>",
            "<table class=\"facts\">",
            "<td>&lt;ACME&gt;</td>",
            "<table class=\"numbers\"><thead><tr><th>γ</th>",
            "<figcaption>other</figcaption>",
            "one\ntwo",
            "content: \"report \\22 7\\22 \"",
        ] {
            assert!(html.contains(part), "{part} is not in\n{html}");
        }
    }
}
