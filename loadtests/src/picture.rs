//! Cost against robots, and memory against robots, as one picture.

use std::path::Path;

use anyhow::{Result, anyhow};
use plotters::prelude::*;

use crate::measure::Figure;

/// (robots, figure) of a series of cases named `prefix/ROBOTS/suffix`.
fn series<'a>(figures: &'a [Figure], prefix: &str, suffix: &str) -> Vec<(f64, &'a Figure)> {
    figures
        .iter()
        .filter_map(|figure| {
            let rest = figure.name.strip_prefix(prefix)?.strip_suffix(suffix)?;
            Some((rest.parse().ok()?, figure))
        })
        .collect()
}

/// Draws nanoseconds and bytes a robot over 1 to 100,000 robots as an SVG file.
///
/// # Errors
/// When the file cannot be written.
pub fn scaling(figures: &[Figure], path: &Path) -> Result<()> {
    let failed = |e: &dyn std::fmt::Display| anyhow!("drawing {}: {e}", path.display());
    let root = SVGBackend::new(path, (900, 380)).into_drawing_area();
    root.fill(&WHITE).map_err(|e| failed(&e))?;
    let (left, right) = root.split_horizontally(450);
    let kinds = [
        (
            "kinematic/swarm/",
            "/brownian",
            "kinematic, brownian",
            RGBColor(0, 114, 178),
        ),
        (
            "kinematic/swarm/",
            "/im",
            "kinematic, im",
            RGBColor(213, 94, 0),
        ),
        (
            "rapier/swarm/",
            "/brownian",
            "rapier, brownian",
            RGBColor(0, 158, 115),
        ),
    ];
    type Value = fn(&Figure) -> f64;
    let panels: [(_, &str, std::ops::Range<f64>, Value); 2] = [
        (&left, "CPU ns a robot-step (median)", 50.0..10_000.0, |f| {
            f.median_ns
        }),
        (&right, "bytes a robot", 100.0..1_000_000.0, |f| {
            f.bytes_per_robot.unwrap_or(0) as f64
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
        for (prefix, suffix, label, colour) in kinds {
            let points: Vec<_> = series(figures, prefix, suffix)
                .iter()
                .map(|(n, f)| (*n, value(f)))
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
        chart
            .configure_series_labels()
            .border_style(BLACK)
            .background_style(WHITE)
            .position(SeriesLabelPosition::UpperRight)
            .draw()
            .map_err(|e| failed(&e))?;
    }
    root.present().map_err(|e| failed(&e))
}
