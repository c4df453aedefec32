//! Letters three lines high, readable from two metres: 3 × 5 dots, or 5 × 5 for wide letters, with two dots
//! per line.

/// Width and dots of a character: five rows from the top, with the highest bit on the left.
fn dots(character: char) -> Option<(usize, [u32; 5])> {
    if let Some(rows) = wide(character.to_ascii_uppercase()) {
        return Some((5, [20, 15, 10, 5, 0].map(|shift| rows >> shift & 0b11111)));
    }
    let rows: u32 = match character.to_ascii_uppercase() {
        'A' => 0b010_101_111_101_101,
        'B' => 0b110_101_110_101_110,
        'C' => 0b011_100_100_100_011,
        'D' => 0b110_101_101_101_110,
        'E' => 0b111_100_110_100_111,
        'F' => 0b111_100_110_100_100,
        'G' => 0b011_100_101_101_011,
        'H' => 0b101_101_111_101_101,
        'I' => 0b111_010_010_010_111,
        'J' => 0b001_001_001_101_010,
        'K' => 0b101_101_110_101_101,
        'L' => 0b100_100_100_100_111,
        'O' => 0b010_101_101_101_010,
        'P' => 0b110_101_110_100_100,
        'Q' => 0b010_101_101_110_011,
        'R' => 0b110_101_110_101_101,
        'S' => 0b011_100_010_001_110,
        'T' => 0b111_010_010_010_010,
        'U' => 0b101_101_101_101_111,
        'V' => 0b101_101_101_101_010,
        'X' => 0b101_101_010_101_101,
        'Y' => 0b101_101_010_010_010,
        'Z' => 0b111_001_010_100_111,
        '0' => 0b111_101_101_101_111,
        '1' => 0b010_110_010_010_111,
        '2' => 0b111_001_111_100_111,
        '3' => 0b111_001_011_001_111,
        '4' => 0b101_101_111_001_001,
        '5' => 0b111_100_111_001_111,
        '6' => 0b111_100_111_101_111,
        '7' => 0b111_001_010_010_010,
        '8' => 0b111_101_111_101_111,
        '9' => 0b111_101_111_001_111,
        '-' => 0b000_000_111_000_000,
        '.' => 0b000_000_000_000_010,
        '%' => 0b101_001_010_100_101,
        '?' => 0b111_001_010_000_010,
        ' ' => 0,
        _ => return None,
    };
    Some((3, [12, 9, 6, 3, 0].map(|shift| rows >> shift & 0b111)))
}

/// The letters that need five dots of width.
fn wide(character: char) -> Option<u32> {
    match character {
        'M' => Some(0b10001_11011_10101_10001_10001),
        'N' => Some(0b10001_11001_10101_10011_10001),
        'W' => Some(0b10001_10001_10101_11011_10001),
        _ => None,
    }
}

/// Writes the text in three lines of block characters: four columns per character, six per wide character.
///
/// Returns `None` if the text is wider than `width`, or has a character without dots.
pub fn large(text: &str, width: usize) -> Option<[String; 3]> {
    let mut lines = [const { String::new() }; 3];
    let mut used = 0;
    for character in text.chars() {
        let (columns, rows) = dots(character)?;
        for (line, text) in lines.iter_mut().enumerate() {
            let (upper, lower) = (rows[2 * line], rows.get(2 * line + 1).copied().unwrap_or(0));
            let bit = |row: u32, column: usize| row >> (columns - 1 - column) & 1 == 1;
            text.extend((0..columns).map(|column| block(bit(upper, column), bit(lower, column))));
            text.push(' ');
        }
        used += columns + 1;
    }
    (used <= width + 1).then(|| lines.map(|line| line.trim_end().into()))
}

fn block(upper: bool, lower: bool) -> char {
    match (upper, lower) {
        (true, true) => '█',
        (true, false) => '▀',
        (false, true) => '▄',
        (false, false) => ' ',
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_letters_match_their_dots_and_respect_the_width() {
        let lines = large("A1-.", 80).unwrap();
        assert_eq!(lines, ["▄▀▄ ▄█", "█▀█  █  ▀▀▀", "▀ ▀ ▀▀▀      ▀"]);
        assert!(large("AB", 7).is_some() && large("AB", 6).is_none());
        assert!(large("é", 80).is_none());
    }
}
