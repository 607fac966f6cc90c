//! Plots as SVG and self-contained HTML reports.
//!
//! Every picture is a function from data to an SVG string; a report is a page that carries its pictures, its numbers
//! and its styles inside one file, so that it opens on a machine without a network.

pub mod answer;
pub mod axes;
pub mod clothes;
pub mod content;
pub mod day;
pub mod diagnosis;
pub mod diagnosis_page;
pub mod document;
pub mod html;
pub mod language;
pub mod map;
mod paper;
pub mod parts;
pub mod pdf;
pub mod plots;
pub mod sensor;
mod statements;
pub mod svg;
pub mod sweep;
pub mod viewer;
