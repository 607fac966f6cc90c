//! `init --sweep`: twins that can be read while γ moves, and the plan of the day as sweeps.

use isolux_photometry::IntensityDistribution;
use isolux_record::plan::SPEED_DEG_S;
use isolux_scan::{most_by_own_clock_deg_s, most_deg_s};
use isolux_virtual::Instrument;
use isolux_virtual::twins::{Choice, InMotion, TWINS};

use crate::Failure;

/// Axes and a lux meter that sweep, where none are `named`: the one that is read most often.
///
/// # Errors
/// Bad input (exit 2) for a named one that cannot; names those that can.
pub fn choose(choice: &mut Choice, named: &[(Instrument, &Option<String>)]) -> Result<(), Failure> {
    for instrument in [Instrument::Axes, Instrument::Luxmeter] {
        let able = || {
            TWINS
                .iter()
                .filter(|twin| twin.instrument == instrument && twin.sweeps.is_some())
        };
        if let Some((_, Some(driver))) = named.iter().find(|(of, _)| *of == instrument) {
            if choice.twin(instrument).is_some_and(|twin| twin.sweeps.is_some()) {
                continue;
            }
            let known: Vec<&str> = able().map(|twin| twin.driver).collect();
            return Err(Failure::bad_input(format!(
                "driver {driver} cannot be read or moved in sweeps; for the {} it would be {}",
                instrument.name(),
                known.join(", ")
            )));
        }
        let every_ms = |sweeps: Option<InMotion>| match sweeps {
            Some(InMotion::OnRequest { integration_ms, .. }) => integration_ms,
            Some(InMotion::ByOwnClock { update_interval_ms }) => update_interval_ms,
            Some(InMotion::Moves) | None => 0,
        };
        if let Some(twin) = able().min_by_key(|twin| every_ms(twin.sweeps)) {
            choice.choose(instrument, twin.driver).map_err(Failure::bad_input)?;
        }
    }
    Ok(())
}

/// A beam narrower than this between the halves of its peak is proposed to be swept a second time, slowly, degrees.
const NARROW_DEG: f64 = 20.0;
/// Share of the largest light from which on light counts as beam: that is what is swept again.
const BEAM_LIGHT: f64 = 0.1;
/// γ up to which that light may reach: beyond it the second sweeps take as long as the first.
const BEAM_REACH_DEG: f64 = 45.0;
/// Share of the slower sweep in the speed of the others.
const BEAM_SPEED: f64 = 0.5;
/// Light below this share of the peak has few digits in a range of four that holds the peak.
const DIM: f64 = 0.01;
/// Share of such light in the flux from which on it is proposed to be swept again in a more sensitive range.
const DIM_FLUX: f64 = 0.01;
/// Digits below which light is dim.
const DIM_DIGITS: u32 = 20;

/// A plan as sweeps for the lux meter of `choice`: its first block with the same steps, two half-planes a sweep. Second
/// sweeps are proposed where `light`, that of the lamp's file, needs them; every other key of sweeps is there as a
/// comment.
///
/// # Errors
/// Bad input (exit 2) for a plan whose first block has no ranges.
pub fn plan(text: &str, choice: &Choice, light: Option<&IntensityDistribution>) -> Result<String, Failure> {
    let mut made = String::new();
    let mut block = 0;
    for line in text.lines() {
        block += usize::from(line == "[[block]]");
        let key = line.trim_start_matches("# ").split([' ', '=']).next().unwrap_or("");
        let set = |value: String, comment: &str| format!("{value:<31} # {comment}\n");
        made += &match key {
            "c_range" if block == 1 => {
                let step = step(line)?;
                set(
                    format!("c_range = [0, {}, {step}]", 180.0 - step),
                    "each sweep reads this half-plane and the one opposite",
                )
            }
            "gamma_range" if block == 1 => {
                let step = step(line)?;
                let speed_deg_s = sweep_deg_s(step, choice);
                set(
                    format!("gamma_range = [-180, 180, {step}]"),
                    "step: no coarser than the light bends",
                ) + &set(
                    "mode = \"sweep\"".to_owned(),
                    "read while γ moves; without this line at rest: the reference",
                ) + &set(format!("speed_deg_s = {speed_deg_s}"), "slower reads more often")
                    + &second(speed_deg_s, choice, light)
            }
            // They do not go with sweeps, each of which crosses γ = 0°: that shows the drift.
            "order" | "repeats" | "reference_every" if block == 1 => continue,
            "The" if line.starts_with("# The distribution:") => {
                "# The distribution, in motion. Ten directions that its sweeps draw are read at rest afterwards.\n"
                    .to_owned()
            }
            _ => format!("{line}\n"),
        };
    }
    Ok(made)
}

/// The keys of second sweeps and of a target, each as a comment where the light is not known to need it.
fn second(speed_deg_s: f64, choice: &Choice, light: Option<&IntensityDistribution>) -> String {
    let key = |needed: bool, value: String, comment: &str| {
        let value = if needed { value } else { format!("# {value}") };
        format!("{value:<31} # {comment}\n")
    };
    let beam_speed_deg_s = (10.0 * BEAM_SPEED * speed_deg_s).round() / 10.0;
    let by_own_clock = choice.twin(Instrument::Luxmeter).and_then(|twin| twin.sweeps);
    let four_digits = matches!(by_own_clock, Some(InMotion::ByOwnClock { .. }));
    key(
        light.is_some_and(is_narrow),
        format!("beam_speed_deg_s = {beam_speed_deg_s}"),
        "a second, slow sweep within the beam: for narrow ones",
    ) + &key(
        four_digits && light.is_some_and(has_dim_flux),
        format!("dim_digits = {DIM_DIGITS}"),
        "light below so many digits again, in a more sensitive range",
    ) + &key(
        false,
        "target = { u_map_rel = 0.02 }".to_owned(),
        "half-planes are chosen from c_range: C by 5° then",
    )
}

/// Whether the beam is narrow in some half-plane, and what is swept again then a small part of the way.
fn is_narrow(light: &IntensityDistribution) -> bool {
    let mut beams = (0..light.c_deg().len()).filter_map(|plane| light.beam_angle(plane));
    let least_cd = BEAM_LIGHT * light.peak().intensity_cd;
    let rows = (0..light.c_deg().len()).map(|plane| light.row(plane));
    let mut strong = rows
        .flat_map(|row| light.gamma_deg().iter().zip(row))
        .filter(|(_, cd)| **cd >= least_cd);
    beams.any(|beam| beam.full_angle_deg() < NARROW_DEG) && strong.all(|(gamma_deg, _)| *gamma_deg <= BEAM_REACH_DEG)
}

/// Whether dim light has a share in the flux that a range of four digits would lose.
fn has_dim_flux(light: &IntensityDistribution) -> bool {
    let dim_cd = DIM * light.peak().intensity_cd;
    let weights = light.flux_weights_sr();
    let of_flux = weights.iter().zip(light.intensity_cd());
    let dim_lm: f64 = of_flux
        .filter(|(_, cd)| **cd < dim_cd)
        .map(|(weight, cd)| weight * cd)
        .sum();
    dim_lm > DIM_FLUX * light.flux_lm()
}

/// The speed of γ that is proposed for steps of so many degrees with the lux meter of `choice`, °/s.
pub fn sweep_deg_s(step_deg: f64, choice: &Choice) -> f64 {
    let most = match choice.twin(Instrument::Luxmeter).and_then(|twin| twin.sweeps) {
        Some(InMotion::OnRequest { integration_ms, .. }) => most_deg_s(step_deg, 1e-3 * f64::from(integration_ms)),
        Some(InMotion::ByOwnClock { update_interval_ms }) => {
            most_by_own_clock_deg_s(step_deg, 1e-3 * f64::from(update_interval_ms))
        }
        Some(InMotion::Moves) | None => SPEED_DEG_S,
    };
    SPEED_DEG_S.min((10.0 * most).floor() / 10.0)
}

/// The step of `key = [from, to, step]`, degrees.
fn step(line: &str) -> Result<f64, Failure> {
    let inside = line.split(['[', ']']).nth(1).unwrap_or("");
    let last = inside.split(',').next_back().unwrap_or("");
    let step = last.trim().parse();
    step.map_err(|_| Failure::bad_input(format!("`{line}` is no [from, to, step]")))
}

#[cfg(test)]
mod tests {
    use camino::Utf8Path;
    use isolux_record::Plan;

    use super::*;
    use crate::init::DayPlan;

    /// Twins where none is named.
    fn fast() -> Choice {
        let mut choice = Choice::default();
        choose(&mut choice, &[]).unwrap();
        choice
    }

    #[test]
    fn the_plan_of_the_day_as_sweeps_reads_the_same_directions() {
        let text = plan(&DayPlan::Near.text(), &fast(), None).unwrap();
        let swept = Plan::parse(Utf8Path::new("plan.toml"), &text).unwrap();
        let day = DayPlan::Near.plan().unwrap();
        assert_eq!(swept.blocks()[1..], day.blocks()[1..]);
        let [swept, day] = [&swept.blocks()[0], &day.blocks()[0]];
        assert_eq!((swept.sweep_deg_s, swept.distance_mm), (Some(12.0), day.distance_mm));
        let mut whole: Vec<(f64, f64)> = Vec::new();
        for c_deg in &swept.c_deg {
            for gamma_deg in &swept.gamma_deg {
                let c_deg = if *gamma_deg < 0.0 { c_deg + 180.0 } else { *c_deg };
                whole.push((c_deg, gamma_deg.abs()));
            }
        }
        let wanted = day.c_deg.iter().filter(|c_deg| **c_deg < 360.0);
        let mut wanted = wanted.flat_map(|c_deg| day.gamma_deg.iter().map(move |gamma_deg| (*c_deg, *gamma_deg)));
        // At the poles all half-planes are one.
        assert!(wanted.all(|at| at.1 == 0.0 || whole.contains(&at)));
    }

    #[test]
    fn fine_steps_are_swept_slowly() {
        let fine = plan(
            &DayPlan::Near.text().replace("[0, 180, 2]", "[0, 180, 0.5]"),
            &fast(),
            None,
        )
        .unwrap();
        assert!(
            fine.contains("speed_deg_s = 3.8") && fine.contains("[-180, 180, 0.5]"),
            "{fine}"
        );
        let listed = plan(
            &DayPlan::Near
                .text()
                .replace("gamma_range = [0, 180, 2]", "gamma_range = 0.5"),
            &fast(),
            None,
        );
        assert!(listed.unwrap_err().message.contains("gamma_range = 0.5"));
    }

    #[test]
    fn a_meter_with_a_clock_of_its_own_is_taken_where_it_is_named() {
        assert_eq!(fast().twin(Instrument::Luxmeter).unwrap().driver, "gigahertz-p9710");
        let mut choice = Choice::default();
        choice.choose(Instrument::Luxmeter, "konica-t10a").unwrap();
        choose(&mut choice, &[(Instrument::Luxmeter, &Some("konica-t10a".to_owned()))]).unwrap();
        assert_eq!(choice.twin(Instrument::Luxmeter).unwrap().driver, "konica-t10a");
        let text = plan(&DayPlan::Near.text(), &choice, None).unwrap();
        assert!(text.contains("speed_deg_s = 6 "), "{text}");
    }

    #[test]
    fn second_sweeps_are_proposed_where_the_light_of_the_file_needs_them() {
        // By half its angle; the dim light has a fiftieth of the flux of the narrow beam, or nothing of it.
        let lamp = |half_deg: f64, dim: f64| {
            let gamma_deg: Vec<f64> = (0..=180).map(f64::from).collect();
            let of = |gamma: &f64| 0.5f64.powf((gamma / half_deg).powi(2)) + dim * gamma.to_radians().cos().max(0.0);
            let intensity_cd = gamma_deg.iter().map(of).collect();
            IntensityDistribution::new(vec![0.0], gamma_deg, intensity_cd).unwrap()
        };
        let mut slow = Choice::default();
        slow.choose(Instrument::Luxmeter, "konica-t10a").unwrap();
        choose(&mut slow, &[(Instrument::Luxmeter, &Some("konica-t10a".to_owned()))]).unwrap();
        for (choice, half_deg, dim, beam, dims) in [
            (&fast(), 7.5, 0.002, true, false),
            (&slow, 7.5, 0.002, true, true),
            (&slow, 7.5, 0.0, true, false),
            (&slow, 30.0, 0.002, false, false),
            // A narrow beam on top of light that reaches far.
            (&fast(), 7.5, 0.3, false, false),
        ] {
            let text = plan(&DayPlan::Near.text(), choice, Some(&lamp(half_deg, dim))).unwrap();
            let swept = Plan::parse(Utf8Path::new("plan.toml"), &text).unwrap();
            let block = &swept.blocks()[0];
            let found = (block.beam_speed_deg_s.is_some(), block.dim_digits.is_some());
            assert_eq!(found, (beam, dims), "{half_deg}° {dim}: {text}");
            // What is not needed is there to be tried: it parses without its comment sign.
            for key in ["beam_speed_deg_s", "dim_digits"] {
                let tried = text.replace(&format!("# {key}"), key);
                assert!(Plan::parse(Utf8Path::new("plan.toml"), &tried).is_ok(), "{tried}");
            }
            assert!(text.contains("# target = { u_map_rel = 0.02 }"), "{text}");
        }
    }
}
