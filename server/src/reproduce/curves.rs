//! Curves of p1 by epoch as SVG: the mean over runs with its bootstrap band, a line a method.

#![allow(
    clippy::let_underscore_must_use,
    reason = "writing to a string cannot fail"
)]

use std::fmt::Write;

use super::document::escaped;
use crate::statistics::bootstrap::band;

/// One method's runs.
pub struct Line {
    pub method: String,
    /// p1 after each epoch, a curve a run.
    pub curves: Vec<Vec<f64>>,
}

const WIDTH: f64 = 760.0;
const HEIGHT: f64 = 400.0;
const LEFT: f64 = 62.0;
const RIGHT: f64 = 122.0;
const TOP: f64 = 14.0;
const BOTTOM: f64 = 48.0;
/// Epochs that are drawn: no more can be told apart.
const POINTS: usize = 200;
/// Least distance of two labels.
const LABEL: f64 = 14.0;

/// Draws the curves of one arena; an epoch too few runs have is not drawn.
pub fn svg(lines: &[Line]) -> String {
    let epochs = lines
        .iter()
        .flat_map(|line| line.curves.iter().map(Vec::len))
        .min()
        .unwrap_or(0);
    let drawn = drawn_epochs(epochs);
    let highest = lines
        .iter()
        .flat_map(|line| line.curves.iter().flatten())
        .copied()
        .fold(1.0, f64::max);
    let step = tick(highest);
    let top = (highest / step).ceil() * step;
    let x = |epoch: usize| LEFT + (WIDTH - LEFT - RIGHT) * epoch as f64 / epochs.max(1) as f64;
    let y = |squares: f64| HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) * squares / top;

    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" \
         width=\"{WIDTH}\" height=\"{HEIGHT}\" font-family=\"Helvetica,Arial,sans-serif\" \
         font-size=\"11\">\n"
    );
    axes(&mut out, epochs, top, &x, &y);
    let mut labels = Vec::new();
    for line in lines {
        let curves: Vec<Vec<f64>> = line
            .curves
            .iter()
            .map(|curve| drawn.iter().map(|&epoch| curve[epoch - 1]).collect())
            .collect();
        let band = band(&curves);
        let along = |values: &[f64]| -> Vec<String> {
            drawn
                .iter()
                .zip(values)
                .map(|(&epoch, &value)| format!("{:.1},{:.1}", x(epoch), y(value)))
                .collect()
        };
        let (colour, dashes) = look(&line.method);
        let mut around = along(&band.low);
        around.extend(along(&band.high).into_iter().rev());
        // Writing to a string cannot fail.
        let _ = writeln!(
            out,
            "<polygon fill=\"{colour}\" fill-opacity=\"0.15\" points=\"{}\"/>\n\
             <polyline fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.6\"{dashes} \
             points=\"{}\"/>",
            around.join(" "),
            along(&band.mean).join(" ")
        );
        let end = y(band.mean.last().copied().unwrap_or(0.0));
        labels.push((end, colour, dashes, line.method.as_str()));
    }
    write_labels(&mut out, labels);
    out.push_str("</svg>\n");
    out
}

/// At most [`POINTS`] epochs, the first and the last among them.
fn drawn_epochs(epochs: usize) -> Vec<usize> {
    let points = epochs.min(POINTS);
    let last = points.saturating_sub(1).max(1);
    (0..points)
        .map(|point| 1 + point * (epochs - 1) / last)
        .collect()
}

fn axes(
    out: &mut String,
    epochs: usize,
    top: f64,
    x: &impl Fn(usize) -> f64,
    y: &impl Fn(f64) -> f64,
) {
    let (bottom, right) = (y(0.0), x(epochs));
    let step = tick(top);
    let mut squares = 0.0;
    while squares <= top {
        let at = y(squares);
        let _ = writeln!(
            out,
            "<path stroke=\"#ddd\" d=\"M{LEFT} {at:.1}H{right:.1}\"/>\
             <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{squares}</text>",
            LEFT - 6.0,
            at + 4.0
        );
        squares += step;
    }
    let step = tick(epochs as f64).max(1.0) as usize;
    for epoch in (0..=epochs).step_by(step) {
        let at = x(epoch);
        let _ = writeln!(
            out,
            "<path stroke=\"#111\" d=\"M{at:.1} {bottom:.1}v4\"/>\
             <text x=\"{at:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{epoch}</text>",
            bottom + 17.0
        );
    }
    let (across, up) = (0.5 * (LEFT + right), 0.5 * (TOP + bottom));
    let _ = writeln!(
        out,
        "<path fill=\"none\" stroke=\"#111\" d=\"M{LEFT} {TOP}V{bottom:.1}H{right:.1}\"/>\
         <text x=\"{across:.1}\" y=\"{:.1}\" text-anchor=\"middle\">epoch</text>\
         <text transform=\"translate(14 {up:.1}) rotate(-90)\" text-anchor=\"middle\">\
         p1 (squares)</text>",
        HEIGHT - 10.0
    );
}

/// Names at the ends of the lines, pushed apart where they would overlap.
fn write_labels(out: &mut String, mut labels: Vec<(f64, &str, &str, &str)>) {
    labels.sort_by(|one, other| one.0.total_cmp(&other.0));
    let spare = HEIGHT - BOTTOM - LABEL * labels.len().saturating_sub(1) as f64;
    let mut least = TOP;
    for (place, (end, colour, dashes, method)) in labels.into_iter().enumerate() {
        // Not so low that those below have no room.
        let at = end.min(spare + LABEL * place as f64).max(least);
        least = at + LABEL;
        let left = WIDTH - RIGHT;
        let _ = writeln!(
            out,
            "<path stroke=\"#bbb\" fill=\"none\" d=\"M{left:.1} {end:.1}L{:.1} {at:.1}\"/>\
             <path stroke=\"{colour}\" stroke-width=\"1.6\"{dashes} d=\"M{:.1} {at:.1}h20\"/>\
             <text x=\"{:.1}\" y=\"{:.1}\">{}</text>",
            left + 10.0,
            left + 12.0,
            left + 37.0,
            at + 4.0,
            escaped(method)
        );
    }
}

/// Colour (of Okabe and Ito) and dashes: one colour a family, dashes for actuator data.
fn look(method: &str) -> (&'static str, &'static str) {
    const DASHES: &str = " stroke-dasharray=\"5 3\"";
    match method {
        "brownian" => ("#777777", ""),
        "curiosity" => ("#e69f00", ""),
        "curiosity-a" => ("#e69f00", DASHES),
        "discovery" => ("#009e73", ""),
        "discovery-a" => ("#009e73", DASHES),
        "im" => ("#111111", ""),
        "ev-iter-c" => ("#d55e00", ""),
        "ev-iter-ca" => ("#d55e00", DASHES),
        "ev-iter-d" => ("#0072b2", ""),
        "ev-iter-da" => ("#0072b2", DASHES),
        _ => ("#cc79a7", " stroke-dasharray=\"2 2\""),
    }
}

/// Distance between ticks: 1, 2 or 5 times a power of ten, at most six of them.
fn tick(range: f64) -> f64 {
    let mut power = 1.0;
    loop {
        for step in [power, 2.0 * power, 5.0 * power] {
            if range / step <= 6.0 {
                return step;
            }
        }
        power *= 10.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_and_last_epoch_are_drawn() {
        assert_eq!(drawn_epochs(3), [1, 2, 3]);
        assert_eq!(drawn_epochs(1), [1]);
        assert!(drawn_epochs(0).is_empty());
        let many = drawn_epochs(2_000);
        assert_eq!((many.len(), many[0], many[199]), (200, 1, 2_000));
        assert!(many.windows(2).all(|pair| pair[0] < pair[1]));
    }

    #[test]
    fn every_line_has_curve_band_and_label() {
        let curve = |top: f64| {
            (1..=50)
                .map(|epoch| top * f64::from(epoch) / 50.0)
                .collect()
        };
        let line = |method: &str| Line {
            method: method.to_owned(),
            curves: vec![curve(900.0), curve(1_000.0)],
        };
        let svg = svg(&[line("im"), line("ev-iter-c"), line("ev-iter-ca")]);
        assert_eq!(svg.matches("<polyline").count(), 3);
        assert_eq!(svg.matches("<polygon").count(), 3);
        for text in [">im<", ">ev-iter-c<", ">1000<", ">50<"] {
            assert!(svg.contains(text), "{text}");
        }
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
    }

    #[test]
    fn nothing_to_draw_is_no_panic() {
        assert!(svg(&[]).contains("<svg"));
    }
}
