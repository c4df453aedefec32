//! Exchanges with a controller that takes one line at a time: a line goes out when the previous one is
//! answered.
//!
//! Implements SR-10, SR-18.

use arrayvec::ArrayVec;

/// Longest line to send, bytes.
pub(super) const SENT_MAX: usize = 120;
/// Most lines that wait for their turn.
const WAITING_MAX: usize = 16;
/// Most unanswered lines: one, and stops that were sent out of turn.
const OPEN_MAX: usize = 8;

/// Most repeated query requests, one second or more apart, before an unanswered exchange counts as lost.
const IN_VAIN_MAX: u8 = 1;

/// A line to send.
pub(super) type Sent = ArrayVec<u8, SENT_MAX>;

/// The waiting lines and the unanswered exchanges.
///
/// `K` names the purpose of a line and so the form of its answer. `P` is the received part of an answer; it
/// is dropped together with its exchange.
///
/// A line is dropped when there is no room for it, and by [`Exchanges::withdraw`], [`Exchanges::give_up`] and
/// [`Exchanges::clear`]. Lines keep their order, except stops.
#[derive(Clone, Debug)]
pub(super) struct Exchanges<K, P = ()> {
    open: ArrayVec<K, OPEN_MAX>,
    part: Option<P>,
    waiting: ArrayVec<(K, Sent), WAITING_MAX>,
    /// Repeated query requests since the last answer.
    in_vain: u8,
}

impl<K, P> Default for Exchanges<K, P> {
    fn default() -> Self {
        Self { open: ArrayVec::new(), part: None, waiting: ArrayVec::new(), in_vain: 0 }
    }
}

impl<K: Copy, P: Copy> Exchanges<K, P> {
    /// Queues a line, and sends it in its turn. If the queue is full, the line is dropped and never answered.
    pub(super) fn send(&mut self, kind: K, line: Sent, out: &mut Vec<u8>) {
        let _ = self.waiting.try_push((kind, line));
        self.next(out);
    }

    /// Sends a line now, ahead of all waiting lines. With [`OPEN_MAX`] unanswered lines it is dropped.
    pub(super) fn send_now(&mut self, kind: K, line: &[u8], out: &mut Vec<u8>) {
        if self.open.try_push(kind).is_ok() {
            out.extend(line);
        }
    }

    /// Sends a line ahead of all waiting lines, as soon as the open exchanges are answered. If the queue is
    /// full, the line is dropped.
    pub(super) fn send_next(&mut self, kind: K, line: Sent, out: &mut Vec<u8>) {
        if !self.waiting.is_full() {
            self.waiting.insert(0, (kind, line));
        }
        self.next(out);
    }

    /// The oldest unanswered exchange.
    pub(super) fn open(&self) -> Option<K> {
        self.open.first().copied()
    }

    /// The received part of the answer to the oldest unanswered exchange.
    pub(super) fn part(&self) -> Option<P> {
        self.part
    }

    /// Replaces the received part of the answer to the oldest unanswered exchange.
    pub(super) fn hear(&mut self, part: Option<P>) {
        self.part = part;
    }

    /// Whether exactly one exchange is unanswered.
    pub(super) fn is_single(&self) -> bool {
        self.open.len() == 1
    }

    /// Closes the oldest exchange as answered, and sends the next line.
    pub(super) fn close(&mut self, out: &mut Vec<u8>) -> Option<K> {
        let closed = self.open.pop_at(0);
        self.part = None;
        self.in_vain = 0;
        self.next(out);
        closed
    }

    /// Whether a requested query must be sent. It is not sent while another query waits or is unanswered.
    /// After more than [`IN_VAIN_MAX`] repeated requests without any answer, the unanswered exchanges count
    /// as lost.
    pub(super) fn wants_query(&mut self, is_query: impl Fn(&K) -> bool, out: &mut Vec<u8>) -> bool {
        if !self.any(&is_query) {
            return true;
        }
        self.in_vain += 1;
        if self.in_vain > IN_VAIN_MAX {
            self.give_up(out);
        }
        !self.any(is_query)
    }

    /// Removes waiting lines that must not be sent, because the controller rejected a line that they depend
    /// on.
    pub(super) fn withdraw(&mut self, is: impl Fn(&K) -> bool) {
        self.waiting.retain(|(kind, _)| !is(kind));
    }

    /// Gives up all unanswered exchanges, and sends the next line.
    pub(super) fn give_up(&mut self, out: &mut Vec<u8>) {
        self.open.clear();
        self.part = None;
        self.in_vain = 0;
        self.next(out);
    }

    /// Whether a line that satisfies `is` waits or is unanswered.
    pub(super) fn any(&self, is: impl Fn(&K) -> bool) -> bool {
        self.waiting.iter().any(|(kind, _)| is(kind)) || self.open.iter().any(is)
    }

    /// Drops all exchanges, open and waiting.
    pub(super) fn clear(&mut self) {
        self.open.clear();
        self.part = None;
        self.waiting.clear();
    }

    fn next(&mut self, out: &mut Vec<u8>) {
        if self.open.is_empty()
            && let Some((kind, line)) = self.waiting.pop_at(0)
        {
            self.send_now(kind, &line, out);
        }
    }
}

/// A line of these bytes, cut off at the longest line.
pub(super) fn sent(bytes: &[u8]) -> Sent {
    bytes.iter().copied().take(SENT_MAX).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    type Ends = fn(&mut Exchanges<u8, u8>, &mut Vec<u8>);

    #[test]
    fn partial_answer_is_dropped_with_its_exchange() {
        let ends: [Ends; 3] = [
            |exchanges, out| _ = exchanges.close(out),
            |exchanges, out| exchanges.give_up(out),
            |exchanges, _| exchanges.clear(),
        ];
        for end in ends {
            let (mut exchanges, mut out) = (Exchanges::default(), Vec::new());
            exchanges.send(1, sent(b"a"), &mut out);
            exchanges.hear(Some(7));
            exchanges.send(2, sent(b"b"), &mut out);
            assert_eq!(exchanges.part(), Some(7));
            end(&mut exchanges, &mut out);
            assert_eq!(exchanges.part(), None);
        }
    }

    // Evidence for SR-10.
    #[test]
    fn lines_go_out_one_at_a_time_and_stops_go_first() {
        let (mut exchanges, mut out) = (Exchanges::<_>::default(), Vec::new());
        for (kind, line) in [(1, b"a"), (2, b"b"), (3, b"c")] {
            exchanges.send(kind, sent(line), &mut out);
        }
        assert_eq!(out, b"a");
        exchanges.send_next(4, sent(b"s"), &mut out);
        exchanges.send_now(5, b"!", &mut out);
        assert_eq!(out, b"a!");
        let closed: Vec<_> = (0..7).map_while(|_| exchanges.close(&mut out)).collect();
        assert_eq!((out.as_slice(), closed.as_slice()), (&b"a!sbc"[..], &[1, 5, 4, 2, 3][..]));
    }

    #[test]
    fn query_is_sent_once_and_given_up_without_an_answer() {
        let (mut exchanges, mut out) = (Exchanges::<_>::default(), Vec::new());
        let is_query = |kind: &i32| *kind == 7;
        assert!(exchanges.wants_query(is_query, &mut out));
        exchanges.send(1, sent(b"m"), &mut out);
        exchanges.send(7, sent(b"q"), &mut out);
        assert!(!exchanges.wants_query(is_query, &mut out) && out == b"m");
        exchanges.close(&mut out);
        assert!(!exchanges.wants_query(is_query, &mut out) && out == b"mq");
        assert!(exchanges.wants_query(is_query, &mut out), "the second repeated request gives it up");
    }

    #[test]
    fn queue_and_output_are_bounded() {
        let (mut exchanges, mut out) = (Exchanges::<_>::default(), Vec::new());
        for k in 0..1000 {
            exchanges.send(k, sent(&[b'x'; 500]), &mut out);
            exchanges.send_now(k, b"!", &mut out);
            exchanges.send_next(k, sent(b"?"), &mut out);
        }
        assert!(out.len() <= SENT_MAX + OPEN_MAX);
        exchanges.give_up(&mut out);
        assert!(exchanges.any(|_| true));
    }
}
