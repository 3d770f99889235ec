//! Tables as CSV: a line of names, then a line a row; what there is not is empty.

use std::io::{self, BufWriter, Write};

use super::cell::{Cell, Column, Rows};
use super::decimal::Decimal;

/// A table on its way.
pub struct Csv<W: Write>(BufWriter<W>);

impl<W: Write> Csv<W> {
    /// Writes the names.
    pub fn begin(columns: &[Column], out: W) -> io::Result<Self> {
        let mut out = BufWriter::new(out);
        for (place, column) in columns.iter().enumerate() {
            if place > 0 {
                out.write_all(b",")?;
            }
            text(&mut out, column.name.as_bytes())?;
        }
        out.write_all(b"\n")?;
        Ok(Self(out))
    }
}

impl<W: Write> Rows for Csv<W> {
    fn add(&mut self, row: &[Cell]) -> io::Result<()> {
        let out = &mut self.0;
        for (place, cell) in row.iter().enumerate() {
            if place > 0 {
                out.write_all(b",")?;
            }
            match cell {
                Cell::Nothing => {}
                Cell::Text(bytes) => text(out, bytes)?,
                Cell::Whole(number) => write!(out, "{number}")?,
                Cell::Real(number) => write!(out, "{}", Decimal(*number))?,
                Cell::Truth(truth) => write!(out, "{truth}")?,
            }
        }
        out.write_all(b"\n")
    }

    fn end(mut self: Box<Self>) -> io::Result<()> {
        self.0.flush()
    }
}

/// A text, in quotes where it could be taken for something else.
fn text(out: &mut impl Write, text: &[u8]) -> io::Result<()> {
    if !text.iter().any(|byte| b",\"\r\n".contains(byte)) {
        return out.write_all(text);
    }
    out.write_all(b"\"")?;
    for (place, part) in text.split(|&byte| byte == b'"').enumerate() {
        if place > 0 {
            out.write_all(b"\"\"")?;
        }
        out.write_all(part)?;
    }
    out.write_all(b"\"")
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;
    use crate::tables::{Form, Kind};

    #[test]
    fn cells_are_written_so_that_they_are_read_back() {
        let columns = [
            Column::new("a", Kind::Text),
            Column::new("b,c", Kind::Whole),
            Column::new("d", Kind::Real),
            Column::new("e", Kind::Truth),
        ];
        let mut bytes = Vec::new();
        let mut rows = Form::Csv.begin(&columns, &mut bytes).unwrap();
        rows.add(&[
            Cell::text("say \"x, y\"\n"),
            Cell::Whole(-3),
            Cell::Real(2.0),
            Cell::Truth(true),
        ])
        .unwrap();
        rows.add(&[
            Cell::text("plain"),
            Cell::Nothing,
            Cell::Real(1e300),
            Cell::Nothing,
        ])
        .unwrap();
        rows.end().unwrap();
        assert_eq!(
            String::from_utf8(bytes).unwrap(),
            "a,\"b,c\",d,e\n\"say \"\"x, y\"\"\n\",-3,2.0,true\nplain,,1e300,\n"
        );
    }
}
