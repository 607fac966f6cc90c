//! What readers allocate: a small multiple of the file, whatever it claims to hold.
//!
//! Every allocation of this process goes through a counter. The bound is a multiple of the file plus a constant, which
//! is room for the tables that a reader needs and for the full circle of a symmetric file (`LARGEST_GRID`).

#![expect(clippy::print_stdout, reason = "the largest ratios are what a person runs this for")]

use std::io::Write as _;
use std::path::Path;

use isolux_allocation::Counting;
use isolux_formats::read_any;

#[global_allocator]
static COUNTING: Counting = Counting;

/// Bytes of the file that one allocated byte may stand for, and what any file may take.
const MULTIPLE: usize = 20;
const CONSTANT: usize = 16 * 1024 * 1024;
/// For files that claim no more than they hold.
const SMALL: usize = 256 * 1024;

/// The most that was allocated at a time while `bytes` were read.
fn peak(bytes: &[u8], name: &str) -> usize {
    isolux_allocation::most(|| read_any(bytes, name)).1
}

struct Seeded(u64);

impl Seeded {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }
}

const NAMES: [&str; 12] = [
    "x.ldt",
    "x.ies",
    "x.xml",
    "x.gldf",
    "x.csv",
    "x.spdx",
    "x.spd",
    "x.sp",
    "x.spectrum",
    "x.txt",
    "x.jdx",
    "x.json",
];

/// Headers that every reader takes for its own.
const HEADS: [&str; 11] = [
    "",
    "IESNA:LM-63-2002\nTILT=NONE\n",
    "IESNA:LM-63-2002\nTILT=INCLUDE\n1\n",
    "<IESTM33-22><Emitter>",
    "<IESTM2714 xmlns=\"iestm2714\"><SpectralDistribution>",
    "gamma_deg,intensity_cd\n",
    "wavelength_nm,value\n",
    "OPTIS - Spectrum file v1.0\nx\n",
    "SPECT\nNUMBER_OF_SETS 1\nBEGIN_DATA\n",
    "##TITLE=x\n##XUNITS=NANOMETERS\n##XYDATA=(X++(Y..Y))\n",
    "PK\u{3}\u{4}",
];

/// Files whose counts promise far more than they hold.
fn boasts() -> Vec<(&'static str, Vec<u8>)> {
    let ldt = |isym: &str, mc: &str, ng: &str, sets: &str| {
        let mut lines = vec!["0"; 60];
        lines[2..7].copy_from_slice(&[isym, mc, "0", ng, "0"]);
        lines[25] = sets;
        lines[28] = "1000";
        lines.join("\n").into_bytes()
    };
    let mut all = Vec::new();
    for (mc, ng, sets) in [
        ("1000000000", "1000000000", "1"),
        ("100000", "100000", "1"),
        ("24", "37", "1000000000"),
        ("100000", "2", "100000"),
    ] {
        for isym in ["0", "1", "2", "3", "4"] {
            all.push(("x.ldt", ldt(isym, mc, ng, sets)));
        }
    }
    for numbers in [
        "1 1000 1 1000000000 1000000000 1 2 0 0 0\n1 1 10\n0 45 90\n0\n1 2 3\n",
        "1 1000 1 100000 100000 1 2 0 0 0\n1 1 10\n0 45 90\n0\n1 2 3\n",
        "1 1000 1 2 2 2 2 0 0 0\n1 1 10\n0 0.0001\n0 0.0001\n1 2 3 4\n",
        "1 1000 1 3 2 3 2 0 0 0\n1 1 10\n-90 89.9999 90\n0 90\n1 2 3 4 5 6\n",
    ] {
        all.push(("x.ies", format!("IESNA:LM-63-2002\nTILT=NONE\n{numbers}").into_bytes()));
    }
    all.push((
        "x.ies",
        b"IESNA91\nTILT=INCLUDE\n1\n1000000000\n0 1 2\n1 1 1\n1 1000 1 2 1 1 2 0 0 0\n".to_vec(),
    ));
    for text in [
        "OPTIS - Spectrum file v1.0\nx\n1000000000\n400\t1\n500\t1\n",
        "SPECT\nSPECTRAL_BANDS \"1000000000\"\nSPECTRAL_START_NM \"380\"\nSPECTRAL_END_NM \"780\"\nNUMBER_OF_FIELDS 1000000000\nNUMBER_OF_SETS 1000000000\nBEGIN_DATA\n1 2 3\nEND_DATA\n",
        "##TITLE=x\n##XUNITS=NANOMETERS\n##YUNITS=COUNTS\n##NPOINTS=1000000000\n##FIRSTX=400\n##LASTX=800\n##DELTAX=0.0000001\n##XYDATA=(X++(Y..Y))\n400 1 2 3\n##END=\n",
        "<IESTM33-22><Emitter><LuminousData><NumberHorz>1000000000</NumberHorz><NumberVert>1000000000</NumberVert><IntensityData horz=\"0\" vert=\"0\">1</IntensityData></LuminousData></Emitter></IESTM33-22>",
    ] {
        all.extend(NAMES.iter().map(|&name| (name, text.as_bytes().to_vec())));
    }
    all
}

/// A container whose one photometry unpacks to `size` bytes of zeros and line ends.
fn bomb(size: usize) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    archive
        .start_file("ldc/a.ldt", zip::write::SimpleFileOptions::default())
        .unwrap();
    archive.write_all(&b"0\n".repeat(size / 2)).unwrap();
    archive.finish().unwrap().into_inner()
}

#[test]
fn readers_allocate_a_small_multiple_of_the_file() {
    let mut seeded = Seeded(7);
    let mut worst = (0, String::new());
    let mut within = |bytes: &[u8], name: &str, what: &str, constant: usize| {
        let most = peak(bytes, name);
        if most > worst.0 {
            worst = (most, format!("{what} as {name}, a file of {} bytes", bytes.len()));
        }
        assert!(
            most <= MULTIPLE * bytes.len() + constant,
            "{what} as {name}: {most} bytes allocated for a file of {}",
            bytes.len()
        );
    };
    for (name, bytes) in boasts() {
        within(&bytes, name, "boast", CONSTANT);
    }
    for name in NAMES {
        for head in HEADS {
            for _ in 0..3 {
                let length = (seeded.next() % 20_000) as usize;
                let digits = b"0123456789.,- \t\n\r;<>\"=/#eE";
                let any: Vec<u8> = (0..length).map(|_| seeded.next() as u8).collect();
                let numeric: Vec<u8> = (0..length)
                    .map(|_| digits[seeded.next() as usize % digits.len()])
                    .collect();
                for body in [any, numeric] {
                    within(&[head.as_bytes(), &body].concat(), name, "arbitrary bytes", SMALL);
                }
            }
        }
    }
    let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    for folder in ["good", "golden"] {
        for entry in std::fs::read_dir(tests.join(folder)).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            let bytes = std::fs::read(&path).unwrap();
            within(&bytes, &name, "golden", SMALL);
            for _ in 0..20 {
                let mut damaged = bytes.clone();
                for _ in 0..=(seeded.next() % 4) {
                    if damaged.is_empty() {
                        break;
                    }
                    let at = seeded.next() as usize % damaged.len();
                    match seeded.next() % 4 {
                        0 => damaged[at] = b'9',
                        1 => damaged.insert(at, b'0' + (seeded.next() % 10) as u8),
                        2 => damaged.truncate(at),
                        _ => damaged[at] = seeded.next() as u8,
                    }
                }
                within(&damaged, &name, "damaged", SMALL);
            }
        }
    }
    println!("most at a time: {} bytes ({})", worst.0, worst.1);
    // A container is measured by what it unpacks to, which is bounded.
    let size = 4 * 1024 * 1024;
    let container = bomb(size);
    let most = peak(&container, "x.gldf");
    println!(
        "a container of {} bytes with {size} inside: {most} bytes",
        container.len()
    );
    assert!(most <= MULTIPLE * size, "{most}");
}
