//! Pictures show what the plan states, in two renderers that nobody here wrote.

use std::io::Write as _;
use std::process::{Command, Stdio};

use clipper2_rust::core::{Paths64, Point64, PointInPolygonResult, point_in_polygon};
use keepout_planner::plan::CertifiedPlan;
use keepout_planner::report::{RunDrawing, svg};
use keepout_planner::units::point_mm;
use resvg::{tiny_skia, usvg};

use crate::dxf::{PlainXy, SmallDrawing};
use crate::figures::closed_by_clipper;
use crate::plan;

/// What the colour of a pixel means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Shown {
    /// The part.
    Part,
    /// Rest material: the ground of its hatching, a stripe, or the blend of both.
    Rest,
    /// The prohibited region beside the part, light.
    KeepOut,
    /// A line, a mark, or the free space.
    Other,
}

/// A rendered picture.
struct Raster {
    width: usize,
    height: usize,
    /// Red, green and blue, row by row from the top.
    pixels: Vec<[u8; 3]>,
}

/// The picture of a plan without words: fonts differ between computers.
fn wordless(plan: &CertifiedPlan) -> String {
    let picture = svg(plan, "sketch.dxf", &RunDrawing::default());
    let mut parts = picture.split("<text");
    let first = parts.next().unwrap_or_default().to_string();
    parts.fold(first, |all, part| all + part.split_once("</text>").map_or("", |(_, rest)| rest))
}

/// The first renderer: resvg.
fn by_resvg(picture: &str) -> Raster {
    let tree = usvg::Tree::from_str(picture, &usvg::Options::default()).unwrap();
    let size = tree.size().to_int_size();
    let mut pixmap = tiny_skia::Pixmap::new(size.width(), size.height()).unwrap();
    resvg::render(&tree, tiny_skia::Transform::identity(), &mut pixmap.as_mut());
    raster(&pixmap)
}

/// The second renderer: librsvg, if this computer has it.
fn by_librsvg(picture: &str) -> Option<Raster> {
    let mut child = Command::new("rsvg-convert").stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().ok()?;
    child.stdin.take()?.write_all(picture.as_bytes()).unwrap();
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "rsvg-convert refuses the picture");
    Some(raster(&tiny_skia::Pixmap::decode_png(&output.stdout).unwrap()))
}

fn raster(pixmap: &tiny_skia::Pixmap) -> Raster {
    let pixels = pixmap.pixels().iter().map(|pixel| pixel.demultiply());
    Raster {
        width: pixmap.width() as usize,
        height: pixmap.height() as usize,
        pixels: pixels.map(|pixel| [pixel.red(), pixel.green(), pixel.blue()]).collect(),
    }
}

impl Raster {
    fn shown(&self, x: usize, y: usize) -> Shown {
        assert!(x < self.width && y < self.height, "outside the picture");
        let pixel = self.pixels[y * self.width + x];
        let near = |colour: [u8; 3]| pixel.iter().zip(colour).all(|(&one, other)| one.abs_diff(other) <= 1);
        // Renderers blend the stripes and the edges of the pattern's tiles.
        const SLACK: u8 = 10;
        let [ground, stripe]: [[u8; 3]; 2] = [[0xf4, 0xb1, 0x83], [0xd5, 0x5e, 0x00]];
        let hatching =
            (0..3).all(|k| (stripe[k].saturating_sub(SLACK)..=ground[k] + SLACK).contains(&pixel[k]));
        if near([0xb9, 0xc0, 0xca]) {
            Shown::Part
        } else if hatching {
            Shown::Rest
        } else if near([0xf3, 0xe1, 0x9c]) || near([0xfb, 0xf3, 0xd0]) {
            Shown::KeepOut
        } else {
            Shown::Other
        }
    }
}

/// Where places of the drawing lie in the picture. The first edge of the part tells it.
struct Mapping {
    /// Pixels per mm.
    scale: f64,
    /// The pixel of the drawing's origin.
    origin: PlainXy,
}

impl Mapping {
    fn of(picture: &str, plan: &CertifiedPlan) -> Self {
        let part = picture.split("<path").find(|path| path.contains("fill=\"#b9c0ca\"")).unwrap();
        let data = part.split_once(" d=\"").unwrap().1.split_once('"').unwrap().0;
        // A move to the first point, and a line or an arc to the second one.
        let numbers = |text: &str| -> Vec<f64> {
            text.split(|c: char| !(c.is_ascii_digit() || ".-".contains(c)))
                .filter_map(|number| number.parse().ok())
                .collect()
        };
        let pieces: Vec<&str> = data[1..].split(['L', 'A', 'Z']).take(2).collect();
        let (from, to) = (numbers(pieces[0]), numbers(pieces[1]));
        let to = &to[to.len() - 2..];
        let edge = &plan.plan.profile.loops[0].edges[0].curve;
        let (first, last) = (edge.from(), edge.to());
        let (first, last) = (point_mm(first), point_mm(last));
        let scale = (to[0] - from[0]).hypot(to[1] - from[1]) / (last.x - first.x).hypot(last.y - first.y);
        Self { scale, origin: (from[0] - first.x * scale, from[1] + first.y * scale) }
    }

    /// The place of a pixel's centre, in lattice units.
    fn place(&self, x: usize, y: usize) -> Point64 {
        #[expect(clippy::cast_precision_loss, reason = "pixels of a picture")]
        let (x, y) = (x as f64 + 0.5, y as f64 + 0.5);
        let units = |mm: f64| {
            #[expect(clippy::cast_possible_truncation, reason = "places of a small drawing")]
            let units = (mm * 1e5).round() as i64;
            units
        };
        Point64 { x: units((x - self.origin.0) / self.scale), y: units((self.origin.1 - y) / self.scale) }
    }
}

/// What an independent library says of a place.
fn truth([part, closed]: &[Paths64; 2], at: Point64) -> Shown {
    let within = |paths: &Paths64| {
        let inside = paths.iter().filter(|path| point_in_polygon(at, path) == PointInPolygonResult::IsInside);
        inside.count() % 2 == 1
    };
    match (within(part), within(closed)) {
        (true, _) => Shown::Part,
        (_, true) => Shown::Rest,
        _ => Shown::Other,
    }
}

/// Pixels of a picture, compared.
#[derive(Debug, Default)]
struct Compared {
    /// Pixels of rest material.
    rest: usize,
    /// Pixels of rest material that have its colours. Marks hide the others.
    shown: usize,
    /// Pixels that have the colour of another area.
    wrong: usize,
}

/// Compares a picture with the independent geometry, pixel by pixel. Pixels at an edge of an area are left out.
fn compare(raster: &Raster, mapping: &Mapping, areas: &[Paths64; 2]) -> Compared {
    const NEAR_EDGE: usize = 3;
    let mut found = Compared::default();
    for y in (40..660).step_by(2) {
        for x in (40..1060).step_by(2) {
            let near = [(x - NEAR_EDGE, y), (x + NEAR_EDGE, y), (x, y - NEAR_EDGE), (x, y + NEAR_EDGE)];
            let said = truth(areas, mapping.place(x, y));
            if near.iter().any(|&(x, y)| truth(areas, mapping.place(x, y)) != said) {
                continue;
            }
            match (said, raster.shown(x, y)) {
                (Shown::Part, Shown::Part) | (Shown::Other, Shown::KeepOut) => {}
                (Shown::Rest, Shown::Rest) => found.shown += 1,
                // A line or a mark.
                (_, Shown::Other) => {}
                _ => found.wrong += 1,
            }
            found.rest += usize::from(said == Shown::Rest);
        }
    }
    found
}

/// The picture of a plan in each renderer of this computer.
fn check(name: &str, sketch: &SmallDrawing, has_rest: bool) {
    let plan = plan(sketch, 6.0).unwrap();
    let (picture, areas) = (wordless(&plan), closed_by_clipper(&plan));
    let mapping = Mapping::of(&picture, &plan);
    let second = by_librsvg(&picture);
    if second.is_none() {
        assert!(std::env::var_os("CI").is_none(), "CI skips nothing: install rsvg-convert");
        println!("skipped: no rsvg-convert for the second renderer");
    }
    let renderers = [("resvg", Some(by_resvg(&picture))), ("librsvg", second)];
    for (renderer, raster) in renderers {
        let Some(raster) = raster else { continue };
        let found = compare(&raster, &mapping, &areas);
        println!("{name}, {renderer}: {found:?}");
        assert_eq!(found.wrong, 0, "{name}, {renderer}: {found:?}");
        assert_eq!(found.rest > 0, has_rest, "{name}, {renderer}: {found:?}");
        assert!(found.shown * 4 >= found.rest * 3, "{name}, {renderer}: {found:?}");
    }
}

#[test]
fn a_hole_that_the_tool_clears_shows_no_rest_material() {
    let hole = SmallDrawing::mm().plate((0.0, 0.0), (60.0, 30.0)).circle((30.0, 15.0), 3.3);
    check("hole of 6.6 mm", &hole, false);
}

#[test]
fn a_hole_below_the_tool_is_rest_material_all_over() {
    let hole = SmallDrawing::mm().plate((0.0, 0.0), (60.0, 30.0)).circle((30.0, 15.0), 2.9);
    check("hole of 5.8 mm", &hole, true);
}

#[test]
fn strips_between_posts_are_shown_where_the_tool_cannot_go() {
    let posts = SmallDrawing::mm().circle((0.0, 0.0), 1.3).circle((7.4246, 0.0), 1.3);
    check("posts", &posts, true);
}
