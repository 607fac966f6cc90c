//! Colours of a map.

/// The colour map viridis (van der Walt and Smith), by a polynomial of degree six.
pub fn viridis(t: f64) -> [u8; 3] {
    let [colour] = viridis_of([t]);
    colour
}

/// Colours that the vector units take side by side.
pub(super) const SIDE_BY_SIDE: usize = 8;

/// [`viridis`] of several numbers.
pub(super) fn viridis_of<const N: usize>(t: [f64; N]) -> [[u8; 3]; N] {
    const TERMS: [[f64; 3]; 7] = [
        [0.277_727_3, 0.005_407_3, 0.334_099_8],
        [0.105_093_0, 1.404_613_5, 1.384_590_2],
        [-0.330_861_8, 0.214_847_6, 0.095_095_2],
        [-4.634_230_5, -5.799_101_0, -19.332_441],
        [6.228_269_9, 14.179_933_4, 56.690_552_6],
        [4.776_385_0, -13.745_145_4, -65.353_032_6],
        [-5.435_455_9, 4.645_852_6, 26.312_435_2],
    ];
    let t = t.map(|t| if t.is_finite() { t.clamp(0.0, 1.0) } else { 0.0 });
    let mut colours = [[0; 3]; N];
    for k in 0..3 {
        let mut sums = [0.0; N];
        for term in TERMS.iter().rev() {
            for (sum, t) in sums.iter_mut().zip(t) {
                *sum = *sum * t + term[k];
            }
        }
        for (colour, sum) in colours.iter_mut().zip(sums) {
            colour[k] = (sum.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
        }
    }
    colours
}
