//! The web server: static files of the page, requests to the workbench, and one socket for each browser.
//!
//! Implements SR-28.

mod assets;
mod checks;
mod requests;
mod socket;
#[cfg(test)]
mod tests;

use std::net::SocketAddr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use axum::Router;
use axum::extract::DefaultBodyLimit;
use axum::middleware::from_fn_with_state;
use axum::routing::{get, post, put};
use fast_qr::convert::svg::SvgBuilder;
use fast_qr::{QRBuilder, QRCode};
use thiserror::Error;

use crate::access::{Access, AccessError};
use crate::bench::Workbench;
use crate::hub::Hub;

/// The address by which another browser enters, with the token. A request sends no part of it after the `#`.
#[derive(Clone, Debug)]
pub struct Invitation {
    /// The address.
    pub address: String,
}

impl Invitation {
    fn code(&self) -> Option<QRCode> {
        QRBuilder::new(self.address.as_str()).build().ok()
    }

    /// Its QR code for a terminal, in half blocks.
    #[must_use]
    pub fn for_terminal(&self) -> Option<String> {
        Some(self.code()?.to_str())
    }

    /// Its QR code as SVG.
    #[must_use]
    pub fn svg(&self) -> Option<String> {
        Some(SvgBuilder::default().to_str(&self.code()?))
    }
}

/// Longest drawing that is uploaded, bytes. From a disk the importer takes longer files.
pub const DRAWING_MAX: usize = 64 << 20;

/// What all requests share.
#[derive(Clone)]
pub struct PanelSite {
    /// The meeting place with the session.
    pub hub: Hub,
    /// The program.
    pub bench: Arc<dyn Workbench>,
    access: Arc<Mutex<Access>>,
    at: SocketAddr,
}

impl PanelSite {
    /// A site at an address.
    ///
    /// # Errors
    /// [`AccessError`] when the system gives no random numbers.
    pub fn new(hub: Hub, bench: Arc<dyn Workbench>, at: SocketAddr) -> Result<Self, AccessError> {
        let access = Arc::new(Mutex::new(Access::new(at, hub.now())?));
        Ok(Self { hub, bench, access, at })
    }

    /// The text of the token, while it admits browsers.
    #[must_use]
    pub fn token(&self) -> Option<String> {
        self.access().token(self.hub.now())
    }

    /// Makes a new token, and the invitation with it.
    ///
    /// # Errors
    /// [`AccessError`] when the system gives no random numbers.
    pub fn invite(&self) -> Result<Invitation, AccessError> {
        let mut access = self.access();
        access.renew(self.hub.now())?;
        let token = access.token(self.hub.now()).unwrap_or_default();
        Ok(Invitation { address: format!("http://{}/#token={token}", self.at) })
    }

    fn access(&self) -> MutexGuard<'_, Access> {
        self.access.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The routes. Every answer has the headers of [`checks`], and every request passes its checks.
    fn router(self) -> Router {
        let admitted = Router::new()
            .route("/api/job", get(requests::job))
            .route("/api/map", get(requests::map))
            .route("/api/ask", post(requests::ask))
            .route("/api/drawing", put(requests::drawing).layer(DefaultBodyLimit::max(DRAWING_MAX)))
            .route("/api/document/{name}", get(requests::document))
            .route("/api/invite", post(requests::invite))
            .route("/api/socket", get(socket::open))
            .layer(from_fn_with_state(self.clone(), checks::is_admitted));
        Router::new()
            .merge(admitted)
            .route("/api/enter", post(requests::enter))
            .route("/", get(assets::page))
            .route("/{name}", get(assets::file))
            .layer(DefaultBodyLimit::max(4096))
            .layer(from_fn_with_state(self.clone(), checks::is_ours))
            .with_state(self)
    }
}

/// Why the panel cannot serve.
#[derive(Debug, Error)]
pub enum ServeError {
    /// The address cannot be used.
    #[error(
        "the panel cannot listen at {at}: {source}. Is another panel running? Choose another port with --port."
    )]
    Listen {
        /// The address.
        at: SocketAddr,
        /// What the system says.
        source: std::io::Error,
    },
    /// The server failed.
    #[error("the panel's server stopped: {0}")]
    Server(std::io::Error),
    /// No token.
    #[error(transparent)]
    Access(#[from] AccessError),
}

/// A server that listens and does not serve yet.
#[derive(Debug)]
pub struct Listener {
    listener: std::net::TcpListener,
    /// Its address.
    pub at: SocketAddr,
}

impl Listener {
    /// Listens at an address. Port 0 takes a free one.
    ///
    /// # Errors
    /// [`ServeError::Listen`] when the system refuses.
    pub fn bind(at: SocketAddr) -> Result<Self, ServeError> {
        let refused = |source| ServeError::Listen { at, source };
        let listener = std::net::TcpListener::bind(at).map_err(refused)?;
        listener.set_nonblocking(true).map_err(refused)?;
        let at = listener.local_addr().map_err(refused)?;
        Ok(Self { listener, at })
    }

    /// Serves a site until the program ends.
    ///
    /// # Errors
    /// [`ServeError::Server`] when the system fails.
    pub fn serve(self, site: PanelSite) -> Result<(), ServeError> {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
        runtime.map_err(ServeError::Server)?.block_on(async move {
            let listener = tokio::net::TcpListener::from_std(self.listener).map_err(ServeError::Server)?;
            axum::serve(listener, site.router()).await.map_err(ServeError::Server)
        })
    }
}
