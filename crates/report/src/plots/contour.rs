//! Level lines of a function on a grid (marching squares) and pictures of its values.

/// Values on a grid, row 0 at the top edge of the picture.
pub(super) struct Grid {
    pub columns: usize,
    pub rows: usize,
    pub value: Vec<f64>,
}

impl Grid {
    /// Samples `of(x, y)` with both from 0 to 1, y downwards, edges included.
    pub fn sample(columns: usize, rows: usize, of: impl Fn(f64, f64) -> f64) -> Self {
        let value = (0..rows * columns)
            .map(|i| {
                let (row, column) = (i / columns, i % columns);
                of(column as f64 / (columns - 1) as f64, row as f64 / (rows - 1) as f64)
            })
            .collect();
        Self { columns, rows, value }
    }

    fn at(&self, column: usize, row: usize) -> f64 {
        self.value[row * self.columns + column]
    }

    /// The line of one level as pieces between two points, both coordinates from 0 to 1.
    pub fn level(&self, level: f64) -> Vec<[(f64, f64); 2]> {
        let mut pieces = Vec::new();
        let (w, h) = ((self.columns - 1) as f64, (self.rows - 1) as f64);
        for row in 0..self.rows - 1 {
            for column in 0..self.columns - 1 {
                let corner = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(dx, dy)| (column + dx, row + dy));
                let value = corner.map(|(c, r)| self.at(c, r));
                if value.iter().any(|v| !v.is_finite()) {
                    continue;
                }
                let crossings: Vec<(f64, f64)> = (0..4)
                    .filter_map(|k| {
                        let (a, b) = (value[k], value[(k + 1) % 4]);
                        ((a < level) != (b < level)).then(|| {
                            let t = (level - a) / (b - a);
                            let ((ca, ra), (cb, rb)) = (corner[k], corner[(k + 1) % 4]);
                            (
                                (ca as f64 + t * (cb as f64 - ca as f64)) / w,
                                (ra as f64 + t * (rb as f64 - ra as f64)) / h,
                            )
                        })
                    })
                    .collect();
                match crossings[..] {
                    [a, b] => pieces.push([a, b]),
                    // A saddle: the mean decides which corners belong together.
                    [a, b, c, d] => {
                        let joined = (value.iter().sum::<f64>() / 4.0 < level) == (value[0] < level);
                        pieces.extend(if joined { [[a, b], [c, d]] } else { [[d, a], [b, c]] });
                    }
                    _ => {}
                }
            }
        }
        pieces
    }

    /// The values as a picture in colours from white over yellow and red to dark, `high` being the darkest.
    pub fn png(&self, high: f64) -> Option<Vec<u8>> {
        let rgb: Vec<u8> = self
            .value
            .iter()
            .flat_map(|v| shade(if high > 0.0 { v / high } else { 0.0 }))
            .collect();
        encode(&rgb, self.columns, self.rows, png::ColorType::Rgb)
    }
}

/// A PNG of 8 bits a channel.
pub(super) fn encode(bytes: &[u8], width: usize, height: usize, colour: png::ColorType) -> Option<Vec<u8>> {
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, width as u32, height as u32);
    encoder.set_color(colour);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header().ok()?;
    writer.write_image_data(bytes).ok()?;
    writer.finish().ok()?;
    Some(out)
}

/// White, yellow, orange, red, dark violet: brightness falls steadily, so that it also prints in grey.
pub(super) fn shade(share: f64) -> [u8; 3] {
    const STOPS: [[f64; 3]; 6] = [
        [255.0, 255.0, 255.0],
        [255.0, 243.0, 178.0],
        [254.0, 201.0, 94.0],
        [245.0, 135.0, 55.0],
        [203.0, 63.0, 64.0],
        [110.0, 20.0, 84.0],
    ];
    let position = share.clamp(0.0, 1.0) * 5.0;
    let k = (position as usize).min(4);
    let t = position - k as f64;
    std::array::from_fn(|c| (STOPS[k][c] + t * (STOPS[k + 1][c] - STOPS[k][c])).round() as u8)
}

/// Levels 1, 2, 5, 10 … below `high`, at most `count`.
pub(super) fn decade_levels(high: f64, count: usize) -> Vec<f64> {
    if !(high > 0.0 && high.is_finite()) {
        return Vec::new();
    }
    let decade = high.log10().floor() as i32;
    (decade - 6..=decade)
        .flat_map(|d| [1.0, 2.0, 5.0].map(|lead| lead * 10f64.powi(d)))
        .filter(|level| *level < 0.97 * high)
        .collect::<Vec<_>>()
        .into_iter()
        .rev()
        .take(count)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_circle_is_a_circle() {
        let grid = Grid::sample(81, 81, |x, y| (x - 0.5).hypot(y - 0.5));
        let pieces = grid.level(0.3);
        assert!(pieces.len() > 100);
        for (x, y) in pieces.into_iter().flatten() {
            assert!(((x - 0.5).hypot(y - 0.5) - 0.3).abs() < 1e-3);
        }
    }

    #[test]
    fn levels_are_round() {
        assert_eq!(decade_levels(60.0, 4), [50.0, 20.0, 10.0, 5.0]);
        assert!(decade_levels(0.0, 4).is_empty());
    }
}
