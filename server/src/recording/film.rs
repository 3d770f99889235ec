//! A moment of a recording as pixels: walls, objects, robots with their headings.

use recording::{Header, Samples};
use serde_json::Value;
use tiny_skia::{Color, FillRule, LineCap, Paint, PathBuilder, Pixmap, Stroke, Transform};

/// Colours of robots, told apart by the colour-blind too.
const COLOURS: [[u8; 3]; 8] = [
    [0, 114, 178],
    [213, 94, 0],
    [0, 158, 115],
    [204, 121, 167],
    [230, 159, 0],
    [86, 180, 233],
    [90, 90, 90],
    [140, 100, 40],
];
const WALLS: [u8; 3] = [40, 40, 48];
const OBJECTS: [u8; 3] = [190, 150, 90];

/// An arena in pixels.
pub struct Film {
    empty: Pixmap,
    scale: f32,
    height_m: f32,
    arena: Value,
}

impl Film {
    /// An arena whose longer side has so many pixels; `None` where that cannot be.
    pub fn new(arena: &Value, pixels: u32) -> Option<Self> {
        let side = |name: &str| arena[name].as_f64().unwrap_or(1.0).max(1e-6) as f32;
        let (width_m, height_m) = (side("width_m"), side("height_m"));
        let scale = pixels as f32 / width_m.max(height_m);
        // Films want even numbers of pixels.
        let even = |metres: f32| ((metres * scale / 2.0).round() as u32).max(8) * 2;
        let mut film = Self {
            empty: Pixmap::new(even(width_m), even(height_m))?,
            scale,
            height_m,
            arena: arena.clone(),
        };
        film.empty.fill(Color::WHITE);
        let mut walls = PathBuilder::new();
        for wall in arena["walls_m"].as_array().into_iter().flatten() {
            let at = |place: usize| wall[place].as_f64().unwrap_or(0.0);
            let ([ax, ay], [bx, by]) = (film.at(at(0), at(1)), film.at(at(2), at(3)));
            walls.move_to(ax, ay);
            walls.line_to(bx, by);
        }
        for [ax, ay, bx, by] in [
            [0.0, 0.0, width_m, 0.0],
            [width_m, 0.0, width_m, height_m],
            [width_m, height_m, 0.0, height_m],
            [0.0, height_m, 0.0, 0.0],
        ] {
            let at = |x: f32, y: f32| film.at(f64::from(x), f64::from(y));
            let ([ax, ay], [bx, by]) = (at(ax, ay), at(bx, by));
            walls.move_to(ax, ay);
            walls.line_to(bx, by);
        }
        if let Some(walls) = walls.finish() {
            let stroke = Stroke {
                width: 2.0,
                line_cap: LineCap::Round,
                ..Stroke::default()
            };
            let here = Transform::identity();
            film.empty
                .stroke_path(&walls, &paint(WALLS), &stroke, here, None);
        }
        Some(film)
    }

    /// Pixels along both sides.
    pub fn size(&self) -> [u32; 2] {
        [self.empty.width(), self.empty.height()]
    }

    fn at(&self, x_m: f64, y_m: f64) -> [f32; 2] {
        let (x_m, y_m) = (x_m as f32, y_m as f32);
        [x_m * self.scale, (self.height_m - y_m) * self.scale]
    }

    /// A moment, four bytes a pixel.
    pub fn show(&self, header: &Header, block: &Samples, at: usize) -> Vec<u8> {
        let mut pixels = self.empty.clone();
        let objects = self.arena["objects"].as_array();
        for (number, object) in objects.into_iter().flatten().enumerate() {
            if number < block.objects {
                self.draw_object(&mut pixels, object, block.object_pose(number, at));
            }
        }
        if header.fields.pose {
            for row in 0..block.rows {
                let number = header.robots.number(row) as usize;
                let colour = COLOURS[number % COLOURS.len()];
                self.draw_robot(
                    &mut pixels,
                    header.body_radius_m,
                    block.pose(row, at),
                    colour,
                );
            }
        }
        pixels.take()
    }

    fn draw_object(&self, pixels: &mut Pixmap, object: &Value, pose: [f64; 3]) {
        let [x_m, y_m, heading_rad] = pose;
        let size = |name: &str| object[name].as_f64();
        let mut outline = PathBuilder::new();
        if let Some(radius_m) = size("radius_m") {
            let [x, y] = self.at(x_m, y_m);
            outline.push_circle(x, y, radius_m as f32 * self.scale);
        } else if let (Some(width_m), Some(height_m)) = (size("width_m"), size("height_m")) {
            let (sin, cos) = (libm::sin(heading_rad), libm::cos(heading_rad));
            for (number, [a, b]) in [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]]
                .into_iter()
                .enumerate()
            {
                let (dx, dy) = (a * width_m / 2.0, b * height_m / 2.0);
                let [x, y] = self.at(x_m + dx * cos - dy * sin, y_m + dx * sin + dy * cos);
                match number {
                    0 => outline.move_to(x, y),
                    _ => outline.line_to(x, y),
                }
            }
            outline.close();
        }
        if let Some(outline) = outline.finish() {
            let here = Transform::identity();
            pixels.fill_path(&outline, &paint(OBJECTS), FillRule::Winding, here, None);
        }
    }

    fn draw_robot(&self, pixels: &mut Pixmap, radius_m: f64, pose: [f64; 3], colour: [u8; 3]) {
        let [x_m, y_m, heading_rad] = pose;
        let [x, y] = self.at(x_m, y_m);
        let here = Transform::identity();
        let mut body = PathBuilder::new();
        body.push_circle(x, y, (radius_m as f32 * self.scale).max(1.5));
        if let Some(body) = body.finish() {
            pixels.fill_path(&body, &paint(colour), FillRule::Winding, here, None);
        }
        let nose = [
            x_m + radius_m * libm::cos(heading_rad),
            y_m + radius_m * libm::sin(heading_rad),
        ];
        let [nose_x, nose_y] = self.at(nose[0], nose[1]);
        let mut heading = PathBuilder::new();
        heading.move_to(x, y);
        heading.line_to(nose_x, nose_y);
        if let Some(heading) = heading.finish() {
            let stroke = Stroke {
                width: (radius_m as f32 * self.scale * 0.3).max(1.0),
                ..Stroke::default()
            };
            pixels.stroke_path(&heading, &paint([255; 3]), &stroke, here, None);
        }
    }
}

fn paint([red, green, blue]: [u8; 3]) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color_rgba8(red, green, blue, 255);
    paint
}
