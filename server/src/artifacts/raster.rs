//! A scene as PNG.
//!
//! The rasteriser runs without SIMD, and glyphs come as outlines from an embedded font: no step
//! depends on the machine, so equal scenes give equal bytes.

use tiny_skia::{
    Color, FillRule, LineCap, Paint, Path, PathBuilder, Pixmap, PremultipliedColorU8, Rect, Stroke,
    Transform,
};
use ttf_parser::{Face, OutlineBuilder};

use super::palette::{Colour, WHITE};
use super::scene::{Anchor, Item, Scene};

/// Draws the scene on white.
pub fn png(scene: &Scene) -> Vec<u8> {
    #[allow(
        clippy::expect_used,
        reason = "sizes are small and never zero, the embedded font can be parsed, and encoding goes to memory"
    )]
    let mut canvas = Canvas {
        pixmap: Pixmap::new(scene.width_px, scene.height_px).expect("the size is not zero"),
        regular: Face::parse(dejavu::sans::regular(), 0).expect("the embedded font is valid"),
        bold: Face::parse(dejavu::sans::bold(), 0).expect("the embedded font is valid"),
    };
    canvas.pixmap.fill(Color::WHITE);
    for item in &scene.items {
        canvas.draw(item);
    }
    let pixels = canvas.pixmap.pixels();
    let size = [scene.width_px, scene.height_px];
    match Indexed::of(pixels) {
        Some(Indexed { colours, places }) => encoded(size, &places, |encoder| {
            encoder.set_color(png::ColorType::Indexed);
            encoder.set_palette(colours.concat());
            // Nothing to foresee in places. As quick as the fastest way, in a tenth of the bytes.
            encoder.set_filter(png::Filter::NoFilter);
            encoder.set_deflate_compression(png::DeflateCompression::Level(1));
        }),
        None => {
            let rgb: Vec<u8> = pixels.iter().flat_map(colour).collect();
            png_of_rgb(&rgb, scene.width_px, scene.height_px)
        }
    }
}

/// Every pixel is opaque.
fn colour(pixel: &PremultipliedColorU8) -> Colour {
    [pixel.red(), pixel.green(), pixel.blue()]
}

/// Pixels as places in a list of colours: a third of the bytes.
struct Indexed {
    colours: Vec<Colour>,
    places: Vec<u8>,
}

impl Indexed {
    /// `None` when there are more than 256 colours; white is the first.
    fn of(pixels: &[PremultipliedColorU8]) -> Option<Self> {
        let mut colours = vec![WHITE];
        let mut places = Vec::with_capacity(pixels.len());
        // Where colours were found last, so that the list is seldom searched.
        let mut found = [(WHITE, 0); 1_024];
        for pixel in pixels {
            let colour = colour(pixel);
            let [red, green, blue] = colour.map(usize::from);
            let (known, place) = &mut found[(red ^ (green << 1) ^ (blue << 2)) % 1_024];
            if *known != colour {
                let at = colours.iter().position(|&known| known == colour);
                let at = at.unwrap_or_else(|| {
                    colours.push(colour);
                    colours.len() - 1
                });
                (*known, *place) = (colour, u8::try_from(at).ok()?);
            }
            places.push(*place);
        }
        Some(Self { colours, places })
    }
}

/// Pixels as PNG, row by row from the top, three bytes each.
///
/// # Panics
/// When there are not `width` x `height` pixels.
pub fn png_of_rgb(rgb: &[u8], width: u32, height: u32) -> Vec<u8> {
    encoded([width, height], rgb, |encoder| {
        encoder.set_color(png::ColorType::Rgb);
    })
}

fn encoded(
    [width, height]: [u32; 2],
    data: &[u8],
    set: impl FnOnce(&mut png::Encoder<'_, &mut Vec<u8>>),
) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_depth(png::BitDepth::Eight);
    // Encoding would be most of a short run otherwise.
    encoder.set_compression(png::Compression::Fast);
    set(&mut encoder);
    #[allow(
        clippy::expect_used,
        reason = "writing to memory cannot fail, and the data has the announced size"
    )]
    encoder
        .write_header()
        .and_then(|mut writer| writer.write_image_data(data))
        .expect("a picture in memory can be encoded");
    bytes
}

struct Canvas {
    pixmap: Pixmap,
    regular: Face<'static>,
    bold: Face<'static>,
}

impl Canvas {
    fn draw(&mut self, item: &Item) {
        match item {
            Item::Rectangles { rectangles, colour } => {
                let mut path = PathBuilder::new();
                for [x, y, width, height] in rectangles {
                    if let Some(rectangle) = Rect::from_xywh(*x, *y, *width, *height) {
                        path.push_rect(rectangle);
                    }
                }
                self.fill(path.finish(), *colour);
            }
            Item::Lines {
                lines,
                width_px,
                colour,
            } => {
                let mut path = PathBuilder::new();
                for [x1, y1, x2, y2] in lines {
                    path.move_to(*x1, *y1);
                    path.line_to(*x2, *y2);
                }
                self.stroke(path.finish(), *width_px, *colour);
            }
            Item::Disc {
                centre: [x, y],
                radius_px,
                colour,
            } => {
                let circle = PathBuilder::from_circle(*x, *y, *radius_px);
                self.fill(circle.clone(), *colour);
                self.stroke(circle, 1.5, WHITE);
            }
            Item::Text {
                text,
                at,
                size_px,
                bold,
                anchor,
                colour,
            } => {
                let face = if *bold { &self.bold } else { &self.regular };
                let path = text_path(face, text, *at, *size_px, *anchor);
                self.fill(path, *colour);
            }
        }
    }

    fn fill(&mut self, path: Option<Path>, colour: Colour) {
        // No path: a shape without points, such as a space.
        if let Some(path) = path {
            let paint = paint(colour);
            self.pixmap.fill_path(
                &path,
                &paint,
                FillRule::Winding,
                Transform::identity(),
                None,
            );
        }
    }

    fn stroke(&mut self, path: Option<Path>, width_px: f32, colour: Colour) {
        if let Some(path) = path {
            let stroke = Stroke {
                width: width_px,
                line_cap: LineCap::Round,
                ..Stroke::default()
            };
            let paint = paint(colour);
            self.pixmap
                .stroke_path(&path, &paint, &stroke, Transform::identity(), None);
        }
    }
}

fn paint([red, green, blue]: Colour) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color_rgba8(red, green, blue, 255);
    paint
}

/// The outlines of a line of text.
fn text_path(
    face: &Face<'_>,
    text: &str,
    [x, y]: [f32; 2],
    size_px: f32,
    anchor: Anchor,
) -> Option<Path> {
    let scale = size_px / f32::from(face.units_per_em());
    let glyphs = || text.chars().filter_map(|letter| face.glyph_index(letter));
    let advance = |glyph| f32::from(face.glyph_hor_advance(glyph).unwrap_or(0)) * scale;
    let width: f32 = glyphs().map(advance).sum();
    let x = match anchor {
        Anchor::Start => x,
        Anchor::Middle => x - width / 2.0,
        Anchor::End => x - width,
    };
    let mut outline = Outline {
        path: PathBuilder::new(),
        origin: [x, y],
        scale,
    };
    for glyph in glyphs() {
        face.outline_glyph(glyph, &mut outline);
        outline.origin[0] += advance(glyph);
    }
    outline.path.finish()
}

/// Takes a glyph's outline from font units, y up, to pixels.
struct Outline {
    path: PathBuilder,
    origin: [f32; 2],
    scale: f32,
}

impl Outline {
    fn at(&self, x: f32, y: f32) -> (f32, f32) {
        (
            self.origin[0] + x * self.scale,
            self.origin[1] - y * self.scale,
        )
    }
}

impl OutlineBuilder for Outline {
    fn move_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.path.move_to(x, y);
    }
    fn line_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.path.line_to(x, y);
    }
    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let ((x1, y1), (x, y)) = (self.at(x1, y1), self.at(x, y));
        self.path.quad_to(x1, y1, x, y);
    }
    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let ((x1, y1), (x2, y2), (x, y)) = (self.at(x1, y1), self.at(x2, y2), self.at(x, y));
        self.path.cubic_to(x1, y1, x2, y2, x, y);
    }
    fn close(&mut self) {
        self.path.close();
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
    use super::*;

    /// Pixels of a PNG, three bytes each.
    fn decoded(bytes: &[u8]) -> Vec<u8> {
        let mut decoder = png::Decoder::new(std::io::Cursor::new(bytes));
        decoder.set_transformations(png::Transformations::EXPAND);
        let mut reader = decoder.read_info().unwrap();
        let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut pixels).unwrap();
        assert_eq!(info.color_type, png::ColorType::Rgb);
        pixels.truncate(info.buffer_size());
        pixels
    }

    #[test]
    fn few_colours_are_stored_as_places_and_many_as_they_are() {
        for colours in [1, 2, 256, 257, 2_000_u32] {
            let rectangles = (0..colours).map(|number| Item::Rectangles {
                rectangles: vec![[(number % 50) as f32, (number / 50) as f32, 1.0, 1.0]],
                colour: [(number % 251) as u8, (number / 251) as u8, 7],
            });
            let scene = Scene {
                width_px: 50,
                height_px: 41,
                items: rectangles.collect(),
            };
            let bytes = png(&scene);
            let pixels = decoded(&bytes);
            for number in 0..50 * 41 {
                let expected = match number < colours {
                    true => [(number % 251) as u8, (number / 251) as u8, 7],
                    false => WHITE,
                };
                assert_eq!(
                    pixels[3 * number as usize..][..3],
                    expected,
                    "{colours} {number}"
                );
            }
            // Colour type 3 is indexed, 2 is RGB.
            assert_eq!(bytes[25], if colours < 256 { 3 } else { 2 }, "{colours}");
        }
    }
}
