//! The thesis's own figures, to stand beside ours.

use serde::Deserialize;

/// `published.json`.
#[derive(Debug, Deserialize)]
pub struct Published {
    /// Where the figures stand.
    pub source: String,
    /// Which rows are missing and why.
    pub left_out: String,
    /// What a figure's three numbers are.
    pub columns: String,
    rows: Vec<Row>,
}

#[derive(Debug, Deserialize)]
struct Row {
    arena: String,
    method: String,
    p1: Figure,
    p2: Figure,
    p5: Figure,
    p10: Figure,
}

/// Mean, standard deviation and median, squares.
pub type Figure = [u32; 3];

/// The embedded figures.
pub fn published() -> Published {
    #[allow(
        clippy::expect_used,
        reason = "the file is part of the program, and a test reads it"
    )]
    serde_json::from_str(include_str!("published.json")).expect("published.json can be read")
}

impl Published {
    /// p1, p2, p5 and p10 of a method on an arena, where they were published.
    pub fn row(&self, arena: &str, method: &str) -> Option<[Figure; 4]> {
        self.rows
            .iter()
            .find(|row| row.arena == arena && row.method == method)
            .map(|row| [row.p1, row.p2, row.p5, row.p10])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_file_holds_the_rows_of_the_thesis() {
        let published = published();
        assert_eq!(published.rows.len(), 25);
        let row = published.row("maze", "ev-iter-c");
        assert_eq!(row.map(|row| row[0]), Some([3341, 254, 3402]));
        assert!(published.row("easy", "discovery-a").is_none());
        for Row {
            p1, p2, p5, p10, ..
        } in &published.rows
        {
            assert!(p1[0] > p2[0] && p2[0] > p5[0] && p5[0] > p10[0]);
        }
    }
}
