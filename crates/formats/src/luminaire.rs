//! The description of a luminaire that photometric formats share.

/// What formats say of a luminaire beside its light. Empty text and `None` are "not stated".
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Luminaire {
    /// Who makes it.
    pub manufacturer: String,
    /// Its name.
    pub name: String,
    /// Its catalogue number.
    pub number: String,
    /// Number of the measurement report.
    pub report: String,
    /// Date and user, as written.
    pub date: String,
    /// Who measured.
    pub laboratory: String,
    /// Length, along C90–C270, or diameter in mm.
    pub length_mm: Option<f64>,
    /// Width, along C0–C180, in mm; 0 for a round luminaire.
    pub width_mm: Option<f64>,
    /// Height in mm.
    pub height_mm: Option<f64>,
    /// Length of the luminous area, along C90–C270, or its diameter, in mm.
    pub luminous_length_mm: Option<f64>,
    /// Width of the luminous area, along C0–C180, in mm; 0 for a round one.
    pub luminous_width_mm: Option<f64>,
    /// What the sizes of EULUMDAT cannot say of the luminous opening, where the file does: extents along C0, C90 and γ
    /// = 0 in mm, two of them negative where it is round in their plane (LM-63-2002). Set with
    /// [`set_luminous_body`](Self::set_luminous_body).
    pub luminous_body_mm: Option<[f64; 3]>,
    /// Height of the luminous sides in mm seen from C0, C90, C180, C270.
    pub luminous_height_mm: [Option<f64>; 4],
    /// The lamp.
    pub lamp: String,
    /// Number of lamps, without sign.
    pub lamp_count: Option<f64>,
    /// Colour appearance or CCT, as written.
    pub colour: String,
    /// Colour rendering, as written.
    pub rendering: String,
    /// Electrical power in W, gear included.
    pub watts: Option<f64>,
    /// Tilt during measurement in degrees.
    pub tilt_deg: Option<f64>,
}

impl Luminaire {
    /// States the luminous opening by its body, and by the sizes of EULUMDAT as far as it has an area along γ = 0.
    pub fn set_luminous_body(&mut self, body_mm: [f64; 3]) {
        self.luminous_body_mm = Some(body_mm);
        let [x, y, z] = body_mm;
        let point = body_mm == [0.0; 3];
        let sizes = match (x * y != 0.0 || point, x == y && x < 0.0) {
            (false, _) => None,
            (true, true) => Some((-x, 0.0)),
            (true, false) => Some((y.abs(), x.abs())),
        };
        (self.luminous_length_mm, self.luminous_width_mm) = sizes.unzip();
        self.luminous_height_mm = [sizes.map(|_| z.abs()); 4];
    }

    /// The luminous area seen along γ = 0, in mm²; none where the file does not state it, and for a line.
    pub fn luminous_area_mm2(&self) -> Option<f64> {
        let area = match (self.luminous_body_mm, self.luminous_length_mm?, self.luminous_width_mm?) {
            (Some([x, y, _]), ..) => face(x, y),
            (None, diameter, 0.0) => face(-diameter, -diameter),
            (None, length, width) => length * width,
        };
        (area > 0.0).then_some(area)
    }
}

/// Area of a face with these two signed extents: an ellipse where both are negative.
pub(crate) fn face(a: f64, b: f64) -> f64 {
    let outline = if a < 0.0 && b < 0.0 {
        std::f64::consts::FRAC_PI_4
    } else {
        1.0
    };
    outline * (a * b).abs()
}
