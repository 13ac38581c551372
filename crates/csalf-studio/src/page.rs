//! The files of the page: plain HTML, CSS and script modules, part of the program.

/// One file of the page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Asset {
    /// Name beside the page.
    pub name: &'static str,
    /// Media type.
    pub kind: &'static str,
    /// Content.
    pub text: &'static str,
}

/// What the page may load and do: its own files, its own engine, nothing from elsewhere.
pub const POLICY: &str = "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'; \
    style-src 'self'; connect-src 'self'; img-src 'self' data:; base-uri 'none'; form-action 'none'; \
    frame-ancestors 'none'";

const SCRIPT: &str = "text/javascript; charset=utf-8";

/// All files; the first is the page itself.
pub const ASSETS: [Asset; 10] = [
    Asset { name: "index.html", kind: "text/html; charset=utf-8", text: include_str!("../page/index.html") },
    Asset { name: "studio.css", kind: "text/css; charset=utf-8", text: include_str!("../page/studio.css") },
    Asset { name: "main.js", kind: SCRIPT, text: include_str!("../page/main.js") },
    Asset { name: "backend.js", kind: SCRIPT, text: include_str!("../page/backend.js") },
    Asset { name: "model.js", kind: SCRIPT, text: include_str!("../page/model.js") },
    Asset { name: "mesh.js", kind: SCRIPT, text: include_str!("../page/mesh.js") },
    Asset { name: "view.js", kind: SCRIPT, text: include_str!("../page/view.js") },
    Asset { name: "tools.js", kind: SCRIPT, text: include_str!("../page/tools.js") },
    Asset { name: "panel.js", kind: SCRIPT, text: include_str!("../page/panel.js") },
    // Of a static site alone: the engine in the browser.
    Asset { name: "worker.js", kind: SCRIPT, text: include_str!("../page/worker.js") },
];

/// The file of this name; the page itself for the empty one.
pub fn asset(name: &str) -> Option<&'static Asset> {
    let name = if name.is_empty() { "index.html" } else { name };
    ASSETS.iter().find(|a| a.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_loads_nothing_from_elsewhere() {
        for a in ASSETS {
            for wrong in ["http://", "https://", "innerHTML", "eval("] {
                assert!(!a.text.contains(wrong), "{} has {wrong}", a.name);
            }
            for line in a.text.lines().filter(|l| l.starts_with("import ")) {
                let module = line.rsplit("\"./").next().unwrap_or_default().trim_end_matches("\";");
                assert!(asset(module).is_some(), "{}: {line}", a.name);
            }
        }
        let page = asset("").unwrap().text;
        assert!(page.contains("studio.css") && page.contains("main.js"));
    }
}
