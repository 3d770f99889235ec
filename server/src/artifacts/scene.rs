//! A picture as a list of shapes, drawn in order; pixels from the upper left corner, y down.

use super::palette::Colour;

/// A picture.
pub struct Scene {
    pub width_px: u32,
    pub height_px: u32,
    pub items: Vec<Item>,
}

/// Something to draw.
pub enum Item {
    /// Filled rectangles: left, top, width, height.
    Rectangles {
        rectangles: Vec<[f32; 4]>,
        colour: Colour,
    },
    /// Lines: x1, y1, x2, y2.
    Lines {
        lines: Vec<[f32; 4]>,
        width_px: f32,
        colour: Colour,
    },
    /// A filled disc with an outline in white.
    Disc {
        centre: [f32; 2],
        radius_px: f32,
        colour: Colour,
    },
    /// Text on one line; `at` is on its base line.
    Text {
        text: String,
        at: [f32; 2],
        size_px: f32,
        bold: bool,
        anchor: Anchor,
        colour: Colour,
    },
}

/// Which end of a text stands at its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    Start,
    Middle,
    End,
}
