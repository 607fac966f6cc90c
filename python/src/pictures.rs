//! The pictures of the report, for notebooks.

use isolux_app::formats::{Content, pictures};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// The picture `kind` of `content` as SVG.
///
/// # Errors
/// `ValueError` with the pictures that there are.
pub(crate) fn one(content: Option<&Content>, title: &str, kind: &str) -> PyResult<String> {
    let all = content.map(|content| pictures(content, title)).unwrap_or_default();
    let kinds: Vec<&str> = all.iter().map(|(kind, _)| *kind).collect();
    let found = all.iter().find(|(name, _)| *name == kind).map(|(_, svg)| svg.clone());
    found.ok_or_else(|| PyValueError::new_err(format!("there is no picture {kind:?}; there are {}", kinds.join(", "))))
}

/// A title, a table of facts and a picture, as HTML.
pub(crate) fn card(title: &str, facts: &[(&str, String)], svg: &str) -> String {
    let mut rows = String::new();
    for (name, value) in facts {
        let (name, value) = (escaped(name), escaped(value));
        rows += &format!("<tr><th style=\"text-align:left\">{name}</th><td>{value}</td></tr>");
    }
    let title = escaped(title);
    format!("<div><b>{title}</b><table>{rows}</table><div style=\"max-width:28em\">{svg}</div></div>")
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
