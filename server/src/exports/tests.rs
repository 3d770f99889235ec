//! That tables have every column that specs and results have, of one type, whatever is in them.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::collections::BTreeSet;

use serde_json::{Value, json};
use swarm::spec::Method;

use super::*;
use crate::documents::{BuiltinArenas, resolve};
use crate::tables::Cell;

/// Dotted paths of the values in a document; lists are left out.
fn paths(value: &Value, before: &str, found: &mut BTreeSet<String>) {
    match value {
        Value::Object(fields) => {
            for (name, value) in fields {
                paths(value, &format!("{before}{name}."), found);
            }
        }
        Value::Array(_) => {}
        _ => drop(found.insert(before.trim_end_matches('.').to_owned())),
    }
}

fn names(table: Table) -> BTreeSet<String> {
    let columns = table.columns();
    let names: BTreeSet<String> = columns.iter().map(|c| c.name.to_string()).collect();
    assert_eq!(names.len(), columns.len(), "a name stands there twice");
    names
}

#[test]
fn every_field_of_every_spec_has_a_column() {
    let known = names(Table::Runs);
    let mut found = BTreeSet::new();
    let sharing = json!({ "mode": "radio", "range_m": 0.5, "bytes_per_step": 8 });
    let anywhere = json!({ "kind": "grid", "anywhere": true });
    for method in Method::NAMES {
        let spec = json!({ "controller": { "method": method }, "placement": anywhere });
        let run = resolve(&spec, &BuiltinArenas).unwrap();
        let shown: Value = serde_json::from_str(&run.canonical_json()).unwrap();
        paths(&shown, "", &mut found);
        // Every cell is of its column's kind, and none that the spec has is empty.
        let cells = spec::cells(Some(&run.canonical_json()));
        for (cell, column) in cells.iter().zip(spec::columns()) {
            let is_kind = match cell {
                Cell::Nothing => true,
                Cell::Text(_) => column.kind == crate::tables::Kind::Text,
                Cell::Whole(_) => column.kind == crate::tables::Kind::Whole,
                Cell::Real(_) => column.kind == crate::tables::Kind::Real,
                Cell::Truth(_) => column.kind == crate::tables::Kind::Truth,
            };
            assert!(is_kind, "{column:?}: {cell:?}");
        }
    }
    paths(&sharing, "sharing.", &mut found);
    for path in found {
        // A placement that says more is told in two columns.
        let path = path.replace("placement.kind", "placement");
        // Null where the arenas' own start stays.
        let path = if path == "start" {
            "start.x_m".to_owned()
        } else {
            path
        };
        assert!(path == "schema" || known.contains(&path), "{path}");
    }
}

#[test]
fn every_field_of_a_result_has_a_column() {
    let spec = json!({ "controller": { "method": "im" }, "epochs": 2, "steps_per_epoch": 50 });
    let run = resolve(&spec, &BuiltinArenas).unwrap();
    let mut run = swarm::run::Run::new(run.run_spec()).unwrap();
    run.advance(u64::MAX);
    let result = crate::artifacts::run_result(&run.outcome().unwrap());
    let mut found = BTreeSet::new();
    paths(&serde_json::to_value(&result).unwrap(), "", &mut found);
    let known = names(Table::Runs);
    for path in &found {
        let is_plan = path.starts_with("memory.plan.") && path != "memory.plan.bytes";
        assert!(
            is_plan || path == "schema" || known.contains(path),
            "{path}"
        );
    }
    let cells = measures::cells(Some(&result), Some(1.5));
    let empty = |cell: &&Cell| **cell == Cell::Nothing;
    // Of one robot there is no overlap, and two epochs cover too little for three times.
    let empty: Vec<_> = cells
        .iter()
        .zip(measures::columns())
        .filter(|(cell, _)| empty(cell))
        .map(|(_, column)| column.name.to_string())
        .collect();
    for name in empty {
        let last = name.trim_start_matches("metrics.");
        assert!(
            ["t50_steps", "t90_steps", "t99_steps", "overlap"].contains(&last),
            "{name}"
        );
    }
    // What a table takes of a run's metrics is what their own file has.
    let log = run.metrics();
    let csv = crate::artifacts::metrics_csv(&log, 0.064);
    let names = csv.lines().next().unwrap();
    let columns: Vec<_> = over_time::metrics_columns();
    let told: Vec<&str> = columns.iter().map(|column| &*column.name).collect();
    assert_eq!(told.join(","), names);
    assert!(metrics_of_run(&log, 0.064).unwrap().starts_with(b"PAR1"));
}

#[test]
fn the_columns_are_told_in_the_documentation() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/exports.md");
    let text = std::fs::read_to_string(path).unwrap();
    let mut right = String::new();
    for table in [Table::Runs, Table::Curves, Table::Metrics] {
        let kind = |column: &Column| match column.kind {
            crate::tables::Kind::Text => "text",
            crate::tables::Kind::Whole => "int64",
            crate::tables::Kind::Real => "float64",
            crate::tables::Kind::Truth => "boolean",
        };
        right += &format!("## `{}`\n\n| Column | Type |\n|---|---|\n", table.name());
        for column in table.columns() {
            right += &format!("| `{}` | {} |\n", column.name, kind(&column));
        }
        right += "\n";
    }
    let right = right.trim_end().to_owned() + "\n";
    let (before, told) = text.split_at(text.find("## `runs`").unwrap_or(text.len()));
    if std::env::var_os("EVSWARM_WRITE_DOCS").is_some() {
        std::fs::write(path, format!("{before}{right}")).unwrap();
        return;
    }
    assert!(
        told == right,
        "docs/exports.md has other columns: write it anew with \
         EVSWARM_WRITE_DOCS=1 cargo test --release -p server exports"
    );
}
