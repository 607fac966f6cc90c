//! A file as it lies there beside the same file as it is computed again.

use camino::Utf8Path;
use isolux_report::svg::escape;

/// Numbers that were computed twice from the same bytes may differ by the last digits of another machine's functions.
const ALIKE_REL: f64 = 1e-9;

/// Characters that are shown on either side of the first difference in a line.
const SHOWN: usize = 24;

/// How two files compare.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Outcome {
    /// The same bytes, or but for the name of the run's folder.
    Same,
    /// Texts that differ in the last digits of numbers alone.
    Alike,
    /// They differ.
    Differs { line: Option<u64>, what: String },
}

/// Where the run lies now; and where it lay when its results were made, once a file says it. Some sentences of results
/// name the folder.
#[derive(Debug)]
pub(super) struct Place {
    /// The folder, and forms in which files hold it, the longest first.
    now: Vec<String>,
    then: Option<String>,
}

/// Stands for the folder in a computed line.
const FOLDER: char = '\u{1}';

impl Place {
    pub fn of(run: &Utf8Path) -> Self {
        let html = escape(run.as_str());
        let json = serde_json::to_string(run.as_str()).unwrap_or_default();
        let mut now = vec![run.to_string(), html, json.trim_matches('"').to_owned()];
        now.retain(|form| !form.is_empty());
        now.sort_by_key(|form| std::cmp::Reverse(form.len()));
        Self { now, then: None }
    }

    /// The folder's name when the results were made, where a file says it.
    pub fn then(&self) -> Option<&str> {
        self.then.as_deref()
    }

    /// Whether a line is the computed one but for the folder, which every line has to name alike.
    fn same_line(&mut self, then: &str, now: &str) -> bool {
        let mut pattern = now.to_owned();
        for form in &self.now {
            pattern = pattern.replace(form.as_str(), &FOLDER.to_string());
        }
        let mut parts = pattern.split(FOLDER);
        let (Some(first), Some(second)) = (parts.next(), parts.next()) else {
            return false;
        };
        let Some(rest) = then.strip_prefix(first) else {
            return false;
        };
        let end = if second.is_empty() {
            Some(rest.len())
        } else {
            rest.find(second)
        };
        let Some(folder) = end.map(|end| &rest[..end]) else {
            return false;
        };
        if folder.is_empty() || pattern.replace(FOLDER, folder) != then {
            return false;
        }
        *self.then.get_or_insert_with(|| folder.to_owned()) == folder
    }
}

/// Compares a file with what is computed again.
pub(super) fn compare(then: &[u8], now: &[u8], place: &mut Place) -> Outcome {
    if then == now {
        return Outcome::Same;
    }
    let (Ok(then), Ok(now)) = (std::str::from_utf8(then), std::str::from_utf8(now)) else {
        let at = then.iter().zip(now).take_while(|(a, b)| a == b).count();
        let what = format!(
            "byte {at} of {} is not as it is computed again ({} bytes)",
            then.len(),
            now.len()
        );
        return Outcome::Differs { line: None, what };
    };
    let (mut theirs, mut ours) = (then.split('\n'), now.split('\n'));
    let (mut line, mut outcome) = (0_u64, Outcome::Same);
    loop {
        line += 1;
        match (theirs.next(), ours.next()) {
            (None, None) => return outcome,
            (Some(then), Some(now)) if then == now || place.same_line(then, now) => {}
            (Some(then), Some(now)) if same_numbers(then, now) => outcome = Outcome::Alike,
            (then, now) => {
                let what = words(then.unwrap_or("no line"), now.unwrap_or("no line"));
                return Outcome::Differs { line: Some(line), what };
            }
        }
    }
}

/// The first difference of two lines that are alike, for files for which no checksum speaks.
pub(super) fn first_difference(then: &[u8], now: &[u8], place: &mut Place) -> (Option<u64>, String) {
    let (then, now) = (String::from_utf8_lossy(then), String::from_utf8_lossy(now));
    let mut lines = then.split('\n').zip(now.split('\n')).zip(1..);
    match lines.find(|((then, now), _)| then != now && !place.same_line(then, now)) {
        Some(((then, now), line)) => (Some(line), words(then, now)),
        None => (None, "is not as it is computed again".to_owned()),
    }
}

/// Both lines about their first difference.
fn words(then: &str, now: &str) -> String {
    let same = then.chars().zip(now.chars()).take_while(|(a, b)| a == b).count();
    let about = |text: &str| -> String {
        let shown = text.chars().skip(same.saturating_sub(SHOWN)).take(2 * SHOWN);
        shown.collect::<String>().trim().to_owned()
    };
    format!("holds `{}`, computed again: `{}`", about(then), about(now))
}

/// Whether two lines are the same but for the last digits of their numbers.
fn same_numbers(a: &str, b: &str) -> bool {
    let (mut a, mut b) = (a, b);
    loop {
        let (text_a, number_a, rest_a) = next(a);
        let (text_b, number_b, rest_b) = next(b);
        if text_a != text_b {
            return false;
        }
        match (number_a, number_b) {
            (None, None) => return true,
            (Some(x), Some(y)) => match (x.parse::<f64>(), y.parse::<f64>()) {
                (Ok(p), Ok(q)) if x.contains(['.', 'e', 'E']) && (p - q).abs() <= ALIKE_REL * p.abs().max(q.abs()) => {}
                _ if x == y => {}
                _ => return false,
            },
            _ => return false,
        }
        (a, b) = (rest_a, rest_b);
    }
}

/// The text before the next number, that number, and what follows.
fn next(line: &str) -> (&str, Option<&str>, &str) {
    let Some(start) = line.find(|c: char| c.is_ascii_digit()) else {
        return (line, None, "");
    };
    let rest = &line[start..];
    let mut end = 0;
    for (at, c) in rest.char_indices() {
        let sign = matches!(c, '+' | '-') && rest[..at].ends_with(['e', 'E']);
        if !(c.is_ascii_digit() || matches!(c, '.' | 'e' | 'E') || sign) {
            break;
        }
        end = at + c.len_utf8();
    }
    (&line[..start], Some(&rest[..end]), &rest[end..])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(then: &str, now: &str) -> Outcome {
        compare(then.as_bytes(), now.as_bytes(), &mut Place::of("/lab/day 2".into()))
    }

    #[test]
    fn a_changed_digit_is_named_with_its_line_and_both_numbers() {
        let Outcome::Differs { line, what } = at("a\n\"flux\": 338.1,\n", "a\n\"flux\": 337.1,\n") else {
            panic!("differs");
        };
        assert_eq!(line, Some(2));
        assert_eq!(what, "holds `\"flux\": 338.1,`, computed again: `\"flux\": 337.1,`");
        assert!(matches!(at("a\nb", "a"), Outcome::Differs { line: Some(2), .. }));
        assert!(matches!(at("C 10\n", "C 11\n"), Outcome::Differs { line: Some(1), .. }));
    }

    #[test]
    fn last_digits_of_another_machine_differ_from_a_changed_one() {
        assert_eq!(at("E 1.00000000001e-3, 2.5", "E 1.00000000002e-3, 2.5"), Outcome::Alike);
        for (then, now) in [
            ("1.0000001", "1.0000002"),
            ("2.5 lx", "2.5 cd"),
            ("100000000001", "100000000002"),
            ("1.5", "1.5 1.5"),
            ("2026-01-01.5", "2026-01-02.5"),
        ] {
            assert!(matches!(at(then, now), Outcome::Differs { .. }), "{then} {now}");
        }
    }

    #[test]
    fn the_folder_may_have_another_name_and_every_line_the_same_one() {
        let mut place = Place::of("/lab/day 2".into());
        let now = "5 of 9 readings of /lab/day 2 made it";
        assert!(place.same_line("5 of 9 readings of day made it", now));
        assert_eq!(place.then(), Some("day"));
        assert!(!place.same_line("5 of 9 readings of dax made it", now), "another name");
        assert!(
            !place.same_line("5 of 8 readings of day made it", now),
            "another number"
        );
        assert!(!place.same_line("flux 338", "flux 337"), "no folder in it");
    }
}
