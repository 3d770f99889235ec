//! Movable objects through the real binary: the README's run, and its files.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use serde_json::Value;
use tests::command::evswarm;

#[test]
fn the_readmes_boxes_are_pushed_the_same_way_twice() {
    let directory = tempfile::tempdir().unwrap();
    let spec = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../experiments/pushing-boxes.json"
    );
    let result = |name: &str| {
        let out = directory.path().join(name);
        let done = evswarm(&["run", spec, "--out", out.to_str().unwrap()], "");
        assert_eq!(done.code, Some(0), "{done:?}");
        let file = |name| std::fs::read_to_string(out.join(name)).unwrap();
        (file("result.json"), file("objects.csv"))
    };
    let first = result("first");
    assert_eq!(first, result("second"));
    let (first, over_time) = first;
    let first: Value = serde_json::from_str(&first).unwrap();
    let objects = first["objects"].as_array().unwrap();
    assert_eq!(objects.len(), 3);
    let moved_m = |n: usize| objects[n]["moved_m"].as_f64().unwrap();
    assert!(moved_m(0) > 0.01 && moved_m(2) > 0.01, "{objects:?}");
    assert!(
        moved_m(1) < moved_m(2),
        "the heavy box moves less: {objects:?}"
    );
    // The start, 9 tenths and the end of the first 4 epochs, and the other 16.
    let lines: Vec<&str> = over_time.lines().collect();
    assert_eq!(lines.len(), 1 + 3 * (1 + 40 + 16));
    // Babbling may have moved it, which does not count.
    assert!(
        lines[1].starts_with("0,0,0,") && lines[1].ends_with(",0.0"),
        "{}",
        lines[1]
    );
    for (line, object) in lines[lines.len() - 3..].iter().zip(objects) {
        assert!(line.starts_with("40000,20,"), "{line}");
        let moved_m: f64 = line.rsplit(',').next().unwrap().parse().unwrap();
        assert_eq!(Some(moved_m), object["moved_m"].as_f64());
    }
}
