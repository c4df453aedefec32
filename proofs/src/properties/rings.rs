//! Rings, regions and contacts, against their definitions over all pairs of edges.

use keepout_kernel::exact::contact::first_contact;
use keepout_kernel::exact::region::Location;
use keepout_kernel::exact::ring::RingError;
use keepout_kernel::{Point, Region, Ring, Segment};

use super::Xy;
use crate::draw::Draw;
use crate::families::at;
use crate::oracle::{self, Big};
use crate::property::{passed_over, properties};

properties! {
    "rings and regions", "kernel/src/exact/ring.rs, region.rs, contact.rs";
    // Evidence for SR-04.
    triangles_and_quadrangles_are_rings_exactly_when_simple |d| {
        let count = 3 + d.one_of(2);
        ring_is_believed_exactly_when_simple(&polygon(d, count))
    }
        => "three or four vertices make a ring exactly when every edge has a length, neighbours meet only \
            in their vertex, and other edges do not meet";
        every 2 random 30_000;
    polygons_are_rings_exactly_when_simple |d| {
        let count = d.one_of(9);
        ring_is_believed_exactly_when_simple(&polygon(d, count))
    }
        => "a polygon of up to eight vertices makes a ring exactly when it is simple";
        random 60_000;
    inside_is_the_winding |d| inside_is_the_winding(&polygon(d, 4), d.point())
        => "the side of a point agrees with the winding number of its ring, also where rays pass through \
            vertices";
        every 2 random 60_000;
    area_is_the_shoelace |d| area_is_the_shoelace(&polygon(d, 4))
        => "the doubled area is the shoelace sum; its sign gives the direction";
        every 2 random 30_000;
    contacts_are_found_when_there_are_any |d| {
        let count = d.one_of(40);
        contacts_are_found_when_there_are_any(&segments(d, count))
    }
        => "the search finds a pair of segments of different owners that meet exactly when there is one, over \
            one, two and three levels of blocks, for owners of one segment and of five";
        random 30_000;
    few_contacts_are_found |d| few_contacts_are_found(&segments(d, 3))
        => "among three segments, the search finds a pair that meets exactly when there is one";
        every 1 random 10_000;
    regions_are_believed_exactly_when_rings_do_not_touch |d|
        regions_are_believed_exactly_when_rings_do_not_touch([polygon(d, 3), polygon(d, 3)], d.point())
        => "two rings make a region exactly when they do not touch; a point inside an odd number of them \
            is inside";
        random 60_000;
    depths_count_the_rings_around_each |d| {
        let count = 1 + d.one_of(6);
        depths_count_the_rings_around_each(&squares(d, count))
    }
        => "the depth of a ring is the number of rings around it, for up to six squares that do not touch";
        random 60_000;
}

/// Corners of squares.
fn squares<D: Draw>(d: &mut D, count: usize) -> Vec<[Xy; 4]> {
    let mut square = || {
        let ((x, y), (size, _)) = (d.point(), d.point());
        // The square stays on the lattice.
        let (x, y, side) = (x / 2, y / 2, size.abs() / 4 + 1);
        [(x, y), (x + side, y), (x + side, y + side), (x, y + side)]
    };
    (0..count).map(|_| square()).collect()
}

fn polygon<D: Draw>(d: &mut D, count: usize) -> Vec<Xy> {
    (0..count).map(|_| d.point()).collect()
}

fn segments<D: Draw>(d: &mut D, count: usize) -> Vec<Segment> {
    (0..count).map(|_| Segment { from: at(d.point()), to: at(d.point()) }).collect()
}

fn points(polygon: &[Xy]) -> Vec<Point> {
    polygon.iter().map(|&p| at(p)).collect()
}

fn sides(polygon: &[Xy]) -> Vec<(Xy, Xy)> {
    polygon.iter().copied().zip(polygon.iter().copied().cycle().skip(1)).collect()
}

/// Whether edges meet only where neighbours share a vertex, by the definitions.
fn is_simple(polygon: &[Xy]) -> bool {
    let edges = sides(polygon);
    let big = |(x, y): Xy| Big::new(x, y);
    let touch = |(a, b): (Xy, Xy), (c, d): (Xy, Xy)| {
        oracle::segment_segment_within(&big(a), &big(b), &big(c), &big(d), 0)
    };
    let on = |p: Xy, (a, b): (Xy, Xy)| oracle::point_segment_within(&big(p), &big(a), &big(b), 0);
    let count = edges.len();
    count >= 3
        && edges.iter().all(|(a, b)| a != b)
        && (0..count).all(|i| {
            (i + 1..count).all(|j| {
                let (one, other) = (edges[i], edges[j]);
                if j == i + 1 {
                    !on(other.1, one) && !on(one.0, other)
                } else if i == 0 && j == count - 1 {
                    !on(other.0, one) && !on(one.1, other)
                } else {
                    !touch(one, other)
                }
            })
        })
}

fn ring_is_believed_exactly_when_simple(polygon: &[Xy]) {
    let made = Ring::new(points(polygon));
    assert_eq!(made.is_ok(), is_simple(polygon), "{polygon:?} {made:?}");
    if polygon.len() < 3 {
        assert_eq!(made, Err(RingError::TooFewVertices { count: polygon.len() }));
    } else if sides(polygon).iter().any(|(a, b)| a == b) {
        assert!(matches!(made, Err(RingError::ZeroLengthEdge { .. })), "{polygon:?} {made:?}");
    }
    match made {
        Ok(ring) => assert!(ring.vertices() == points(polygon) && ring.chord_errors().len() == polygon.len()),
        Err(RingError::TooFewVertices { .. }) => {}
        Err(RingError::ZeroLengthEdge { at: place }) => {
            assert!(sides(polygon).iter().any(|&(a, b)| a == b && at(a) == place), "{polygon:?}");
        }
        Err(RingError::Contact(contact)) => assert!(contact.first < contact.second, "{polygon:?}"),
        Err(RingError::Gap { .. }) => panic!("vertices have no gaps"),
    }
}

fn inside_is_the_winding(polygon: &[Xy], p: Xy) {
    let Ok(ring) = Ring::new(points(polygon)) else { return passed_over() };
    let corners: Vec<_> = polygon.iter().map(|&(x, y)| Big::new(x, y)).collect();
    let truth = oracle::inside_polygon(&Big::new(p.0, p.1), &corners);
    if let Some(inside) = truth {
        assert_eq!(ring.crossing_parity_is_odd(at(p)), inside, "{polygon:?} {p:?}");
    }
    let region = Region::new(vec![ring]).expect("one ring");
    let location = match truth {
        None => Location::Boundary,
        Some(true) => Location::Inside,
        Some(false) => Location::Outside,
    };
    assert_eq!(region.locate(at(p)), location, "{polygon:?} {p:?}");
}

fn area_is_the_shoelace(polygon: &[Xy]) {
    let Ok(ring) = Ring::new(points(polygon)) else { return passed_over() };
    let term =
        |((ax, ay), (bx, by)): (Xy, Xy)| i128::from(ax) * i128::from(by) - i128::from(bx) * i128::from(ay);
    let area: i128 = sides(polygon).into_iter().map(term).sum();
    assert_eq!(ring.double_area(), area, "{polygon:?}");
}

fn contacts_are_found_when_there_are_any(edges: &[Segment]) {
    // Short segments, so that often no two meet.
    let short: Vec<Segment> = edges
        .iter()
        .map(|edge| {
            let d = edge.to.minus(edge.from);
            let (x, y) = (i64::from(edge.from.x.units()), i64::from(edge.from.y.units()));
            Segment { from: edge.from, to: at((x + i64::from(d.dx) / 64, y + i64::from(d.dy) / 64)) }
        })
        .collect();
    for run in [1, 5] {
        contact_of_runs_is_found(&short, run);
    }
}

fn few_contacts_are_found(edges: &[Segment]) {
    contact_of_runs_is_found(edges, 1);
}

/// Each `run` of consecutive segments has one owner.
fn contact_of_runs_is_found(edges: &[Segment], run: usize) {
    let meet = |i: usize, j: usize| edges[i].touches(edges[j]);
    let is_contact = |i: usize, j: usize| i / run != j / run && meet(i, j);
    let any = (0..edges.len()).any(|i| (i + 1..edges.len()).any(|j| is_contact(i, j)));
    let found = first_contact(edges, |edge| edge / run, meet);
    assert_eq!(found.is_some(), any, "{edges:?} {run}");
    assert!(found.is_none_or(|(i, j)| i < j && is_contact(i, j)), "{edges:?} {run}");
}

fn depths_count_the_rings_around_each(squares: &[[Xy; 4]]) {
    // Squares that touch one before them are passed over.
    let region = |squares: &[[Xy; 4]]| {
        let rings: Result<Vec<Ring>, _> = squares.iter().map(|each| Ring::new(points(each))).collect();
        Region::new(rings.ok()?).ok()
    };
    let mut kept: Vec<[Xy; 4]> = Vec::new();
    for square in squares {
        kept.push(*square);
        if region(&kept).is_none() {
            kept.pop();
        }
    }
    let Some(region) = region(&kept) else { return passed_over() };
    let around = |[(x, y), ..]: &[Xy; 4]| {
        let holds = |other: &&[Xy; 4]| {
            let ((x0, y0), (x1, y1)) = (other[0], other[2]);
            x0 < *x && *x < x1 && y0 < *y && *y < y1
        };
        kept.iter().filter(holds).count()
    };
    assert_eq!(region.depths(), kept.iter().map(around).collect::<Vec<_>>(), "{kept:?}");
}

fn regions_are_believed_exactly_when_rings_do_not_touch(polygons: [Vec<Xy>; 2], p: Xy) {
    let [Ok(one), Ok(other)] = polygons.each_ref().map(|polygon| Ring::new(points(polygon))) else {
        return passed_over();
    };
    let touch = one.segments().any(|a| other.segments().any(|b| a.touches(b)));
    let inside = one.crossing_parity_is_odd(at(p)) ^ other.crossing_parity_is_odd(at(p));
    match Region::new(vec![one, other]) {
        Err(_) => assert!(touch, "{polygons:?}"),
        Ok(region) => {
            assert!(!touch, "{polygons:?}");
            match region.locate(at(p)) {
                Location::Boundary => {}
                location => assert_eq!(location == Location::Inside, inside, "{polygons:?} {p:?}"),
            }
        }
    }
}
