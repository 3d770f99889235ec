//! Copies of a data directory.

use super::*;

#[test]
fn a_backup_has_recordings_and_last_states_for_its_owner_alone() {
    use std::os::unix::fs::PermissionsExt;
    let dir = tempfile::tempdir().unwrap();
    let (data, copy) = (dir.path().join("data"), dir.path().join("copy"));
    let store = open(&data);
    create(&store, &["a"]);
    let checkpoint = Checkpoint {
        findings: finished().findings,
        snapshot: vec![1, 2, 3],
    };
    store.origins().write("a", &checkpoint).unwrap();
    Checkpoints::open(&data.join("finals"))
        .unwrap()
        .write("a", &checkpoint)
        .unwrap();
    store.recordings().make("a").unwrap();
    let recording = store.recordings().of("a");
    for name in ["live.evrec", "1.json", "1.evrec.part"] {
        std::fs::write(recording.join(name), name).unwrap();
    }
    // Still being written.
    std::fs::write(recording.join(".tmp1"), "").unwrap();
    backup(&data, &copy).unwrap();
    let names = |path: &Path| {
        let entries = std::fs::read_dir(path).unwrap();
        let mut names: Vec<String> = entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    };
    let copied = copy.join("recordings/a");
    assert_eq!(names(&copied), ["1.evrec.part", "1.json", "live.evrec"]);
    assert_eq!(
        std::fs::read(copied.join("live.evrec")).unwrap(),
        b"live.evrec"
    );
    let mode = |path: &Path| path.metadata().unwrap().permissions().mode() & 0o777;
    let mut folders = vec![copy.clone()];
    while let Some(folder) = folders.pop() {
        assert_eq!(mode(&folder), 0o700, "{}", folder.display());
        for name in names(&folder) {
            let path = folder.join(name);
            match path.is_dir() {
                true => folders.push(path),
                false => assert_eq!(mode(&path), 0o600, "{}", path.display()),
            }
        }
    }
    let restored = open(&copy);
    let last = restored.finals().read("a").unwrap();
    assert_eq!(last.as_ref(), Some(&checkpoint));
    assert_eq!(restored.origins().read("a").unwrap(), Some(checkpoint));
}

#[test]
fn a_backup_inside_the_data_directory_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let data = dir.path().join("data");
    drop(open(&data));
    let before = std::fs::read_dir(&data).unwrap().count();
    for to in [
        "data",
        "data/copy",
        "data/new/copy",
        "other/../data/copy",
        "data/finals/copy",
    ] {
        let error = backup(&data, &dir.path().join(to)).unwrap_err().to_string();
        assert!(error.contains("inside the data directory"), "{to}: {error}");
        assert_eq!(std::fs::read_dir(&data).unwrap().count(), before, "{to}");
    }
}
