//! Whether the truth lies within ± U: days of the program in rooms that differ, each from the lamp that is switched on
//! to the mean on a sensor, in virtual time.
//!
//!     cargo bench -p isolux-app --bench coverage -- [--days 200] [--first 1] [--published] [--cases]
//!
//! `--days` rooms from number `--first` on; `--published` with the plan at 10 m in place of the near one; `--cases` a
//! line for each value that lies beyond U. A day is a pure function of its number.
//!
//! Everything that the station's certificates state is drawn from what they state: gain of the lux meter (0.4 %) and of
//! the spectroradiometer (0.4 %), a tilt and a bow of its calibration over the wavelength (0.4 % each), its wavelengths
//! (0.1 nm), distance (2 mm), γ zero (0.03°), power (0.1 %). Lamp, colour over angle, warm-up, drift, zero of the
//! meter, stray light of room and floor and the room's temperature are drawn beside it; noise is the instruments' own.
//! The plan takes spectra over angle and the power of the supply. What the station has no key for is not drawn: light
//! that is scattered inside the spectroradiometer among it.
//!
//! The truth is that of the room's single LEDs: their light far away, the spectrum of their sum, and the room's camera
//! before the lamp for the mean on the sensor.
//!
//! | column | what |
//! |---|---|
//! | days | values with an uncertainty; of directions, all of all days |
//! | in U | share of the truths within ± U (k = 2), %, with Wilson's interval of 95 % |
//! | in u | the same within ± u (k = 1) |
//! | bias | mean of (value − truth) ÷ u |
//! | U | median of U, in % of the truth, or in the unit that is named |

#![expect(clippy::print_stdout, clippy::print_stderr, reason = "a program to run by hand")]

use std::error::Error;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use camino::{Utf8Path, Utf8PathBuf};
use isolux_app::files::Overwrite;
use isolux_app::front_end::control::Control;
use isolux_app::front_end::progress::Silent;
use isolux_app::init::{DayPlan, Instruments, run as init};
use isolux_app::instruments::bench::StationFiles;
use isolux_app::instruments::catalogue::Catalogue;
use isolux_app::instruments::session::{self, Session};
use isolux_app::scan::{Place, ScanJob, Target};
use isolux_darkroom::camera::Unit;
use isolux_darkroom::output::relative_output;
use isolux_darkroom::{Darkroom, Instrument, MapPose, Room, SensorFrame};
use isolux_model::Scene;
use isolux_photometry::IntensityDistribution;
use isolux_record::{Plan, Run, Subject};
use isolux_reduce::{Options, Quantity, Reduction, reduce};
use isolux_sim::simulation::{Method, simulate};
use isolux_spectrum::{Chromaticity, Spectrum, cct, quantities};
use isolux_virtual::station::{calibration, in_memory, station};
use isolux_virtual::twins::Choice;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;

type Outcome<T> = Result<T, Box<dyn Error + Send + Sync>>;

/// Relative shape of the spectroradiometer's calibration, as the virtual station states it.
const U_SHAPE_REL: f64 = 0.004;
/// Edge of the published sensor.
const SENSOR_MM: f64 = 24.576;
/// Bins of the room's camera along it: the mean is asked for, not its detail.
const BINS: usize = 16;

/// A value with its truth.
struct Compared {
    what: &'static str,
    /// In the unit of the value; none: U is stated in % of the truth.
    unit: Option<&'static str>,
    value: f64,
    u: f64,
    truth: f64,
}

struct Wanted {
    days: u64,
    first: u64,
    published: bool,
    cases: bool,
}

fn main() -> Outcome<()> {
    let wanted = wanted()?;
    let (next, found) = (AtomicU64::new(0), Mutex::new(Vec::new()));
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                loop {
                    let place = next.fetch_add(1, Ordering::Relaxed);
                    if place >= wanted.days {
                        break;
                    }
                    let number = wanted.first + place;
                    let of_day = day(number, wanted.published);
                    if let Ok(mut found) = found.lock() {
                        found.push((number, of_day));
                        eprint!("\r{} of {} days", found.len(), wanted.days);
                    }
                }
            });
        }
    });
    eprintln!();
    let mut found = found.into_inner().map_err(|_| "a thread ended early")?;
    found.sort_by_key(|(number, _)| *number);
    print_table(&wanted, &found);
    Ok(())
}

fn wanted() -> Outcome<Wanted> {
    let mut wanted = Wanted {
        days: 200,
        first: 1,
        published: false,
        cases: false,
    };
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut value = || words.next().ok_or_else(|| format!("{word} needs a value"));
        match word.as_str() {
            "--bench" => {}
            "--days" => wanted.days = value()?.parse()?,
            "--first" => wanted.first = value()?.parse()?,
            "--published" => wanted.published = true,
            "--cases" => wanted.cases = true,
            other => return Err(format!("{other} is no option").into()),
        }
    }
    Ok(wanted)
}

/// What a normal distribution of this standard deviation gives (Box and Muller 1958).
fn normal(draws: &mut ChaCha8Rng, u: f64) -> f64 {
    let radius = (-2.0 * (1.0 - draws.random_range(0.0..1.0f64)).ln()).sqrt();
    u * radius * draws.random_range(0.0..std::f64::consts::TAU).cos()
}

/// The room of a day.
fn room(draws: &mut ChaCha8Rng, number: u64) -> Outcome<Room> {
    let mut document = Darkroom::built_in()?;
    document.seed = number;
    let lamp = &mut document.lamp;
    lamp.exponent = draws.random_range(2.0..14.0);
    lamp.ellipticity_rel = draws.random_range(0.0..0.1);
    lamp.flux_lm = draws.random_range(250.0..800.0);
    lamp.power_w = draws.random_range(3.0..9.0);
    let coloured = draws.random_bool(2.0 / 3.0);
    let (rise, lean) = (draws.random_range(-0.15..0.6), draws.random_range(0.0..0.12));
    lamp.phosphor_rise_rel = if coloured { rise } else { 0.0 };
    lamp.phosphor_lean_rel = if coloured { lean } else { 0.0 };
    lamp.phosphor_lean_azimuth_deg = draws.random_range(0.0..360.0);
    document.room.temperature_c = draws.random_range(22.0..27.0);
    document.luxmeter.gain_error_rel = normal(draws, 0.004);
    document.spectroradiometer.gain_error_rel = normal(draws, 0.004);
    document.powermeter.gain_error_rel = normal(draws, 0.001);
    let effects = &mut document.injected_effects;
    effects.distance_offset.offset_mm = normal(draws, 2.0);
    effects.gamma_zero.offset_deg = normal(draws, 0.03);
    effects.spectro_shift.shift_nm = normal(draws, 0.1);
    effects.ambient_stray.illuminance_lx = draws.random_range(0.0..0.02);
    effects.dark_offset.offset_lx = draws.random_range(-0.02..0.02);
    effects.dark_offset.offset_rel = 0.0;
    effects.floor_reflection.albedo = draws.random_range(0.0..0.08);
    effects.lamp_warmup.amplitude_rel = draws.random_range(0.0..0.06);
    effects.lamp_warmup.time_constant_s = draws.random_range(200.0..600.0);
    effects.lamp_drift.rate_per_h = draws.random_range(-0.002..0.002);
    Ok(Room::new(document))
}

/// The calibration file with a tilt and a bow over the wavelength, as the certificate allows.
fn bent(text: &str, draws: &mut ChaCha8Rng) -> String {
    let (tilt, bow) = (normal(draws, U_SHAPE_REL), normal(draws, U_SHAPE_REL));
    let mut bent = String::new();
    for line in text.lines() {
        let fields = line.split_once(',').and_then(|(nm, factor)| {
            let (nm, factor): (f64, f64) = (nm.parse().ok()?, factor.parse().ok()?);
            Some((nm, factor))
        });
        match fields {
            Some((nm, factor)) => {
                let t = (nm - 550.0) / 300.0;
                let shape = (1.0 + tilt * t) * (1.0 + 0.5 * bow * (1.0 - 8.0 * t * t));
                bent.push_str(&format!("{nm},{:e}\n", factor * shape));
            }
            None => bent.push_str(&format!("{line}\n")),
        }
    }
    bent
}

/// The day of this number: what is stated beside what is true.
fn day(number: u64, published: bool) -> Outcome<Vec<Compared>> {
    let mut draws = ChaCha8Rng::seed_from_u64(number);
    let room = room(&mut draws, number)?;
    let keep = tempfile::tempdir()?;
    let folder = Utf8PathBuf::try_from(keep.path().to_owned())?;
    let instruments = Instruments {
        colour: true,
        powermeter: Some("yokogawa-wt300".to_owned()),
        ..Instruments::default()
    };
    let day_plan = if published { DayPlan::Published } else { DayPlan::Near };
    init(
        &folder.join("day"),
        day_plan,
        &instruments,
        &Subject::default(),
        Overwrite::Never,
    )?;
    let plan = Plan::load(&folder.join("day/plan.toml"))?;
    let mut choice = Choice::default();
    choice.choose(Instrument::Powermeter, "yokogawa-wt300")?;
    let outlets = in_memory(&choice);
    let certificate = calibration(&room, &outlets).map(|text| bent(&text, &mut draws));
    let source = StationFiles::from_text(&station(room.document(), &outlets), certificate.as_deref())?;
    let run = scanned(room.document().clone(), &choice, &source, &plan, &folder.join("run"))?;
    let reduction = reduce(&run, &Options::default(), None)?;
    let mut all = Vec::new();
    photometric(&mut all, &reduction, &room)?;
    spectral(&mut all, &reduction, &room)?;
    sensor(&mut all, &reduction, &run, &room, &folder)?;
    Ok(all)
}

/// The record of `plan` in this room, by the program.
fn scanned(room: Darkroom, choice: &Choice, source: &StationFiles, plan: &Plan, path: &Utf8Path) -> Outcome<Run> {
    session::run(true, async {
        let session = Session::in_room(room, choice)?;
        let catalogue = Catalogue::new(session.links.clone());
        let mut devices = source.open(&catalogue).await?;
        let job = ScanJob {
            source,
            plan,
            place: Place::take(Target::New(path), false)?,
            force: None,
            operator: None,
            control: &Control::default(),
            progress: &Silent,
        };
        job.execute_on(&mut devices, None, jiff::Timestamp::UNIX_EPOCH).await
    })?;
    Ok(Run::read(path)?)
}

/// Adds a value where it has an uncertainty and a truth.
fn add(
    all: &mut Vec<Compared>,
    what: &'static str,
    unit: Option<&'static str>,
    quantity: Option<&Quantity>,
    truth: Option<f64>,
) {
    let stated = quantity.and_then(|quantity| Some((quantity.value, quantity.u?)));
    if let (Some((value, u)), Some(truth)) = (stated, truth) {
        all.push(Compared {
            what,
            unit,
            value,
            u,
            truth,
        });
    }
}

/// When the distribution was read, in the middle, s since the lamp was switched on.
fn middle_s(reduction: &Reduction) -> f64 {
    let ages: Vec<f64> = reduction.grid.nodes.iter().filter_map(|node| node.lamp_s).collect();
    ages.iter().sum::<f64>() / ages.len().max(1) as f64
}

/// Flux, intensities, angles and power.
fn photometric(all: &mut Vec<Compared>, reduction: &Reduction, room: &Room) -> Outcome<()> {
    let document = room.document();
    let time_s = middle_s(reduction);
    let output = relative_output(&document.injected_effects, time_s, 0.5);
    let flux_lm = output * document.lamp.flux_lm;
    let c_deg: Vec<f64> = (0..24).map(|c| 15.0 * f64::from(c)).collect();
    let gamma_deg: Vec<f64> = (0..=720).map(|gamma| 0.25 * f64::from(gamma)).collect();
    let light = |c: &f64| {
        gamma_deg
            .iter()
            .map(|gamma| room.intensity_cd(*c, *gamma))
            .collect::<Vec<_>>()
    };
    let intensity_cd = c_deg.iter().flat_map(light).collect();
    let exact = IntensityDistribution::new(c_deg, gamma_deg.clone(), intensity_cd)?;
    let peak_cd = output * exact.peak().intensity_cd;
    add(all, "flux", None, Some(&reduction.flux), Some(flux_lm));
    add(all, "I max", None, Some(&reduction.i_max), Some(peak_cd));
    for angles in &reduction.angles {
        let plane = exact.plane_at(angles.c_deg);
        let truth = |share: f64| Some(exact.divergence(plane?, share)?.full_angle_deg());
        add(all, "beam angle", Some("°"), angles.beam.as_ref(), truth(0.5));
        add(all, "field angle", Some("°"), angles.field.as_ref(), truth(0.1));
    }
    let electrical = reduction.electrical.as_ref().ok_or("no power was read")?;
    let power_w =
        isolux_darkroom::electrical::Electrical::illuminated(document, document.lamp.voltage_v, time_s).power_w;
    add(all, "power", None, Some(&electrical.power), Some(power_w));
    add(
        all,
        "lm/W of the supply",
        None,
        Some(&electrical.luminous_efficacy),
        Some(flux_lm / power_w),
    );
    Ok(())
}

/// The spectrum of such light, per lux.
fn light(room: &Room, phosphor: f64) -> Outcome<Spectrum> {
    let nm: Vec<f64> = (340..=1000).map(f64::from).collect();
    let value = nm.iter().map(|nm| room.spectrum().per_lux(*nm, phosphor)).collect();
    Ok(Spectrum::new(nm, value)?)
}

/// Spectrum on the axis, colour of the whole light and of every direction.
fn spectral(all: &mut Vec<Compared>, reduction: &Reduction, room: &Room) -> Outcome<()> {
    let axis = reduction.spectral.as_ref().ok_or("no spectrum was taken")?;
    let exact = quantities(&light(room, room.phosphor(0.0, 0.0))?);
    let colour = &axis.colour;
    for (what, unit, quantity, truth) in [
        ("CCT", Some("K"), &colour.cct, exact.cct_k),
        ("Duv", Some(""), &colour.duv, exact.duv),
        ("x", Some(""), &colour.x, exact.x),
        ("y", Some(""), &colour.y, exact.y),
        ("Ra", Some(""), &colour.ra, exact.ra),
        ("Rf", Some(""), &colour.rf, exact.rf),
        ("Rg", Some(""), &colour.rg, exact.rg),
    ] {
        add(all, what, unit, quantity.as_ref(), truth);
    }
    add(all, "lm/W of the radiation", None, Some(&axis.ler), exact.ler_lm_per_w);

    let found = reduction.over_angle.as_ref().ok_or("no colour over angle")?;
    let directions: Vec<(f64, f64)> = (0..24)
        .flat_map(|c| (0..180).map(move |gamma| (15.0 * f64::from(c), f64::from(gamma) + 0.5)))
        .collect();
    let weighed = directions.iter().map(|&(c, gamma)| {
        let weight = room.intensity_cd(c, gamma) * gamma.to_radians().sin();
        (weight, room.phosphor(c, gamma))
    });
    let whole = quantities(&light(room, room.spectrum().mixed(weighed))?);
    let colour = &found.facts.total.colour;
    for (what, unit, quantity, truth) in [
        ("whole light, CCT", Some("K"), &colour.cct, whole.cct_k),
        ("whole light, Duv", Some(""), &colour.duv, whole.duv),
        ("whole light, x", Some(""), &colour.x, whole.x),
        ("whole light, y", Some(""), &colour.y, whole.y),
        ("whole light, Ra", Some(""), &colour.ra, whole.ra),
        ("whole light, Rf", Some(""), &colour.rf, whole.rf),
    ] {
        add(all, what, unit, quantity.as_ref(), truth);
    }
    let time_s = middle_s(reduction);
    let flux_lm = relative_output(&room.document().injected_effects, time_s, 0.5) * room.document().lamp.flux_lm;
    let watts = whole.ler_lm_per_w.map(|ler| flux_lm / ler);
    add(all, "radiant flux", None, Some(&found.facts.total.radiant_flux), watts);

    let at = |c: f64, gamma: f64| -> Outcome<Chromaticity> {
        Ok(light(room, room.phosphor(c, gamma))?.chromaticity().ok_or("no light")?)
    };
    let average = lm79(room, &at)?.uv_1976();
    let peak_cd = directions
        .iter()
        .map(|&(c, gamma)| room.intensity_cd(c, gamma))
        .fold(0.0, f64::max);
    let mut farthest: f64 = 0.0;
    for of in &found.facts.directions {
        let truth = at(of.c_deg, of.gamma_deg)?;
        let (u_prime, v_prime) = truth.uv_1976();
        let nearest = cct::nearest_planckian(truth).map(|nearest| nearest.cct_k);
        for (what, unit, value, u, truth) in [
            ("directions, u′", "", Some(of.u_prime), of.u_u_prime, Some(u_prime)),
            ("directions, v′", "", Some(of.v_prime), of.u_v_prime, Some(v_prime)),
            ("directions, CCT", "K", of.cct_k, of.u_cct_k, nearest),
        ] {
            if let (Some(value), Some(u), Some(truth)) = (value, u, truth) {
                let unit = Some(unit);
                all.push(Compared {
                    what,
                    unit,
                    value,
                    u,
                    truth,
                });
            }
        }
        if room.intensity_cd(of.c_deg, of.gamma_deg) >= 0.1 * peak_cd {
            farthest = farthest.max((u_prime - average.0).hypot(v_prime - average.1));
        }
    }
    let delta = &found.facts.delta_u_prime_v_prime;
    add(all, "Δu′v′", Some(""), Some(&delta.value), Some(farthest));
    Ok(())
}

/// The average of LM-79-08, 12, by four half-planes every 10°.
fn lm79(room: &Room, at: &dyn Fn(f64, f64) -> Outcome<Chromaticity>) -> Outcome<Chromaticity> {
    let (mut x, mut y, mut sum) = (0.0, 0.0, 0.0);
    for gamma in (0..=9).map(|k| 10.0 * f64::from(k)) {
        let edge = |deg: f64| deg.max(0.0).to_radians().cos();
        for c in [0.0, 90.0, 180.0, 270.0] {
            let weight = (edge(gamma - 5.0) - edge(gamma + 5.0)) * room.intensity_cd(c, gamma);
            let there = at(c, gamma)?;
            x += weight * there.x;
            y += weight * there.y;
            sum += weight;
        }
    }
    Ok(Chromaticity { x: x / sum, y: y / sum })
}

/// The mean on the published sensor: by the results, and by a simulation of the model that they hold.
fn sensor(all: &mut Vec<Compared>, reduction: &Reduction, run: &Run, room: &Room, folder: &Utf8Path) -> Outcome<()> {
    let frame = SensorFrame {
        size_mm: [SENSOR_MM; 2],
        bins: [BINS; 2],
    };
    let pose = MapPose {
        time_s: Some(middle_s(reduction)),
        ..MapPose::default()
    };
    let mean = |unit| {
        let map = room.sensor_map(&frame, &pose, unit);
        map.iter().sum::<f64>() / map.len() as f64
    };
    let (watts, lux) = (mean(Unit::WattPerSquareMetre), mean(Unit::Lux));
    add(
        all,
        "mean on the sensor, lx",
        None,
        Some(&reduction.sensor_illuminance),
        Some(lux),
    );
    add(
        all,
        "mean on the sensor, W/m²",
        None,
        reduction.sensor_irradiance.as_ref(),
        Some(watts),
    );
    for file in isolux_reduce::files(reduction, run, &[], "coverage")? {
        let path = folder.join(&file.name);
        if let Some(parent) = path.parent() {
            std::fs::create_dir_all(parent)?;
        }
        std::fs::write(path, &file.bytes)?;
    }
    let scene = format!(
        "format = \"isolux-scene/1\"\nmodel = \"luminaire.model.toml\"\n[sensor]\nsize_mm = {SENSOR_MM:?}\n\
         pixels = {BINS}\ndistance_mm = 500.0\n"
    );
    let scene = Scene::parse(&folder.join("scene.toml"), &scene)?;
    let simulated = simulate(&scene, Method::Inverse, &|| 0.0)?;
    if let Some(u) = simulated.facts.u_mean {
        all.push(Compared {
            what: "mean of `simulate`, W/m²",
            unit: None,
            value: simulated.facts.mean,
            u,
            truth: watts,
        });
    }
    Ok(())
}

/// Wilson's interval of 95 % for `hits` of `count`, in %.
fn wilson(hits: usize, count: usize) -> (f64, f64) {
    let (n, z) = (count as f64, 1.96_f64);
    let p = hits as f64 / n;
    let centre = (p + z * z / (2.0 * n)) / (1.0 + z * z / n);
    let half = z * (p * (1.0 - p) / n + z * z / (4.0 * n * n)).sqrt() / (1.0 + z * z / n);
    (100.0 * (centre - half), 100.0 * (centre + half))
}

fn print_table(wanted: &Wanted, found: &[(u64, Outcome<Vec<Compared>>)]) {
    let mut names: Vec<(&'static str, Option<&'static str>)> = Vec::new();
    for (number, of_day) in found {
        match of_day {
            Err(error) => println!("day {number}: {error}"),
            Ok(all) => {
                for compared in all {
                    if !names.contains(&(compared.what, compared.unit)) {
                        names.push((compared.what, compared.unit));
                    }
                    let z = (compared.value - compared.truth) / compared.u;
                    if wanted.cases && z.abs() > 2.0 && !compared.what.starts_with("directions") {
                        println!(
                            "day {number}: {} {:+.2} u, truth {:.6}",
                            compared.what, z, compared.truth
                        );
                    }
                }
            }
        }
    }
    println!("| what | days | in U/% | in u/% | bias/u | U |\n|---|---|---|---|---|---|");
    for (what, unit) in names {
        let of: Vec<&Compared> = found
            .iter()
            .filter_map(|(_, of_day)| of_day.as_ref().ok())
            .flatten()
            .filter(|compared| compared.what == what)
            .collect();
        let z: Vec<f64> = of.iter().map(|one| (one.value - one.truth) / one.u).collect();
        let within = |most: f64| z.iter().filter(|z| z.abs() <= most).count();
        let (low, high) = wilson(within(2.0), z.len());
        let mut expanded: Vec<f64> = of
            .iter()
            .map(|one| 2.0 * one.u * unit.map_or(100.0 / one.truth.abs(), |_| 1.0))
            .collect();
        expanded.sort_by(f64::total_cmp);
        let share = |count: usize| 100.0 * count as f64 / z.len() as f64;
        println!(
            "| {what} | {} | {:.1} ({low:.1} to {high:.1}) | {:.0} | {:+.2} | {:.2} {} |",
            z.len(),
            share(within(2.0)),
            share(within(1.0)),
            z.iter().sum::<f64>() / z.len() as f64,
            expanded[expanded.len() / 2] * if unit == Some("") { 1e4 } else { 1.0 },
            match unit {
                None => "%",
                Some("") => "· 10⁻⁴",
                Some(unit) => unit,
            },
        );
    }
}
