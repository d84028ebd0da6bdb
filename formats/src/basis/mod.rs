//! The bases that stored numbers refer to.

pub mod brdf_grid;
pub mod lobe_table;
