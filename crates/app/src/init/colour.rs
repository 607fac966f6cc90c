//! `init --colour`: a block of spectra over angle.

/// The block: C0 and C90 by 10° (IES LM-79-08, 12).
const BLOCK: &str = "\
# The colour of every direction: the planes C 0° and C 90° by 10°. Each direction is exposed as long as its light
# allows, and has its dark behind it; `isolux reduce` leaves out what is too dark.
[[block]]
name = \"colour\"
kind = \"lit\"
instrument = \"spectroradiometer\"
c_deg = [0, 90]                 # signed γ: four half-planes
gamma_range = [-90, 90, 10]
repeats = 4                     # spectra averaged, light and dark

";

/// What stands behind the spectrum on the axis in the plan of the day.
const BEHIND: &str = "# Detector capped";

/// The plan of the day with that block, while the spectroradiometer is there and the lamp is warm.
pub fn plan(text: &str) -> String {
    match text.find(BEHIND) {
        Some(at) => format!("{}{BLOCK}{}", &text[..at], &text[at..]),
        None => format!("{text}\n{}", BLOCK.trim_end()),
    }
}

#[cfg(test)]
mod tests {
    use camino::Utf8Path;
    use isolux_record::Plan;
    use isolux_record::plan::Instrument;

    use super::*;
    use crate::init::DayPlan;

    #[test]
    fn the_block_stands_between_the_spectrum_on_the_axis_and_the_dark() {
        let plan = Plan::parse(Utf8Path::new("p.toml"), &plan(&DayPlan::Near.text())).unwrap();
        let names: Vec<&str> = plan.blocks().iter().map(|block| block.name.as_str()).collect();
        assert_eq!(
            names,
            ["distribution", "baffled", "spectrum", "colour", "capped", "lamp off"]
        );
        let colour = &plan.blocks()[3];
        assert_eq!(colour.instrument, Instrument::Spectroradiometer);
        assert_eq!((colour.c_deg.len(), colour.gamma_deg.len()), (2, 19));
    }
}
