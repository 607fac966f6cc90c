//! The interval of a grid that holds an abscissa, in constant time.

/// Buckets of equal width over a rising grid: the interval of an abscissa in constant time.
#[derive(Debug, Clone)]
pub(crate) struct Search {
    origin: f64,
    per_bucket: f64,
    first: Vec<u32>,
}

impl Search {
    pub(crate) fn over(grid: &[f64]) -> Self {
        let (Some(&origin), Some(&end)) = (grid.first(), grid.last()) else {
            return Self {
                origin: 0.0,
                per_bucket: 0.0,
                first: vec![0],
            };
        };
        if grid.len() < 2 {
            return Self {
                origin,
                per_bucket: 0.0,
                first: vec![0],
            };
        }
        let buckets = (grid.len() * 4).max(16);
        let width = (end - origin) / buckets as f64;
        let mut interval = 0;
        let first = (0..=buckets)
            .map(|bucket| {
                let start = origin + width * (bucket as f64 - 1e-9);
                while interval + 2 < grid.len() && grid[interval + 1] <= start {
                    interval += 1;
                }
                interval as u32
            })
            .collect();
        Self {
            origin,
            per_bucket: 1.0 / width,
            first,
        }
    }

    #[inline]
    pub(crate) fn interval(&self, grid: &[f64], x: f64) -> usize {
        let bucket = ((x - self.origin) * self.per_bucket) as usize;
        let mut interval = self.first[bucket.min(self.first.len() - 1)] as usize;
        while interval + 2 < grid.len() && grid[interval + 1] <= x {
            interval += 1;
        }
        interval
    }
}
