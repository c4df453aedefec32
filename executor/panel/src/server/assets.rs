//! The files of the page. They are in the program.

use axum::extract::Path;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};

/// Media types.
const HTML: &str = "text/html; charset=utf-8";
const CSS: &str = "text/css; charset=utf-8";
const SVG: &str = "image/svg+xml";
const SCRIPT: &str = "text/javascript; charset=utf-8";

macro_rules! files {
    ($($name:literal $media:ident),+ $(,)?) => { &[$(($name, $media, include_str!(concat!("../../page/", $name)))),+] };
}

/// The files: name, media type, content.
const FILES: &[(&str, &str, &str)] = files![
    "index.html" HTML,
    "panel.css" CSS,
    "icon.svg" SVG,
    "panel.js" SCRIPT,
    "steps.js" SCRIPT,
    "parts.js" SCRIPT,
    "link.js" SCRIPT,
    "map.js" SCRIPT,
    "shape.js" SCRIPT,
    "steering.js" SCRIPT,
    "texts.js" SCRIPT,
    "text-de.js" SCRIPT,
    "text-en.js" SCRIPT,
    "text-pt.js" SCRIPT,
];

/// The page itself.
pub async fn page() -> Response {
    file(Path("index.html".into())).await
}

/// A file of the page.
pub async fn file(Path(name): Path<String>) -> Response {
    match FILES.iter().find(|(known, ..)| *known == name) {
        Some((_, media, content)) => ([(header::CONTENT_TYPE, *media)], *content).into_response(),
        None => (StatusCode::NOT_FOUND, "the panel has no such file").into_response(),
    }
}
