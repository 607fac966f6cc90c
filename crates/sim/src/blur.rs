//! Light that spreads to neighbouring pixels.

/// A Gaussian of standard deviation `width_px` over a map; beyond its edges the map goes on as it ends.
pub fn gaussian(map: &[f64], nx: usize, ny: usize, width_px: f64) -> Vec<f64> {
    let reach = (4.0 * width_px).ceil() as isize;
    let kernel: Vec<f64> = (-reach..=reach)
        .map(|k| (-0.5 * (k as f64 / width_px).powi(2)).exp())
        .collect();
    let total: f64 = kernel.iter().sum();
    let pass = |from: &[f64], along_x: bool| -> Vec<f64> {
        let at = |ix: isize, iy: isize| {
            from[iy.clamp(0, ny as isize - 1) as usize * nx + ix.clamp(0, nx as isize - 1) as usize]
        };
        (0..ny as isize)
            .flat_map(|iy| (0..nx as isize).map(move |ix| (ix, iy)))
            .map(|(ix, iy)| {
                let sum: f64 = kernel
                    .iter()
                    .zip(-reach..=reach)
                    .map(|(w, k)| w * if along_x { at(ix + k, iy) } else { at(ix, iy + k) })
                    .sum();
                sum / total
            })
            .collect()
    };
    pass(&pass(map, true), false)
}

/// `passes` means over 3 × 3 pixels, as map filters of commercial tools have them; at the edge over the pixels there
/// are.
pub fn box3(map: &[f64], nx: usize, ny: usize, passes: usize) -> Vec<f64> {
    let mut now = map.to_vec();
    for _ in 0..passes {
        let before = now;
        now = (0..nx * ny)
            .map(|index| {
                let (ix, iy) = (index % nx, index / nx);
                let (mut sum, mut count) = (0.0, 0.0);
                for y in iy.saturating_sub(1)..(iy + 2).min(ny) {
                    for x in ix.saturating_sub(1)..(ix + 2).min(nx) {
                        sum += before[y * nx + x];
                        count += 1.0;
                    }
                }
                sum / count
            })
            .collect();
    }
    now
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keeps_what_is_even_and_spreads_a_point() {
        assert!(gaussian(&[2.0; 30], 6, 5, 0.7).iter().all(|v| (v - 2.0).abs() < 1e-12));
        let mut point = vec![0.0; 49];
        point[24] = 81.0;
        // Two passes of a 3 × 3 mean are [1 2 3 2 1]² / 81.
        let twice = box3(&point, 7, 7, 2);
        assert!((twice[24] - 9.0).abs() < 1e-12 && (twice[23] - 6.0).abs() < 1e-12 && (twice[16] - 4.0).abs() < 1e-12);
    }
}
