//! A recording as a table: a row for each moment and robot.

use std::io::{self, Read, Seek, Write};

use recording::{Reader, RecordingError};

use super::slice::{epoch_of, step_of};
use crate::tables::{Cell, Column, Form, Kind};

/// Names of the sensors' columns.
const SENSORS: [&str; 8] = ["ps0", "ps1", "ps2", "ps3", "ps4", "ps5", "ps6", "ps7"];

/// Writes all that there is of a recording, in order of time, then of the robots' numbers.
///
/// # Errors
/// When it cannot be written, or the recording is damaged.
pub fn write_rows<F: Read + Seek>(
    reader: &mut Reader<F>,
    form: Form,
    out: impl Write + Send,
) -> io::Result<()> {
    let header = reader.header().clone();
    let layout = *reader.layout();
    let fields = header.fields;
    let mut columns: Vec<Column> = [
        ("step", Kind::Whole),
        ("time_s", Kind::Real),
        ("epoch", Kind::Whole),
        ("epoch_step", Kind::Whole),
        ("phase", Kind::Text),
        ("in_training", Kind::Truth),
        ("robot", Kind::Whole),
    ]
    .map(|(name, kind)| Column::new(name, kind))
    .to_vec();
    let mut more = |has: bool, names: &[&'static str], kind: Kind| {
        if has {
            columns.extend(names.iter().map(|name| Column::new(*name, kind)));
        }
    };
    more(fields.pose, &["x_m", "y_m", "heading_rad"], Kind::Real);
    more(fields.command, &["left", "right"], Kind::Real);
    more(fields.decision, &["state", "action"], Kind::Whole);
    more(fields.sensors, &SENSORS, Kind::Whole);
    let mut table = form.begin(&columns, out)?;
    let samples = reader.samples();
    let mut sample = samples.start;
    let mut cells: Vec<Cell> = Vec::with_capacity(columns.len());
    while sample < samples.end {
        let block = reader.block(sample).map_err(failed)?;
        while sample < block.first + block.count as u64 {
            let at = (sample - block.first) as usize;
            let place = layout.place(sample);
            let epoch = epoch_of(&header, place.arena_epoch);
            let step = step_of(&header, place);
            let phase = Cell::text(&epoch.phase);
            for row in 0..block.rows {
                cells.clear();
                cells.extend([
                    step.into(),
                    (step as f64 * header.step_s).into(),
                    place.arena_epoch.into(),
                    place.step.into(),
                    phase.clone(),
                    epoch.in_training.into(),
                    header.robots.number(row).into(),
                ]);
                if fields.pose {
                    cells.extend(block.pose(row, at).map(Cell::from));
                }
                if fields.command {
                    cells.extend(block.command(row, at).map(Cell::from));
                }
                if fields.decision {
                    let decision = block.decision(row, at);
                    let both = [decision.state, decision.action];
                    cells.extend(both.map(|number| Cell::from(number.map(u32::from))));
                }
                if fields.sensors {
                    let values = block.sensors(row, at);
                    cells.extend(values.map(|value| Cell::from(u32::from(value))));
                }
                table.add(&cells)?;
            }
            sample += 1;
        }
    }
    table.end()
}

/// What is wrong with a recording, to whoever reads what is made of it.
pub fn failed(error: RecordingError) -> io::Error {
    match error {
        RecordingError::Io(error) => error,
        error => io::Error::other(error),
    }
}
