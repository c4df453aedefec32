//! Tables as text.

/// A table as Markdown. The first row is its head.
#[must_use]
pub fn markdown(table: &[Vec<String>]) -> String {
    let line = |row: &Vec<String>| format!("| {} |\n", row.join(" | "));
    let mut lines: Vec<String> = table.iter().map(line).collect();
    if let Some(head) = table.first() {
        lines.insert(1, format!("|{}\n", "---|".repeat(head.len())));
    }
    lines.concat()
}
