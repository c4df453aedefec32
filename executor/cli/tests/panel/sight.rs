//! What can be seen: pictures of every step at three sizes, contrast, and the frames of a large map.

use serde_json::{Value, json};

use crate::PanelProcess;
use crate::browser::Tab;
use crate::complaints::{opened, steered};

/// Sizes of screens: 10 inches, 7 inches, and 7 inches upright.
const SIZES: [(u32, u32); 3] = [(1280, 800), (1024, 600), (600, 1024)];

fn resize(tab: &mut Tab<'_>, (width, height): (u32, u32)) {
    let size = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": true });
    tab.send("Emulation.setDeviceMetricsOverride", &size);
    std::thread::sleep(std::time::Duration::from_millis(250));
}

/// Texts of less contrast than WCAG's level AA asks for: 4.5, or 3 for large ones. Struck-through and disabled ones do
/// not count.
const PALE: &str = include_str!("pale.js");

/// Keeps pictures of a step at three sizes, light and dark, and checks the contrast of its texts.
fn look(tab: &mut Tab<'_>, step: &str) {
    for scheme in ["light", "dark"] {
        let media = json!({ "features": [{ "name": "prefers-color-scheme", "value": scheme }] });
        tab.send("Emulation.setEmulatedMedia", &media);
        for size in SIZES {
            resize(tab, size);
            if scheme == "light" || size == SIZES[0] {
                tab.picture(&format!("{step}-{scheme}-{}x{}", size.0, size.1));
            }
            let wide = tab.value("document.documentElement.scrollWidth <= innerWidth");
            assert_eq!(wide, Value::Bool(true), "{step}: the page is wider than the screen of {size:?}");
        }
        assert_eq!(tab.value(PALE), json!([]), "{step}, {scheme}");
    }
    resize(tab, SIZES[0]);
}

#[test]
fn every_step_is_legible_at_three_sizes_light_and_dark() {
    let Some(mut steered) = opened("sight", PanelProcess::start) else { return };
    let mut tab = steered.tab();
    for step in ["drawing", "tool", "place"] {
        tab.value(&format!("panel.go('{step}')"));
        look(&mut tab, step);
    }
    tab.tap("Begin to cut");
    tab.wait("document.querySelector('#dialog').open");
    look(&mut tab, "begin");
    tab.value("document.querySelector('#dialog').close()");
    for language in ["de", "pt"] {
        tab.value(&format!("localStorage.setItem('language', '{language}')"));
        tab.send("Page.reload", &json!({}));
        tab.wait("globalThis.panel && panel.step === 'rough'");
        look(&mut tab, &format!("place-{language}"));
    }
    tab.value("localStorage.removeItem('language')");
    tab.send("Page.reload", &json!({}));
    tab.wait("globalThis.panel && panel.step === 'rough'");
    steered.begin();
    look(&mut steered.tab(), "rough");
}

/// A map of 100,000 edges is drawn with the points that the screen can show. The times of frames while it is panned and
/// zoomed are printed: 60 a second, without a graphics card.
#[test]
fn map_of_100_000_edges_is_drawn_with_few_points() {
    let Some(mut steered) = steered("frames") else { return };
    let mut tab = steered.tab();
    let measured = tab.value(include_str!("frames.js"));
    println!("100,000 edges, ms, median and p95: {measured}");
    assert_eq!(measured["points"], 25_000);
    // Of the 50,000 points of the face, the whole view needs a part, and a near one little.
    let drawn = |name: &str| measured[name].as_u64().unwrap();
    assert!((500..12_000).contains(&drawn("drawn")) && drawn("near") < 2_000, "{measured}");
    tab.picture("100000-edges");
}
