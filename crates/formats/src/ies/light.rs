//! The light of an LM-63 file on its grid: types A, B and C.

use isolux_photometry::{IntensityDistribution, Symmetry};

use super::edition::Edition;
use super::scene::Scene;
use super::{angles, native};
use crate::distribution::Native;
use crate::finding::{Finding, Findings};
use crate::plausible;

/// Resampled light that differs less from the file's own is the file's.
const MOST_OFF: f64 = 0.01;

/// Planes with their horizontal angles.
type Planes<'c> = Vec<(f64, &'c [f64])>;

type Grid = (IntensityDistribution, Symmetry, Option<Native>);

impl Scene<'_, '_> {
    pub fn grid(&self, vertical: &[f64], horizontal: &[f64], candela: &[f64], findings: &mut Findings) -> Option<Grid> {
        let at_vertical = self.place(self.layout.vertical);
        if vertical.len() < 2 {
            let message = "one vertical angle is no distribution";
            findings.push(
                Finding::error("ies-angles", message)
                    .at(at_vertical.0, at_vertical.1)
                    .fix("at least two are needed"),
            );
            return None;
        }
        let made = match self.lamp.photometric_type {
            'C' => self.type_c(vertical, horizontal, candela, findings),
            other => self.type_a_or_b(other, vertical, horizontal, candela, findings),
        };
        match made {
            Ok(grid) => Some(grid),
            Err(message) => {
                findings.push(
                    Finding::error("ies-angles", message)
                        .at(at_vertical.0, at_vertical.1)
                        .fix("correct the angles or the photometric type"),
                );
                None
            }
        }
    }

    fn type_c(
        &self,
        vertical: &[f64],
        horizontal: &[f64],
        candela: &[f64],
        findings: &mut Findings,
    ) -> Result<Grid, String> {
        let nv = vertical.len();
        let (line, column) = self.place(self.layout.vertical);
        let (first, last) = (vertical[0], vertical[nv - 1]);
        if !(matches!(first, 0.0 | 90.0) && matches!(last, 90.0 | 180.0)) && (0.0..=180.0).contains(&first) {
            let message =
                format!("vertical angles go from {first}° to {last}°; the standard has 0° or 90° to 90° or 180°");
            findings.push(
                Finding::warning("ies-vertical-range", message)
                    .at(line, column)
                    .assumed("no light outside these angles"),
            );
        }
        let rows: Vec<(f64, &[f64])> = horizontal.iter().copied().zip(candela.chunks(nv)).collect();
        let (symmetry, rows) = self.circle(rows, findings)?;
        let rows: Vec<(f64, Vec<f64>)> = rows.into_iter().map(|(c, row)| (c, row.to_vec())).collect();
        let grid =
            IntensityDistribution::expand(symmetry, &rows, vertical.to_vec()).map_err(|error| error.to_string())?;
        Ok((grid, symmetry, None))
    }

    /// Symmetry class and stored planes within [0, 360).
    fn circle<'c>(&self, rows: Planes<'c>, findings: &mut Findings) -> Result<(Symmetry, Planes<'c>), String> {
        let (line, column) = self.place(self.layout.horizontal);
        let first = rows.first().map_or(0.0, |row| row.0);
        let last = rows.last().map_or(0.0, |row| row.0);
        let odd = |message: String, assumed: &str| {
            Finding::warning("ies-horizontal-range", message)
                .at(line, column)
                .assumed(assumed.to_owned())
        };
        if rows.len() == 1 {
            if first != 0.0 {
                findings.push(odd(
                    format!("the only horizontal angle is {first}°"),
                    "rotational symmetry",
                ));
            }
            return Ok((Symmetry::Rotational, vec![(0.0, rows[0].1)]));
        }
        match (first, last) {
            (0.0, 90.0) => Ok((Symmetry::Quadrant, rows)),
            (0.0, 180.0) => Ok((Symmetry::C0C180, rows)),
            (90.0, 270.0) => {
                if self.preamble.edition >= Edition::E2002 {
                    let message = "horizontal angles from 90° to 270° belong to the 1995 edition".to_owned();
                    findings.push(odd(message, "symmetry about C90–C270"));
                }
                Ok((Symmetry::C90C270, rows))
            }
            (-90.0, 90.0) => {
                let message = "horizontal angles from −90° to 90° in type C".to_owned();
                findings.push(odd(message, "symmetry about C90–C270"));
                Ok((
                    Symmetry::C90C270,
                    rows.into_iter().map(|(c, row)| (c.rem_euclid(360.0), row)).collect(),
                ))
            }
            _ => Ok((Symmetry::None, self.full_circle(rows, findings)?)),
        }
    }

    fn full_circle<'c>(&self, rows: Planes<'c>, findings: &mut Findings) -> Result<Planes<'c>, String> {
        let (line, column) = self.place(self.layout.horizontal);
        let (first, last) = (rows[0].0, rows[rows.len() - 1].0);
        if last - first > 360.0 {
            return Err(format!(
                "horizontal angles from {first}° to {last}° are more than a circle"
            ));
        }
        let widest = rows.windows(2).map(|pair| pair[1].0 - pair[0].0).fold(0.0, f64::max);
        let gap = 360.0 - (last - first);
        if first < 0.0 {
            let message = format!("horizontal angles begin at {first}°");
            findings.push(
                Finding::warning("ies-horizontal-range", message)
                    .at(line, column)
                    .assumed("C = H + 360° below zero"),
            );
        }
        if gap > 1e-6 {
            let message = format!("horizontal angles go from {first}° to {last}°");
            let finding = if gap <= 1.5 * widest {
                Finding::note("ies-horizontal-range", message).assumed("a full circle")
            } else {
                Finding::warning("ies-horizontal-range", message)
                    .assumed("a full circle, interpolated over the gap")
                    .fix("the standard ends at 0°, 90°, 180° or 360°")
            };
            findings.push(finding.at(line, column));
            return Ok(rows.into_iter().map(|(c, row)| (c.rem_euclid(360.0), row)).collect());
        }
        let mut rows = rows;
        if let Some((_, closing)) = rows.pop()
            && let Some((_, opening)) = rows.first()
            && let Some(at) = (0..closing.len()).find(|&at| closing[at] != opening[at])
        {
            let index = self.layout.candela + rows.len() * self.layout.nv + at;
            let (line, column) = self.place(index);
            let token = self.tokens.get(index).map_or("", |token| token.text);
            let peak = rows
                .iter()
                .flat_map(|(_, row)| row.iter())
                .fold(0.0, |most: f64, &value| most.max(value));
            findings.push(
                Finding::new(
                    plausible::closing_severity(opening, closing, peak),
                    "ies-closing-plane",
                    format!("the planes at {first}° and {last}° are one plane, yet they differ"),
                )
                .at(line, column)
                .raw(token)
                .assumed(format!("the plane at {first}°"))
                .fix("repeat the first plane as the last"),
            );
        }
        Ok(rows.into_iter().map(|(c, row)| (c.rem_euclid(360.0), row)).collect())
    }

    fn type_a_or_b(
        &self,
        kind: char,
        vertical: &[f64],
        horizontal: &[f64],
        candela: &[f64],
        findings: &mut Findings,
    ) -> Result<Grid, String> {
        let (line, column) = self.place(self.layout.vertical);
        let source = native::Native {
            type_a: kind == 'A',
            vertical_deg: vertical,
            horizontal_deg: horizontal,
            candela,
        };
        let reach = source.reach_deg();
        if reach > 90.0 {
            let message = format!("type {kind} has angles within ±90°; these reach {reach}°");
            findings.push(
                Finding::warning("ies-angle-range", message)
                    .at(line, column)
                    .assumed("the same coordinates beyond 90°")
                    .fix("check the photometric type"),
            );
        }
        if horizontal.len() == 1 {
            findings.push(
                Finding::warning("ies-horizontal-range", format!("one horizontal angle in type {kind}"))
                    .at(line, column)
                    .assumed("the same candela at every horizontal angle")
                    .fix("check the photometric type"),
            );
        }
        self.mirrored(vertical, horizontal, findings);
        let grid = source.resampled().map_err(|error| error.to_string())?;
        findings.push(resampling(kind, &source, &grid).at(line, column));
        let native = Native {
            photometry_type: if kind == 'A' { "A" } else { "B" },
            vertical_deg: vertical.to_vec(),
            horizontal_deg: horizontal.to_vec(),
            intensity_cd: candela.chunks(vertical.len()).map(<[f64]>::to_vec).collect(),
            c0_axis: "horizontal_positive",
        };
        Ok((grid.intensity, source.symmetry(), Some(native)))
    }

    /// Angles of type A or B that begin at 0 or above stand for those below as well. For horizontal angles that is
    /// lateral symmetry, as LM-63 has it; of vertical ones it says only that they may begin at 0.
    fn mirrored(&self, vertical: &[f64], horizontal: &[f64], findings: &mut Findings) {
        if let &[first, _, ..] = horizontal
            && native::folds(horizontal)
        {
            let message = format!("horizontal angles begin at {first}°");
            let finding = if first == 0.0 {
                Finding::note("ies-mirrored", message)
            } else {
                Finding::warning("ies-mirrored", message).fix("begin at 0° or −90°")
            };
            let (line, column) = self.place(self.layout.horizontal);
            findings.push(finding.at(line, column).assumed("left like right"));
        }
        if native::folds(vertical) {
            let message = format!(
                "vertical angles begin at {}°: what lies below is not stated",
                vertical[0]
            );
            let (line, column) = self.place(self.layout.vertical);
            findings.push(
                Finding::warning("ies-mirrored", message)
                    .at(line, column)
                    .assumed("below V = 0 the light is as above: half of the flux is not in the file")
                    .fix("write vertical angles from −90° to 90°"),
            );
        }
    }
}

/// How the light over C-γ differs from the file's own: a warning from 1 %, or where the file's step is too fine.
fn resampling(kind: char, source: &native::Native<'_>, grid: &angles::Resampled) -> Finding {
    let step = grid.step_deg;
    let smallest = source.smallest_step().unwrap_or(step);
    let mut message = format!("type {kind} is resampled to C-γ every {step}°");
    let coarser = step > smallest.min(30.0) + 1e-9;
    if coarser {
        message += &format!("; its smallest step, {smallest}°, is too fine");
    }
    for (off, what) in [(grid.flux_off, "flux"), (grid.peak_off, "peak")] {
        if let Some(off) = off {
            message += &format!(", {what} {:+.2} %", 100.0 * off);
        }
    }
    let finding = if coarser || grid.off() >= MOST_OFF {
        Finding::warning("ies-resampled", message)
            .fix("trust flux and peak, which are the file's own; what is simulated or turned is the resampled light")
    } else {
        Finding::note("ies-resampled", message)
    };
    finding.assumed("V = 0, H = 0 is γ = 0, positive H is C0, positive V is C90")
}
