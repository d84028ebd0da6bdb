//! Takes the noise out of pictures that are sums of other pictures.
//!
//! What is stored are images whose weighted sums are pictures, and the weights are not known yet. So the
//! filter is linear and knows nothing of materials that vary: what it makes of a sum is the sum of what it
//! makes of its parts. A *fragment* is what one class of surfaces shows in one pixel; every fragment becomes
//! a weighted sum of its neighbours of the same class. Light is filtered in [`seen::LAYERS`] by how often it
//! was reflected, for direct light has sharp shadows and little noise, and what was reflected before is the
//! other way round.
//!
//! * [`seen`]: what paths tell of a fragment beside what is stored: where it is, and what it shows in a few
//!   states, in two halves of the samples;
//! * [`film`]: all fragments, and which are neighbours;
//! * [`likeness`]: how alike fragments look (Rousselle et al. 2012, patches of guides);
//! * [`row`]: weights of one fragment's neighbours: a first-order fit (Bitterli et al. 2016);
//! * [`errors`]: what fragments would be off by, estimated from the two halves;
//! * [`choice`]: how strong the filter is where, and what comes of it;
//! * [`pictures`]: pictures of states as they come out of a bake.
//!
//! After NFOR (Bitterli et al. 2016, "Nonlinearly Weighted First-order Regression for Denoising Monte Carlo
//! Renderings"), but that weights of neighbours are never negative: no place gets less than no light. Rows
//! are 1 in all, but the weights that a fragment has in all rows are not: light is kept about, not exactly.

mod choice;
mod errors;
mod film;
mod likeness;
pub mod pictures;
mod row;
pub mod seen;

#[cfg(test)]
mod tests;

/// Side of the squares of pixels whose fragments are filtered together. Neighbours are in the squares next to
/// it.
pub const TILE: i32 = 16;
const _: () = assert!(RADIUS <= TILE);

pub use choice::{Filter, expected_errors, noise_of};
pub use errors::Noise;
pub use film::{Film, Fragment};
pub use row::{RADIUS, Row};
pub use seen::{LAYERS, Layer, Seen, Watcher, matt_where_it_varies};
