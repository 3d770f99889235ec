//! What is measured of a swarm: one table of name, unit, formula and where each metric shows. JSON,
//! CSV, the measures of a summary and the table in `docs/metrics.md` all follow from it.

mod counted;
mod metric;
mod table;
mod values;

pub use counted::Counted;
pub use metric::{Metric, Shown, Source, Value};
pub use table::{METRICS, time_to_cover};
pub use values::{RowValues, at_end, over_time, pooled};
