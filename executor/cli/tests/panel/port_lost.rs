//! The cable is pulled while a contour is cut: complaints 8 and 9.

use crate::complaints::{Steered, contour_of_the_pocket, opened};
use crate::{BenchMill, PanelProcess};

/// A browser at the panel of a job, with a mill behind a port of its own. `None` without a browser.
fn at_bench(name: &str) -> Option<(Steered, BenchMill)> {
    let mut bench = None;
    let steered = opened(name, |name| {
        let folder = PanelProcess::folder(name);
        bench = Some(BenchMill::start(&folder));
        PanelProcess::over(folder)
    })?;
    Some((steered, bench?))
}

/// 8 and 9: a fault names its cause and the remedy and offers one button, and the contour goes on after a disconnect.
#[test]
pub(crate) fn c08_lost_port_names_the_remedy_and_the_contour_goes_on() {
    let Some((mut steered, bench)) = at_bench("c08") else { return };
    let job = steered.panel.folder.join("cover/job.toml");
    let mut tab = steered.tab();
    let chosen = "[...document.querySelectorAll('select')].forEach((one) => { one.value = 'bench'; \
                  one.dispatchEvent(new Event('change')); })";
    tab.value("panel.go('tool')");
    tab.wait("document.querySelector('select option[value=bench]')");
    tab.value(chosen);
    tab.wait("panel.job.machine === 'bench'");
    assert!(std::fs::read_to_string(job).unwrap().contains("machine = \"bench\""));
    tab.tap("Prove and save the plan");
    tab.wait("panel.job.figures.length > 5");
    tab.value("panel.go('place')");
    steered.begin();
    let mut tab = steered.tab();
    contour_of_the_pocket(&mut tab);
    tab.wait("panel.state.session.share > 0.1");
    bench.unplug();
    tab.wait("panel.state.session.phase === 'faulted'");
    tab.wait("document.querySelector('#headline').innerText === 'STOPPED'");
    tab.picture("port-lost");
    let detail = tab.value("document.querySelector('#detail').innerText");
    let detail = detail.as_str().unwrap();
    assert!(detail.contains("port") && detail.contains("lost"), "the cause: {detail}");
    assert!(detail.contains("Plug") || detail.contains("Check"), "the remedy: {detail}");
    let offered = tab.value("[...document.querySelectorAll('#bar button.main')].map((one) => one.innerText)");
    assert_eq!(offered, serde_json::json!(["Begin again"]));
    tab.tap("Begin again");
    tab.wait("panel.state.session.interrupted");
    tab.wait(
        "[...document.querySelectorAll('#bar button.main')].some((one) => one.innerText.startsWith('Finish') \
              && !one.disabled)",
    );
    tab.tap("Finish the contour");
    // Where the tool stopped a little too near the wall, it begins from above: the screen says so.
    std::thread::sleep(std::time::Duration::from_secs(3));
    if tab.value("panel.state.session.phase") != "contouring" {
        tab.tap("Raise");
        tab.wait("panel.state.session.phase === 'manual' && panel.state.session.rests");
        tab.tap("Finish the contour");
        tab.wait("panel.state.session.phase === 'contouring'");
    }
    tab.picture("port-found");
    let two_cut = "panel.job.contours.filter(({ state }) => state === 'cut').length > 1";
    tab.wait_for(two_cut, std::time::Duration::from_secs(60));
}

/// A machine is stored from the panel: the controller states its figures, and the person answers the others.
#[test]
pub(crate) fn machine_is_stored_by_touch() {
    let Some((mut steered, _bench)) = at_bench("machine") else { return };
    let port = std::fs::canonicalize(steered.panel.folder.join("port")).unwrap();
    let stored = steered.panel.folder.join("config/machine/shop.toml");
    let mut tab = steered.tab();
    tab.value("panel.go('tool')");
    let mut store = |port: &str| {
        tab.tap("New machine");
        tab.wait("document.querySelector('#dialog').open");
        tab.value(&format!(
            "(() => {{ const [name, port] = document.querySelectorAll('#dialog input'); name.value = 'shop'; \
             port.value = {port:?}; document.querySelector('#dialog input[type=checkbox]').checked = true; }})()"
        ));
        tab.picture("machine");
        tab.tap("Ask the controller");
        tab.wait("!document.querySelector('#dialog').open && !document.body.hasAttribute('aria-busy')");
    };
    store("/etc/passwd");
    assert!(!stored.exists());
    store(&port.to_string_lossy());
    tab.wait("panel.job.machine === 'shop'");
    let text = std::fs::read_to_string(stored).unwrap();
    assert!(text.contains("[profile.z]") && text.contains("contour_error_mm = 0.05"), "{text}");
}
