//! The sweep file and what it asks for.

use camino::Utf8PathBuf;
use isolux_record::document::{Fault, SourceText};
use serde::Deserialize;
use toml::{Table, Value};

use crate::Failure;
use crate::simulation::simulate::{Method, Sampling};

/// Value of `format` in a sweep file.
pub const FORMAT: &str = "isolux-sweep/1";

/// A sweep file as written.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Document {
    #[serde(rename = "format")]
    _format: String,
    pub scene: Utf8PathBuf,
    #[serde(default = "inverse")]
    method: String,
    #[serde(default)]
    sampling: Option<String>,
    #[serde(default)]
    rays: Option<f64>,
    #[serde(default)]
    seed: Option<u64>,
    pub vary: Table,
}

fn inverse() -> String {
    "inverse".to_owned()
}

pub fn fault(source: SourceText<'_>, key: &str, message: &str) -> Failure {
    Failure::bad_input(source.locate(&Fault {
        path: key.to_owned(),
        message: message.to_owned(),
    }))
}

pub fn method(source: SourceText<'_>, document: &Document) -> Result<Method, Failure> {
    let wrong = |key: &str, word: &str, known: &str| fault(source, key, &format!("`{word}` is none of {known}"));
    match document.method.as_str() {
        "inverse" => {
            let of_rays = [
                ("sampling", document.sampling.is_some()),
                ("rays", document.rays.is_some()),
                ("seed", document.seed.is_some()),
            ];
            match of_rays.into_iter().find(|(_, given)| *given) {
                Some((key, _)) => Err(
                    fault(source, key, "it is of the rays, and the inverse method draws none")
                        .help(format!("write method = \"direct\" with it, or leave {key} out")),
                ),
                None => Ok(Method::Inverse),
            }
        }
        "direct" => {
            let sampling = match document.sampling.as_deref().unwrap_or("thinned") {
                "traced" => Sampling::Traced,
                "thinned" => Sampling::Thinned,
                "expected" => Sampling::Expected,
                word => return Err(wrong("sampling", word, "traced, thinned, expected")),
            };
            let rays = document.rays.unwrap_or(2e9);
            if !(1.0..9e15).contains(&rays) {
                return Err(fault(source, "rays", &format!("{rays} is not within 1 to 9e15")));
            }
            Ok(Method::Direct {
                sampling,
                rays: rays as u64,
                seed: document.seed.unwrap_or(1),
            })
        }
        word => Err(wrong("method", word, "inverse, direct")),
    }
}

/// Keys may be written quoted and dotted or as nested tables.
pub fn flatten(
    prefix: &str,
    table: &Table,
    keys: &mut Vec<String>,
    values: &mut Vec<Vec<Value>>,
) -> Result<(), String> {
    for (key, value) in table {
        let key = if prefix.is_empty() {
            key.clone()
        } else {
            format!("{prefix}.{key}")
        };
        match value {
            Value::Array(list) => {
                keys.push(key);
                values.push(list.clone());
            }
            Value::Table(inner) => flatten(&key, inner, keys, values)?,
            _ => return Err(key),
        }
    }
    Ok(())
}

/// Values of point `index`; the last key runs fastest.
pub fn at(values: &[Vec<Value>], index: usize) -> impl Iterator<Item = &Value> {
    let mut strides = vec![1; values.len()];
    for k in (0..values.len().saturating_sub(1)).rev() {
        strides[k] = strides[k + 1] * values[k + 1].len();
    }
    values
        .iter()
        .zip(strides)
        .map(move |(list, stride)| &list[index / stride % list.len()])
}
