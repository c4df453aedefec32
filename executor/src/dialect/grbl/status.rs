//! A status report, field by field.
//!
//! Implements SR-18.

use keepout_kernel::Place;

use super::super::lines::place;
use super::buffers::Free;
use super::meaning::mode;
use crate::supervisor::Mode;

/// A status report of a GRBL controller, machine coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Status<'a> {
    /// The state, as the controller's word.
    pub state: &'a str,
    /// The state, as the supervisor's mode.
    pub mode: Mode,
    /// The machine position.
    pub position: Option<Place>,
    /// Free planner blocks and free bytes of the receive buffer.
    pub free: Option<Free>,
    /// The work coordinate offset.
    pub offset: Option<Place>,
    /// The feed, mm/min.
    pub feed_mm_min: Option<f64>,
    /// The feed override, per cent.
    pub feed_percent: Option<u16>,
}

impl<'a> Status<'a> {
    /// Reads a line `<…>` of a machine with two or `three` axes. `None` when it is malformed: then no part of
    /// it is used.
    #[must_use]
    pub fn parse(line: &'a str, three: bool) -> Option<Self> {
        let inner = line.strip_prefix('<')?.strip_suffix('>')?;
        let mut fields = inner.split('|');
        let state = fields.next()?;
        let mut status = Self {
            state,
            mode: mode(state)?,
            position: None,
            free: None,
            offset: None,
            feed_mm_min: None,
            feed_percent: None,
        };
        let mut later = fields.clone();
        for field in fields {
            later.next();
            let (name, value) = field.split_once(':')?;
            // A repeated field shows that two reports were joined, and its values belong to neither.
            if later.clone().any(|field| field.split_once(':').is_some_and(|(again, _)| again == name)) {
                return None;
            }
            match name {
                "MPos" => status.position = Some(place(value, three)?),
                "Bf" => {
                    let (blocks, bytes) = value.split_once(',')?;
                    status.free = Some((blocks.parse().ok()?, bytes.parse().ok()?));
                }
                "WCO" => status.offset = Some(place(value, three)?),
                "F" | "FS" => status.feed_mm_min = value.split(',').next().and_then(|feed| feed.parse().ok()),
                "Ov" => status.feed_percent = Some(value.split(',').next()?.parse().ok()?),
                _ => {}
            }
        }
        Some(status)
    }
}
