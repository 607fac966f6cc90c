//! The ASDF forms of JCAMP-DX 4.24: an abscissa a line, then ordinates as differences and repeats.

use crate::finding::{Finding, Findings};
use crate::number;
use crate::spectral::point::Point;

/// Points beyond this are no spectrum but a forged repeat count.
const MOST_POINTS: usize = 300_000;

/// One step of the ASDF code (JCAMP-DX 4.24, 5.4–5.8).
enum Code {
    Absolute(f64),
    Difference(f64),
    Repeat(usize),
}

/// `(X++(Y..Y))`: an abscissa a line, then ordinates in AFFN, PAC, SQZ, DIF and DUP form, with both of their checks.
pub(super) fn ordinates(
    table: &[(usize, &str)],
    [first, last, count]: [f64; 3],
    [x_factor, y_factor]: [f64; 2],
    findings: &mut Findings,
) -> Result<Vec<Point>, Finding> {
    if !(2.0..=MOST_POINTS as f64).contains(&count) {
        return Err(Finding::error("jcamp-points", "NPOINTS is no number of points").at(1, 1));
    }
    let step = (last - first) / (count - 1.0);
    let mut y: Vec<(f64, usize)> = Vec::new();
    // The last line ended on a difference: the next begins with the same ordinate again.
    let mut in_difference = false;
    for &(line, content) in table {
        if content.trim().is_empty() {
            continue;
        }
        let bad = |column: usize, raw: &str| {
            Finding::error("jcamp-number", "this is no number of JCAMP-DX")
                .at(line, column + 1)
                .raw(raw)
        };
        let (x, codes) = decode(content).map_err(|(column, raw)| bad(column, &raw))?;
        let index = if in_difference {
            y.len().saturating_sub(1)
        } else {
            y.len()
        };
        let expected = first + step * index as f64;
        // Abscissas of the lines are rounded to the digits that fit.
        if (x * x_factor - expected).abs() > 0.6 * step.abs() + 1.0_f64.min(0.002 * expected.abs()) {
            findings.push(
                Finding::error(
                    "jcamp-abscissa",
                    format!(
                        "the line begins at {}, the points before it lead to {expected:.4}",
                        x * x_factor
                    ),
                )
                .at(line, 1)
                .raw(content)
                .assumed("FIRSTX, LASTX and NPOINTS")
                .fix("check for a lost, doubled or damaged line"),
            );
        }
        let mut check = in_difference;
        let (mut now, mut difference) = (y.last().map_or(0.0, |last| last.0), None);
        for code in codes {
            match code {
                Code::Absolute(value) => {
                    difference = None;
                    if check && (value - now).abs() > 1.0 {
                        findings.push(
                            Finding::error(
                                "jcamp-check",
                                format!("the line begins with {value}, the line before ends with {now}"),
                            )
                            .at(line, 1)
                            .raw(content)
                            .assumed("the differences")
                            .fix("check for a lost or damaged line"),
                        );
                    }
                    now = value;
                    if !check {
                        y.push((now, line));
                    }
                }
                Code::Difference(value) => {
                    difference = Some(value);
                    now += value;
                    y.push((now, line));
                }
                Code::Repeat(times) => {
                    if y.len() + times > MOST_POINTS {
                        return Err(bad(0, "repeat count"));
                    }
                    for _ in 1..times {
                        now += difference.unwrap_or(0.0);
                        y.push((now, line));
                    }
                }
            }
            check = false;
        }
        in_difference = difference.is_some();
    }
    Ok(y.iter()
        .enumerate()
        .map(|(i, &(value, line))| Point {
            line,
            column: 1,
            x: first + step * i as f64,
            value: vec![Some(value * y_factor)],
        })
        .collect())
}

/// The abscissa and the codes of a line; an error is the zero-based column and the text.
fn decode(line: &str) -> Result<(f64, Vec<Code>), (usize, String)> {
    let bytes = line.as_bytes();
    let mut out = Vec::new();
    let mut abscissa = None;
    let mut at = 0;
    while at < bytes.len() {
        let start = at;
        let (lead, kind) = match bytes[at] {
            b' ' | b'\t' | b',' | b';' => {
                at += 1;
                continue;
            }
            b'@' => ("0".to_owned(), 0),
            c @ b'A'..=b'I' => (format!("{}", c - b'A' + 1), 0),
            c @ b'a'..=b'i' => (format!("-{}", c - b'a' + 1), 0),
            b'%' => ("0".to_owned(), 1),
            c @ b'J'..=b'R' => (format!("{}", c - b'J' + 1), 1),
            c @ b'j'..=b'r' => (format!("-{}", c - b'j' + 1), 1),
            c @ b'S'..=b'Z' => (format!("{}", c - b'S' + 1), 2),
            b's' => ("9".to_owned(), 2),
            c @ (b'+' | b'-' | b'.' | b'0'..=b'9') => ((c as char).to_string(), 0),
            _ => return Err((at, line.get(at..).unwrap_or("").chars().take(12).collect())),
        };
        let plain = matches!(bytes[at], b'+' | b'-' | b'.' | b'0'..=b'9');
        at += 1;
        let digits = at;
        while at < bytes.len() {
            let exponent = plain
                && matches!(bytes[at], b'E' | b'e')
                && matches!(bytes.get(at + 1), Some(b'+' | b'-'))
                && bytes.get(at + 2).is_some_and(u8::is_ascii_digit);
            if exponent {
                at += 2;
            } else if !(bytes[at].is_ascii_digit() || bytes[at] == b'.') {
                break;
            }
            at += 1;
        }
        let text = format!("{lead}{}", line.get(digits..at).unwrap_or("?"));
        let value: f64 = text
            .parse()
            .ok()
            .filter(|v: &f64| v.is_finite() && v.abs() < number::LARGEST_SPECTRAL)
            .ok_or_else(|| (start, line.get(start..at).unwrap_or("").to_owned()))?;
        match (abscissa, kind) {
            (None, 0) if plain => abscissa = Some(value),
            (None, _) => return Err((start, line.get(start..at).unwrap_or("").to_owned())),
            (_, 0) => out.push(Code::Absolute(value)),
            (_, 1) => out.push(Code::Difference(value)),
            _ => out.push(Code::Repeat((value.max(0.0) as usize).min(MOST_POINTS + 1))),
        }
    }
    abscissa.map(|x| (x, out)).ok_or((0, line.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(line: &str) -> Vec<f64> {
        let mut out: Vec<f64> = Vec::new();
        let mut step = 0.0;
        for code in decode(line).unwrap().1 {
            match code {
                Code::Absolute(v) => {
                    step = 0.0;
                    out.push(v);
                }
                Code::Difference(v) => {
                    step = v;
                    out.push(out.last().unwrap() + v);
                }
                Code::Repeat(n) => (1..n).for_each(|_| out.push(out.last().unwrap() + step)),
            }
        }
        out
    }

    #[test]
    fn the_five_forms_of_the_standard_are_the_same_numbers() {
        // The example of JCAMP-DX 4.24, 5.9.
        let expected = [1.0, 2.0, 3.0, 3.0, 2.0, 1.0, 0.0, -1.0, -2.0, -3.0];
        for line in [
            "99 1 2 3 3 2 1 0 -1 -2 -3",
            "99+1+2+3+3+2+1+0-1-2-3",
            "99ABCCBA@abc",
            "99AJJ%jjjjjj",
            "99AJT%jX",
        ] {
            assert_eq!(values(line), expected, "{line}");
        }
    }
}
