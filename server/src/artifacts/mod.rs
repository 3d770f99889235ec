//! What a finished run leaves behind: files of a result directory, and the same as bytes for HTTP.
//!
//! Everything but `timing.json` is a pure function of the run, down to the bytes of the picture.

mod directory;
mod files;
mod fractions;
mod metrics;
mod npy;
mod objects;
mod palette;
mod picture;
mod pushed;
mod raster;
mod scene;
mod tables;
mod timing;
mod vector;

pub use directory::{Finished, WriteError, is_complete, write_directory};
pub use files::{Maker, Material, RUN_FILES, RunFile};
pub use metrics::{metrics_csv, metrics_json, robots_csv};
pub use npy::visits_npy;
pub use objects::{objects_csv, objects_json};
pub use pushed::{Pushed, pushed};
pub use raster::png_of_rgb;
pub use tables::{coverage_csv, coverage_json, curve_csv, memory_plan, run_result};
pub use timing::{Timing, process_cpu_s, thread_cpu_s};

use arenas::Arena;

/// The visits over the arena's walls, with axes and a legend, as a PNG.
///
/// `visits` and `reachable` hold a value for each of the arena's squares, row 0 the lowest y.
/// Squares that are not reachable are hatched. Equal input gives equal bytes on every machine.
pub fn coverage_png(
    arena: &Arena,
    visits: &[u32],
    reachable: Option<&[bool]>,
    objects: &[Pushed],
) -> Vec<u8> {
    raster::png(&picture::coverage(arena, visits, reachable, objects))
}

/// The same picture as [`coverage_png`] as SVG.
pub fn coverage_svg(
    arena: &Arena,
    visits: &[u32],
    reachable: Option<&[bool]>,
    objects: &[Pushed],
) -> String {
    vector::svg(&picture::coverage(arena, visits, reachable, objects))
}

#[cfg(test)]
mod tests;
