//! Movable objects through the real binary: the README's run, and its files.
#![allow(clippy::unwrap_used)]

use serde_json::Value;
use tests::command::evswarm;

#[test]
fn the_readmes_boxes_are_pushed_the_same_way_twice() {
    let directory = tempfile::tempdir().unwrap();
    let spec = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/pushing-boxes.json");
    let result = |name: &str| {
        let out = directory.path().join(name);
        let done = evswarm(&["run", spec, "--out", out.to_str().unwrap()], "");
        assert_eq!(done.code, Some(0), "{done:?}");
        std::fs::read_to_string(out.join("result.json")).unwrap()
    };
    let first = result("first");
    assert_eq!(first, result("second"));
    let first: Value = serde_json::from_str(&first).unwrap();
    let objects = first["objects"].as_array().unwrap();
    assert_eq!(objects.len(), 3);
    let moved_m = |n: usize| objects[n]["moved_m"].as_f64().unwrap();
    assert!(moved_m(0) > 0.01 && moved_m(2) > 0.01, "{objects:?}");
    assert!(
        moved_m(1) < moved_m(2),
        "the heavy box moves less: {objects:?}"
    );
}
