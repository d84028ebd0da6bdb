//! The same as [`crate::evaluate`], in vector code on all cores, for machines without a GPU; and all else that
//! has threads.
//!
//! What is here equals its meaning there, which tests check. Loops run over arrays of a fixed number of
//! lanes, which the compiler makes vector code of; `pulp` chooses at run time between its versions for
//! AVX-512, for AVX2 and for any processor.

pub mod sphere_shadows;

use rayon::prelude::*;

/// What `of` makes of each of `items`, in their order.
pub(crate) fn on_all_cores<T: Sync, U: Send>(items: &[T], of: impl Fn(&T) -> U + Sync + Send) -> Vec<U> {
    items.par_iter().map(of).collect()
}
