//! `init --sweep`: twins that can be read while γ moves, and the plan of the day as sweeps.

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

/// A plan as sweeps for the lux meter of `choice`: its first block with the same steps, two half-planes a sweep.
///
/// # Errors
/// Bad input (exit 2) for a plan whose first block has no ranges.
pub fn plan(text: &str, choice: &Choice) -> Result<String, Failure> {
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
                set(
                    format!("gamma_range = [-180, 180, {step}]"),
                    "step: no coarser than the light bends",
                ) + &set(
                    "mode = \"sweep\"".to_owned(),
                    "read while γ moves; without this line at rest: the reference",
                ) + &set(
                    format!("speed_deg_s = {}", sweep_deg_s(step, choice)),
                    "slower reads more often",
                )
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
        let text = plan(&DayPlan::Near.text(), &fast()).unwrap();
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
        let fine = plan(&DayPlan::Near.text().replace("[0, 180, 2]", "[0, 180, 0.5]"), &fast()).unwrap();
        assert!(
            fine.contains("speed_deg_s = 3.8") && fine.contains("[-180, 180, 0.5]"),
            "{fine}"
        );
        let listed = plan(
            &DayPlan::Near
                .text()
                .replace("gamma_range = [0, 180, 2]", "gamma_range = 0.5"),
            &fast(),
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
        let text = plan(&DayPlan::Near.text(), &choice).unwrap();
        assert!(text.contains("speed_deg_s = 6 "), "{text}");
    }
}
