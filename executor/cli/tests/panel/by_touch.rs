//! The whole job by touch, from the list of jobs to the printed report.

use std::time::{Duration, Instant};

use keepout_planner::Mm2;

use crate::PanelProcess;
use crate::browser::{Browser, Tab};

/// The tool on the map, mm, as soon as the page knows it.
fn tool(tab: &mut Tab<'_>) -> Mm2 {
    tab.wait("panel.map.tool");
    let at = tab.value("panel.map.tool");
    Mm2::new(at[0].as_f64().expect("x"), at[1].as_f64().expect("y"))
}

/// Jogs the tool to a place of the map by the pad, as the page shows it, until it rests within 4 mm of it: who looks at
/// a slow page lets go too late, and pushes again, and slows down earlier.
fn jog_to(tab: &mut Tab<'_>, to: Mm2) {
    let begun = Instant::now();
    let mut slow_within_mm = 20.0;
    while tool(tab).distance(to) > 4.0 {
        assert!(begun.elapsed() < Duration::from_secs(60), "the tool is at {}, and not at {to}", tool(tab));
        push_towards(tab, to, slow_within_mm);
        slow_within_mm *= 2.0;
    }
}

/// Pushes the pad until the tool is near a place, has passed it, or stands. On a slow page the finger answers late, and
/// would lead the tool round the place for ever. A page that let go takes the finger only when it comes down again.
fn push_towards(tab: &mut Tab<'_>, to: Mm2, slow_within_mm: f64) {
    let centre = tab.place("#pad");
    let radius = tab.value("document.querySelector('#pad').clientWidth / 2").as_f64().unwrap();
    tab.push(Mm2::ZERO);
    let mut moved = (tool(tab), Instant::now());
    let mut nearest = f64::INFINITY;
    while moved.1.elapsed() < Duration::from_secs(2) {
        let at = tool(tab);
        let (way, length) = (to - at, at.distance(to));
        nearest = nearest.min(length);
        if length < 0.6 || length > nearest + 2.0 {
            break;
        }
        if at != moved.0 {
            moved = (at, Instant::now());
        }
        let share = (length / slow_within_mm).clamp(0.2, 0.95) / length;
        tab.drag(&[centre + Mm2::new(way.x, -way.y) * (share * radius)]);
        std::thread::sleep(Duration::from_millis(40));
    }
    tab.lift();
    tab.wait("panel.state.session.rests");
}

/// Lowers or raises the tool by the button until it has passed the height.
fn lift_to(tab: &mut Tab<'_>, height_mm: f64) {
    let height = |tab: &mut Tab<'_>| tab.value("panel.state.session.height_mm").as_f64().unwrap();
    let below = height(tab) > height_mm;
    let (button, passed) = if below { ("↓", "<") } else { ("↑", ">=") };
    tab.presses(&format!("panel.state.session.height_mm {passed} {height_mm}"), |tab| {
        let at = tab.place(button);
        tab.second_finger(&[at]);
    });
    tab.wait("panel.state.session.rests");
    let rests_at = height(tab);
    assert_eq!(rests_at < height_mm, below, "the tool rests at {rests_at} mm, above {}", tool(tab));
}

#[test]
fn demo_part_is_machined_by_touch() {
    let Some(mut browser) = Browser::start("whole-job") else {
        println!("skipped: no chromium");
        return;
    };
    let panel = PanelProcess::start("whole-job");
    let id = browser.open(&panel.url, (1280, 800));
    let mut tab = browser.tab(&id);
    tab.wait("globalThis.panel && panel.job");
    tab.picture("1-jobs");
    tab.tap("cover");
    tab.wait("panel.job.name === 'cover'");
    tab.picture("1-drawing");
    tab.tap("This is my part");
    tab.tap("Prove and save the plan");
    tab.wait("panel.job.figures.length > 5");
    tab.picture("2-planned");
    tab.tap("Next");
    tab.picture("3-place");
    // The place of the part is not known yet.
    tab.wait(
        "[...document.querySelectorAll('button')].find((one) => one.innerText === 'Begin to cut')?.disabled",
    );
    touch_off(&mut tab);
    cut(&mut tab);
    tab.wait("panel.job.running === null && panel.job.reported");
    tab.wait("panel.job.contours.every((contour) => contour.state === 'cut')");
    tab.picture("6-report");
    let report = std::fs::read_to_string(panel.folder.join("cover/report.html")).unwrap();
    assert!(report.contains("4 of 4 contours cut"), "{}", &report[..2000]);
    let closest = report.split("closest approach of tool and part</th><td>").nth(1).unwrap();
    let closest: f64 = closest.split(' ').next().unwrap().parse().unwrap();
    assert!((0.0..0.1).contains(&closest), "{closest} mm");
    let address = tab.value("location.origin + '/api/document/report'");
    tab.send("Page.navigate", &serde_json::json!({ "url": address }));
    tab.wait("document.body?.innerText.includes('4 of 4 contours cut')");
    assert!(tab.print("6-report") > 10_000);
}

/// Homes, and touches three edges and the top of a part that lies in the middle of the table.
fn touch_off(tab: &mut Tab<'_>) {
    tab.tap("Begin to touch off");
    tab.tap("Home first");
    tab.wait("panel.state.session && panel.state.session.phase === 'manual'");
    tab.taps("100 %", "panel.steering.speed === 1");
    tab.picture("3-touch");
    let places = tab.value("panel.job.touches[0].map((place) => place.at_mm)");
    let (width, height) = (80.0, 50.0);
    for (number, place) in (1..).zip(places.as_array().unwrap()) {
        match (place[0].as_f64(), place[1].as_f64()) {
            (Some(x), Some(y)) => {
                let out = |c: f64, size: f64| {
                    if c < 0.5 {
                        -3.0
                    } else if c > size - 0.5 {
                        size + 3.0
                    } else {
                        c
                    }
                };
                jog_to(tab, Mm2::new(out(x, width), out(y, height)));
            }
            _ => lift_to(tab, -20.0),
        }
        // The panel takes no place while the machine moves.
        tab.taps("Take", &format!("panel.job.touches[1] === {number}"));
    }
    tab.wait("document.querySelector('#headline').innerText === 'ALL TAKEN'");
    tab.picture("3-taken");
    lift_to(tab, -10.0);
    tab.tap("End the session");
    tab.wait("panel.job.running === null && panel.job.step === 'rough'");
    tab.wait("panel.job.message.includes('The place of the part is known')");
    tab.picture("4-place-known");
}

/// Begins the session, lowers the tool beside the part, arms, and touches the part.
fn cut(tab: &mut Tab<'_>) {
    tab.tap("Begin to cut");
    tab.tap("It is homed");
    tab.wait("panel.state.session && panel.state.session.phase === 'manual'");
    tab.taps("Raise", "panel.state.session.height_mm > 4.9");
    tab.wait("panel.state.session.rests");
    tab.taps("Spindle stands", "panel.state.session.spindle === true");
    tab.taps("50 %", "panel.steering.speed === 0.5");
    jog_to(tab, Mm2::new(-16.0, 25.0));
    lift_to(tab, -0.8);
    tab.picture("4-rough");
    tab.hold("Hold 1 s to arm", Duration::from_millis(1300));
    tab.wait("panel.state.session.armed");
    tab.picture("4-armed");
    tab.push(Mm2::new(1.0, 0.0));
    tab.wait("panel.state.session.phase === 'contouring'");
    tab.lift();
    tab.picture("5-finish");
    tab.wait_for("document.querySelector('#headline').innerText === 'ALL CUT'", Duration::from_secs(240));
    tab.picture("5-all-cut");
    tab.tap("End the session");
}
