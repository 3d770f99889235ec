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

/// Rows that are drawn at a time, so that pixels stay in the cache and memory stays small.
const BAND_ROWS: u32 = 128;

/// Draws the scene on white.
pub fn png(scene: &Scene) -> Vec<u8> {
    let size = [scene.width_px, scene.height_px];
    let mut indexed = Some(Indexed::new(scene));
    draw(scene, BAND_ROWS, |pixels| {
        indexed = indexed.take().and_then(|indexed| indexed.with(pixels));
        indexed.is_some()
    });
    match indexed {
        Some(Indexed {
            colours, places, ..
        }) => encoded(size, &places, |encoder| {
            encoder.set_color(png::ColorType::Indexed);
            encoder.set_palette(colours.list.concat());
            // Nothing to foresee in places. As quick as the fastest way, in a tenth of the bytes.
            encoder.set_filter(png::Filter::NoFilter);
            encoder.set_deflate_compression(png::DeflateCompression::Level(1));
        }),
        None => {
            let mut rgb = Vec::new();
            draw(scene, BAND_ROWS, |pixels| {
                rgb.extend(pixels.iter().copied().flat_map(colour));
                true
            });
            png_of_rgb(&rgb, scene.width_px, scene.height_px)
        }
    }
}

/// Draws the scene band by band from the top, as long as `take` wants more pixels.
fn draw(scene: &Scene, band_rows: u32, mut take: impl FnMut(&[PremultipliedColorU8]) -> bool) {
    #[allow(
        clippy::expect_used,
        reason = "sizes are small and never zero, and the embedded font can be parsed"
    )]
    let mut band = Band {
        pixmap: Pixmap::new(scene.width_px, band_rows).expect("the size is not zero"),
        regular: Face::parse(dejavu::sans::regular(), 0).expect("the embedded font is valid"),
        bold: Face::parse(dejavu::sans::bold(), 0).expect("the embedded font is valid"),
        top: 0.0,
    };
    for top in (0..scene.height_px).step_by(band_rows as usize) {
        band.top = top as f32;
        band.pixmap.fill(Color::WHITE);
        for item in &scene.items {
            band.draw(item);
        }
        let rows = band_rows.min(scene.height_px - top);
        if !take(&band.pixmap.pixels()[..(rows * scene.width_px) as usize]) {
            return;
        }
    }
}

/// Every pixel is opaque.
fn colour(pixel: PremultipliedColorU8) -> Colour {
    [pixel.red(), pixel.green(), pixel.blue()]
}

/// Pixels as places in a list of colours: a third of the bytes.
struct Indexed {
    colours: Colours,
    places: Vec<u8>,
    /// Pixels that have their places.
    placed: usize,
}

struct Colours {
    /// White is the first.
    list: Vec<Colour>,
    /// Where colours were found last, so that the list is seldom searched.
    found: [(Colour, u8); 1_024],
}

impl Indexed {
    fn new(scene: &Scene) -> Self {
        Self {
            colours: Colours {
                list: vec![WHITE],
                found: [(WHITE, 0); 1_024],
            },
            places: vec![0; (scene.width_px * scene.height_px) as usize],
            placed: 0,
        }
    }

    /// `None` when there are more than 256 colours.
    fn with(mut self, pixels: &[PremultipliedColorU8]) -> Option<Self> {
        for (pixels, places) in pixels
            .chunks(16)
            .zip(self.places[self.placed..].chunks_mut(16))
        {
            // Most are alike, which is seen at once, and white, which is there already.
            let first = pixels[0];
            if pixels
                .iter()
                .fold(true, |alike, &pixel| alike & (pixel == first))
            {
                match self.colours.place(colour(first))? {
                    0 => {}
                    place => places[..pixels.len()].fill(place),
                }
            } else {
                for (place, &pixel) in places.iter_mut().zip(pixels) {
                    *place = self.colours.place(colour(pixel))?;
                }
            }
        }
        self.placed += pixels.len();
        Some(self)
    }
}

impl Colours {
    fn place(&mut self, colour: Colour) -> Option<u8> {
        let [red, green, blue] = colour.map(usize::from);
        let (known, place) = &mut self.found[(red ^ (green << 1) ^ (blue << 2)) % 1_024];
        if *known != colour {
            let at = self.list.iter().position(|&known| known == colour);
            let at = at.unwrap_or_else(|| {
                self.list.push(colour);
                self.list.len() - 1
            });
            (*known, *place) = (colour, u8::try_from(at).ok()?);
        }
        Some(*place)
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

/// Some rows of a picture.
struct Band {
    pixmap: Pixmap,
    regular: Face<'static>,
    bold: Face<'static>,
    /// Row of the picture that is the band's first.
    top: f32,
}

impl Band {
    /// Whether what lies between these two heights of the picture, and a little beyond, is seen.
    fn shows(&self, y1: f32, y2: f32, beyond_px: f32) -> bool {
        let (upper, lower) = (y1.min(y2) - beyond_px, y1.max(y2) + beyond_px);
        lower >= self.top && upper <= self.top + self.pixmap.height() as f32
    }

    fn draw(&mut self, item: &Item) {
        match item {
            Item::Rectangles { rectangles, colour } => {
                let paint = paint(*colour);
                for [x, y, width, height] in rectangles {
                    let rectangle = Rect::from_xywh(*x, *y - self.top, *width, *height);
                    if let Some(rectangle) = rectangle.filter(|_| self.shows(*y, *y + *height, 1.0))
                    {
                        let pixmap = &mut self.pixmap;
                        pixmap.fill_rect(rectangle, &paint, Transform::identity(), None);
                    }
                }
            }
            Item::Lines {
                lines,
                width_px,
                colour,
            } => {
                let mut path = PathBuilder::new();
                for [x1, y1, x2, y2] in lines {
                    if self.shows(*y1, *y2, *width_px) {
                        path.move_to(*x1, *y1 - self.top);
                        path.line_to(*x2, *y2 - self.top);
                    }
                }
                self.stroke(path.finish(), *width_px, *colour);
            }
            Item::Disc {
                centre: [x, y],
                radius_px,
                colour,
            } => {
                if self.shows(*y, *y, 2.0 * radius_px) {
                    let circle = PathBuilder::from_circle(*x, *y - self.top, *radius_px);
                    self.fill(circle.clone(), *colour);
                    self.stroke(circle, 1.5, WHITE);
                }
            }
            Item::Text {
                text,
                at: [x, y],
                size_px,
                bold,
                anchor,
                colour,
            } => {
                if self.shows(*y, *y, 1.5 * size_px) {
                    let face = if *bold { &self.bold } else { &self.regular };
                    let path = text_path(face, text, [*x, *y - self.top], *size_px, *anchor);
                    self.fill(path, *colour);
                }
            }
        }
    }

    fn fill(&mut self, path: Option<Path>, colour: Colour) {
        // No path: a shape without points, such as a space.
        if let Some(path) = path {
            let paint = paint(colour);
            let (rule, whole) = (FillRule::Winding, Transform::identity());
            self.pixmap.fill_path(&path, &paint, rule, whole, None);
        }
    }

    fn stroke(&mut self, path: Option<Path>, width_px: f32, colour: Colour) {
        if let Some(path) = path {
            // Hatching is thousands of lines, whose smooth edges would be a tenth of a short run.
            let smooth = width_px > 1.0;
            let stroke = Stroke {
                // Without a width: one pixel.
                width: if smooth { width_px } else { 0.0 },
                line_cap: LineCap::Round,
                ..Stroke::default()
            };
            let mut paint = paint(colour);
            paint.anti_alias = smooth;
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
    fn bands_show_what_the_whole_shows() {
        let line = |at: f32| [3.0, at, 190.0, 1.3 * at];
        let scene = Scene {
            width_px: 200,
            height_px: 300,
            items: vec![
                Item::Rectangles {
                    rectangles: (0..20)
                        .map(|n| [9.7 * n as f32, 13.3 * n as f32, 9.0, 40.5])
                        .collect(),
                    colour: [200, 30, 90],
                },
                Item::Lines {
                    lines: (0..30).map(|n| line(9.1 * n as f32)).collect(),
                    width_px: 5.0,
                    colour: [20, 120, 20],
                },
                Item::Lines {
                    lines: (0..200)
                        .map(|n| (8.0 * (n % 20) as f32, 24.0 * (n / 20) as f32))
                        .map(|(x, y)| [x, y + 8.0, x + 8.0, y])
                        .collect(),
                    width_px: 1.0,
                    colour: [0, 0, 0],
                },
                Item::Disc {
                    centre: [70.0, 130.0],
                    radius_px: 25.0,
                    colour: [70, 70, 200],
                },
                Item::Text {
                    text: "gently (over) bands".to_owned(),
                    at: [100.0, 67.0],
                    size_px: 20.0,
                    bold: true,
                    anchor: Anchor::Middle,
                    colour: [9, 9, 9],
                },
            ],
        };
        let drawn = |band_rows| {
            let mut all = Vec::new();
            draw(&scene, band_rows, |pixels| {
                all.extend_from_slice(pixels);
                true
            });
            all
        };
        let whole = drawn(300);
        // Smooth edges that a border cuts are a shade off in few places; nothing is missing.
        for band_rows in [7, 64, 128, 299, 301] {
            let apart = |(&band, &whole): (&PremultipliedColorU8, &PremultipliedColorU8)| {
                let channels = colour(band).into_iter().zip(colour(whole));
                channels.map(|(a, b)| a.abs_diff(b)).max().unwrap()
            };
            let band = drawn(band_rows);
            assert_eq!(band.len(), 200 * 300);
            let off: Vec<u8> = band.iter().zip(&whole).map(apart).collect();
            let many = off.iter().filter(|&&off| off > 0).count();
            let most = off.iter().max().unwrap();
            assert!(many < 600 && *most < 64, "{band_rows} rows: {many}, {most}");
        }
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
