//! Drawing of an arena for papers and the dashboard: walls, boundary, starts, name, scale bar.

#![allow(
    clippy::let_underscore_must_use,
    reason = "writing to a string cannot fail"
)]

use std::fmt::Write;

use nalgebra::Point2;

use crate::arena::Arena;
use crate::segment::Segment;

/// How to draw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SvgOptions {
    /// Longer side of the arena in the drawing, pixels; margins come on top.
    pub size_px: u32,
    /// Radius of the body drawn at each start, metres.
    pub body_radius_m: f64,
}

impl Default for SvgOptions {
    /// 640 pixels, the e-puck's radius of 0.037 m.
    fn default() -> Self {
        Self {
            size_px: 640,
            body_radius_m: 0.037,
        }
    }
}

const INK: &str = "#1a1a1a";
const QUIET: &str = "#5f6670";
const BODY_FILL: &str = "#dbe7f6";
const BODY_LINE: &str = "#2a6fbb";
const OBJECT_FILL: &str = "#f3dfc1";
const OBJECT_LINE: &str = "#a8691c";

/// A complete SVG document, white background, y up as in the arena.
pub fn render_svg(arena: &Arena, options: &SvgOptions) -> String {
    let size_px = f64::from(options.size_px);
    let px_per_m = size_px / arena.width_m().max(arena.height_m());
    let [width_px, height_px] = [arena.width_m(), arena.height_m()].map(|side_m| side_m * px_per_m);
    let text_px = (size_px / 40.0).max(9.0);
    let [side_px, top_px, bottom_px] = [1.5 * text_px, 2.5 * text_px, 3.0 * text_px];
    let line_px = (size_px / 320.0).max(1.0);
    let view = View {
        px_per_m,
        left_px: side_px,
        base_px: top_px + height_px,
    };

    let mut svg = String::new();
    let total_px = [width_px + 2.0 * side_px, top_px + height_px + bottom_px].map(round_px);
    push(
        &mut svg,
        format_args!(
            r#"<svg xmlns="http://www.w3.org/2000/svg" width="{0}" height="{1}" viewBox="0 0 {0} {1}" role="img">"#,
            total_px[0], total_px[1],
        ),
    );
    // Names have no character that XML would read as markup.
    push(&mut svg, format_args!("<title>{}</title>", arena.name()));
    push(
        &mut svg,
        format_args!(r##"<rect width="100%" height="100%" fill="#ffffff"/>"##),
    );
    push(
        &mut svg,
        format_args!(
            r#"<g font-family="sans-serif" font-size="{}" fill="{INK}">"#,
            round_px(text_px)
        ),
    );
    let baseline_px = round_px(1.7 * text_px);
    push(
        &mut svg,
        format_args!(
            r#"<text x="{}" y="{baseline_px}" font-weight="bold">{}</text>"#,
            round_px(side_px),
            arena.name(),
        ),
    );
    push(
        &mut svg,
        format_args!(
            r#"<text x="{}" y="{baseline_px}" text-anchor="end" fill="{QUIET}">{} m &#215; {} m</text>"#,
            round_px(side_px + width_px),
            arena.width_m(),
            arena.height_m(),
        ),
    );
    scale_bar(&mut svg, arena, &view, text_px, line_px);
    push(&mut svg, format_args!("</g>"));
    starts(&mut svg, arena, &view, options.body_radius_m, line_px);
    objects(&mut svg, arena, &view, line_px);
    push(
        &mut svg,
        format_args!(
            r#"<path d="{}" fill="none" stroke="{INK}" stroke-width="{}" stroke-linecap="round"/>"#,
            segments(arena.walls(), &view),
            round_px(line_px),
        ),
    );
    push(
        &mut svg,
        format_args!(
            r#"<rect x="{}" y="{}" width="{}" height="{}" fill="none" stroke="{INK}" stroke-width="{}"/>"#,
            round_px(side_px),
            round_px(top_px),
            round_px(width_px),
            round_px(height_px),
            round_px(1.5 * line_px),
        ),
    );
    push(&mut svg, format_args!("</svg>"));
    svg
}

/// From metres to pixels.
struct View {
    px_per_m: f64,
    left_px: f64,
    base_px: f64,
}

impl View {
    fn px(&self, point: Point2<f64>) -> [f64; 2] {
        [
            self.left_px + point.x * self.px_per_m,
            self.base_px - point.y * self.px_per_m,
        ]
        .map(round_px)
    }
}

fn segments(walls: &[Segment], view: &View) -> String {
    let mut path = String::new();
    for wall in walls {
        let ([x1, y1], [x2, y2]) = (view.px(wall.a), view.px(wall.b));
        // Writing to a string cannot fail.
        let _ = write!(path, "M{x1} {y1}L{x2} {y2}");
    }
    path
}

/// Movable objects, where they begin.
fn objects(svg: &mut String, arena: &Arena, view: &View, line_px: f64) {
    let mut outlines = String::new();
    for object in arena.objects() {
        let Some(corners) = object.corners() else {
            let [x, y] = view.px(object.centre());
            let radius_px = round_px(object.reach_m() * view.px_per_m);
            // Writing to a string cannot fail.
            let _ = write!(
                outlines,
                "M{} {y}a{radius_px} {radius_px} 0 1 0 {d} 0a{radius_px} {radius_px} 0 1 0 -{d} 0z",
                round_px(x - radius_px),
                d = round_px(2.0 * radius_px),
            );
            continue;
        };
        for (place, corner) in corners.iter().enumerate() {
            let [x, y] = view.px(*corner);
            let _ = write!(outlines, "{}{x} {y}", if place == 0 { 'M' } else { 'L' });
        }
        outlines.push('z');
    }
    if !outlines.is_empty() {
        push(
            svg,
            format_args!(
                r#"<path d="{outlines}" fill="{OBJECT_FILL}" stroke="{OBJECT_LINE}" stroke-width="{}"/>"#,
                round_px(line_px),
            ),
        );
    }
}

/// All bodies in one path, all arrows in another: small also with thousands of starts.
fn starts(svg: &mut String, arena: &Arena, view: &View, body_radius_m: f64, line_px: f64) {
    let radius_px = round_px(body_radius_m * view.px_per_m);
    let (mut bodies, mut arrows) = (String::new(), String::new());
    for start in arena.starts() {
        let [x, y] = view.px(start.position());
        let _ = write!(
            bodies,
            "M{} {y}a{radius_px} {radius_px} 0 1 0 {d} 0a{radius_px} {radius_px} 0 1 0 -{d} 0z",
            round_px(x - radius_px),
            d = round_px(2.0 * radius_px),
        );
        // Tip, tail and barbs in units of the radius, x along the heading.
        let (sin, cos) = (libm::sin(start.heading_rad), libm::cos(start.heading_rad));
        let [tip, tail, left, right] =
            [[0.75, 0.0], [-0.55, 0.0], [0.2, 0.42], [0.2, -0.42]].map(|[along, across]| {
                let turned = [along * cos - across * sin, along * sin + across * cos];
                [
                    round_px(x + radius_px * turned[0]),
                    round_px(y - radius_px * turned[1]),
                ]
            });
        let _ = write!(
            arrows,
            "M{} {}L{} {}M{} {}L{} {}L{} {}",
            tail[0], tail[1], tip[0], tip[1], left[0], left[1], tip[0], tip[1], right[0], right[1],
        );
    }
    push(
        svg,
        format_args!(
            r#"<g stroke="{BODY_LINE}" stroke-linejoin="round" stroke-linecap="round" stroke-width="{}">"#,
            round_px((0.12 * radius_px).clamp(0.3, line_px)),
        ),
    );
    push(
        svg,
        format_args!(r#"<path d="{bodies}" fill="{BODY_FILL}"/>"#),
    );
    push(svg, format_args!(r#"<path d="{arrows}" fill="none"/>"#));
    push(svg, format_args!("</g>"));
}

/// A bar of 1, 2 or 5 times a power of ten, at most a quarter of the width.
fn scale_bar(svg: &mut String, arena: &Arena, view: &View, text_px: f64, line_px: f64) {
    const LENGTHS_CM: [u32; 13] = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10_000];
    let most_cm = 25.0 * arena.width_m();
    let length_cm = LENGTHS_CM
        .into_iter()
        .rev()
        .find(|&length_cm| f64::from(length_cm) <= most_cm)
        .unwrap_or(LENGTHS_CM[0]);
    let label = if length_cm < 100 {
        format!("{length_cm} cm")
    } else {
        format!("{} m", length_cm / 100)
    };
    let length_px = f64::from(length_cm) / 100.0 * view.px_per_m;
    let [left, right] = [view.left_px, view.left_px + length_px].map(round_px);
    let [y, tick] = [view.base_px + 1.4 * text_px, 0.3 * text_px];
    push(
        svg,
        format_args!(
            r#"<path d="M{left} {0}V{1}M{left} {2}H{right}M{right} {0}V{1}" fill="none" stroke="{INK}" stroke-width="{3}"/>"#,
            round_px(y - tick),
            round_px(y + tick),
            round_px(y),
            round_px(0.75 * line_px),
        ),
    );
    push(
        svg,
        format_args!(
            r#"<text x="{}" y="{}">{label}</text>"#,
            round_px(right + 0.5 * text_px),
            round_px(y + 0.35 * text_px),
        ),
    );
}

/// Hundredths of a pixel are enough.
fn round_px(value_px: f64) -> f64 {
    (value_px * 100.0).round() / 100.0
}

fn push(svg: &mut String, line: std::fmt::Arguments<'_>) {
    // Writing to a string cannot fail.
    let _ = writeln!(svg, "{line}");
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;
    use crate::builtin;

    #[test]
    fn draws_each_wall_and_start_upright() {
        let arena = builtin("easy").unwrap();
        let svg = render_svg(
            &arena,
            &SvgOptions {
                size_px: 600,
                body_radius_m: 0.037,
            },
        );
        let walls = svg
            .lines()
            .find(|line| line.contains("fill=\"none\"") && line.contains("linecap"))
            .unwrap();
        assert_eq!(walls.matches('M').count(), arena.walls().len());
        // The first wall starts at (0, 0.45): three quarters up.
        assert!(walls.contains("M22.5 187.5L182.5 197.5"), "{walls}");
        assert!(
            svg.contains("<title>easy</title>")
                && svg.contains(">10 cm<")
                && svg.contains("0.6 m &#215; 0.6 m")
        );
        assert_eq!(svg.matches("a37 37").count(), 2);
        assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"));
    }

    #[test]
    fn long_thin_and_tiny_drawings_stay_finite() {
        let arena = Arena::from_json(
            r#"{"name": "a", "width_m": 1000, "height_m": 0.1, "walls_m": [],
                "starts": [{"x_m": 0.9, "y_m": 0.05, "heading_rad": 0}]}"#,
        )
        .unwrap();
        let svg = render_svg(
            &arena,
            &SvgOptions {
                size_px: 1,
                body_radius_m: 0.0,
            },
        );
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
        assert!(svg.contains(">100 m<"));
    }
}
