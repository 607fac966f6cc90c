//! What an effect does, in one sentence with its numbers.
//!
//! In a sentence of the catalogue `{key}` is the value with its unit, `{key:size}` the same without its sign, `{key:%}`
//! its size in per cent, `{key:min}` seconds as minutes, `{key:off1%}` how far a factor is from 1 in per cent, and
//! `{key:above|below}` one of two words: the first where the value is above its null. A part in brackets is left out
//! where a value in it is not known or a share in it is 0.

use super::spec::{EffectSpec, ParameterSpec};

impl EffectSpec {
    /// The sentence with the values that `value` knows, by key.
    pub fn described(&self, value: impl Fn(&str) -> Option<f64>) -> String {
        let mut described = String::new();
        let mut rest = self.sentence;
        while let Some(begin) = rest.find('[') {
            let (before, part) = rest.split_at(begin);
            let Some((part, after)) = part[1..].split_once(']') else {
                break;
            };
            described.push_str(before);
            if let Some(part) = self.filled(part, &value) {
                described.push_str(&part);
            }
            rest = after;
        }
        described.push_str(rest);
        described
    }

    /// The part with its placeholders filled; none where a value is not known or a share is 0.
    fn filled(&self, part: &str, value: &impl Fn(&str) -> Option<f64>) -> Option<String> {
        let mut filled = String::new();
        let mut rest = part;
        while let Some((before, after)) = rest.split_once('{') {
            let (placeholder, after) = after.split_once('}')?;
            let (key, form) = placeholder.split_once(':').unwrap_or((placeholder, ""));
            let parameter = &self.parameters[self.index_of(key)?];
            let value = value(key).filter(|value| !(parameter.share && *value == 0.0))?;
            filled.push_str(before);
            filled.push_str(&words(parameter, value, form));
            rest = after;
        }
        Some(filled + rest)
    }
}

fn words(parameter: &ParameterSpec, value: f64, form: &str) -> String {
    if let Some((above, below)) = form.split_once('|') {
        return if value >= parameter.null { above } else { below }.to_owned();
    }
    let (value, unit) = match form {
        "size" => (value.abs(), parameter.unit),
        "%" => (100.0 * value.abs(), "%"),
        "off1%" => (100.0 * (value - 1.0).abs(), "%"),
        "min" => (value / 60.0, "min"),
        _ => (value, parameter.unit),
    };
    // A sentence is for the size of an effect, tables have the rest.
    let number = digits(value, 2);
    match unit {
        "" | "1" => number,
        "°" => format!("{number}°"),
        unit => format!("{number} {unit}"),
    }
}

/// A number with so many significant digits: 0.00123, 12.3, 1230.
pub fn digits(value: f64, significant: usize) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let magnitude = value.abs().log10().floor() as i32;
    let places = (significant as i32 - 1 - magnitude).max(0) as usize;
    if places > 9 {
        return format!("{value:.*e}", significant - 1);
    }
    let text = format!("{value:.places$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::digits;
    use crate::effects::catalogue;

    #[test]
    fn every_sentence_reads_with_all_of_its_values_and_with_none() {
        for spec in catalogue() {
            let known = spec.described(|key| Some(spec.parameters[spec.index_of(key)?].plausible.1));
            let unknown = spec.described(|_| None);
            for stated in [&known, &unknown] {
                assert!(
                    stated.ends_with('.') && !stated.contains(['{', '}', '[', ']', '_']),
                    "{}: {stated}",
                    spec.name
                );
                assert!(
                    !stated.contains("  ") && !stated.contains(" ,") && !stated.contains(" ."),
                    "{}: {stated}",
                    spec.name
                );
                assert!(stated.chars().next().is_some_and(char::is_uppercase), "{stated}");
            }
            assert!(known.len() > unknown.len(), "{}: no number in {known}", spec.name);
            // Every key of a placeholder is one of the effect: otherwise its part would be silently left out.
            for placeholder in spec.sentence.split('{').skip(1) {
                let key = placeholder.split([':', '}']).next().unwrap_or_default();
                assert!(spec.index_of(key).is_some(), "{}: {key}", spec.name);
            }
        }
    }

    #[test]
    fn numbers_have_their_units_and_words_their_sign() {
        let spec = |name: &str| catalogue().iter().find(|spec| spec.name == name).unwrap();
        let described = |name: &str, values: &[(&str, f64)]| {
            spec(name).described(|key| values.iter().find(|(known, _)| *known == key).map(|(_, value)| *value))
        };
        assert_eq!(
            described("lamp_warmup", &[("amplitude_rel", 0.054), ("time_constant_s", 360.0)]),
            "The lamp was read before it was warm: 5.4 % too bright at first, gone to a third after 6 min."
        );
        assert_eq!(
            described("distance_offset", &[("offset_mm", -4.0)]),
            "The detector is not where its scale says: it is 4 mm nearer."
        );
        assert_eq!(
            described("dark_offset", &[("offset_rel", 0.002)]),
            "The instrument shows something when no light reaches it: 0.2 % of full scale."
        );
        assert_eq!(
            described("spectral_mismatch", &[("factor", 0.985)]),
            "The lux meter weighs this spectrum otherwise than V(λ): 1.5 % too little."
        );
    }

    #[test]
    fn numbers_keep_their_digits_and_lose_their_zeros() {
        assert_eq!(digits(0.0, 3), "0");
        assert_eq!(digits(0.000_123_456, 2), "0.00012");
        assert_eq!(digits(-12.34, 3), "-12.3");
        assert_eq!(digits(1234.56, 3), "1235");
        assert_eq!(digits(0.5, 3), "0.5");
        assert_eq!(digits(3e-12, 2), "3.0e-12");
    }
}
