//! Images as maps: `.npy`, 16-bit `.tiff` and `.png`. Row 0 of the file is iy = 0.

use camino::Utf8Path;

use crate::table::read_bytes;
use crate::table::{ObservationError, Problem};

/// The values of an image row by row, `bins` = [width, height].
pub(super) fn read_image(path: &Utf8Path, bins: [usize; 2]) -> Result<Vec<f64>, ObservationError> {
    let bytes = read_bytes(path)?;
    let refuse = |reason: String| ObservationError::new(path, None, Problem::Image(reason));
    let (found, values) = match path.extension() {
        Some("npy") => npy(&bytes).map_err(refuse)?,
        Some("png") => png_16(&bytes).map_err(refuse)?,
        Some("tif" | "tiff") => tiff_16(&bytes).map_err(refuse)?,
        other => {
            return Err(refuse(format!(
                "extension `{}` is none of npy, png, tif, tiff",
                other.unwrap_or("")
            )));
        }
    };
    if found != bins {
        return Err(ObservationError::new(
            path,
            None,
            Problem::ImageSize { found, expected: bins },
        ));
    }
    if let Some(at) = values.iter().position(|value| !value.is_finite()) {
        return Err(refuse(format!(
            "iy {}, ix {}: {} is no finite number",
            at / bins[0],
            at % bins[0],
            values[at]
        )));
    }
    Ok(values)
}

type Image = ([usize; 2], Vec<f64>);

/// NumPy's format 1.0–3.0, C order, little-endian floats and unsigned integers.
fn npy(bytes: &[u8]) -> Result<Image, String> {
    if bytes.len() < 12 || &bytes[..6] != b"\x93NUMPY" {
        return Err("no NumPy file".into());
    }
    let (start, length) = if bytes[6] == 1 {
        (10, u16::from_le_bytes([bytes[8], bytes[9]]) as usize)
    } else {
        (
            12,
            u32::from_le_bytes([bytes[8], bytes[9], bytes[10], bytes[11]]) as usize,
        )
    };
    let header = bytes
        .get(start..start + length)
        .and_then(|header| std::str::from_utf8(header).ok())
        .ok_or("its header is cut")?;
    let field = |key: &str| {
        let after = &header[header.find(&format!("'{key}'"))? + key.len() + 2..];
        Some(after.trim_start_matches([':', ' ']).to_owned())
    };
    let descr = field("descr").ok_or("no descr")?;
    let descr = descr
        .trim_start_matches('\'')
        .split('\'')
        .next()
        .unwrap_or("")
        .to_owned();
    if field("fortran_order").is_some_and(|order| order.starts_with("True")) {
        return Err("Fortran order; save it in C order".into());
    }
    let shape = field("shape").ok_or("no shape")?;
    let shape: Vec<usize> = shape
        .trim_start_matches('(')
        .split(')')
        .next()
        .unwrap_or("")
        .split(',')
        .filter_map(|n| n.trim().parse().ok())
        .collect();
    let [rows, columns] = shape[..] else {
        return Err(format!("shape {shape:?}: a map has two dimensions"));
    };
    let data = &bytes[start + length..];
    let width = match descr.as_str() {
        "<f8" => 8,
        "<f4" => 4,
        "<u2" => 2,
        "|u1" => 1,
        _ => return Err(format!("dtype `{descr}` is none of <f8, <f4, <u2, |u1")),
    };
    if rows.checked_mul(columns).and_then(|n| n.checked_mul(width)) != Some(data.len()) {
        return Err(format!("{} bytes of data for shape {shape:?}", data.len()));
    }
    let values = data
        .chunks_exact(width)
        .map(|chunk| match *chunk {
            [a, b, c, d, e, f, g, h] => f64::from_le_bytes([a, b, c, d, e, f, g, h]),
            [a, b, c, d] => f32::from_le_bytes([a, b, c, d]) as f64,
            [a, b] => u16::from_le_bytes([a, b]) as f64,
            [a, ..] => a as f64,
            [] => 0.0,
        })
        .collect();
    Ok(([columns, rows], values))
}

fn png_16(bytes: &[u8]) -> Result<Image, String> {
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes))
        .read_info()
        .map_err(|error| error.to_string())?;
    let size = reader.output_buffer_size().ok_or("too large")?;
    let mut pixels = vec![0; size];
    let info = reader.next_frame(&mut pixels).map_err(|error| error.to_string())?;
    if (info.color_type, info.bit_depth) != (png::ColorType::Grayscale, png::BitDepth::Sixteen) {
        return Err(format!(
            "{:?} of {:?} bits; 16-bit grey is needed",
            info.color_type, info.bit_depth as u8
        ));
    }
    let values = pixels[..info.buffer_size()]
        .chunks_exact(2)
        .map(|p| u16::from_be_bytes([p[0], p[1]]) as f64)
        .collect();
    Ok(([info.width as usize, info.height as usize], values))
}

fn tiff_16(bytes: &[u8]) -> Result<Image, String> {
    use tiff::decoder::{Decoder, DecodingResult};
    let mut decoder = Decoder::new(std::io::Cursor::new(bytes)).map_err(|error| error.to_string())?;
    let (width, height) = decoder.dimensions().map_err(|error| error.to_string())?;
    let values: Vec<f64> = match decoder.read_image().map_err(|error| error.to_string())? {
        DecodingResult::U16(values) => values.into_iter().map(f64::from).collect(),
        DecodingResult::F32(values) => values.into_iter().map(f64::from).collect(),
        DecodingResult::F64(values) => values,
        _ => return Err("16-bit grey or floating point is needed".into()),
    };
    if values.len() != width as usize * height as usize {
        return Err("one channel is needed".into());
    }
    Ok(([width as usize, height as usize], values))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn npy_of_numpy_is_read() {
        let header = "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }                                                \n";
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(header.as_bytes());
        for value in 0..6 {
            bytes.extend((value as f32).to_le_bytes());
        }
        let (size, values) = npy(&bytes).unwrap();
        assert_eq!((size, values), ([3, 2], vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0]));
        bytes.pop();
        assert!(npy(&bytes).is_err());
    }
}
