//! Tables with columns of fixed names and types, written row by row as CSV or Parquet: what is held
//! of them at a time is bounded, however long they are.

mod cell;
mod csv;
mod decimal;
mod parquet;

use std::io::{self, Write};

pub use cell::{Cell, Column, Kind, Rows, real};
pub use decimal::Decimal;

/// How a table is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// Text, as RFC 4180 has it.
    Csv,
    /// Columns in groups of rows, compressed by Snappy.
    Parquet,
}

impl Form {
    /// Begins a table.
    ///
    /// # Errors
    /// When its head cannot be written.
    pub fn begin<'a>(
        self,
        columns: &[Column],
        out: impl Write + Send + 'a,
    ) -> io::Result<Box<dyn Rows + 'a>> {
        Ok(match self {
            Self::Csv => Box::new(csv::Csv::begin(columns, out)?),
            Self::Parquet => Box::new(parquet::Parquet::begin(columns, out)?),
        })
    }

    /// What it is sent as.
    pub const fn media_type(self) -> &'static str {
        match self {
            Self::Csv => "text/csv; charset=utf-8",
            Self::Parquet => "application/vnd.apache.parquet",
        }
    }

    /// End of a file's name.
    pub const fn suffix(self) -> &'static str {
        match self {
            Self::Csv => "csv",
            Self::Parquet => "parquet",
        }
    }
}
