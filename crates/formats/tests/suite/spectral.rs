//! Spectral files as they come: every legal variant right, every damage told at its line.

use isolux_formats::spectral::SpectrumFile;
use isolux_formats::{
    Content, Finding, Format, Parsed, ReadOptions, Severity, read_any, read_any_with, write_spectrum,
};
use proptest::prelude::*;

fn read(bytes: &[u8], name: &str) -> Parsed<Content> {
    let mut all = read_any(bytes, name);
    assert_eq!(all.len(), 1, "{name}");
    all.remove(0)
}

fn spectrum(text: &str, name: &str) -> (SpectrumFile, Vec<Finding>) {
    let parsed = read(text.as_bytes(), name);
    match parsed.document {
        Some(Content::Spectrum(file)) => (*file, parsed.findings),
        _ => panic!("{name}: not read: {:#?}", parsed.findings),
    }
}

fn finding(text: &str, name: &str, code: &str) -> Finding {
    let parsed = read(text.as_bytes(), name);
    parsed
        .findings
        .iter()
        .find(|f| f.code == code)
        .cloned()
        .unwrap_or_else(|| panic!("{name}: no {code} in {:#?}", parsed.findings))
}

/// A refusal: nothing is handed on, an error says why, at this line.
fn refused(text: &str, name: &str, code: &str, line: usize) {
    let parsed = read(text.as_bytes(), name);
    assert!(parsed.document.is_none(), "{name} was read:\n{text}");
    let found = parsed
        .findings
        .iter()
        .any(|f| f.code == code && f.line == Some(line) && f.severity == Severity::Error);
    assert!(found, "{name}: no {code} at line {line} in {:#?}", parsed.findings);
}

fn points(text: &str, name: &str) -> Vec<(f64, f64)> {
    let (file, _) = spectrum(text, name);
    file.wavelength_nm.iter().copied().zip(file.value).collect()
}

const THREE: [(f64, f64); 3] = [(380.0, 0.5), (385.0, 1.25), (390.0, -0.25)];

#[test]
fn every_way_to_write_three_points() {
    for (name, text) in [
        ("a.csv", "wavelength_nm,value\n380,0.5\n385,1.25\n390,-0.25\n"),
        (
            "b.csv",
            "Wavelength (nm), Relative Intensity (%)\r\n380.0,0.5\r\n385.0,1.25\r\n390.0,-0.25\r\n",
        ),
        ("c.csv", "Wellenlänge [nm];Wert\n380;0,5\n385;1,25\n390;-0,25\n"),
        ("d.csv", "380\t0,5\n385\t1,25\n390\t-0,25\n"),
        ("e.csv", "380 0.5\n385 1.25\n390 -0.25\n"),
        (
            "f.csv",
            "\u{feff}\"nm\",\"W/m2\"\n\"380\",\"0.5\"\n\"385\",\"1.25\"\n\"390\",\"-0.25\"\n",
        ),
        (
            "g.csv",
            "Device: X 1\nDate: 2020-01-01\n\nlambda;E\n380;0.5;\n385;1.25;\n390;-0.25;\n",
        ),
        (
            "h.csv",
            "# a comment, with commas\n# wavelength,value\n380,0.5\n385,1.25\n390,-0.25\n",
        ),
        ("i.csv", ",wavelength,value\n0,380,0.5\n1,385,1.25\n2,390,-0.25\n"),
        ("j.csv", "Wavelength (µm),v\n0.380,0.5\n0.385,1.25\n0.390,-0.25\n"),
        ("k.csv", "390,-0.25\n385,1.25\n380,0.5\n"),
        ("l.csv", "380nm;0.5\n385nm;1.25\n390nm;-0.25\n"),
        ("m.spd", "# pbrt\n380 0.5 385 1.25\n390 -0.25 # end\n"),
        ("n.spd", "380 0.5\r385 1.25\r390 -0.25\r"),
        ("o.spd", "380,0.5\n385,1.25\n390,-0.25\n"),
        (
            "p.spectrum",
            "OPTIS - Spectrum file v1\nthing\n3\n380\t0.5\n385\t1.25\n390\t-0.25\n",
        ),
        (
            "q.spectrum",
            "OPTIS - Spectrum fie v1.0\r\n\r\n3\r\n380 0.5\r\n385 1.25\r\n390 -0.25\r\n",
        ),
        (
            "r.sp",
            "SPECT  \n\nKEYWORD \"SPECTRAL_BANDS\"\nSPECTRAL_BANDS \"3\"\nSPECTRAL_START_NM \"380.0\"\nSPECTRAL_END_NM \"390.0\"\n\
             NUMBER_OF_FIELDS 3\nBEGIN_DATA_FORMAT\nSPEC_380 SPEC_385 SPEC_390\nEND_DATA_FORMAT\nNUMBER_OF_SETS 1\nBEGIN_DATA\n\
             0.5 1.25 -0.25\nEND_DATA\n",
        ),
        (
            "s.sp",
            "CGATS.17\nNUMBER_OF_FIELDS\t4\nBEGIN_DATA_FORMAT\nSAMPLE_ID\tnm380\tnm385\tnm390\nEND_DATA_FORMAT\nNUMBER_OF_SETS\t1\n\
             BEGIN_DATA\n1\t0,5\t1,25\t-0,25\nEND_DATA\n",
        ),
        (
            "t.spdx",
            "<?xml version=\"1\"?>\n<IESTM2714 xmlns=\"http://www.ies.org/iestm2714\" version=\"1.0\"><Header><Description>x &amp; y</Description>\
             </Header><SpectralDistribution><SpectralQuantity>relative</SpectralQuantity>\n<SpectralData wavelength=\"380.0\">0.5</SpectralData>\n\
             <SpectralData wavelength=\"385\">1.25</SpectralData><SpectralData wavelength='390'> -0.25 </SpectralData></SpectralDistribution></IESTM2714>",
        ),
        (
            "u.txt",
            "Data from x.txt Node\n\nDate: Mon\nIntegration Time (sec): 1,0E-1\nNumber of Pixels in Spectrum: 3\n>>>>>Begin Spectral Data<<<<<\n\
             380,000\t0,5\n385,000\t1,25\n390,000\t-0,25\n>>>>>End Spectral Data<<<<<\n",
        ),
        (
            "v.txt",
            "SpectraSuite Data File\n++++\nXAxis mode: Wavelengths\n>>>>>Begin Processed Spectral Data<<<<<\n380\t0.5\n385\t1.25\n390\t-0.25\n",
        ),
    ] {
        assert_eq!(points(text, name), THREE, "{name}");
        let errors = spectrum(text, name)
            .1
            .into_iter()
            .filter(|f| f.severity == Severity::Error)
            .count();
        assert_eq!(errors, 0, "{name}");
    }
}

#[test]
fn wave_numbers_become_wavelengths_with_a_note() {
    let text = "Wavenumber (1/cm);A\n20000;1\n25000;2\n";
    assert_eq!(points(text, "x.csv"), [(400.0, 2.0), (500.0, 1.0)]);
    assert_eq!(
        finding(text, "x.csv", "spectrum-axis-converted").severity,
        Severity::Note
    );
}

fn near(found: &[(f64, f64)], expected: &[(f64, f64)]) -> bool {
    found.len() == expected.len()
        && found
            .iter()
            .zip(expected)
            .all(|(a, b)| (a.0 - b.0).abs() < 1e-9 * b.0 && (a.1 - b.1).abs() <= 1e-12 * b.1.abs())
}

#[test]
fn values_per_micrometre_or_wave_number_follow_their_abscissa() {
    let micrometres = "wavelength_um,irradiance W/m2/um\n0.5,1000\n0.6,2000\n0.7,3000\n";
    assert!(near(
        &points(micrometres, "a.csv"),
        &[(500.0, 1.0), (600.0, 2.0), (700.0, 3.0)]
    ));
    let note = finding(micrometres, "a.csv", "spectrum-values-converted");
    assert_eq!(note.severity, Severity::Note);
    let (file, _) = spectrum(
        "wavelength [µm];irradiance [W m-2 µm-1]\n0.5;1000\n0.6;2000\n0.7;3000\n",
        "a.csv",
    );
    assert_eq!((file.value[0], file.unit.as_deref()), (1.0, Some("W m-2 nm-1")));

    // 1 W/(m²·sr) per 1/cm at 20 000 1/cm: dν = 10⁷/λ² dλ = 40 1/cm a nm at 500 nm.
    let numbers = "wavenumber_1/cm,radiance W/m2/sr/cm-1\n12500,1\n16000,1\n20000,1\n";
    assert!(near(
        &points(numbers, "a.csv"),
        &[(500.0, 40.0), (625.0, 25.6), (800.0, 15.625)]
    ));

    let unsaid = finding(
        "wavelength_um,irradiance\n0.5,1\n0.6,2\n0.7,3\n",
        "a.csv",
        "spectrum-values-per",
    );
    assert_eq!(unsaid.severity, Severity::Warning);
    for ratio in [
        "wavelength_um,reflectance\n0.5,1\n0.6,2\n0.7,3\n",
        "wavelength_um,irradiance W/m2/nm\n0.5,1\n0.6,2\n0.7,3\n",
        "wavelength_nm,irradiance\n500,1\n600,2\n700,3\n",
    ] {
        let (file, findings) = spectrum(ratio, "a.csv");
        assert_eq!(file.value, [1.0, 2.0, 3.0]);
        assert!(
            !findings.iter().any(|f| f.code.starts_with("spectrum-values")),
            "{ratio}"
        );
    }
}

#[test]
fn the_spectrum_is_read_before_what_it_was_computed_from() {
    let jaz = |processed: [&str; 3]| {
        let rows: Vec<String> = [500, 600, 700]
            .iter()
            .zip(processed)
            .map(|(nm, p)| format!("{nm}\t803.8\t0\t80{nm}\t{p}\n"))
            .collect();
        let rows = rows.concat();
        format!(
            "Jaz Data File\n>>>>>Begin Processed Spectral Data<<<<<\nW\tD\tR\tS\tP\n{rows}>>>>>End Processed Spectral Data<<<<<\n"
        )
    };
    let whole = jaz(["0.1", "0.2", "0.3"]);
    assert_eq!(points(&whole, "jaz.txt"), [(500.0, 0.1), (600.0, 0.2), (700.0, 0.3)]);
    assert_eq!(finding(&whole, "jaz.txt", "csv-column-chosen").severity, Severity::Note);
    let raw = jaz(["0", "0", "0"]);
    assert_eq!(points(&raw, "jaz.txt")[0], (500.0, 80500.0));
    assert_eq!(
        finding(&raw, "jaz.txt", "csv-column-chosen").severity,
        Severity::Warning
    );

    let pixels = "pixel;Wavelength [nm];Counts;Irradiance [W/m2/nm]\n0;500;90;0.1\n1;600;91;0.2\n2;700;92;0.3\n";
    let (file, _) = spectrum(pixels, "pix.csv");
    assert_eq!(file.value, [0.1, 0.2, 0.3]);
    assert_eq!(
        (file.quantity.as_deref(), file.unit.as_deref()),
        (Some("irradiance"), Some("W/m2/nm"))
    );
    // Several of one kind keep their order.
    let two = "wavelength_nm,irradiance left,irradiance right\n500,1,4\n600,2,5\n700,3,6\n";
    assert_eq!(points(two, "a.csv")[0], (500.0, 1.0));
}

#[test]
fn no_wavelength_no_spectrum() {
    for heading in ["Frequency (Hz)", "m/z", "Shift (ppm)", "Time (s)"] {
        let text = format!("{heading},value\n100,1\n200,2\n300,3\n");
        let parsed = read(text.as_bytes(), "x.csv");
        assert!(parsed.document.is_none(), "{heading}");
        assert!(
            parsed.findings.iter().any(|f| f.code == "spectrum-no-wavelength"),
            "{heading}"
        );
    }
    let jcamp = "##TITLE= x\n##JCAMP-DX= 4.24\n##XUNITS= HZ\n##XYDATA= (X++(Y..Y))\n1 2 3\n##END=\n";
    refused(jcamp, "x.jdx", "jcamp-refused", 3);
}

#[test]
fn several_series() {
    let (file, _) = spectrum("nm;red;green\n380;1;2\n385;3;\n390;5;6\n", "x.csv");
    assert_eq!(file.value, [1.0, 3.0, 5.0]);
    assert_eq!(file.series[1].name, "green");
    assert_eq!(file.series[1].value, [Some(2.0), None, Some(6.0)]);
    assert!(file.to_json()["series"][1]["value"][1].is_null());
    let wide = "name,380,385,390,395,400,405,410,415,420,425\nred,1,2,3,4,5,6,7,8,9,10\nblue,2,3,4,5,6,7,8,9,10,11\n";
    let (file, _) = spectrum(wide, "x.csv");
    assert_eq!((file.wavelength_nm[9], file.value[9]), (425.0, 10.0));
    assert_eq!(file.series[1].name, "blue");
}

#[test]
fn damage_is_reported_at_its_line() {
    refused("nm,v\n380,1\n38S,2\n390,3\n", "x.csv", "csv-number", 3);
    refused("nm,v\n38O,1\n385,2\n390,3\n", "x.csv", "csv-number", 2);
    refused("38O,1\n385,2\n390,3\n395,4\n400,5\n", "x.csv", "csv-number", 1);
    refused("nm,v\nO80,1\n385,2\n390,3\n", "x.csv", "csv-number", 2);
    refused("nm,v\n380,1\nO85,2\n390,3\n", "x.csv", "csv-number", 3);
    refused("nm,v\n380,1\n385,NaN\n390,3\n", "x.csv", "csv-number", 3);
    refused("nm,v\n380,1\n385,1e300\n390,3\n", "x.csv", "csv-number", 3);
    refused("nm,v\n380,1\n385\n390,3\n", "x.csv", "csv-cells", 3);
    refused("nm,v\n380,1\n385,\n390,3\n", "x.csv", "csv-number", 3);
    refused("nm,v\n380,1\n385,2,7\n390,3\n", "x.csv", "csv-cells", 3);
    refused(
        "nm,v\n380,1\n390,3\n385,2\n395,4\n400,4\n",
        "x.csv",
        "spectrum-order",
        4,
    );
    refused("380 1\n385\n390 3\n395 4\n", "x.spd", "csv-cells", 2);
    refused(
        "OPTIS - Spectrum file v1.0\nd\n2\n380 1\n390 x\n",
        "x.spectrum",
        "speos-number",
        5,
    );
    let spdx = |body: &str| {
        format!(
            "<?xml version=\"1.0\"?>\n<IESTM2714 xmlns=\"iestm2714\" version=\"1.0\">\n<SpectralDistribution>\n\
             <SpectralQuantity>flux</SpectralQuantity>\n{body}\n</SpectralDistribution>\n</IESTM2714>\n"
        )
    };
    let row = |w: &str, v: &str| format!("<SpectralData wavelength=\"{w}\">{v}</SpectralData>");
    refused(
        &spdx(&[row("380", "1"), row("385", "2O")].join("\n")),
        "x.spdx",
        "spdx-number",
        6,
    );
    refused(
        &spdx("<SpectralData wavelength=\"380\">1</SpectralDat>"),
        "x.spdx",
        "spdx-xml",
        5,
    );
    let whole = spdx(&row("380", "1"));
    refused(
        &whole[..whole.find("</SpectralDistribution>").unwrap()],
        "x.spdx",
        "spdx-xml",
        5,
    );
    refused("<?xml version=\"1.0\"?>\n<item></item>\n", "x.spdx", "spdx-root", 2);
}

#[test]
fn what_is_assumed_is_said() {
    let even = |skip: f64| {
        let rows: Vec<String> = (0..70)
            .map(|i| 380.0 + 5.0 * f64::from(i))
            .filter(|w| *w != skip)
            .map(|w| format!("{w},{}\n", w / 100.0))
            .collect();
        format!("nm,v\n{}", rows.concat())
    };
    assert!(read(even(0.0).as_bytes(), "x.csv").findings.is_empty());
    assert_eq!(finding(&even(425.0), "x.csv", "spectrum-gap").line, Some(11));
    let again = even(0.0).replace("400,4\n", "400,4\n400,4\n");
    assert_eq!(finding(&again, "x.csv", "spectrum-wavelength-repeated").line, Some(7));
    let cut = "nm,v\n380,1.25\n385,2.25\n390,2.5";
    assert_eq!(finding(cut, "x.csv", "text-unfinished").line, Some(4));
    let whole = "nm,v\n380,1.25\n385,2.25\n390,2.50";
    assert!(read(whole.as_bytes(), "x.csv").findings.is_empty());
    let counted = "OPTIS - Spectrum file v1.0\nd\n4\n380 1\n385 2\n390 3\n";
    assert_eq!(finding(counted, "x.spectrum", "speos-count").severity, Severity::Error);
    let bare = "0.380 1\n0.385 2\n0.390 3\n";
    assert_eq!(
        finding(bare, "x.spd", "spectrum-axis-unit").assumed.as_deref(),
        Some("µm")
    );
    let cut: String = even(0.0).split_inclusive('\n').take(40).collect();
    assert_eq!(finding(&cut, "x.csv", "spectrum-range").line, Some(40));
    let outlier = even(0.0).replace("400,4\n", "400,40000\n");
    assert_eq!(finding(&outlier, "x.csv", "spectrum-outlier").line, Some(6));
}

#[test]
fn jcamp_over_wavelength_is_read_with_its_checks() {
    let file = |table: &str, unit: &str| {
        format!(
            "##TITLE= x\n##JCAMP-DX= 4.24 $$ y\n##DATA TYPE= UV/VIS SPECTRUM\n##XUNITS= {unit}\n##YUNITS= ABSORBANCE\n\
             ##XFACTOR= 1\n##YFACTOR= 0.5\n##FIRSTX= 400\n##LASTX= 450\n##NPOINTS= 6\n##XYDATA= (X++(Y..Y))\n{table}\n##END=\n"
        )
    };
    let good = file("400A2JT\n430A4jj", "NANOMETERS");
    let expected = [
        (400.0, 6.0),
        (410.0, 6.5),
        (420.0, 7.0),
        (430.0, 7.0),
        (440.0, 6.5),
        (450.0, 6.0),
    ];
    // The second line repeats the last ordinate of the first as its check, so 420 is its place.
    let checked = good.replace("430A4jj", "420A4%jj");
    assert_eq!(points(&checked, "x.jdx"), expected);
    assert_eq!(
        finding(&checked.replace("420A4", "420A9"), "x.jdx", "jcamp-check").line,
        Some(13)
    );
    assert_eq!(
        finding(&checked.replace("420A4", "440A4"), "x.jdx", "jcamp-abscissa").line,
        Some(13)
    );
    assert_eq!(
        finding(&checked.replace("NPOINTS= 6", "NPOINTS= 7"), "x.jdx", "jcamp-points").line,
        Some(10)
    );
    refused(checked.trim_end().trim_end_matches("##END="), "x.jdx", "jcamp-end", 13);
    refused(&checked.replace("A2JT", "A2J?"), "x.jdx", "jcamp-number", 12);
    let numbers = file("20000 1 2 3 4 5 6", "1/CM")
        .replace("400", "20000")
        .replace("450", "25000");
    assert_eq!(points(&numbers, "x.jdx").last(), Some(&(500.0, 0.5)));
    refused(&file("400 1 2 3 4 5 6", "HZ"), "x.jdx", "jcamp-refused", 4);
}

#[test]
fn vendors_texts() {
    let sekonic = "Title,x\nTcp [K],3262\nSpectral Data 380[nm],0.1\nSpectral Data 480[nm],0.2\nSpectral Data 580[nm],0.3\n\n\
        Spectral Data 380[nm],0.1\nSpectral Data 381[nm],0.2\nSpectral Data 382[nm],0.3\nSpectral Data 383[nm],0.4\n\nbin1,0.9,0.2\n";
    assert_eq!(points(sekonic, "x.csv").last(), Some(&(383.0, 0.4)));
    assert_eq!(finding(sekonic, "x.csv", "csv-blocks").line, Some(7));
    let two = "[nm],,\n380,1,2\n385,2,3\n390,3,4\nIrradiance [E],\nTime,a,b\n[nm],\n380,5,6\n385,7,8\n390,7,8\n";
    let (file, findings) = spectrum(two, "x.csv");
    assert_eq!(file.value, [1.0, 2.0, 3.0]);
    assert!(findings.iter().any(|f| f.code == "csv-blocks" && f.line == Some(5)));
    let numbered = "wavelength,1,2\n380,5,6\n385,7,8\n390,7,8\n";
    assert_eq!(spectrum(numbered, "x.csv").0.series[0].name, "1");
}

#[test]
fn what_a_program_could_not_compute_is_missing_in_a_further_series_and_damage_in_the_first() {
    let text = "W,D,P\n380,1,2\n381,3,NaN\n382,5,-inf\n383,7,4\n384,9,5\n";
    let (file, findings) = spectrum(text, "x.csv");
    assert_eq!(file.value, [1.0, 3.0, 5.0, 7.0, 9.0]);
    assert_eq!(file.series[1].value, [Some(2.0), None, None, Some(4.0), Some(5.0)]);
    let found: Vec<_> = findings.iter().filter(|f| f.code == "csv-nan").collect();
    assert_eq!(found.len(), 1, "one cause is one finding");
    assert_eq!((found[0].line, found[0].places()[0].line), (Some(3), Some(4)));
    refused("W,D,P\n380,1,2\n381,nan,4\n382,5,6\n", "x.csv", "csv-number", 3);
}

#[test]
fn columns_that_end_before_the_table_does_are_functions_with_an_end() {
    // As the CIE publishes its action spectra: NaN, or blanks, where a receptor has no value.
    for nothing in ["NaN", ""] {
        let rows = (0..41).fold(String::new(), |rows, k| {
            let short = if k < 25 {
                format!("0.{:03}", 900 - 30 * k)
            } else {
                nothing.to_owned()
            };
            rows + &format!("{},{short},0.{:03}\n", 380 + 10 * k, 100 + k)
        });
        let (file, findings) = spectrum(&format!("nm,sc,mc\n{rows}"), "x.csv");
        assert_eq!(file.wavelength_nm.len(), 41);
        // The one with a value at every wavelength is the one that is used.
        assert_eq!(
            (file.series[0].name.as_str(), file.series[1].name.as_str()),
            ("mc", "sc")
        );
        assert_eq!(file.series[1].value.iter().flatten().count(), 25);
        assert_eq!(
            finding(&format!("nm,sc,mc\n{rows}"), "x.csv", "csv-series-shorter").line,
            Some(27)
        );
        assert!(findings.iter().all(|f| f.severity == Severity::Note), "{findings:?}");
        // One value that is missing is damage.
        let damaged = rows.replacen(",0.105", ",NaN", 1);
        assert!(damaged != rows);
        let findings = read(format!("nm,sc,mc\n{damaged}").as_bytes(), "x.csv").findings;
        assert!(findings.iter().any(|f| f.severity > Severity::Note), "{findings:?}");
    }
}

#[test]
fn bins_have_their_middle_as_wavelength_and_their_end_is_no_value() {
    // As TUV writes them.
    let rows = (0..30).fold(String::new(), |rows, k| {
        rows + &format!(
            " {}.00     {}.00     0.{:03}  0.{:03}\n",
            280 + k,
            281 + k,
            100 + k,
            200 + k
        )
    });
    let text = format!(" LOWER WVL  UPPER WVL  DIRECT     DIFFUSE DOWN\n{rows}");
    let (file, findings) = spectrum(&text, "x.txt");
    assert_eq!((file.wavelength_nm[0], file.wavelength_nm[29]), (280.5, 309.5));
    assert_eq!(file.value[..2], [0.1, 0.101]);
    let names: Vec<&str> = file.series.iter().map(|series| series.name.as_str()).collect();
    assert_eq!(names, ["DIRECT", "DIFFUSE DOWN"]);
    assert!(findings.iter().any(|f| f.code == "csv-bins"));
    refused(
        &text.replacen("290.00     0.1", "29O.00     0.1", 1),
        "x.csv",
        "csv-number",
        11,
    );
}

#[test]
fn wavelengths_without_a_value_are_no_lost_lines() {
    let row = |k: usize| {
        let value = if (3..6).contains(&k) {
            "nan".to_owned()
        } else {
            format!("0.{k:03}")
        };
        format!("{}\t{value}\n", 300 + k)
    };
    let text = |count: usize| {
        let rows: String = (0..count).map(row).collect();
        format!("Number of Pixels in Spectrum: 40\n>>>>>Begin Spectral Data<<<<<\n{rows}>>>>>End Spectral Data<<<<<\n")
    };
    let codes = |text: &str| -> Vec<&str> {
        let found = read(text.as_bytes(), "x.txt").findings;
        found
            .iter()
            .filter(|f| f.severity > Severity::Note)
            .map(|f| f.code)
            .collect()
    };
    assert_eq!(codes(&text(40)), ["csv-nan"]);
    // A line that is really lost is still counted.
    assert_eq!(codes(&text(39)), ["csv-pixels", "csv-nan"]);
}

#[test]
fn a_damaged_spectrum_under_any_name_is_told_as_one() {
    let rows: Vec<String> = (0..30).map(|i| format!("{}\t{}\n", 400 + 10 * i, 30 - i)).collect();
    let text = format!("Wavelength (nm)\tpower\n{}", rows.concat()).replace("450\t25", "450\t2x5");
    refused(&text, "scan.txt", "csv-number", 7);
    let lost = rows.concat().replace("690\t1\n", "\t1\n");
    refused(&lost, "x.csv", "csv-number", 30);
}

#[test]
fn resampling_is_asked_for_and_told() {
    use isolux_formats::spectral::Interpolation;
    let rows: Vec<String> = (0..41).map(|i| format!("{},{}\n", 380 + 10 * i, i * i)).collect();
    let (file, _) = spectrum(&format!("nm,v\n{}", rows.concat()), "x.csv");
    let (fine, findings) = file.resampled(1.0, Interpolation::Sprague).unwrap();
    assert_eq!((fine.wavelength_nm.len(), fine.wavelength_nm[400]), (401, 780.0));
    // A square is kept by a polynomial of the fifth order.
    assert!((fine.value[25] - 6.25).abs() < 1e-9, "{}", fine.value[25]);
    assert!(fine.header["resampled"].as_str().unwrap().contains("sprague"));
    assert!(findings.iter().any(|f| f.code == "convert-resampled"));
    let mut uneven = file.clone();
    uneven.wavelength_nm[3] += 2.0;
    assert_eq!(
        uneven.resampled(1.0, Interpolation::Sprague).unwrap_err().code,
        "convert-resample"
    );
    assert!(uneven.resampled(1.0, Interpolation::Linear).is_ok());
    let (_, coarse) = file.resampled(20.0, Interpolation::Linear).unwrap();
    assert!(coarse.iter().any(|f| f.code == "convert-coarser"));
}

#[test]
fn a_comment_about_another_unit_does_not_move_the_numbers() {
    let rows: Vec<String> = (0..20).map(|i| format!("{} {i}\n", 400 + 10 * i)).collect();
    let text = format!("# Lambda (A)   n   k\n{}", rows.concat());
    let (file, findings) = spectrum(&text, "x.spd");
    assert_eq!(file.wavelength_nm[0], 400.0);
    assert!(
        findings
            .iter()
            .any(|f| f.code == "spectrum-axis-unit" && f.severity == Severity::Warning)
    );
    // What is written from a file in µm says nm, whatever its old header said.
    let text = format!("X Units: micrometers\nunit: mW/nm\n{}", rows.concat().replace(' ', ","))
        .replace("\n4", "\n0.4")
        .replace("\n5", "\n0.5");
    let (file, _) = spectrum(&text, "x.csv");
    assert_eq!((file.wavelength_nm[0], file.unit.as_deref()), (400.0, Some("mW/nm")));
    for (format, name) in WRITTEN {
        let bytes = write_spectrum(&file, format).unwrap().bytes;
        let (back, _) = spectrum(std::str::from_utf8(&bytes).unwrap(), name);
        assert_eq!(
            (&back.wavelength_nm, &back.value),
            (&file.wavelength_nm, &file.value),
            "{name}"
        );
    }
}

/// The code of the error for a table that is refused.
fn refusal(text: &str, name: &str) -> Option<&'static str> {
    let parsed = read(text.as_bytes(), name);
    assert!(parsed.document.is_none(), "{name}: {text}");
    let errors = parsed
        .findings
        .into_iter()
        .filter(|finding| finding.severity == Severity::Error);
    errors.map(|finding| finding.code).next()
}

#[test]
fn tables_of_something_else_are_no_spectra() {
    let rows = |from: f64, step: f64, columns: usize| -> String {
        (0..40).map(f64::from).fold(String::new(), |text, k| {
            let others = (1..columns).fold(String::new(), |text, n| {
                text + &format!(",{}", 0.5 + 0.01 * k * n as f64)
            });
            text + &format!("{}{others}\n", from + step * k)
        })
    };
    for (heading, table) in [
        ("temperature_k,resistance\n", rows(310.0, 20.0, 2)),
        ("price,quantity,x\n", rows(120.0, 3.0, 3)),
        ("PAR,power_w,level\n", rows(200.0, 25.0, 3)),
        ("pixel,red,nir\n", rows(300.0, 1.0, 3)),
        ("latitude,longitude,altitude\n", rows(400.0, 0.1, 3)),
        ("# position  error\n", rows(0.01, 0.02, 2)),
        ("", rows(0.01, 0.02, 2)),
        ("", rows(1.0, 1.0, 2)),
    ] {
        let text = format!("{heading}{table}");
        assert_eq!(refusal(&text, "table.csv"), Some("table-no-spectrum"), "{heading}");
        // A person who knows better says which columns they are.
        let options = ReadOptions {
            columns: Some([1, 2]),
            ..ReadOptions::default()
        };
        let forced = read_any_with(text.as_bytes(), "table.csv", options).remove(0);
        let Some(Content::Spectrum(file)) = forced.document else {
            assert!(
                heading.is_empty() || heading.starts_with('#'),
                "{heading}: {:?}",
                forced.findings
            );
            continue;
        };
        assert_eq!(file.value.len(), 40);
    }
}

#[test]
fn tables_that_are_spectra_are_read_under_every_name() {
    let rows: Vec<String> = (0..40)
        .map(|k| format!("{} {} {}\n", 400 + 5 * k, 0.5 + f64::from(k), f64::from(k)))
        .collect();
    let plain = rows.concat();
    for heading in ["", "# wavelength value dark\n", "# exported from the lab\n"] {
        let text = format!("{heading}{plain}");
        let as_csv = spectrum(&text, "x.csv").0;
        for name in ["x.txt", "x.dat"] {
            let file = spectrum(&text, name).0;
            assert_eq!(
                (&file.wavelength_nm, &file.value),
                (&as_csv.wavelength_nm, &as_csv.value),
                "{name} {heading}"
            );
        }
    }
    let commas = plain.replace(' ', ", ");
    let file = spectrum(&commas, "x.csv").0;
    assert_eq!((file.wavelength_nm[0], file.value[0]), (400.0, 0.5));
    let named = format!("wavelength, value, dark\n{commas}");
    let (file, findings) = spectrum(&named, "x.csv");
    assert_eq!(file.series[0].name, "value");
    assert!(findings.iter().all(|finding| finding.code != "csv-decimal-comma"));
    let footer = format!("{plain}\nLux\n276\n");
    let (file, findings) = spectrum(&footer, "x.txt");
    assert_eq!(file.value.len(), 40);
    assert!(findings.iter().any(|finding| finding.code == "csv-after-data"));
}

#[test]
fn jaz_takes_what_was_processed_with_and_without_a_reference() {
    let body = |columns: &str, row: &str| {
        let rows = (0..10).fold(String::new(), |text, k| text + &format!("{}\t{row}\n", 400 + k));
        format!(
            "Jaz Absolute Irradiance File\n>>>>>Begin Processed Spectral Data<<<<<\n{columns}\n{rows}>>>>>End Processed Spectral Data<<<<<\n"
        )
    };
    let without = body("W\tD\tS\tP", "1\t2\t3");
    assert_eq!(spectrum(&without, "x.JazIrrad").0.value, [3.0; 10]);
    let with = body("W\tD\tR\tS\tP", "1\t2\t3\t4");
    assert_eq!(spectrum(&with, "x.jaz").0.value, [4.0; 10]);
}

#[test]
fn what_a_program_could_not_compute_is_left_out_where_there_is_no_light() {
    let text = "nm,v\n300,nan\n340,1\n360,inf\n400,2\n440,3\n480,4\n900,nan\n";
    let (file, findings) = spectrum(text, "x.csv");
    assert_eq!(file.wavelength_nm, [340.0, 400.0, 440.0, 480.0]);
    let stated = findings.iter().find(|finding| finding.code == "csv-nan").unwrap();
    assert!(
        stated.severity == Severity::Warning && stated.message.starts_with("3 "),
        "{stated:?}"
    );
    assert_eq!(refusal(&text.replace("440,3", "440,nan"), "x.csv"), Some("csv-number"));
}

#[test]
fn macam_and_pairs_of_cgats() {
    let macam = "@19/5/1997\n@17:44:58\n#Glasshouse\n 4.0E+02\n 1.0E-01\n 4.01E+02\n 2.0E-01\n 4.02E+02\n 3.0E-01\n";
    for name in ["x.DTA", "x.DAT"] {
        assert_eq!(points(macam, name), [(400.0, 0.1), (401.0, 0.2), (402.0, 0.3)]);
    }
    let cut = macam.trim_end().rsplit_once('\n').unwrap().0;
    assert_eq!(refusal(cut, "x.DTA"), Some("macam-pairs"));
    let columns = "CGATS.17\nBEGIN_DATA_FORMAT\nSPECTRAL_NM SPECTRAL_VAL\nEND_DATA_FORMAT\nNUMBER_OF_SETS 3\nBEGIN_DATA\n\
                   400 0.1\n401 0.2\n402 0.3\nEND_DATA\n";
    assert_eq!(points(columns, "x.txt"), [(400.0, 0.1), (401.0, 0.2), (402.0, 0.3)]);
    let tabs = "CGATS.17\nNUMBER_OF_FIELDS\t4\nBEGIN_DATA_FORMAT\nSAMPLE_NAME\tnm400\tnm410\tnm420\nEND_DATA_FORMAT\n\
                BEGIN_DATA\ndark skin\t0.1\t0.2\t0.3\nEND_DATA\n";
    assert_eq!(spectrum(tabs, "x.txt").0.value, [0.1, 0.2, 0.3]);
}

#[test]
fn a_photometric_file_is_no_spectrum() {
    let parsed = read(b"some\ntext\nof no kind\n", "x.txt");
    assert!(parsed.document.is_none());
}

const WRITTEN: [(Format, &str); 6] = [
    (Format::SPDX, "x.spdx"),
    (Format::SPD, "x.spd"),
    (Format::SP, "x.sp"),
    (Format::SPECTRUM, "x.spectrum"),
    (Format::CSV, "x.csv"),
    (Format::JSON, "x.json"),
];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn every_format_keeps_every_bit(
        start in 200.0..500.0f64,
        steps in prop::collection::vec(0.01..20.0f64, 3..60),
        scale in -8i32..8,
        seed in prop::collection::vec(0.0..1.0f64, 60),
    ) {
        let mut nm = vec![start];
        for step in steps { nm.push(nm[nm.len() - 1] + step); }
        let value: Vec<f64> = seed.iter().take(nm.len()).map(|v| v * 10f64.powi(scale)).collect();
        nm.truncate(value.len());
        let spectrum = isolux_spectrum::Spectrum::new(nm.clone(), value.clone()).unwrap();
        let file = SpectrumFile::new(&spectrum, Some("irradiance"), Some("W/(m2.nm)"));
        for (format, name) in WRITTEN {
            let bytes = write_spectrum(&file, format).unwrap().bytes;
            let parsed = read(&bytes, name);
            let Some(Content::Spectrum(back)) = parsed.document else {
                panic!("{name}: {:#?}\n{}", parsed.findings, String::from_utf8_lossy(&bytes));
            };
            prop_assert_eq!(&back.value, &value, "{}", name);
            prop_assert_eq!(&back.wavelength_nm, &nm, "{}", name);
        }
    }

    #[test]
    fn no_bytes_panic(bytes in prop::collection::vec(any::<u8>(), 0..300), which in 0usize..9) {
        let name = ["x.spdx", "x.spd", "x.sp", "x.spectrum", "x.csv", "x.txt", "x.jdx", "x.json", "x"][which];
        let _ = read_any(&bytes, name);
    }

    #[test]
    fn no_damage_panics(at in 0usize..600, byte in any::<u8>(), cut in 0usize..900, which in 0usize..5) {
        let nm: Vec<f64> = (0..12).map(|i| 380.0 + 5.0 * f64::from(i)).collect();
        let value = nm.iter().map(|w| w / 700.0).collect();
        let spectrum = isolux_spectrum::Spectrum::new(nm, value).unwrap();
        let (format, name) = WRITTEN[which];
        let file = SpectrumFile::new(&spectrum, Some("flux"), None);
        let mut bytes = write_spectrum(&file, format).unwrap().bytes;
        if let Some(b) = bytes.get_mut(at) { *b = byte; }
        bytes.truncate(cut);
        let _ = read_any(&bytes, name);
    }
}
