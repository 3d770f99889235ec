//! Maps of an arena, one a method: in which share of the runs each square was entered.

use std::fmt::Write;

use arenas::Arena;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::document::escaped;

/// One method's runs.
pub struct Map {
    pub method: String,
    /// Runs that entered each square, row 0 the lowest y.
    pub entered: Vec<u32>,
    /// Runs in all.
    pub runs: u32,
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
pub fn svg(arena: &Arena, reachable: &[bool], maps: &[Map]) -> String {
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
        let picture = STANDARD.encode(png(map, reachable, arena.squares()));
        // Writing to a string cannot fail.
        let _ = writeln!(
            out,
            "<g transform=\"translate({left:.1} {top:.1})\"><text y=\"-5\">{}</text>\
             <image width=\"{width:.1}\" height=\"{height:.1}\" preserveAspectRatio=\"none\" \
             style=\"image-rendering:pixelated\" href=\"data:image/png;base64,{picture}\"/>\
             {walls}</g>",
            escaped(&map.method)
        );
    }
    legend(&mut out, whole_height - LEGEND + 14.0);
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

fn legend(out: &mut String, top: f64) {
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
    label(out, 5.0, "entered in: one run");
    for step in 0..STEPS {
        let x = 124.0 + 4.0 * f64::from(step);
        swatch(out, x, 4.2, shade(step + 1, STEPS));
    }
    label(out, 292.0, "all runs");
    swatch(out, 360.0, 18.0, UNREACHABLE);
    label(out, 384.0, "never, and not reachable; white: never");
    out.push('\n');
}

/// One pixel a square, the highest y at the top.
fn png(map: &Map, reachable: &[bool], [columns, rows]: [u32; 2]) -> Vec<u8> {
    let across = columns.max(1) as usize;
    let mut rgb = Vec::with_capacity(3 * map.entered.len());
    let lines = map.entered.chunks(across).zip(reachable.chunks(across));
    for (entered, reachable) in lines.rev() {
        for (&runs, &reachable) in entered.iter().zip(reachable) {
            rgb.extend(match (runs, reachable) {
                (0, true) => NEVER,
                (0, false) => UNREACHABLE,
                _ => shade(runs, map.runs),
            });
        }
    }
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, columns, rows);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    // Writing to memory cannot fail, and the data has the announced size.
    #[allow(clippy::expect_used)]
    encoder
        .write_header()
        .and_then(|mut writer| writer.write_image_data(&rgb))
        .expect("a picture in memory can be encoded");
    bytes
}

/// The colour of a square that so many of all runs entered, at least one.
fn shade(runs: u32, of: u32) -> [u8; 3] {
    let last = (SCALE.len() - 1) as f64;
    let share = match of {
        0 | 1 => 1.0,
        of => f64::from(runs.saturating_sub(1)) / f64::from(of - 1),
    };
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
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn shades_go_from_one_run_to_all() {
        assert_eq!(shade(1, 15), SCALE[0]);
        assert_eq!(shade(8, 15), SCALE[2]);
        assert_eq!(shade(15, 15), SCALE[4]);
        assert_eq!(shade(1, 1), SCALE[4]);
    }

    #[test]
    fn a_map_is_one_pixel_a_square_with_the_highest_row_first() {
        let map = Map {
            method: "im".to_owned(),
            entered: vec![3, 0, 0, 1],
            runs: 3,
        };
        let bytes = png(&map, &[true, true, false, true], [2, 2]);
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
        let map = |method: &str| Map {
            method: method.to_owned(),
            entered: vec![1; 10_000],
            runs: 2,
        };
        let svg = svg(&arena, &[true; 10_000], &[map("im"), map("ev-iter-c")]);
        assert_eq!(svg.matches("<image").count(), 2);
        assert!(svg.contains(">im<") && svg.contains("data:image/png;base64,iVBOR"));
    }
}
