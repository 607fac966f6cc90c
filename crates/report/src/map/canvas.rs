//! A raster picture with words.

use font8x8::legacy::{BASIC_LEGACY, LATIN_LEGACY};
use isolux_sim::array::Array;

/// Where words stand beside their point.
pub(super) enum Align {
    Left,
    Centre,
    Right,
}

/// An RGB raster with a fixed font: 8 × 8 letters at double size.
pub(super) struct Canvas {
    pub(super) width: usize,
    height: usize,
    pub(super) rgb: Array<u8>,
}

impl Canvas {
    pub(super) fn new(width: usize, height: usize) -> Self {
        let mut rgb = Array::zeros(width * height * 3);
        rgb.fill(255);
        Self { width, height, rgb }
    }

    pub(super) fn set(&mut self, x: usize, y: usize, colour: [u8; 3]) {
        if x < self.width && y < self.height {
            let at = (y * self.width + x) * 3;
            self.rgb[at..at + 3].copy_from_slice(&colour);
        }
    }

    pub(super) fn horizontal(&mut self, x: usize, y: usize, length: usize) {
        (x..x + length).for_each(|x| self.set(x, y, [40; 3]));
    }

    pub(super) fn vertical(&mut self, x: usize, y: usize, length: usize) {
        (y..y + length).for_each(|y| self.set(x, y, [40; 3]));
    }

    pub(super) fn frame(&mut self, left: usize, top: usize, width: usize, height: usize) {
        self.horizontal(left - 1, top - 1, width + 2);
        self.horizontal(left - 1, top + height, width + 2);
        self.vertical(left - 1, top - 1, height + 2);
        self.vertical(left + width, top - 1, height + 2);
    }

    pub(super) fn text(&mut self, x: usize, y: usize, align: Align, text: &str) {
        const LETTER: usize = 12;
        let length = text.chars().count() * LETTER;
        let start = match align {
            Align::Left => x,
            Align::Centre => x.saturating_sub(length / 2),
            Align::Right => x.saturating_sub(length),
        };
        for (k, letter) in text.chars().enumerate() {
            let rows = match letter as usize {
                code @ 0..128 => BASIC_LEGACY[code],
                code @ 160..256 => LATIN_LEGACY[code - 160],
                0x2212 => BASIC_LEGACY['-' as usize],
                _ => BASIC_LEGACY['?' as usize],
            };
            for (row, bits) in rows.iter().enumerate() {
                for column in (0..8).filter(|column| bits >> column & 1 == 1) {
                    // Twice as tall as the font, half as wide again.
                    let left = start + k * LETTER + column * 3 / 2;
                    for dx in 0..2 {
                        for dy in 0..2 {
                            self.set(left + dx, y + 2 * row + dy, [25; 3]);
                        }
                    }
                }
            }
        }
    }

    pub(super) fn png(&self) -> Vec<u8> {
        let mut out = Vec::new();
        let mut encoder = png::Encoder::new(&mut out, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::Fast);
        // As small as with the filter that suits each line best, without a search for it.
        encoder.set_filter(png::Filter::Paeth);
        // Writing to memory with matching sizes cannot fail.
        if let Ok(mut writer) = encoder.write_header() {
            let _ = writer.write_image_data(&self.rgb);
        }
        out
    }
}
