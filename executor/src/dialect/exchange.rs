//! Exchanges with a controller that takes one line at a time: the next is sent when the one before is answered.

use arrayvec::ArrayVec;

/// Longest line that is sent.
pub(super) const SENT_MAX: usize = 120;
/// Most exchanges that wait.
const WAITING_MAX: usize = 16;
/// Most lines on the wire: one, and stops that could not wait.
const OPEN_MAX: usize = 8;

/// Queries asked for again, each after a second or more, before an answer is taken to be lost.
const IN_VAIN_MAX: u8 = 1;

/// A line to send.
pub(super) type Sent = ArrayVec<u8, SENT_MAX>;

/// Lines that wait for their turn, and what is unanswered. `K` says what a line is, and so what its answer is; `P` is what was
/// heard of an answer in parts, and is forgotten with the exchange that it belongs to.
///
/// Nothing is dropped but by [`Exchanges::withdraw`], [`Exchanges::give_up`] and [`Exchanges::clear`], and lines stay in order but for stops.
#[derive(Clone, Debug)]
pub(super) struct Exchanges<K, P = ()> {
    open: ArrayVec<K, OPEN_MAX>,
    part: Option<P>,
    waiting: ArrayVec<(K, Sent), WAITING_MAX>,
    /// Queries asked for since anything was answered.
    in_vain: u8,
}

impl<K, P> Default for Exchanges<K, P> {
    fn default() -> Self {
        Self { open: ArrayVec::new(), part: None, waiting: ArrayVec::new(), in_vain: 0 }
    }
}

impl<K: Copy, P: Copy> Exchanges<K, P> {
    /// Sends a line when it is its turn. Should there be no room, it is never sent, and so never answered.
    pub(super) fn send(&mut self, kind: K, line: Sent, out: &mut Vec<u8>) {
        let _ = self.waiting.try_push((kind, line));
        self.next(out);
    }

    /// Sends a line now, before all that wait.
    pub(super) fn send_now(&mut self, kind: K, line: &[u8], out: &mut Vec<u8>) {
        if self.open.try_push(kind).is_ok() {
            out.extend(line);
        }
    }

    /// Sends a line before all that wait, once what is open is answered.
    pub(super) fn send_next(&mut self, kind: K, line: Sent, out: &mut Vec<u8>) {
        if !self.waiting.is_full() {
            self.waiting.insert(0, (kind, line));
        }
        self.next(out);
    }

    /// The oldest exchange that is unanswered.
    pub(super) fn open(&self) -> Option<K> {
        self.open.first().copied()
    }

    /// What was heard of the oldest exchange that is unanswered.
    pub(super) fn part(&self) -> Option<P> {
        self.part
    }

    /// Takes a part of the answer to the oldest exchange that is unanswered, in place of what was heard of it before.
    pub(super) fn hear(&mut self, part: Option<P>) {
        self.part = part;
    }

    /// Whether one exchange is unanswered, and no more.
    pub(super) fn is_single(&self) -> bool {
        self.open.len() == 1
    }

    /// The oldest exchange is answered: the next line is sent.
    pub(super) fn close(&mut self, out: &mut Vec<u8>) -> Option<K> {
        let closed = self.open.pop_at(0);
        self.part = None;
        self.in_vain = 0;
        self.next(out);
        closed
    }

    /// A query is asked for: whether one is to be sent. While one is under way already it is not, but when nothing at all was
    /// answered for so long, what is unanswered is lost.
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

    /// Lines that wait and shall not be sent after all: what they needed was refused.
    pub(super) fn withdraw(&mut self, is: impl Fn(&K) -> bool) {
        self.waiting.retain(|(kind, _)| !is(kind));
    }

    /// What is unanswered is not waited for any longer.
    pub(super) fn give_up(&mut self, out: &mut Vec<u8>) {
        self.open.clear();
        self.part = None;
        self.in_vain = 0;
        self.next(out);
    }

    /// Whether such a line waits or is unanswered.
    pub(super) fn any(&self, is: impl Fn(&K) -> bool) -> bool {
        self.waiting.iter().any(|(kind, _)| is(kind)) || self.open.iter().any(is)
    }

    /// Forgets everything.
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

/// A line of these bytes, as far as they fit.
pub(super) fn sent(bytes: &[u8]) -> Sent {
    bytes.iter().copied().take(SENT_MAX).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    type Ends = fn(&mut Exchanges<u8, u8>, &mut Vec<u8>);

    #[test]
    fn parts_of_an_answer_are_forgotten_with_their_exchange() {
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

    #[test]
    fn one_line_at_a_time_and_stops_first() {
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
    fn queries_are_asked_once_and_given_up_when_nothing_is_answered() {
        let (mut exchanges, mut out) = (Exchanges::<_>::default(), Vec::new());
        let is_query = |kind: &i32| *kind == 7;
        assert!(exchanges.wants_query(is_query, &mut out));
        exchanges.send(1, sent(b"m"), &mut out);
        exchanges.send(7, sent(b"q"), &mut out);
        assert!(!exchanges.wants_query(is_query, &mut out) && out == b"m");
        exchanges.close(&mut out);
        assert!(!exchanges.wants_query(is_query, &mut out) && out == b"mq");
        assert!(exchanges.wants_query(is_query, &mut out), "the second time in a row it is lost");
    }

    #[test]
    fn is_bounded() {
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
