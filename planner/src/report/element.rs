//! Elements of SVG and HTML, written in lines.

use std::fmt::{self, Display, Write as _};

/// Element. Its attributes and its content keep the order of the calls.
#[derive(Clone, Debug)]
#[must_use]
pub struct Element {
    name: &'static str,
    attributes: String,
    content: Option<String>,
}

impl Element {
    /// An element without attributes and content.
    pub fn new(name: &'static str) -> Self {
        Self { name, attributes: String::new(), content: None }
    }

    /// Adds an attribute.
    pub fn set(mut self, name: &str, value: impl Display) -> Self {
        let _ = write!(self.attributes, " {name}=\"{}\"", escape(&value.to_string()));
        self
    }

    /// Adds a length in pixels with a number of decimals.
    pub fn fixed(self, name: &str, pixels: f64, decimals: usize) -> Self {
        self.set(name, format_args!("{pixels:.decimals$}"))
    }

    /// Adds the colour of an area or of text.
    pub fn fill(self, colour: &str) -> Self {
        self.set("fill", colour)
    }

    /// Adds the colour of a line and its width in pixels.
    pub fn stroke(self, colour: &str, width: impl Display) -> Self {
        self.set("stroke", colour).set("stroke-width", width)
    }

    /// Adds a line around an area that stays empty.
    pub fn outline(self, colour: &str, width: impl Display) -> Self {
        self.fill("none").stroke(colour, width)
    }

    /// Makes text bold, with a size in pixels.
    pub fn bold(self, size: u32) -> Self {
        self.set("font-size", size).set("font-weight", "bold")
    }

    /// Adds text to the content.
    pub fn text(self, text: impl Display) -> Self {
        self.content(&escape(&text.to_string()))
    }

    /// Adds an element to the content.
    pub fn with(self, inner: &Self) -> Self {
        self.content(&inner.to_string())
    }

    /// Adds lines to the content, behind a line break.
    pub fn lines(self, lines: &Lines) -> Self {
        self.content("\n").content(&lines.0)
    }

    fn content(mut self, markup: &str) -> Self {
        self.content.get_or_insert_default().push_str(markup);
        self
    }
}

impl Display for Element {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, attributes, content } = self;
        match content {
            None => write!(f, "<{name}{attributes}/>"),
            Some(content) => write!(f, "<{name}{attributes}>{content}</{name}>"),
        }
    }
}

/// Lines of elements.
#[derive(Clone, Debug, Default)]
pub struct Lines(pub(super) String);

impl Lines {
    /// Adds a line of markup as it is.
    pub fn raw(&mut self, markup: &str) {
        self.0 += markup;
        self.0.push('\n');
    }

    /// Adds a line with these elements.
    pub fn draw(&mut self, elements: &[Element]) {
        elements.iter().for_each(|element| self.0 += &element.to_string());
        self.0.push('\n');
    }
}

/// SVG document of a size in pixels, without content.
pub fn document((width, height): (f64, f64)) -> Element {
    let view_box = format_args!("0 0 {width:.0} {height:.0}");
    Element::new("svg").set("xmlns", "http://www.w3.org/2000/svg").set("viewBox", view_box)
}

/// Background of a picture.
pub fn background(colour: &str) -> Element {
    Element::new("rect").set("width", "100%").set("height", "100%").fill(colour)
}

/// Path, from its commands.
pub fn path(commands: impl Display) -> Element {
    Element::new("path").set("d", commands)
}

/// Points of a polyline, with a space after each.
#[must_use]
pub fn points(points: impl Iterator<Item = (f64, f64)>, decimals: usize) -> String {
    points.map(|(x, y)| format!("{x:.decimals$},{y:.decimals$} ")).collect()
}

/// Straight lines between [`points`].
pub fn polyline(points: &str) -> Element {
    Element::new("polyline").set("points", points)
}

/// Line between two points.
pub fn line((x1, y1): (f64, f64), (x2, y2): (f64, f64), decimals: usize) -> Element {
    let from = Element::new("line").fixed("x1", x1, decimals).fixed("y1", y1, decimals);
    from.fixed("x2", x2, decimals).fixed("y2", y2, decimals)
}

/// Circle around a point.
pub fn circle((x, y): (f64, f64), decimals: usize, radius: impl Display) -> Element {
    Element::new("circle").fixed("cx", x, decimals).fixed("cy", y, decimals).set("r", radius)
}

/// Text that begins at a point.
pub fn text((x, y): (f64, f64), decimals: usize, text: impl Display) -> Element {
    Element::new("text").fixed("x", x, decimals).fixed("y", y, decimals).text(text)
}

/// Text escaped for XML. XML permits no control characters.
#[must_use]
pub fn escape(text: &str) -> String {
    let shown = |letter: char| if letter.is_control() && letter != '\n' { '\u{fffd}' } else { letter };
    let text: String = text.chars().map(shown).collect();
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn attributes_and_text_are_escaped() {
        let element = Element::new("text").set("id", "\"\u{7}").text("1 < 2");
        assert_eq!(element.to_string(), "<text id=\"&quot;\u{fffd}\">1 &lt; 2</text>");
    }
}
