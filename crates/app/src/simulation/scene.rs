//! A scene from whatever the operator points at: a scene or model file, a run, a photometric file; with changes from
//! the command line.

use camino::{Utf8Path, Utf8PathBuf};
use isolux_formats::ReadOptions;
use isolux_model::{Accuracy, Emitter, Luminaire, Model, Scene, Spectral};
use isolux_photometry::IntensityDistribution;
use isolux_record::document::read_text;
use isolux_spectrum::Spectrum;
use toml::Table;
pub use toml::Value;

use crate::{Failure, files};

/// Changes to the scene that a front end asks for.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Changes {
    /// Spectrum file in place of the model's spectrum or efficacy.
    pub spectrum: Option<Utf8PathBuf>,
    /// `sensor.distance_mm`.
    pub distance_mm: Option<f64>,
    /// `sensor.size_mm`.
    pub sensor_mm: Option<[f64; 2]>,
    /// `sensor.pixels`.
    pub pixels: Option<[u64; 2]>,
    /// `simulation.accuracy`.
    pub accuracy: Option<Accuracy>,
    /// `key=value` pairs: dotted keys of the scene file, values as TOML.
    pub set: Vec<String>,
    /// Takes the emitter from the luminous dimensions of the photometric file.
    pub luminous_area: bool,
}

impl Changes {
    fn is_none(&self) -> bool {
        *self == Self::default()
    }

    /// As they stand on the command line.
    fn words(&self) -> String {
        let pair = |[x, y]: [String; 2]| format!("{x},{y}");
        let given = [
            self.spectrum.as_ref().map(|file| format!("--spectrum {file}")),
            self.distance_mm.map(|mm| format!("--distance-mm {mm}")),
            self.sensor_mm
                .map(|mm| format!("--sensor-mm {}", pair(mm.map(|mm| mm.to_string())))),
            self.pixels
                .map(|count| format!("--pixels {}", pair(count.map(|count| count.to_string())))),
            self.accuracy.map(|accuracy| format!("--accuracy {}", accuracy.word())),
            self.luminous_area.then(|| "--luminous-area".to_owned()),
        ];
        let set = self.set.iter().map(|pair| format!("--set {pair}"));
        given.into_iter().flatten().chain(set).collect::<Vec<_>>().join(" ")
    }
}

/// What a simulation takes for granted where `input` names no sensor and no option says otherwise, in one sentence;
/// none where nothing is.
pub fn assumption(input: &Utf8Path, scene: &Scene, changes: &Changes) -> Option<String> {
    if is_scene(input) {
        return None;
    }
    let by_key = |key: &str| changes.set.iter().any(|pair| pair.trim_start().starts_with(key));
    let sensor = &scene.sensor;
    let ([width, height], [nx, ny]) = (sensor.size_mm, sensor.pixels);
    let parts = [
        (
            changes.distance_mm.is_some() || by_key("sensor.distance_mm"),
            format!("distance {} mm", sensor.pose.distance_mm),
        ),
        (
            changes.sensor_mm.is_some() || by_key("sensor.size_mm"),
            format!("size {width} × {height} mm"),
        ),
        (
            changes.pixels.is_some() || by_key("sensor.pixels"),
            format!("{nx} × {ny} pixels"),
        ),
    ];
    let assumed: Vec<String> = parts
        .into_iter()
        .filter_map(|(given, text)| (!given).then_some(text))
        .collect();
    (!assumed.is_empty()).then(|| format!("assumed, because {input} names no sensor: {}", assumed.join(", ")))
}

/// The scene at `input` with `changes`.
///
/// # Errors
/// Exit 2 with the file, the line where there is one, and what to do.
pub fn load(input: &Utf8Path, changes: &Changes) -> Result<Scene, Failure> {
    let (at, table) = base(input)?;
    if changes.is_none() && is_scene(input) {
        return Scene::load(input).map_err(Failure::bad_input);
    }
    let text = toml::to_string(&changed(&at, table, changes)?).map_err(Failure::bad_input)?;
    Scene::parse(&at, &text).map_err(|mut error| {
        if changes.is_none() {
            return Failure::bad_input(error);
        }
        // A fault of the file itself is said with its line there.
        if is_scene(input)
            && let Err(own) = Scene::load(input)
        {
            return Failure::bad_input(own);
        }
        // The lines are those of a text that nobody wrote.
        if error.file == at {
            (error.line, error.column) = (None, None);
        }
        Failure::bad_input(error).help(format!("change what was given: {}", changes.words()))
    })
}

/// The scene's table with its changes, and the path that its own paths are relative to.
///
/// # Errors
/// Exit 2.
pub fn table(input: &Utf8Path, changes: &Changes) -> Result<(Utf8PathBuf, Table), Failure> {
    let (at, table) = base(input)?;
    let table = changed(&at, table, changes)?;
    Ok((at, table))
}

/// The scene at `input` lit by `model`, whatever model it names itself.
///
/// # Errors
/// Exit 2 with the file, the line where there is one, and what to do.
pub(crate) fn lit_by(input: &Utf8Path, model: &Model) -> Result<Scene, Failure> {
    let (at, mut table) = base(input)?;
    if is_scene(input) {
        let text = read_text(input).map_err(Failure::bad_input)?;
        return Scene::parse_with(input, &text, model).map_err(Failure::bad_input);
    }
    table.remove("model");
    table.remove("luminaire");
    let text = toml::to_string(&table).map_err(Failure::bad_input)?;
    Scene::parse_with(&at, &text, model).map_err(Failure::bad_input)
}

/// The sensor of the published case lit by `model`.
///
/// # Errors
/// Exit 2 for a model that cannot light it.
pub(crate) fn of_the_published_case(model: &Model) -> Result<Scene, Failure> {
    let mut table = with_sensor("model", "");
    table.remove("model");
    let text = toml::to_string(&table).map_err(Failure::bad_input)?;
    Scene::parse_with(Utf8Path::new("scene.toml"), &text, model).map_err(Failure::bad_input)
}

/// A luminaire that is in no file, before the sensor of the published case, with `changes`.
///
/// # Errors
/// Exit 2 with the key, and what to do; also for a change of what only a file holds.
pub fn of_distribution(
    intensity: IntensityDistribution,
    spectrum: Option<Spectrum>,
    changes: &Changes,
) -> Result<Scene, Failure> {
    let at = Utf8Path::new("scene.toml");
    if changes.luminous_area || changes.spectrum.is_some() {
        return Err(
            Failure::bad_input("a distribution in memory has no file with luminous dimensions or a spectrum")
                .help("write it to a file, and simulate that"),
        );
    }
    let mut table = with_sensor("luminaire", "");
    table.insert("luminaire".into(), Table::new().into());
    let mut table = changed(at, table, changes)?;
    let mut luminaire = match table.remove("luminaire") {
        Some(Value::Table(luminaire)) => luminaire,
        _ => Table::new(),
    };
    let emitter = match luminaire.remove("emitter") {
        None => Emitter::Point {},
        Some(emitter) => emitter
            .try_into()
            .map_err(|error| Failure::bad_input(format!("luminaire.emitter: {error}")))?,
    };
    if let Some(key) = luminaire
        .keys()
        .next()
        .map(|key| format!("luminaire.{key}"))
        .or_else(|| {
            let own = ["model", "effect"].into_iter().find(|key| table.contains_key(*key));
            own.map(str::to_owned)
        })
    {
        return Err(
            Failure::bad_input(format!("{key}: a distribution in memory has no such key"))
                .help("write it to a file, and simulate a scene that names the file"),
        );
    }
    let spectral = spectrum.map_or(Spectral::None, Spectral::Spectrum);
    let model = Model::of(Luminaire::new(intensity, emitter, spectral));
    let text = toml::to_string(&table).map_err(Failure::bad_input)?;
    Scene::parse_with(at, &text, &model).map_err(|mut error| {
        // The lines are those of a text that nobody wrote.
        (error.line, error.column) = (None, None);
        Failure::bad_input(error)
    })
}

/// Sets a dotted key; a number in brackets picks an entry of a list.
///
/// # Errors
/// Exit 2 when a part of the key is no table.
pub fn set(table: &mut Table, key: &str, value: Value) -> Result<(), Failure> {
    let mut parts = key.split('.').peekable();
    let mut at = table;
    while let Some(part) = parts.next() {
        if parts.peek().is_none() {
            at.insert(part.to_owned(), value);
            return Ok(());
        }
        let next = at.entry(part.to_owned()).or_insert_with(|| Value::Table(Table::new()));
        at = match next {
            Value::Table(table) => table,
            Value::Array(list) => {
                let index = parts.next().and_then(|index| index.parse::<usize>().ok());
                if parts.peek().is_none() {
                    return Err(Failure::bad_input(format!(
                        "key {key}: it ends on the list `{part}`, not on a key of one of its entries"
                    ))
                    .help("name the key that is changed, such as effect.0.radius_mm, or the whole list: effect=[…]"));
                }
                match index.and_then(|index| list.get_mut(index)) {
                    Some(Value::Table(table)) => table,
                    _ => return Err(unknown(key, part)),
                }
            }
            _ => return Err(unknown(key, part)),
        };
    }
    Ok(())
}

fn unknown(key: &str, part: &str) -> Failure {
    Failure::bad_input(format!("key {key}: `{part}` holds no further keys"))
        .help("keys are written as in the scene file, such as sensor.distance_mm or effect.0.radius_mm")
}

/// Every text in a value, wherever it stands.
pub(crate) fn each_text(value: &mut Value, change: &mut dyn FnMut(&mut String)) {
    match value {
        Value::String(text) => change(text),
        Value::Array(list) => list.iter_mut().for_each(|value| each_text(value, change)),
        Value::Table(table) => table.iter_mut().for_each(|(_, value)| each_text(value, change)),
        _ => {}
    }
}

fn is_scene(input: &Utf8Path) -> bool {
    input.is_file() && input.extension() == Some("toml") && format_of(input).as_deref() != Some("isolux-model/1")
}

fn format_of(path: &Utf8Path) -> Option<String> {
    let text = read_text(path).ok()?;
    let table: Table = text.parse().ok()?;
    Some(table.get("format")?.as_str()?.to_owned())
}

/// The table of a scene, and the path it stands at or would stand at.
fn base(input: &Utf8Path) -> Result<(Utf8PathBuf, Table), Failure> {
    if input.is_dir() {
        let model = ["results/luminaire.model.toml", "luminaire.model.toml"]
            .into_iter()
            .find(|model| input.join(model).is_file())
            .ok_or_else(|| {
                Failure::bad_input(format!("{input}: no results/luminaire.model.toml"))
                    .help("a run is simulated after `isolux reduce RUN` has made its model")
            })?;
        if model.starts_with("results/") {
            crate::run::record::check_results(&input.join("results"))?;
        }
        return Ok((input.join("scene.toml"), with_sensor("model", model)));
    }
    if input.exists() && !input.is_file() {
        return Err(
            Failure::bad_input(format!("{input} is a pipe or device, which gives its bytes once"))
                .help("save it as a file: a scene and what it names are read again from their own places"),
        );
    }
    let bytes = files::read(input)?;
    let name = input.file_name().unwrap_or_default();
    // What the file stands for is a scene at its own place: relative paths and messages are of this file.
    let at = input.to_owned();
    if input.extension() != Some("toml") {
        let mut luminaire = Table::new();
        luminaire.insert("distribution".into(), name.into());
        let mut table = with_sensor("format", "isolux-scene/1");
        table.insert("luminaire".into(), luminaire.into());
        return Ok((at, table));
    }
    let text = String::from_utf8(bytes).map_err(|_| Failure::bad_input(format!("{input}: not UTF-8 text")))?;
    if format_of(input).as_deref() == Some("isolux-model/1") {
        return Ok((at, with_sensor("model", name)));
    }
    match text.parse() {
        Ok(table) => Ok((input.to_owned(), table)),
        // The scene's own reader words this with file and line.
        Err(error) => Err(Scene::load(input)
            .err()
            .map_or_else(|| Failure::bad_input(&error), Failure::bad_input)),
    }
}

/// The sensor of the published case: 24.576 mm, 2048² pixels, 500 mm.
fn with_sensor(key: &str, value: &str) -> Table {
    let mut sensor = Table::new();
    sensor.insert("size_mm".into(), Value::Array(vec![24.576.into(), 24.576.into()]));
    sensor.insert("pixels".into(), Value::Array(vec![2048.into(), 2048.into()]));
    sensor.insert("distance_mm".into(), 500.0.into());
    let mut table = Table::new();
    table.insert("format".into(), "isolux-scene/1".into());
    table.insert(key.into(), value.into());
    table.insert("sensor".into(), sensor.into());
    table
}

fn changed(at: &Utf8Path, mut table: Table, changes: &Changes) -> Result<Table, Failure> {
    let touches_model = changes.spectrum.is_some()
        || changes.luminous_area
        || changes
            .set
            .iter()
            .any(|pair| pair.trim_start().starts_with("luminaire") || pair.trim_start().starts_with("effect"));
    if touches_model {
        inline_model(at, &mut table)?;
    }
    if let Some(spectrum) = &changes.spectrum {
        let whole = std::path::absolute(spectrum).map_err(Failure::bad_input)?;
        let path = Utf8PathBuf::try_from(whole).map_err(Failure::bad_input)?;
        if let Some(Value::Table(luminaire)) = table.get_mut("luminaire") {
            luminaire.remove("ler_lm_per_w");
            luminaire.insert("spectrum".into(), files::in_document(&path).into());
        }
    }
    if changes.luminous_area {
        let emitter = luminous_emitter(at, &table)?;
        set(&mut table, "luminaire.emitter", emitter)?;
    }
    if let Some(distance_mm) = changes.distance_mm {
        set(&mut table, "sensor.distance_mm", distance_mm.into())?;
    }
    if let Some([x, y]) = changes.sensor_mm {
        set(&mut table, "sensor.size_mm", Value::Array(vec![x.into(), y.into()]))?;
    }
    if let Some(pixels) = changes.pixels {
        let whole = |n: u64| Value::Integer(i64::try_from(n).unwrap_or(i64::MAX));
        set(&mut table, "sensor.pixels", Value::Array(pixels.map(whole).to_vec()))?;
    }
    if let Some(accuracy) = changes.accuracy {
        set(&mut table, "simulation.accuracy", accuracy.word().into())?;
    }
    for pair in &changes.set {
        let Some((key, value)) = pair.split_once('=') else {
            return Err(Failure::bad_input(format!("--set {pair}: expected key=value")));
        };
        set(&mut table, key.trim(), parsed(value.trim()))?;
    }
    Ok(table)
}

/// A value as TOML; what is no TOML is a text.
pub fn parsed(text: &str) -> Value {
    let line: Result<Table, _> = format!("value = {text}").parse();
    line.ok()
        .and_then(|mut table| table.remove("value"))
        .unwrap_or_else(|| Value::String(text.to_owned()))
}

/// Puts the model's own tables into the scene, its paths made good, so that a key of it can be changed.
fn inline_model(at: &Utf8Path, table: &mut Table) -> Result<(), Failure> {
    let Some(Value::String(file)) = table.get("model").cloned() else {
        return Ok(());
    };
    let path = at.parent().unwrap_or(Utf8Path::new("")).join(&file);
    // The model as it stands has to be one: a table that is not taken over would otherwise be left out without a word.
    Model::load(&path).map_err(Failure::bad_input)?;
    let text = String::from_utf8(files::read(&path)?).map_err(|_| Failure::bad_input(format!("{path}: not UTF-8")))?;
    let mut model: Table = text
        .parse()
        .map_err(|error| Failure::bad_input(format!("{path}: {error}")))?;
    let folder = Utf8Path::new(&file).parent().unwrap_or(Utf8Path::new("")).to_owned();
    if let Some(Value::Table(luminaire)) = model.get_mut("luminaire") {
        for key in ["distribution", "spectrum"] {
            if let Some(Value::String(name)) = luminaire.get_mut(key) {
                *name = files::in_document(&folder.join(&*name));
            }
        }
    }
    table.remove("model");
    for key in ["luminaire", "noise"] {
        if let Some(value) = model.remove(key) {
            table.insert(key.into(), value);
        }
    }
    // Effects of the model come first, as a scene's own are added to them.
    let mut effects = match model.remove("effect") {
        Some(Value::Array(effects)) => effects,
        _ => Vec::new(),
    };
    if let Some(Value::Array(own)) = table.remove("effect") {
        effects.extend(own);
    }
    if !effects.is_empty() {
        table.insert("effect".into(), Value::Array(effects));
    }
    Ok(())
}

/// The emitter that the photometric file's luminous dimensions describe.
fn luminous_emitter(at: &Utf8Path, table: &Table) -> Result<Value, Failure> {
    let name = table
        .get("luminaire")
        .and_then(|luminaire| luminaire.get("distribution"))
        .and_then(Value::as_str);
    let name = name.ok_or_else(|| Failure::bad_input("the scene names no distribution"))?;
    let path = at.parent().unwrap_or(Utf8Path::new("")).join(name);
    let [length, width] = luminous_mm(&path)?;
    let mut emitter = Table::new();
    if width == 0.0 {
        emitter.insert("shape".into(), "disc".into());
        emitter.insert("diameter_mm".into(), length.into());
    } else {
        emitter.insert("shape".into(), "rectangle".into());
        // EULUMDAT: the length lies along C90–C270, the width along C0–C180.
        emitter.insert("size_mm".into(), Value::Array(vec![width.into(), length.into()]));
    }
    Ok(emitter.into())
}

/// Length (or diameter) and width (0: circular) of the luminous area, mm.
fn luminous_mm(path: &Utf8Path) -> Result<[f64; 2], Failure> {
    let bytes = files::read(path)?;
    let wrong = || {
        Failure::bad_input(format!("{path}: no luminous dimensions"))
            .help("give the emitter in the scene, such as --set 'luminaire.emitter={shape=\"disc\", diameter_mm=20}'")
    };
    if path.extension().map(str::to_ascii_lowercase).as_deref() != Some("ldt") {
        return Err(wrong());
    }
    let read = isolux_formats::eulumdat::read(&bytes, ReadOptions::default());
    let luminaire = read.document.map(|document| document.luminaire).ok_or_else(wrong)?;
    match (luminaire.luminous_length_mm, luminaire.luminous_width_mm) {
        (Some(length), Some(width)) if length > 0.0 && width >= 0.0 => Ok([length, width]),
        _ => Err(wrong()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dotted_keys_reach_into_tables_and_lists() {
        let mut table: Table = "a = 1\n[[effect]]\nname = \"x\"\n".parse().unwrap();
        set(&mut table, "sensor.distance_mm", parsed("250")).unwrap();
        set(&mut table, "effect.0.radius_mm", parsed("28.5")).unwrap();
        assert_eq!(table["sensor"]["distance_mm"].as_integer(), Some(250));
        assert_eq!(table["effect"][0]["radius_mm"].as_float(), Some(28.5));
        assert!(set(&mut table, "a.b", parsed("1")).is_err());
        let before = table.clone();
        assert!(set(&mut table, "effect.0", parsed("5")).is_err());
        assert_eq!(table, before, "nothing is changed by a key that is refused");
    }

    #[test]
    fn values_are_toml_or_text() {
        assert_eq!(parsed("[1.0, 2.0]").as_array().map(Vec::len), Some(2));
        assert_eq!(parsed("ring.ldt").as_str(), Some("ring.ldt"));
    }
}
