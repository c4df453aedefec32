//! The figures of the paper: what it states, and what we found.

use keepout_drives::controllers::kind::Kind;

/// A controller in a figure, and the error of its model as a share.
type Shown = (Kind, f64);

/// A figure of the paper.
pub(super) struct PaperFigure {
    pub(super) number: &'static str,
    pub(super) row: &'static str,
    pub(super) shown: &'static [Shown],
    /// The paper's statement.
    pub(super) says: &'static str,
    /// Our result.
    pub(super) found: &'static str,
}

const FEEDBACK: [Shown; 4] = [(Kind::P, 0.0), (Kind::Pid, 0.0), (Kind::Zpetc, 0.0), (Kind::Ccc, 0.0)];
const CORNERS: [Shown; 5] =
    [(Kind::P, 0.0), (Kind::Pid, 0.0), (Kind::Zpetc, 0.0), (Kind::Ikf, 0.0), (Kind::Ccc, 0.0)];
const WRONG: [Shown; 4] = [(Kind::Zpetc, 0.0), (Kind::Zpetc, 0.02), (Kind::Zpetc, 0.05), (Kind::Ccc, 0.0)];
const MACHINE: [Shown; 4] = [(Kind::P, 0.0), (Kind::Pid, 0.0), (Kind::Zpetc, 0.02), (Kind::Ccc, 0.0)];

/// The figures, in order.
pub(super) const FIGURES: [PaperFigure; 11] = [
    PaperFigure {
        number: "Fig. 11",
        row: "S2",
        shown: &FEEDBACK,
        says: "The axial errors of PID are much smaller than those of P (±0.35 mm instead of ±3.2 mm), but\n\
               its contour error is larger. ZPETC is best with an exact model. CCC is far better than P and\n\
               PID.",
        found: "Reproduced.",
    },
    PaperFigure {
        number: "Fig. 12",
        row: "S3",
        shown: &FEEDBACK,
        says: "The gains differ by 15 % and the time constants by 44 %. All controllers except P reach a\n\
               very small contour error. ZPETC is best.",
        found: "Reproduced.",
    },
    PaperFigure {
        number: "Fig. 13",
        row: "S1",
        shown: &WRONG,
        says: "ZPETC is better than CCC only when the model error is less than 0.5 %.",
        found: "**Holds by a special reading only.** If only the time constant of one axis is wrong, the RMS errors\n\
                are equal at 0.51 %. With our reading of \"2 %\" (both axes, gains and time constants) \
                they are equal at\n\
                0.015 %. The test `figure_13_the_model_error_where_both_are_equal` computes both.",
    },
    PaperFigure {
        number: "Fig. 14",
        row: "S7",
        shown: &FEEDBACK,
        says: "Saturation strongly limits ZPETC. It usually does not influence CCC, P and PID.",
        found: "Reproduced for ZPETC, CCC and P. **Not reproduced** for PID: its integral winds up at the\n\
                start, and the error is large. It then depends on the limit, which the paper does not state.",
    },
    PaperFigure {
        number: "Fig. 15",
        row: "S4",
        shown: &FEEDBACK,
        says: "CCC and PID reject friction well, and CCC is best. P and ZPETC reject it very poorly.",
        found: "Reproduced.",
    },
    PaperFigure {
        number: "Fig. 16",
        row: "S5",
        shown: &FEEDBACK,
        says: "The same holds for the cutting force.",
        found: "Reproduced, with the force at 45° to the path. The paper does not state the angle. At 0° the\n\
                force causes no contour error.",
    },
    PaperFigure {
        number: "Fig. 17",
        row: "S6",
        shown: &CORNERS,
        says: "P is average, PID overshoots, ZPETC and CCC are accurate.",
        found: "Reproduced.",
    },
    PaperFigure {
        number: "Fig. 18",
        row: "S6b",
        shown: &CORNERS,
        says: "With a limit ZPETC fails at the corner; IKF does not.",
        found: "Reproduced, with |U| ≤ 200 and two poles of 10 ms.\n\
                The paper states neither the limit nor the filter.",
    },
    PaperFigure {
        number: "Fig. 19",
        row: "E1",
        shown: &MACHINE,
        says: "Measured. ZPETC is worst on the line, PID overshoots, CCC is best.",
        found: "Reproduced in part: CCC is best, then PID, then P and ZPETC. Whether P or ZPETC is worse depends on\n\
                the signs of the model error. PID overshoots at the end of the line, see below.",
    },
    PaperFigure {
        number: "Fig. 20",
        row: "E2",
        shown: &MACHINE,
        says: "Measured. Because of the friction, only CCC and PID have small errors.",
        found: "Reproduced.",
    },
    PaperFigure {
        number: "Fig. 21",
        row: "E3",
        shown: &MACHINE,
        says: "Measured. PID fails at the higher feed. ZPETC tracks better than P and PID.\n\
               Only CCC has a small error.",
        found: "Reproduced for CCC. **Not reproduced:** ZPETC is not better than PID. With the stated\n\
                friction, ZPETC has the error of P, because both use the feedback of P.",
    },
];
