//! Small drawings, as text.

use std::fmt::Write as _;

use keepout_planner::Mm2;

/// Plain numbers of a small drawing, mm.
pub type PlainXy = (f64, f64);

/// A drawing in the making.
#[derive(Clone, Default)]
pub struct SmallDrawing {
    entities: String,
    unit: Option<u8>,
    /// Layers that are not plotted.
    unplotted: Vec<&'static str>,
}

impl SmallDrawing {
    /// An empty drawing in millimetres.
    pub fn mm() -> Self {
        Self { unit: Some(4), ..Self::default() }
    }

    /// An empty drawing without a unit.
    pub fn without_unit() -> Self {
        Self::default()
    }

    /// A layer that is not plotted.
    pub fn without_plot(mut self, layer: &'static str) -> Self {
        self.unplotted.push(layer);
        self
    }

    /// An entity by its groups.
    pub fn entity(mut self, kind: &str, layer: &str, groups: &str) -> Self {
        write!(self.entities, "0\n{kind}\n8\n{layer}\n{groups}").unwrap();
        self
    }

    /// A closed polyline on a layer, with more groups before its corners.
    pub fn loop_on(self, layer: &str, more: &str, corners: &[PlainXy]) -> Self {
        let corners: String = corners.iter().map(|(x, y)| format!("10\n{x}\n20\n{y}\n")).collect();
        self.entity("LWPOLYLINE", layer, &format!("{more}70\n1\n{corners}"))
    }

    /// A rectangle on layer 0.
    pub fn plate(self, low: PlainXy, high: PlainXy) -> Self {
        self.loop_on("0", "", &[low, (high.0, low.1), high, (low.0, high.1)])
    }

    /// A circle on a layer.
    pub fn circle_on(self, layer: &str, (x, y): PlainXy, radius: f64) -> Self {
        self.entity("CIRCLE", layer, &format!("10\n{x}\n20\n{y}\n40\n{radius}\n"))
    }

    /// A circle on layer 0.
    pub fn circle(self, at: PlainXy, radius: f64) -> Self {
        self.circle_on("0", at, radius)
    }

    /// A line on layer 0.
    pub fn line(self, (a, b): PlainXy, (c, d): PlainXy) -> Self {
        self.entity("LINE", "0", &format!("10\n{a}\n20\n{b}\n11\n{c}\n21\n{d}\n"))
    }

    /// An arc on layer 0, by its angles in degrees.
    pub fn arc(self, (x, y): PlainXy, radius: f64, (from, to): PlainXy) -> Self {
        self.entity("ARC", "0", &format!("10\n{x}\n20\n{y}\n40\n{radius}\n50\n{from}\n51\n{to}\n"))
    }

    /// Lines from corner to corner, each shortened or lengthened by these lengths at its start and its end.
    pub fn lines(self, corners: &[PlainXy], (start, end): PlainXy) -> Self {
        let next = corners.iter().cycle().skip(1);
        corners.iter().zip(next).fold(self, |sketch, (&a, &b)| {
            let (a, b) = (Mm2::new(a.0, a.1), Mm2::new(b.0, b.1));
            let along = a.direction_to(b);
            let (from, to) = (a - along * start, b + along * end);
            sketch.line((from.x, from.y), (to.x, to.y))
        })
    }

    /// The file.
    pub fn bytes(&self) -> Vec<u8> {
        let unit = self.unit.map_or(String::new(), |unit| {
            format!("0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n{unit}\n0\nENDSEC\n")
        });
        let layer = |name: &&str| format!("0\nLAYER\n2\n{name}\n70\n0\n62\n7\n290\n0\n");
        let layers: String = self.unplotted.iter().map(layer).collect();
        let tables = format!("0\nSECTION\n2\nTABLES\n0\nTABLE\n2\nLAYER\n{layers}0\nENDTAB\n0\nENDSEC\n");
        format!("{unit}{tables}0\nSECTION\n2\nENTITIES\n{}0\nENDSEC\n0\nEOF\n", self.entities).into_bytes()
    }
}
