//! Tables as Parquet: rows are gathered into groups of bounded size, each written column by column.

use std::io::{self, Write};
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use super::cell::{Cell, Column, Kind, Rows};

/// Most cells of a group of rows: some tens of megabytes with what the writer needs besides.
const GROUP_CELLS: usize = 1 << 19;

/// A table on its way.
pub struct Parquet<W: Write + Send> {
    writer: SerializedFileWriter<W>,
    columns: Vec<Gathered>,
    rows: usize,
    group_rows: usize,
}

/// The cells of a column that are not written yet.
struct Gathered {
    /// For each row 1 where there is a value.
    present: Vec<i16>,
    values: Values,
}

enum Values {
    Text(Vec<ByteArray>),
    Whole(Vec<i64>),
    Real(Vec<f64>),
    Truth(Vec<bool>),
}

impl<W: Write + Send> Parquet<W> {
    /// Writes the head.
    pub fn begin(columns: &[Column], out: W) -> io::Result<Self> {
        let fields: Result<Vec<_>, _> = columns.iter().map(field).collect();
        let schema = Type::group_type_builder("table")
            .with_fields(fields.map_err(failed)?)
            .build()
            .map_err(failed)?;
        let properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            .set_created_by(concat!("evswarm ", env!("CARGO_PKG_VERSION")).to_owned())
            .build();
        let writer = SerializedFileWriter::new(out, Arc::new(schema), Arc::new(properties));
        Ok(Self {
            writer: writer.map_err(failed)?,
            columns: columns.iter().map(Gathered::of).collect(),
            rows: 0,
            group_rows: (GROUP_CELLS / columns.len().max(1)).max(1),
        })
    }

    fn write_group(&mut self) -> Result<(), ParquetError> {
        if self.rows == 0 {
            return Ok(());
        }
        let mut group = self.writer.next_row_group()?;
        for gathered in &mut self.columns {
            let Some(mut column) = group.next_column()? else {
                return Err(ParquetError::General("a column is missing".to_owned()));
            };
            let present = Some(&gathered.present[..]);
            match &mut gathered.values {
                Values::Text(values) => {
                    column
                        .typed::<ByteArrayType>()
                        .write_batch(values, present, None)?;
                    values.clear();
                }
                Values::Whole(values) => {
                    column
                        .typed::<Int64Type>()
                        .write_batch(values, present, None)?;
                    values.clear();
                }
                Values::Real(values) => {
                    column
                        .typed::<DoubleType>()
                        .write_batch(values, present, None)?;
                    values.clear();
                }
                Values::Truth(values) => {
                    column
                        .typed::<BoolType>()
                        .write_batch(values, present, None)?;
                    values.clear();
                }
            }
            column.close()?;
            gathered.present.clear();
        }
        group.close()?;
        self.rows = 0;
        Ok(())
    }
}

impl<W: Write + Send> Rows for Parquet<W> {
    fn add(&mut self, row: &[Cell]) -> io::Result<()> {
        for (gathered, cell) in self.columns.iter_mut().zip(row) {
            gathered.push(cell)?;
        }
        self.rows += 1;
        if self.rows == self.group_rows {
            self.write_group().map_err(failed)?;
        }
        Ok(())
    }

    fn end(mut self: Box<Self>) -> io::Result<()> {
        self.write_group().map_err(failed)?;
        self.writer.close().map_err(failed)?;
        Ok(())
    }
}

impl Gathered {
    fn of(column: &Column) -> Self {
        Self {
            present: Vec::new(),
            values: match column.kind {
                Kind::Text => Values::Text(Vec::new()),
                Kind::Whole => Values::Whole(Vec::new()),
                Kind::Real => Values::Real(Vec::new()),
                Kind::Truth => Values::Truth(Vec::new()),
            },
        }
    }

    fn push(&mut self, cell: &Cell) -> io::Result<()> {
        match (&mut self.values, cell) {
            (_, Cell::Nothing) => {}
            (Values::Text(values), Cell::Text(text)) => values.push(text.clone().into()),
            (Values::Whole(values), Cell::Whole(number)) => values.push(*number),
            (Values::Real(values), Cell::Real(number)) => values.push(*number),
            (Values::Truth(values), Cell::Truth(truth)) => values.push(*truth),
            (_, cell) => {
                let what = format!("{cell:?} is not of its column's kind");
                return Err(io::Error::new(io::ErrorKind::InvalidData, what));
            }
        }
        self.present.push((*cell != Cell::Nothing).into());
        Ok(())
    }
}

/// Every cell may be missing, so that a column has one type in every table.
fn field(column: &Column) -> Result<Arc<Type>, ParquetError> {
    let (physical, logical) = match column.kind {
        Kind::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
        Kind::Whole => (Physical::INT64, None),
        Kind::Real => (Physical::DOUBLE, None),
        Kind::Truth => (Physical::BOOLEAN, None),
    };
    Type::primitive_type_builder(&column.name, physical)
        .with_repetition(Repetition::OPTIONAL)
        .with_logical_type(logical)
        .build()
        .map(Arc::new)
}

fn failed(error: ParquetError) -> io::Error {
    match error {
        // What a writer said comes back as it was.
        ParquetError::External(error) => match error.downcast::<io::Error>() {
            Ok(error) => *error,
            Err(error) => io::Error::other(error),
        },
        error => io::Error::other(error),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use parquet::file::reader::{FileReader, SerializedFileReader};

    use super::*;
    use crate::tables::Form;

    #[test]
    fn rows_come_back_over_several_groups() {
        let columns = [
            Column::new("name", Kind::Text),
            Column::new("count", Kind::Whole),
            Column::new("share", Kind::Real),
            Column::new("is", Kind::Truth),
        ];
        let row = |number: i64| {
            let odd = number % 2 == 1;
            let or_nothing = |cell: Cell| if odd { cell } else { Cell::Nothing };
            [
                Cell::text(&format!("row {}", number % 7)),
                or_nothing(Cell::Whole(-number)),
                or_nothing(Cell::Real(number as f64 / 3.0)),
                or_nothing(Cell::Truth(number % 4 == 1)),
            ]
        };
        let mut bytes = Vec::new();
        let mut table = Form::Parquet.begin(&columns, &mut bytes).unwrap();
        let rows = (GROUP_CELLS / 4 + 5) as i64;
        for number in 0..rows {
            table.add(&row(number)).unwrap();
        }
        table.end().unwrap();
        let reader = SerializedFileReader::new(bytes::Bytes::from(bytes)).unwrap();
        let meta = reader.metadata();
        assert_eq!(
            (meta.num_row_groups(), meta.file_metadata().num_rows()),
            (2, rows)
        );
        for (number, read) in reader.get_row_iter(None).unwrap().enumerate() {
            let shown: Vec<String> = read
                .unwrap()
                .get_column_iter()
                .map(|(_, field)| field.to_string())
                .collect();
            let number = number as i64;
            assert_eq!(shown[0], format!("\"row {}\"", number % 7));
            if number % 2 == 1 {
                assert_eq!(shown[1], (-number).to_string());
                assert_eq!(shown[3], (number % 4 == 1).to_string());
            } else {
                assert_eq!(shown[1..], ["null", "null", "null"]);
            }
        }
    }

    #[test]
    fn a_cell_of_another_kind_is_an_error() {
        let columns = [Column::new("count", Kind::Whole)];
        let mut table = Form::Parquet.begin(&columns, Vec::new()).unwrap();
        assert!(table.add(&[Cell::Real(1.0)]).is_err());
    }
}
