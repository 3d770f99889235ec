//! A moment of a recording as text: the arena in characters, robots as arrows.

#![allow(
    clippy::let_underscore_must_use,
    reason = "writing to a string cannot fail"
)]

use std::fmt::Write;

use recording::{Header, Samples};
use serde_json::Value;

/// Robots by heading, from right on against the clock.
const ARROWS: [char; 8] = ['→', '↗', '↑', '↖', '←', '↙', '↓', '↘'];
/// Characters are about twice as high as they are wide.
const ASPECT: f64 = 2.0;
const MOST_ROWS: usize = 200;

/// An arena in characters.
pub struct View {
    columns: usize,
    rows: usize,
    width_m: f64,
    height_m: f64,
    empty: Vec<char>,
}

impl View {
    /// An arena, so many characters wide.
    pub fn new(arena: &Value, columns: usize) -> Self {
        let side = |name: &str| arena[name].as_f64().unwrap_or(1.0).max(1e-6);
        let (width_m, height_m) = (side("width_m"), side("height_m"));
        let columns = columns.clamp(10, 400);
        let rows = (columns as f64 * height_m / width_m / ASPECT).round() as usize;
        let rows = rows.clamp(3, MOST_ROWS);
        let mut view = Self {
            columns,
            rows,
            width_m,
            height_m,
            empty: vec![' '; columns * rows],
        };
        for wall in arena["walls_m"].as_array().into_iter().flatten() {
            let at = |place: usize| wall[place].as_f64().unwrap_or(0.0);
            view.line([at(0), at(1)], [at(2), at(3)]);
        }
        view
    }

    fn cell(&self, x_m: f64, y_m: f64) -> usize {
        let place = |value: f64, whole: f64, cells: usize| {
            ((value / whole * cells as f64).max(0.0) as usize).min(cells - 1)
        };
        let column = place(x_m, self.width_m, self.columns);
        let row = self.rows - 1 - place(y_m, self.height_m, self.rows);
        row * self.columns + column
    }

    fn line(&mut self, from: [f64; 2], to: [f64; 2]) {
        let steps = 2 * (self.columns + self.rows);
        for step in 0..=steps {
            let share = step as f64 / steps as f64;
            let at = |axis: usize| from[axis] + share * (to[axis] - from[axis]);
            let cell = self.cell(at(0), at(1));
            self.empty[cell] = '#';
        }
    }

    /// The arena with everything in it.
    pub fn show(&self, header: &Header, block: &Samples, at: usize) -> String {
        let mut cells = self.empty.clone();
        for object in 0..block.objects {
            let [x_m, y_m, _] = block.object_pose(object, at);
            cells[self.cell(x_m, y_m)] = 'o';
        }
        if header.fields.pose {
            for row in 0..block.rows {
                let [x_m, y_m, heading_rad] = block.pose(row, at);
                let eighths = (heading_rad / std::f64::consts::FRAC_PI_4).round() as i64;
                cells[self.cell(x_m, y_m)] = ARROWS[eighths.rem_euclid(8) as usize];
            }
        }
        let edge = format!("+{}+\n", "-".repeat(self.columns));
        let mut text = edge.clone();
        for row in cells.chunks(self.columns) {
            text.push('|');
            text.extend(row);
            text.push_str("|\n");
        }
        text.push_str(&edge);
        text
    }
}

/// The robots of a moment, a line each, so many at most.
pub fn lines(header: &Header, block: &Samples, at: usize, most: usize) -> String {
    let mut text = String::new();
    for row in 0..block.rows.min(most) {
        let _ = write!(text, "robot {}", header.robots.number(row));
        if header.fields.pose {
            let [x_m, y_m, heading_rad] = block.pose(row, at);
            let _ = write!(
                text,
                "  at ({x_m:.4}, {y_m:.4}) m, heading {heading_rad:.3} rad"
            );
        }
        if header.fields.command {
            let [left, right] = block.command(row, at);
            let _ = write!(text, "  wheels {left:+.3} {right:+.3}");
        }
        if header.fields.decision {
            let decision = block.decision(row, at);
            if let (Some(state), Some(action)) = (decision.state, decision.action) {
                let _ = write!(text, "  state {state}, action {action}");
            }
        }
        if header.fields.sensors {
            let _ = write!(text, "  sensors {:?}", block.sensors(row, at));
        }
        text.push('\n');
    }
    if block.rows > most {
        let _ = writeln!(text, "and {} robots more", block.rows - most);
    }
    text
}
