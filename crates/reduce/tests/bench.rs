//! Synthetic benches with a known lamp: what the reduction takes away, what it keeps, and whether its uncertainty holds.

use isolux_record::run::RunHeader;
use isolux_record::{Quality, Reading, ReadingKind, Role};
use isolux_reduce::{Correction, Reduction, Switches, luminaire_files, reduce};

const HEADER: &str = r#"
format = "isolux-run/1"
program = "test"
started_utc = "2026-01-01T00:00:00Z"
[station]
format = "isolux-station/1"
[station.bench]
type = "turning_luminaire"
distance_mm = 10000.0
u_distance_mm = 2.0
[station.axis.c]
open = "zaber:x?axis=1"
counts_per_deg = "6400/9"
zero_deg = 0.0
sense = 1
limit_deg = [-5.0, 365.0]
speed_deg_s = 20.0
accel_deg_s2 = 40.0
[station.axis.gamma]
open = "zaber:x?axis=2"
counts_per_deg = "6400/9"
zero_deg = 0.0
sense = 1
limit_deg = [-185.0, 185.0]
speed_deg_s = 20.0
accel_deg_s2 = 40.0
[station.luxmeter]
open = "konica-t10a:x"
calibration_factor = 1.0
u_rel = 0.004
[station.lamp]
prompt = "switch the lamp"
[plan]
format = "isolux-plan/1"
[[plan.block]]
name = "lit"
kind = "lit"
c_deg = [0]
gamma_deg = [0]
"#;

/// A bench: a cosⁿ lamp at 10 m, what lies on its light, and how the meter shows it.
#[derive(Clone, Copy)]
struct Bench {
    offset_lx: f64,
    room_lx: f64,
    stray_lx: f64,
    drift_per_h: f64,
    noise_lx: f64,
    digit_lx: f64,
    seed: u64,
}

const CLEAN: Bench = Bench {
    offset_lx: 0.0,
    room_lx: 0.0,
    stray_lx: 0.0,
    drift_per_h: 0.0,
    noise_lx: 0.0,
    digit_lx: 1e-9,
    seed: 0,
};

impl Bench {
    fn header() -> RunHeader {
        toml::from_str(HEADER).unwrap()
    }

    fn lamp_cd(gamma_deg: f64) -> f64 {
        337.0 * gamma_deg.to_radians().cos().max(0.0).powf(5.3)
    }

    fn reading(&self, index: u64, kind: ReadingKind, role: Role, c: f64, gamma: f64, time_s: f64) -> Reading {
        let direct = Self::lamp_cd(gamma) / 100.0;
        let light = match kind {
            ReadingKind::Lit => direct + self.stray_lx + self.room_lx,
            ReadingKind::Baffled => self.stray_lx + self.room_lx,
            ReadingKind::LampOff => self.room_lx,
            ReadingKind::Capped => 0.0,
        };
        let lamp = 1.0 + self.drift_per_h * time_s / 3600.0;
        let shown = light * lamp + self.offset_lx + self.noise_lx * normal(self.seed, index);
        let illuminance = (shown / self.digit_lx).round() * self.digit_lx;
        Reading {
            index,
            block: "b".to_owned(),
            kind,
            time_s: Some(time_s),
            c_deg: c,
            gamma_deg: gamma,
            distance_mm: 10_000.0,
            travel: 1,
            range: 1,
            ambient_c: Some(25.0),
            illuminance_lx: Some(illuminance),
            u_lx: Some(self.noise_lx.hypot(self.digit_lx / 12f64.sqrt())),
            quality: Quality::Ok,
            role,
            point: index,
            repeat: 0,
            c_target_deg: c,
            gamma_target_deg: gamma,
            digit_lx: Some(self.digit_lx),
            integration_s: Some(0.5),
            raw: String::new(),
        }
    }

    /// Dark blocks, then 25 half-planes by 2°, a visit to the reference after each.
    fn scan(&self) -> Vec<Reading> {
        let mut readings: Vec<Reading> = Vec::new();
        let mut take = |kind, role, c: f64, gamma: f64| {
            let index = readings.len() as u64;
            readings.push(self.reading(index, kind, role, c, gamma, index as f64 * 4.0));
        };
        for _ in 0..20 {
            take(ReadingKind::Capped, Role::Point, 0.0, 0.0);
            take(ReadingKind::LampOff, Role::Point, 0.0, 0.0);
        }
        for gamma in [0.0, 60.0, 120.0, 180.0] {
            (0..10).for_each(|_| take(ReadingKind::Baffled, Role::Point, 0.0, gamma));
        }
        for plane in 0..=24 {
            take(ReadingKind::Lit, Role::Reference, 0.0, 0.0);
            for step in 0..=90 {
                take(
                    ReadingKind::Lit,
                    Role::Point,
                    f64::from(plane) * 15.0,
                    f64::from(step) * 2.0,
                );
            }
        }
        take(ReadingKind::Lit, Role::Reference, 0.0, 0.0);
        readings
    }

    fn reduce(&self, switches: &Switches) -> Reduction {
        reduce(&Self::header(), &self.scan(), switches).unwrap()
    }
}

/// A standard normal number from (seed, index) alone.
fn normal(seed: u64, index: u64) -> f64 {
    let uniform = |k: u64| {
        let mut z = (seed << 40) ^ (index * 2 + k).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    };
    (-2.0 * (1.0 - uniform(0)).ln()).sqrt() * (std::f64::consts::TAU * uniform(1)).cos()
}

fn clean_flux() -> f64 {
    CLEAN.reduce(&Switches::default()).flux_lm().value
}

#[test]
fn a_clean_bench_gives_the_lamp_back() {
    let reduction = CLEAN.reduce(&Switches::default());
    // 2π·337/6.3, less what 2° of linear interpolation cut off
    assert!(
        (reduction.flux_lm().value / 336.1 - 1.0).abs() < 1e-3,
        "{}",
        reduction.flux_lm().value
    );
    assert!((reduction.i_max_cd().value - 337.0).abs() < 1e-6);
    assert_eq!(
        (
            reduction.distribution.c_deg().len(),
            reduction.distribution.gamma_deg().len()
        ),
        (24, 91)
    );
    assert!(reduction.closing.unwrap().largest_rel_of_peak.abs() < 1e-9);
    let files = luminaire_files(&reduction, None, &isolux_reduce::Description::default()).unwrap();
    assert_eq!(files.negative_points, 0);
}

#[test]
fn every_correction_takes_away_its_own_light_and_its_switch_leaves_it() {
    let bench = Bench {
        offset_lx: 0.02,
        room_lx: 0.01,
        stray_lx: 0.03,
        drift_per_h: -0.01,
        ..CLEAN
    };
    let clean = clean_flux();
    let flux = |off: &[Correction]| bench.reduce(&Switches::without(off.iter().copied())).flux_lm().value;
    // Room and stray light drift with the lamp here but were read early; what is left of that is 0.04 lx · drift.
    assert!((flux(&[]) / clean - 1.0).abs() < 3e-3, "{} {clean}", flux(&[]));
    // 1 lx all around at 10 m is 100 cd · 4π sr
    let lm_per_lx = 400.0 * std::f64::consts::PI;
    let left = |off: Correction| flux(&[off]) - flux(&[]);
    assert!((left(Correction::Dark) / (0.02 * lm_per_lx) - 1.0).abs() < 0.02);
    assert!((left(Correction::Ambient) / (0.01 * lm_per_lx) - 1.0).abs() < 0.02);
    assert!((left(Correction::Stray) / (0.03 * lm_per_lx) - 1.0).abs() < 0.02);
    assert!(left(Correction::Drift) / clean < -0.005);
}

#[test]
fn the_darks_digit_stands_in_the_flux_budget() {
    // The lamp gives 3.4 lx, one digit is 0.01 lx, the noise is below it: forty dark readings are rounded alike.
    let bench = Bench {
        offset_lx: 0.003,
        noise_lx: 0.0005,
        digit_lx: 0.01,
        ..CLEAN
    };
    let flux = bench.reduce(&Switches::default()).flux_lm();
    let digit_all_around = 0.01 / 12f64.sqrt() * 100.0 * 4.0 * std::f64::consts::PI;
    assert!((flux.part("dark") / digit_all_around - 1.0).abs() < 0.01, "{flux:?}");
    assert!(
        flux.part("dark") / flux.value > 0.01,
        "more than one per cent of 337 lm"
    );
    assert!(
        flux.part("digit") > 0.5 * flux.part("dark"),
        "the back of the lamp reads 0.00 everywhere"
    );
    assert!(flux.part("independent") < 0.1 * flux.part("dark"));
    // With noise above half a digit the rounding is dithered, and ten baffled readings reduce both.
    let dithered = Bench {
        noise_lx: 0.0051,
        ..bench
    }
    .reduce(&Switches::default())
    .flux_lm();
    let expected = 0.0051f64.hypot(0.01 / 12f64.sqrt()) / 10f64.sqrt() * 400.0 * std::f64::consts::PI;
    assert!((dithered.part("dark") / expected - 1.0).abs() < 0.01, "{dithered:?}");
    assert_eq!(dithered.part("digit"), 0.0);
    assert!((flux.u - flux.parts.iter().map(|p| p.u * p.u).sum::<f64>().sqrt()).abs() < 1e-12);
}

#[test]
fn calibration_and_distance_act_on_all_points_at_once() {
    let flux = CLEAN.reduce(&Switches::default()).flux_lm();
    assert!((flux.part("calibration") / flux.value - 0.004).abs() < 1e-9);
    assert!((flux.part("distance") / flux.value - 0.0004).abs() < 1e-9);
}

/// Over many benches the stated uncertainty must cover the error as often as it says: the offset is uniform over a digit, so
/// that the rounding of the dark is what the budget says it is.
#[test]
fn the_stated_uncertainty_covers_the_error() {
    let clean = clean_flux();
    let (mut inside, mut total) = (0, 0);
    let mut chi2 = 0.0;
    for seed in 1..=60u64 {
        let offset_lx = 0.01 * (seed as f64 * 0.618_033_988_749_895).fract();
        let bench = Bench {
            offset_lx,
            noise_lx: 0.0008,
            digit_lx: 0.01,
            seed,
            ..CLEAN
        };
        let flux = bench.reduce(&Switches::default()).flux_lm();
        // calibration and distance are exact here: compare with the rest
        let u = flux.u.powi(2) - flux.part("calibration").powi(2) - flux.part("distance").powi(2);
        let z2 = (flux.value - clean).powi(2) / u;
        chi2 += z2;
        inside += u32::from(z2 < 4.0);
        total += 1;
    }
    assert!(
        inside * 100 >= total * 95,
        "{inside} of {total} inside two standard uncertainties"
    );
    assert!(chi2 / f64::from(total) < 1.3, "mean square error {chi2} over {total}");
}

#[test]
fn a_point_without_a_number_is_named() {
    let mut readings = CLEAN.scan();
    for reading in &mut readings {
        if reading.c_target_deg == 45.0 && reading.gamma_target_deg == 30.0 {
            (reading.illuminance_lx, reading.u_lx, reading.quality) = (None, None, Quality::OverRange);
        }
    }
    let error = reduce(&Bench::header(), &readings, &Switches::default())
        .unwrap_err()
        .to_string();
    assert!(error.contains("C 45° γ 30°") && error.contains("over range"), "{error}");
    readings.truncate(40);
    let error = reduce(&Bench::header(), &readings, &Switches::default())
        .unwrap_err()
        .to_string();
    assert!(error.contains("no lit readings"), "{error}");
}

#[test]
fn signed_gamma_is_the_opposite_half_plane() {
    let mut readings = Vec::new();
    for (index, (c, gamma)) in [0.0, 90.0]
        .into_iter()
        .flat_map(|c| [-40.0, -20.0, 0.0, 20.0, 40.0].map(|g| (c, g)))
        .enumerate()
    {
        readings.push(CLEAN.reading(index as u64, ReadingKind::Lit, Role::Point, c, gamma, 0.0));
    }
    // γ = 0 of C180 and C270 is that of C0 and C90
    for (index, c) in [(10, 180.0), (11, 270.0)] {
        readings.push(CLEAN.reading(index, ReadingKind::Lit, Role::Point, c, 0.0, 0.0));
    }
    let reduction = reduce(&Bench::header(), &readings, &Switches::default()).unwrap();
    assert_eq!(reduction.distribution.c_deg(), [0.0, 90.0, 180.0, 270.0]);
    assert_eq!(reduction.distribution.gamma_deg(), [0.0, 20.0, 40.0]);
}
