//! The files of the page, which are part of the program.

/// Type and content of the file that a path means.
pub(crate) fn file(path: &str) -> Option<(&'static str, &'static [u8])> {
    const HTML: &str = "text/html; charset=utf-8";
    const SCRIPT: &str = "text/javascript; charset=utf-8";
    const STYLE: &str = "text/css; charset=utf-8";
    const PICTURE: &str = "image/svg+xml";
    macro_rules! files {
        ($($path:literal: $kind:ident $file:literal,)*) => {
            match path {
                $($path => Some(($kind, &include_bytes!(concat!("../page/", $file))[..])),)*
                _ => None,
            }
        };
    }
    files! {
        "/": HTML "index.html",
        "/style.css": STYLE "style.css",
        "/icon.svg": PICTURE "icon.svg",
        "/main.js": SCRIPT "main.js",
        "/wire.js": SCRIPT "wire.js",
        "/stage.js": SCRIPT "stage.js",
        "/shaders.js": SCRIPT "shaders.js",
        "/draw.js": SCRIPT "draw.js",
        "/camera.js": SCRIPT "camera.js",
        "/matrix.js": SCRIPT "matrix.js",
        "/hands.js": SCRIPT "hands.js",
        "/panel.js": SCRIPT "panel.js",
        "/timeline.js": SCRIPT "timeline.js",
        "/graph.js": SCRIPT "graph.js",
        "/link.js": SCRIPT "link.js",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn every_file_of_the_folder_is_served_and_none_asks_for_anything_elsewhere() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/page");
        for entry in fs::read_dir(folder).unwrap() {
            let name = entry.unwrap().file_name().into_string().unwrap();
            if name.ends_with(".json") || name.ends_with(".d.ts") {
                continue;
            }
            let path = if name == "index.html" { "/".to_owned() } else { format!("/{name}") };
            let (_, content) = file(&path).unwrap_or_else(|| panic!("{name} is not served"));
            let text = std::str::from_utf8(content).unwrap().replace("http://www.w3.org/2000/svg", "");
            assert!(!text.contains("http://") && !text.contains("https://"), "{name} names another place");
        }
        assert!(file("/../Cargo.toml").is_none());
    }
}
