//! HTML pages that need no scripts and no other files.

use super::element::{Element, Lines, escape};

const STYLE: &str = "body{font-family:Helvetica,Arial,sans-serif;max-width:1120px;margin:1.5em auto;\
     padding:0 1em;color:#1d2025}table{border-collapse:collapse;margin:1em 0}\
     th{text-align:left;font-weight:600;padding:.25em 1.5em .25em 0;vertical-align:top;white-space:nowrap}\
     td{padding:.25em 1.5em .25em 0;overflow-wrap:anywhere}tr{border-bottom:1px solid #dde1e6}\
     pre{background:#f4f6f8;padding:1em;overflow:auto}svg{width:100%;height:auto}";

/// Page of a run: rows, picture, and further elements.
#[must_use]
pub fn page(title: &str, rows: Vec<(String, String)>, picture: &str, further: &[Element]) -> String {
    let (title, table) = (escape(title), table(rows.into_iter().map(Into::into)));
    let further: String = further.iter().map(|element| format!("{element}\n")).collect();
    format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{title}</title>\n\
         <style>{STYLE}</style></head>\n<body><h1>{title}</h1>\n{table}\n{picture}\n{further}</body></html>\n"
    )
}

/// Table. The first cell of a row is its heading.
pub fn table<const N: usize>(rows: impl Iterator<Item = [String; N]>) -> Element {
    let mut lines = Lines::default();
    for cells in rows {
        let names = std::iter::once("th").chain(std::iter::repeat("td"));
        let cells = names.zip(cells).map(|(name, text)| Element::new(name).text(text));
        lines.draw(&[cells.fold(Element::new("tr"), |row, cell| row.with(&cell))]);
    }
    Element::new("table").lines(&lines)
}
