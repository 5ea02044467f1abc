//! The page and its scripts, inside the program.

/// A file of the page.
pub(super) struct File {
    pub(super) content: &'static str,
    pub(super) kind: &'static str,
}

/// Returns the file of a name; the page itself has none.
pub(super) fn file(name: &str) -> Option<File> {
    const HTML: &str = "text/html; charset=utf-8";
    const CSS: &str = "text/css; charset=utf-8";
    const SCRIPT: &str = "text/javascript; charset=utf-8";
    let (content, kind) = match name {
        "" => (include_str!("../../page/index.html"), HTML),
        "icon.svg" => (include_str!("../../page/icon.svg"), "image/svg+xml"),
        "view.css" => (include_str!("../../page/view.css"), CSS),
        "main.js" => (include_str!("../../page/main.js"), SCRIPT),
        "facts.js" => (include_str!("../../page/facts.js"), SCRIPT),
        "handles.js" => (include_str!("../../page/handles.js"), SCRIPT),
        "plan.js" => (include_str!("../../page/plan.js"), SCRIPT),
        "space.js" => (include_str!("../../page/space.js"), SCRIPT),
        "vertices.js" => (include_str!("../../page/vertices.js"), SCRIPT),
        "why.js" => (include_str!("../../page/why.js"), SCRIPT),
        "other.js" => (include_str!("../../page/other.js"), SCRIPT),
        "server.js" => (include_str!("../../page/server.js"), SCRIPT),
        "screen.js" => (include_str!("../../page/screen.js"), SCRIPT),
        "moves.js" => (include_str!("../../page/moves.js"), SCRIPT),
        "panel.js" => (include_str!("../../page/panel.js"), SCRIPT),
        _ => return None,
    };
    Some(File { content, kind })
}
