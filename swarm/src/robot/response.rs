//! Infra-red response: distance to mean value and relative standard deviation, linear between rows.

use serde::{Deserialize, Serialize};

/// Largest number of rows of a response table.
pub const MAX_ROWS: usize = 16;

/// One row of a response table.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ResponseRow {
    /// Distance from the sensor.
    pub distance_m: f64,
    /// Mean raw value.
    pub value: f64,
    /// Standard deviation relative to the value.
    pub relative_sd: f64,
}

/// A response table: strictly increasing distances, first at 0. Past the last row that row holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SensorResponse {
    rows: Vec<ResponseRow>,
}

const fn row(distance_m: f64, value: f64, relative_sd: f64) -> ResponseRow {
    ResponseRow {
        distance_m,
        value,
        relative_sd,
    }
}

impl SensorResponse {
    /// A table from its rows.
    ///
    /// # Errors
    /// Says what is wrong when there are fewer than 2 or more than 16 rows, when distances do not
    /// start at 0 or do not increase, or when a figure is negative or not finite.
    pub fn new(rows: Vec<ResponseRow>) -> Result<Self, String> {
        if rows.len() < 2 || rows.len() > MAX_ROWS {
            return Err(format!(
                "a response has 2 to {MAX_ROWS} rows, not {}",
                rows.len()
            ));
        }
        if rows[0].distance_m != 0.0 {
            return Err("the first row must be at distance 0".into());
        }
        for pair in rows.windows(2) {
            if pair[1].distance_m.partial_cmp(&pair[0].distance_m)
                != Some(std::cmp::Ordering::Greater)
            {
                return Err("distances must increase from row to row".into());
            }
        }
        if rows.iter().any(|r| {
            !(r.distance_m.is_finite() && r.value.is_finite() && r.relative_sd.is_finite())
                || r.value < 0.0
                || r.relative_sd < 0.0
                || r.distance_m > 10.0
        }) {
            return Err("figures must be finite, not negative, and distances at most 10 m".into());
        }
        Ok(Self { rows })
    }

    /// Webots 7 to R2019, the thesis's.
    pub fn thesis() -> Self {
        Self {
            rows: vec![
                row(0.000, 4095.0, 0.005),
                row(0.005, 3474.0, 0.037),
                row(0.010, 2211.0, 0.071),
                row(0.020, 676.0, 0.105),
                row(0.030, 306.0, 0.125),
                row(0.040, 164.0, 0.206),
                row(0.050, 90.0, 0.269),
                row(0.060, 56.0, 0.438),
                row(0.070, 34.0, 0.704),
            ],
        }
    }

    /// Webots from 2022 on.
    pub fn webots_2022() -> Self {
        Self {
            rows: vec![
                row(0.000, 4095.0, 0.002),
                row(0.005, 2133.33, 0.003),
                row(0.010, 1465.73, 0.007),
                row(0.015, 601.46, 0.0406667),
                row(0.020, 383.84, 0.01472),
                row(0.030, 234.93, 0.0241),
                row(0.040, 158.03, 0.0287),
                row(0.050, 120.0, 0.04225),
                row(0.060, 104.09, 0.03065),
                row(0.070, 67.19, 0.04897),
            ],
        }
    }

    /// The rows.
    pub fn rows(&self) -> &[ResponseRow] {
        &self.rows
    }

    /// Distance beyond which nothing is seen.
    pub fn range_m(&self) -> f64 {
        self.rows[self.rows.len() - 1].distance_m
    }

    /// Mean value and relative standard deviation at a distance (the scalar reference).
    pub fn at(&self, distance_m: f64) -> (f64, f64) {
        let last = self.rows[self.rows.len() - 1];
        for pair in self.rows.windows(2) {
            let (a, b) = (pair[0], pair[1]);
            if distance_m < b.distance_m {
                let f = ((distance_m - a.distance_m) / (b.distance_m - a.distance_m)).max(0.0);
                return (
                    a.value + f * (b.value - a.value),
                    a.relative_sd + f * (b.relative_sd - a.relative_sd),
                );
            }
        }
        (last.value, last.relative_sd)
    }
}
