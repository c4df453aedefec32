//! HTML pages that need no scripts and no other files.

use super::element::{Element, Lines, escape};

/// Screens wide and narrow, light and dark, and paper. Print begins the proof on a page of its own.
const STYLE: &str = ":root{--ink:#1d2025;--paper:#fff;--rule:#d5dae1;--soft:#f4f6f8;color-scheme:light dark}\
     @media(prefers-color-scheme:dark){:root{--ink:#e8eaed;--paper:#16181c;--rule:#3a3f47;--soft:#22262c}}\
     body{font:16px/1.45 Helvetica,Arial,sans-serif;max-width:1120px;margin:1.2em auto;padding:0 1em;\
     color:var(--ink);background:var(--paper)}h1{font-size:1.5em;margin:.4em 0}h2{font-size:1.15em;margin:1.4em 0 .4em}\
     table{border-collapse:collapse;width:100%;margin:.6em 0}th{text-align:left;font-weight:600;\
     padding:.3em 1em .3em 0;vertical-align:top}td{padding:.3em 1em .3em 0;overflow-wrap:anywhere;min-width:3em;\
     vertical-align:top}\
     tr{border-bottom:1px solid var(--rule)}pre{background:var(--soft);padding:1em;overflow:auto;font-size:.85em;\
     white-space:pre-wrap}figure{margin:1em 0;background:#fff}svg{display:block;width:100%;height:auto}\
     .outcome{font-size:1.15em;padding:.6em .8em;border-left:.5em solid #0072b2;background:var(--soft)}\
     .outcome.open{border-left-color:#d55e00}.outcome.open::before{content:\"\\26A0 \"}\
     .outcome.whole::before{content:\"\\2713 \"}.columns{display:grid;grid-template-columns:1fr 1fr;gap:0 2em}\
     @media(max-width:700px){.columns{display:block}th{white-space:normal}}\
     @media print{:root{--ink:#000;--paper:#fff;--rule:#999;--soft:#fff}body{font-size:10pt;margin:0;max-width:none}\
     figure svg{max-height:13cm}.proof{break-before:page}tr,figure{break-inside:avoid}a{color:inherit}}";

/// The page of a job: first what a customer reads, then the proof.
#[derive(Clone, Debug, Default)]
pub struct JobPage {
    /// Title of the page.
    pub title: String,
    /// The outcome in words.
    pub outcome: String,
    /// Whether every contour of the plan is cut.
    pub is_complete: bool,
    /// Title block: name and value.
    pub head: Vec<(String, String)>,
    /// Part, tool and times: name and value.
    pub facts: Vec<(String, String)>,
    /// The contours: name, place and length, fate.
    pub contours: Vec<[String; 3]>,
    /// The picture, SVG.
    pub picture: String,
    /// The section view of a plan with depths, SVG.
    pub section: Option<String>,
    /// Figures of the run and of its proof: name and value.
    pub proof: Vec<(String, String)>,
    /// What happened: time, event, place.
    pub timeline: Vec<[String; 3]>,
    /// Summary of the plan.
    pub plan: String,
}

impl JobPage {
    /// The page.
    #[must_use]
    pub fn html(&self) -> String {
        let title = escape(&self.title);
        let pairs = |rows: &[(String, String)]| table(rows.iter().cloned().map(Into::into));
        let kind = if self.is_complete { "whole" } else { "open" };
        let outcome = Element::new("p").set("class", format_args!("outcome {kind}")).text(&self.outcome);
        let timeline = if self.timeline.is_empty() {
            String::new()
        } else {
            format!("<h2>What happened</h2>\n{}\n", table(self.timeline.iter().cloned()))
        };
        format!(
            "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"><title>{title}</title>\n\
             <style>{STYLE}</style></head>\n<body><h1>{title}</h1>\n{}\n{outcome}\n<figure>{}</figure>\n{}\
             <div class=\"columns\"><div><h2>Contours</h2>\n{}</div>\n\
             <div><h2>Part, tool and time</h2>\n{}</div></div>\n\
             <section class=\"proof\"><h2>Proof</h2>\n{}\n{timeline}<h2>The plan</h2>\n{}\n</section></body></html>\n",
            if self.head.is_empty() { String::new() } else { pairs(&self.head).to_string() },
            self.picture,
            self.section.as_ref().map_or(String::new(), |section| format!("<figure>{section}</figure>\n")),
            table(self.contours.iter().cloned()),
            pairs(&self.facts),
            pairs(&self.proof),
            Element::new("pre").text(&self.plan),
        )
    }
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
