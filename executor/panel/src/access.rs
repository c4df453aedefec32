//! Who may use the panel: the token, the browsers that entered with it, and the headers that a foreign page cannot
//! send.
//!
//! Implements SR-28.

use std::net::SocketAddr;
use std::time::Duration;

use keepout_guard::Time;
use thiserror::Error;

use crate::lease::ClientId;

/// Time for which a token admits new browsers.
pub const TOKEN_LIVES: Duration = Duration::from_secs(15 * 60);
/// Time for which a browser stays admitted.
pub const BROWSER_LIVES: Duration = Duration::from_secs(12 * 3600);
/// Most browsers at once. The oldest one is forgotten first.
const BROWSERS_MAX: usize = 16;
/// Wrong tokens after which the token ends.
const WRONG_MAX: u32 = 20;

/// A secret of 128 random bits.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Secret([u8; 16]);

impl Secret {
    /// A new secret from the system's random numbers.
    ///
    /// # Errors
    /// [`AccessError::Random`] when the system gives none.
    pub fn new() -> Result<Self, AccessError> {
        let mut bytes = [0; 16];
        getrandom::fill(&mut bytes).map_err(AccessError::Random)?;
        Ok(Self(bytes))
    }

    /// Its text: 32 hexadecimal digits.
    #[must_use]
    pub fn text(&self) -> String {
        self.0.iter().fold(String::with_capacity(32), |text, byte| text + &format!("{byte:02x}"))
    }

    /// Whether a text is this secret's. The time that this takes does not depend on where they differ.
    fn is(&self, text: &str) -> bool {
        let own = self.text();
        let differs = own.bytes().zip(text.bytes()).fold(0, |differs, (a, b)| differs | (a ^ b));
        own.len() == text.len() && differs == 0
    }
}

impl std::fmt::Debug for Secret {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Secret(…)")
    }
}

/// Why the panel admits nobody.
#[derive(Debug, Error)]
pub enum AccessError {
    /// The system gives no random numbers.
    #[error("the system gives no random numbers for a token: {0}")]
    Random(getrandom::Error),
}

/// The token and the browsers that entered with it.
#[derive(Debug)]
pub struct Access {
    token: Option<(Secret, Time)>,
    wrong: u32,
    browsers: Vec<(Secret, Time)>,
    /// The secret of each connection, by which the requests of its page are known.
    screens: Vec<(ClientId, Secret)>,
    /// The hosts by which a browser may name this server: with its port.
    hosts: Vec<String>,
}

impl Access {
    /// Access with a new token, for a server at this address.
    ///
    /// # Errors
    /// [`AccessError`] when the system gives no random numbers.
    pub fn new(at: SocketAddr, now: Time) -> Result<Self, AccessError> {
        let mut hosts = vec![at.to_string()];
        if at.ip().is_loopback() {
            hosts.push(format!("localhost:{}", at.port()));
        }
        let token = Some((Secret::new()?, now));
        Ok(Self { token, wrong: 0, browsers: Vec::new(), screens: Vec::new(), hosts })
    }

    /// The text of the token, while it admits browsers.
    #[must_use]
    pub fn token(&self, now: Time) -> Option<String> {
        let (token, since) = self.token.as_ref()?;
        (now.since(*since) <= TOKEN_LIVES).then(|| token.text())
    }

    /// Makes a new token. The browsers that entered before stay.
    ///
    /// # Errors
    /// [`AccessError`] when the system gives no random numbers.
    pub fn renew(&mut self, now: Time) -> Result<(), AccessError> {
        (self.token, self.wrong) = (Some((Secret::new()?, now)), 0);
        Ok(())
    }

    /// Admits a browser that knows the token. Returns the secret that the browser keeps. `None` for a wrong or an old
    /// token.
    ///
    /// # Errors
    /// [`AccessError`] when the system gives no random numbers.
    pub fn enter(&mut self, text: &str, now: Time) -> Result<Option<Secret>, AccessError> {
        let right = self.token.filter(|(token, since)| now.since(*since) <= TOKEN_LIVES && token.is(text));
        if right.is_none() {
            self.wrong += 1;
            if self.wrong >= WRONG_MAX {
                self.token = None;
            }
            return Ok(None);
        }
        let secret = Secret::new()?;
        if self.browsers.len() >= BROWSERS_MAX {
            self.browsers.remove(0);
        }
        self.browsers.push((secret, now));
        Ok(Some(secret))
    }

    /// Whether a browser with this secret entered before.
    #[must_use]
    pub fn admits(&self, text: &str, now: Time) -> bool {
        let admits = |(secret, since): &(Secret, Time)| secret.is(text) && now.since(*since) <= BROWSER_LIVES;
        self.browsers.iter().any(admits)
    }

    /// Gives a new connection its secret.
    ///
    /// # Errors
    /// [`AccessError`] when the system gives no random numbers.
    pub fn connect(&mut self, client: ClientId) -> Result<Secret, AccessError> {
        let secret = Secret::new()?;
        self.screens.push((client, secret));
        Ok(secret)
    }

    /// A connection is gone: its secret is no longer known.
    pub fn disconnect(&mut self, client: ClientId) {
        self.screens.retain(|(connected, _)| *connected != client);
    }

    /// The connection with this secret.
    #[must_use]
    pub fn connection(&self, text: &str) -> Option<ClientId> {
        self.screens.iter().find(|(_, secret)| secret.is(text)).map(|(client, _)| *client)
    }

    /// Whether the header `Host` names this server. A page of another name that resolves to this address does not.
    #[must_use]
    pub fn is_host(&self, host: &str) -> bool {
        self.hosts.iter().any(|own| own.eq_ignore_ascii_case(host))
    }

    /// Whether the header `Origin` is of this server's own page.
    #[must_use]
    pub fn is_origin(&self, origin: &str) -> bool {
        origin.strip_prefix("http://").is_some_and(|host| self.is_host(host))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(seconds: u64) -> Time {
        Time::ZERO.after(Duration::from_secs(seconds))
    }

    fn access() -> Access {
        Access::new(SocketAddr::from(([127, 0, 0, 1], 8123)), Time::ZERO).unwrap()
    }

    // Evidence for SR-28.
    #[test]
    fn token_admits_for_a_quarter_of_an_hour_and_a_browser_for_a_day() {
        let mut access = access();
        let token = access.token(after(0)).unwrap();
        let browser = access.enter(&token, after(900)).unwrap().unwrap().text();
        assert!(access.enter(&token, after(901)).unwrap().is_none() && access.token(after(901)).is_none());
        assert!(
            access.admits(&browser, after(900 + 43_200)) && !access.admits(&browser, after(900 + 43_201))
        );
        assert!(!access.admits(&token, after(900)) && !access.admits("", after(900)));
        access.renew(after(1000)).unwrap();
        assert_ne!(access.token(after(1000)), Some(token));
        assert!(access.admits(&browser, after(1000)), "a new token leaves the browsers");
    }

    // Evidence for SR-28.
    #[test]
    fn token_cannot_be_guessed_for_long() {
        let mut access = access();
        let token = access.token(after(0)).unwrap();
        for guess in 0..WRONG_MAX {
            assert!(access.enter(&format!("{guess:032x}"), after(1)).unwrap().is_none());
        }
        assert!(access.enter(&token, after(1)).unwrap().is_none(), "the token has ended");
        assert_eq!(access.token(after(1)), None);
        for _ in 0..2 * BROWSERS_MAX {
            access.renew(after(2)).unwrap();
            let token = access.token(after(2)).unwrap();
            access.enter(&token, after(2)).unwrap();
        }
        assert_eq!(access.browsers.len(), BROWSERS_MAX);
    }

    #[test]
    fn other_names_and_pages_are_foreign() {
        let access = access();
        for own in ["127.0.0.1:8123", "localhost:8123", "LOCALHOST:8123"] {
            assert!(access.is_host(own) && access.is_origin(&format!("http://{own}")), "{own}");
        }
        for other in ["127.0.0.1", "127.0.0.1:8124", "evil.example:8123", "127.0.0.1:8123.evil.example", ""] {
            assert!(!access.is_host(other) && !access.is_origin(&format!("http://{other}")), "{other}");
        }
        assert!(!access.is_origin("null") && !access.is_origin("https://127.0.0.1:8123"));
    }
}
