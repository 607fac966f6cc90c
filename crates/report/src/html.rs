//! A self-contained HTML page: sections, tables, tiles, pictures, all in one file.

use std::fmt::Write as _;

use crate::svg::escape;

/// A page under construction.
#[derive(Debug, Clone)]
pub struct Page {
    title: String,
    body: String,
    libraries: String,
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
            body: String::new(),
            libraries: String::new(),
            scripts: String::new(),
        }
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
        self.body.push_str("<table><thead><tr>");
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
        self.body.push_str("</tbody></table>\n");
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

    /// Adds a script at the page's end, once the elements it speaks of are there.
    pub fn script(&mut self, javascript: &str) {
        let _ = writeln!(
            self.scripts,
            "<script>{}</script>",
            javascript.replace("</script", "<\\/script")
        );
    }

    /// Adds a library that scripts of this page use, once however often it is asked for, before every script.
    pub fn library(&mut self, javascript: &str) {
        if !self.libraries.contains(javascript) {
            let _ = writeln!(
                self.libraries,
                "<script>{}</script>",
                javascript.replace("</script", "<\\/script")
            );
        }
    }

    /// The finished page.
    pub fn finish(self) -> String {
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" \
             content=\"width=device-width, initial-scale=1\">\n<title>{title}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n\
             <h1>{title}</h1>\n{body}{libraries}{scripts}</body>\n</html>\n",
            title = self.title,
            body = self.body,
            libraries = self.libraries,
            scripts = self.scripts
        )
    }
}

const STYLE: &str = "
:root { --ink: #222831; --muted: #66707c; --line: #d9dee4; --good: #2e7d4f; --bad: #b3261e; }
* { box-sizing: border-box; }
body { font: 15px/1.5 'Helvetica Neue', Helvetica, Arial, 'Liberation Sans', sans-serif; color: var(--ink); margin: 2rem auto; max-width: 78rem; padding: 0 1.5rem; }
h1 { font-size: 1.6rem; margin: 0 0 .5rem; } h2 { font-size: 1.15rem; margin: 2rem 0 .5rem; border-bottom: 1px solid var(--line); padding-bottom: .25rem; }
.tiles { display: flex; flex-wrap: wrap; gap: .75rem; margin: 1rem 0; }
.tile { border: 1px solid var(--line); border-radius: 6px; padding: .6rem .9rem; min-width: 10rem; display: flex; flex-direction: column; }
.tile .name { color: var(--muted); font-size: .8rem; } .tile .value { font-size: 1.25rem; font-variant-numeric: tabular-nums; } .tile .note { color: var(--muted); font-size: .8rem; }
.verdict { border-left: 4px solid var(--muted); padding: .5rem .9rem; background: #f6f7f9; font-size: 1.05rem; } .verdict.good { border-color: var(--good); } .verdict.bad { border-color: var(--bad); }
figure { display: inline-block; vertical-align: top; margin: .5rem 1rem .5rem 0; max-width: 100%; } figure svg { max-width: 100%; height: auto; } figcaption { color: var(--muted); font-size: .85rem; max-width: 40rem; }
.pair { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 30rem), 1fr)); gap: 0 1.5rem; align-items: end; } .pair figure { margin-right: 0; } .pair figure svg { width: 100%; }
details { margin: .75rem 0; } summary { cursor: pointer; color: var(--muted); } .files { columns: 2 24rem; padding-left: 1.2rem; color: var(--muted); }
table { border-collapse: collapse; margin: .75rem 0; font-variant-numeric: tabular-nums; display: block; overflow-x: auto; } th, td { text-align: left; padding: .25rem .8rem .25rem 0; border-bottom: 1px solid var(--line); } th { color: var(--muted); font-weight: 600; font-size: .85rem; }
pre { background: #f6f7f9; padding: .75rem; white-space: pre-wrap; overflow-wrap: anywhere; font-size: .85rem; }
@media print { body { margin: 0; max-width: none; } figure { break-inside: avoid; } }
";

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
        page.script("let x = '</script>';");
        let html = page.finish();
        assert!(html.contains("day &lt;1&gt;") && html.contains("±&lt;2&gt;") && html.contains("<td>&lt;b&gt;</td>"));
        assert!(html.contains("'<\\/script>'"));
        assert!(!html.contains("http://") && !html.contains("https://") && !html.contains("src="));
    }
}
