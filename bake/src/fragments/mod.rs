//! What is seen of a scene in each pixel, surface by surface, on its way from paths to images: in tiles of the film
//! that logs keep, as sums of channels that a method gives a meaning to, and without their noise.
//!
//! A *fragment* is what one class of materials shows in one pixel: each that varies is a class, and everything fixed
//! is the last.

mod filtered;
mod pixel;
mod records;
mod tiles;

pub use filtered::Filtered;
pub use pixel::{PixelRecord, PixelRecords, trace};
pub use records::{Channels, Record, Records};
pub use tiles::{SIDE, Tile, TileFragment, pixels_of, tiles_of};
