//! Model and scene files: what is wrong is said with file and line, what is read is written whole.

use camino::Utf8PathBuf;
use isolux_model::{Emitter, Harmonic, Model, Refined, Scene, ShapeTrust, UncertaintyScale};

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        let rows: Vec<String> = (0..=90)
            .map(|g| format!("{g},{}\n", 300.0 * f64::from(g).to_radians().cos().max(0.0)))
            .collect();
        std::fs::write(
            folder.path("d.csv"),
            format!("gamma_deg,intensity_cd\n{}", rows.concat()),
        )
        .unwrap();
        folder
    }
    fn path(&self, name: &str) -> Utf8PathBuf {
        Utf8PathBuf::try_from(self.0.path().join(name)).unwrap()
    }
    fn complaint(&self, text: &str) -> String {
        let path = self.path("m.toml");
        Model::parse(&path, text)
            .unwrap_err()
            .to_string()
            .replace(self.path("").as_str(), "")
    }
}

const HEAD: &str = "format = \"isolux-model/1\"\n[luminaire]\ndistribution = \"d.csv\"\nemitter = { shape = \"disc\", diameter_mm = 1.0 }\n";

#[test]
fn what_is_wrong_is_said_with_file_and_line() {
    let folder = Folder::new();
    let starts = |text: &str, expected: &str| {
        let found = folder.complaint(text);
        assert!(found.starts_with(expected), "{found}\n  for {expected}");
    };
    starts(&format!("{HEAD}flux = 3\n"), "m.toml:5:1: unknown field `flux`");
    starts(
        &format!("{HEAD}interpolation = \"cubic\"\n"),
        "m.toml:5:17: `luminaire.interpolation`: unknown variant `cubic`, expected `linear` or `smooth`",
    );
    starts(
        &format!("{HEAD}flux_lm = -3\n"),
        "m.toml:5:1: luminaire.flux_lm: -3 is not within",
    );
    starts(
        &format!("{HEAD}[[effect]]\nname = \"gamma_zreo\"\n"),
        "m.toml:6:1: effect.0.name: effect `gamma_zreo` is not in the catalogue",
    );
    starts(
        &format!("{HEAD}[[effect]]\nname = \"gamma_zero\"\noffset = 3\n"),
        "m.toml:7:1: effect.0.offset: effect `gamma_zero` has no key `offset`; its keys are offset_deg",
    );
    starts(
        &format!("{HEAD}[[effect]]\nname = \"lamp_warmup\"\namplitude_rel = 0.1\n"),
        "m.toml:5:1: effect.0: effect `lamp_warmup` needs `time_constant_s`",
    );
    starts(
        &format!("{HEAD}[[effect]]\nname = \"gamma_zero\"\noffset_deg = nan\n"),
        "m.toml:7:1: effect.0.offset_deg",
    );
    starts(
        &format!("{HEAD}[[effect]]\nname = \"gamma_zero\"\noffset_deg = \"1\"\n"),
        "m.toml:7:1: effect.0.offset_deg: `offset_deg` of effect",
    );
    starts(&HEAD.replace("diameter_mm", "diameter"), "m.toml:4:");
    starts(
        &HEAD.replace("d.csv", "e.csv"),
        "m.toml:3:1: luminaire.distribution: e.csv: No such file",
    );
    starts(
        &HEAD.replace(
            "{ shape = \"disc\", diameter_mm = 1.0 }\n",
            "{ shape = \"rectangle\", size_mm = [1, 2] }\n[[effect]]\nname = \"near_field\"\nradius_mm = 20\n",
        ),
        "m.toml:5:1: effect.0: effect `near_field` replaces the emitter of a point or disc",
    );
    starts(
        &format!("{HEAD}spectrum = \"s.csv\"\nler_lm_per_w = 300\n"),
        "m.toml:6:1: luminaire.ler_lm_per_w: give either",
    );
    starts(
        &HEAD.replace("isolux-model/1", "isolux-model/9"),
        "m.toml:1:10: format is",
    );
    std::fs::write(folder.path("d.csv"), "gamma_deg,intensity_cd\n0,100\n45,NaN\n").unwrap();
    let found = folder.complaint(HEAD);
    assert!(
        found.starts_with("m.toml:3:1: luminaire.distribution: d.csv:3"),
        "{found}"
    );
}

#[test]
fn a_model_is_written_whole_and_read_back_the_same() {
    let folder = Folder::new();
    // Steps so wide that straight lines have another flux than the light.
    std::fs::write(
        folder.path("d.csv"),
        "gamma_deg,intensity_cd\n0,300\n30,260\n60,150\n90,0\n",
    )
    .unwrap();
    let text = format!(
        "{HEAD}interpolation = \"smooth\"\nflux_lm = 337.0\nler_lm_per_w = 255.1\n[luminaire.trust]\nshape = \"smooth\"\nc_harmonics = [2]\n\
         [luminaire.u]\nintensity_rel = 0.01\n[luminaire.provenance]\nrun = \"day\"\nreadings_sha256 = \"abc\"\n\
         [noise]\nu_scale = \"fit\"\n\
         [[effect]]\nname = \"lamp_warmup\"\namplitude_rel = 0.05\ntime_constant_s = 600\n\
         [effect.u]\namplitude_rel = 0.001\n[effect.evidence]\nln_bayes_factor = 12.5\nalternatives = [\"lamp_drift\"]\n\
         [effect.provenance]\nsha256 = \"def\"\n\
         [[effect]]\nname = \"range_step\"\nfactor_rel = -0.002\nrange = 3\n"
    );
    let model = Model::parse(&folder.path("m.toml"), &text).unwrap();
    assert_eq!(model.trust().shape, ShapeTrust::Smooth);
    assert_eq!(model.u_scale(), UncertaintyScale::Fit);
    // The flux is that of the light, not that of straight lines between the file's directions.
    assert!((model.luminaire().grid().flux_lm() - 337.0).abs() < 1e-9);
    assert!((model.luminaire().distribution().flux_lm() - 337.0).abs() > 1.0);
    let refined = Refined {
        ln_shape: vec![0.01, -0.02],
        gamma_max_deg: 70.0,
        c_harmonics: vec![Harmonic {
            m: 2,
            amplitude_rel: 0.003,
        }],
        map_gain: 1.234e-4,
        ..Refined::default()
    };
    let model = model.with_refined(refined.clone());
    let again = Model::parse(&folder.path("again.toml"), &model.to_toml()).unwrap();
    assert_eq!(again.effects(), model.effects());
    assert_eq!(again.refined(), &refined);
    assert_eq!(again.luminaire(), model.luminaire());
    assert_eq!(again.provenance(), model.provenance());
    assert_eq!(again.uncertainty(), model.uncertainty());
    assert_eq!(again.to_toml(), model.to_toml());
    let notes = &again.effects()[0].notes;
    assert_eq!(
        notes.evidence.as_ref().unwrap()["ln_bayes_factor"].as_float(),
        Some(12.5)
    );
    assert_eq!(notes.provenance.as_ref().unwrap()["sha256"].as_str(), Some("def"));
}

#[test]
fn a_model_can_move_with_its_files() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("sub")).unwrap();
    std::fs::rename(folder.path("d.csv"), folder.path("sub/d.csv")).unwrap();
    let model = Model::parse(&folder.path("m.toml"), &HEAD.replace("d.csv", "sub/d.csv")).unwrap();
    assert_eq!(model.files(), [("sub/d.csv".to_owned(), folder.path("sub/d.csv"))]);
    let moved = model.beside_its_files();
    assert!(
        moved.to_toml().contains("distribution = \"d.csv\""),
        "{}",
        moved.to_toml()
    );
    assert!(Model::parse(&folder.path("sub/m.toml"), &moved.to_toml()).is_ok());
}

#[test]
fn spectra_over_angle_move_with_their_model_and_what_is_wrong_with_them_is_said() {
    let folder = Folder::new();
    let line = |nm: u32, value: f64| format!("wavelength_nm,value\n{},0\n{nm},{value}\n{},0\n", nm - 1, nm + 1);
    std::fs::create_dir(folder.path("sub")).unwrap();
    for (name, nm) in [
        ("axis.csv", 555),
        ("sub/a.csv", 560),
        ("sub/b.csv", 600),
        ("dark.csv", 900),
    ] {
        std::fs::write(folder.path(name), line(nm, 2.0)).unwrap();
    }
    let entry = |c: &str, gamma: &str, file: &str| {
        format!("[[luminaire.colour]]\n{c}gamma_deg = {gamma}\nspectrum = \"{file}\"\n")
    };
    let head = format!("{HEAD}spectrum = \"axis.csv\"\n");
    let good = head.clone()
        + &entry("", "0.0", "axis.csv")
        + &entry("c_deg = 0.0\n", "40.0", "sub/a.csv")
        + &entry("c_deg = 180.0\n", "40.0", "sub/b.csv");
    let model = Model::parse(&folder.path("m.toml"), &good).unwrap();
    let colour = model.colour().unwrap();
    assert_eq!(colour.directions_deg(), [(0.0, 0.0), (0.0, 40.0), (180.0, 40.0)]);
    assert_eq!(model.files().len(), 5);
    assert_eq!(model.files()[4], ("sub/b.csv".to_owned(), folder.path("sub/b.csv")));
    let again = Model::parse(&folder.path("again.toml"), &model.to_toml()).unwrap();
    assert_eq!(again.colour(), model.colour());
    let moved = model.beside_its_files().to_toml();
    assert!(moved.contains("\"a.csv\"") && !moved.contains("sub/"), "{moved}");
    // A scene has the spectra of its model, or its own in their place.
    std::fs::write(folder.path("m.toml"), &good).unwrap();
    let scene =
        "format = \"isolux-scene/1\"\nmodel = \"m.toml\"\n[sensor]\nsize_mm = 24.0\npixels = 2\ndistance_mm = 500\n";
    let of = |text: &str| {
        Scene::parse(&folder.path("scene.toml"), text)
            .unwrap()
            .optics
            .colour
            .unwrap()
    };
    assert_eq!(&of(scene), model.colour().unwrap());
    let own = of(&format!(
        "{scene}[[colour]]\ngamma_deg = 0.0\nspectrum = \"axis.csv\"\n"
    ));
    assert_eq!(own.directions_deg(), [(0.0, 0.0)]);

    for (text, expected) in [
        (HEAD.to_owned() + &entry("", "0.0", "axis.csv"), "luminaire.spectrum"),
        (
            head.clone() + &entry("", "190.0", "axis.csv"),
            "m.toml:7:1: luminaire.colour.0.gamma_deg",
        ),
        (
            head.clone() + &entry("", "0.0", "none.csv"),
            "m.toml:8:1: luminaire.colour.0.spectrum",
        ),
        (head.clone() + &entry("", "0.0", "dark.csv"), "no visible light"),
        (
            good.clone() + &entry("c_deg = 360.0\n", "40.0", "axis.csv"),
            "given twice",
        ),
        (good.clone() + &entry("", "50.0", "axis.csv"), "lacks c_deg"),
        (
            head.clone() + &entry("", "40.0", "axis.csv") + &entry("", "30.0", "axis.csv"),
            "angles must rise",
        ),
        (
            head + &entry("c_deg = 0.0\n", "40.0", "axis.csv") + &entry("c_deg = 100.0\n", "40.0", "axis.csv"),
            "do not go round",
        ),
    ] {
        let found = folder.complaint(&text);
        assert!(found.contains(expected), "{found}\n  for {expected}");
    }
}

#[test]
fn a_scene_is_a_model_and_a_sensor() {
    let folder = Folder::new();
    std::fs::write(folder.path("m.toml"), HEAD).unwrap();
    let sensor = "[sensor]\nsize_mm = 24.0\npixels = [4, 2]\ndistance_mm = 500\noffset_mm = [1, 2]\n";
    let path = folder.path("scene.toml");
    let scene = Scene::parse(
        &path,
        &format!("format = \"isolux-scene/1\"\nmodel = \"m.toml\"\n{sensor}"),
    )
    .unwrap();
    assert_eq!((scene.sensor.size_mm, scene.sensor.pixels), ([24.0, 24.0], [4, 2]));
    assert_eq!(scene.sensor.pixel_centre_mm(0, 1).to_array(), [-9.0, 6.0]);
    assert_eq!(scene.model.luminaire().emitter(), &Emitter::Disc { diameter_mm: 1.0 });
    let inline = HEAD.replace("isolux-model/1", "isolux-scene/1");
    let same = Scene::parse(&path, &format!("{inline}{sensor}")).unwrap();
    assert_eq!(same.model.luminaire(), scene.model.luminaire());

    let complaint = |text: &str| {
        Scene::parse(&path, text)
            .unwrap_err()
            .to_string()
            .replace(folder.path("").as_str(), "")
    };
    let both = complaint(&format!(
        "{}{sensor}",
        inline.replacen('\n', "\nmodel = \"m.toml\"\n", 1)
    ));
    assert!(both.starts_with("scene.toml:3:"), "{both}");
    let behind = complaint(&format!(
        "{inline}{}",
        sensor.replace("distance_mm = 500", "distance_mm = -500")
    ));
    assert!(
        behind.starts_with("scene.toml:8:1: sensor.distance_mm: -500 is not within 0.001 to"),
        "{behind}"
    );
}
