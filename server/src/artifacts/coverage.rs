//! The picture of coverage, in each of its formats.

use arenas::Arena;

use super::pushed::Pushed;
use super::{picture, raster, vector};

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
