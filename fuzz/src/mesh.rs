//! The Delaunay mesh, compared with brute force.

use crate::oracle::xy;
use arbitrary::{Arbitrary, Result, Unstructured};
use keepout_kernel::exact::lattice::COORD_MAX;
use keepout_kernel::exact::region::Location;
use keepout_kernel::exact::segment::Window;
use keepout_kernel::index::build::build;
use keepout_kernel::{CheckedIndex, Edge, Length, Nearest, Point};
use keepout_planner::mesh::{Mesh, MeshError};
use keepout_proofs::families::at;
use keepout_proofs::properties::Xy;
use keepout_proofs::square::plain;

use crate::field::{CORNERS_MAX, Field, segment};
use crate::oracle::to_chord;

/// Reads edges from any bytes. The mesh finds the nearest edge and the location of a point as brute force
/// does, or the index does not confirm its answer.
///
/// # Panics
/// When the index confirms a wrong answer, or a mesh with all edges gives one.
pub fn mesh(bytes: &[u8]) {
    let _ = mesh_of(&mut Unstructured::new(bytes));
}

fn mesh_of(u: &mut Unstructured<'_>) -> Result<()> {
    let field = Field::arbitrary(u)?;
    let soup = bool::arbitrary(u)?;
    let (edges, corners) = if soup { soup_of(field, u)? } else { rings_of(field, u)? };
    let Ok(index) = build(edges) else { return Ok(()) };
    let half_frame = 2 * field.half + 1 + i64::from(u16::arbitrary(u)?);
    let half_frame = half_frame.min(i64::from(COORD_MAX));
    let frame = i32::try_from(half_frame).unwrap_or(i32::MAX);
    let frame = Window::from_corners(-frame, -frame, frame, frame);
    let mesh = match Mesh::build(&index, frame, bool::arbitrary(u)?) {
        Ok(mesh) => mesh,
        Err(MeshError::Frame) => {
            let ends = index.edges().iter().flat_map(|edge| [plain(edge.chord.from), plain(edge.chord.to)]);
            let most = ends.map(|(x, y)| x.abs().max(y.abs())).max().unwrap_or(0);
            assert!(most >= half_frame, "a frame of {half_frame} is refused for {most}");
            return Ok(());
        }
        Err(error) => panic!("{error}: {:?}", index.edges()),
    };
    let mut walk = mesh.walk();
    for _ in 0..u.int_in_range(1..=8_u8)? {
        let p = at(field.beside(&corners, u)?);
        let Some(nearest) = walk.nearest(&mesh, &index, p) else {
            assert!(!frame.holds(p), "no edge is nearest to {p:?} of {:?}", index.edges());
            continue;
        };
        let truth = brute(&index, p);
        let right = (nearest.distance() - truth).abs() <= 1e-3 + truth * 1e-9;
        let case = format!("{p:?}: {nearest:?}, {truth} in {:?}", index.edges());
        assert!(
            right || !index.confirms(p, nearest) || (nearest.distance() - truth).abs() < 2.5,
            "confirmed {case}"
        );
        assert!(right || mesh.left_out() > 0, "{case}");
        refuses_others(&index, p, nearest, truth, u)?;
        if !soup && mesh.left_out() == 0 && frame.holds(p) && index.locate(p) != Location::Boundary {
            // The outside of all rings is connected to the frame's corner.
            let outside = walk.component(&mesh, p) == Some(0);
            assert!(!outside || index.locate(p) == Location::Outside, "{case}");
        }
    }
    Ok(())
}

/// Checks that the index does not confirm an answer that is off by more than rounding.
fn refuses_others(
    index: &CheckedIndex,
    p: Point,
    nearest: Nearest,
    truth: f64,
    u: &mut Unstructured<'_>,
) -> Result<()> {
    let edge = usize::from(u8::arbitrary(u)?);
    let factor = 1.0 + f64::from(i8::arbitrary(u)?) / 64.0;
    let other = Nearest { edge, distance_2: nearest.distance_2 * factor };
    let off = |edge: &Edge| (to_edge(edge, p) - other.distance()).abs();
    let wrong =
        (other.distance() - truth).abs() > 2.5 || index.edges().get(edge).is_none_or(|edge| off(edge) > 2.5);
    assert!(!wrong || !index.confirms(p, other), "{other:?} at {p:?}, truth {truth}");
    Ok(())
}

fn soup_of(field: Field, u: &mut Unstructured<'_>) -> Result<(Vec<Edge>, Vec<Xy>)> {
    let count = u.int_in_range(1..=CORNERS_MAX)?;
    let mut corners: Vec<Xy> = Vec::new();
    let mut edges = Vec::new();
    for _ in 0..count {
        // Some edges share an end.
        let a =
            if corners.is_empty() || bool::arbitrary(u)? { field.point(u)? } else { *u.choose(&corners)? };
        let b = field.point(u)?;
        corners.extend([a, b]);
        edges.push(Edge { chord: segment(a, b), chord_error: Length::ZERO });
    }
    Ok((edges, corners))
}

fn rings_of(field: Field, u: &mut Unstructured<'_>) -> Result<(Vec<Edge>, Vec<Xy>)> {
    let (mut edges, mut corners) = (Vec::new(), Vec::new());
    for _ in 0..u.int_in_range(1..=2_u8)? {
        let ring = field.ring(u)?;
        let ends = ring.iter().zip(ring.iter().cycle().skip(1));
        edges.extend(ends.map(|(&a, &b)| Edge { chord: segment(a, b), chord_error: Length::ZERO }));
        corners.extend(ring);
    }
    Ok((edges, corners))
}

fn to_edge(edge: &Edge, p: Point) -> f64 {
    to_chord(xy(p), (xy(edge.chord.from), xy(edge.chord.to)))
}

fn brute(index: &CheckedIndex, p: Point) -> f64 {
    index.edges().iter().map(|edge| to_edge(edge, p)).fold(f64::INFINITY, f64::min)
}
