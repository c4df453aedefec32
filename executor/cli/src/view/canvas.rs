//! A canvas of braille dots: two dots per column, four per line.

/// Braille dots and marks in character cells.
#[derive(Clone, Debug)]
pub struct Canvas {
    columns: usize,
    lines: usize,
    cells: Vec<u8>,
    marks: Vec<(usize, char)>,
}

/// Bits of a braille cell, by row and column of the dot.
const BITS: [[u8; 2]; 4] = [[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]];

impl Canvas {
    /// An empty canvas.
    pub fn new(columns: usize, lines: usize) -> Self {
        Self { columns, lines, cells: vec![0; columns * lines], marks: Vec::new() }
    }

    /// Width and height in dots.
    pub fn dots(&self) -> (f64, f64) {
        let count = |cells: usize, each: u32| f64::from(u32::try_from(cells).unwrap_or(0) * each);
        (count(self.columns, 2), count(self.lines, 4))
    }

    /// Sets a dot. `at` counts dots from the upper left. A dot outside the canvas has no effect.
    pub fn dot(&mut self, at: (f64, f64)) {
        if let Some((cell, x, y)) = self.cell(at) {
            self.cells[cell] |= BITS[y][x];
        }
    }

    /// Writes a character over the cell at `at`, in dots.
    pub fn mark(&mut self, at: (f64, f64), mark: char) {
        if let Some((cell, ..)) = self.cell(at) {
            self.marks.push((cell, mark));
        }
    }

    /// Draws a straight line, clipped at the canvas.
    pub fn line(&mut self, from: (f64, f64), to: (f64, f64)) {
        let Some((from, to)) = self.clipped(from, to) else { return };
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        // The line is clipped, so it has at most some hundreds of dots.
        let count = whole(dx.abs().max(dy.abs()).ceil()).max(1);
        for index in 0..=count {
            let share =
                f64::from(u32::try_from(index).unwrap_or(0)) / f64::from(u32::try_from(count).unwrap_or(1));
            self.dot((from.0 + dx * share, from.1 + dy * share));
        }
    }

    /// The lines of characters, each `columns` wide.
    pub fn text(&self) -> Vec<String> {
        let mut characters: Vec<char> = self.cells.iter().map(|&dots| braille(dots)).collect();
        for &(cell, mark) in &self.marks {
            characters[cell] = mark;
        }
        if self.columns == 0 {
            return vec![String::new(); self.lines];
        }
        characters.chunks(self.columns).map(|line| line.iter().collect()).collect()
    }

    fn cell(&self, (x, y): (f64, f64)) -> Option<(usize, usize, usize)> {
        let (width, height) = self.dots();
        if !((0.0..width).contains(&x) && (0.0..height).contains(&y)) {
            return None;
        }
        let (x, y) = (whole(x), whole(y));
        Some((y / 4 * self.columns + x / 2, x % 2, y % 4))
    }

    /// The part of a line on the canvas (Liang and Barsky, 1984).
    fn clipped(&self, from: (f64, f64), to: (f64, f64)) -> Option<((f64, f64), (f64, f64))> {
        let (width, height) = self.dots();
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        if ![from.0, from.1, dx, dy].iter().all(|value| value.is_finite()) {
            return None;
        }
        let (mut begin, mut end) = (0.0_f64, 1.0_f64);
        for (step, room) in [(-dx, from.0), (dx, width - from.0), (-dy, from.1), (dy, height - from.1)] {
            let share = room / step;
            if step < 0.0 {
                begin = begin.max(share);
            } else if step > 0.0 {
                end = end.min(share);
            } else if room < 0.0 {
                return None;
            }
        }
        // Far from the canvas the shares are not exact, so the ends are clamped to the canvas.
        let at =
            |share: f64| ((from.0 + dx * share).clamp(0.0, width), (from.1 + dy * share).clamp(0.0, height));
        (begin <= end).then(|| (at(begin), at(end)))
    }
}

/// The integer part of a number. Negative numbers and NaN give 0.
fn whole(value: f64) -> usize {
    usize::try_from(keepout_kernel::curve::round_down(value)).unwrap_or(0)
}

fn braille(dots: u8) -> char {
    if dots == 0 { ' ' } else { char::from_u32(0x2800 + u32::from(dots)).unwrap_or(' ') }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_and_marks_appear_in_the_expected_cells() {
        let mut canvas = Canvas::new(4, 2);
        canvas.line((0.0, 0.0), (7.0, 0.0));
        canvas.line((0.0, 7.0), (7.0, 7.0));
        canvas.mark((7.0, 7.0), '●');
        assert_eq!(canvas.text(), ["⠉⠉⠉⠉", "⣀⣀⣀●"]);
    }

    #[test]
    fn endless_lines_are_clipped_at_the_canvas() {
        let mut canvas = Canvas::new(4, 1);
        canvas.line((-1e9, 0.5), (1e9, 0.5));
        assert_eq!(canvas.text(), ["⠉⠉⠉⠉"]);
        for bad in [f64::NAN, f64::INFINITY, f64::MAX, f64::MIN] {
            canvas.line((bad, 0.0), (0.0, bad));
            canvas.line((bad, bad), (-bad, -bad));
            canvas.dot((bad, 1.0));
        }
        Canvas::new(0, 0).line((0.0, 0.0), (1.0, 1.0));
        assert_eq!(Canvas::new(0, 3).text().len(), 3);
    }
}
