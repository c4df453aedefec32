//! The checks of every request, and the headers of every answer.
//!
//! Implements SR-28.
//!
//! A foreign page cannot act here: its `Origin` differs, and the cookie is `SameSite=Strict`. A foreign name that
//! resolves to this address cannot, either: its `Host` differs.

use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use super::PanelSite;
use crate::protocol::Control;

/// Name of the cookie of an admitted browser.
pub const COOKIE: &str = "keepout_panel";

/// Name of the header with the secret of the page's connection.
const SCREEN: &str = "x-keepout-screen";

/// What a page of the panel may load: its own files alone.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src \
                      'self'; manifest-src 'self'; frame-src 'self'; base-uri 'none'; form-action 'none'; \
                      frame-ancestors 'self'";

/// Passes requests to this server from its own page on, and refuses others.
pub async fn is_ours(State(site): State<PanelSite>, request: Request, next: Next) -> Response {
    let headers = request.headers();
    let host = text(headers, header::HOST);
    let origin = text(headers, header::ORIGIN);
    let changes = !matches!(*request.method(), Method::GET | Method::HEAD);
    let upgrades = headers.contains_key(header::UPGRADE);
    let (ours, own) = {
        let access = site.access();
        (host.is_some_and(|host| access.is_host(host)), origin.map(|origin| access.is_origin(origin)))
    };
    let refused = if !ours {
        Some("this server is named otherwise: open the address that the program shows")
    } else if own == Some(false) || (changes || upgrades) && own.is_none() {
        Some("the request comes from another page")
    } else {
        None
    };
    let mut answer = match refused {
        Some(reason) => (StatusCode::FORBIDDEN, reason).into_response(),
        None => next.run(request).await,
    };
    let set = |headers: &mut HeaderMap, name: HeaderName, value: &'static str| {
        headers.entry(name).or_insert(HeaderValue::from_static(value));
    };
    let headers = answer.headers_mut();
    set(headers, header::CONTENT_SECURITY_POLICY, POLICY);
    set(headers, header::X_CONTENT_TYPE_OPTIONS, "nosniff");
    set(headers, header::REFERRER_POLICY, "no-referrer");
    set(headers, header::CACHE_CONTROL, "no-store");
    set(headers, HeaderName::from_static("cross-origin-opener-policy"), "same-origin");
    set(headers, HeaderName::from_static("cross-origin-resource-policy"), "same-origin");
    answer
}

/// Passes requests of admitted browsers on.
pub async fn is_admitted(State(site): State<PanelSite>, request: Request, next: Next) -> Response {
    let known = cookie(request.headers()).is_some_and(|secret| site.access().admits(secret, site.hub.now()));
    if known {
        next.run(request).await
    } else {
        (StatusCode::UNAUTHORIZED, "enter with the token that the program shows").into_response()
    }
}

/// Whether the request is from a connected screen, and no other one steers.
pub fn may_change(site: &PanelSite, headers: &HeaderMap) -> bool {
    let client =
        text(headers, HeaderName::from_static(SCREEN)).and_then(|secret| site.access().connection(secret));
    client.is_some_and(|client| !matches!(site.hub.control_of(client, site.hub.now()), Control::Other { .. }))
}

fn text(headers: &HeaderMap, name: HeaderName) -> Option<&str> {
    headers.get(name)?.to_str().ok()
}

/// The secret of the browser.
fn cookie(headers: &HeaderMap) -> Option<&str> {
    let pairs = text(headers, header::COOKIE)?.split(';').filter_map(|pair| pair.trim().split_once('='));
    pairs.filter(|(name, _)| *name == COOKIE).map(|(_, value)| value).next()
}
