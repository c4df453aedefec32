//! Faults seeded in the page: one for each complaint, by its number, and those for other tests in the browser. The
//! test must notice it.
//!
//! `cargo test -p keepout --test panel seeded -- --ignored --nocapture`

use std::cell::RefCell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use crate::{complaints, network, port_lost};

/// A fault in a file of the page.
#[derive(Clone, Copy, Debug)]
pub struct PageFault {
    name: &'static str,
    /// Its file.
    pub file: &'static str,
    find: &'static str,
    with: &'static str,
    notices: fn(),
}

thread_local! {
    static SEEDED: RefCell<Option<PageFault>> = const { RefCell::new(None) };
}

/// The fault that the tests of this thread meet.
pub fn seeded() -> Option<PageFault> {
    SEEDED.with_borrow(|fault| *fault)
}

impl PageFault {
    /// The file with the fault in it.
    pub(crate) fn content(&self) -> String {
        let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../panel/page").join(self.file);
        let text = std::fs::read_to_string(page).unwrap();
        assert_eq!(text.matches(self.find).count(), 1, "its place in {} is there once", self.file);
        text.replace(self.find, self.with)
    }
}

const FAULTS: [PageFault; 14] = [
    PageFault {
        name: "1: a window that loses the focus holds on",
        file: "steering.js",
        find: "    addEventListener(\"blur\", () => this.release());\n",
        with: "",
        notices: complaints::c01_whatever_lets_go_stops_the_tool,
    },
    PageFault {
        name: "2: the pad is let go late",
        file: "steering.js",
        find: "    pointer = null;\n    steering.pad = null;\n",
        with: "    pointer = null;\n    setTimeout(() => { steering.pad = null; }, 5000);\n",
        notices: complaints::c01_whatever_lets_go_stops_the_tool,
    },
    PageFault {
        name: "3: a screen gives control away unasked",
        file: "panel.js",
        find: "state.control.asked) this.consent();",
        with: "state.control.asked) this.link.send({ type: \"answer\", consents: true });",
        notices: complaints::c03_one_screen_steers_and_others_watch,
    },
    PageFault {
        name: "4: targets are small",
        file: "panel.css",
        find: "--target: 12.5mm;",
        with: "--target: 8mm;",
        notices: complaints::c04_targets_are_large_and_apart,
    },
    PageFault {
        name: "5: old data look alive",
        file: "link.js",
        find: "export const DEAD_MS = 500;",
        with: "export const DEAD_MS = 5000;",
        notices: complaints::c05_stale_data_is_visibly_dead,
    },
    PageFault {
        name: "6: a reload forgets the session",
        file: "panel.js",
        find: "this.job = await ask(\"/api/job\");",
        with: "this.job = await ask(\"/api/job\"); \
               if (performance.getEntriesByType(\"navigation\")[0].type === \"reload\") this.job.running = null;",
        notices: complaints::c06_reload_within_a_contour_shows_the_truth,
    },
    PageFault {
        name: "7: a tap away, steps change their unit",
        file: "steps.js",
        find: "make(\"small\", {}, texts.step_size),",
        with: "make(\"small\", {}, texts.step_size), button(\"inch\", () => {}),",
        notices: complaints::c04_targets_are_large_and_apart,
    },
    PageFault {
        name: "8: a fault offers no remedy",
        file: "panel.js",
        find: "if (phase === \"faulted\") return button(",
        with: "if (phase === \"never\") return button(",
        notices: port_lost::c08_lost_port_names_the_remedy_and_the_contour_goes_on,
    },
    PageFault {
        name: "9: an interrupted contour is not offered",
        file: "panel.js",
        find: "if (state.session?.interrupted &&",
        with: "if (false &&",
        notices: port_lost::c08_lost_port_names_the_remedy_and_the_contour_goes_on,
    },
    PageFault {
        name: "10: the time left does not run",
        file: "panel.js",
        find: "`${this.texts.left} ${minutes(session.left_s / 60)} ${this.texts.min}`);",
        with: "`${this.texts.left} ${minutes(this.first ??= session.left_s / 60)} ${this.texts.min}`);",
        notices: complaints::c06_reload_within_a_contour_shows_the_truth,
    },
    PageFault {
        name: "11: keys jog while somebody types",
        file: "steering.js",
        find: "const typing = event.target",
        with: "const typing = false && event.target",
        notices: complaints::c11_keys_jog_only_where_they_are_meant,
    },
    PageFault {
        name: "12: the screen falls asleep",
        file: "parts.js",
        find: "lock(); });\n  lock();\n",
        with: "lock(); });\n",
        notices: network::c12_screen_stays_awake_and_strangers_stay_out,
    },
    PageFault {
        name: "inputs repeat the first time stamp",
        file: "link.js",
        find: "seen_us: this.seen };",
        with: "seen_us: this.first ??= this.seen };",
        notices: network::slow_network_costs_comfort_alone,
    },
    PageFault {
        name: "a new machine has its repeatability as contour error",
        file: "steps.js",
        find: "contour_error_um: um(fields.contour_error)",
        with: "contour_error_um: um(fields.repeatability)",
        notices: port_lost::machine_is_stored_by_touch,
    },
];

#[test]
#[ignore = "it runs every complaint's test once more: four minutes"]
fn seeded_faults_are_noticed() {
    let mut missed = Vec::new();
    for fault in FAULTS {
        SEEDED.set(Some(fault));
        let noticed = catch_unwind(AssertUnwindSafe(fault.notices)).is_err();
        println!("{} in {}: {}", if noticed { "noticed" } else { "MISSED" }, fault.file, fault.name);
        if !noticed {
            missed.push(fault.name);
        }
    }
    SEEDED.set(None);
    assert!(missed.is_empty(), "not noticed: {missed:?}");
}

/// Each fault's place is there once.
#[test]
fn seeded_faults_have_their_places() {
    for fault in FAULTS {
        assert_ne!(fault.content(), "", "{fault:?}");
    }
}
