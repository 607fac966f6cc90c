//! Energy label and product information of a light source: Regulations (EU) 2019/2015 and 2019/2020.
//!
//! Definitions, factors and classes are those of Annexes I and II of 2019/2015, the rows of the table those of Table 3
//! of its Annex V. What was not measured and is not stated is not known, with the reason.

mod class;
mod file;
mod flux;
mod rows;

use isolux_record::Run;

pub use class::{Class, f_tm};
pub(crate) use file::file;
pub use file::{FILE, quoted};
pub use flux::{Cone, Directional};
pub use rows::{Known, NOT_STATED, Row};

use crate::error::ReduceError;
use crate::{Quantity, Reduction};

/// What the label of a light source says.
#[derive(Debug, Clone, PartialEq)]
pub struct Label {
    /// Whether the light source is directional, and why.
    pub directional: Directional,
    /// Useful luminous flux in lm.
    pub useful_flux: Quantity,
    /// Where it lies.
    pub cone: Cone,
    /// F_TM, where the job says whether the light source is operated on the mains.
    pub f_tm: Option<f64>,
    /// Total mains efficacy η_TM in lm/W, or why there is none.
    pub efficacy: Result<Quantity, &'static str>,
    /// Class of η_TM.
    pub class: Option<Class>,
    /// Probability of each class that has at least one in a thousand, by the normal distribution of η_TM; empty where
    /// its uncertainty is not known.
    pub probabilities: Vec<(Class, f64)>,
    /// The table of the product information sheet.
    pub rows: Vec<Row>,
}

/// The label of a run whose job has a table `[eu_label]`; none without one.
///
/// # Errors
/// [`ReduceError::Distribution`] never for a grid that was one already.
pub fn label(reduction: &Reduction, run: &Run) -> Result<Option<Label>, ReduceError> {
    let stated = &run.header.eu_label;
    if stated.is_empty() {
        return Ok(None);
    }
    let (directional, cone, useful_flux) = flux::useful(reduction)?;
    let f_tm = stated.mains.map(|mains| f_tm(directional.is_directional, mains));
    let power = reduction.electrical.as_ref().map(|line| &line.power);
    let efficacy = match (f_tm, power) {
        (None, _) => Err("the job does not say eu_label.mains: F_TM is not known"),
        (_, None) => Err("no power meter was read: the on-mode power is not known"),
        (Some(f_tm), Some(power)) => Ok(useful_flux.over(power, "lm/W", "power").times(f_tm, "lm/W")),
    };
    let class = efficacy.as_ref().ok().map(|efficacy| Class::of(efficacy.value));
    let probabilities = efficacy.as_ref().ok().map_or_else(Vec::new, class::probabilities);
    let mut label = Label {
        directional,
        useful_flux,
        cone,
        f_tm,
        efficacy,
        class,
        probabilities,
        rows: Vec::new(),
    };
    label.rows = rows::rows(&label, reduction, run);
    Ok(Some(label))
}
