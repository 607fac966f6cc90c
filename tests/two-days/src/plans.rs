//! The plans of both days.

use camino::Utf8Path;
use isolux_app::Failure;
use isolux_app::init::DayPlan;
use isolux_record::Plan;

/// Where the second scan reads, against the 15° × 2° of the first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Grid {
    /// On directions of the first: every 45° × 4°, and C 0° and 90° once more with signed γ, backwards.
    Equal,
    /// Fewer of them: every 45° × 8°, forwards alone.
    Coarse,
    /// Between them: from C 7.5° every 45°, γ every 5°, there and back.
    Shifted,
}

impl Grid {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Equal, Self::Coarse, Self::Shifted];

    /// Its name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Equal => "equal",
            Self::Coarse => "coarse",
            Self::Shifted => "shifted",
        }
    }

    /// The plan of the second day: eight half-planes, γ 0–80° at 3.7 m, reference visits, stray light, dark; with a
    /// closing half-plane where they begin at C 0°.
    ///
    /// # Errors
    /// Never for these plans.
    pub fn plan(self) -> Result<Plan, Failure> {
        let illuminated = match self {
            Self::Equal => {
                "c_range = [0, 360, 45]\ngamma_range = [0, 80, 4]\nreference_every = 42\ndistance_mm = 3700.0\n\
                 [[block]]\nname = \"signed\"\nkind = \"lit\"\nc_deg = [0, 90]\ngamma_range = [-80, 80, 8]\n\
                 order = \"reverse\"\n"
            }
            Self::Coarse => "c_range = [0, 360, 45]\ngamma_range = [0, 80, 8]\nreference_every = 33\n",
            Self::Shifted => {
                "c_range = [7.5, 322.5, 45]\ngamma_range = [0, 80, 5]\norder = \"both\"\nreference_every = 34\n"
            }
        };
        let text = format!(
            "{HEAD}[[block]]\nname = \"distribution\"\nkind = \"lit\"\n{illuminated}distance_mm = 3700.0\n{TAIL}"
        );
        Plan::parse(Utf8Path::new("second day"), &text).map_err(Failure::bad_input)
    }
}

/// The plan of a second day that reads a few directions and the spectrum on the axis.
///
/// # Errors
/// Never for this plan.
pub fn with_spectrum() -> Result<Plan, Failure> {
    const BLOCKS: &str = "[[block]]\nname = \"distribution\"\nkind = \"lit\"\nc_range = [0, 270, 90]\n\
                          gamma_range = [0, 180, 20]\nreference_every = 20\ndistance_mm = 3700.0\n\
                          [[block]]\nname = \"spectrum\"\nkind = \"lit\"\ninstrument = \"spectroradiometer\"\n\
                          c_deg = 0\ngamma_deg = 0\nrepeats = 10\n";
    let text = format!("{HEAD}{BLOCKS}{TAIL}");
    Plan::parse(Utf8Path::new("second day"), &text).map_err(Failure::bad_input)
}

/// The limits are wide: what a reading disagrees with is for the diagnosis to say, not for the scan to refuse.
const HEAD: &str = "format = \"isolux-plan/1\"\nname = \"second day\"\n\
                    [limits]\nreference_rel = 0.5\ndrift_rel = 0.5\nclosing_rel = 0.5\n";

const TAIL: &str = "[[block]]\nname = \"baffled\"\nkind = \"baffled\"\ndistance_mm = 3700.0\nc_deg = 0\n\
                    gamma_range = [0, 80, 20]\nrepeats = 3\n\
                    [[block]]\nname = \"capped\"\nkind = \"capped\"\ndistance_mm = 3700.0\nc_deg = 0\ngamma_deg = 0\nrepeats = 10\n\
                    [[block]]\nname = \"lamp off\"\nkind = \"lamp_off\"\ndistance_mm = 3700.0\nc_deg = 0\ngamma_deg = 0\nrepeats = 10\n";

/// The plan of the first day: that of `isolux run`.
///
/// # Errors
/// Never for the plan as it is shipped.
pub fn first_day() -> Result<Plan, Failure> {
    DayPlan::default().plan()
}
