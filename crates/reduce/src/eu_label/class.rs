//! Energy efficiency classes (Regulation (EU) 2019/2015, Annex II).

use crate::Quantity;

/// An energy efficiency class.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Class {
    /// η_TM of at least 210 lm/W.
    A,
    /// At least 185 lm/W.
    B,
    /// At least 160 lm/W.
    C,
    /// At least 135 lm/W.
    D,
    /// At least 110 lm/W.
    E,
    /// At least 85 lm/W.
    F,
    /// Less.
    G,
}

/// Classes with the least η_TM of each in lm/W (Annex II, Table 1).
const CLASSES: [(Class, f64); 7] = [
    (Class::A, 210.0),
    (Class::B, 185.0),
    (Class::C, 160.0),
    (Class::D, 135.0),
    (Class::E, 110.0),
    (Class::F, 85.0),
    (Class::G, f64::NEG_INFINITY),
];

/// Classes less probable than this are not named.
const LEAST_PROBABILITY: f64 = 1e-3;

impl Class {
    /// The class of a total mains efficacy in lm/W.
    pub fn of(efficacy_lm_per_w: f64) -> Self {
        let reached = CLASSES.iter().find(|(_, least)| efficacy_lm_per_w >= *least);
        reached.map_or(Self::G, |(class, _)| *class)
    }

    /// Its letter.
    pub const fn letter(self) -> &'static str {
        match self {
            Self::A => "A",
            Self::B => "B",
            Self::C => "C",
            Self::D => "D",
            Self::E => "E",
            Self::F => "F",
            Self::G => "G",
        }
    }
}

/// F_TM (Annex II, Table 2).
pub const fn f_tm(directional: bool, mains: bool) -> f64 {
    match (directional, mains) {
        (false, true) => 1.000,
        (false, false) => 0.926,
        (true, true) => 1.176,
        (true, false) => 1.089,
    }
}

/// Probability of the classes by the normal distribution of an efficacy in lm/W; none where its uncertainty is not
/// known.
pub(super) fn probabilities(efficacy: &Quantity) -> Vec<(Class, f64)> {
    let Some(u) = efficacy.u.filter(|u| *u > 0.0) else {
        return Vec::new();
    };
    let mut below = f64::INFINITY;
    let classes = CLASSES.iter().map(|&(class, least)| {
        let share = normal((below - efficacy.value) / u) - normal((least - efficacy.value) / u);
        below = least;
        (class, share)
    });
    classes.filter(|(_, share)| *share >= LEAST_PROBABILITY).collect()
}

/// The standard normal distribution function.
fn normal(x: f64) -> f64 {
    0.5 * libm::erfc(-x / std::f64::consts::SQRT_2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_class_begins_at_its_limit() {
        for (lm_per_w, letter) in [
            (210.0, "A"),
            (209.99, "B"),
            (185.0, "B"),
            (160.0, "C"),
            (159.9, "D"),
            (135.0, "D"),
            (110.0, "E"),
            (109.9, "F"),
            (85.0, "F"),
            (84.9, "G"),
            (0.0, "G"),
        ] {
            assert_eq!(Class::of(lm_per_w).letter(), letter, "{lm_per_w}");
        }
    }

    #[test]
    fn the_probability_of_another_class_is_that_of_the_normal_distribution() {
        let at = |value: f64, u: f64| probabilities(&Quantity::new(value, "lm/W", [("all", u)]));
        // One u above the limit of D: 15.87 % of E.
        let found = at(137.0, 2.0);
        assert_eq!(found.iter().map(|(class, _)| class.letter()).collect::<String>(), "DE");
        assert!(
            (found[0].1 - 0.841_345).abs() < 1e-6 && (found[1].1 - 0.158_655).abs() < 1e-6,
            "{found:?}"
        );
        // In the middle of a class far from both limits there is one.
        assert_eq!(at(147.5, 1.0).len(), 1);
        let wide: f64 = at(147.5, 40.0).iter().map(|(_, share)| share).sum();
        assert!((wide - 1.0).abs() < 1e-6, "{wide}");
        let lacking = Quantity::new(137.0, "lm/W", [("all", 2.0)]).lacking(["no bound".to_owned()]);
        assert!(probabilities(&lacking).is_empty());
    }
}
