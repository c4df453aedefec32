//! The requests to the workbench.
//!
//! Implements SR-28.

use axum::Json;
use axum::body::Bytes;
use axum::extract::{Path, Query, State};
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};

use super::PanelSite;
use super::checks::{COOKIE, may_change};
use crate::access::BROWSER_LIVES;
use crate::bench::{BenchRequest, DocumentName, JobView, MapView};

/// The token of a browser that enters.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Entrance {
    token: String,
}

/// Admits a browser that knows the token.
pub async fn enter(State(site): State<PanelSite>, Json(Entrance { token }): Json<Entrance>) -> Response {
    let now = site.hub.now();
    let entered = site.access().enter(&token, now);
    match entered {
        Ok(Some(secret)) => {
            let cookie = format!(
                "{COOKIE}={}; Path=/; Max-Age={}; HttpOnly; SameSite=Strict",
                secret.text(),
                BROWSER_LIVES.as_secs()
            );
            ([(header::SET_COOKIE, cookie)], StatusCode::NO_CONTENT).into_response()
        }
        Ok(None) => (
            StatusCode::FORBIDDEN,
            "this code is wrong or old. For a new one, press Enter in the terminal of the panel, or \"Another \
             screen\" on a screen that has entered.",
        )
            .into_response(),
        Err(error) => (StatusCode::INTERNAL_SERVER_ERROR, error.to_string()).into_response(),
    }
}

/// An invitation for another screen: its address, and its QR code as SVG.
#[derive(Debug, Serialize)]
pub struct InvitationView {
    address: String,
    svg: Option<String>,
}

/// Makes a new code for another screen.
pub async fn invite(State(site): State<PanelSite>) -> Response {
    match site.invite() {
        Ok(invitation) => {
            let svg = invitation.svg();
            Json(InvitationView { address: invitation.address, svg }).into_response()
        }
        Err(error) => (StatusCode::INTERNAL_SERVER_ERROR, error.to_string()).into_response(),
    }
}

/// The job as it is.
pub async fn job(State(site): State<PanelSite>) -> Json<JobView> {
    Json(site.bench.job())
}

/// The map of the job.
pub async fn map(State(site): State<PanelSite>) -> Json<MapView> {
    Json(site.bench.map())
}

/// Does what the page asks for. Planning takes a while, so another thread does it. Every screen may end a session.
pub async fn ask(
    State(site): State<PanelSite>,
    headers: HeaderMap,
    Json(request): Json<BenchRequest>,
) -> Response {
    if !matches!(request, BenchRequest::End {}) && !may_change(&site, &headers) {
        return watches();
    }
    answer(move || site.bench.ask(request)).await
}

/// The answer to a screen that watches.
fn watches() -> Response {
    (StatusCode::CONFLICT, "another screen steers, or this one is not connected: take control first")
        .into_response()
}

/// Name of an uploaded drawing.
#[derive(Debug, Deserialize)]
pub struct Uploaded {
    name: String,
}

/// Makes a job of an uploaded drawing.
pub async fn drawing(
    State(site): State<PanelSite>,
    Query(Uploaded { name }): Query<Uploaded>,
    headers: HeaderMap,
    bytes: Bytes,
) -> Response {
    if !may_change(&site, &headers) {
        return watches();
    }
    answer(move || site.bench.drawing(&name, &bytes)).await
}

async fn answer(work: impl FnOnce() -> Result<(), String> + Send + 'static) -> Response {
    match tokio::task::spawn_blocking(work).await {
        Ok(Ok(())) => StatusCode::NO_CONTENT.into_response(),
        Ok(Err(reason)) => (StatusCode::CONFLICT, reason).into_response(),
        Err(_) => {
            (StatusCode::INTERNAL_SERVER_ERROR, "the program failed at this: report it").into_response()
        }
    }
}

/// What the report may show: its own styles and pictures.
const REPORT_POLICY: &str =
    "default-src 'none'; style-src 'unsafe-inline'; img-src data:; frame-ancestors 'self'";

/// A document of the job.
pub async fn document(State(site): State<PanelSite>, Path(name): Path<DocumentName>) -> Response {
    match site.bench.document(name) {
        Some(document) => {
            let headers =
                [(header::CONTENT_TYPE, document.media), (header::CONTENT_SECURITY_POLICY, REPORT_POLICY)];
            (headers, document.bytes).into_response()
        }
        None => (StatusCode::NOT_FOUND, "the job has no such document yet").into_response(),
    }
}
