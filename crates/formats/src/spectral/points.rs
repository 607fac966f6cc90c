//! From rows of numbers with their places to a spectrum: axis, order, repeats.

use serde_json::{Map, Value};

use super::axis::AxisUnit;
use super::checks::{gaps, negatives, outliers, range};
use super::density::{self, Stated};
use super::file::{Series, SpectrumFile};
use super::point::Point;
use crate::finding::{Finding, Findings};

/// Everything a reader collected.
#[derive(Debug)]
pub(super) struct Draft {
    pub points: Vec<Point>,
    /// Abscissae whose rows are there but hold no finite value.
    pub left_out: Vec<f64>,
    /// One name a series; may be short.
    pub names: Vec<String>,
    pub axis: Option<AxisUnit>,
    pub quantity: Option<String>,
    pub unit: Option<String>,
    pub header: Map<String, Value>,
    /// False once something was found that makes the numbers not trustworthy.
    pub whole: bool,
}

impl Draft {
    pub fn new(encoding: &str) -> Self {
        let mut header = Map::new();
        header.insert("encoding".into(), encoding.into());
        Self {
            points: Vec::new(),
            left_out: Vec::new(),
            names: Vec::new(),
            axis: None,
            quantity: None,
            unit: None,
            header,
            whole: true,
        }
    }

    /// The spectrum, if nothing stands against it.
    pub fn finish(mut self, findings: &mut Findings) -> Option<SpectrumFile> {
        if self.points.is_empty() && !self.whole {
            return None;
        }
        if self.points.is_empty() {
            findings.push(
                Finding::error("spectrum-empty", "no pair of wavelength and value stands in this file")
                    .fix("fetch the file again, or check that it is a spectrum"),
            );
            return None;
        }
        self.axis_in_nm(findings)?;
        self.order(findings);
        if self.whole && self.points.len() < 2 {
            let line = self.points[0].line;
            findings.push(
                Finding::error("spectrum-short", "one pair alone is no spectrum")
                    .at(line, 1)
                    .fix("fetch the file again"),
            );
            self.whole = false;
        }
        if self.whole {
            gaps(&self.points, &self.left_out, findings);
            outliers(&self.points, findings);
            range(&self.points, findings);
            negatives(&self.points, findings);
        }
        let blank = self.points.iter().find(|p| p.value.first().is_none_or(Option::is_none));
        if let (true, Some(point)) = (self.whole, blank) {
            findings.push(
                Finding::error("spectrum-blank", "no value stands beside this wavelength")
                    .at(point.line, point.column)
                    .fix("write the missing value"),
            );
            self.whole = false;
        }
        if !self.whole {
            return None;
        }
        let line = self.points[0].line;
        let file = self.document();
        if let Some(first) = file.series.first() {
            findings.push(
                Finding::note(
                    "spectrum-series",
                    format!("{} series stand in this file", file.series.len()),
                )
                .at(line, 1)
                .assumed(format!("the first, “{}”, where one is needed", first.name))
                .fix("choose another with `convert --series NAME`"),
            );
        }
        Some(file)
    }

    fn document(self) -> SpectrumFile {
        let count = self.points.iter().map(|p| p.value.len()).max().unwrap_or(0);
        let series = (0..count)
            .map(|k| Series {
                name: self
                    .names
                    .get(k)
                    .filter(|name| !name.is_empty())
                    .cloned()
                    .unwrap_or_else(|| format!("series {}", k + 1)),
                value: self.points.iter().map(|p| p.value.get(k).copied().flatten()).collect(),
            })
            .collect();
        SpectrumFile {
            wavelength_nm: self.points.iter().map(|p| p.x).collect(),
            value: self
                .points
                .iter()
                .filter_map(|p| p.value.first().copied().flatten())
                .collect(),
            series: if count > 1 { series } else { Vec::new() },
            quantity: self.quantity,
            unit: self.unit,
            header: self.header,
        }
    }

    /// Brings the abscissa to nm; none where it is no wavelength.
    fn axis_in_nm(&mut self, findings: &mut Findings) -> Option<()> {
        let first = self.points.first().map_or((1, 1), |p| (p.line, p.column));
        let largest = self.points.iter().map(|p| p.x).fold(0.0, f64::max);
        let unit = self.axis.unwrap_or_else(|| {
            if !self.points.is_empty() && largest > 0.0 && largest < 30.0 {
                findings.push(
                    Finding::warning(
                        "spectrum-axis-unit",
                        "the wavelengths have no unit and are too small for nm",
                    )
                    .at(first.0, first.1)
                    .assumed("µm")
                    .fix("write the unit into the heading"),
                );
                AxisUnit::Micrometre
            } else if self.points.iter().all(|p| p.x > 2000.0) {
                findings.push(
                    Finding::warning(
                        "spectrum-axis-unit",
                        "the wavelengths have no unit and all lie above 2000: nm of the infrared, or Å, or 1/cm",
                    )
                    .at(first.0, first.1)
                    .assumed("nm")
                    .fix("write the unit into the heading"),
                );
                AxisUnit::Nanometre
            } else {
                if !self.points.is_empty() {
                    findings.push(
                        Finding::note("spectrum-axis-unit", "the wavelengths have no unit")
                            .at(first.0, first.1)
                            .assumed("nm"),
                    );
                }
                AxisUnit::Nanometre
            }
        });
        match unit {
            AxisUnit::Other(name) => {
                findings.push(
                    Finding::error(
                        "spectrum-no-wavelength",
                        format!("the abscissa is in {name}: this is no spectrum over wavelength"),
                    )
                    .at(first.0, first.1)
                    .raw(name)
                    .fix("give wavelengths in nm or µm, or wave numbers in 1/cm"),
                );
                return None;
            }
            AxisUnit::Nanometre => {}
            other => findings.push(
                Finding::note(
                    "spectrum-axis-converted",
                    format!("the abscissa is in {}", other.name()),
                )
                .at(first.0, first.1)
                .raw(other.name())
                .assumed("converted to nm"),
            ),
        }
        for x in &mut self.left_out {
            *x = unit.to_nm(*x);
        }
        self.without_anchor(findings);
        for point in &mut self.points {
            if point.x <= 0.0 {
                self.whole = false;
                findings.push(
                    Finding::error("spectrum-wavelength", "a wavelength must be above zero")
                        .at(point.line, point.column)
                        .raw(&format!("{}", point.x)),
                );
            }
            point.x = unit.to_nm(point.x);
            if self.whole && !(10.0..=1e6).contains(&point.x) {
                self.whole = false;
                findings.push(
                    Finding::error(
                        "spectrum-wavelength",
                        format!("{} nm is no wavelength of light", point.x),
                    )
                    .at(point.line, point.column)
                    .fix("check the number and the unit of the wavelengths"),
                );
            }
        }
        self.values_per_nm(unit, findings);
        Some(())
    }

    /// A first row at zero without any light is where a program begins its interpolation, not a wavelength.
    fn without_anchor(&mut self, findings: &mut Findings) {
        let dark = |point: &Point| point.x == 0.0 && point.value.iter().all(|&value| value == Some(0.0));
        if self.points.len() > 8 && dark(&self.points[0]) {
            let row = self.points.remove(0);
            findings.push(
                Finding::warning("spectrum-wavelength", "a row of zeros stands at the wavelength 0")
                    .at(row.line, row.column)
                    .raw("0")
                    .assumed("left out")
                    .fix("remove the row"),
            );
        }
    }

    /// Brings values that are a density per µm, Å or 1/cm to nm, as their headings say; a density that is not said is
    /// kept as it stands, with a warning.
    fn values_per_nm(&mut self, axis: AxisUnit, findings: &mut Findings) {
        let first = self.points.first().map_or((1, 1), |p| (p.line, p.column));
        let count = self.points.iter().map(|p| p.value.len()).max().unwrap_or(0);
        for k in 0..count {
            let name = self.names.get(k).cloned().unwrap_or_default();
            let of_file = |field: &Option<String>| field.clone().filter(|_| k == 0);
            let (quantity, unit) = (of_file(&self.quantity), of_file(&self.unit));
            match density::stated(&name, quantity.as_deref(), unit.as_deref(), axis) {
                Stated::Nothing => {}
                // Reported once, for the series that is used where one is needed.
                Stated::Unsaid if k > 0 => {}
                Stated::Unsaid => findings.push(
                    Finding::warning(
                        "spectrum-values-per",
                        format!(
                            "the abscissa is in {} and nothing says whether the values are per {} or per nm",
                            axis.name(),
                            axis.name()
                        ),
                    )
                    .at(first.0, first.1)
                    .raw(&name)
                    .assumed("per nm: kept as they are")
                    .fix("write the unit into the heading, such as W/m2/um"),
                ),
                Stated::Per(per) => {
                    for point in &mut self.points {
                        if let Some(Some(value)) = point.value.get_mut(k) {
                            *value *= density::to_per_nm(per, point.x);
                        }
                    }
                    findings.push(
                        Finding::note(
                            "spectrum-values-converted",
                            format!("the values are per {}", per.name()),
                        )
                        .at(first.0, first.1)
                        .raw(&name)
                        .assumed("converted to values per nm"),
                    );
                    if let Some(name) = self.names.get_mut(k) {
                        *name = density::renamed(name);
                    }
                    if k == 0 {
                        self.unit = self.unit.as_deref().map(density::renamed);
                    }
                }
            }
        }
    }

    /// Rising order without repeats, or a finding at the row that breaks it.
    fn order(&mut self, findings: &mut Findings) {
        let (mut rises, mut falls) = (0usize, 0usize);
        for pair in self.points.windows(2) {
            rises += usize::from(pair[1].x > pair[0].x);
            falls += usize::from(pair[1].x < pair[0].x);
        }
        if falls > rises {
            findings.push(
                Finding::note("spectrum-falling", "the wavelengths fall from line to line")
                    .at(self.points[0].line, 1)
                    .assumed("reversed"),
            );
            self.points.reverse();
            std::mem::swap(&mut rises, &mut falls);
        }
        if falls > 0 && self.digitised(falls) {
            let at = self
                .points
                .windows(2)
                .find(|p| p[1].x < p[0].x)
                .map_or(1, |p| p[1].line);
            findings.push(
                Finding::warning(
                    "spectrum-unsorted",
                    format!("{falls} wavelengths step back by less than 1 nm, as in a digitised curve"),
                )
                .at(at, 1)
                .assumed("sorted by wavelength")
                .fix("sort the file"),
            );
            self.points.sort_by(|a, b| a.x.total_cmp(&b.x));
        } else {
            for pair in self.points.windows(2) {
                if pair[1].x < pair[0].x {
                    self.whole = false;
                    findings.push(
                        Finding::error(
                            "spectrum-order",
                            format!("the wavelength {} nm stands after {} nm", pair[1].x, pair[0].x),
                        )
                        .at(pair[1].line, pair[1].column)
                        .raw(&format!("{}", pair[1].x))
                        .fix("put the lines back into their order, or correct the wavelength"),
                    );
                }
            }
        }
        self.merge_repeats(findings);
    }

    /// Small steps back in an uneven grid are how curves come from a digitiser; in an even grid they are damage.
    fn digitised(&self, falls: usize) -> bool {
        let steps: Vec<f64> = self.points.windows(2).map(|p| p[1].x - p[0].x).collect();
        let mut sizes: Vec<f64> = steps.iter().map(|s| s.abs()).collect();
        sizes.sort_by(f64::total_cmp);
        let median = sizes[sizes.len() / 2];
        let even = steps.iter().filter(|s| (**s - median).abs() < 0.02 * median).count() * 2 > steps.len();
        !even && falls * 3 < steps.len() && steps.iter().all(|s| *s > -1.0)
    }

    fn merge_repeats(&mut self, findings: &mut Findings) {
        let mut kept: Vec<(Point, usize)> = Vec::with_capacity(self.points.len());
        for point in std::mem::take(&mut self.points) {
            match kept.last_mut() {
                Some((last, count)) if last.x == point.x => {
                    let same = last.value == point.value;
                    let message = format!("the wavelength {} nm stands here again", point.x);
                    findings.push(
                        Finding::warning("spectrum-wavelength-repeated", message)
                            .at(point.line, point.column)
                            .raw(&format!("{}", point.x))
                            .assumed(if same {
                                "one of the equal lines"
                            } else {
                                "the mean of their values"
                            })
                            .fix("keep one line a wavelength"),
                    );
                    let n = *count as f64;
                    for (a, b) in last.value.iter_mut().zip(&point.value) {
                        *a = match (*a, *b) {
                            (Some(a), Some(b)) if a == b => Some(a),
                            (Some(a), Some(b)) => Some((a * n + b) / (n + 1.0)),
                            (a, b) => a.or(b),
                        };
                    }
                    *count += 1;
                }
                _ => kept.push((point, 1)),
            }
        }
        self.points = kept.into_iter().map(|(p, _)| p).collect();
    }
}
