//! Which engine carries each property, and why that one.
//!
//! Every property runs on cases. Where another engine answers the same question for more inputs, that engine carries
//! the statement, and the cases check that nobody misread it: the two share no code. The engine follows from the
//! question. Products of unknown numbers need a solver of polynomials; sums, comparisons, memory and states suit a
//! SAT solver; orders of messages need exploration; small domains need none of them.

use Carrier::{EveryCase, Exploration, ModelChecker, Random, RandomReasoned, Theorems};

/// The engine that carries a property.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Carrier {
    /// Theorems over all numbers, of which one runs the code.
    Theorems(&'static [&'static str]),
    /// Harnesses that the bounded model checker answers.
    ModelChecker(&'static [&'static str]),
    /// Worlds that are explored completely.
    Exploration(&'static [&'static str]),
    /// Every case of the property's own domain, or of a small lattice.
    EveryCase,
    /// Random cases, and why no other engine answers.
    Random(&'static str),
    /// Random cases of the code. Theorems prove the reason, and run none of the property's code, or a small part.
    RandomReasoned(&'static [&'static str]),
}

impl Carrier {
    /// Whether this theorem is among those that carry the property or give its reason.
    #[must_use]
    pub fn has_theorem(self, theorem: &str) -> bool {
        matches!(self, Theorems(names) | RandomReasoned(names) if names.contains(&theorem))
    }

    /// The engine and the reason, for the page.
    #[must_use]
    pub fn text(self) -> String {
        let named = |engine: &str, names: &[&str], reason: &str| {
            let names: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
            format!("{engine} {}: {reason}", names.join(", "))
        };
        match self {
            Theorems(names) => named("solver", names, "products of unknown numbers"),
            ModelChecker(names) => named("model checker", names, "sums, comparisons, memory or states"),
            Exploration(names) => named("exploration", names, "orders of messages"),
            EveryCase => "every case within the stated bound: the domain is small".into(),
            Random(reason) => format!("random: {reason}"),
            RandomReasoned(names) => {
                named("random; the reason is proved by", names, "geometry, and at most a part of the code")
            }
        }
    }
}

/// The engine that carries a property; `None` when nobody said.
#[must_use]
pub fn by(property: &str) -> Option<Carrier> {
    CARRIED.iter().find(|(name, _)| *name == property).map(|(_, carrier)| *carrier)
}

const SORTING: &str =
    "a search that sorts; the program checks its result each time, and the check is a theorem";
const INDUCTION: &str = "a loop over any number of edges; its step is a theorem or a smaller property";
const ANSWERS: &str = "a comparison of two ways to one answer; each way rests on the predicates";
const DIGITS: &str = "loops over digits, with quotients";
const REFUSALS: &str =
    "a refusal, which exploration does not show; the positions that are accepted are explored";

/// Each property once.
pub const CARRIED: &[(&str, Carrier)] = &[
    // Predicates.
    ("orientation_is_the_sign_of_the_area", Theorems(&["orientation"])),
    ("point_point_is_exact", Theorems(&["point_point"])),
    ("point_segment_is_exact", Theorems(&["point_segment"])),
    ("segment_segment_is_exact", Theorems(&["segment_segment"])),
    ("triangle_segment_is_exact", Theorems(&["triangle_segment"])),
    ("convex_segment_is_exact", Theorems(&["convex_near_segment", "convex_holds"])),
    ("beyond_is_exact", Theorems(&["beyond"])),
    ("strictly_inside_is_inside_and_on_no_side", Theorems(&["strictly_inside"])),
    ("crossing_properly_is_one_point_inside_both", Theorems(&["crosses_properly"])),
    ("swept_triangle_covers_every_retargeted_motion", Theorems(&["triangle_segment", "in_flight_is_convex"])),
    ("retracting_never_comes_nearer", Theorems(&["retracts"])),
    ("box_segment_is_exact", Theorems(&["box_segment", "box_point"])),
    ("parity_of_a_triangle_is_its_inside", Theorems(&["ray_crosses_triangle"])),
    ("a_unit_more_covers_rounding_by_a_unit", RandomReasoned(&["rounding"])),
    (
        "polygons_of_many_corners_are_exact",
        Random("more corners than the solver takes; from there on by induction, see `convex_near_segment`"),
    ),
    (
        "polygons_are_checked_at_every_side",
        Random("corners on a circle; the model checker moves one corner of a square"),
    ),
    // Lattice.
    ("coordinates_are_those_within_the_bound", ModelChecker(&["coordinates_are_those_within_the_bound"])),
    ("points_move_by_vectors_or_say_so", ModelChecker(&["points_move_exactly_or_say_so"])),
    ("differences_are_exact", ModelChecker(&["differences_lead_back", "squares_of_distances_are_exact"])),
    ("sums_of_lengths_are_exact_or_errors", ModelChecker(&["sums_of_lengths_are_exact_or_errors"])),
    ("small_lengths_are_what_they_say", EveryCase),
    ("grown_windows_hold_what_is_within_reach", ModelChecker(&["grown_windows_hold_what_is_within_reach"])),
    (
        "windows_meet_when_they_share_a_point",
        ModelChecker(&["windows_meet_when_their_common_part_holds_a_point"]),
    ),
    ("grown_windows_meet_whenever_shapes_are_near", RandomReasoned(&["pruning"])),
    ("window_near_segment_is_of_its_part_on_the_lattice", Theorems(&["box_segment"])),
    ("within_reach_is_every_point", RandomReasoned(&["near_is_convex"])),
    ("touching_is_a_distance_of_nothing", RandomReasoned(&["touches"])),
    ("ahead_is_the_projection", Theorems(&["swept_arc_corner"])),
    // Rings and regions.
    ("triangles_and_quadrangles_are_rings_exactly_when_simple", RandomReasoned(&["folds_back"])),
    ("polygons_are_rings_exactly_when_simple", Random(INDUCTION)),
    ("inside_is_the_winding", Theorems(&["ray_crosses_ring"])),
    ("area_is_the_shoelace", Random(INDUCTION)),
    ("contacts_are_found_when_there_are_any", Random(INDUCTION)),
    ("few_contacts_are_found", EveryCase),
    ("regions_are_believed_exactly_when_rings_do_not_touch", Random(INDUCTION)),
    ("depths_count_the_rings_around_each", Random(INDUCTION)),
    // Arcs and curves.
    ("arcs_are_believed_exactly_when_their_ends_fit", Theorems(&["on_ring"])),
    ("chords_leave_their_arc_by_no_more_than_the_chord_error", Theorems(&["chord_error_bound", "sagitta"])),
    ("chords_go_forward_and_are_short", Random(INDUCTION)),
    (
        "what_is_clear_of_a_swept_arc_is_clear_of_its_ring",
        RandomReasoned(&["swept_arc_pieces", "swept_arc_rules", "swept_arc_corner"]),
    ),
    ("what_touches_a_piece_of_an_arc_is_near", RandomReasoned(&["swept_arc_rules", "chord_error_bound"])),
    ("weights_and_counts_are_checked", ModelChecker(&["weights_are_in_their_range"])),
    (
        "what_follows_a_line_is_within_the_chord_error",
        Random("control points of high degree; sampled against exact fractions"),
    ),
    ("ring_edges_carry_both_chord_errors", Random(INDUCTION)),
    ("certified_paths_keep_the_threshold_and_the_chord_error", Random(INDUCTION)),
    ("chains_that_run_past_the_end_are_refused", Random(INDUCTION)),
    // Index.
    ("accepted_index_overlooks_no_edge", EveryCase),
    ("disturbed_indices_are_refused_or_overlook_nothing", Random(INDUCTION)),
    ("shrunken_boxes_are_refused", ModelChecker(&["accepted_boxes_hold_their_edges"])),
    ("misshapen_trees_are_refused", Random(INDUCTION)),
    (
        "boxes_of_a_node_meet_as_windows_do",
        ModelChecker(&["nodes_meet_as_their_boxes_do", "empty_lanes_meet_nothing"]),
    ),
    ("queries_are_those_over_all_edges", RandomReasoned(&["pruning", "polygon_pruning", "box_side"])),
    ("few_queries_are_those_over_all_edges", EveryCase),
    ("long_motions_skip_only_what_is_beside", Theorems(&["box_side"])),
    ("claims_survive_packing", ModelChecker(&["claims_survive_packing"])),
    ("cells_answer_as_the_index", RandomReasoned(&["near_is_convex"])),
    ("disturbed_cells_are_refused_or_harmless", Random(INDUCTION)),
    ("what_is_near_lies_in_the_whole", Random(INDUCTION)),
    ("walks_cover_their_motion", Random("a walk with quotients; its squares are counted again in fractions")),
    // Parts.
    ("free_points_are_clear_and_on_the_free_side", Random(ANSWERS)),
    ("clear_motions_and_swept_triangles_stay_free", RandomReasoned(&["ray_crosses_ring"])),
    ("retract_moves_come_nearer_to_nothing", Theorems(&["retracts"])),
    ("clipped_motions_are_clear_prefixes", RandomReasoned(&["clip_prefix"])),
    ("prefixes_were_accepted", RandomReasoned(&["clip_prefix"])),
    (
        "slides_keep_away_from_the_wall",
        Random("a quotient chooses the jog; the guard checks it as any other jog"),
    ),
    ("prepared_parts_answer_as_their_index", Random(ANSWERS)),
    ("clearance_is_below_the_distance", Random("a search by halves; each step is a query")),
    ("what_is_clear_of_the_simplified_outline_is_clear_of_the_part", Random(ANSWERS)),
    ("simplified_chords_cover_their_runs", Random(INDUCTION)),
    // Levels.
    ("levels_hold_what_stands_above_the_tip", RandomReasoned(&["levels_are_monotone"])),
    ("levels_are_monotone", RandomReasoned(&["levels_are_monotone"])),
    ("certificates_do_not_hold_below_their_level", Random(ANSWERS)),
    ("levels_fall_from_top_to_top", Random(INDUCTION)),
    ("levels_of_copies_share_their_outlines", Random("addresses of memory, which no other engine has")),
    // Guard.
    ("hull_holds_its_points_and_no_others", RandomReasoned(&["hull_is_one_polygon", "convex_holds"])),
    ("large_hulls_hold_their_points_and_no_others", Random(SORTING)),
    ("hulls_of_more_than_fourteen_are_none", EveryCase),
    ("nearest_of_a_hull_is_nearest", EveryCase),
    ("admitted_jogs_keep_the_hull_clear", RandomReasoned(&["in_flight_is_convex", "hull_is_one_polygon"])),
    (
        "admitted_cancels_keep_their_reach_clear",
        Exploration(&["cancels that leave the path", "cancels that leave the box"]),
    ),
    (
        "reports_are_never_farther_than_they_were",
        Exploration(&["reports that err", "reports that err, with a checksum"]),
    ),
    ("reports_off_the_set_are_refused", Random(REFUSALS)),
    (
        "acknowledgements_are_counted",
        Random(
            "any order of answers and rejections; a harness has two of them, and worlds have no answer too many",
        ),
    ),
    (
        "evidence_is_newer_than_what_it_settles",
        Exploration(&["an old report in place of one", "lines and answers are lost"]),
    ),
    (
        "refused_lines_did_not_leave_the_queue",
        Exploration(&["a line is refused", "a line comes twice, and once is refused"]),
    ),
    ("one_retract_move_at_a_time", Exploration(&["retract moves"])),
    ("contours_go_on_one_by_one", Exploration(&["contour", "contour, lines lost"])),
    ("certified_contours_are_joined_and_clear", Random(ANSWERS)),
    (
        "arcs_on_the_wire_are_short_and_not_too_short",
        Random("products of an arc's ends, a case per quarter turn"),
    ),
    (
        "places_on_arcs_are_told",
        Random("a nearest point with quotients; the report is compared with it in fractions"),
    ),
    (
        "slowed_motions_differ_in_their_feed_alone",
        ModelChecker(&["overrides_only_slow", "overrides_are_within_their_range"]),
    ),
    ("jogs_beyond_the_travel_are_refused", Random(REFUSALS)),
    // Contours.
    (
        "contours_end_after_their_last_motion",
        Random("contours that come back to their end, which no world has"),
    ),
    ("contours_begin_without_lines_in_flight", Random(REFUSALS)),
    ("arcs_beyond_the_travel_are_refused", Random("a chain of chords with quotients")),
    (
        "starts_beside_the_simplified_outline_are_inside",
        Random("places and outlines of many sizes; each world begins at one place"),
    ),
    ("no_thirteenth_line_goes_out", Random("more lines than exploration reaches")),
    // Reports.
    ("one_queue_length_is_no_evidence", Exploration(&["targets leave the set: time passes"])),
    (
        "lines_complete_only_when_the_query_left_late_enough",
        Exploration(&["targets leave the set: time passes", "time and cancels"]),
    ),
    ("rest_shows_when_no_line_can_be_in_parsing", Exploration(&["a line comes twice, and once is refused"])),
    ("contour_heights_off_the_motion_are_refused", Random(REFUSALS)),
    // Heights.
    (
        "jogs_are_clear_of_what_stands_above_the_lowest_height",
        RandomReasoned(&["lowest_height_suffices", "levels_are_monotone"]),
    ),
    ("jogs_are_refused_only_for_a_reason", Random(REFUSALS)),
    ("rises_are_always_admitted", Random("an admission, which exploration needs and does not count")),
    ("heights_rise_by_evidence_only", Exploration(&["heights: an old report in place of one"])),
    ("reported_heights_off_the_set_are_refused", Random(REFUSALS)),
    ("contours_are_certified_at_their_lowest_heights", Exploration(&["heights: contour with a plunge"])),
    ("retract_moves_do_not_lead_down", Exploration(&["heights: retract moves aside and up"])),
    ("heights_beyond_the_travel_are_refused", ModelChecker(&["permitted_heights_are_within_the_travel"])),
    ("cancels_may_sink", Exploration(&["heights: cancels that leave the path"])),
    // Dialects.
    ("short_byte_strings_are_decoded", EveryCase),
    ("strings_of_telling_bytes_are_decoded", EveryCase),
    ("long_byte_strings_are_decoded", Random("strings too long to list; libFuzzer searches them, too")),
    ("only_ok_accepts", EveryCase),
    ("answer_to_a_spindle_switch_accepts_no_motion", EveryCase),
    ("jogs_are_written_exactly", Random(DIGITS)),
    ("positions_are_read_exactly", Random(DIGITS)),
];
