//! Certificates that can be used, and every kind of one that cannot.

use super::*;

const CERTIFICATE: &str = "format = \"isolux-standard/1\"
[lamp]
designation = \"FEL 1000 W\"
number = \"F-123\"
[certificate]
number = \"C 1\"
laboratory = \"L\"
issued = \"2026-01-15\"
expires = \"2027-01-15\"
[conditions]
current_a = 8.2
current_tolerance_a = 0.002
reference_plane = \"the posts\"
u_alignment_deg = 0.2
[spectral_irradiance]
distance_mm = 500.0
table = \"t.csv\"
u_scale_rel = 0.004
u_temperature_rel = 0.0005
[illuminance]
distance_mm = 2000.0
illuminance_lx = 300.0
u_rel = 0.005
colour_temperature_k = 2856
";

const TABLE: &str = "# F-123
wavelength_nm,irradiance_w_m2_nm,u_rel
350,0.01,0.006
400,0.02,0.005
500,0.08,0.005
600,0.15,0.005
700,0.21,0.005
800,0.24,0.005
";

fn parse(text: &str, table: &str) -> Result<Standard, StandardError> {
    let read = |name: &str| match name {
        "t.csv" => Ok(table.to_owned()),
        _ => Err("no such file".to_owned()),
    };
    Standard::parse(Utf8Path::new("lamps/c.toml"), text, &read)
}

#[test]
fn a_certificate_has_its_values_and_a_hash_of_both_files() {
    let standard = parse(CERTIFICATE, TABLE).unwrap();
    let (spectral, rows) = standard.spectral().unwrap();
    assert_eq!(
        (spectral.distance_mm, rows.len(), rows[3].irradiance_w_m2_nm),
        (500.0, 6, 0.15)
    );
    assert_eq!(standard.illuminance().unwrap().illuminance_lx, 300.0);
    assert_eq!(standard.name(), "FEL 1000 W F-123, certificate C 1 of L");
    for changed in [
        parse(CERTIFICATE, &TABLE.replace("0.15,", "0.151,")),
        parse(&CERTIFICATE.replace("8.2", "8.1"), TABLE),
    ] {
        assert_ne!(changed.unwrap().sha256(), standard.sha256());
    }
    let lux = CERTIFICATE.replace("[spectral_irradiance]\ndistance_mm = 500.0\ntable = \"t.csv\"\n", "");
    let lux = lux.replace("u_scale_rel = 0.004\nu_temperature_rel = 0.0005\n", "");
    assert!(parse(&lux, "").unwrap().spectral().is_none());
}

#[test]
fn what_no_certificate_says_is_refused_with_its_line() {
    for (from, to, expected) in [
        ("isolux-standard/1", "isolux-plan/1", "lamps/c.toml:1:10"),
        (
            "current_a = 8.2\n",
            "current_a = -8.2\n",
            "lamps/c.toml:11:1: conditions.current_a: is -8.2",
        ),
        ("current_a = 8.2\n", "", "missing field `current_a`"),
        (
            "tolerance_a = 0.002",
            "tolerance_a = 0.2",
            "lamps/c.toml:12:1: conditions.current_tolerance_a: is 0.2",
        ),
        (
            "2027-01-15",
            "2025-01-15",
            "lamps/c.toml:9:1: certificate.expires: 2025-01-15 is before",
        ),
        ("2027-01-15", "15.1.2027", "is no day, write YYYY-MM-DD"),
        ("\"L\"", "\" \"", "lamps/c.toml:7:1: certificate.laboratory: is empty"),
        ("\"L\"", "\"L\\nM\"", "more than one line"),
        (
            "u_alignment_deg = 0.2",
            "u_alignment_deg = nan",
            "lamps/c.toml:14:1: conditions.u_alignment_deg",
        ),
        (
            "distance_mm = 500.0",
            "distance_mm = 0.5",
            "lamps/c.toml:16:1: spectral_irradiance.distance_mm",
        ),
        (
            "\"t.csv\"",
            "\"u.csv\"",
            "lamps/c.toml:17:1: spectral_irradiance.table: names u.csv: no such file",
        ),
        (
            "u_scale_rel = 0.004",
            "u_scale_rel = 0.6",
            "lamps/c.toml:18:1: spectral_irradiance.u_scale_rel",
        ),
        ("u_scale_rel = 0.004\n", "", "missing field `u_scale_rel`"),
        (
            "u_temperature_rel = 0.0005",
            "u_temperature_rel = 0.5",
            "spectral_irradiance.u_temperature_rel: is 0.5",
        ),
        (
            "illuminance_lx = 300.0",
            "illuminance_lx = 0.0",
            "lamps/c.toml:22:1: illuminance.illuminance_lx",
        ),
        ("u_rel = 0.005", "u_rel = 0.0", "lamps/c.toml:23:1: illuminance.u_rel"),
        (
            "= 2856",
            "= 6500",
            "lamps/c.toml:24:1: illuminance.colour_temperature_k: is 6500",
        ),
    ] {
        assert!(CERTIFICATE.contains(from), "{from}");
        let error = parse(&CERTIFICATE.replace(from, to), TABLE).unwrap_err().to_string();
        assert!(error.contains(expected), "{to}: {error}");
    }
}

#[test]
fn a_damaged_table_is_refused_with_its_line() {
    for (from, to, expected) in [
        (
            "irradiance_w_m2_nm,",
            "irradiance,",
            "lamps/t.csv:1: column `irradiance_w_m2_nm` is missing",
        ),
        ("400,0.02", "340,0.02", "lamps/t.csv:4: "),
        ("400,0.02", "400,-0.02", "lamps/t.csv:4: "),
        ("400,0.02", "400,0,02", "lamps/t.csv:4: "),
        ("400,0.02", "400,zero", "lamps/t.csv:4: "),
        ("0.02,0.005", "0.02,5", "a fraction up to 0.5"),
        ("0.02,0.005", "0.02,0.003", "at least u_scale_rel"),
        ("0.02,0.005", "0.02,", "lamps/t.csv:4: "),
        ("800,0.24,0.005\n", "", "six wavelengths"),
    ] {
        assert!(TABLE.contains(from), "{from}");
        let error = parse(CERTIFICATE, &TABLE.replace(from, to)).unwrap_err().to_string();
        assert!(error.contains(expected), "{to}: {error}");
    }
}
