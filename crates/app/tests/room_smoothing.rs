//! What smoothing makes of a scan in the virtual room, against the light that the room's lamp gives.

use camino::{Utf8Path, Utf8PathBuf};
use glam::DVec3;
use isolux_app::bench::Source;
use isolux_app::catalogue::Catalogue;
use isolux_app::init;
use isolux_app::progress::Silent;
use isolux_app::scan::{self, Place, Target};
use isolux_app::session::{self, Session};
use isolux_darkroom::{Darkroom, Room};
use isolux_photometry::IntensityDistribution;
use isolux_record::{Plan, Run};
use isolux_reduce::Options;
use isolux_scan::Cancel;
use isolux_virtual::BUILT_IN;
use isolux_virtual::twins::Choice;

/// The distribution and the stray light of the day, at a distance, every second half-plane.
fn plan(distance_mm: f64) -> Plan {
    let text = format!(
        "format = \"isolux-plan/1\"\n[[block]]\nname = \"lit\"\nkind = \"lit\"\nc_range = [0, 330, 30]\ngamma_range = [0, 180, 2]\n\
         distance_mm = {distance_mm:?}\nreference_every = 91\n[[block]]\nname = \"baffled\"\nkind = \"baffled\"\nc_deg = 0\n\
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
    let keep = tempfile::tempdir().unwrap();
    let path = Utf8PathBuf::try_from(keep.path().join("run")).unwrap();
    let room = Darkroom::parse(&BUILT_IN.replace("seed = 1", &format!("seed = {seed}"))).unwrap();
    assert_eq!(room.seed, seed);
    let (station, calibration) = init::virtual_station(&Choice::default()).unwrap();
    let source = Source::from_text(&station, calibration.as_deref()).unwrap();
    let plan = plan(distance_mm);
    let inside = room.clone();
    session::run(true, async {
        let session = Session::in_room(inside, &Choice::default())?;
        let catalogue = Catalogue::new(session.links.clone());
        let mut devices = source.open(&catalogue).await?;
        let now = "2026-01-01T00:00:00Z".parse().unwrap();
        let cancel = Cancel::new();
        let place = Place::take(Target::New(&path), false)?;
        scan::on(&source, &mut devices, &plan, place, None, None, &cancel, now, &Silent).await
    })
    .unwrap();
    let run = Run::read(&path).unwrap();
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
