//! Samples of a text file: one column, or time and value.
//!
//! Lines that begin with `#` are comments; of them `# sample_rate_hz = 20000` and `# range = -0.1 0.9` are read. A line
//! of words names the columns; what follows the last `_` of a name is its unit. Columns are parted by commas, or by
//! semicolons or tabs, and then numbers may have decimal commas.

use crate::WaveformError;
use crate::recorded::Recorded;

/// A time may differ from its place by this share of a step: times that were rounded.
const UNEVEN: f64 = 0.2;
/// Largest relative difference of a stated sample rate from that of the times.
const RATE_DIFFERENCE: f64 = 1e-3;

struct Columns {
    /// Seconds of a unit of the time column; none without one.
    time_s: Option<f64>,
    unit: String,
}

pub(crate) fn read(bytes: &[u8], stated_rate_hz: Option<f64>) -> Result<Recorded, WaveformError> {
    let text = std::str::from_utf8(bytes)
        .map_err(|_| WaveformError::File("neither text (UTF-8) nor a WAVE file".to_owned()))?;
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut columns: Option<Columns> = None;
    let (mut times, mut samples, mut places) = (Vec::new(), Vec::new(), Vec::new());
    let (mut noted_rate_hz, mut range) = (None, None);
    for (number, line) in text.lines().enumerate() {
        let (line, number) = (line.trim(), number + 1);
        let wrong = |problem: String| WaveformError::Line { line: number, problem };
        if line.is_empty() {
            continue;
        }
        if let Some(comment) = line.strip_prefix('#') {
            if let Some((key, value)) = comment.split_once('=') {
                match key.trim() {
                    "sample_rate_hz" => {
                        noted_rate_hz = Some(
                            number_of(value, false)
                                .ok_or_else(|| wrong(format!("\"{}\" is no sample rate in Hz", value.trim())))?,
                        );
                    }
                    "range" => {
                        let ends: Vec<f64> = value
                            .split_whitespace()
                            .filter_map(|end| number_of(end, false))
                            .collect();
                        let [low, high] = ends[..] else {
                            return Err(wrong(format!("\"{}\" is no range: two numbers", value.trim())));
                        };
                        range = Some((low, high));
                    }
                    _ => {}
                }
            }
            continue;
        }
        let (cells, comma) = cells(line);
        if samples.is_empty() && columns.is_none() && cells.iter().any(|cell| number_of(cell, comma).is_none()) {
            columns = Some(named(&cells).map_err(wrong)?);
            continue;
        }
        let wanted = match &columns {
            Some(columns) => 1 + usize::from(columns.time_s.is_some()),
            None => 1,
        };
        if cells.len() != wanted {
            let how = if columns.is_some() {
                format!("{} columns instead of {wanted}", cells.len())
            } else {
                format!(
                    "{} columns without names: begin with a line of names such as time_s,value_V, or keep one column",
                    cells.len()
                )
            };
            return Err(wrong(how));
        }
        let value = |cell: &str| number_of(cell, comma).ok_or_else(|| wrong(format!("\"{cell}\" is no number")));
        if let Some(unit_s) = columns.as_ref().and_then(|columns| columns.time_s) {
            times.push(unit_s * value(cells[0])?);
            places.push(number);
        }
        samples.push(value(cells[wanted - 1])?);
    }
    let timed = columns.as_ref().is_some_and(|columns| columns.time_s.is_some());
    let of_times = if timed { Some(rate_of(&times, &places)?) } else { None };
    let rate_hz = match (of_times, noted_rate_hz, stated_rate_hz) {
        (Some(rate_hz), noted, stated) => {
            for other in [noted, stated].into_iter().flatten() {
                // A rate that is no number differs too.
                let same = (other / rate_hz - 1.0).abs() <= RATE_DIFFERENCE;
                if !same {
                    return Err(WaveformError::File(format!(
                        "the times give {rate_hz} Hz, stated are {other} Hz: leave the wrong one out"
                    )));
                }
            }
            rate_hz
        }
        (None, Some(noted), Some(stated)) if (noted / stated - 1.0).abs() > RATE_DIFFERENCE => {
            return Err(WaveformError::File(format!(
                "the file notes {noted} Hz, stated are {stated} Hz: leave the wrong one out"
            )));
        }
        (None, Some(rate_hz), _) | (None, None, Some(rate_hz)) => rate_hz,
        (None, None, None) => {
            return Err(WaveformError::File(
                "one column without a sample rate: state it (--rate, or sample_rate_hz in a job), or add a \
                 column time_s before the values"
                    .to_owned(),
            ));
        }
    };
    Ok(Recorded {
        samples,
        rate_hz,
        unit: columns.map(|columns| columns.unit).unwrap_or_default(),
        range,
    })
}

/// The cells of a line, and whether its numbers may have decimal commas.
fn cells(line: &str) -> (Vec<&str>, bool) {
    let (by, comma) = match line {
        line if line.contains(';') => (';', true),
        line if line.contains('\t') => ('\t', true),
        _ => (',', false),
    };
    (line.split(by).map(str::trim).collect(), comma)
}

fn number_of(cell: &str, comma: bool) -> Option<f64> {
    let cell = cell.trim();
    let number = if comma {
        cell.replacen(',', ".", 1).parse()
    } else {
        cell.parse()
    };
    number.ok().filter(|value: &f64| value.is_finite())
}

fn named(cells: &[&str]) -> Result<Columns, String> {
    let bare = |cell: &&str| cell.trim_matches('"').to_owned();
    let names: Vec<String> = cells.iter().map(bare).collect();
    let unit = |name: &str| {
        name.rsplit_once('_')
            .map(|(_, unit)| unit.to_owned())
            .unwrap_or_default()
    };
    match &names[..] {
        [value] => Ok(Columns {
            time_s: None,
            unit: unit(value),
        }),
        [time, value] => {
            let time_s = match time.as_str() {
                "time_s" => 1.0,
                "time_ms" => 1e-3,
                "time_us" => 1e-6,
                _ => {
                    return Err(format!(
                        "the first of two columns is \"{time}\": name it time_s, time_ms or time_us"
                    ));
                }
            };
            Ok(Columns {
                time_s: Some(time_s),
                unit: unit(value),
            })
        }
        _ => Err(format!("{} columns: keep the time and one value", names.len())),
    }
}

/// The sample rate of even times in seconds; `places` are their lines.
fn rate_of(times: &[f64], places: &[usize]) -> Result<f64, WaveformError> {
    let (Some(first), Some(last)) = (times.first(), times.last()) else {
        return Err(WaveformError::File("no samples".to_owned()));
    };
    let step_s = (last - first) / (times.len().max(2) - 1) as f64;
    if !(step_s.is_finite() && step_s > 0.0) {
        return Err(WaveformError::File("the times do not rise".to_owned()));
    }
    for (k, (time, line)) in times.iter().zip(places).enumerate() {
        let off = (time - first) / step_s - k as f64;
        if off.abs() > UNEVEN {
            return Err(WaveformError::Line {
                line: *line,
                problem: format!(
                    "{time} s is {off:+.2} steps from its place: the times are not even, or rounded too coarsely; \
                     record without gaps, or give the values alone with their sample rate"
                ),
            });
        }
    }
    Ok(1.0 / step_s)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Source, Waveform};

    fn parse(text: &str, rate_hz: Option<f64>) -> Result<Waveform, WaveformError> {
        Waveform::parse(text.as_bytes(), Source { rate_hz, dark: None })
    }

    fn lines(line: impl Fn(usize) -> String) -> String {
        (0..100).map(|k| line(k) + "\n").collect()
    }

    #[test]
    fn columns_rates_and_units() {
        let timed = format!(
            "time_ms,voltage_V\n{}",
            lines(|k| format!("{},{}", 0.05 * k as f64, 1 + k % 2))
        );
        let read = parse(&timed, None).unwrap();
        assert!((read.rate_hz() - 20e3).abs() < 1e-6 && read.unit() == "V");
        assert_eq!(read.samples()[..3], [1.0, 2.0, 1.0]);
        assert!(parse(&timed, Some(20e3)).is_ok() && parse(&timed, Some(10e3)).is_err());
        let bare = lines(|k| format!("{}.5", k % 3));
        assert_eq!(parse(&bare, Some(2000.0)).unwrap().rate_hz(), 2000.0);
        assert!(parse(&bare, None).unwrap_err().to_string().contains("--rate"));
        let noted = format!("# sample_rate_hz = 4000\n{bare}");
        assert_eq!(parse(&noted, None).unwrap().rate_hz(), 4000.0);
        assert!(parse(&noted, Some(5000.0)).is_err());
        let commas = format!(
            "time_s;value\n{}",
            lines(|k| format!("{};1,5", k as f64 * 0.01).replace('.', ","))
        );
        assert_eq!(parse(&commas, None).unwrap().samples()[0], 1.5);
        let ranged = format!("# range = -1 2\n{noted}");
        assert!(matches!(parse(&ranged, None), Err(WaveformError::OverRange { .. })));
    }

    #[test]
    fn damaged_files_say_the_line_and_the_remedy() {
        let timed = |step: &dyn Fn(usize) -> f64| format!("time_s,value\n{}", lines(|k| format!("{},1", step(k))));
        for (text, words) in [
            (
                timed(&|k| {
                    if k < 50 {
                        0.01 * k as f64
                    } else {
                        0.01 * k as f64 + 0.05
                    }
                }),
                "steps from its place",
            ),
            (timed(&|_| 1.0), "do not rise"),
            ("time,value\n1,2\n".to_owned(), "line 1: the first of two columns"),
            ("a,b,c\n".to_owned(), "line 1: 3 columns"),
            ("1,2\n3,4\n".to_owned(), "line 1: 2 columns without names"),
            ("value\n1\n2\nx\n".to_owned(), "line 4: \"x\" is no number"),
            ("value\n1\nNaN\n".to_owned(), "line 3: \"NaN\" is no number"),
            ("value\n1\n1,2\n".to_owned(), "line 3: 2 columns instead of 1"),
            (
                "# sample_rate_hz = fast\n1\n".to_owned(),
                "line 1: \"fast\" is no sample rate",
            ),
            ("# range = 1\n1\n".to_owned(), "line 1: \"1\" is no range"),
            (
                "# sample_rate_hz = -5\n".to_owned() + &lines(|_| "1".to_owned()),
                "sample rate of -5",
            ),
            ("time_s,value\n".to_owned(), "no samples"),
            (String::new(), "--rate"),
        ] {
            let error = parse(&text, None).unwrap_err().to_string();
            assert!(error.contains(words), "{text}: {error}");
        }
        assert!(Waveform::parse(b"\xff\xfe\x00", Source::default()).is_err());
    }
}
