//! The page "Messages A to Z" quotes the messages that the program has, and all of its errors.

use crate::source::{Offender, judge, product, read, sources};

const PAGE: &str = "docs/machinist/messages.md";
/// The code whose messages a user can see.
const PRODUCT: [&str; 8] = [
    "kernel/src",
    "planner/src",
    "planner/drives/src",
    "executor/src",
    "executor/guard/src",
    "executor/sim/src",
    "executor/panel/src",
    "executor/cli/src",
];
/// An error with fewer letters of its own only wraps another.
const WRAPPER: usize = 10;

/// A string literal of the code.
struct Literal {
    file: String,
    line: usize,
    /// Its text, with `…` for each placeholder.
    text: String,
    is_error: bool,
}

/// The text of a literal as a user sees it, with `…` for each placeholder.
fn shown(literal: &str) -> String {
    let mut text = String::new();
    let mut letters = literal.chars().peekable();
    while let Some(letter) = letters.next() {
        match (letter, letters.peek()) {
            ('\\', Some('\n')) => while letters.next_if(|next| next.is_whitespace()).is_some() {},
            ('\\', Some(_)) => text.extend(letters.next()),
            ('{', Some('{')) | ('}', Some('}')) => text.extend(letters.next()),
            ('{', _) => {
                while letters.next().is_some_and(|next| next != '}') {}
                text.push('…');
            }
            _ => text.push(letter),
        }
    }
    text
}

/// The string literals of a file, without its comments and inline tests.
fn literals(file: &str, text: &str) -> Vec<Literal> {
    let lines: Vec<(usize, &str)> =
        product(text).into_iter().filter(|(_, line)| !line.trim_start().starts_with("//")).collect();
    let code: String = lines.iter().flat_map(|(_, line)| [line, "\n"]).collect();
    let line_at = |place: usize| {
        let index = code[..place].matches('\n').count();
        lines.get(index).map_or(0, |(number, _)| *number)
    };
    let mut found = Vec::new();
    let mut from = 0;
    while let Some(begin) = code[from..].find('"').map(|at| from + at) {
        // The quote of a character literal begins no string.
        if code[..begin].ends_with('\'') && code[begin..].starts_with("\"'") {
            from = begin + 2;
            continue;
        }
        let mut end = begin + 1;
        while let Some(letter) = code[end..].chars().next().filter(|&letter| letter != '"') {
            end += letter.len_utf8();
            if letter == '\\' {
                end += code[end..].chars().next().map_or(0, char::len_utf8);
            }
        }
        found.push(Literal {
            file: file.into(),
            line: line_at(begin),
            text: shown(&code[begin + 1..end]),
            is_error: code[..begin].trim_end().ends_with("#[error("),
        });
        from = (end + 1).min(code.len());
    }
    found
}

fn product_literals() -> Vec<Literal> {
    let files = PRODUCT.iter().flat_map(|place| sources(place));
    files
        .filter(|(file, _)| !file.ends_with("tests.rs"))
        .flat_map(|(file, text)| literals(&file, &text))
        .collect()
}

/// The quoted messages of the page, each with its line.
fn quotes(page: &str) -> Vec<(usize, &str)> {
    let rows = page.lines().enumerate().filter(|(_, line)| line.starts_with("| **"));
    rows.flat_map(|(index, line)| {
        let subject_and_quotes = line.split(" | ").next().unwrap_or_default();
        subject_and_quotes.split('`').skip(1).step_by(2).map(move |quote| (index + 1, quote))
    })
    .collect()
}

/// Whether a message has all words of a quote.
fn has(text: &str, quote: &str) -> bool {
    let parts = quote.split('…').map(|part| part.trim_matches([' ', ':', '.', ',']));
    let words: Vec<&str> = parts.filter(|part| part.chars().count() > 3).collect();
    !words.is_empty() && words.iter().all(|part| text.contains(part))
}

#[test]
fn quoted_messages_are_messages_of_the_program() {
    let (page, literals) = (read(PAGE), product_literals());
    let is_shown = |quote: &str| literals.iter().any(|literal| has(&literal.text, quote));
    let quotes = quotes(&page);
    assert!(quotes.len() > 200, "only {} quotes were found", quotes.len());
    // The two parts about a colon may come from two messages.
    let stale = quotes.into_iter().filter(|(_, quote)| !is_shown(quote) && !quote.split(": ").all(is_shown));
    let offenders: Vec<_> = stale.map(|(line, quote)| Offender::at(PAGE, line, quote)).collect();
    judge("A quoted message is a message of the program", &offenders, &[]);
}

#[test]
fn every_error_has_a_row_on_the_page_of_messages() {
    let page = read(PAGE);
    let quotes = quotes(&page);
    let errors = product_literals().into_iter().filter(|literal| literal.is_error);
    let is_own = |text: &str| text.chars().filter(|letter| letter.is_alphabetic()).count() >= WRAPPER;
    let errors: Vec<Literal> = errors.filter(|error| is_own(&error.text)).collect();
    assert!(errors.len() > 150, "only {} errors were found", errors.len());
    // A quote of a word or two would cover every error with these words.
    let is_quoted =
        |error: &Literal| quotes.iter().any(|(_, quote)| is_own(quote) && has(&error.text, quote));
    let missing = errors.iter().filter(|error| !is_quoted(error));
    let offenders: Vec<_> = missing.map(|error| Offender::at(&error.file, error.line, &error.text)).collect();
    judge("Every error has a row on the page of messages", &offenders, &[]);
}
