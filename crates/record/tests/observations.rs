//! Sensor maps and spectra as files: what is read, and what is refused with file and line.

use camino::Utf8PathBuf;
use isolux_record::observation::{Cell, MapSet, MapUnit, Need, ObservationError, Observations, Problem, open};

struct Folder(tempfile::TempDir);

const MAPS: &str = "sensor_mm = [24.0, 12.0]\nbins = [3, 2]\nunit = \"relative\"\n\
[[map]]\nname = \"a\"\ndistance_mm = 500.0\n\
[[map]]\nname = \"b\"\ndistance_mm = 300.0\ntilt_x_deg = 40.0\nexposure = 0.5\nheld_out = true\n";
const ROWS: &str = "map,iy,ix,signal,u\na,0,0,1.0,0.01\na,0,1,1.1,0.01\na,1,2,-0.1,0.01\n";

impl Folder {
    fn new() -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        folder.write("maps.toml", MAPS);
        folder.write("maps.csv", ROWS);
        folder
    }
    fn path(&self, name: &str) -> Utf8PathBuf {
        Utf8PathBuf::try_from(self.0.path().join(name)).unwrap()
    }
    fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), bytes).unwrap();
    }
    fn open(&self, name: &str, need: Need) -> Result<Observations, ObservationError> {
        open(&self.path(name), need)
    }
    fn maps(&self, need: Need) -> MapSet {
        match self.open("maps.toml", need).unwrap() {
            Observations::Maps(maps) => maps,
            other => panic!("{other:?}"),
        }
    }
    fn complaint(&self, name: &str) -> String {
        self.open(name, Need::Values)
            .unwrap_err()
            .to_string()
            .replace(self.path("").as_str(), "")
    }
}

#[test]
fn maps_are_read_bin_by_bin() {
    let folder = Folder::new();
    let maps = folder.maps(Need::Values);
    assert_eq!(
        (maps.sensor_mm(), maps.bins(), maps.unit()),
        ([24.0, 12.0], [3, 2], MapUnit::Relative)
    );
    assert_eq!(maps.cells()[2], Cell { map: 0, iy: 1, ix: 2 });
    assert_eq!(maps.values().unwrap().0, [1.0, 1.1, -0.1], "a negative signal is data");
    assert!(maps.maps()[1].held_out && maps.maps()[0].lamp && !maps.maps()[0].capped);
    assert_eq!(maps.maps()[1].exposure, 0.5);
    // Fewer bins of the same maps.
    let fewer = MapSet::new(
        &maps,
        [1, 1],
        vec![Cell { map: 0, iy: 0, ix: 0 }],
        Some((vec![0.7], vec![0.1])),
    )
    .unwrap();
    assert_eq!((fewer.bins(), fewer.cells().len()), ([1, 1], 1));
    assert!(MapSet::new(&maps, [1, 1], vec![Cell { map: 0, iy: 1, ix: 0 }], None).is_err());
}

#[test]
fn coordinates_alone_are_enough_to_predict() {
    let folder = Folder::new();
    folder.write("maps.csv", "map,iy,ix\nb,1,0\na,0,0\n");
    assert_eq!(
        folder.maps(Need::Coordinates).cells(),
        [Cell { map: 1, iy: 1, ix: 0 }, Cell { map: 0, iy: 0, ix: 0 }]
    );
    std::fs::remove_file(folder.path("maps.csv")).unwrap();
    let all = folder.maps(Need::Coordinates);
    assert_eq!(all.cells().len(), 12);
    assert_eq!(
        (all.cells()[1].ix, all.cells()[3].iy, all.cells()[6].map),
        (1, 1, 1),
        "by map, iy, ix"
    );
}

#[test]
fn what_is_wrong_with_maps_is_said() {
    let folder = Folder::new();
    let with_rows = |rows: &str| {
        folder.write("maps.csv", rows);
        folder.complaint("maps.toml")
    };
    assert_eq!(
        with_rows("map,iy,ix,signal\na,0,0,1\n"),
        "maps.csv:1: column `u` is missing; needed are map, iy, ix, signal, u"
    );
    assert_eq!(
        with_rows(&ROWS.replace("1.1,0.01", "nan,0.01")),
        "maps.csv:3: `signal` = `nan` is no finite number"
    );
    assert_eq!(
        with_rows(&ROWS.replace("1.1,0.01", "1.1,-0.01")),
        "maps.csv:3: `u` = -0.01: it must be above zero"
    );
    assert_eq!(
        with_rows(&ROWS.replace("a,0,1", "a,0,0")),
        "maps.csv:3: map `a`, iy 0, ix 0 is there twice; the first is on line 2"
    );
    assert_eq!(
        with_rows(&ROWS.replace("a,0,1", "a,0,3")),
        "maps.csv:3: ix = 3 is outside 0…2"
    );
    assert_eq!(
        with_rows(&ROWS.replace("a,0,1", "c,0,1")),
        "maps.csv:3: map `c` is not in the maps file"
    );
    assert_eq!(
        with_rows("map,iy,ix,signal,u\nb,0,0,1.0,0.01\n"),
        "maps.toml: map `a` has no values; give its rows, or say held_out = true where it is only a pose to predict"
    );
    folder.write("maps.toml", MAPS.replace("bins = [3, 2]", "bins = [3, 3]"));
    let full: Vec<String> = (0..9).map(|i| format!("a,{},{},65535,1\n", i / 3, i % 3)).collect();
    assert!(
        with_rows(&format!("map,iy,ix,signal,u\n{}", full.concat()))
            .contains("all 9 bins hold 65535: it is saturated or empty")
    );
    folder.write("maps.toml", MAPS.replace("tilt_x_deg", "tiltx_deg"));
    assert!(
        folder.complaint("maps.toml").contains("unknown field `tiltx_deg`"),
        "{}",
        folder.complaint("maps.toml")
    );
    folder.write("maps.toml", MAPS.replace("name = \"b\"", "name = \"a\""));
    assert!(folder.complaint("maps.toml").contains("map `a` is there twice"));
    folder.write("maps.toml", MAPS.replace("distance_mm = 300.0", "distance_mm = -300.0"));
    assert!(
        folder
            .complaint("maps.toml")
            .contains("distance_mm: is -300, expected 0.001 to")
    );
}

#[test]
fn images_need_a_noise_and_the_right_size() {
    let folder = Folder::new();
    let with_images = |rest: &str| {
        let text = MAPS
            .replace("distance_mm = 500.0\n", "distance_mm = 500.0\nfile = \"a.npy\"\n")
            .replacen("[[map]]", &format!("{rest}[[map]]"), 1);
        folder.write("maps.toml", text);
    };
    let npy = |shape: &str, values: &[f64]| {
        let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}\n");
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((header.len() as u16).to_le_bytes());
        bytes.extend(
            header
                .bytes()
                .chain(values.iter().flat_map(|value| value.to_le_bytes())),
        );
        bytes
    };
    folder.write("a.npy", npy("(2, 3)", &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]));
    with_images("");
    assert_eq!(
        folder.complaint("maps.toml"),
        "maps.toml: images need [noise] u_abs and u_rel in the maps file"
    );
    with_images("[noise]\nu_abs = 0.3\nu_rel = 0.1\n");
    let maps = folder.maps(Need::Values);
    let (signal, u) = maps.values().unwrap();
    assert_eq!(signal, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    assert!((u[3] - 0.5).abs() < 1e-15);
    assert_eq!(maps.cells()[3], Cell { map: 0, iy: 1, ix: 0 });
    folder.write("a.npy", npy("(3, 2)", &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]));
    assert_eq!(
        folder.complaint("maps.toml"),
        "a.npy: image is [2, 3] pixels (width, height), the maps file says [3, 2]"
    );
}

#[test]
fn sixteen_bit_images_are_read_row_zero_first() {
    let folder = Folder::new();
    let values: Vec<u16> = vec![1, 2, 3, 400, 500, 65535];
    let mut png_bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut png_bytes, 3, 2);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Sixteen);
    let big_endian: Vec<u8> = values.iter().flat_map(|value| value.to_be_bytes()).collect();
    encoder.write_header().unwrap().write_image_data(&big_endian).unwrap();
    folder.write("a.png", png_bytes);
    let mut tiff_bytes = std::io::Cursor::new(Vec::new());
    tiff::encoder::TiffEncoder::new(&mut tiff_bytes)
        .unwrap()
        .write_image::<tiff::encoder::colortype::Gray16>(3, 2, &values)
        .unwrap();
    folder.write("a.tiff", tiff_bytes.into_inner());
    for file in ["a.png", "a.tiff"] {
        let text = MAPS.replace(
            "distance_mm = 500.0\n",
            &format!("distance_mm = 500.0\nfile = \"{file}\"\n"),
        );
        folder.write(
            "maps.toml",
            text.replacen("[[map]]", "[noise]\nu_abs = 1.0\nu_rel = 0.0\n[[map]]", 1),
        );
        let signal: Vec<f64> = values.iter().map(|value| f64::from(*value)).collect();
        assert_eq!(folder.maps(Need::Values).values().unwrap().0, signal, "{file}");
    }
}

#[test]
fn spectra_have_their_pose_and_rows() {
    let folder = Folder::new();
    folder.write(
        "spectra.toml",
        "quantity = \"irradiance\"\nunit = \"W/m2/nm\"\ndistance_mm = 500\nc_deg = 0\ngamma_deg = 0\n",
    );
    folder.write(
        "spectra.csv",
        "index,kind,wavelength_nm,value,u\n0,lit,380,0.1,0.01\n0,lit,381,0.2,0.01\n1,capped,380,0.0,0.01\n",
    );
    let Observations::Spectra(spectra) = folder.open("spectra.toml", Need::Values).unwrap() else {
        panic!()
    };
    assert_eq!(
        (spectra.rows().len(), spectra.rows()[1].value, spectra.distance_mm),
        (3, Some(0.2), 500.0)
    );
    folder.write(
        "spectra.csv",
        "index,kind,wavelength_nm,value,u\n0,lit,380,0.1,0.01\n0,lit,380,0.2,0.01\n",
    );
    assert_eq!(
        folder.complaint("spectra.toml"),
        "spectra.csv:3: 380 nm of spectrum 0 is there twice; the first is on line 2"
    );
    folder.write("spectra.csv", "index,kind,wavelength_nm,value,u\n0,lit,380,0.1,0\n");
    assert_eq!(
        folder.complaint("spectra.toml"),
        "spectra.csv:2: `u` = 0: it must be above zero"
    );
}

#[test]
fn what_is_no_observation_is_refused() {
    let folder = Folder::new();
    folder.write("model.toml", "format = \"isolux-model/1\"\n");
    assert!(matches!(
        folder.open("model.toml", Need::Coordinates).unwrap_err().problem,
        Problem::NotObservations
    ));
    assert!(matches!(
        folder.open("nothing.csv", Need::Coordinates).unwrap_err().problem,
        Problem::Read(_)
    ));
    assert!(matches!(
        folder.open("", Need::Coordinates).unwrap_err().problem,
        Problem::NotARun
    ));
}
