//! `evswarm run --out`: every place that can be written is, every other is refused at once.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Command, Stdio};

use serde_json::Value;
use tests::command::{self, Done};
use tests::{program, small_spec};

/// A run of hours: what is refused must be refused before it.
fn long_spec() -> Value {
    let mut spec = small_spec();
    spec["epochs"] = 100_000.into();
    spec["steps_per_epoch"] = 10_000.into();
    spec
}

fn names(directory: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(directory)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

fn check_complete(out: &Path, home: &Path) {
    let reference = home.join("reference");
    assert_eq!(command::run(&small_spec(), &reference, "1").code, Some(0));
    assert_eq!(names(out), names(&reference));
    for name in names(out).iter().filter(|name| *name != "timing.json") {
        assert_eq!(
            fs::read(out.join(name)).unwrap(),
            fs::read(reference.join(name)).unwrap(),
            "{name}"
        );
    }
}

fn check_again(done: &Done) {
    assert_eq!(done.code, Some(0), "{done:?}");
    assert!(done.stdout.contains("already complete"), "{done:?}");
}

#[test]
fn an_empty_directory_and_a_link_to_one_are_filled() {
    let home = tempfile::tempdir().unwrap();
    let (real, link) = (home.path().join("real"), home.path().join("link"));
    fs::create_dir(&real).unwrap();
    symlink(&real, &link).unwrap();
    let done = command::run(&small_spec(), &link, "1");
    assert_eq!(done.code, Some(0), "{done:?}");
    assert!(link.is_symlink());
    check_complete(&real, home.path());
    check_again(&command::run(&small_spec(), &link, "1"));
    assert_eq!(names(home.path()), ["link", "real", "reference"]);
}

/// Runs a shell's commands in `home`, with the program as `$EVSWARM` and the spec as its input.
fn shell(home: &Path, unshare: &[&str], commands: &str) -> Done {
    let mut spec = tempfile::tempfile().unwrap();
    serde_json::to_writer(&mut spec, &small_spec()).unwrap();
    std::io::Seek::rewind(&mut spec).unwrap();
    let mut line: Vec<&str> = unshare.to_vec();
    line.extend(["sh", "-ec", commands]);
    Command::new(line[0])
        .args(&line[1..])
        .current_dir(home)
        .env("EVSWARM", program("evswarm"))
        .env("XDG_RUNTIME_DIR", home)
        .stdin(Stdio::from(spec))
        .output()
        .unwrap()
        .into()
}

/// A place that cannot be replaced gets its files one by one: always the present directory, and a
/// mount point where the system lets a test have one.
#[test]
fn a_directory_that_must_stay_gets_its_files_one_by_one() {
    let home = tempfile::tempdir().unwrap();
    let out = home.path().join("out");
    fs::create_dir(&out).unwrap();
    let done = shell(&out, &[], "$EVSWARM run - --out .; test -e result.json");
    assert_eq!(done.code, Some(0), "{done:?}");
    check_complete(&out, home.path());

    let mounted = home.path().join("mounted");
    fs::create_dir(&mounted).unwrap();
    let mount = "mount -t tmpfs none mounted && cat /proc/self/mountinfo | grep -q mounted";
    let user: &[&str] = &["unshare", "--map-root-user", "--mount"];
    for unshare in [&["unshare", "--mount"], user] {
        if shell(home.path(), unshare, mount).code != Some(0) {
            continue;
        }
        let run = format!("{mount}\n$EVSWARM run - --out mounted\ncp -r mounted copied");
        let done = shell(home.path(), unshare, &run);
        assert_eq!(done.code, Some(0), "{done:?}");
        let copied = home.path().join("copied");
        fs::remove_dir_all(home.path().join("reference")).unwrap();
        check_complete(&copied, home.path());
        assert!(!home.path().join("mounted.partial").exists());
        return;
    }
    eprintln!("the system lets nobody mount: only the present directory was tried");
}

#[test]
fn what_cannot_be_written_is_refused_before_the_first_step() {
    let home = tempfile::tempdir().unwrap();
    let path = |name: &str| home.path().join(name);
    fs::write(path("file"), "").unwrap();
    symlink(path("nowhere"), path("broken")).unwrap();
    for out in [
        path("file"),
        path("file").join("below"),
        path("broken"),
        "/proc/evswarm-out".into(),
        "/proc/self/task".into(),
    ] {
        let done = command::run(&long_spec(), &out, "1");
        assert_eq!(done.code, Some(1), "{}: {done:?}", out.display());
        assert!(done.stderr.contains(out.to_str().unwrap()), "{done:?}");
    }
    assert_eq!(names(home.path()), ["broken", "file"]);
}
