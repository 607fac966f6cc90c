//! `isolux predict`: what a model says would be read at the coordinates of a file.

use camino::Utf8Path;
use isolux_model::Model;
use isolux_record::observation::{MapSet, MapUnit, Need, Observations, Readings, SpectraSet, open};
use serde::Serialize;

use crate::Failure;
use crate::files::{self, Overwrite};

/// What was predicted.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Predicted {
    /// `readings`, `maps` or `spectra`.
    pub kind: &'static str,
    /// Rows written.
    pub rows: usize,
    /// Effects of the model that changed these predictions.
    pub effects_applied: Vec<&'static str>,
    /// Effects of the model that do not act on this kind of observation.
    pub effects_not_applicable: Vec<&'static str>,
    /// What a person should know of the record that the coordinates come from.
    pub notices: Vec<String>,
}

/// Predicts every row of `observations` (a run directory, a readings CSV, a `maps.toml`, a `spectra.toml`) and writes
/// the coordinates with the prediction to `out`, in the same order.
///
/// # Errors
/// Bad input (exit 2) with file and line; nothing is written then.
pub fn run(
    model: &Utf8Path,
    observations: &Utf8Path,
    out: &Utf8Path,
    overwrite: Overwrite,
) -> Result<Predicted, Failure> {
    files::refuse_existing(out, overwrite)?;
    let (predicted, table) = table(model, observations)?;
    files::write(out, &table.csv()?, overwrite)?;
    Ok(predicted)
}

/// Predicts every row of `observations` as [`run`] does, and writes nothing.
///
/// # Errors
/// As [`run`].
pub fn table(model: &Utf8Path, observations: &Utf8Path) -> Result<(Predicted, Table), Failure> {
    let model_path = model;
    let model = Model::load(model_path).map_err(Failure::bad_input)?;
    let observations = open(observations, Need::Coordinates).map_err(Failure::bad_input)?;
    let (kind, stage, table) = match &observations {
        Observations::Readings(readings) => ("readings", isolux_model::Stage::Readings, of_readings(&model, readings)),
        Observations::Maps(maps) => ("maps", isolux_model::Stage::Maps, of_maps(&model, model_path, maps)?),
        Observations::Spectra(spectra) => (
            "spectra",
            isolux_model::Stage::Spectra,
            of_spectra(&model, model_path, spectra)?,
        ),
    };
    if let Some(row) = table.values.iter().position(|value| !value.is_finite()) {
        let message = format!(
            "{model_path}: the prediction of row {} is {}",
            row + 1,
            table.values[row]
        );
        return Err(Failure::bad_input(message)
            .help("look at the values of the model's effects: one of them is not possible here"));
    }
    let names = |acts: bool| {
        model
            .effects()
            .iter()
            .filter(|e| e.acts_on(stage) == acts)
            .map(isolux_model::Effect::name)
            .collect()
    };
    let predicted = Predicted {
        kind,
        rows: table.values.len(),
        effects_applied: names(true),
        effects_not_applicable: names(false),
        notices: match &observations {
            Observations::Readings(readings) => readings.notices().to_vec(),
            Observations::Maps(_) | Observations::Spectra(_) => Vec::new(),
        },
    };
    Ok((predicted, table))
}

/// Coordinates as text and the predicted value of each row.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// Names of the coordinates.
    pub header: Vec<String>,
    /// One text a name, for each row.
    pub coordinates: Vec<Vec<String>>,
    /// Name of the predicted values, with their unit.
    pub column: &'static str,
    /// One a row.
    pub values: Vec<f64>,
}

impl Table {
    fn csv(&self) -> Result<Vec<u8>, Failure> {
        let mut writer = csv::WriterBuilder::new()
            .terminator(csv::Terminator::Any(b'\n'))
            .from_writer(Vec::new());
        // A file that was itself predicted is predicted anew.
        let kept: Vec<usize> = (0..self.header.len())
            .filter(|index| self.header[*index] != self.column)
            .collect();
        let mut row: Vec<&str> = kept.iter().map(|index| self.header[*index].as_str()).collect();
        row.push(self.column);
        writer.write_record(&row).map_err(Failure::instrument)?;
        for (coordinates, value) in self.coordinates.iter().zip(&self.values) {
            let value = value.to_string();
            let mut row: Vec<&str> = kept.iter().map(|index| coordinates[*index].as_str()).collect();
            row.push(&value);
            writer.write_record(&row).map_err(Failure::instrument)?;
        }
        writer.into_inner().map_err(Failure::instrument)
    }
}

fn of_readings(model: &Model, readings: &Readings) -> Table {
    Table {
        header: readings.header().to_vec(),
        coordinates: readings.text().to_vec(),
        column: "predicted_illuminance_lx",
        values: model.predict_readings(&readings.coordinates()),
    }
}

fn of_maps(model: &Model, model_path: &Utf8Path, maps: &MapSet) -> Result<Table, Failure> {
    let in_watts = maps.unit() == MapUnit::WattPerSquareMetre || model.background_lx().is_none();
    if in_watts && model.ler_lm_per_w().is_none() {
        let message = format!("{model_path}: W/m² need a spectrum or an efficacy, and the model has neither");
        return Err(Failure::bad_input(message).help("give luminaire.spectrum or luminaire.ler_lm_per_w"));
    }
    let coordinates = maps
        .cells()
        .iter()
        .map(|cell| {
            vec![
                maps.maps()[cell.map as usize].name.clone(),
                cell.iy.to_string(),
                cell.ix.to_string(),
            ]
        })
        .collect();
    Ok(Table {
        header: ["map", "iy", "ix"].map(str::to_owned).to_vec(),
        coordinates,
        column: "predicted_signal",
        values: model.predict_maps(maps),
    })
}

fn of_spectra(model: &Model, model_path: &Utf8Path, spectra: &SpectraSet) -> Result<Table, Failure> {
    let values = model
        .predict_spectra(spectra)
        .map_err(|error| Failure::bad_input(format!("{model_path}: {error}")))?;
    Ok(Table {
        header: spectra.header().to_vec(),
        coordinates: spectra.text().to_vec(),
        column: "predicted_value",
        values,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use camino::Utf8PathBuf;

    const COORDINATES: &str = "index,block,kind,time_s,c_deg,gamma_deg,distance_mm,travel,range,ambient_c,note\n\
                               3,A,lit,600,0,0,2000,0,0,24.5,\"far, up\"\n\
                               1,A,capped,,0,0,2000,0,0,,\n";

    fn folder() -> (tempfile::TempDir, Utf8PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = Utf8PathBuf::try_from(folder.path().to_owned()).unwrap();
        std::fs::write(path.join("d.csv"), "gamma_deg,intensity_cd\n0,400\n90,400\n").unwrap();
        let model = "format = \"isolux-model/1\"\n[luminaire]\ndistribution = \"d.csv\"\nemitter = { shape = \"point\" }\n\
                     [[effect]]\nname = \"dark_offset\"\noffset_lx = 0.5\n\
                     [[effect]]\nname = \"vignetting\"\ncoefficient_rel = 0.02\n";
        std::fs::write(path.join("model.toml"), model).unwrap();
        std::fs::write(path.join("at.csv"), COORDINATES).unwrap();
        (folder, path)
    }

    #[test]
    fn writes_the_coordinates_and_the_prediction_in_their_order() {
        let (_keep, path) = folder();
        let out = path.join("p.csv");
        let predicted = run(&path.join("model.toml"), &path.join("at.csv"), &out, Overwrite::Never).unwrap();
        assert_eq!((predicted.kind, predicted.rows), ("readings", 2));
        assert_eq!(predicted.effects_applied, ["dark_offset"]);
        assert_eq!(predicted.effects_not_applicable, ["vignetting"]);
        let expected = "index,block,kind,time_s,c_deg,gamma_deg,distance_mm,travel,range,ambient_c,note,predicted_illuminance_lx\n\
                        3,A,lit,600,0,0,2000,0,0,24.5,\"far, up\",100.5\n\
                        1,A,capped,,0,0,2000,0,0,,,0.5\n";
        assert_eq!(std::fs::read_to_string(&out).unwrap(), expected);
    }

    #[test]
    fn bad_input_writes_nothing() {
        let (_keep, path) = folder();
        std::fs::write(path.join("at.csv"), COORDINATES.replace(",2000,", ",far,")).unwrap();
        let failure = run(
            &path.join("model.toml"),
            &path.join("at.csv"),
            &path.join("p.csv"),
            Overwrite::Never,
        )
        .unwrap_err();
        assert_eq!(failure.kind, crate::FailureKind::BadInput);
        assert!(
            failure
                .message
                .ends_with("at.csv:2: `distance_mm` = `far` is no finite number"),
            "{}",
            failure.message
        );
        assert!(!path.join("p.csv").exists());
    }
}
