//! Hazards, requirements and assumptions, as the pages of `docs/safety/` state them.

use std::path::Path;
use std::{fs, io};

/// A safety requirement.
#[derive(Clone, Debug)]
pub struct Requirement {
    /// Its number, such as "SR-07".
    pub id: String,
    /// Its title.
    pub title: String,
    /// The hazards that it answers.
    pub hazards: Vec<String>,
    /// The assumptions that it rests on.
    pub assumptions: Vec<String>,
}

/// A numbered statement of another page, and the numbers that its text refers to.
#[derive(Clone, Debug)]
pub struct Statement {
    /// Its number, such as "H-01" or "A-03".
    pub id: String,
    /// The requirements and assumptions that it names.
    pub refers_to: Vec<String>,
    /// Whether it says what it must: a hazard its measure and what remains, an assumption its check.
    pub whole: bool,
}

/// Everything that the pages state.
#[derive(Clone, Debug)]
pub struct Statements {
    /// `hazards.md`.
    pub hazards: Vec<Statement>,
    /// `requirements.md`.
    pub requirements: Vec<Requirement>,
    /// `assumptions.md`.
    pub assumptions: Vec<Statement>,
}

/// Numbered sections of a page: number, title and text.
fn sections<'a>(page: &'a str, prefix: &str) -> Vec<[&'a str; 3]> {
    let mut found: Vec<[&str; 3]> = Vec::new();
    let heads: Vec<usize> = page.match_indices("\n### ").map(|(at, head)| at + head.len()).collect();
    for (n, begin) in heads.iter().enumerate() {
        let end = heads.get(n + 1).map_or(page.len(), |next| next - "\n### ".len());
        let (head, text) = page[*begin..end].split_once('\n').unwrap_or((&page[*begin..end], ""));
        let (id, title) = head.split_once(' ').unwrap_or((head, ""));
        if id.starts_with(prefix) {
            found.push([id, title, text.split("\n## ").next().unwrap_or(text)]);
        }
    }
    found
}

/// The numbers with this prefix that a text names, in order. "A-08 to A-14" names all seven.
pub fn numbers(text: &str, prefix: &str) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    let mut begin = 0;
    while let Some(at) = text[begin..].find(prefix) {
        let after = begin + at + prefix.len();
        let digits: String = text[after..].chars().take_while(char::is_ascii_digit).collect();
        let range = text[begin..begin + at].trim() == "to";
        begin = after + digits.len();
        let Ok(number) = digits.parse::<u32>() else { continue };
        let first = match found.last().and_then(|last| last[prefix.len()..].parse::<u32>().ok()) {
            Some(last) if range => last + 1,
            _ => number,
        };
        found.extend((first..=number).map(|n| format!("{prefix}{n:02}")));
    }
    found
}

/// The text behind a word, up to the end of its paragraph, as "Hazards:".
fn behind<'a>(text: &'a str, word: &str) -> &'a str {
    let Some((_, after)) = text.split_once(word) else { return "" };
    after.split("\n\n").next().unwrap_or(after)
}

/// Reads the three pages under the root of the workspace.
///
/// # Errors
/// When one cannot be read.
pub fn read(root: &Path) -> io::Result<Statements> {
    let page = |name: &str| fs::read_to_string(root.join("docs/safety").join(name));
    let (hazards, requirements, assumptions) =
        (page("hazards.md")?, page("requirements.md")?, page("assumptions.md")?);
    let stated = |page: &str, prefix: &str, parts: &[&str]| {
        sections(page, prefix)
            .into_iter()
            .map(|[id, _, text]| Statement {
                id: id.into(),
                refers_to: [numbers(text, "SR-"), numbers(text, "A-")].concat(),
                whole: parts.iter().all(|part| text.contains(part)),
            })
            .collect()
    };
    let parts = ["**Cause.**", "**Harm.**", "**Who notices.**", "**Measure.**", "**What remains.**"];
    Ok(Statements {
        hazards: stated(&hazards, "H-", &parts),
        assumptions: stated(&assumptions, "A-", &["**Check.**"]),
        requirements: sections(&requirements, "SR-")
            .into_iter()
            .map(|[id, title, text]| {
                let (before, after) = behind(text, "Hazards:")
                    .split_once("Assumptions:")
                    .unwrap_or((behind(text, "Hazards:"), ""));
                Requirement {
                    id: id.into(),
                    title: title.into(),
                    hazards: numbers(before, "H-"),
                    assumptions: numbers(after, "A-"),
                }
            })
            .collect(),
    })
}
