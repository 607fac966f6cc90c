//! A self-contained HTML page: sections, tables, tiles, pictures, all in one file.

use std::fmt::Write as _;

use crate::svg::escape;

/// A page under construction.
#[derive(Debug, Clone)]
pub struct Page {
    title: String,
    language: &'static str,
    /// Style of its own, after that of every page.
    style: String,
    /// At the foot of each printed page, as a string of CSS.
    foot: String,
    body: String,
    data: String,
    scripts: String,
}

/// A headline number: what it is, its value with unit, its uncertainty or remark.
#[derive(Debug, Clone, PartialEq)]
pub struct Tile {
    /// What the number is.
    pub name: String,
    /// The number with its unit.
    pub value: String,
    /// Its uncertainty, or a remark.
    pub note: String,
}

impl Page {
    /// An empty page.
    pub fn new(title: &str) -> Self {
        Self {
            title: escape(title),
            language: "en",
            style: String::new(),
            foot: String::new(),
            body: String::new(),
            data: String::new(),
            scripts: String::new(),
        }
    }

    /// The language that it is in, by BCP 47, and style that follows that of every page.
    pub fn dress(&mut self, language: &'static str, style: &str) {
        self.language = language;
        // Nothing in it ends the element.
        self.style = style.replace("</", "<\\/");
    }

    /// What stands at the foot of each page when it is printed, beside its number.
    pub fn foot(&mut self, text: &str) {
        // CSS: whatever could end the string or the element is written by its number.
        self.foot = text.chars().fold(String::new(), |css, c| match c {
            '"' | '\\' | '<' | '>' | '&' => format!("{css}\\{:x} ", u32::from(c)),
            c if c.is_control() => css + " ",
            c => format!("{css}{c}"),
        });
    }

    /// Adds all that another page holds, with its scripts.
    pub fn append(&mut self, other: &Self) {
        self.body.push_str(&other.body);
        for line in other.data.split_inclusive("</script>\n") {
            if !self.data.contains(line) {
                self.data.push_str(line);
            }
        }
        self.scripts.push_str(&other.scripts);
    }

    /// Begins a section.
    pub fn heading(&mut self, text: &str) {
        let _ = writeln!(self.body, "<h2>{}</h2>", escape(text));
    }

    /// Adds a paragraph.
    pub fn paragraph(&mut self, text: &str) {
        let _ = writeln!(self.body, "<p>{}</p>", escape(text));
    }

    /// Adds the sentence that a reader should take away; `good` colours it.
    pub fn verdict(&mut self, text: &str, good: bool) {
        let class = if good { "good" } else { "bad" };
        let _ = writeln!(self.body, r#"<p class="verdict {class}">{}</p>"#, escape(text));
    }

    /// Adds a row of headline numbers.
    pub fn tiles(&mut self, tiles: &[Tile]) {
        self.body.push_str("<div class=\"tiles\">\n");
        for tile in tiles {
            let _ = writeln!(
                self.body,
                r#"<div class="tile"><span class="name">{}</span><span class="value">{}</span><span class="note">{}</span></div>"#,
                escape(&tile.name),
                escape(&tile.value),
                escape(&tile.note)
            );
        }
        self.body.push_str("</div>\n");
    }

    /// Adds a table; every row has as many cells as the head.
    pub fn table<S: AsRef<str>>(&mut self, head: &[&str], rows: &[Vec<S>]) {
        self.body.push_str("<div class=\"scroll\"><table><thead><tr>");
        for cell in head {
            let _ = write!(self.body, "<th>{}</th>", escape(cell));
        }
        self.body.push_str("</tr></thead><tbody>\n");
        for row in rows {
            self.body.push_str("<tr>");
            for cell in row {
                let _ = write!(self.body, "<td>{}</td>", escape(cell.as_ref()));
            }
            self.body.push_str("</tr>\n");
        }
        self.body.push_str("</tbody></table></div>\n");
    }

    /// Adds an SVG picture with its caption. Pictures that follow each other share a row where there is room.
    pub fn figure(&mut self, svg: &str, caption: &str) {
        let _ = writeln!(
            self.body,
            "<figure>{svg}<figcaption>{}</figcaption></figure>",
            escape(caption)
        );
    }

    /// Adds two SVG pictures with their captions side by side, above each other on a narrow screen.
    pub fn pair(&mut self, left: (&str, &str), right: (&str, &str)) {
        self.body.push_str("<div class=\"pair\">\n");
        self.figure(left.0, left.1);
        self.figure(right.0, right.1);
        self.body.push_str("</div>\n");
    }

    /// Adds preformatted text (a model file, a diff).
    pub fn preformatted(&mut self, text: &str) {
        let _ = writeln!(self.body, "<pre>{}</pre>", escape(text));
    }

    /// Adds preformatted text behind its summary, closed until somebody wants it.
    pub fn details(&mut self, summary: &str, text: &str) {
        let _ = writeln!(
            self.body,
            "<details><summary>{}</summary><pre>{}</pre></details>",
            escape(summary),
            escape(text)
        );
    }

    /// Begins a part that is closed until somebody wants it.
    pub fn open_fold(&mut self, summary: &str) {
        let _ = writeln!(self.body, "<details><summary>{}</summary>", escape(summary));
    }

    /// Ends the part.
    pub fn close_fold(&mut self) {
        self.body.push_str("</details>\n");
    }

    /// Adds a list of files beside the page, each with what it is.
    pub fn files(&mut self, files: &[(&str, &str)]) {
        self.body.push_str("<ul class=\"files\">\n");
        for (file, what) in files {
            let file = escape(file);
            let _ = writeln!(self.body, "<li><a href=\"{file}\">{file}</a> {}</li>", escape(what));
        }
        self.body.push_str("</ul>\n");
    }

    /// Adds raw HTML; the caller escapes.
    pub fn raw(&mut self, html: &str) {
        self.body.push_str(html);
        self.body.push('\n');
    }

    /// Adds a module at the page's end, once the elements it speaks of are there.
    pub fn module(&mut self, javascript: &str) {
        let _ = writeln!(
            self.scripts,
            "<script type=\"module\">{}</script>",
            javascript.replace("</script", "<\\/script")
        );
    }

    /// Adds data that modules of this page find by `id`, once however often they are asked for, before every module.
    pub fn data(&mut self, id: &str, base64: &str) {
        let element = format!("<script type=\"application/octet-stream\" id=\"{id}\">{base64}</script>\n");
        if !self.data.contains(&element) {
            self.data.push_str(&element);
        }
    }

    /// The finished page.
    pub fn finish(self) -> String {
        format!(
            "<!DOCTYPE html>\n<html lang=\"{language}\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" \
             content=\"width=device-width, initial-scale=1\">\n<title>{title}</title>\n<style>{STYLE}{viewer}{foot}{style}</style>\n</head>\n<body>\n\
             <h1>{title}</h1>\n{body}{data}{scripts}</body>\n</html>\n",
            title = self.title,
            language = self.language,
            style = self.style,
            viewer = include_str!("viewer/viewer.css"),
            foot = PRINTED_FOOT.replace("FOOT", &self.foot),
            body = self.body,
            data = self.data,
            scripts = self.scripts
        )
    }
}

const STYLE: &str = include_str!("html/report.css");

/// The foot of printed pages: what the report is, and the page of how many.
const PRINTED_FOOT: &str = "@page { @bottom-left { content: \"FOOT\"; } }";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_fetches_nothing_and_escapes_what_it_is_given() {
        let mut page = Page::new("day <1>");
        page.tiles(&[Tile {
            name: "Φ".into(),
            value: "337 lm".into(),
            note: "±<2>".into(),
        }]);
        page.table(&["a"], &[vec!["<b>"]]);
        page.module("let x = '</script>';");
        let html = page.finish();
        assert!(html.contains("day &lt;1&gt;") && html.contains("±&lt;2&gt;") && html.contains("<td>&lt;b&gt;</td>"));
        assert!(html.contains("'<\\/script>'"));
        assert!(!html.contains("http://") && !html.contains("https://") && !html.contains("src="));
    }
}
