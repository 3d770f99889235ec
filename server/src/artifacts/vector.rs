//! A scene as SVG.

#![allow(
    clippy::let_underscore_must_use,
    reason = "writing to a string cannot fail"
)]

use std::fmt::Write;

use super::palette::{Colour, WHITE};
use super::scene::{Anchor, Item, Scene};

/// Draws the scene on white.
pub fn svg(scene: &Scene) -> String {
    let Scene {
        width_px,
        height_px,
        items,
    } = scene;
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width_px}\" height=\"{height_px}\" \
         viewBox=\"0 0 {width_px} {height_px}\" \
         font-family=\"DejaVu Sans, Verdana, sans-serif\">\n\
         <rect width=\"{width_px}\" height=\"{height_px}\" fill=\"#ffffff\"/>\n"
    );
    for item in items {
        // Writing to a string cannot fail.
        let _ = draw(&mut out, item);
    }
    out.push_str("</svg>\n");
    out
}

fn draw(out: &mut String, item: &Item) -> std::fmt::Result {
    match item {
        Item::Rectangles { rectangles, colour } => {
            write!(out, "<path fill=\"{}\" d=\"", hex(*colour))?;
            for [x, y, width, height] in rectangles {
                write!(out, "M{x} {y}h{width}v{height}h-{width}z")?;
            }
            writeln!(out, "\"/>")
        }
        Item::Lines {
            lines,
            width_px,
            colour,
        } => {
            let colour = hex(*colour);
            write!(
                out,
                "<path fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width_px}\" \
                 stroke-linecap=\"round\" d=\""
            )?;
            for [x1, y1, x2, y2] in lines {
                write!(out, "M{x1} {y1}L{x2} {y2}")?;
            }
            writeln!(out, "\"/>")
        }
        Item::Disc {
            centre: [x, y],
            radius_px,
            colour,
        } => writeln!(
            out,
            "<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius_px}\" fill=\"{}\" stroke=\"{}\" \
             stroke-width=\"1.5\"/>",
            hex(*colour),
            hex(WHITE)
        ),
        Item::Text {
            text,
            at: [x, y],
            size_px,
            bold,
            anchor,
            colour,
        } => {
            let weight = if *bold { " font-weight=\"bold\"" } else { "" };
            let anchor = match anchor {
                Anchor::Start => "start",
                Anchor::Middle => "middle",
                Anchor::End => "end",
            };
            writeln!(
                out,
                "<text x=\"{x}\" y=\"{y}\" font-size=\"{size_px}\"{weight} \
                 text-anchor=\"{anchor}\" fill=\"{}\">{}</text>",
                hex(*colour),
                escaped(text)
            )
        }
    }
}

fn hex([red, green, blue]: Colour) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}
