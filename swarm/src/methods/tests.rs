//! Tests of the list of methods.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use super::*;
use crate::spec::ControllerParameters;

#[test]
fn every_method_has_its_own_definition() {
    for &method in Method::ALL {
        let definition = method.definition();
        assert_eq!(definition.method, method);
        let walks = Walkers::robot_bytes_for(method) > 0;
        assert_eq!(
            walks,
            definition.explores == Explores::Walking,
            "{method:?}"
        );
        // Its own parameters stand beside those in common.
        let own = (definition.parameters)();
        assert_eq!(own.table().len(), own.shown().len());
        for (parameter, (name, _)) in own.table().iter().zip(own.shown()) {
            assert_eq!(parameter.name, *name);
            let mut common = ControllerParameters::TABLE.iter();
            assert!(common.all(|common| common.name != *name) && *name != "train");
        }
    }
}

/// The lines of the table in `docs/methods.md`.
fn documented() -> String {
    let mut lines = String::from(
        "| Method | What it does | Source | Trains elsewhere | Shares | Its own parameters |\n\
         |---|---|---|---|---|---|\n",
    );
    for &method in Method::ALL {
        let Definition {
            about,
            source,
            trains,
            explores,
            parameters,
            ..
        } = method.definition();
        let own: Vec<String> = parameters()
            .table()
            .iter()
            .map(|parameter| format!("`{}`", parameter.name))
            .collect();
        let (trains, shares, own) = (trains.words(), explores.shares(), own.join(", "));
        let name = method.name();
        lines.push_str(&format!(
            "| `{name}` | {about} | {source} | {trains} | {shares} | {own} |\n"
        ));
    }
    lines
}

/// With `EVSWARM_WRITE_DOCS` set, the table is written anew first.
#[test]
fn the_table_in_the_documentation_is_this_one() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/methods.md");
    let text = std::fs::read_to_string(path).unwrap();
    let table = &text[text.find("| Method |").unwrap()..];
    let table = &table[..table.find("\n\n").unwrap() + 1];
    if std::env::var_os("EVSWARM_WRITE_DOCS").is_some() {
        std::fs::write(path, text.replacen(table, &documented(), 1)).unwrap();
        return;
    }
    assert!(
        table == documented(),
        "docs/methods.md has another table of methods: write it anew with \
         EVSWARM_WRITE_DOCS=1 cargo test --release -p swarm methods"
    );
}
