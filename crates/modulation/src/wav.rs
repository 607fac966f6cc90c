//! Samples of a RIFF WAVE file.

use std::io::Cursor;

use hound::{SampleFormat, WavReader};

use crate::WaveformError;
use crate::recorded::Recorded;

/// One channel; full scale is 1.
pub(crate) fn read(bytes: &[u8], stated_rate_hz: Option<f64>) -> Result<Recorded, WaveformError> {
    let file = |problem: String| WaveformError::File(problem);
    let unreadable = |error: hound::Error| file(format!("no readable WAVE file: {error}"));
    let mut reader = WavReader::new(Cursor::new(bytes)).map_err(unreadable)?;
    let spec = reader.spec();
    if let Some(rate_hz) = stated_rate_hz {
        return Err(file(format!(
            "the file states its sample rate, {} Hz: leave the stated one, {rate_hz} Hz, out",
            spec.sample_rate
        )));
    }
    if spec.channels != 1 {
        return Err(file(format!(
            "{} channels: write the channel of the photodiode to a file of its own",
            spec.channels
        )));
    }
    let (samples, range) = match spec.sample_format {
        SampleFormat::Float => {
            let samples = reader.samples::<f32>().map(|sample| sample.map(f64::from));
            (samples.collect::<Result<Vec<_>, _>>().map_err(unreadable)?, (-1.0, 1.0))
        }
        SampleFormat::Int => {
            let scale = f64::from(spec.bits_per_sample.saturating_sub(1)).exp2();
            let samples = reader
                .samples::<i32>()
                .map(|sample| sample.map(|value| f64::from(value) / scale));
            let highest = 1.0 - 1.0 / scale;
            (
                samples.collect::<Result<Vec<_>, _>>().map_err(unreadable)?,
                (-1.0, highest),
            )
        }
    };
    Ok(Recorded {
        samples,
        rate_hz: f64::from(spec.sample_rate),
        unit: "of full scale".to_owned(),
        range: Some(range),
    })
}

#[cfg(test)]
mod tests {
    use hound::{WavSpec, WavWriter};

    use super::*;
    use crate::Source;
    use crate::Waveform;

    fn file(bits: u16, format: SampleFormat, channels: u16, peak: f64) -> Vec<u8> {
        let spec = WavSpec {
            channels,
            sample_rate: 8000,
            bits_per_sample: bits,
            sample_format: format,
        };
        let mut bytes = Cursor::new(Vec::new());
        let mut writer = WavWriter::new(&mut bytes, spec).unwrap();
        let full = f64::from(bits - 1).exp2();
        for k in 0..800 * i32::from(channels) {
            let value = peak * (0.6 + 0.4 * (0.1 * f64::from(k)).sin());
            match format {
                SampleFormat::Float => writer.write_sample(value as f32).unwrap(),
                SampleFormat::Int => writer
                    .write_sample((value * full).floor().min(full - 1.0) as i32)
                    .unwrap(),
            }
        }
        writer.finalize().unwrap();
        bytes.into_inner()
    }

    #[test]
    fn every_depth_gives_the_same_signal_to_its_own_step() {
        for (bits, format) in [
            (8, SampleFormat::Int),
            (16, SampleFormat::Int),
            (24, SampleFormat::Int),
            (32, SampleFormat::Int),
            (32, SampleFormat::Float),
        ] {
            let read = Waveform::parse(&file(bits, format, 1, 0.9), Source::default()).unwrap();
            assert_eq!((read.rate_hz(), read.samples().len()), (8000.0, 800));
            let step = (-f64::from(bits.min(24) - 1)).exp2();
            for (k, value) in read.samples().iter().enumerate() {
                let expected = 0.9 * (0.6 + 0.4 * (0.1 * k as f64).sin());
                assert!(
                    (value - expected).abs() <= step,
                    "{bits} bits, {k}: {value}, {expected}"
                );
            }
        }
    }

    #[test]
    fn full_scale_two_channels_and_a_second_rate_are_refused() {
        let parse = |bytes: &[u8], rate_hz| Waveform::parse(bytes, Source { rate_hz, dark: None });
        for bits in [8, 16, 24] {
            let clipped = parse(&file(bits, SampleFormat::Int, 1, 1.1), None);
            assert!(
                matches!(clipped, Err(WaveformError::OverRange { .. })),
                "{bits}: {clipped:?}"
            );
        }
        assert!(parse(&file(16, SampleFormat::Int, 2, 0.9), None).is_err());
        assert!(parse(&file(16, SampleFormat::Int, 1, 0.9), Some(8000.0)).is_err());
        assert!(parse(b"RIFF", None).is_err());
    }
}
