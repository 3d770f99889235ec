//! The first columns of every table: which run a row is of.

use crate::store::{RunState, RunView};
use crate::tables::{Cell, Column, Kind};

pub fn columns() -> impl Iterator<Item = Column> {
    [
        ("job", Kind::Text),
        ("index", Kind::Whole),
        ("run", Kind::Text),
        ("seed", Kind::Whole),
        ("method", Kind::Text),
        ("arena", Kind::Text),
        ("label", Kind::Text),
        ("state", Kind::Text),
        ("error", Kind::Text),
        ("results_version", Kind::Whole),
    ]
    .into_iter()
    .map(|(name, kind)| Column::new(name, kind))
}

pub fn cells(run: &RunView) -> Vec<Cell> {
    let error = match &run.state {
        RunState::Failed { reason } | RunState::Damaged { reason } => Some(reason.as_str()),
        _ => None,
    };
    vec![
        Cell::text(&run.job.to_string()),
        Cell::count(run.ordinal),
        Cell::text(&run.id),
        Cell::count(run.seed),
        Cell::text(&run.method),
        Cell::text(&run.arena),
        Cell::text(&run.label),
        Cell::text(run.state.state().name()),
        error.into(),
        run.results_version.into(),
    ]
}
