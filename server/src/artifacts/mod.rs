//! What a finished run leaves behind: files of a result directory, and the same as bytes for HTTP.
//!
//! Everything but `timing.json` is a pure function of the run, down to the bytes of the picture.

mod coverage;
mod directory;
mod files;
mod fractions;
mod metrics;
mod npy;
mod objects;
mod palette;
mod picture;
mod pushed;
mod put;
mod raster;
mod scene;
mod tables;
mod timing;
mod vector;

pub use coverage::{coverage_png, coverage_svg};
pub use directory::{Finished, STAGED, is_complete, write_directory};
pub use files::{Maker, Material, RUN_FILES, RunFile};
pub use metrics::{metrics_csv, metrics_json, robots_csv};
pub use npy::visits_npy;
pub use objects::{objects_csv, objects_json};
pub use pushed::{Pushed, pushed};
pub use put::WriteError;
pub use raster::png_of_rgb;
pub use tables::{
    coverage_csv, coverage_json, curve_csv, curve_row, memory, memory_plan, run_result,
};
pub use timing::{Timing, process_cpu_s, thread_cpu_s};

#[cfg(test)]
mod tests;
