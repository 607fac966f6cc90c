//! What says at a glance whose report it is: logo, mark of accreditation, address, style.

use base64::Engine as _;

/// What says at a glance whose report it is.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Clothes {
    /// Logo, as SVG.
    pub logo: Option<String>,
    /// Mark of accreditation, as SVG.
    pub accreditation_mark: Option<String>,
    /// Address, one line a line.
    pub address: Vec<String>,
    /// Style of the page that follows its own.
    pub style: String,
}

/// A picture of a laboratory as SVG with width and height, whatever of the two kinds it is.
///
/// # Errors
/// What is wrong with it.
pub fn picture(bytes: &[u8]) -> Result<String, String> {
    if bytes.starts_with(b"\x89PNG") {
        let reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info();
        let reader = reader.map_err(|error| format!("is no PNG: {error}"))?;
        let (w, h) = (reader.info().width, reader.info().height);
        let data = base64::engine::general_purpose::STANDARD.encode(bytes);
        return Ok(format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" viewBox=\"0 0 {w} {h}\">\
             <image width=\"{w}\" height=\"{h}\" href=\"data:image/png;base64,{data}\"/></svg>"
        ));
    }
    let text = std::str::from_utf8(bytes).map_err(|_| "is neither SVG nor PNG".to_owned())?;
    let tree = usvg::Tree::from_str(text, &usvg::Options::default()).map_err(|error| format!("is no SVG: {error}"))?;
    // Written again: without scripts, links and style sheets, and with its size where `extent` looks for it.
    let size = tree.size();
    let inner = tree.to_string(&usvg::WriteOptions::default());
    let (_, body) = inner.split_once('>').ok_or("is no SVG")?;
    Ok(format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" width=\"{w}\" height=\"{h}\" \
         viewBox=\"0 0 {w} {h}\">{body}",
        w = size.width(),
        h = size.height()
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_of_either_kind_comes_as_svg_with_its_size_and_without_scripts() {
        let svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 40 20\"><script>alert(1)</script><rect width=\"40\" height=\"20\"/></svg>";
        let made = picture(svg.as_bytes()).unwrap();
        assert!(
            made.contains(" width=\"40\" height=\"20\"") && !made.contains("alert") && made.contains("<path"),
            "{made}"
        );
        let mut png = Vec::new();
        let mut encoder = png::Encoder::new(&mut png, 3, 2);
        encoder.set_color(png::ColorType::Grayscale);
        encoder.write_header().unwrap().write_image_data(&[0; 6]).unwrap();
        assert!(picture(&png).unwrap().contains("width=\"3\" height=\"2\""));
        assert!(picture(b"GIF89a").is_err() && picture(&png[..20]).is_err());
    }
}
