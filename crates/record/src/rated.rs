//! What a luminaire is rated by: the tables `[ratings]` and `[eu_label]` of a job, kept in run.toml.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::document::Fault;
use crate::key::Key;

/// Facts that ratings of the measured light need. What is not stated is not rated.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Ratings {
    /// Half-plane C in degrees of the street side of an outdoor luminaire (IES TM-15-11).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub street_side_c_deg: Option<f64>,
    /// Rated correlated colour temperature in K: the colour is compared with that of a radiator of this temperature.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rated_cct_k: Option<f64>,
    /// Rated chromaticity x, y, in its place.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rated_xy: Option<[f64; 2]>,
}

/// The light source for an EU energy label (Regulation (EU) 2019/2015): what a measurement of its light cannot say.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct EuLabel {
    /// Whether it is operated directly on the mains (MLS) or needs a separate control gear (NMLS).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mains: Option<bool>,
    /// Texts as the supplier states them, by the names of [`EU_LABEL_KEYS`].
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub stated: BTreeMap<String, String>,
}

/// Keys of `[eu_label.stated]`, in the order of Table 3 of Annex V of Regulation (EU) 2019/2015.
pub const EU_LABEL_KEYS: [Key; 20] = [
    key("supplier_address", "supplier's address"),
    key("lighting_technology", "lighting technology used"),
    key("cap_type", "light source cap-type or other electric interface"),
    key("connected", "connected light source"),
    key("colour_tuneable", "colour-tuneable light source"),
    key("envelope", "envelope"),
    key("high_luminance", "high luminance light source"),
    key("anti_glare_shield", "anti-glare shield"),
    key("dimmable", "dimmable"),
    key("standby_power_w", "standby power in W"),
    key("networked_standby_power_w", "networked standby power in W"),
    key("height_mm", "height in mm"),
    key("width_mm", "width in mm"),
    key("depth_mm", "depth in mm"),
    key("equivalent_power_w", "claim of equivalent power in W"),
    key("survival_factor", "survival factor"),
    key("lumen_maintenance_factor", "lumen maintenance factor"),
    key("lifetime_h", "L70B50 lifetime in h"),
    key("flicker_pst_lm", "flicker metric Pst LM"),
    key("stroboscopic_svm", "stroboscopic effect metric SVM"),
];

const fn key(name: &'static str, what: &'static str) -> Key {
    Key {
        name,
        what,
        longest: 200,
    }
}

impl Ratings {
    /// Whether nothing is stated.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Refuses what is no angle, temperature or chromaticity, and two colours for one light.
    ///
    /// # Errors
    /// [`Fault`] with the path of the key.
    pub fn check(&self) -> Result<(), Fault> {
        let fault = |key: &str, message: &str| Err(Fault::new(format!("ratings.{key}"), message));
        if self.street_side_c_deg.is_some_and(|c| !(0.0..360.0).contains(&c)) {
            return fault("street_side_c_deg", "is no half-plane: 0 to below 360 is, in degrees");
        }
        if self.rated_cct_k.is_some_and(|k| !(1000.0..=25_000.0).contains(&k)) {
            return fault(
                "rated_cct_k",
                "is no temperature of white light: 1000 to 25000 is, in K",
            );
        }
        let is_chromaticity = |[x, y]: [f64; 2]| x > 0.0 && y > 0.0 && x + y < 1.0;
        if self.rated_xy.is_some_and(|xy| !is_chromaticity(xy)) {
            return fault(
                "rated_xy",
                "is no chromaticity: x and y are above 0, and their sum is below 1",
            );
        }
        if self.rated_cct_k.is_some() && self.rated_xy.is_some() {
            return fault(
                "rated_xy",
                "stands beside rated_cct_k: state one of them, the colour that is declared",
            );
        }
        Ok(())
    }
}

impl EuLabel {
    /// Whether nothing is stated: no label is made.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// The text of one of [`EU_LABEL_KEYS`].
    pub fn text(&self, name: &str) -> Option<&str> {
        self.stated.get(name).map(String::as_str)
    }

    /// Refuses names that are none of [`EU_LABEL_KEYS`], and texts that are empty or longer than a field.
    ///
    /// # Errors
    /// [`Fault`] with the path of the key.
    pub fn check(&self) -> Result<(), Fault> {
        for (name, text) in &self.stated {
            let path = format!("eu_label.stated.{name}");
            let Some(key) = EU_LABEL_KEYS.iter().find(|key| key.name == name) else {
                let known = EU_LABEL_KEYS.map(|key| key.name).join(", ");
                return Err(Fault::new(path, format!("is not known; the keys are {known}")));
            };
            key.check(text).map_err(|message| Fault::new(path, message))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_is_refused_with_its_key() {
        let ratings = |text: &str| toml::from_str::<Ratings>(text).unwrap().check();
        assert!(ratings("street_side_c_deg = 90\nrated_cct_k = 3000").is_ok());
        assert!(ratings("rated_xy = [0.44, 0.4]").is_ok() && ratings("").is_ok());
        for (text, key) in [
            ("street_side_c_deg = 360", "ratings.street_side_c_deg"),
            ("street_side_c_deg = -90", "ratings.street_side_c_deg"),
            ("rated_cct_k = 30", "ratings.rated_cct_k"),
            ("rated_xy = [0.6, 0.5]", "ratings.rated_xy"),
            ("rated_xy = [0.0, 0.5]", "ratings.rated_xy"),
            ("rated_xy = [0.44, 0.4]\nrated_cct_k = 3000", "ratings.rated_xy"),
        ] {
            assert_eq!(ratings(text).unwrap_err().path, key, "{text}");
        }
        let label = |text: &str| toml::from_str::<EuLabel>(text).unwrap().check();
        assert!(label("mains = true\n[stated]\ncap_type = \"E27\"").is_ok());
        let unknown = label("[stated]\ncap = \"E27\"").unwrap_err();
        assert_eq!(unknown.path, "eu_label.stated.cap");
        assert!(unknown.message.contains("cap_type"), "{}", unknown.message);
        assert_eq!(
            label("[stated]\ndimmable = \" \"").unwrap_err().path,
            "eu_label.stated.dimmable"
        );
        assert!(toml::from_str::<EuLabel>("main = true").is_err());
    }
}
