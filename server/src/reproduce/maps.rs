//! Maps of an arena, one a method: how often one run entered each square, or how many runs did.

#![allow(
    clippy::let_underscore_must_use,
    reason = "writing to a string cannot fail"
)]

use std::fmt::Write;

use arenas::Arena;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::document::escaped;
use crate::artifacts;

/// One method's map.
pub struct Map {
    pub title: String,
    /// Entries of one run, or runs that entered each square; row 0 the lowest y.
    pub entered: Vec<u32>,
}

/// What the maps of a figure count.
#[derive(Clone, Copy)]
pub enum Counted {
    /// Entries of one run, in the steps of p1, p2, p5 and p10.
    Entries,
    /// Runs that entered a square, of so many.
    Runs(u32),
}

/// Maps beside each other.
const COLUMNS: usize = 5;
/// Longer side of a map.
const SIDE: f64 = 142.0;
const GAP: f64 = 10.0;
const TITLE: f64 = 18.0;
const LEGEND: f64 = 40.0;

const UNREACHABLE: [u8; 3] = [225, 225, 225];
const NEVER: [u8; 3] = [255, 255, 255];
/// Viridis, turned round: light for few runs, dark for all.
const SCALE: [[u8; 3]; 5] = [
    [253, 231, 37],
    [94, 201, 98],
    [33, 145, 140],
    [59, 82, 139],
    [68, 1, 84],
];

/// Draws the maps of one arena with a legend. `reachable` holds a value for each square.
pub fn svg(arena: &Arena, reachable: &[bool], maps: &[Map], counted: Counted) -> String {
    let per_m = SIDE / arena.width_m().max(arena.height_m());
    let (width, height) = (arena.width_m() * per_m, arena.height_m() * per_m);
    let rows = maps.len().div_ceil(COLUMNS);
    let whole_width = COLUMNS as f64 * (width + GAP);
    let whole_height = rows as f64 * (height + TITLE + GAP) + LEGEND;
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {whole_width:.1} \
         {whole_height:.1}\" width=\"{whole_width:.1}\" height=\"{whole_height:.1}\" \
         font-family=\"Helvetica,Arial,sans-serif\" font-size=\"11\">\n"
    );
    let walls = walls(arena, per_m, height);
    for (place, map) in maps.iter().enumerate() {
        let left = (place % COLUMNS) as f64 * (width + GAP) + 0.5 * GAP;
        let top = (place / COLUMNS) as f64 * (height + TITLE + GAP) + TITLE;
        let picture = STANDARD.encode(png(map, reachable, arena.squares(), counted));
        // Writing to a string cannot fail.
        let _ = writeln!(
            out,
            "<g transform=\"translate({left:.1} {top:.1})\"><text y=\"-5\">{}</text>\
             <image width=\"{width:.1}\" height=\"{height:.1}\" preserveAspectRatio=\"none\" \
             style=\"image-rendering:pixelated\" href=\"data:image/png;base64,{picture}\"/>\
             {walls}</g>",
            escaped(&map.title)
        );
    }
    legend(&mut out, whole_height - LEGEND + 14.0, counted);
    out.push_str("</svg>\n");
    out
}

/// Walls and rim as one path.
fn walls(arena: &Arena, per_m: f64, height: f64) -> String {
    let mut path = String::new();
    for wall in arena.walls().iter().chain(&arena.boundary()) {
        let _ = write!(
            path,
            "M{:.1} {:.1}L{:.1} {:.1}",
            wall.a.x * per_m,
            height - wall.a.y * per_m,
            wall.b.x * per_m,
            height - wall.b.y * per_m
        );
    }
    format!("<path fill=\"none\" stroke=\"#111\" stroke-width=\"1.2\" d=\"{path}\"/>")
}

fn legend(out: &mut String, top: f64, counted: Counted) {
    const STEPS: u32 = 40;
    let swatch = |out: &mut String, x: f64, width: f64, [red, green, blue]: [u8; 3]| {
        let _ = write!(
            out,
            "<rect x=\"{x:.1}\" y=\"{top:.1}\" width=\"{width:.1}\" height=\"11\" \
             fill=\"rgb({red},{green},{blue})\"/>"
        );
    };
    let label = |out: &mut String, x: f64, text: &str| {
        let y = top + 10.0;
        let _ = write!(out, "<text x=\"{x:.1}\" y=\"{y:.1}\">{text}</text>");
    };
    match counted {
        Counted::Runs(_) => {
            label(out, 5.0, "entered in: one run");
            for step in 0..STEPS {
                let x = 124.0 + 4.0 * f64::from(step);
                swatch(out, x, 4.2, shade(f64::from(step) / f64::from(STEPS - 1)));
            }
            label(out, 292.0, "all runs");
        }
        Counted::Entries => {
            label(out, 5.0, "entered:");
            for (place, text) in ["once", "2 to 4", "5 to 9", "10 or more times"]
                .into_iter()
                .enumerate()
            {
                let x = 60.0 + 66.0 * place as f64;
                swatch(out, x, 14.0, shade(place as f64 / 3.0));
                label(out, x + 18.0, text);
            }
        }
    }
    swatch(out, 372.0, 18.0, UNREACHABLE);
    label(out, 396.0, "never, and not reachable; white: never");
    out.push('\n');
}

/// One pixel a square, the highest y at the top.
fn png(map: &Map, reachable: &[bool], [columns, rows]: [u32; 2], counted: Counted) -> Vec<u8> {
    let across = columns.max(1) as usize;
    let mut rgb = Vec::with_capacity(3 * map.entered.len());
    let lines = map.entered.chunks(across).zip(reachable.chunks(across));
    for (entered, reachable) in lines.rev() {
        for (&entered, &reachable) in entered.iter().zip(reachable) {
            rgb.extend(match (entered, reachable) {
                (0, true) => NEVER,
                (0, false) => UNREACHABLE,
                _ => shade(share(entered, counted)),
            });
        }
    }
    artifacts::png_of_rgb(&rgb, columns, rows)
}

/// Where on the scale, 0 to 1, a count of at least one is.
fn share(count: u32, counted: Counted) -> f64 {
    match counted {
        Counted::Entries => match count {
            0 | 1 => 0.0,
            2..5 => 1.0 / 3.0,
            5..10 => 2.0 / 3.0,
            _ => 1.0,
        },
        Counted::Runs(0 | 1) => 1.0,
        Counted::Runs(of) => f64::from(count.saturating_sub(1)) / f64::from(of - 1),
    }
}

/// The colour at a place of the scale, 0 to 1.
fn shade(share: f64) -> [u8; 3] {
    let last = (SCALE.len() - 1) as f64;
    let place = (share * last).clamp(0.0, last);
    let from = (place as usize).min(SCALE.len() - 2);
    let part = place - from as f64;
    std::array::from_fn(|channel| {
        let (low, high) = (
            f64::from(SCALE[from][channel]),
            f64::from(SCALE[from + 1][channel]),
        );
        (low + part * (high - low)).round() as u8
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    #[test]
    fn shades_go_from_one_run_to_all() {
        let of = |runs, all| shade(share(runs, Counted::Runs(all)));
        assert_eq!(of(1, 15), SCALE[0]);
        assert_eq!(of(8, 15), SCALE[2]);
        assert_eq!(of(15, 15), SCALE[4]);
        assert_eq!(of(1, 1), SCALE[4]);
    }

    #[test]
    fn entries_are_shown_in_the_steps_of_the_tables() {
        let of = |entries| share(entries, Counted::Entries);
        assert!(of(1) < of(2) && of(4) < of(5) && of(9) < of(10));
        assert_eq!((of(2), of(5), of(10)), (of(4), of(9), of(5_000)));
    }

    #[test]
    fn a_map_is_one_pixel_a_square_with_the_highest_row_first() {
        let map = Map {
            title: "im".to_owned(),
            entered: vec![3, 0, 0, 1],
        };
        let bytes = png(&map, &[true, true, false, true], [2, 2], Counted::Runs(3));
        let mut reader = png::Decoder::new(std::io::Cursor::new(bytes))
            .read_info()
            .unwrap();
        let mut rgb = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut rgb).unwrap();
        assert_eq!(rgb, [UNREACHABLE, SCALE[0], SCALE[4], NEVER].concat());
    }

    #[test]
    fn maps_stand_side_by_side_with_walls() {
        let arena = arenas::builtin("maze").unwrap();
        let map = |title: &str| Map {
            title: title.to_owned(),
            entered: vec![1; 10_000],
        };
        let maps = [map("im"), map("ev-iter-c")];
        let svg = svg(&arena, &[true; 10_000], &maps, Counted::Entries);
        assert_eq!(svg.matches("<image").count(), 2);
        assert!(svg.contains(">im<") && svg.contains("data:image/png;base64,iVBOR"));
    }
}
