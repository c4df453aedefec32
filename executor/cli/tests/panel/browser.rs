//! A real browser, steered through its DevTools protocol.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::seeded::seeded;
use keepout_planner::Mm2;
use serde_json::{Value, json};
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Message, WebSocket};

/// Longest wait for an answer of the browser, and for a state of a page.
const WITHIN: Duration = Duration::from_secs(20);

/// A browser without a window.
pub struct Browser {
    process: Child,
    socket: WebSocket<MaybeTlsStream<std::net::TcpStream>>,
    next: u64,
    profile: PathBuf,
}

/// A tab of the browser.
pub struct Tab<'a> {
    browser: &'a mut Browser,
    session: String,
}

/// Name of a tab that was opened.
#[derive(Clone, Debug)]
pub struct TabId(String);

impl Browser {
    /// Starts Chromium. `None` when there is none.
    pub fn start(name: &str) -> Option<Self> {
        let with_fault = if seeded().is_some() { "-seeded" } else { "" };
        let profile = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("browser-{name}{with_fault}"));
        let _ = std::fs::remove_dir_all(&profile);
        let process = Command::new("chromium")
            .args(["--headless=new", "--no-sandbox", "--disable-gpu", "--no-first-run", "--hide-scrollbars"])
            .args([
                "--disable-background-networking",
                "--disable-component-update",
                "--remote-debugging-port=0",
            ])
            .args(["--touch-events=enabled", "--lang=en"])
            .arg(format!("--user-data-dir={}", profile.display()))
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn();
        assert!(process.is_ok() || std::env::var_os("CI").is_none(), "CI skips nothing: install chromium");
        let mut process = process.ok()?;
        let mut lines = BufReader::new(process.stderr.take()?).lines();
        let listening = |line: &String| line.contains("DevTools listening on ws://");
        let line = lines.by_ref().map_while(Result::ok).find(listening).expect("the browser listens");
        std::thread::spawn(move || lines.for_each(drop));
        let at = line.split_once("ws://").map(|(_, rest)| format!("ws://{rest}")).expect("it states where");
        let (socket, _) = tungstenite::connect(at).expect("the browser takes a connection");
        Some(Self { process, socket, next: 0, profile })
    }

    /// Opens a tab of this size.
    pub fn open(&mut self, url: &str, (width, height): (u32, u32)) -> TabId {
        let target = self.ask(None, "Target.createTarget", &json!({ "url": "about:blank" }));
        let attach = json!({ "targetId": target["targetId"], "flatten": true });
        let session =
            self.ask(None, "Target.attachToTarget", &attach)["sessionId"].as_str().map(String::from);
        let id = TabId(session.expect("the browser names the session"));
        let mut tab = self.tab(&id);
        tab.send("Page.enable", &json!({}));
        tab.send(
            "Emulation.setDeviceMetricsOverride",
            &json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": true }),
        );
        tab.send("Emulation.setTouchEmulationEnabled", &json!({ "enabled": true, "maxTouchPoints": 5 }));
        tab.send("Emulation.setFocusEmulationEnabled", &json!({ "enabled": true }));
        if let Some(fault) = seeded() {
            let pattern = json!({ "urlPattern": format!("*/{}", fault.file) });
            tab.send("Fetch.enable", &json!({ "patterns": [pattern] }));
        }
        tab.send("Page.navigate", &json!({ "url": url }));
        id
    }

    /// The tab of this name.
    pub fn tab(&mut self, id: &TabId) -> Tab<'_> {
        Tab { session: id.0.clone(), browser: self }
    }

    fn ask(&mut self, session: Option<&str>, method: &str, parameters: &Value) -> Value {
        self.next += 1;
        let mut message = json!({ "id": self.next, "method": method, "params": parameters });
        if let Some(session) = session {
            message["sessionId"] = session.into();
        }
        self.socket.send(Message::text(message.to_string())).expect("the browser listens");
        let begun = Instant::now();
        while begun.elapsed() < WITHIN {
            let Message::Text(text) = self.socket.read().expect("the browser answers") else { continue };
            let answer: Value = serde_json::from_str(&text).expect("JSON");
            if answer["method"] == "Fetch.requestPaused" {
                self.serve_fault(&answer);
                continue;
            }
            if answer["id"] == self.next {
                assert!(answer["error"].is_null(), "{method}: {}", answer["error"]);
                return answer["result"].clone();
            }
        }
        panic!("the browser does not answer {method}");
    }
}

impl Browser {
    /// Serves the file with the seeded fault instead of the panel's.
    fn serve_fault(&mut self, paused: &Value) {
        let Some(fault) = seeded() else { return };
        let media = if fault.file.ends_with(".css") { "text/css" } else { "text/javascript" };
        let parameters = json!({
            "requestId": paused["params"]["requestId"],
            "responseCode": 200,
            "responseHeaders": [{ "name": "Content-Type", "value": media }],
            "body": base64(fault.content().as_bytes()),
        });
        // Nobody waits for the answer, so its number is one that no question has.
        let message = json!({ "id": 1_000_000_000, "method": "Fetch.fulfillRequest", "params": parameters,
            "sessionId": paused["sessionId"] });
        self.socket.send(Message::text(message.to_string())).expect("the browser listens");
    }
}

/// Bytes in base 64 (RFC 4648, section 4).
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for three in bytes.chunks(3) {
        let bits =
            (0..3).fold(0_usize, |bits, k| bits << 8 | usize::from(three.get(k).copied().unwrap_or(0)));
        let digit =
            |k: usize| if k > three.len() { '=' } else { char::from(DIGITS[bits >> (18 - 6 * k) & 63]) };
        text.extend((0..4).map(digit));
    }
    text
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
        let _ = std::fs::remove_dir_all(&self.profile);
    }
}

impl Tab<'_> {
    /// Asks the tab.
    pub fn send(&mut self, method: &str, parameters: &Value) -> Value {
        let session = self.session.clone();
        self.browser.ask(Some(&session), method, parameters)
    }

    /// The value of an expression.
    pub fn value(&mut self, expression: &str) -> Value {
        let parameters = json!({ "expression": expression, "returnByValue": true, "awaitPromise": true });
        let answer = self.send("Runtime.evaluate", &parameters);
        let thrown = &answer["exceptionDetails"];
        assert!(thrown.is_null(), "{expression}: {}\n{thrown}", self.shown());
        answer["result"]["value"].clone()
    }

    /// Waits until an expression is true.
    pub fn wait(&mut self, expression: &str) {
        self.wait_for(expression, WITHIN);
    }

    /// Waits until an expression is true, for so long.
    pub fn wait_for(&mut self, expression: &str, within: Duration) {
        let begun = Instant::now();
        while self.value(&format!("Boolean({expression})")) != Value::Bool(true) {
            assert!(begun.elapsed() < within, "not within {within:?}: {expression}\n{}", self.shown());
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// The middle of the element whose text holds `text`, or of the one that a selector names.
    pub fn place(&mut self, what: &str) -> Mm2 {
        let find = format!(
            "(() => {{ const what = {what:?}; const all = [...document.querySelectorAll('button, label, summary')]; \
             const found = what.startsWith('#') ? document.querySelector(what) \
             : all.filter((one) => one.innerText.includes(what) && one.offsetParent).pop(); \
             if (!found) return null; found.scrollIntoView({{ block: 'nearest' }}); \
             const box = found.getBoundingClientRect(); \
             return [box.left + box.width / 2, box.top + box.height / 2]; }})()"
        );
        let begun = Instant::now();
        loop {
            let place = self.value(&find);
            if let (Some(x), Some(y)) = (place[0].as_f64(), place[1].as_f64()) {
                return Mm2::new(x, y);
            }
            assert!(begun.elapsed() < WITHIN, "nothing on the page is {what}");
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    fn finger(&mut self, kind: &str, fingers: &[Mm2]) {
        let points: Vec<Value> =
            fingers.iter().zip(1..).map(|(at, id)| json!({ "x": at.x, "y": at.y, "id": id })).collect();
        self.send("Input.dispatchTouchEvent", &json!({ "type": kind, "touchPoints": points }));
    }

    /// Taps.
    pub fn tap(&mut self, what: &str) {
        let at = self.place(what);
        self.finger("touchStart", &[at]);
        self.finger("touchEnd", &[]);
    }

    /// Taps until an expression is true. The page drops a touch that arrives late, so a person taps again.
    pub fn taps(&mut self, what: &str, until: &str) {
        let came = (0..8).any(|_| {
            self.tap(what);
            self.comes(until)
        });
        assert!(came, "not after eight taps of {what}: {until}\n{}", self.shown());
    }

    /// Presses until an expression is true. The page lets go of a control that it builds again, so a person presses
    /// again.
    pub fn presses(&mut self, until: &str, press: impl Fn(&mut Self)) {
        let came = (0..8).any(|_| {
            press(self);
            let came = self.comes(until);
            self.lift();
            came
        });
        assert!(came, "not after eight presses: {until}\n{}", self.shown());
    }

    /// Whether an expression becomes true within three seconds.
    fn comes(&mut self, until: &str) -> bool {
        (0..60).any(|_| {
            std::thread::sleep(Duration::from_millis(50));
            self.value(&format!("Boolean({until})")) == Value::Bool(true)
        })
    }

    /// The beginning of what the page shows.
    fn shown(&mut self) -> Value {
        self.value("document.body?.innerText.slice(0, 600)")
    }

    /// Holds for so long.
    pub fn hold(&mut self, what: &str, span: Duration) {
        let at = self.place(what);
        self.finger("touchStart", &[at]);
        std::thread::sleep(span);
        self.finger("touchEnd", &[]);
    }

    /// Rests a finger on the pad, then pushes it by shares of the pad's radius.
    pub fn push(&mut self, share: Mm2) -> Mm2 {
        let at = self.place("#pad");
        let radius = self.value("document.querySelector('#pad').clientWidth / 2").as_f64().unwrap_or(100.0);
        self.finger("touchStart", &[at]);
        std::thread::sleep(Duration::from_millis(300));
        let to = at + Mm2::new(share.x, -share.y) * (radius * 0.95);
        self.finger("touchMove", &[to]);
        to
    }

    /// Moves the finger that rests on the pad.
    pub fn drag(&mut self, fingers: &[Mm2]) {
        self.finger("touchMove", fingers);
    }

    /// Another finger comes down beside those that rest.
    pub fn second_finger(&mut self, fingers: &[Mm2]) {
        self.finger("touchStart", fingers);
    }

    /// Lifts all fingers.
    pub fn lift(&mut self) {
        self.finger("touchEnd", &[]);
    }

    /// Presses or releases a key.
    pub fn key(&mut self, key: &str, down: bool) {
        let kind = if down { "keyDown" } else { "keyUp" };
        self.send("Input.dispatchKeyEvent", &json!({ "type": kind, "key": key, "code": key }));
    }

    /// Keeps a picture of the page.
    pub fn picture(&mut self, name: &str) {
        let answer = self.send("Page.captureScreenshot", &json!({ "format": "png" }));
        keep(&format!("{name}.png"), answer["data"].as_str().unwrap_or_default());
    }

    /// Prints the page to a PDF file. Returns its length, bytes.
    pub fn print(&mut self, name: &str) -> usize {
        let answer = self.send("Page.printToPDF", &json!({ "printBackground": true }));
        keep(&format!("{name}.pdf"), answer["data"].as_str().unwrap_or_default())
    }
}

/// The folder of pictures that the tests keep.
pub fn pictures() -> PathBuf {
    let named = std::env::var_os("KEEPOUT_PICTURES").map(PathBuf::from);
    named.unwrap_or_else(|| Path::new(env!("CARGO_TARGET_TMPDIR")).join("panel-pictures"))
}

fn keep(name: &str, base64: &str) -> usize {
    let digit = |c: u8| match c {
        b'A'..=b'Z' => c - b'A',
        b'a'..=b'z' => c - b'a' + 26,
        b'0'..=b'9' => c - b'0' + 52,
        b'+' => 62,
        _ => 63,
    };
    let digits: Vec<u8> = base64.bytes().filter(|&c| c != b'=').map(digit).collect();
    let bytes: Vec<u8> = digits
        .chunks(4)
        .flat_map(|four| {
            let bits = (0..4).fold(0_u32, |bits, k| bits << 6 | u32::from(four.get(k).copied().unwrap_or(0)));
            bits.to_be_bytes()[1..four.len()].to_vec()
        })
        .collect();
    std::fs::create_dir_all(pictures()).expect("writable");
    std::fs::write(pictures().join(name), &bytes).expect("writable");
    bytes.len()
}
