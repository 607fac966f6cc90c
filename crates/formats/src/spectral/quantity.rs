//! What a heading says of the values below it.

/// Whether a heading names light itself, not a ratio or a detector's signal.
pub(super) fn is_radiometric(name: &str) -> bool {
    let quantity = quantity_of(name).0;
    ["irradiance", "radiance", "flux", "power"]
        .iter()
        .any(|known| quantity.as_deref() == Some(known))
}

/// What a heading says of the values: quantity and unit.
pub(super) fn quantity_of(name: &str) -> (Option<String>, Option<String>) {
    let unit = name
        .split_once(['(', '['])
        .and_then(|(_, rest)| rest.rsplit_once([')', ']']))
        .map(|(unit, _)| unit.trim())
        .filter(|unit| !unit.is_empty())
        .map(str::to_owned);
    let lower = name.to_lowercase();
    let quantity = [
        ("irradiance", "irradiance"),
        ("radiance", "radiance"),
        ("radiant flux", "flux"),
        ("flux", "flux"),
        ("relative", "relative"),
        ("normali", "relative"),
        ("intensity", "intensity"),
        ("reflect", "reflectance"),
        ("transmi", "transmittance"),
        ("absor", "absorbance"),
        ("respons", "responsivity"),
        ("counts", "counts"),
        ("power", "power"),
        ("qe", "quantum efficiency"),
        ("quantum eff", "quantum efficiency"),
    ]
    .iter()
    .find(|(word, _)| lower.contains(word))
    .map(|(_, quantity)| (*quantity).to_owned());
    (quantity, unit)
}
