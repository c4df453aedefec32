//! The clearance index and its checker, compared with all edges.

use std::ops::ControlFlow;

use arbitrary::{Arbitrary, Result, Unstructured};
use keepout_kernel::exact::segment::Window;
use keepout_kernel::index::build::propose;
use keepout_kernel::index::check::{BoxProposal, Node};
use keepout_kernel::{CheckedIndex, Edge};
use keepout_proofs::families::{at, length};

use crate::field::{Field, segment};
use crate::import::check_message;

/// Reads edges and queries from any bytes. Index and cells must answer as all edges do.
///
/// # Panics
/// When an answer differs.
pub fn index(bytes: &[u8]) {
    const PROPERTIES: [&str; 5] = [
        "queries_are_those_over_all_edges",
        "long_motions_skip_only_what_is_beside",
        "cells_answer_as_the_index",
        "walks_cover_their_motion",
        "prepared_parts_answer_as_their_index",
    ];
    keepout_proofs::named_of_bytes(&PROPERTIES, bytes);
}

/// Reads edges and a modified tree over them from any bytes. The checker refuses the tree, or the tree
/// overlooks no edge.
///
/// # Panics
/// When the checker accepts a tree that overlooks an edge.
pub fn index_check(bytes: &[u8]) {
    const PROPERTIES: [&str; 7] = [
        "accepted_index_overlooks_no_edge",
        "disturbed_indices_are_refused_or_overlook_nothing",
        "shrunken_boxes_are_refused",
        "misshapen_trees_are_refused",
        "boxes_of_a_node_meet_as_windows_do",
        "disturbed_cells_are_refused_or_harmless",
        "what_is_near_lies_in_the_whole",
    ];
    match bytes.split_first() {
        Some((which, rest)) if which % 2 == 0 => keepout_proofs::named_of_bytes(&PROPERTIES, rest),
        Some((_, rest)) => drop(mutated(&mut Unstructured::new(rest))),
        None => {}
    }
}

/// Edges in a tree of up to three levels, with changed boxes, nodes and levels.
fn mutated(u: &mut Unstructured<'_>) -> Result<()> {
    let field = Field::arbitrary(u)?;
    let (own, copies) = (u.int_in_range(0..=40_usize)?, u.int_in_range(1..=16_i64)?);
    let mut edges = Vec::new();
    for _ in 0..own {
        let (a, b, chord_error) = (field.point(u)?, field.point(u)?, length(i64::from(u8::arbitrary(u)?)));
        for k in 0..copies {
            let chord = segment((a.0 + 7 * k, a.1), (b.0, b.1 - 5 * k));
            edges.push(Edge { chord, chord_error });
        }
    }
    let mut proposal = propose(&edges);
    for _ in 0..u.int_in_range(0..=4_u8)? {
        mutate(&mut proposal, field, u)?;
    }
    match CheckedIndex::check(edges.clone(), proposal) {
        Err(fault) => check_message(&fault.to_string()),
        Ok(index) => {
            for (number, edge) in edges.iter().enumerate() {
                // All of the edge's box, and windows that just touch it on each side.
                let whole = edge.bounds();
                let (x0, y0, x1, y1) = whole.corners();
                let rims = [(x0, y0, x0, y1), (x1, y0, x1, y1), (x0, y0, x1, y0), (x0, y1, x1, y1)];
                let rims = rims.map(|(a, b, c, d)| Window::from_corners(a, b, c, d));
                for window in rims.into_iter().chain([whole]) {
                    let mut seen = 0;
                    let _ = index.visit(window, |visited, _| {
                        seen += usize::from(visited == number);
                        ControlFlow::Continue(())
                    });
                    assert_eq!(seen, 1, "edge {number} of {edges:?} in {window:?}");
                }
            }
        }
    }
    Ok(())
}

fn mutate(proposal: &mut BoxProposal, field: Field, u: &mut Unstructured<'_>) -> Result<()> {
    if proposal.levels.is_empty() {
        proposal.levels.push(vec![Node::of(std::iter::empty())]);
        return Ok(());
    }
    let level = u.choose_index(proposal.levels.len())?;
    let nodes = &mut proposal.levels[level];
    let node = u.choose_index(nodes.len().max(1))?.min(nodes.len().saturating_sub(1));
    match u.int_in_range(0..=9_u8)? {
        0 => drop(proposal.levels.remove(level)),
        1 => proposal.levels.insert(level, proposal.levels[level].clone()),
        2 if !nodes.is_empty() => drop(nodes.remove(node)),
        3 if !nodes.is_empty() => nodes.push(nodes[node]),
        4 if !nodes.is_empty() => nodes.rotate_left(node),
        _ if !nodes.is_empty() => {
            let mut boxes: Vec<Window> = nodes[node].windows().collect();
            let (lane, side) = (u.int_in_range(0..=7_usize)?, u.int_in_range(0..=3_u8)?);
            let by = i32::from(*u.choose(&[1_i16, -1, 2, i16::MAX, i16::MIN])?);
            let (x0, y0, x1, y1) = boxes[lane].corners();
            boxes[lane] = match side {
                0 => Window::from_corners(x0.saturating_add(by), y0, x1, y1),
                1 => Window::from_corners(x0, y0.saturating_add(by), x1, y1),
                2 => Window::from_corners(x0, y0, x1.saturating_add(by), y1),
                _ => Window::of(at(field.point(u)?)),
            };
            nodes[node] = Node::of(boxes.into_iter());
        }
        _ => {}
    }
    Ok(())
}
