//! The server over a real socket: who is admitted, what a foreign page is refused, and what it bounds.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use crate::bench::{BenchRequest, Document, DocumentName, JobView, MapView, SessionWords, Workbench};
use crate::hub::Hub;
use crate::server::{Listener, PanelSite};
use tungstenite::Message;
use tungstenite::client::IntoClientRequest;

/// A workbench that remembers what it was asked for.
#[derive(Default)]
struct Asked(Mutex<Vec<String>>);

impl Workbench for Asked {
    fn job(&self) -> JobView {
        JobView::default()
    }

    fn map(&self) -> MapView {
        MapView::default()
    }

    fn revision(&self) -> u64 {
        1
    }

    fn ask(&self, request: BenchRequest) -> Result<(), String> {
        self.0.lock().unwrap().push(format!("{request:?}"));
        Err("not here: try there".into())
    }

    fn drawing(&self, name: &str, bytes: &[u8]) -> Result<(), String> {
        self.0.lock().unwrap().push(format!("{name} of {} bytes", bytes.len()));
        Ok(())
    }

    fn document(&self, _: DocumentName) -> Option<Document> {
        Some(Document { media: "text/html; charset=utf-8", bytes: b"<p>report</p>".to_vec() })
    }

    fn words(&self) -> SessionWords {
        SessionWords::default()
    }
}

struct Served {
    at: SocketAddr,
    token: String,
    bench: Arc<Asked>,
    hub: Hub,
}

fn served() -> Served {
    let listener = Listener::bind(SocketAddr::from(([127, 0, 0, 1], 0))).unwrap();
    let (at, hub, bench) = (listener.at, Hub::default(), Arc::new(Asked::default()));
    let site = PanelSite::new(hub.clone(), Arc::clone(&bench) as Arc<dyn Workbench>, at).unwrap();
    let token = site.token().unwrap();
    std::thread::spawn(move || listener.serve(site));
    Served { at, token, bench, hub }
}

impl Served {
    /// The answer to a request: its first line, its headers and its body.
    fn answer(&self, line: &str, headers: &str, body: &str) -> String {
        let mut socket = TcpStream::connect(self.at).unwrap();
        socket.set_read_timeout(Some(Duration::from_secs(5))).unwrap();
        let length = body.len();
        write!(
            socket,
            "{line} HTTP/1.1\r\n{headers}Connection: close\r\nContent-Length: {length}\r\n\r\n{body}"
        )
        .unwrap();
        let mut answer = Vec::new();
        let _ = socket.read_to_end(&mut answer);
        String::from_utf8_lossy(&answer).into_owned()
    }

    fn own(&self) -> String {
        format!("Host: {0}\r\nOrigin: http://{0}\r\nContent-Type: application/json\r\n", self.at)
    }

    /// Enters, and returns the headers of an admitted browser.
    fn enter(&self) -> String {
        let body = format!("{{\"token\":\"{}\"}}", self.token);
        let answer = self.answer("POST /api/enter", &self.own(), &body);
        let cookie =
            answer.split("set-cookie: ").nth(1).and_then(|rest| rest.split(';').next()).unwrap().to_string();
        assert!(answer.contains("HttpOnly; SameSite=Strict"), "{answer}");
        format!("{}Cookie: {cookie}\r\n", self.own())
    }

    /// A connected screen of an admitted browser: its socket, and the headers of its requests.
    fn screen(&self, headers: &str) -> (tungstenite::WebSocket<TcpStream>, String) {
        let cookie = headers.lines().find_map(|line| line.strip_prefix("Cookie: ")).unwrap();
        let mut socket = self.socket(cookie, &format!("http://{}", self.at)).unwrap();
        let Message::Text(state) = socket.read().unwrap() else { panic!("it is a state") };
        let secret = state.split("\"screen\":\"").nth(1).and_then(|rest| rest.split('"').next()).unwrap();
        let headers = format!("{headers}X-Keepout-Screen: {secret}\r\n");
        (socket, headers)
    }

    fn socket(&self, cookie: &str, origin: &str) -> Result<tungstenite::WebSocket<TcpStream>, String> {
        let mut request = format!("ws://{}/api/socket", self.at).into_client_request().unwrap();
        request.headers_mut().insert("Cookie", cookie.parse().unwrap());
        request.headers_mut().insert("Origin", origin.parse().unwrap());
        let stream = TcpStream::connect(self.at).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(5))).unwrap();
        tungstenite::client(request, stream).map(|(socket, _)| socket).map_err(|error| error.to_string())
    }
}

fn status(answer: &str) -> &str {
    answer.split(' ').nth(1).unwrap_or("none")
}

// Evidence for SR-28.
#[test]
fn page_is_served_with_a_strict_policy_and_nothing_else_without_the_token() {
    let served = served();
    let page = served.answer("GET /", &format!("Host: {}\r\n", served.at), "");
    assert_eq!(status(&page), "200");
    for header in
        ["content-security-policy: default-src 'none'", "x-content-type-options: nosniff", "no-store"]
    {
        assert!(page.contains(header), "{header}: {page}");
    }
    for path in ["/api/job", "/api/map", "/api/document/report", "/api/socket"] {
        assert_eq!(status(&served.answer(&format!("GET {path}"), &served.own(), "")), "401", "{path}");
    }
    assert_eq!(status(&served.answer("POST /api/enter", &served.own(), "{\"token\":\"0\"}")), "403");
    let headers = served.enter();
    assert_eq!(status(&served.answer("GET /api/job", &headers, "")), "200");
    for path in ["/../Cargo.toml", "/panel.css/../x", "/%2e%2e/%2e%2e/etc/passwd", "/api/document/secret"] {
        let found = served.answer(&format!("GET {path}"), &headers, "");
        assert!(["404", "400"].contains(&status(&found)), "{path}: {found}");
    }
}

// Evidence for SR-28.
#[test]
fn foreign_names_and_pages_are_refused() {
    let served = served();
    let headers = served.enter();
    let cookie = headers.lines().find(|line| line.starts_with("Cookie")).unwrap();
    for (host, origin) in [
        ("evil.example".to_string(), String::new()),
        (format!("localhost.evil.example:{}", served.at.port()), String::new()),
        (served.at.to_string(), "Origin: http://evil.example\r\n".into()),
        (served.at.to_string(), "Origin: null\r\n".into()),
    ] {
        let headers = format!("Host: {host}\r\n{origin}{cookie}\r\n");
        assert_eq!(status(&served.answer("GET /api/job", &headers, "")), "403", "{headers}");
    }
    // A request that changes something needs an origin.
    let bare = format!("Host: {}\r\n{cookie}\r\nContent-Type: application/json\r\n", served.at);
    assert_eq!(status(&served.answer("POST /api/ask", &bare, "{\"type\":\"end\"}")), "403");
    assert!(served.bench.0.lock().unwrap().is_empty());
    let answer = served.answer("POST /api/ask", &headers, "{\"type\":\"end\"}");
    assert!(status(&answer) == "409" && answer.ends_with("not here: try there"), "{answer}");
    assert_eq!(*served.bench.0.lock().unwrap(), ["End"]);
}

// Evidence for SR-28.
#[test]
fn requests_are_bounded() {
    let served = served();
    let headers = served.enter();
    let long = format!("{{\"type\":\"open\",\"name\":\"{}\"}}", "x".repeat(10_000));
    assert_eq!(status(&served.answer("POST /api/ask", &headers, &long)), "413");
    let drawing = "0\nEOF\n".repeat(10_000);
    let (_socket, headers) = served.screen(&headers);
    assert_eq!(status(&served.answer("PUT /api/drawing?name=a.dxf", &headers, &drawing)), "204");
    assert_eq!(*served.bench.0.lock().unwrap(), ["a.dxf of 60000 bytes"]);
}

// Evidence for SR-28.
#[test]
fn socket_needs_the_token_and_the_origin_and_ends_at_a_flood() {
    let served = served();
    let headers = served.enter();
    let cookie = headers.lines().find_map(|line| line.strip_prefix("Cookie: ")).unwrap();
    let own = format!("http://{}", served.at);
    assert!(served.socket("keepout_panel=0", &own).is_err());
    assert!(served.socket(cookie, "http://evil.example").is_err());
    let mut socket = served.socket(cookie, &own).unwrap();
    let Message::Text(state) = socket.read().unwrap() else { panic!("it is a state") };
    assert!(state.contains("\"holder\":\"mine\"") && state.contains("\"session\":null"), "{state}");
    // A message that is not in the protocol gets an answer, and the socket stays.
    socket.send(Message::text("{\"type\":\"fire\"}")).unwrap();
    let refused = (0..50).find_map(|_| match socket.read().unwrap() {
        Message::Text(text) if text.contains("refused") => Some(text),
        _ => None,
    });
    assert!(refused.unwrap().contains("protocol"));
    let mut flooding = served.socket(cookie, &own).unwrap();
    let ended = (0..5000).any(|_| flooding.send(Message::text("{\"type\":\"alive\"}")).is_err())
        || (0..5000).any(|_| flooding.read().is_err());
    assert!(ended, "a flood is cut off");
    let mut long = served.socket(cookie, &own).unwrap();
    let _ = long.send(Message::text("x".repeat(5000)));
    assert!((0..200).any(|_| long.read().is_err()), "a long message ends the socket");
    assert!(served.hub.session().is_none());
}

// Evidence for SR-28.
#[test]
fn screen_that_watches_changes_nothing() {
    let served = served();
    let admitted = served.enter();
    let (steers, own) = served.screen(&admitted);
    let (mut watches, others) = served.screen(&admitted);
    let begin = "{\"type\":\"begin\",\"kind\":\"cut\",\"home\":true}";
    let asks = |headers: &str| {
        let begun = served.answer("POST /api/ask", headers, begin);
        let drawn = served.answer("PUT /api/drawing?name=a.dxf", headers, "0\nEOF\n");
        [begun, drawn].map(|answer| answer.contains("take control first"))
    };
    let invented = format!("{admitted}X-Keepout-Screen: {}\r\n", "0".repeat(32));
    for headers in [&others, &admitted, &invented, &format!("{admitted}X-Keepout-Screen: \r\n")] {
        assert_eq!(asks(headers), [true; 2], "{headers}");
    }
    assert!(served.bench.0.lock().unwrap().is_empty());
    assert_eq!(asks(&own), [false; 2]);
    // Every screen may end a session.
    served.answer("POST /api/ask", &others, "{\"type\":\"end\"}");
    let asked = ["Begin { kind: Cut, home: true }", "a.dxf of 6 bytes", "End"];
    assert_eq!(*served.bench.0.lock().unwrap(), asked);
    // A connection that is gone is known no longer, and the other screen may ask.
    drop(steers);
    let holder = |socket: &mut tungstenite::WebSocket<TcpStream>| socket.read().unwrap().to_string();
    assert!((0..100).any(|_| holder(&mut watches).contains("\"holder\":\"free\"")));
    assert_eq!((asks(&own), asks(&others)), ([true; 2], [false; 2]));
}

#[test]
fn socket_that_is_gone_gives_control_back() {
    let served = served();
    let headers = served.enter();
    let cookie = headers.lines().find_map(|line| line.strip_prefix("Cookie: ")).unwrap();
    let own = format!("http://{}", served.at);
    let holder = |socket: &mut tungstenite::WebSocket<TcpStream>| {
        let Message::Text(state) = socket.read().unwrap() else { return String::new() };
        state.split("\"holder\":\"").nth(1).and_then(|rest| rest.split('"').next()).unwrap_or("").to_string()
    };
    let mut one = served.socket(cookie, &own).unwrap();
    assert_eq!(holder(&mut one), "mine");
    let mut two = served.socket(cookie, &own).unwrap();
    assert_eq!(holder(&mut two), "other");
    drop(one);
    assert!((0..100).any(|_| holder(&mut two) == "free"), "the first one is gone");
    two.send(Message::text("{\"type\":\"take_control\"}")).unwrap();
    assert!((0..100).any(|_| holder(&mut two) == "mine"));
}
