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
const PALE: &str = r"
(() => {
  const channels = (text) => { const all = (text.match(/[\d.]+/g) ?? []).map(Number); return all.length ? all : [0, 0, 0, 0]; };
  const light = ([r, g, b]) => { const one = (c) => { c /= 255; return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4; };
    return 0.2126 * one(r) + 0.7152 * one(g) + 0.0722 * one(b); };
  const ground = (element) => { for (let at = element; at; at = at.parentElement) {
    const colour = channels(getComputedStyle(at).backgroundColor); if (colour[3] === undefined || colour[3] > 0.99) return colour; }
    return [255, 255, 255]; };
  const found = [];
  for (const element of document.querySelectorAll('body *')) {
    const own = [...element.childNodes].some((node) => node.nodeType === 3 && node.textContent.trim());
    const style = getComputedStyle(element);
    if (!own || !element.offsetParent || element.disabled || element.closest('iframe') || element.classList.contains('stale')) continue;
    const [a, b] = [light(channels(style.color)), light(ground(element))].sort((x, y) => y - x);
    const ratio = (a + 0.05) / (b + 0.05);
    const size = parseFloat(style.fontSize);
    const large = size >= 24 || size >= 18.66 && Number(style.fontWeight) >= 700;
    if (ratio < (large ? 3 : 4.5)) found.push([element.textContent.trim().slice(0, 40), ratio]);
  }
  return found;
})()";

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
    let measured = tab.value(
        r"(async () => {
  const line = (radius) => { const points = []; for (let k = 0; k < 25000; k += 1) {
    const phi = 2 * Math.PI * k / 25000; const r = radius + 2 * Math.sin(9 * phi) + 0.1 * Math.sin(997 * phi);
    points.push(40 + r * Math.cos(phi), 25 + r * Math.sin(phi)); } return points; };
  const map = { bounds: [-60, -75, 140, 125], faces: [[0, [line(90), line(70)]]], zones: [], rest: [], left_out: [],
    contours: [[1, -1, line(93)], [2, -1, line(67)]], tool_radius_mm: 3 };
  panel.map.take(map);
  const work = []; const gaps = []; let last = performance.now();
  const frame = () => new Promise((done) => requestAnimationFrame(done));
  for (let k = 0; k < 240; k += 1) {
    if (k % 120 < 60) panel.map.view.x += 0.3; else panel.map.zoomBy(k % 120 < 90 ? 1.05 : 1 / 1.05);
    const begun = performance.now(); panel.map.draw(); work.push(performance.now() - begun);
    await frame(); const now = performance.now(); gaps.push(now - last); last = now;
  }
  const rank = (all, share) => [...all].sort((a, b) => a - b)[Math.floor(share * (all.length - 1))];
  panel.map.view.zoom *= 1; panel.map.move([40, 25], []);
  const still = []; for (let k = 0; k < 60; k += 1) { const begun = performance.now(); panel.map.draw(); still.push(performance.now() - begun); await frame(); }
  panel.map.fit();
  const drawn = panel.map.shapes.faces[0][1].drawn;
  panel.map.zoomBy(60, [panel.map.canvas.width * 0.93, panel.map.canvas.height / 2]); panel.map.draw();
  return { drawn, near: panel.map.shapes.faces[0][1].drawn, work: [rank(work, 0.5), rank(work, 0.95)], still: [rank(still, 0.5), rank(still, 0.95)], gaps: [rank(gaps, 0.5), rank(gaps, 0.95)],
    points: panel.map.shapes.faces[0][1].lines[0].points.length / 2 };
})()",
    );
    println!("100,000 edges, ms, median and p95: {measured}");
    assert_eq!(measured["points"], 25_000);
    // Of the 50,000 points of the face, the whole view needs a part, and a near one little.
    let drawn = |name: &str| measured[name].as_u64().unwrap();
    assert!((500..12_000).contains(&drawn("drawn")) && drawn("near") < 2_000, "{measured}");
    tab.picture("100000-edges");
}
