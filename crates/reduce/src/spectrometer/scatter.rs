//! Light that a spectroradiometer scatters inside, from what it shows where a long-pass filter before it is opaque.

use isolux_record::filter::CutOnFilter;
use isolux_record::spectra::{SCATTER_FORMAT, Scatter, SpectralCorrections};
use isolux_record::{ReadingKind, Run};

use super::error::InstrumentError;
use super::{Spectra, made, steady};
use crate::instrument::{Chain, Linear};

/// As many pixels below the filter at least.
const LEAST_PIXELS: usize = 50;
/// Classes of them, whose differences say how evenly light falls on them.
const CLASSES: usize = 10;
/// How far the cut-on may be from that of the filter, nm.
const CUT_ON_NM: f64 = 10.0;
/// So far above the cut-on a filter is clear, nm.
const CLEAR_NM: f64 = 25.0;
/// More light than this share of the strongest below the filter is not scattered.
const MOST_REL: f64 = 0.02;
/// What one filter does not show: how the share differs for light of other wavelengths and on other pixels. Half width
/// of a rectangle, of the share itself.
const UNSEEN_REL: f64 = 0.3;

/// The share of light that falls evenly on all pixels, from a run with `filter` before the entrance.
///
/// # Errors
/// [`InstrumentError`]: saturated, unsteady, no filter or another one.
pub fn scatter(run: &Run, filter: &CutOnFilter) -> Result<Scatter, InstrumentError> {
    let Spectra { calibration, records } = Spectra::of(run, ReadingKind::Lit, "light behind a filter")?;
    // What is to be found is not corrected for.
    let mut own = calibration.clone();
    own.corrections = SpectralCorrections {
        scatter: None,
        ..own.corrections
    };
    steady(&records, &own, run.header.plan.limits().reference_rel())?;
    let linear = records.iter().map(|record| Linear::of(record, &own, Chain::ALL));
    let all = linear.collect::<Result<Vec<_>, _>>()?;
    let n = all.len() as f64;
    let nm = &all[0].wavelength_nm;
    let lit = calibration.dark_pixels[1]..nm.len();
    let per_s = |place: usize| all.iter().filter_map(|of| of.per_s[place]).sum::<f64>() / n;
    let u_per_s = |place: usize| all.iter().map(|of| of.u_per_s[place].powi(2)).sum::<f64>().sqrt() / n;
    let light: Vec<(f64, f64)> = lit.clone().map(|place| (nm[place], per_s(place))).collect();
    let peak = light.iter().map(|(_, per_s)| *per_s).fold(0.0, f64::max);
    let below: Vec<usize> = lit.filter(|place| nm[*place] < filter.opaque_below_nm).collect();
    if below.len() < LEAST_PIXELS {
        return Err(InstrumentError::NoPixels {
            filter: filter.designation.clone(),
            below_nm: filter.opaque_below_nm,
            pixels: below.len(),
            least: LEAST_PIXELS,
        });
    }
    let of = |places: &[usize]| places.iter().map(|place| per_s(*place)).sum::<f64>() / places.len() as f64;
    let mean = of(&below);
    // Of hundreds of pixels one is three standard uncertainties high by chance.
    let surely = |place: &usize| per_s(*place) - 4.0 * u_per_s(*place);
    let brightest = below.iter().map(surely).fold(0.0, f64::max);
    if brightest > MOST_REL * peak {
        return Err(InstrumentError::NoFilter {
            filter: filter.designation.clone(),
            below_nm: filter.opaque_below_nm,
            share_rel: brightest / peak,
        });
    }
    cut_on(&light, mean, filter)?;
    let total: f64 = light.iter().map(|(_, per_s)| per_s).sum();
    // Of all counts, those that lie evenly on the pixels; then over the counts of the light that is not scattered.
    let of_all = mean * light.len() as f64 / total;
    let share_rel = of_all / (1.0 - of_all);
    let noise2: f64 = below.iter().map(|place| u_per_s(*place).powi(2)).sum();
    let noise = noise2.sqrt() / below.len() as f64;
    let classes: Vec<f64> = below.chunks(below.len().div_ceil(CLASSES)).map(of).collect();
    let squares: f64 = classes.iter().map(|class| (class - mean).powi(2)).sum();
    let uneven = (squares / (classes.len() - 1) as f64).sqrt();
    let third = 3.0_f64.sqrt();
    let leak = filter.transmittance_below_max * peak / third;
    let parts = [noise, uneven, leak, UNSEEN_REL / third * mean.abs()];
    let u = parts.iter().map(|part| part * part).sum::<f64>().sqrt();
    Ok(Scatter {
        format: SCATTER_FORMAT.to_owned(),
        edges_nm: Vec::new(),
        share_rel: vec![vec![share_rel]],
        u_share_rel: vec![vec![u * light.len() as f64 / total / (1.0 - of_all).powi(2)]],
        made: made(run, &filter.designation),
    })
}

/// That the light begins where the filter says.
fn cut_on(light: &[(f64, f64)], stray: f64, filter: &CutOnFilter) -> Result<(), InstrumentError> {
    let clear = light.iter().find(|(nm, _)| *nm >= filter.cut_on_nm + CLEAR_NM);
    let half = clear.map_or(f64::INFINITY, |(_, per_s)| 0.5 * (per_s - stray));
    let found = light.iter().find(|(_, per_s)| per_s - stray > half);
    let found_nm = found.map_or(f64::NAN, |(nm, _)| *nm);
    if (found_nm - filter.cut_on_nm).abs() <= CUT_ON_NM {
        return Ok(());
    }
    Err(InstrumentError::OtherFilter {
        filter: filter.designation.clone(),
        stated_nm: filter.cut_on_nm,
        found_nm,
    })
}
