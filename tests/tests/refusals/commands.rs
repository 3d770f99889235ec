//! Commands that cannot do what they are asked to.

use serde_json::json;
use tests::command::evswarm;
use tests::refusals::row;
use tests::small_spec;

#[test]
fn commands_that_cannot_work_end_with_1() {
    let home = tempfile::tempdir().unwrap();
    let path = |name: &str| home.path().join(name).to_str().unwrap().to_owned();
    let spec_or_out =
        "a spec that cannot be read, or an output directory that holds something else";
    let refused = |what: &str, arguments: &[&str], input: &str, words: &str| {
        let done = evswarm(arguments, input);
        let exit = row(what).exit.map(i32::from);
        assert_eq!(done.code, exit, "{arguments:?}: {done:?}");
        assert!(done.stderr.contains(words), "{arguments:?}: {done:?}");
    };
    let failed = |arguments: &[&str], input: &str, words: &str| {
        refused(spec_or_out, arguments, input, words);
    };
    let (spec, out) = (small_spec().to_string(), path("out"));
    failed(
        &["run", &path("missing.json"), "--out", &out],
        "",
        "cannot read",
    );
    failed(&["run", &path(""), "--out", &out], "", "cannot read");
    std::fs::create_dir(path("full")).unwrap();
    std::fs::write(path("full/notes.txt"), "mine").unwrap();
    failed(&["run", "-", "--out", &path("full")], &spec, "not empty");
    assert_eq!(std::fs::read(path("full/notes.txt")).unwrap(), b"mine");
    failed(
        &["run", "-", "--out", &path("full/notes.txt")],
        &spec,
        "directory",
    );
    assert_eq!(evswarm(&["run", "-", "--out", &out], &spec).code, Some(0));
    let mut other = small_spec();
    other["seed"] = json!(2);
    failed(
        &["run", "-", "--out", &out],
        &other.to_string(),
        "another spec",
    );
    failed(&["run"], "", "--out");
    let data = path("data");
    std::fs::write(path("tokens"), "ann may read").unwrap();
    for tokens in [path("tokens"), path("missing")] {
        let unusable = "a file of tokens that cannot be used (`evswarm serve`)";
        let arguments = ["serve", "--data", &data, "--tokens", &tokens];
        refused(unusable, &arguments, "", "the tokens in");
    }
    let listen = |at: &'static str| ["serve", "--listen", at, "--data", &data].map(str::to_owned);
    for at in ["0.0.0.0:0", "[::]:0"] {
        let arguments = listen(at);
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let open = "listening beyond this machine without a token (`evswarm serve`)";
        refused(open, &arguments, "", "set a token");
    }
}
