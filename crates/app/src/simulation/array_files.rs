//! Maps as files that ImageJ, Python and a spreadsheet open: `.npy`, 32-bit TIFF, CSV.

use std::fmt::Write as _;
use std::io::Cursor;

use isolux_sim::array::Array;

use crate::Failure;

/// NumPy's format 1.0: little-endian float32, C order, `[ny][nx]`.
pub fn npy(values: &[f32], nx: usize, ny: usize) -> Array<u8> {
    let mut header = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': ({ny}, {nx}), }}");
    // Magic, version and length take 10 bytes; the data begin at a multiple of 64.
    while (10 + header.len() + 1) % 64 != 0 {
        header.push(' ');
    }
    header.push('\n');
    let [low, high] = (header.len() as u16).to_le_bytes();
    let head = [&b"\x93NUMPY\x01\x00"[..], &[low, high], header.as_bytes()].concat();
    let mut bytes = Array::zeros(head.len() + 4 * values.len());
    let (start, data) = bytes.split_at_mut(head.len());
    start.copy_from_slice(&head);
    for (four, value) in data.chunks_exact_mut(4).zip(values) {
        four.copy_from_slice(&value.to_le_bytes());
    }
    bytes
}

/// One-channel 16-bit TIFF, row 0 first.
///
/// # Errors
/// When the encoder refuses the size.
pub fn tiff16(values: &[u16], nx: usize, ny: usize) -> Result<Vec<u8>, Failure> {
    let mut bytes = Cursor::new(Vec::new());
    let mut encoder = tiff::encoder::TiffEncoder::new(&mut bytes).map_err(Failure::instrument)?;
    encoder
        .write_image::<tiff::encoder::colortype::Gray16>(nx as u32, ny as u32, values)
        .map_err(Failure::instrument)?;
    Ok(bytes.into_inner())
}

/// One-channel 32-bit float TIFF, row 0 first.
///
/// # Errors
/// When the encoder refuses the size.
pub fn tiff(values: &[f32], nx: usize, ny: usize) -> Result<Vec<u8>, Failure> {
    let mut bytes = Cursor::new(Vec::new());
    let mut encoder = tiff::encoder::TiffEncoder::new(&mut bytes).map_err(Failure::instrument)?;
    encoder
        .write_image::<tiff::encoder::colortype::Gray32Float>(nx as u32, ny as u32, values)
        .map_err(Failure::instrument)?;
    Ok(bytes.into_inner())
}

/// `ix,iy,x_mm,y_mm,` and a column of values named with their unit.
pub fn csv(values: &[f32], nx: usize, ny: usize, size_mm: [f64; 2], column: &str) -> Vec<u8> {
    let mut text = format!("ix,iy,x_mm,y_mm,{column}\n");
    for (index, value) in values.iter().enumerate() {
        let (ix, iy) = (index % nx, index / nx);
        let place = |k: usize, n: usize, extent: f64| ((k as f64 + 0.5) / n as f64 - 0.5) * extent;
        let (x, y) = (place(ix, nx, size_mm[0]), place(iy, ny, size_mm[1]));
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{ix},{iy},{x},{y},{value}");
    }
    text.into_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn npy_has_the_header_that_numpy_writes() {
        let bytes = npy(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], 3, 2);
        assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00");
        let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        assert_eq!((10 + length) % 64, 0);
        assert!(
            std::str::from_utf8(&bytes[10..10 + length])
                .unwrap()
                .contains("'shape': (2, 3)")
        );
        assert_eq!(&bytes[10 + length + 4..10 + length + 8], &2.0_f32.to_le_bytes());
    }

    #[test]
    fn tiff_comes_back() {
        let bytes = tiff(&[0.5, -1.0, 2.0, 7.25], 2, 2).unwrap();
        let mut decoder = tiff::decoder::Decoder::new(Cursor::new(bytes)).unwrap();
        assert_eq!(decoder.dimensions().unwrap(), (2, 2));
        let tiff::decoder::DecodingResult::F32(values) = decoder.read_image().unwrap() else {
            panic!("not float")
        };
        assert_eq!(values, [0.5, -1.0, 2.0, 7.25]);
    }
}
