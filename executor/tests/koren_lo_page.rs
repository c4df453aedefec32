//! `docs/koren-lo.md` and its pictures are what `keepout servo page` writes.

use std::path::Path;

use keepout_executor::servo::page::page;

#[test]
fn page_is_the_one_that_is_written() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs");
    let page = page(&mut |_, _| {}).unwrap();
    let stale = "is not what `keepout servo page` writes: run it, and look at what changed";
    let kept = |path: &Path| std::fs::read_to_string(path).unwrap_or_default();
    assert!(kept(&docs.join("koren-lo.md")) == page.text, "docs/koren-lo.md {stale}");
    for (name, svg) in &page.pictures {
        assert!(kept(&docs.join("koren-lo").join(name)) == *svg, "docs/koren-lo/{name} {stale}");
    }
}
