//! A digit that became a letter e leaves a number: `0.0559` and `0e0559`.

use crate::finding::Finding;
use crate::number;
use crate::text::Text;

/// Programs that write exponents fill whole columns with them; as few as these in a file of more than `MANY` numbers
/// stand alone.
const FEW: usize = 3;
const MANY: usize = 20;

/// Exponents without a sign in lines of data, where the other numbers of the file have none.
pub(super) fn alone(text: &Text<'_>) -> Vec<Finding> {
    let (mut numbers, mut with_exponent) = (0, 0);
    let mut bare = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let found = tokens(line);
        if found.len() < 2 {
            continue;
        }
        numbers += found.len();
        for (start, token) in found {
            let Some(at) = token.bytes().rposition(|byte| matches!(byte, b'e' | b'E')) else {
                continue;
            };
            with_exponent += 1;
            if with_exponent > FEW {
                return Vec::new();
            }
            if token.as_bytes().get(at + 1).is_some_and(u8::is_ascii_digit) {
                let column = line[..start].chars().count() + 1;
                bare.push(number::bare_exponent(token).at(index + 1, column));
            }
        }
    }
    if numbers > MANY { bare } else { Vec::new() }
}

/// Numbers of a line with their first byte. In a comment, or with words between them, they are no data.
fn tokens(line: &str) -> Vec<(usize, &str)> {
    let starts_as_data = line
        .trim_start_matches([' ', '\t', '"', ',', ';'])
        .starts_with(|c: char| c.is_ascii_digit() || matches!(c, '-' | '+' | '.' | '<'));
    if !starts_as_data {
        return Vec::new();
    }
    let separator = |c: char| c.is_whitespace() || matches!(c, ',' | ';' | '|' | '"' | '<' | '>' | '=' | '/');
    let mut all = Vec::new();
    let mut start = 0;
    for piece in line.split(separator) {
        if piece.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '-' | '+' | '.'))
            && number::read_up_to(piece, f64::MAX).is_ok()
        {
            all.push((start, piece));
        }
        start += piece.len();
        start += line[start..].chars().next().map_or(0, char::len_utf8);
    }
    all
}
