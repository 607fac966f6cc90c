//! A lamp by its table of luminous intensities: what a photometric file says of a real luminaire, between the
//! directions of the file interpolated smoothly.
//!
//! Along γ each half-plane is a monotone cubic (Fritsch and Carlson 1980, SIAM J. Numer. Anal. 17, 238; slopes by
//! Butland's weighted harmonic mean), so nothing overshoots beside a cut-off; through the pole it goes on in the
//! opposite half-plane. Over C the half-planes are blended by cubics whose slopes are those of parabolas through three
//! neighbours. Value and first derivative are continuous in both; below zero it is cut off.

use std::f64::consts::TAU;

use glam::DVec3;

/// First line of a table.
pub const HEAD: &str = "c_deg,gamma_deg,intensity_cd";

/// Luminous intensities of a warm lamp on a grid of half-planes and γ, in any spacing.
#[derive(Debug, Clone, PartialEq)]
pub struct LampTable {
    c_deg: Vec<f64>,
    gamma_deg: Vec<f64>,
    /// Intensity, cd, and its slope along γ, cd/°, by half-plane and then γ.
    nodes: Vec<[f64; 2]>,
    /// From each half-plane to the next.
    between: Vec<Between>,
}

/// A table that cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: {message}")]
pub struct TableError {
    /// One-based line.
    pub line: usize,
    /// What is wrong and what would be right.
    pub message: String,
}

impl LampTable {
    /// Reads the text of a table: the line [`HEAD`], then one direction a line, half-plane after half-plane, all of
    /// them at the same γ. One half-plane is a lamp of rotational symmetry. Outside the γ of the table the lamp is
    /// dark; at γ = 0° and 180° it has the mean of all half-planes.
    ///
    /// # Errors
    /// The first line that breaks this.
    pub fn parse(text: &str) -> Result<Self, TableError> {
        let fail = |line: usize, message: String| Err(TableError { line, message });
        let (mut c_deg, mut gamma_deg, mut intensity): (Vec<f64>, Vec<f64>, Vec<f64>) = Default::default();
        let mut lines = text.lines().enumerate().map(|(index, line)| (index + 1, line.trim()));
        match lines.next() {
            Some((_, HEAD)) => {}
            _ => return fail(1, format!("a table begins with the line {HEAD}")),
        }
        for (line, content) in lines.filter(|(_, content)| !content.is_empty()) {
            let fields: Result<Vec<f64>, _> = content.split(',').map(|field| field.trim().parse()).collect();
            let Ok(&[c, gamma, value]) = fields.as_deref() else {
                return fail(line, format!("`{content}` is not three numbers: {HEAD}"));
            };
            if !(0.0..360.0).contains(&c) || !(0.0..=180.0).contains(&gamma) {
                return fail(line, "needs C from 0 to below 360 and γ from 0 to 180".to_owned());
            }
            if !(0.0..=1e9).contains(&value) {
                return fail(
                    line,
                    format!("{value} cd is no intensity; it must lie between 0 and 1e9"),
                );
            }
            // γ of this half-plane so far; the first one says how many there are.
            let begun = intensity.len() - gamma_deg.len() * c_deg.len().saturating_sub(1);
            let first = c_deg.len() <= 1;
            match c_deg.last() {
                Some(last) if *last > c => return fail(line, "half-planes must rise".to_owned()),
                Some(last) if *last == c && first => {
                    if gamma_deg.last().is_some_and(|last| *last >= gamma) {
                        return fail(line, "γ must rise within a half-plane".to_owned());
                    }
                    gamma_deg.push(gamma);
                }
                Some(last) if *last == c => {
                    if gamma_deg.get(begun) != Some(&gamma) {
                        return fail(line, "every half-plane needs the γ of the first one".to_owned());
                    }
                }
                Some(_) if !first && begun != gamma_deg.len() => {
                    return fail(
                        line,
                        "the half-plane before this line lacks γ of the first one".to_owned(),
                    );
                }
                Some(_) => {
                    if gamma_deg[0] != gamma {
                        return fail(line, "every half-plane needs the γ of the first one".to_owned());
                    }
                    c_deg.push(c);
                }
                None => {
                    c_deg.push(c);
                    gamma_deg.push(gamma);
                }
            }
            intensity.push(value);
        }
        let last = text.lines().count();
        if gamma_deg.len() < 2 {
            return fail(last, "a table needs at least two γ in each half-plane".to_owned());
        }
        if intensity.len() != gamma_deg.len() * c_deg.len() {
            return fail(last, "the last half-plane lacks γ of the first one".to_owned());
        }
        Ok(Self::new(c_deg, gamma_deg, intensity))
    }

    fn new(c_deg: Vec<f64>, gamma_deg: Vec<f64>, mut intensity_cd: Vec<f64>) -> Self {
        let (planes, count) = (c_deg.len(), gamma_deg.len());
        let poles = [(0, gamma_deg[0] == 0.0), (count - 1, gamma_deg[count - 1] == 180.0)];
        for (pole, _) in poles.into_iter().filter(|(_, is)| *is) {
            let mean = (0..planes).map(|plane| intensity_cd[plane * count + pole]).sum::<f64>() / planes as f64;
            (0..planes).for_each(|plane| intensity_cd[plane * count + pole] = mean);
        }
        let mut table = Self {
            nodes: intensity_cd.iter().map(|intensity| [*intensity, 0.0]).collect(),
            between: (0..planes).map(|plane| Between::of(&c_deg, plane)).collect(),
            c_deg,
            gamma_deg,
        };
        for plane in 0..planes {
            let opposite = table.blend(table.c_deg[plane] + 180.0);
            let beyond = |k: usize| opposite.of(|plane| table.nodes[plane * count + k][0]);
            let (mut x, mut y) = (table.gamma_deg.clone(), Vec::new());
            y.extend(
                table.nodes[plane * count..(plane + 1) * count]
                    .iter()
                    .map(|node| node[0]),
            );
            // Through a pole the curve goes on in the opposite half-plane.
            if poles[0].1 {
                x.insert(0, -x[1]);
                y.insert(0, beyond(1));
            }
            if poles[1].1 {
                x.push(360.0 - table.gamma_deg[count - 2]);
                y.push(beyond(count - 2));
            }
            let slopes = monotone_slopes(&x, &y);
            for k in 0..count {
                table.nodes[plane * count + k][1] = slopes[k + usize::from(poles[0].1)];
            }
        }
        table
    }

    /// Luminous intensity towards a unit vector of the luminaire's frame, cd.
    pub fn intensity_cd(&self, direction: DVec3) -> f64 {
        let gamma_deg = direction.z.clamp(-1.0, 1.0).acos().to_degrees();
        self.at(direction.y.atan2(direction.x).to_degrees(), gamma_deg)
    }

    /// Luminous intensity at (C, γ), cd.
    pub fn at(&self, c_deg: f64, gamma_deg: f64) -> f64 {
        let count = self.gamma_deg.len();
        if gamma_deg < self.gamma_deg[0] || gamma_deg > self.gamma_deg[count - 1] {
            return 0.0;
        }
        let cell = self
            .gamma_deg
            .partition_point(|node| *node <= gamma_deg)
            .clamp(1, count - 1)
            - 1;
        let (low, high) = (self.gamma_deg[cell], self.gamma_deg[cell + 1]);
        let weights = hermite((gamma_deg - low) / (high - low));
        let step = high - low;
        let curve = |plane: usize| {
            let [[y0, m0], [y1, m1]] = [self.nodes[plane * count + cell], self.nodes[plane * count + cell + 1]];
            weights[0] * y0 + weights[1] * step * m0 + weights[2] * y1 + weights[3] * step * m1
        };
        self.blend(c_deg).of(curve).max(0.0)
    }

    /// The half-planes around C, in any turn.
    fn blend(&self, c_deg: f64) -> Blend {
        let wanted_deg = (c_deg - self.c_deg[0]).rem_euclid(360.0) + self.c_deg[0];
        let plane = self.c_deg.partition_point(|c| *c <= wanted_deg).max(1) - 1;
        self.between[plane].at(wanted_deg - self.c_deg[plane])
    }

    /// The largest intensity of the table, cd.
    pub fn peak_cd(&self) -> f64 {
        self.nodes.iter().map(|node| node[0]).fold(0.0, f64::max)
    }

    /// The largest γ at which the lamp shines, degrees.
    pub fn last_lit_deg(&self) -> f64 {
        let count = self.gamma_deg.len();
        let illuminated = (0..self.nodes.len()).filter(|k| self.nodes[*k][0] > 0.0);
        illuminated
            .map(|k| self.gamma_deg[(k % count + 1).min(count - 1)])
            .fold(0.0, f64::max)
    }

    /// Luminous flux, lm: Gauss's rule in every cell, of two points over C, where it is exact, and of four over γ.
    pub fn flux_lm(&self) -> f64 {
        const OVER_C: [(f64, f64); 2] = [(-0.577_350_269_189_625_8, 1.0), (0.577_350_269_189_625_8, 1.0)];
        const OVER_GAMMA: [(f64, f64); 4] = [
            (-0.861_136_311_594_052_6, 0.347_854_845_137_453_9),
            (-0.339_981_043_584_856_3, 0.652_145_154_862_546_1),
            (0.339_981_043_584_856_3, 0.652_145_154_862_546_1),
            (0.861_136_311_594_052_6, 0.347_854_845_137_453_9),
        ];
        let turn = self.c_deg[0] + 360.0;
        let ends = self.c_deg[1..].iter().chain(std::iter::once(&turn));
        let mut sum = 0.0;
        for (from, to) in self.c_deg.iter().zip(ends) {
            for pair in self.gamma_deg.windows(2) {
                let (half_c, half_gamma) = (0.5 * (to - from), 0.5 * (pair[1] - pair[0]));
                for (x, weight) in OVER_C {
                    for (y, other) in OVER_GAMMA {
                        let gamma_deg = pair[0] + half_gamma * (1.0 + y);
                        let intensity = self.at(from + half_c * (1.0 + x), gamma_deg);
                        sum += weight * other * half_c * half_gamma * intensity * gamma_deg.to_radians().sin();
                    }
                }
            }
        }
        sum * (TAU / 360.0).powi(2)
    }
}

/// Values and slopes at the two ends of a cell, at the share `t` of it.
fn hermite(t: f64) -> [f64; 4] {
    let (square, cube) = (t * t, t * t * t);
    [
        2.0 * cube - 3.0 * square + 1.0,
        cube - 2.0 * square + t,
        3.0 * square - 2.0 * cube,
        cube - square,
    ]
}

/// From one half-plane to the next: these two, the one before and the one after.
#[derive(Debug, Clone, PartialEq)]
struct Between {
    planes: [usize; 4],
    width_deg: f64,
    /// Slopes at both ends, of the parabola through three neighbours, by the values of the three; times the width.
    slopes: [[f64; 3]; 2],
}

impl Between {
    fn of(c_deg: &[f64], plane: usize) -> Self {
        let count = c_deg.len();
        let planes = [count - 1, 0, 1, 2].map(|next| (plane + next) % count);
        // From one half-plane to the next, a whole turn where there is only one.
        let step = |k: usize| {
            let gap = (c_deg[planes[k + 1]] - c_deg[planes[k]]).rem_euclid(360.0);
            if gap == 0.0 { 360.0 } else { gap }
        };
        let [before, own, after] = [step(0), step(1), step(2)];
        Self {
            planes,
            width_deg: own,
            slopes: [
                [-own / before, own / before - before / own, before / own].map(|w| own * w / (before + own)),
                [-after / own, after / own - own / after, own / after].map(|w| own * w / (own + after)),
            ],
        }
    }

    /// The blend so many degrees after the half-plane.
    fn at(&self, after_deg: f64) -> Blend {
        let h = hermite(after_deg / self.width_deg);
        let [left, right] = [self.slopes[0].map(|w| h[1] * w), self.slopes[1].map(|w| h[3] * w)];
        Blend {
            planes: self.planes,
            weights: [left[0], h[0] + left[1] + right[0], h[2] + left[2] + right[1], right[2]],
        }
    }
}

/// Four half-planes and their weights at one C.
struct Blend {
    planes: [usize; 4],
    weights: [f64; 4],
}

impl Blend {
    fn of(&self, value: impl Fn(usize) -> f64) -> f64 {
        self.planes
            .iter()
            .zip(self.weights)
            .map(|(plane, weight)| weight * value(*plane))
            .sum()
    }
}

/// Slopes of the monotone cubic through (x, y) at its nodes.
fn monotone_slopes(x: &[f64], y: &[f64]) -> Vec<f64> {
    let n = x.len();
    let h: Vec<f64> = x.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let d: Vec<f64> = y.windows(2).zip(&h).map(|(pair, h)| (pair[1] - pair[0]) / h).collect();
    if n == 2 {
        return vec![d[0]; 2];
    }
    let mut slopes = vec![0.0; n];
    for k in 1..n - 1 {
        if d[k - 1] * d[k] > 0.0 {
            let (w1, w2) = (2.0 * h[k] + h[k - 1], h[k] + 2.0 * h[k - 1]);
            slopes[k] = (w1 + w2) / (w1 / d[k - 1] + w2 / d[k]);
        }
    }
    slopes[0] = end_slope(h[0], h[1], d[0], d[1]);
    slopes[n - 1] = end_slope(h[n - 2], h[n - 3], d[n - 2], d[n - 3]);
    slopes
}

/// Slope at an end, of the parabola through three nodes, held back where it would overshoot.
fn end_slope(h0: f64, h1: f64, d0: f64, d1: f64) -> f64 {
    let slope = ((2.0 * h0 + h1) * d0 - h0 * d1) / (h0 + h1);
    if slope * d0 <= 0.0 {
        0.0
    } else if d0 * d1 <= 0.0 && slope.abs() > 3.0 * d0.abs() {
        3.0 * d0
    } else {
        slope
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(c_deg: &[f64], gamma_deg: &[f64], light: impl Fn(f64, f64) -> f64) -> LampTable {
        let mut text = format!("{HEAD}\n");
        for c in c_deg {
            for gamma in gamma_deg {
                text += &format!("{c},{gamma},{}\n", light(*c, *gamma));
            }
        }
        LampTable::parse(&text).unwrap()
    }

    fn every(step: f64, last: f64) -> Vec<f64> {
        (0..=(last / step) as usize).map(|k| k as f64 * step).collect()
    }

    /// A lobe that leans to C = 0° by a tenth, of 1 + sin γ cos C in its shape.
    fn leaning(c_deg: f64, gamma_deg: f64) -> f64 {
        let (sin, cos) = gamma_deg.to_radians().sin_cos();
        1000.0 * (1.0 + 0.1 * sin * c_deg.to_radians().cos()) * (1.0 + cos)
    }

    #[test]
    fn a_smooth_lamp_is_met_between_the_nodes_and_at_them() {
        let table = table(&every(15.0, 345.0), &every(2.5, 180.0), leaning);
        for k in 0..2000 {
            let (c, gamma) = (137.508 * f64::from(k) % 360.0, 180.0 * (f64::from(k) + 0.5) / 2000.0);
            let (got, expected) = (table.at(c, gamma), leaning(c, gamma));
            assert!((got - expected).abs() < 0.3, "{c} {gamma}: {got} against {expected}");
        }
        assert_eq!(table.at(45.0, 40.0), leaning(45.0, 40.0));
        assert_eq!(table.at(-315.0, 40.0), table.at(45.0, 40.0));
        // ∫(1 + cos γ) is a sphere of 1000 cd; the leaning part integrates to nothing.
        assert!((table.flux_lm() / (4000.0 * std::f64::consts::PI) - 1.0).abs() < 1e-4);
    }

    #[test]
    fn it_is_smooth_through_cells_half_planes_and_poles_of_an_uneven_grid() {
        let gamma = [0.0, 1.0, 3.0, 10.0, 11.0, 40.0, 60.0, 90.0, 170.0, 180.0];
        let table = table(&[10.0, 30.0, 100.0, 250.0], &gamma, leaning);
        let direction = |c: f64, gamma: f64| {
            let (sin, cos) = gamma.to_radians().sin_cos();
            DVec3::new(sin * c.to_radians().cos(), sin * c.to_radians().sin(), cos)
        };
        // On great circles through everything: steps of the derivative fall with the step of the angle.
        let kink = |step: f64| {
            let mut worst = 0.0f64;
            for c in [0.0, 30.0, 77.0] {
                let turns = (360.0 / step) as usize;
                let at = |k: usize| table.intensity_cd(direction(c, k as f64 * step));
                for k in 1..turns {
                    worst = worst.max((at(k + 1) - 2.0 * at(k) + at(k - 1)).abs() / step);
                }
            }
            worst
        };
        let (coarse, fine) = (kink(0.1), kink(0.01));
        assert!(fine < 0.2 * coarse, "{coarse} {fine}");
    }

    #[test]
    fn nothing_overshoots_beside_a_cut_off() {
        let cut = |_: f64, gamma: f64| if gamma <= 60.0 { 500.0 } else { 0.0 };
        let table = table(&[0.0], &every(5.0, 180.0), cut);
        for k in 0..=1800 {
            let value = table.at(77.0, f64::from(k) * 0.1);
            assert!((0.0..500.001).contains(&value), "{k}: {value}");
        }
        assert_eq!((table.at(0.0, 60.0), table.at(0.0, 65.0)), (500.0, 0.0));
        assert_eq!((table.peak_cd(), table.last_lit_deg()), (500.0, 65.0));
    }

    #[test]
    fn a_table_of_the_lower_half_is_dark_above() {
        let table = table(&[0.0, 90.0, 180.0, 270.0], &every(5.0, 90.0), leaning);
        assert!(table.at(0.0, 89.9) > 0.0);
        assert_eq!(table.at(0.0, 90.1), 0.0);
    }

    #[test]
    fn a_damaged_table_is_refused_with_its_line() {
        let text = format!("{HEAD}\n0,0,10\n0,90,5\n90,0,10\n90,90,4\n180,0,10\n180,90,5\n");
        LampTable::parse(&text).unwrap();
        for (from, to, line, word) in [
            (HEAD, "c,gamma,cd", 1, HEAD),
            ("0,90,5\n90", "0,90,x\n90", 3, "three numbers"),
            ("90,90,4", "90,80,4", 5, "the γ of the first"),
            ("90,90,4\n", "", 5, "lacks"),
            ("180,90,5\n", "", 6, "lacks"),
            ("180,0,10", "360,0,10", 6, "below 360"),
            ("90,0,10", "90,0,-1", 4, "intensity"),
            ("90,0,10", "90,0,nan", 4, "intensity"),
            ("0,90,5\n90,0,10", "0,0,5\n90,0,10", 3, "rise"),
            ("180,0,10\n180,90,5", "45,0,10\n45,90,5", 6, "half-planes must rise"),
            ("180,90,5\n", "180,90,5,1\n", 7, "three"),
        ] {
            assert!(text.contains(from), "{from}");
            let error = LampTable::parse(&text.replacen(from, to, 1)).unwrap_err();
            assert_eq!(error.line, line, "{from} → {to}: {error}");
            assert!(error.message.contains(word), "{from} → {to}: {error}");
        }
    }
}
