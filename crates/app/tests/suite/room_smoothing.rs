//! What smoothing makes of a scan in the virtual room, against the light that the room's lamp gives.

use camino::Utf8Path;
use glam::DVec3;
use isolux_darkroom::{Darkroom, Room};
use isolux_photometry::IntensityDistribution;
use isolux_record::Plan;
use isolux_reduce::Options;
use isolux_virtual::BUILT_IN;

/// The distribution and the stray light of the day, at a distance, every fourth half-plane.
fn plan(distance_mm: f64) -> Plan {
    let text = format!(
        "format = \"isolux-plan/1\"\n[[block]]\nname = \"lit\"\nkind = \"lit\"\n\
         c_range = [0, 300, 60]\ngamma_range = [0, 180, 2]\ndistance_mm = {distance_mm:?}\nreference_every = 91\n\
         [[block]]\nname = \"baffled\"\nkind = \"baffled\"\nc_deg = 0\n\
         gamma_range = [0, 180, 30]\nrepeats = 3\ndistance_mm = {distance_mm:?}\n"
    );
    Plan::parse(Utf8Path::new("plan.toml"), &text).unwrap()
}

/// Root mean square of the errors up to γ 80°, after the factor that brings the whole nearest to the light: calibration
/// and distance are wrong for all directions alike.
fn rms_cd(room: &Room, distribution: &IntensityDistribution) -> f64 {
    let gammas = distribution.gamma_deg();
    let pairs: Vec<(f64, f64)> = distribution
        .intensity_cd()
        .iter()
        .enumerate()
        .map(|(place, read)| {
            (
                distribution.c_deg()[place / gammas.len()],
                gammas[place % gammas.len()],
                *read,
            )
        })
        .filter(|(_, gamma, _)| *gamma <= 80.0)
        .map(|(c, gamma, read)| {
            let (c, gamma) = (c.to_radians(), gamma.to_radians());
            let direction = DVec3::new(gamma.sin() * c.cos(), gamma.sin() * c.sin(), gamma.cos());
            (room.lamp().far_field_cd(direction), read)
        })
        .collect();
    let product: f64 = pairs.iter().map(|(light, read)| light * read).sum();
    let factor = product / pairs.iter().map(|(light, _)| light * light).sum::<f64>();
    let squares: f64 = pairs.iter().map(|(light, read)| (read - factor * light).powi(2)).sum();
    (squares / pairs.len() as f64).sqrt()
}

/// Errors of the raw and of the smoothed distribution of a scan in a room with this seed.
fn errors_cd(seed: u64, distance_mm: f64) -> (f64, f64) {
    let room = Darkroom::parse(&BUILT_IN.replace("seed = 1", &format!("seed = {seed}"))).unwrap();
    assert_eq!(room.seed, seed);
    let run = crate::in_room::scanned(room.clone(), &plan(distance_mm));
    let reduction = isolux_reduce::reduce(&run, &Options::default(), None).unwrap();
    let room = Room::new(room);
    let (raw, _) = reduction.grid.smoothed.as_ref().unwrap();
    (rms_cd(&room, raw), rms_cd(&room, &reduction.grid.distribution))
}

#[test]
fn smoothing_brings_a_scan_nearer_to_the_light() {
    for seed in [1, 2, 3] {
        let (raw, smooth) = errors_cd(seed, 10_000.0);
        assert!(smooth < 0.75 * raw, "seed {seed}, 10 m: {raw} → {smooth} cd");
    }
    let (raw, smooth) = errors_cd(4, 3_700.0);
    assert!(smooth < raw, "3.7 m: {raw} → {smooth} cd");
}
