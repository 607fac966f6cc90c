//! A key of a table whose value is a text.

/// A key of one of the tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Key {
    /// Its name in the table.
    pub name: &'static str,
    /// What it is, as a person is asked.
    pub what: &'static str,
    /// The most characters that the files of the results can hold.
    pub longest: usize,
}

impl Key {
    /// Refuses a text that the files of the results cannot hold.
    ///
    /// # Errors
    /// What is wrong with it, and what to do.
    pub fn check(&self, text: &str) -> Result<(), String> {
        let length = text.chars().count();
        if text.trim().is_empty() {
            return Err("is empty; leave the key out where it is not known".to_owned());
        }
        if text
            .chars()
            .any(|c| c.is_control() && !(self.name == "notes" && c == '\n'))
        {
            return Err("has a line break or another control character; write it in one line".to_owned());
        }
        if length > self.longest {
            return Err(format!(
                "has {length} characters; the files of the results hold {}",
                self.longest
            ));
        }
        Ok(())
    }
}
