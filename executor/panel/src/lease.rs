//! The control lease: one client steers, the others watch.
//!
//! Implements SR-28.

use std::time::Duration;

use keepout_guard::Time;

/// Number of a client: of one connection of one browser.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ClientId(pub u64);

/// Silence of the holder after which another client takes the lease without asking.
pub const SILENCE: Duration = Duration::from_secs(3);
/// Time for which a request for the lease stands.
pub const REQUEST_STANDS: Duration = Duration::from_secs(15);

/// Who holds the control lease, and who asks for it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Lease {
    holder: Option<(ClientId, Time)>,
    request: Option<(ClientId, Time)>,
}

/// The answer to a client that wants the lease.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LeaseAnswer {
    /// The client holds it now.
    Granted,
    /// Another client holds it. The panel asks that client.
    Asked,
}

impl Lease {
    /// The client that holds the lease. It may have been silent for long.
    #[must_use]
    pub fn holder(&self) -> Option<ClientId> {
        self.holder.map(|(client, _)| client)
    }

    /// Whether the client holds the lease.
    #[must_use]
    pub fn is_held_by(&self, client: ClientId) -> bool {
        self.holder() == Some(client)
    }

    /// How long the holder has been silent. `None` without a holder.
    #[must_use]
    pub fn silent_for(&self, now: Time) -> Option<Duration> {
        self.holder.map(|(_, heard)| now.since(heard))
    }

    /// The client that asks for the lease.
    #[must_use]
    pub fn request(&self, now: Time) -> Option<ClientId> {
        let (client, asked) = self.request?;
        (now.since(asked) <= REQUEST_STANDS).then_some(client)
    }

    /// Takes note of a sign of life.
    pub fn heard(&mut self, client: ClientId, now: Time) {
        if let Some((_, heard)) = self.holder.as_mut().filter(|(holder, _)| *holder == client) {
            *heard = now;
        }
    }

    /// A client wants the lease. It gets it from nobody, or from a holder that has been silent; otherwise the holder is
    /// asked.
    pub fn take(&mut self, client: ClientId, now: Time) -> LeaseAnswer {
        let free = self.holder.is_none_or(|(holder, heard)| holder == client || now.since(heard) > SILENCE);
        if !free {
            self.request = Some((client, now));
            return LeaseAnswer::Asked;
        }
        self.holder = Some((client, now));
        self.request = self.request.filter(|(asking, _)| *asking != client);
        LeaseAnswer::Granted
    }

    /// The holder answers the request. Nothing happens for another client's answer, or without a standing request.
    pub fn answer(&mut self, client: ClientId, consents: bool, now: Time) {
        if !self.is_held_by(client) {
            return;
        }
        if let Some(asking) = self.request(now).filter(|_| consents) {
            self.holder = Some((asking, now));
        }
        self.request = None;
    }

    /// The client gives the lease back, or its connection is gone.
    pub fn leave(&mut self, client: ClientId) {
        self.holder = self.holder.filter(|(holder, _)| *holder != client);
        self.request = self.request.filter(|(asking, _)| *asking != client);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ONE: ClientId = ClientId(1);
    const TWO: ClientId = ClientId(2);
    const THREE: ClientId = ClientId(3);

    fn at(ms: u64) -> Time {
        Time::ZERO.after(Duration::from_millis(ms))
    }

    #[test]
    fn second_client_takes_over_with_consent_or_after_silence() {
        let mut lease = Lease::default();
        assert_eq!(lease.take(ONE, at(0)), LeaseAnswer::Granted);
        lease.heard(ONE, at(2000));
        assert_eq!(lease.take(TWO, at(2100)), LeaseAnswer::Asked);
        assert_eq!(lease.request(at(2200)), Some(TWO));
        lease.answer(TWO, true, at(2200));
        lease.answer(THREE, true, at(2200));
        assert!(lease.is_held_by(ONE), "only the holder consents");
        lease.answer(ONE, false, at(2300));
        assert_eq!((lease.holder(), lease.request(at(2300))), (Some(ONE), None));
        lease.take(TWO, at(2400));
        lease.answer(ONE, true, at(2500));
        assert!(lease.is_held_by(TWO));
        assert_eq!(lease.take(ONE, at(5500)), LeaseAnswer::Asked);
        assert_eq!(lease.take(ONE, at(5501)), LeaseAnswer::Granted, "the holder has been silent for 3 s");
    }

    #[test]
    fn old_request_and_one_of_a_client_that_left_are_not_granted() {
        let mut lease = Lease::default();
        lease.take(ONE, at(0));
        lease.take(TWO, at(0));
        lease.heard(ONE, at(15_001));
        lease.answer(ONE, true, at(15_001));
        assert!(lease.is_held_by(ONE));
        lease.take(TWO, at(15_100));
        lease.leave(TWO);
        lease.answer(ONE, true, at(15_200));
        assert!(lease.is_held_by(ONE));
        lease.leave(ONE);
        assert_eq!((lease.holder(), lease.silent_for(at(16_000))), (None, None));
    }

    // Evidence for SR-28.
    /// Whatever clients do, at most one holds the lease, and nobody takes it from a holder that is heard and does not
    /// consent.
    #[test]
    fn lease_is_never_taken_from_a_holder_that_is_heard() {
        let mut random = fastrand::Rng::with_seed(6);
        let (mut lease, mut now) = (Lease::default(), Time::ZERO);
        // When the holder was last heard, counted here.
        let mut heard = now;
        for _ in 0..100_000 {
            now = now.after(Duration::from_millis(random.u64(0..900)));
            let client = ClientId(random.u64(0..4));
            let before = lease.holder();
            let kept = before.is_some() && now.since(heard) <= SILENCE;
            match random.u8(0..5) {
                0 | 1 => {
                    lease.heard(client, now);
                    heard = if before == Some(client) { now } else { heard };
                }
                2 => {
                    let answer = lease.take(client, now);
                    heard = if answer == LeaseAnswer::Granted { now } else { heard };
                    assert_eq!(answer == LeaseAnswer::Granted, lease.is_held_by(client));
                    assert!(!kept || lease.holder() == before);
                }
                3 => {
                    let asking = lease.request(now);
                    lease.answer(client, random.bool(), now);
                    let moved = lease.holder() != before;
                    heard = if moved { now } else { heard };
                    assert!(!moved || before == Some(client) && lease.holder() == asking);
                }
                _ => {
                    lease.leave(client);
                    assert!(!lease.is_held_by(client));
                }
            }
        }
    }
}
