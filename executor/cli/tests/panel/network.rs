//! A slow network that loses packets, between the browser and the panel.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use keepout_planner::Mm2;

use crate::PanelProcess;
use crate::browser::{Browser, Tab};
use crate::complaints::{moving, opened, stops};

/// Delay each way: a round trip takes 300 ms.
const DELAY: Duration = Duration::from_millis(150);
/// Of a hundred packets, so many are lost.
const LOST_OF_100: u8 = 3;
/// Time until a lost packet arrives after all: one more round trip, when TCP notices it by what comes behind. All that
/// waits.
const AGAIN: Duration = Duration::from_millis(300);

/// Passes bytes on with the delay. A lost packet keeps all behind it back, as TCP does. The second of two names goes on
/// in place of the first.
fn pass(mut from: TcpStream, mut to: TcpStream, names: Option<(String, String)>, seed: u64) {
    let (sender, queue): (_, Receiver<(Instant, Vec<u8>)>) = channel();
    std::thread::spawn(move || {
        let mut random = fastrand::Rng::with_seed(seed);
        let mut due = Instant::now();
        let mut bytes = [0; 1400];
        while let Ok(count) = from.read(&mut bytes)
            && count > 0
        {
            let lost = random.u8(0..100) < LOST_OF_100;
            due = due.max(Instant::now() + DELAY + if lost { AGAIN } else { Duration::ZERO });
            // The browser names the network's port, and the panel knows its own alone.
            let text = String::from_utf8_lossy(&bytes[..count]);
            let chunk = match &names {
                Some((own, other)) if text.contains(own) => text.replace(own, other).into_bytes(),
                _ => bytes[..count].to_vec(),
            };
            if sender.send((due, chunk)).is_err() {
                break;
            }
        }
    });
    for (due, chunk) in queue {
        std::thread::sleep(due.saturating_duration_since(Instant::now()));
        if to.write_all(&chunk).is_err() {
            break;
        }
    }
    let _ = to.shutdown(std::net::Shutdown::Both);
}

/// Puts the network before a panel. Returns the panel's address there.
fn slow(url: &str) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let own = listener.local_addr().unwrap().to_string();
    let panel = url.trim_start_matches("http://").split('/').next().unwrap().to_string();
    let there = url.replace(&panel, &own);
    std::thread::spawn(move || {
        for (number, browser) in (0..).zip(listener.incoming().map_while(Result::ok)) {
            let server = TcpStream::connect(&panel).unwrap();
            let names = (own.clone(), panel.clone());
            let (to_server, to_browser) = (server.try_clone().unwrap(), browser.try_clone().unwrap());
            std::thread::spawn(move || pass(browser, to_server, Some(names), 2 * number));
            std::thread::spawn(move || pass(server, to_browser, None, 2 * number + 1));
        }
    });
    there
}

/// With a round trip of 300 ms and 3 % of the packets lost the tool follows, late, and stops when it is let go. Nothing
/// moves later.
#[test]
pub(crate) fn slow_network_costs_comfort_alone() {
    let start = |name: &str| {
        let mut panel = PanelProcess::start(name);
        panel.url = slow(&panel.url);
        panel
    };
    let Some(mut steered) = opened("slow", start) else { return };
    steered.begin();
    let mut tab = steered.tab();
    for _ in 0..4 {
        moving(&mut tab);
        lift(&mut tab);
        stops(&mut tab, "release over a slow network");
        tab.push(Mm2::new(1.0, 1.0));
        std::thread::sleep(Duration::from_millis(900));
        lift(&mut tab);
        stops(&mut tab, "release over a slow network");
    }
    tab.picture("slow");
}

/// Lifts the finger, and waits for a state from after the panel heard of it. A lost packet can hold back everything
/// since before the finger moved: the page then shows a tool at rest.
fn lift(tab: &mut Tab<'_>) {
    let known = tab.value("panel.state.now_us").as_u64().unwrap();
    tab.lift();
    // That state is up to one late way old, and the order takes another.
    let heard = Duration::from_micros(known) + 2 * (DELAY + 2 * AGAIN);
    tab.wait(&format!("panel.state.now_us > {}", heard.as_micros()));
}

/// 12: the screen is kept awake, a browser without the code gets nothing, and another screen enters by a new code.
#[test]
pub(crate) fn c12_screen_stays_awake_and_strangers_stay_out() {
    let Some(mut browser) = Browser::start("c12") else {
        println!("skipped: no chromium");
        return;
    };
    let panel = PanelProcess::start("c12");
    let (address, _) = panel.url.split_once("/#").unwrap();
    let stranger = browser.open(address, (1280, 800));
    let mut tab = browser.tab(&stranger);
    tab.wait("document.querySelector('#dialog')?.open");
    assert_eq!(tab.value("globalThis.panel === undefined"), true);
    assert_eq!(tab.value("fetch('/api/job').then((answer) => answer.status)"), 401);
    tab.picture("code");
    // The page asks for the lock, and again when it is seen again.
    let awake =
        "globalThis.locks = 0; navigator.wakeLock.request = async () => { globalThis.locks += 1; }; 0";
    let admitted = browser.open(&panel.url, (1280, 800));
    let mut tab = browser.tab(&admitted);
    tab.wait("globalThis.panel && panel.job");
    tab.send("Page.addScriptToEvaluateOnNewDocument", &serde_json::json!({ "source": awake }));
    tab.send("Page.reload", &serde_json::json!({}));
    tab.wait("globalThis.panel && panel.job && globalThis.locks === 1");
    tab.value("document.dispatchEvent(new Event('visibilitychange'))");
    tab.wait("globalThis.locks === 2");
    // Another screen enters by the code of this one.
    tab.tap("Another screen");
    tab.wait(
        "document.querySelector('#dialog').open && document.querySelector('#dialog img').naturalWidth > 0",
    );
    tab.picture("another-screen");
    let address = tab.value("document.querySelector('.address').innerText");
    let invited = browser.open(address.as_str().unwrap(), (800, 1280));
    browser.tab(&invited).wait("globalThis.panel && panel.job");
}
