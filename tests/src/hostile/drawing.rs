//! Random drawings: closed outlines of lines and arcs, as DXF.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use fastrand::Rng;

/// A random drawing as DXF text: an outline, 15 to 120 mm across, in some cases with a hole.
#[must_use]
pub fn random_drawing(random: &mut Rng) -> String {
    let size = 15.0 * 8.0_f64.powf(random.f64());
    let outline = match random.u8(0..7) {
        0 => star(random, size),
        1 => comb(random, size),
        2 => rounded(random, size),
        3 => spiral(random, size),
        4 => gear(random, size),
        5 => wedge(random, size),
        _ => blob(random, size),
    };
    let mut text =
        String::from("0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n4\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n");
    polyline(&mut text, &outline);
    if random.u8(0..3) == 0 {
        hole(random, &mut text, &outline);
    }
    text.push_str("0\nENDSEC\n0\nEOF\n");
    text
}

/// A corner (x, y), mm, and the bulge of the edge after it.
type Corner = (f64, f64, f64);

fn polyline(text: &mut String, corners: &[Corner]) {
    let _ = write!(text, "0\nLWPOLYLINE\n8\n0\n90\n{}\n70\n1\n", corners.len());
    for (x, y, bulge) in corners {
        let _ = write!(text, "10\n{x:.5}\n20\n{y:.5}\n42\n{bulge:.5}\n");
    }
}

/// Adds a circle around the outline's middle, if the outline is wide there.
fn hole(random: &mut Rng, text: &mut String, outline: &[Corner]) {
    let near = outline.iter().map(|(x, y, _)| x.hypot(*y)).fold(f64::INFINITY, f64::min);
    let radius = near * (0.2 + 0.4 * random.f64());
    if radius > 0.5 {
        let _ = write!(text, "0\nCIRCLE\n8\n0\n10\n0.0\n20\n0.0\n40\n{radius:.5}\n");
    }
}

fn star(random: &mut Rng, size: f64) -> Vec<Corner> {
    let count = random.u32(3..14) * 2;
    let depth = 0.3 + 0.6 * random.f64();
    let turn = random.f64();
    (0..count)
        .map(|k| {
            let r = if k % 2 == 0 { size } else { size * depth } / 2.0;
            let phi = TAU * (f64::from(k) + turn) / f64::from(count);
            (r * phi.cos(), r * phi.sin(), 0.0)
        })
        .collect()
}

/// A rectangle with narrow slots from above, square or round at the bottom.
fn comb(random: &mut Rng, size: f64) -> Vec<Corner> {
    let slots = random.u32(1..5);
    let pitch = size / f64::from(slots);
    let (h, depth) = (size / 2.0, size * (0.2 + 0.5 * random.f64()));
    let width = pitch * (0.3 + 0.4 * random.f64());
    let bulge = if random.bool() { 1.0 } else { 0.0 };
    let mut corners = vec![(-h, -h, 0.0), (h, -h, 0.0), (h, h, 0.0)];
    for k in (0..slots).rev() {
        let middle = -h + pitch * (f64::from(k) + 0.5);
        let (a, b) = (middle + width / 2.0, middle - width / 2.0);
        // A round bottom is a half circle that bulges into the part.
        corners.extend([(a, h, 0.0), (a, h - depth, -bulge), (b, h - depth, 0.0), (b, h, 0.0)]);
    }
    corners.push((-h, h, 0.0));
    corners
}

fn rounded(random: &mut Rng, size: f64) -> Vec<Corner> {
    let (w, h) = (size / 2.0, size / 2.0 * (0.3 + 0.7 * random.f64()));
    let r = w.min(h) * (0.1 + 0.8 * random.f64());
    let quarter = (TAU / 16.0).tan();
    let bulge = if random.u8(0..4) == 0 { -quarter } else { quarter };
    vec![
        (-w + r, -h, 0.0),
        (w - r, -h, bulge),
        (w, -h + r, 0.0),
        (w, h - r, bulge),
        (w - r, h, 0.0),
        (-w + r, h, bulge),
        (-w, h - r, 0.0),
        (-w, -h + r, bulge),
    ]
}

/// A spiral arm.
fn spiral(random: &mut Rng, size: f64) -> Vec<Corner> {
    let steps = random.u32(12..40);
    let turns = 0.6 + 0.8 * random.f64();
    let arm = size * 0.08;
    let at = |k: u32, off: f64| {
        let t = f64::from(k) / f64::from(steps);
        let r = size * (0.5 - 0.35 * t) + off;
        let phi = TAU * turns * t;
        (r * phi.cos(), r * phi.sin(), 0.0)
    };
    let out = (0..=steps).map(|k| at(k, arm / 2.0));
    let back = (0..=steps).rev().map(|k| at(k, -arm / 2.0));
    out.chain(back).collect()
}

fn gear(random: &mut Rng, size: f64) -> Vec<Corner> {
    let teeth = random.u32(5..24);
    let depth = size * (0.03 + 0.08 * random.f64());
    let bulge = 0.3 * random.f64();
    (0..teeth * 4)
        .map(|k| {
            let r = if k % 4 < 2 { size / 2.0 } else { size / 2.0 - depth };
            let phi = TAU * f64::from(k) / f64::from(teeth * 4);
            (r * phi.cos(), r * phi.sin(), if k % 4 == 0 { bulge } else { 0.0 })
        })
        .collect()
}

/// An outline with sharp corners, convex and concave.
fn wedge(random: &mut Rng, size: f64) -> Vec<Corner> {
    let h = size / 2.0;
    let tip = size * (0.02 + 0.2 * random.f64());
    let notch = h * (1.6 * random.f64() - 0.6);
    vec![(-h, -h, 0.0), (h, -tip, 0.0), (h, tip, 0.0), (-h, h, 0.0), (notch, 0.1 * h * random.f64(), 0.0)]
}

fn blob(random: &mut Rng, size: f64) -> Vec<Corner> {
    let count = random.u32(4..30);
    (0..count)
        .map(|k| {
            let r = size / 2.0 * (0.6 + 0.4 * random.f64());
            let phi = TAU * f64::from(k) / f64::from(count);
            (r * phi.cos(), r * phi.sin(), 0.4 * (random.f64() - 0.4))
        })
        .collect()
}
