//! What a table is made of.

use std::borrow::Cow;
use std::io;

use bytes::Bytes;

/// What the cells of a column hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// UTF-8.
    Text,
    /// Whole numbers of 64 bits.
    Whole,
    /// Floating-point numbers of 64 bits.
    Real,
    /// True or false.
    Truth,
}

/// A column.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    /// Its name.
    pub name: Cow<'static, str>,
    /// What its cells hold.
    pub kind: Kind,
}

impl Column {
    /// A column of this name and kind.
    pub fn new(name: impl Into<Cow<'static, str>>, kind: Kind) -> Self {
        Self {
            name: name.into(),
            kind,
        }
    }
}

/// A cell. Cheap to clone.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// There is no value.
    Nothing,
    /// UTF-8.
    Text(Bytes),
    /// A whole number.
    Whole(i64),
    /// Any other number.
    Real(f64),
    /// True or false.
    Truth(bool),
}

impl Cell {
    /// A text.
    pub fn text(text: &str) -> Self {
        Self::Text(Bytes::copy_from_slice(text.as_bytes()))
    }

    /// A count. None is so large that it would not fit.
    pub fn count(count: impl Into<u64>) -> Self {
        Self::Whole(i64::try_from(count.into()).unwrap_or(i64::MAX))
    }
}

impl<T: Into<Cell>> From<Option<T>> for Cell {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::Nothing, Into::into)
    }
}

impl From<f64> for Cell {
    fn from(value: f64) -> Self {
        Self::Real(value)
    }
}

impl From<u32> for Cell {
    fn from(value: u32) -> Self {
        Self::Whole(value.into())
    }
}

impl From<u64> for Cell {
    fn from(value: u64) -> Self {
        Self::count(value)
    }
}

impl From<bool> for Cell {
    fn from(value: bool) -> Self {
        Self::Truth(value)
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::text(text)
    }
}

/// The cell of a number that may be missing or not finite.
pub fn real(value: Option<f64>) -> Cell {
    value.filter(|value| value.is_finite()).into()
}

/// Where the rows of a table go.
pub trait Rows {
    /// Adds a row: a cell a column, of the column's kind or nothing.
    ///
    /// # Errors
    /// When it cannot be written.
    fn add(&mut self, row: &[Cell]) -> io::Result<()>;

    /// Ends the table.
    ///
    /// # Errors
    /// When the rest cannot be written.
    fn end(self: Box<Self>) -> io::Result<()>;
}
