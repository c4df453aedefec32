//! The socket of one browser: states go out twenty times a second, inputs and commands come in.
//!
//! Implements SR-28.

use std::time::Duration;

use axum::extract::State;
use axum::extract::ws::{Message, WebSocket, WebSocketUpgrade};
use axum::response::Response;
use keepout_guard::Time;

use super::PanelSite;
use crate::lease::ClientId;
use crate::protocol::{MESSAGE_MAX, PanelAction, RefusedMessage, SessionMessage, StateMessage};

/// Time between two states.
const EVERY: Duration = Duration::from_millis(50);
/// Time within which a browser must take a state. A browser that does not is cut off.
const TAKES_WITHIN: Duration = Duration::from_secs(5);
/// Messages that a browser may send in a second, and at once.
const MESSAGES_A_SECOND: f64 = 100.0;
const MESSAGES_AT_ONCE: f64 = 200.0;

/// Opens the socket of a browser.
pub async fn open(State(site): State<PanelSite>, upgrade: WebSocketUpgrade) -> Response {
    upgrade
        .max_message_size(MESSAGE_MAX)
        .max_frame_size(MESSAGE_MAX)
        .on_upgrade(move |socket| serve(site, socket))
}

async fn serve(site: PanelSite, mut socket: WebSocket) {
    let client = site.hub.join(site.hub.now());
    // Without random numbers the socket ends, and the page tries again.
    let connected = site.access().connect(client);
    if let Ok(secret) = connected {
        talk(&site, client, &secret.text(), &mut socket).await;
    }
    site.access().disconnect(client);
    site.hub.leave(client);
}

/// Talks with a browser until one side ends.
async fn talk(site: &PanelSite, client: ClientId, secret: &str, socket: &mut WebSocket) {
    let mut due = tokio::time::interval(EVERY);
    due.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Skip);
    let mut budget = Budget { left: MESSAGES_AT_ONCE, at: site.hub.now() };
    loop {
        tokio::select! {
            _ = due.tick() => {
                let text = state(site, client, secret);
                match tokio::time::timeout(TAKES_WITHIN, socket.send(Message::Text(text.into()))).await {
                    Ok(Ok(())) => {}
                    _ => return,
                }
            }
            message = socket.recv() => {
                let text = match message {
                    Some(Ok(Message::Text(text))) => text,
                    Some(Ok(Message::Ping(_) | Message::Pong(_))) => continue,
                    _ => return,
                };
                let now = site.hub.now();
                if !budget.takes(now) {
                    return;
                }
                let refused = match PanelAction::parse(&text) {
                    Ok(action) => site.hub.act(client, action, now).err().map(|refusal| refusal.to_string()),
                    Err(error) => Some(error.to_string()),
                };
                if let Some(reason) = refused {
                    let text = serde_json::to_string(&RefusedMessage { refused: reason }).unwrap_or_default();
                    if socket.send(Message::Text(text.into())).await.is_err() {
                        return;
                    }
                }
            }
        }
    }
}

/// The number of messages that a browser may still send.
struct Budget {
    left: f64,
    at: Time,
}

impl Budget {
    /// Counts a message. Returns whether it was allowed.
    fn takes(&mut self, now: Time) -> bool {
        let gained = now.since(self.at).as_secs_f64() * MESSAGES_A_SECOND;
        self.left = (self.left + gained).min(MESSAGES_AT_ONCE) - 1.0;
        self.at = now;
        self.left >= 0.0
    }
}

/// The state for a client.
fn state(site: &PanelSite, client: ClientId, secret: &str) -> String {
    let now = site.hub.now();
    let words = site.bench.words();
    let session = site.hub.session();
    let session = session.as_ref().map(|(state, age)| SessionMessage::of(state, *age, &words));
    let message = StateMessage {
        now_us: now.micros(),
        screen: secret,
        control: site.hub.control_of(client, now),
        revision: site.bench.revision(),
        session,
    };
    serde_json::to_string(&message).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn browser_that_floods_is_cut_off_and_one_that_steers_is_not() {
        let at = |ms: u64| Time::ZERO.after(Duration::from_millis(ms));
        let mut steers = Budget { left: MESSAGES_AT_ONCE, at: at(0) };
        assert!((0..100_000).all(|k| steers.takes(at(20 * k))), "fifty messages a second");
        let mut floods = Budget { left: MESSAGES_AT_ONCE, at: at(0) };
        let taken = (0..10_000).take_while(|_| floods.takes(at(1))).count();
        assert_eq!(taken, 200);
    }
}
