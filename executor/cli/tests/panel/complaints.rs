//! What users of other programs complain about, one test each. Their numbers are those of the panel's requirements.

use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use keepout_planner::Mm2;
use serde_json::Value;

use crate::PanelProcess;
use crate::browser::{Browser, Tab, TabId};

/// A panel whose job is planned and aligned, and a browser in which a session of it is steered.
pub struct Steered {
    pub browser: Browser,
    pub panel: PanelProcess,
    pub id: TabId,
}

fn keepout(folder: &Path, arguments: &[&str]) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_keepout"));
    let done = command.args(arguments).env("KEEPOUT_CONFIG", folder.join("config")).output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
}

/// `None` without a browser.
pub(crate) fn steered(name: &str) -> Option<Steered> {
    let mut steered = opened(name, PanelProcess::start)?;
    steered.begin();
    Some(steered)
}

/// A browser at the panel of a job that can be cut. `None` without a browser.
pub(crate) fn opened(name: &str, start: impl FnOnce(&str) -> PanelProcess) -> Option<Steered> {
    let Some(mut browser) = Browser::start(name) else {
        println!("skipped: no chromium");
        return None;
    };
    let panel = start(name);
    let job = panel.folder.join("cover").to_string_lossy().into_owned();
    let points = ["--point", "0,0=-240,-200", "--point", "80,0=-160,-200"];
    keepout(&panel.folder, &[&["align", &job], &points[..]].concat());
    keepout(&panel.folder, &["align", &job, "--top-mm", "-20"]);
    keepout(&panel.folder, &["plan", &job]);
    let id = browser.open(&panel.url, (1280, 800));
    let mut tab = browser.tab(&id);
    tab.wait("globalThis.panel && panel.job");
    tab.tap("cover");
    tab.wait("panel.step === 'rough'");
    Some(Steered { browser, panel, id })
}

impl Steered {
    /// Begins to cut.
    pub(crate) fn begin(&mut self) {
        let mut tab = self.tab();
        tab.tap("Begin to cut");
        tab.tap("Home first");
        tab.wait("panel.state.session && panel.state.session.phase === 'manual'");
        tab.tap("20 %");
    }

    pub(crate) fn tab(&mut self) -> Tab<'_> {
        self.browser.tab(&self.id)
    }
}

pub(crate) fn place(tab: &mut Tab<'_>) -> Mm2 {
    let at = tab.value("panel.state.session.position_mm");
    Mm2::new(at[0].as_f64().unwrap_or(f64::NAN), at[1].as_f64().unwrap_or(f64::NAN))
}

/// Pushes, and waits until the tool moves. The finger stays. The page lets go of a pad that it builds again: then the
/// finger presses again.
pub(crate) fn moving(tab: &mut Tab<'_>) -> Mm2 {
    let before = place(tab);
    for _ in 0..4 {
        let finger = tab.push(Mm2::new(-1.0, -1.0));
        let begun = Instant::now();
        while begun.elapsed() < Duration::from_secs(4) {
            if place(tab).distance(before) >= 2.0 {
                return finger;
            }
            std::thread::sleep(Duration::from_millis(30));
        }
        tab.lift();
    }
    panic!("the tool does not move");
}

/// The tool comes to rest long before the end of travel, and stays where it is.
pub(crate) fn stops(tab: &mut Tab<'_>, why: &str) {
    let before = place(tab);
    let mut last = before;
    // At 40 mm/s the tool would be at the end of travel after eight seconds.
    for _ in 0..8 {
        std::thread::sleep(Duration::from_millis(500));
        let now = place(tab);
        let rests = now == last && tab.value("panel.state.session.rests") == Value::Bool(true);
        if rests {
            break;
        }
        last = now;
    }
    let way = last.distance(before);
    assert!(way < 120.0, "{why}: {way} mm after it was let go");
    std::thread::sleep(Duration::from_millis(700));
    assert_eq!(place(tab), last, "{why}: it moves on");
}

/// 1 and 2: release, blur, a hidden tab, a second finger and a lost socket stop the tool, and nothing of a queue
/// follows.
#[test]
pub(crate) fn c01_whatever_lets_go_stops_the_tool() {
    let Some(mut steered) = steered("c01") else { return };
    let mut tab = steered.tab();
    moving(&mut tab);
    tab.lift();
    stops(&mut tab, "release");
    for (why, script) in [
        ("blur", "dispatchEvent(new Event('blur'))"),
        (
            "hidden",
            "Object.defineProperty(document, 'hidden', { value: true, configurable: true }); \
                    document.dispatchEvent(new Event('visibilitychange'))",
        ),
        ("pagehide", "dispatchEvent(new Event('pagehide'))"),
    ] {
        moving(&mut tab);
        tab.value(script);
        stops(&mut tab, why);
        tab.lift();
        tab.value("Object.defineProperty(document, 'hidden', { value: false, configurable: true })");
    }
    let finger = moving(&mut tab);
    tab.second_finger(&[finger, Mm2::new(200.0, 300.0)]);
    stops(&mut tab, "a second finger");
    tab.lift();
    moving(&mut tab);
    tab.value("panel.link.socket.close()");
    tab.wait("panel.link.alive");
    stops(&mut tab, "a lost socket");
    tab.lift();
    // A page that hangs sends nothing any more.
    moving(&mut tab);
    tab.value("panel.link.send = () => {}");
    stops(&mut tab, "a page that hangs");
}

/// 3: one operator holds control, and others watch; closing a tab harms nobody.
#[test]
pub(crate) fn c03_one_screen_steers_and_others_watch() {
    let Some(mut steered) = steered("c03") else { return };
    let url = steered.panel.url.clone();
    let other = steered.browser.open(&url, (800, 1280));
    let mut watching = steered.browser.tab(&other);
    watching.wait("globalThis.panel && panel.state && panel.job && panel.job.running === 'cut'");
    assert_eq!(watching.value("panel.state.control.holder"), "other");
    watching.wait("document.querySelector('#headline').innerText === 'WATCHING'");
    let before = place(&mut watching);
    watching.push(Mm2::new(-1.0, 0.0));
    std::thread::sleep(Duration::from_millis(700));
    watching.lift();
    assert_eq!(place(&mut watching), before, "a screen that watches moves nothing");
    watching.picture("watching-portrait");
    watching.tap("Take control");
    let mut first = steered.tab();
    first.wait("document.querySelector('#dialog').open");
    first.picture("asked");
    first.tap("Give it");
    let mut watching = steered.browser.tab(&other);
    watching.wait("panel.state.control.holder === 'mine'");
    moving(&mut watching);
    watching.lift();
    // The screen that steers is closed: the tool rests, and the first one takes over.
    watching.send("Page.close", &serde_json::json!({}));
    let mut first = steered.tab();
    first.wait("panel.state.control.holder === 'free'");
    first.tap("Take control");
    first.wait("panel.state.control.holder === 'mine'");
    moving(&mut first);
    first.lift();
    stops(&mut first, "after the other screen was closed");
}

/// 4 and 7: targets are large and apart, coordinates are large, and no unit switch is beside the jog buttons.
#[test]
pub(crate) fn c04_targets_are_large_and_apart() {
    let Some(mut steered) = steered("c04") else { return };
    for (width, height) in [(1280, 800), (1024, 600), (600, 1024)] {
        let mut tab = steered.tab();
        tab.send(
            "Emulation.setDeviceMetricsOverride",
            &serde_json::json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": true }),
        );
        std::thread::sleep(Duration::from_millis(300));
        tab.picture(&format!("steering-{width}x{height}"));
        tab.value(
            "globalThis.seen = (one) => { const box = one.getBoundingClientRect(); const room = one.closest('aside'); \
             const at = document.elementFromPoint(box.left + box.width / 2, box.top + box.height / 2); \
             return one.contains(at) && (!room || box.bottom <= room.getBoundingClientRect().bottom); }; 0",
        );
        // 12 mm are 45.35 pixels of 1/96 inch.
        let small = tab.value(
            "[...document.querySelectorAll('button')].filter(seen).map((one) => \
             [one.innerText, one.getBoundingClientRect()]).filter(([, box]) => box.width < 45.3 || box.height < 45.3) \
             .map(([text]) => text)",
        );
        assert_eq!(small, serde_json::json!([]), "{width} × {height}");
        let close = tab.value(
            "(() => { const all = [...document.querySelectorAll('button')].filter(seen) \
             .map((one) => [one.innerText, one.getBoundingClientRect()]); const found = []; \
             all.forEach(([a, p], i) => all.slice(i + 1).forEach(([b, q]) => { \
             const apart = Math.max(q.left - p.right, p.left - q.right, q.top - p.bottom, p.top - q.bottom); \
             if (apart < 5) found.push([a, b, apart]); })); return found; })()",
        );
        assert_eq!(close, serde_json::json!([]), "{width} × {height}");
        let size = tab.value("parseFloat(getComputedStyle(document.querySelector('#x')).fontSize)");
        assert!(size.as_f64().unwrap() >= 28.0, "{size}");
        assert_eq!(
            tab.value("/inch|unit/i.test(document.querySelector('#side').innerText)"),
            Value::Bool(false)
        );
    }
}

/// 5: stale data is visibly dead within half a second.
#[test]
pub(crate) fn c05_stale_data_is_visibly_dead() {
    let Some(mut steered) = steered("c05") else { return };
    let mut tab = steered.tab();
    assert_eq!(tab.value("document.querySelector('#x').classList.contains('stale')"), Value::Bool(false));
    tab.value("panel.link.socket.onmessage = () => {}");
    std::thread::sleep(Duration::from_millis(650));
    assert_eq!(tab.value("document.querySelector('#x').classList.contains('stale')"), Value::Bool(true));
    assert_eq!(tab.value("document.querySelector('#headline').innerText"), "NO CONNECTION");
    tab.picture("stale");
}

/// Starts the spindle and the contour of the pocket.
pub(crate) fn contour_of_the_pocket(tab: &mut Tab<'_>) {
    tab.tap("Spindle stands");
    tab.wait("panel.state.session.spindle === true");
    // Cross to the pocket, and start there.
    tab.taps("Cross to 4", "!panel.state.session.rests");
    tab.wait("panel.state.session.height_mm < 1.2 && panel.state.session.rests");
    tab.hold("Hold 1 s to arm", Duration::from_millis(1300));
    tab.wait("panel.state.session.armed");
    tab.presses("panel.state.session.phase !== 'manual' || panel.state.session.height_mm < -1.5", |tab| {
        let at = tab.place("↓");
        tab.second_finger(&[at]);
    });
    if tab.value("panel.state.session.phase") != "contouring" {
        tab.presses("panel.state.session.phase === 'contouring'", |tab| _ = tab.push(Mm2::new(1.0, 0.0)));
    }
}

/// The time that the contour still takes, s, and when it was read.
fn time_left(tab: &mut Tab<'_>) -> (Instant, f64) {
    (Instant::now(), tab.value("panel.state.session.left_s").as_f64().unwrap())
}

/// 6, 9 and 10: a reload within a contour shows the truth, the contour goes on, and the time left is honest.
#[test]
pub(crate) fn c06_reload_within_a_contour_shows_the_truth() {
    let Some(mut steered) = steered("c06") else { return };
    let mut tab = steered.tab();
    contour_of_the_pocket(&mut tab);
    tab.wait("panel.state.session.left_s > 5");
    let (begun, left) = time_left(&mut tab);
    tab.send("Page.reload", &serde_json::json!({}));
    tab.wait("globalThis.panel && panel.state && panel.state.session");
    assert_eq!(tab.value("panel.state.session.phase"), "contouring");
    assert_eq!(tab.value("panel.state.control.holder"), "mine", "it steers again");
    std::thread::sleep(Duration::from_secs(4));
    let (_, now) = time_left(&mut tab);
    let gone = begun.elapsed().as_secs_f64();
    assert!(left - now > 0.4 * gone && left - now < 2.0 * gone, "{left} s, then {now} s after {gone} s");
    tab.wait("document.querySelector('#detail').innerText.includes('%')");
    // What is shown is what is left, under an override, too.
    let shown = "parseFloat(document.querySelector('#left').innerText.replace(/[^0-9.]/g, '')) * 60";
    let off = format!("Math.abs({shown} - panel.state.session.left_s) < 8");
    tab.wait(&off);
    let (_, before) = time_left(&mut tab);
    tab.taps("25 %", "panel.state.session.feed_percent === 25");
    tab.wait(&format!("panel.state.session.left_s > {}", 1.8 * before));
    tab.wait(&off);
    tab.taps("100 %", "panel.state.session.feed_percent === 100");
    tab.picture("reloaded");
    tab.tap("FEED HOLD");
    tab.wait("panel.state.session.phase === 'holding'");
    tab.tap("Go on");
    tab.wait("panel.state.session.phase === 'contouring'");
}

/// 11: focus neither traps nor leaks keys.
#[test]
pub(crate) fn c11_keys_jog_only_where_they_are_meant() {
    let Some(mut steered) = steered("c11") else { return };
    let mut tab = steered.tab();
    let before = place(&mut tab);
    // A button that has the focus does not trap the keys.
    tab.value("document.querySelector('#bar button').focus()");
    tab.key("ArrowLeft", true);
    tab.wait(&format!("panel.state.session.position_mm[0] < {} - 2", before.x));
    tab.key("ArrowLeft", false);
    stops(&mut tab, "the key was released");
    // Keys that are typed into a field do not jog.
    tab.value(
        "(() => { const field = document.createElement('input'); field.id = 'typed'; document.body.append(field); \
         field.focus(); })()",
    );
    let before = place(&mut tab);
    tab.key("ArrowLeft", true);
    std::thread::sleep(Duration::from_millis(600));
    tab.key("ArrowLeft", false);
    assert_eq!(place(&mut tab), before);
    tab.value("document.querySelector('#typed').remove()");
    // A dialog is open: keys are its own.
    tab.value("document.querySelector('#dialog').showModal()");
    tab.key("ArrowLeft", true);
    std::thread::sleep(Duration::from_millis(600));
    assert_eq!(place(&mut tab), before);
    tab.value("document.querySelector('#dialog').close()");
    tab.key("ArrowLeft", false);
    // A key that was down when the window lost the focus does not go on.
    tab.key("ArrowRight", true);
    tab.wait(&format!("panel.state.session.position_mm[0] > {} + 1", before.x));
    tab.value("dispatchEvent(new Event('blur'))");
    stops(&mut tab, "the window lost the focus");
    tab.key("ArrowRight", false);
}
