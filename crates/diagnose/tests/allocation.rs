//! What a diagnosis allocates: the values of its thousands of patterns are never all there at once where there are many
//! readings.
//!
//! Every allocation of this process goes through a counter.

#![expect(clippy::print_stdout, reason = "the peak is what a person runs this for")]

use std::fmt::Write as _;

use camino::Utf8PathBuf;
use isolux_allocation::Counting;
use isolux_diagnose::diagnosis::diagnose;
use isolux_diagnose::document::Verdict;
use isolux_diagnose::search::Settings;
use isolux_model::Model;
use isolux_record::observation::{Need, open};
use rand::{RngExt as _, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

#[global_allocator]
static COUNTING: Counting = Counting;

const READINGS: usize = 20_000;
/// All patterns at once would be about 700 MB, and the search would hold them more than once.
const BOUND: usize = 512 << 20;

const MODEL: &str = r#"format = "isolux-model/1"
[luminaire]
distribution = "distribution.csv"
emitter = { shape = "disc", diameter_mm = 1.0 }
[luminaire.trust]
shape = "smooth"
c_harmonics = [2]
"#;

fn intensity_cd(gamma_deg: i32) -> f64 {
    350.0 * f64::from(gamma_deg).to_radians().cos().max(0.0).powi(5)
}

/// Half-planes at three distances, back and forth, of a lamp that the model knows.
fn readings() -> String {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut csv = String::from(
        "index,block,kind,time_s,c_deg,gamma_deg,distance_mm,travel,range,ambient_c,illuminance_lx,u_lx\n",
    );
    let planes = READINGS.div_ceil(29);
    for i in 0..READINGS {
        let (plane, k) = (i / 29, (i % 29) as i32);
        let travel = if plane % 2 == 0 { 1 } else { -1 };
        let gamma = travel * (5 * k - 70);
        let distance_m = [2, 1, 3][3 * plane / planes];
        let (c, time) = ((plane * 15) % 360, 4 * i + 100);
        let lx = intensity_cd(gamma.abs()) / f64::from(distance_m * distance_m);
        let u = (0.003 * lx).hypot(0.01);
        let read = lx + u * rng.sample::<f64, _>(StandardNormal);
        let _ = writeln!(
            csv,
            "{i},A,lit,{time},{c},{gamma},{distance_m}000,{travel},1,25,{read:.6},{u:.6}"
        );
    }
    csv
}

#[test]
fn many_readings_need_little_more_memory_than_few() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| Utf8PathBuf::try_from(folder.path().join(name)).unwrap();
    let mut distribution = String::from("gamma_deg,intensity_cd\n");
    for gamma in 0..=90 {
        let _ = writeln!(distribution, "{gamma},{}", intensity_cd(gamma));
    }
    std::fs::write(path("distribution.csv"), distribution).unwrap();
    std::fs::write(path("model.toml"), MODEL).unwrap();
    std::fs::write(path("readings.csv"), readings()).unwrap();
    let model = Model::load(&path("model.toml")).unwrap();
    let observations = [open(&path("readings.csv"), Need::Values).unwrap()];
    let settings = Settings {
        nulls: 100,
        ..Settings::default()
    };
    let (found, most) = isolux_allocation::most(|| diagnose(&model, &observations, None, "", &settings).unwrap());
    println!("most at a time: {} MB", most >> 20);
    assert_eq!(found.document.verdict, Verdict::Consistent);
    assert!(most < BOUND, "{most} bytes");
}
