//! The coverage picture: squares by visits, walls, start poses, axes in metres and a legend.

use arenas::Arena;
use swarm::run::counts_within;

use super::palette::{self, BLACK, Colour, GREY, HATCH, START, STEPS, UNREACHABLE, WHITE};
use super::pushed::{self, Pushed};
use super::scene::{Anchor, Item, Scene};
use super::tables::coverage_counts;

/// Pixels of the arena's longer side.
const PLOT_PX: f64 = 800.0;
/// The arena's shorter side is never drawn smaller than the legend needs.
const MIN_HEIGHT_PX: f32 = 520.0;
const LEFT_PX: f32 = 74.0;
const TOP_PX: f32 = 64.0;
const BOTTOM_PX: f32 = 66.0;
const LEGEND_PX: f32 = 286.0;
const GAP_PX: f32 = 28.0;

/// Lays the picture out. `visits` and `reachable` hold a value for each square, row 0 lowest y.
pub fn coverage(
    arena: &Arena,
    visits: &[u32],
    reachable: Option<&[bool]>,
    objects: &[Pushed],
) -> Scene {
    let plot = Plot::of(arena);
    let mut items = Vec::new();
    title(&mut items, arena);
    squares(&mut items, &plot, visits, reachable);
    walls(&mut items, &plot, arena);
    pushed::draw(&mut items, objects, |x_m, y_m| plot.at(x_m, y_m));
    starts(&mut items, &plot, arena);
    axes(&mut items, &plot, arena);
    legend(&mut items, &plot, visits, reachable, !objects.is_empty());
    Scene {
        width_px: (LEFT_PX + plot.width_px + GAP_PX + LEGEND_PX) as u32,
        height_px: (TOP_PX + plot.height_px.max(MIN_HEIGHT_PX) + BOTTOM_PX) as u32,
        items,
    }
}

/// Where the arena is drawn.
struct Plot {
    px_per_m: f64,
    width_px: f32,
    height_px: f32,
    columns: usize,
    rows: usize,
}

impl Plot {
    fn of(arena: &Arena) -> Self {
        let px_per_m = PLOT_PX / arena.width_m().max(arena.height_m());
        let side = |side_m: f64| (side_m * px_per_m).round().max(1.0) as f32;
        Self {
            px_per_m,
            width_px: side(arena.width_m()),
            height_px: side(arena.height_m()),
            columns: arena.squares()[0] as usize,
            rows: arena.squares()[1] as usize,
        }
    }

    fn at(&self, x_m: f64, y_m: f64) -> [f32; 2] {
        let x = (x_m * self.px_per_m) as f32;
        let y = (y_m * self.px_per_m) as f32;
        [LEFT_PX + x, TOP_PX + self.height_px - y]
    }

    /// Whole pixel at which a column begins, from the left.
    fn column_px(&self, column: usize) -> f32 {
        LEFT_PX + (self.width_px * column as f32 / self.columns as f32).round()
    }

    /// Whole pixel at which a row begins, from the bottom up.
    fn row_px(&self, row: usize) -> f32 {
        TOP_PX + self.height_px - (self.height_px * row as f32 / self.rows as f32).round()
    }
}

fn text(
    items: &mut Vec<Item>,
    text: impl Into<String>,
    at: [f32; 2],
    style: (f32, bool, Anchor, Colour),
) {
    let (size_px, bold, anchor, colour) = style;
    items.push(Item::Text {
        text: text.into(),
        at,
        size_px,
        bold,
        anchor,
        colour,
    });
}

fn title(items: &mut Vec<Item>, arena: &Arena) {
    text(
        items,
        format!("Coverage of {}", arena.name()),
        [LEFT_PX, 30.0],
        (20.0, true, Anchor::Start, BLACK),
    );
    let [columns, rows] = arena.squares();
    let (width_m, height_m) = (arena.width_m(), arena.height_m());
    let about =
        format!("entries counted in {columns} x {rows} squares; {width_m} m x {height_m} m");
    text(
        items,
        about,
        [LEFT_PX, 51.0],
        (13.0, false, Anchor::Start, GREY),
    );
}

/// Fills squares, neighbours of a row that look alike as one rectangle.
fn squares(items: &mut Vec<Item>, plot: &Plot, visits: &[u32], reachable: Option<&[bool]>) {
    let mut stepped: [Vec<[f32; 4]>; STEPS.len()] = Default::default();
    let mut blocked = Vec::new();
    let mut hatch = Vec::new();
    for (row, counts) in visits.chunks(plot.columns.max(1)).enumerate() {
        let look = |column: usize| {
            let blocked = reachable.is_some_and(|mask| !mask[row * plot.columns + column]);
            (palette::step(counts[column]), blocked)
        };
        let (top, bottom) = (plot.row_px(row + 1), plot.row_px(row));
        let mut from = 0;
        while from < counts.len() {
            let here = look(from);
            let to = (from..counts.len())
                .find(|&column| look(column) != here)
                .unwrap_or(counts.len());
            let (left, right) = (plot.column_px(from), plot.column_px(to));
            let rectangle = [left, top, right - left, bottom - top];
            match here {
                (Some(step), _) => stepped[step].push(rectangle),
                (None, true) => {
                    blocked.push(rectangle);
                    hatch.extend((from..to).map(|column| {
                        [
                            plot.column_px(column),
                            bottom,
                            plot.column_px(column + 1),
                            top,
                        ]
                    }));
                }
                (None, false) => {}
            }
            from = to;
        }
    }
    items.push(Item::Rectangles {
        rectangles: blocked,
        colour: UNREACHABLE,
    });
    items.push(Item::Lines {
        lines: hatch,
        width_px: 1.0,
        colour: HATCH,
    });
    for (step, rectangles) in STEPS.iter().zip(stepped) {
        items.push(Item::Rectangles {
            rectangles,
            colour: step.colour,
        });
    }
}

/// Black on a thin white edge, so that walls stand out from dark squares too.
fn walls(items: &mut Vec<Item>, plot: &Plot, arena: &Arena) {
    let (upright, slanted): (Vec<[f32; 4]>, Vec<[f32; 4]>) = arena
        .walls()
        .iter()
        .chain(&arena.boundary())
        .map(|wall| {
            let ([x1, y1], [x2, y2]) = (plot.at(wall.a.x, wall.a.y), plot.at(wall.b.x, wall.b.y));
            [x1, y1, x2, y2]
        })
        .partition(|[x1, y1, x2, y2]| x1 == x2 || y1 == y2);
    for (width_px, colour) in [(5.0, WHITE), (3.0, BLACK)] {
        // Rectangles are drawn far quicker than lines.
        let rectangle = |[x1, y1, x2, y2]: &[f32; 4]| {
            [
                x1.min(*x2) - width_px / 2.0,
                y1.min(*y2) - width_px / 2.0,
                (x2 - x1).abs() + width_px,
                (y2 - y1).abs() + width_px,
            ]
        };
        items.push(Item::Rectangles {
            rectangles: upright.iter().map(rectangle).collect(),
            colour,
        });
        items.push(Item::Lines {
            lines: slanted.clone(),
            width_px,
            colour,
        });
    }
}

fn starts(items: &mut Vec<Item>, plot: &Plot, arena: &Arena) {
    for start in arena.starts() {
        let heading = [
            libm::cos(start.heading_rad) as f32,
            libm::sin(start.heading_rad) as f32,
        ];
        start_mark(items, plot.at(start.x_m, start.y_m), heading);
    }
}

/// A disc with a line in the direction of the heading.
fn start_mark(items: &mut Vec<Item>, centre: [f32; 2], [cos, sin]: [f32; 2]) {
    let [x, y] = centre;
    let nose = vec![[x, y, x + 16.0 * cos, y - 16.0 * sin]];
    items.push(Item::Lines {
        lines: nose.clone(),
        width_px: 5.0,
        colour: WHITE,
    });
    items.push(Item::Lines {
        lines: nose,
        width_px: 3.0,
        colour: START,
    });
    items.push(Item::Disc {
        centre,
        radius_px: 7.0,
        colour: START,
    });
}

fn axes(items: &mut Vec<Item>, plot: &Plot, arena: &Arena) {
    let style = |anchor| (13.0, false, anchor, BLACK);
    let bottom = TOP_PX + plot.height_px;
    let step_m = tick_m(arena.width_m().max(arena.height_m()));
    let decimals = if step_m < 0.1 {
        2
    } else {
        usize::from(step_m < 1.0)
    };
    // The small addition keeps a tick that rounding puts just beyond the side.
    let ticks = |side_m: f64| 0..=((side_m / step_m + 1e-9) as u32);
    let mut lines = Vec::new();
    for tick in ticks(arena.width_m()) {
        let x_m = f64::from(tick) * step_m;
        let [x, _] = plot.at(x_m, 0.0);
        lines.push([x, bottom + 4.0, x, bottom + 9.0]);
        text(
            items,
            format!("{x_m:.decimals$}"),
            [x, bottom + 25.0],
            style(Anchor::Middle),
        );
    }
    for tick in ticks(arena.height_m()) {
        let y_m = f64::from(tick) * step_m;
        let [_, y] = plot.at(0.0, y_m);
        lines.push([LEFT_PX - 9.0, y, LEFT_PX - 4.0, y]);
        text(
            items,
            format!("{y_m:.decimals$}"),
            [LEFT_PX - 14.0, y + 4.5],
            style(Anchor::End),
        );
    }
    items.push(Item::Lines {
        lines,
        width_px: 1.5,
        colour: BLACK,
    });
    let middle = LEFT_PX + plot.width_px / 2.0;
    text(
        items,
        "x (m)",
        [middle, bottom + 48.0],
        style(Anchor::Middle),
    );
    text(
        items,
        "y (m)",
        [LEFT_PX - 14.0, TOP_PX - 12.0],
        style(Anchor::End),
    );
}

/// Distance between ticks: 1, 2 or 5 times a power of ten, at most ten ticks a side.
fn tick_m(side_m: f64) -> f64 {
    let mut power_m = 1e-3;
    loop {
        for step_m in [power_m, 2.0 * power_m, 5.0 * power_m] {
            if side_m / step_m <= 10.0 {
                return step_m;
            }
        }
        power_m *= 10.0;
    }
}

fn legend(
    items: &mut Vec<Item>,
    plot: &Plot,
    visits: &[u32],
    reachable: Option<&[bool]>,
    has_objects: bool,
) {
    let left = LEFT_PX + plot.width_px + GAP_PX;
    let line_px = 30.0;
    let mut y = TOP_PX + 14.0;
    let heading = (14.0, true, Anchor::Start, BLACK);
    let plain = (14.0, false, Anchor::Start, BLACK);
    let number = (14.0, false, Anchor::End, BLACK);
    let swatch = |items: &mut Vec<Item>, y: f32, colour| {
        let edge = [left, y - 15.0, 30.0, 20.0];
        items.push(Item::Rectangles {
            rectangles: vec![edge],
            colour: GREY,
        });
        let inside = [left + 1.0, y - 14.0, 28.0, 18.0];
        items.push(Item::Rectangles {
            rectangles: vec![inside],
            colour,
        });
    };

    text(items, "Visits of a square", [left, y], heading);
    y += line_px;
    for step in STEPS.iter().rev() {
        swatch(items, y, step.colour);
        text(items, step.label, [left + 42.0, y], plain);
        y += line_px;
    }
    swatch(items, y, WHITE);
    text(items, "none", [left + 42.0, y], plain);
    y += line_px;
    if reachable.is_some() {
        swatch(items, y, UNREACHABLE);
        let stroke = |x: f32| [left + x, y + 3.0, left + x + 10.0, y - 13.0];
        let lines = vec![stroke(2.0), stroke(10.0), stroke(18.0)];
        items.push(Item::Lines {
            lines,
            width_px: 1.0,
            colour: HATCH,
        });
        text(items, "not reachable", [left + 42.0, y], plain);
        y += line_px;
    }
    start_mark(items, [left + 10.0, y - 5.0], [1.0, 0.0]);
    text(items, "start, with heading", [left + 42.0, y], plain);
    if has_objects {
        y += line_px;
        pushed::draw_now_mark(items, [left, y]);
        text(items, "movable object", [left + 42.0, y], plain);
        y += line_px;
        pushed::draw_start_mark(items, [left, y]);
        text(items, "its start and way", [left + 42.0, y], plain);
    }

    y += 1.6 * line_px;
    text(items, "Squares entered", [left, y], heading);
    let total = reachable.map(|mask| mask.iter().filter(|&&reached| reached).count());
    let inside = reachable.map_or([0; STEPS.len()], |mask| counts_within(visits, mask));
    for ((step, count), inside) in STEPS.iter().zip(coverage_counts(visits)).zip(inside) {
        y += line_px;
        let from = step.from;
        let times = if from == 1 {
            "1 time or more".to_owned()
        } else {
            format!("{from} times or more")
        };
        text(
            items,
            format!("p{from}"),
            [left, y],
            (14.0, true, Anchor::Start, BLACK),
        );
        text(
            items,
            times,
            [left + 42.0, y],
            (13.0, false, Anchor::Start, GREY),
        );
        text(items, count.to_string(), [left + 200.0, y], number);
        if let Some(total) = total.filter(|&total| total > 0) {
            let percent = 100.0 * f64::from(inside) / total as f64;
            text(
                items,
                format!("{percent:.1} %"),
                [left + 262.0, y],
                (13.0, false, Anchor::End, GREY),
            );
        }
    }
    if let Some(total) = total {
        y += line_px;
        text(
            items,
            "reachable",
            [left + 42.0, y],
            (13.0, false, Anchor::Start, GREY),
        );
        text(items, total.to_string(), [left + 200.0, y], number);
    }
}
