//! Sizes as people write them: one number for a square, or two.

use serde::Deserialize;

/// Width and height, or one number for both.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(
    untagged,
    expecting = "one number for both sides or a list of two, such as 24.5 or [24.5, 18.0]; counts are whole numbers of one or more"
)]
pub enum OneOrTwo<T> {
    /// Both alike.
    One(T),
    /// Width, height.
    Two([T; 2]),
}

impl<T: Copy> OneOrTwo<T> {
    /// Width and height.
    pub fn both(&self) -> [T; 2] {
        match self {
            Self::One(value) => [*value; 2],
            Self::Two(values) => *values,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::SourceText;

    #[derive(Debug, Deserialize)]
    struct Toy {
        #[serde(rename = "size")]
        _size: OneOrTwo<u64>,
    }

    #[test]
    fn what_is_no_size_is_shown_with_what_is_needed() {
        let (file, text) = ("toy.toml".into(), "size = [48, -36]");
        let error = toml::from_str::<Toy>(text).unwrap_err();
        let message = SourceText { file, text }.toml_error(&error).message;
        assert!(message.starts_with("`size` is [48, -36]; one number"), "{message}");
    }
}
