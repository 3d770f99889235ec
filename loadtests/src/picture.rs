//! Cost against robots, and memory against robots, as one picture.

use std::path::Path;

use anyhow::{Result, anyhow};
use plotters::coord::ranged1d::Ranged;
use plotters::prelude::*;

use crate::gain::Gain;
use crate::measure::Figure;
use crate::table::{SCALING, robots_of};

const COLOURS: [RGBColor; 4] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
];

/// Draws nanoseconds a robot-step and peak memory over 1 to 100,000 robots as an SVG file.
///
/// # Errors
/// When the file cannot be written.
pub fn scaling(figures: &[Figure], path: &Path) -> Result<()> {
    let failed = |e: &dyn std::fmt::Display| anyhow!("drawing {}: {e}", path.display());
    let root = SVGBackend::new(path, (900, 380)).into_drawing_area();
    root.fill(&WHITE).map_err(|e| failed(&e))?;
    let (left, right) = root.split_horizontally(450);
    type Value = fn(&Figure) -> f64;
    let panels: [(_, &str, std::ops::Range<f64>, Value); 2] = [
        (&left, "CPU ns a robot-step (median)", 50.0..10_000.0, |f| {
            f.median_ns
        }),
        (&right, "peak resident memory, MB", 1.0..10_000.0, |f| {
            f.peak_bytes.map_or(f64::NAN, |bytes| bytes as f64 / 1e6)
        }),
    ];
    for (area, title, range, value) in panels {
        let mut chart = ChartBuilder::on(area)
            .caption(title, ("sans-serif", 16))
            .margin(12)
            .x_label_area_size(36)
            .y_label_area_size(64)
            .build_cartesian_2d((1.0..100_000.0_f64).log_scale(), range.log_scale())
            .map_err(|e| failed(&e))?;
        chart
            .configure_mesh()
            .x_desc("robots in one arena, 0.036 m2 each")
            .light_line_style(WHITE)
            .draw()
            .map_err(|e| failed(&e))?;
        for ((prefix, suffix, label), colour) in SCALING.into_iter().zip(COLOURS) {
            let points: Vec<_> = figures
                .iter()
                .filter_map(|f| Some((robots_of(&f.name, prefix, suffix)? as f64, value(f))))
                .filter(|(_, value)| value.is_finite())
                .collect();
            let line = LineSeries::new(points.clone(), colour.stroke_width(2));
            chart
                .draw_series(line)
                .map_err(|e| failed(&e))?
                .label(label)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], colour));
            let marks = points
                .iter()
                .map(|point| Circle::new(*point, 3, colour.filled()));
            chart.draw_series(marks).map_err(|e| failed(&e))?;
        }
        legend(&mut chart).map_err(|e| failed(&e))?;
    }
    root.present().map_err(|e| failed(&e))
}

/// Draws how many times as fast worlds are stepped on several threads as an SVG file.
///
/// # Errors
/// When the file cannot be written.
pub fn threads(gains: &[Gain], path: &Path) -> Result<()> {
    let failed = |e: &dyn std::fmt::Display| anyhow!("drawing {}: {e}", path.display());
    let points = gains.iter().flat_map(|gain| &gain.points);
    let most = points.map(|point| point.threads).max().unwrap_or(1) as f64;
    let root = SVGBackend::new(path, (520, 380)).into_drawing_area();
    root.fill(&WHITE).map_err(|e| failed(&e))?;
    let mut chart = ChartBuilder::on(&root)
        .caption(
            "speed-up of one world (median wall time)",
            ("sans-serif", 16),
        )
        .margin(12)
        .x_label_area_size(36)
        .y_label_area_size(48)
        .build_cartesian_2d(1.0..most.max(1.1), 0.5..most + 0.5)
        .map_err(|e| failed(&e))?;
    chart
        .configure_mesh()
        .x_desc("threads")
        .x_labels(most as usize)
        .light_line_style(WHITE)
        .draw()
        .map_err(|e| failed(&e))?;
    let even = LineSeries::new([(1.0, 1.0), (most, most)], BLACK.mix(0.3));
    chart.draw_series(even).map_err(|e| failed(&e))?;
    for (gain, colour) in gains.iter().zip(COLOURS) {
        let alone_ns = gain.points[0].median_ns;
        let points = gain
            .points
            .iter()
            .map(|point| (point.threads as f64, alone_ns / point.median_ns));
        let line = LineSeries::new(points.clone(), colour.stroke_width(2)).point_size(3);
        chart
            .draw_series(line)
            .map_err(|e| failed(&e))?
            .label(gain.name.trim_start_matches("kinematic/"))
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], colour));
    }
    legend(&mut chart).map_err(|e| failed(&e))?;
    root.present().map_err(|e| failed(&e))
}

/// What the lines of a chart are, within it.
fn legend<'a, X: Ranged, Y: Ranged>(
    chart: &mut ChartContext<'a, SVGBackend<'a>, Cartesian2d<X, Y>>,
) -> Result<(), DrawingAreaErrorKind<std::io::Error>> {
    chart
        .configure_series_labels()
        .border_style(BLACK)
        .background_style(WHITE)
        .position(SeriesLabelPosition::UpperLeft)
        .draw()
}
