//! Tables on paper: how wide each column is, and its rows.

use super::blocks::Layout;
use super::piece::{CELL, Ink, Item, Kind, LEFT, Piece, Style, WIDTH, in_part, style, text, wrapped};
use crate::document::ReportTable;

/// Room between columns.
const GAP: f32 = 9.0;

impl Layout<'_> {
    /// One piece a row, the head with the first.
    pub(super) fn table(&self, table: &ReportTable, pieces: &mut Vec<Piece>) {
        let columns = table
            .rows
            .iter()
            .map(Vec::len)
            .chain([table.head.len()])
            .max()
            .unwrap_or(0);
        if columns == 0 {
            return;
        }
        // Wide tables of numbers are set smaller.
        let size = if columns > 10 { 6.6 } else { CELL.size };
        let cell = Style { size, ..CELL };
        let widths = self.widths(table, columns, cell);
        let head_style = style(size - 0.5, true, Ink::Muted);
        let number = self.next();
        let head =
            (!table.head.is_empty()).then(|| Box::new(self.row(&table.head, &widths, head_style, table.numbers)));
        let mut first = true;
        for cells in &table.rows {
            let mut piece = self.row(cells, &widths, cell, table.numbers);
            piece.of = Some(self.own(Kind::Row {
                head: false,
                named: table.head.is_empty() || table.numbers,
                table: number,
            }));
            if table.head.is_empty()
                && let Some(Item::Text { style, .. }) = piece.items.first_mut()
            {
                style.ink = Ink::Muted;
            }
            if let (true, Some(head)) = (first, &head) {
                let mut head = (**head).clone();
                (head.above, head.with_next) = (7.0, true);
                head.of = Some(self.own(Kind::Row {
                    head: true,
                    named: false,
                    table: number,
                }));
                pieces.push(head);
            } else {
                piece.head.clone_from(&head);
                piece.above = if first { 7.0 } else { 0.0 };
            }
            first = false;
            pieces.push(piece);
        }
    }

    /// As wide as the longest line of each column; where they do not fit, the wide ones are narrower, never below their
    /// longest word while that fits.
    fn widths(&self, table: &ReportTable, columns: usize, cell: Style) -> Vec<f32> {
        let room = WIDTH - GAP * (columns as f32 - 1.0);
        let all = || table.rows.iter().chain(std::iter::once(&table.head));
        let of = |column: usize, measure: &dyn Fn(&str) -> f32| {
            let cells = all().filter_map(|row| row.get(column));
            cells.map(|text| measure(text)).fold(4.0, f32::max)
        };
        // Bold is wider than regular.
        let style = Style { bold: true, ..cell };
        let line = |text: &str| self.fonts.width(text, style) + 1.0;
        let word = |text: &str| text.split(' ').map(line).fold(0.0, f32::max);
        let natural: Vec<f32> = (0..columns).map(|column| of(column, &line)).collect();
        if natural.iter().sum::<f32>() <= room {
            return natural;
        }
        let least: Vec<f32> = (0..columns).map(|column| of(column, &word).min(room / 2.0)).collect();
        let spare = room - least.iter().sum::<f32>();
        if spare <= 0.0 {
            let total: f32 = least.iter().sum();
            return least.iter().map(|width| width * room / total).collect();
        }
        let wanted: f32 = natural.iter().zip(&least).map(|(natural, least)| natural - least).sum();
        let share = spare / wanted.max(1e-3);
        natural
            .iter()
            .zip(&least)
            .map(|(natural, least)| least + (natural - least) * share)
            .collect()
    }

    fn row(&self, cells: &[String], widths: &[f32], style: Style, numbers: bool) -> Piece {
        let step = 1.28 * style.size;
        let mut items = Vec::new();
        let mut lines = 1;
        let mut x = LEFT;
        for (column, (words, &width)) in cells.iter().zip(widths).enumerate() {
            let wrapped = wrapped(words, width + 0.5, style, self.fonts);
            lines = lines.max(wrapped.len());
            for (place, line) in wrapped.into_iter().enumerate() {
                let right = width - self.fonts.width(&line, style);
                let at = if numbers && column > 0 { x + right } else { x };
                let line = text(at, style.size + 1.5 + step * place as f32, style, line);
                items.push(in_part(line, column));
            }
            x += width + GAP;
        }
        let height = 4.0 + step * lines as f32;
        items.push(Item::Box {
            at: [LEFT, height - 0.8, x - GAP - LEFT, 0.4],
            ink: Ink::Line,
        });
        Piece {
            items,
            height,
            ..Piece::default()
        }
    }
}
