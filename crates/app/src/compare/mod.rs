//! `compare`: two or more distributions or runs against the first of them, and a series with its spread.

mod item;
mod pair;
mod series;
mod words;

use camino::{Utf8Path, Utf8PathBuf};
use isolux_report::plots::{DifferenceCurve, difference_over_gamma, difference_over_sphere};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use self::item::Item;
pub use self::pair::{Pair, Row, Sphere};
pub use self::series::{Series, SeriesRow};
use crate::Failure;
use crate::files::{self, Overwrite};

/// What is compared, and how.
#[derive(Debug, Clone)]
pub struct Request<'a> {
    /// Photometric files, models and run directories; the others against the first.
    pub items: &'a [Utf8PathBuf],
    /// Relative difference that is allowed where no uncertainty is known, and of the distribution relative to its
    /// largest intensity; none: not judged.
    pub tolerance_rel: Option<f64>,
    /// Compare the shape alone: distributions are scaled to the flux of the first.
    pub shape: bool,
    /// Folder for the figures and `comparison.json`.
    pub out: Option<&'a Utf8Path>,
    /// Whether files there may be replaced.
    pub overwrite: Overwrite,
}

/// What a comparison gives; the content of `compare --json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Compared {
    /// The first, against which the others are compared.
    pub first: String,
    /// Each of the others.
    pub pairs: Vec<Pair>,
    /// Mean and spread, of three or more.
    pub series: Option<Series>,
    /// Whether everything that is judged agrees; none where nothing is judged.
    pub agree: Option<bool>,
}

/// Compares.
///
/// # Errors
/// Bad input (exit 2) for fewer than two items, one that cannot be read, or files that exist and may not be replaced.
pub fn run(request: &Request<'_>) -> Result<(Compared, Vec<Utf8PathBuf>), Failure> {
    if request.items.len() < 2 {
        return Err(Failure::bad_input("one item is no comparison").help("give two or more files or run directories"));
    }
    if let Some(bad) = request.tolerance_rel.filter(|rel| !(1e-6..=1.0).contains(rel)) {
        return Err(Failure::bad_input(format!(
            "--tolerance {} %: 0.0001 to 100 are possible",
            100.0 * bad
        )));
    }
    let items: Vec<Item> = request
        .items
        .iter()
        .map(|path| Item::load(path))
        .collect::<Result<_, _>>()?;
    let Some((first, others)) = items.split_first() else {
        return Err(Failure::bad_input("one item is no comparison"));
    };
    let pairs: Vec<Pair> = others
        .iter()
        .map(|other| Pair::of(first, other, request.tolerance_rel, request.shape))
        .collect();
    let verdicts: Vec<bool> = pairs.iter().filter_map(|pair| pair.agree).collect();
    let compared = Compared {
        first: first.name.clone(),
        series: Series::of(&items),
        agree: (!verdicts.is_empty()).then(|| verdicts.iter().all(|agree| *agree)),
        pairs,
    };
    let written = match request.out {
        Some(out) => write(out, first, others, &compared, request)?,
        None => Vec::new(),
    };
    Ok((compared, written))
}

fn write(
    out: &Utf8Path,
    first: &Item,
    others: &[Item],
    compared: &Compared,
    request: &Request<'_>,
) -> Result<Vec<Utf8PathBuf>, Failure> {
    let mut written = Vec::new();
    let mut put = |name: &str, bytes: &[u8]| -> Result<(), Failure> {
        let path = out.join(name);
        files::write(&path, bytes, request.overwrite)?;
        written.push(path);
        Ok(())
    };
    let json = serde_json::to_string_pretty(compared).map_err(Failure::instrument)? + "\n";
    put("comparison.json", json.as_bytes())?;
    let mut curves = Vec::new();
    for (number, other) in others.iter().enumerate() {
        let difference = pair::Difference::of(first, other, request.shape);
        let title = format!("{} against {}", other.name, first.name);
        let at = |c_deg: f64, gamma_deg: f64| difference.of_peak(c_deg, gamma_deg);
        let map = difference_over_sphere(&at, difference.last_gamma_deg(), &title);
        put(&format!("sphere-{}.svg", number + 2), map.as_bytes())?;
        for c_deg in [0.0, 90.0] {
            curves.push(DifferenceCurve {
                name: format!("{}, C{c_deg}–C{}", other.name, c_deg + 180.0),
                points: difference.along(c_deg),
            });
        }
    }
    put("curves.svg", difference_over_gamma(&curves, &first.name).as_bytes())?;
    Ok(written)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A rotational lamp of an axial intensity, as LM-63.
    fn lamp(folder: &Utf8Path, name: &str, axial_cd: f64) -> Utf8PathBuf {
        let path = folder.join(name);
        let gammas: Vec<String> = (0..=18).map(|k| format!("{}", 5 * k)).collect();
        let candela: Vec<String> = (0..=18)
            .map(|k| format!("{:.4}", axial_cd * f64::from(5 * k).to_radians().cos().max(0.0)))
            .collect();
        let text = format!(
            "IESNA:LM-63-2002\n[TEST] 1\n[TESTLAB] a\n[ISSUEDATE] b\n[MANUFAC] c\nTILT=NONE\n\
             1 -1 1 19 1 1 2 0 0 0\n1 1 10\n{}\n0\n{}\n",
            gammas.join(" "),
            candela.join(" ")
        );
        std::fs::write(&path, text).unwrap();
        path
    }

    #[test]
    fn files_are_judged_by_the_tolerance_and_shapes_without_their_level() {
        let keep = tempfile::tempdir().unwrap();
        let folder = Utf8Path::from_path(keep.path()).unwrap();
        let items = [
            lamp(folder, "a.ies", 100.0),
            lamp(folder, "b.ies", 102.0),
            lamp(folder, "c.ies", 101.0),
        ];
        let out = folder.join("out");
        let request = Request {
            items: &items,
            tolerance_rel: None,
            shape: false,
            out: Some(&out),
            overwrite: Overwrite::Never,
        };
        let (compared, written) = run(&request).unwrap();
        assert_eq!((compared.agree, written.len()), (None, 4));
        let pair = &compared.pairs[0];
        // 2 % of the peak on the axis; ∫cos²γ dΩ over a half space is 2π/3, of the sphere 4π.
        assert!((pair.sphere.largest_of_peak - 0.02).abs() < 1e-9 && pair.sphere.largest_gamma_deg == 0.0);
        let rms = 0.02 * (1.0_f64 / 3.0).sqrt();
        assert!(
            (pair.sphere.rms_of_peak / rms - 1.0).abs() < 0.01,
            "{}",
            pair.sphere.rms_of_peak
        );
        assert!((pair.sphere.rms_rel_where_bright - 0.02).abs() < 1e-6);
        let flux = &pair.rows[0];
        assert!((flux.difference / flux.first - 0.02).abs() < 1e-6 && flux.e_n.is_none());
        let series = compared.series.unwrap();
        assert!((series.rows[0].mean / flux.first - 1.01).abs() < 1e-6);
        assert!((series.rows[0].s / flux.first - 0.01).abs() < 1e-6);
        let agree = |tolerance_rel: f64, shape: bool| {
            let request = Request {
                tolerance_rel: Some(tolerance_rel),
                shape,
                out: None,
                ..request.clone()
            };
            run(&request).unwrap().0.agree
        };
        assert_eq!((agree(0.01, false), agree(0.03, false)), (Some(false), Some(true)));
        assert_eq!(agree(1e-4, true), Some(true));
        // Nothing is replaced unasked, and nothing is compared with itself alone.
        assert!(run(&request).unwrap_err().message.contains("comparison.json"));
        let alone = Request {
            items: &items[..1],
            ..request.clone()
        };
        assert!(run(&alone).is_err());
    }
}
