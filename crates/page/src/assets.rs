//! The files of the page, inside the binary: it needs no network.

use isolux_app::drawing;

/// One file: its path below `/`, its type, its bytes.
pub struct Asset {
    /// Path without the leading slash.
    pub path: &'static str,
    /// Content type.
    pub kind: &'static str,
    /// The file.
    pub bytes: &'static [u8],
}

const HTML: &str = "text/html; charset=utf-8";
const CSS: &str = "text/css; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";
const SVG: &str = "image/svg+xml";

macro_rules! assets {
    ($($path:literal $kind:ident $($text:path)?;)*) => {
        /// Every file.
        pub const ASSETS: &[Asset] = &[$(Asset {
            path: $path,
            kind: $kind,
            bytes: bytes!($path $($text)?),
        }),*];
    };
}

/// A file of this crate, or one that the report draws with too.
macro_rules! bytes {
    ($path:literal) => {
        include_bytes!(concat!("../assets/", $path))
    };
    ($path:literal $text:path) => {
        $text.as_bytes()
    };
}

assets! {
    "index.html" HTML;
    "launch.html" HTML;
    "icon.svg" SVG;
    "page.css" CSS;
    "app.js" SCRIPT;
    "stream.js" SCRIPT;
    "stream-worker.js" SCRIPT;
    "state.js" SCRIPT;
    "polar.js" SCRIPT;
    "grid.js" SCRIPT;
    "charts.js" SCRIPT;
    "sensor.js" SCRIPT;
    "in-motion.js" SCRIPT;
    "u-map.js" SCRIPT;
    "dropped.js" SCRIPT;
    "commands.js" SCRIPT;
    "words.js" SCRIPT;
    "dom.js" SCRIPT;
    "results.js" SCRIPT;
    "solid.js" SCRIPT;
    "start.js" SCRIPT;
    "warmup.js" SCRIPT;
    "simulation.js" SCRIPT;
    "diagnosis.js" SCRIPT;
    "map.js" SCRIPT drawing::MAP;
    "stage.js" SCRIPT drawing::STAGE;
    "viewer.css" CSS drawing::STYLE;
    "vendor/three.min.js" SCRIPT drawing::THREE;
    "vendor/uPlot.iife.min.js" SCRIPT;
    "vendor/uPlot.min.css" CSS;
}

/// The file at this path.
pub fn asset(path: &str) -> Option<&'static Asset> {
    ASSETS.iter().find(|asset| asset.path == path)
}

#[cfg(test)]
mod tests {
    use sha2::{Digest as _, Sha256};

    use super::*;

    #[test]
    fn the_page_is_small_and_calls_nobody() {
        let all: usize = ASSETS.iter().map(|asset| asset.bytes.len()).sum();
        assert!(all < 2_000_000, "{all} bytes");
        for asset in ASSETS.iter().filter(|asset| !asset.path.starts_with("vendor/")) {
            let text = std::str::from_utf8(asset.bytes).unwrap();
            for foreign in [
                "https://",
                "//cdn",
                "eval(",
                "innerHTML",
                "onclick=",
                " style=\"",
                "<script>",
            ] {
                assert!(!text.contains(foreign), "{}: {foreign}", asset.path);
            }
        }
    }

    #[test]
    fn vendored_files_are_as_they_were_taken() {
        let vendored: Vec<_> = ASSETS
            .iter()
            .filter(|asset| asset.path.starts_with("vendor/"))
            .collect();
        assert_eq!(vendored.len(), 3);
        let sums = [
            include_str!("../assets/vendor/SHA256SUMS"),
            include_str!("../../report/src/viewer/vendor/SHA256SUMS"),
        ]
        .concat();
        for asset in vendored {
            let sum = hex::encode(Sha256::digest(asset.bytes));
            let name = asset.path.trim_start_matches("vendor/");
            assert!(sums.contains(&format!("{sum}  {name}\n")), "{name}: {sum}");
        }
    }
}
