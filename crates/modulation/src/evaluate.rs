//! What a waveform says, each number with its uncertainty or with the reason why it is not given.

use isolux_reduce::Quantity;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::camera::Exposed;
use crate::cycle::{self, Denoised, LEAST_PERIODS, Shape, Strongest};
use crate::harmonics::Amplitudes;
use crate::waveform::Waveform;
use crate::{WaveformError, bands, noise, pst, svm};

/// Length of the pieces of a record in s: SVM and modulation depth are their means.
const PIECE_S: f64 = 1.0;
/// Pieces from which on the first and the last are left out of depth and index: the record ends in them.
const ENDS: usize = 5;
/// Slow changes of less than this share of the mean are no modulation of which too few periods were recorded.
const SLOW: f64 = 0.01;
/// Slow changes of more than this share are named.
const NAMED: f64 = 1e-3;
/// A share of the modulation below half the sample rate that is named.
const FOLDED: f64 = 0.01;
/// Points of the waveform that are kept for its figure, and the periods that they show.
const POINTS: usize = 1200;
const PERIODS: f64 = 5.0;
/// Highest frequency of the figure in Hz.
const SHOWN_HZ: f64 = 5000.0;

/// A number, or why it is not given.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Given {
    /// The number.
    pub quantity: Option<Quantity>,
    /// Why there is none.
    pub why_not: Option<String>,
}

impl Given {
    fn some(quantity: Quantity) -> Self {
        Self {
            quantity: Some(quantity),
            why_not: None,
        }
    }

    fn none(why_not: String) -> Self {
        Self {
            quantity: None,
            why_not: Some(why_not),
        }
    }

    /// As reports state it.
    pub fn stated(&self) -> String {
        match (&self.quantity, &self.why_not) {
            (Some(quantity), _) => quantity.stated(),
            (None, Some(why_not)) => format!("not given: {why_not}"),
            (None, None) => "not given".to_owned(),
        }
    }
}

/// A camera.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Camera {
    /// Lengths of exposures in s.
    pub exposures_s: Vec<f64>,
    /// Time from row to row of a rolling shutter in s.
    pub line_time_s: Option<f64>,
}

/// What a waveform says.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Modulation {
    /// Samples.
    pub samples: usize,
    /// Sample rate, Hz.
    pub rate_hz: f64,
    /// Length of the record, s.
    pub duration_s: f64,
    /// Noise of one sample (standard deviation) relative to the mean.
    pub noise_rel: f64,
    /// Smallest step between samples relative to the mean.
    pub resolution_rel: f64,
    /// Mean, in units of the file.
    pub mean: Quantity,
    /// (largest − smallest)/(largest + smallest), %, without the noise.
    pub modulation_depth: Quantity,
    /// Area above the mean over the whole area.
    pub flicker_index: Quantity,
    /// Frequency of the strongest component, Hz.
    pub dominant_frequency: Given,
    /// Stroboscopic effect visibility measure.
    pub svm: Given,
    /// Short-term flicker severity.
    pub pst_lm: Given,
    /// What a camera sees, one an exposure.
    pub exposures: Vec<Exposed>,
    /// What a person should know.
    pub notes: Vec<String>,
    /// The first periods: time in s and light relative to the mean.
    pub waveform: Vec<[f64; 2]>,
    /// The largest component of each narrow band: frequency in Hz and amplitude relative to the mean.
    pub spectrum: Vec<[f64; 2]>,
}

/// Evaluates a waveform.
///
/// # Errors
/// [`WaveformError::TooFewPeriods`] of a modulation that is slower than the record is long.
pub fn evaluate(waveform: &Waveform, camera: &Camera) -> Result<Modulation, WaveformError> {
    let (samples, rate_hz, mean) = (waveform.samples(), waveform.rate_hz(), waveform.mean());
    let duration_s = waveform.duration_s();
    let noise_rel = noise::of(samples) / mean;
    let resolution_rel = noise::resolution(samples) / mean;
    let (strongest, slow) = cycle::strongest(samples, rate_hz, noise_rel);
    let mut notes = Vec::new();
    if let Some(slow) = slow {
        let faster = strongest.map_or(0.0, |strongest| strongest.amplitude);
        if slow.amplitude > SLOW && slow.amplitude > faster {
            return Err(WaveformError::TooFewPeriods {
                duration_s,
                periods: slow.frequency_hz * duration_s,
                frequency_hz: slow.frequency_hz,
                least: LEAST_PERIODS,
            });
        }
        if slow.amplitude > NAMED {
            notes.push(format!(
                "the light changes by {:.2} % more slowly than {:.3} Hz: it is not steady",
                200.0 * slow.amplitude,
                LEAST_PERIODS / duration_s
            ));
        }
    }
    let lacking = || (!waveform.dark_is_stated()).then(|| "the dark level is not stated".to_owned());
    let light = Denoised::of(samples, rate_hz, strongest.map(|s| s.frequency_hz), noise_rel);
    let (depth, index) = shapes(&light, rate_hz, strongest, resolution_rel, (noise_rel, samples.len()));
    let amplitudes = Amplitudes::of(samples, rate_hz, PIECE_S, noise_rel);
    let (svm, folded) = svm::measured(&amplitudes);
    if folded > FOLDED * strongest.map_or(f64::INFINITY, |s| s.amplitude) {
        notes.push(format!(
            "components of {:.2} % lie just below half the sample rate, others may be folded into the band: record \
             with an anti-alias filter or a higher rate",
            100.0 * folded
        ));
    }
    let svm = if rate_hz < svm::LEAST_RATE_HZ {
        Given::none(format!("{rate_hz} Hz: {} Hz are needed", svm::LEAST_RATE_HZ))
    } else if duration_s < svm::LEAST_S - 0.5 / rate_hz {
        Given::none(format!("a record of {duration_s} s: {} s are needed", svm::LEAST_S))
    } else {
        notes.push(
            "SVM is for general lighting above 100 lx and movements below 4 m/s; CIE 249:2022-Cor1 says that its \
             calculation needs verification"
                .to_owned(),
        );
        Given::some(svm.lacking(lacking()))
    };
    let pst_lm = if rate_hz < pst::LEAST_RATE_HZ {
        Given::none(format!("{rate_hz} Hz: {} Hz are needed", pst::LEAST_RATE_HZ))
    } else if duration_s < pst::LEAST_S - 0.5 / rate_hz {
        Given::none(format!("a record of {duration_s} s: {} s are needed", pst::LEAST_S))
    } else {
        Given::some(pst::measured(samples, rate_hz, noise_rel).lacking(lacking()))
    };
    let exposures = camera
        .exposures_s
        .iter()
        .map(|exposure_s| Exposed::of(&light.bins, rate_hz, light.noise_rel, *exposure_s, camera.line_time_s));
    Ok(Modulation {
        samples: samples.len(),
        rate_hz,
        duration_s,
        noise_rel,
        resolution_rel,
        mean: Quantity::new(
            mean,
            waveform.unit().to_owned(),
            [
                ("noise", noise_rel * mean / (samples.len() as f64).sqrt()),
                ("resolution", resolution_rel * mean / 12.0_f64.sqrt()),
            ],
        )
        .lacking(lacking()),
        modulation_depth: depth.lacking(lacking()),
        flicker_index: index.lacking(lacking()),
        dominant_frequency: strongest.map_or_else(
            || Given::none("no component above the noise".to_owned()),
            |strongest| Given::some(cycle::frequency(strongest, samples.len(), rate_hz, noise_rel)),
        ),
        svm,
        pst_lm,
        exposures: exposures.collect(),
        notes,
        waveform: first_periods(waveform, strongest),
        spectrum: bands::largest(&amplitudes.mean(), amplitudes.step_hz, SHOWN_HZ),
    })
}

/// Modulation depth in % and flicker index: means over pieces of whole periods.
fn shapes(
    light: &Denoised,
    rate_hz: f64,
    strongest: Option<Strongest>,
    resolution_rel: f64,
    (noise_rel, recorded): (f64, usize),
) -> (Quantity, Quantity) {
    let frequency_hz = strongest.map_or(0.0, |strongest| strongest.frequency_hz);
    let count = light.samples.len();
    // Slower light than three periods a piece is one piece.
    let length = if frequency_hz == 0.0 {
        (PIECE_S * rate_hz) as usize
    } else if frequency_hz * PIECE_S < 3.0 {
        count
    } else {
        ((frequency_hz * PIECE_S).round() / frequency_hz * rate_hz).round() as usize
    };
    let length = length.clamp(1, count);
    let pieces = light
        .samples
        .chunks_exact(length)
        .zip(light.recorded.chunks_exact(length));
    let mut pieces: Vec<Shape> = pieces
        .map(|(piece, recorded)| Shape::of(piece, recorded, noise_rel))
        .collect();
    if pieces.len() >= ENDS {
        pieces.pop();
        pieces.remove(0);
    }
    let number = pieces.len().max(1) as f64;
    let mean = |of: fn(&Shape) -> f64| pieces.iter().map(of).sum::<f64>() / number;
    let scatter = |of: fn(&Shape) -> f64| {
        let mean = mean(of);
        let square: f64 = pieces.iter().map(|piece| (of(piece) - mean).powi(2)).sum();
        if number > 1.0 {
            (square / (number - 1.0) / number).sqrt()
        } else {
            0.0
        }
    };
    let (depth, index) = (mean(Shape::depth), mean(|shape| shape.index));
    let (lowest, highest) = (mean(|shape| shape.lowest), mean(|shape| shape.highest));
    // ∂/∂highest and ∂/∂lowest of (h − l)/(h + l).
    let slope = 2.0 * highest.hypot(lowest) / (highest + lowest).powi(2);
    // The largest of many samples with noise lies above the largest of the light.
    let kept = (light.noise_rel / noise_rel.max(f64::MIN_POSITIVE)).powi(2) * count as f64;
    let beyond = 2.0 * light.noise_rel * (2.0 * kept.max(1.0).ln()).sqrt() / (highest + lowest);
    // Where the record itself is the bound, its noise moves the extreme by 0 to 5 σ.
    let bounded = if pieces.iter().any(|piece| piece.bounded) {
        5.0 * slope * noise_rel / 3.0_f64.sqrt() / 2.0
    } else {
        0.0
    };
    let period = if frequency_hz == 0.0 {
        length
    } else {
        (rate_hz / frequency_hz).round() as usize
    };
    let turns = light.turns(period.clamp(1, count));
    let depth = Quantity::new(
        100.0 * depth,
        "%",
        [
            (
                "noise",
                100.0 * (slope * light.noise_rel).hypot(beyond / 3.0_f64.sqrt()).hypot(bounded),
            ),
            ("resolution", 100.0 * slope * resolution_rel / 12.0_f64.sqrt()),
            ("sampling", 100.0 * slope * turns),
            ("variation of the light", 100.0 * scatter(Shape::depth)),
        ],
    );
    // An edge lies anywhere between two samples.
    let edges = mean(|shape| shape.step) * mean(|shape| shape.crossings) / 12.0_f64.sqrt() / 2.0;
    let white = noise_rel / (2.0 * (recorded as f64).sqrt());
    let folded = light.noise_rel * light.noise_rel / (2.0 * index).max(light.noise_rel).max(f64::MIN_POSITIVE);
    let index = Quantity::new(
        index,
        "",
        [
            ("noise", white.hypot(folded)),
            (
                "resolution",
                resolution_rel / 12.0_f64.sqrt() / (recorded as f64).sqrt(),
            ),
            ("sampling", edges),
            ("variation of the light", scatter(|shape| shape.index)),
        ],
    );
    (depth, index)
}

/// Up to [`POINTS`] samples of the first periods.
fn first_periods(waveform: &Waveform, strongest: Option<Strongest>) -> Vec<[f64; 2]> {
    let shown_s = strongest.map_or(0.05, |strongest| PERIODS / strongest.frequency_hz);
    let count = ((shown_s * waveform.rate_hz()).ceil() as usize + 1).clamp(2, waveform.samples().len());
    let every = count.div_ceil(POINTS);
    let mean = waveform.mean();
    let samples = waveform.samples()[..count].iter().enumerate().step_by(every);
    samples
        .map(|(k, value)| [k as f64 / waveform.rate_hz(), value / mean])
        .collect()
}
