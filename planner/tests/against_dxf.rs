//! Compares our reader with the `dxf` crate: both find the same entities in every drawing that both can read.
//!
//! The reasons for a reader of our own: the crate has no HATCH, drops the frozen flag of layers, and keeps
//! only the last of several ENTITIES sections. It reports neither the place of an entity in the file nor the
//! faulty group, and takes several times as long (docs/contributor/planning.md).

use std::collections::BTreeMap;
use std::io::{Cursor, Write as _};
use std::path::{Path, PathBuf};

use dxf::entities::EntityType;
use keepout_planner::drawing::census;

fn drawings() -> Vec<PathBuf> {
    let ours = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/drawings");
    let shared = std::env::var_os("KEEPOUT_SHARED").map(|shared| PathBuf::from(shared).join("dxf/dev"));
    if shared.is_none() {
        // The harness would keep what `eprintln!` prints.
        let _ =
            writeln!(std::io::stderr(), "skipped: no KEEPOUT_SHARED (the test reads only our own drawings)");
    }
    let files =
        |folder: PathBuf| std::fs::read_dir(folder).into_iter().flatten().flatten().map(|file| file.path());
    std::iter::once(ours).chain(shared).flat_map(files).collect()
}

fn by_crate(bytes: &[u8]) -> Option<BTreeMap<&'static str, usize>> {
    let drawing = std::panic::catch_unwind(|| dxf::Drawing::load(&mut Cursor::new(bytes))).ok()?.ok()?;
    let mut counts = BTreeMap::new();
    for entity in drawing.entities() {
        let name = match entity.specific {
            EntityType::Line(_) => "LINE",
            EntityType::Arc(_) => "ARC",
            EntityType::Circle(_) => "CIRCLE",
            EntityType::Ellipse(_) => "ELLIPSE",
            EntityType::LwPolyline(_) => "LWPOLYLINE",
            EntityType::Spline(_) => "SPLINE",
            EntityType::Insert(_) => "INSERT",
            _ => continue,
        };
        *counts.entry(name).or_default() += 1;
    }
    Some(counts)
}

#[test]
fn both_readers_find_the_same_entities() {
    // Drawings with several ENTITIES sections: the crate keeps only the last section.
    const CRATE_LOSES: [&str; 2] = ["many_sections.dxf", "ezdxf__recover01.dxf"];
    let (mut same, mut differ) = (0, Vec::new());
    for path in drawings() {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let bytes = std::fs::read(&path).unwrap();
        let (Some(theirs), Ok(mut ours)) = (by_crate(&bytes), census(&bytes)) else { continue };
        // Not compared: POLYLINE, where the crate counts meshes too, and HATCH and SOLID.
        ours.retain(|kind, _| !matches!(*kind, "POLYLINE" | "HATCH" | "SOLID"));
        if ours == theirs || CRATE_LOSES.contains(&name.as_str()) {
            same += 1;
        } else {
            differ.push(format!("{name}: ours {ours:?}, theirs {theirs:?}"));
        }
    }
    assert!(differ.is_empty(), "{}", differ.join("\n"));
    assert!(same >= 60, "only {same} drawings were compared");
}
