//! The words of a CGATS file.

/// One word.
#[derive(Clone, Copy)]
pub(super) struct Token<'t> {
    pub line: usize,
    pub column: usize,
    pub text: &'t str,
}

/// Cells of a row of data: between tabs, where these make as many as there are fields, else words.
pub(super) fn cells(line: &str, number: usize, fields: usize) -> Vec<Token<'_>> {
    if fields < 2 || line.split('\t').count() != fields {
        return tokens(line, number);
    }
    line.split('\t')
        .map(|cell| Token {
            line: number,
            column: crate::text::column_of(line, cell),
            text: cell.trim(),
        })
        .collect()
}

/// Words of a line; a quoted text is one word.
pub(super) fn tokens(line: &str, number: usize) -> Vec<Token<'_>> {
    let mut out = Vec::new();
    let (mut rest, mut column) = (line, 1);
    loop {
        let blanks = rest.len() - rest.trim_start().len();
        // Counted on from the word before: a line may hold all the words of the file.
        column += rest[..blanks].chars().count();
        rest = &rest[blanks..];
        if rest.is_empty() {
            return out;
        }
        let length = if let Some(quoted) = rest.strip_prefix('"') {
            quoted.find('"').map_or(rest.len(), |end| end + 2)
        } else {
            rest.find(char::is_whitespace).unwrap_or(rest.len())
        };
        out.push(Token {
            line: number,
            column,
            text: &rest[..length],
        });
        column += rest[..length].chars().count();
        rest = &rest[length..];
    }
}
