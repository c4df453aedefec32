//! The first line of a log: what its session was set up with.

use keepout_kernel::exact::segment::Window;
use keepout_kernel::{Point, Vector};
use keepout_planner::job::Progress;

use super::job;
use super::line::{LineError, quoted, unquoted};

/// What a log says of its session: enough to play it again.
#[derive(Clone, Debug, PartialEq)]
pub struct Header {
    /// When the session began by the computer's clock: date and time, UTC, as RFC 3339 writes them.
    pub began: String,
    /// SHA-256 of the plan file's content.
    pub plan: String,
    /// Name of the drawing.
    pub drawing: String,
    /// The dialect, as it is asked for on the command line.
    pub dialect: String,
    /// SHA-256 of the text that describes it; empty for one that is built in, and in logs of earlier versions.
    pub description: String,
    /// Whether nothing but a simulated machine moved.
    pub simulated: bool,
    /// Machine coordinates less drawing coordinates.
    pub offset: Vector,
    /// The machine's travel in x and y, mm; logs of earlier versions do not say it.
    pub travel_mm: Option<[f64; 2]>,
    /// Where the tool may go of that, drawing coordinates.
    pub travel: Window,
    /// Feed of the contour, mm/min.
    pub feed_mm_min: u32,
    /// Whether the session begins with homing.
    pub home: bool,
    /// Longest silence of the controller, ms.
    pub answer_within_ms: u64,
    /// Baud rate of the line; 4800, the slowest, in logs of earlier versions.
    pub baud: u32,
    /// What an earlier session had done of the plan's contours.
    pub progress: Progress,
    /// Who steers, as asked for on the command line.
    pub operator: String,
    /// The machine and its port, in words.
    pub setting: String,
}

impl Default for Header {
    fn default() -> Self {
        Self {
            began: String::new(),
            plan: String::new(),
            drawing: String::new(),
            dialect: String::new(),
            description: String::new(),
            simulated: false,
            offset: Vector { dx: 0, dy: 0 },
            travel_mm: None,
            travel: Window::of(Point::ORIGIN),
            feed_mm_min: 0,
            home: false,
            answer_within_ms: 0,
            baud: 115_200,
            progress: Progress::default(),
            operator: String::new(),
            setting: String::new(),
        }
    }
}

const MAGIC: &str = "keepout-log 1";

/// The first line.
pub(super) fn text(header: &Header) -> String {
    let (x0, y0, x1, y1) = header.travel.corners();
    let mut progress = String::new();
    job::push_progress(&mut progress, &header.progress);
    let travel = header.travel_mm.map_or(String::new(), |[x, y]| format!(" travel={x},{y}"));
    let description = match &header.description {
        none if none.is_empty() => String::new(),
        hash => format!(" description={}", quoted(hash)),
    };
    format!(
        "{MAGIC} began={} plan={} drawing={} dialect={}{description} simulated={} offset={},{}{travel} stroke={x0},{y0},{x1},{y1} feed={} home={} answer={} baud={} progress={} operator={} setting={}",
        quoted(&header.began),
        quoted(&header.plan),
        quoted(&header.drawing),
        quoted(&header.dialect),
        u8::from(header.simulated),
        header.offset.dx,
        header.offset.dy,
        header.feed_mm_min,
        u8::from(header.home),
        header.answer_within_ms,
        header.baud,
        quoted(&progress),
        quoted(&header.operator),
        quoted(&header.setting),
    )
}

/// Reads the first line.
pub(super) fn parse(text: &str) -> Result<Header, LineError> {
    let bad = || LineError::Form(text.chars().take(200).collect());
    let rest = text.strip_prefix(MAGIC).ok_or_else(bad)?;
    let field = |name: &str| {
        rest.split(' ').find_map(|field| field.strip_prefix(name)?.strip_prefix('=')).ok_or_else(bad)
    };
    let numbers = |name: &str| -> Result<Vec<i32>, LineError> {
        field(name)?.split(',').map(|number| number.parse().map_err(|_| bad())).collect()
    };
    let word = |name: &str| unquoted(field(name)?).ok_or_else(bad);
    let (offset, travel) = (numbers("offset")?, numbers("stroke")?);
    let (&[dx, dy], &[x0, y0, x1, y1]) = (&offset[..], &travel[..]) else { return Err(bad()) };
    let travel_mm = match field("travel") {
        Ok(travel) => {
            let mm = travel.split(',').map(|number| number.parse().ok().filter(|mm: &f64| mm.is_finite()));
            let [x, y] =
                mm.collect::<Option<Vec<f64>>>().and_then(|mm| mm.try_into().ok()).ok_or_else(bad)?;
            Some([x, y])
        }
        Err(_) => None,
    };
    let corner = |x: i32, y: i32| Point::from_units(x.into(), y.into()).map_err(|_| bad());
    Ok(Header {
        began: word("began")?,
        plan: word("plan")?,
        drawing: word("drawing")?,
        dialect: word("dialect")?,
        description: field("description").map_or(Some(String::new()), unquoted).ok_or_else(bad)?,
        // Logs of earlier versions do not say it.
        simulated: field("simulated").is_ok_and(|simulated| simulated == "1"),
        offset: corner(dx, dy)?.minus(Point::ORIGIN),
        travel_mm,
        travel: Window::of(corner(x0, y0)?).including(corner(x1, y1)?),
        feed_mm_min: field("feed")?.parse().map_err(|_| bad())?,
        home: field("home")? == "1",
        answer_within_ms: field("answer")?.parse().map_err(|_| bad())?,
        baud: field("baud").map_or(Ok(4800), |baud| baud.parse().map_err(|_| bad()))?,
        progress: job::parse_progress(&word("progress")?).ok_or_else(bad)?,
        operator: word("operator")?,
        setting: word("setting")?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_are_read_as_they_were_written() {
        let mut progress = keepout_planner::job::Progress::default();
        progress.finish(keepout_planner::job::LoopNumber { pass: 1, index: 7 });
        let header = Header {
            began: "2026-11-21T16:38:20Z".into(),
            plan: "9f86".into(),
            drawing: "a part = \"ä\" plan=x.dxf\t\n".into(),
            dialect: "/some where/dialect.toml".into(),
            description: "41d5".into(),
            simulated: true,
            offset: Vector { dx: -20_000_000, dy: 500 },
            travel_mm: Some([400.125, 1.0 / 3.0]),
            travel: Window::of(Point::from_units(-5, -7).unwrap()).including(Point::ORIGIN),
            feed_mm_min: 900,
            home: true,
            answer_within_ms: 5000,
            baud: 9600,
            progress,
            operator: "trace:a b".into(),
            setting: "the old mill, /dev/ttyUSB0".into(),
        };
        let written = text(&header);
        assert!(!written.contains(['\t', '\n']));
        assert_eq!(parse(&written), Ok(header));
        assert!(parse(&written.replace("keepout-log 1", "keepout-log 2")).is_err());
        assert!(!parse(&written.replace(" simulated=1", "")).unwrap().simulated);
        assert_eq!(parse(&written.replace(" description=", " unread=")).unwrap().description, "");
        assert!(parse(&written.replace(" travel=400.125,", " travel=nan,")).is_err());
        let unsaid = parse(&written.replace(" travel=400.125,", " unread=")).unwrap();
        assert_eq!(unsaid.travel_mm, None);
        assert!(parse(&written.replace("offset=-20000000", "offset=-2147483648")).is_err());
    }
}
