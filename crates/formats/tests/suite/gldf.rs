//! The container GLDF: what lies in it, and what it only links to.

use std::io::{Cursor, Write};

use isolux_formats::{Content, read_any};

fn container(product: &str) -> Vec<u8> {
    let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
    zip.start_file("product.xml", zip::write::SimpleFileOptions::default())
        .unwrap();
    zip.write_all(product.as_bytes()).unwrap();
    zip.finish().unwrap().into_inner()
}

#[test]
fn a_spectrum_in_the_product_is_read_and_addresses_are_counted() {
    let rows: String = (0..9)
        .map(|k| {
            [
                r#"<Intensity wavelength=""#,
                &(380 + 40 * k).to_string(),
                r#"">0.5</Intensity>"#,
            ]
            .concat()
                + "\n"
        })
        .collect();
    let product = ["<Root><Spectrum id=\"s\">\n", &rows, "</Spectrum></Root>"].concat();
    let found = read_any(&container(&product), "a.gldf");
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].inner.as_deref(), Some("product.xml#s"));
    let Some(Content::Spectrum(file)) = &found[0].document else {
        panic!("no spectrum: {:?}", found[0].findings);
    };
    assert_eq!((file.wavelength_nm[8], file.value[8]), (700.0, 0.5));
    let damaged = product.replacen(">0.5<", ">O.5<", 1);
    let found = read_any(&container(&damaged), "a.gldf");
    assert!(found[0].document.is_none());
    assert_eq!(
        (found[0].findings[0].code, found[0].findings[0].line),
        ("gldf-spectrum-number", Some(2))
    );

    let linked = "<Root><File id=\"a\" type=\"url\">https://example.org/a.ldt</File></Root>";
    let found = read_any(&container(linked), "a.gldf");
    assert_eq!(found[0].findings[0].code, "gldf-empty");
    assert!(found[0].findings[0].message.ends_with("not fetched: 1"));
}
