//! The same as [`crate::evaluate`], in vector code on all cores, for machines without a GPU.
//!
//! What is here equals its meaning there, which tests check. Loops run over arrays of a fixed number of
//! lanes, which the compiler makes vector code of; `pulp` chooses at run time between its versions for
//! AVX-512, for AVX2 and for any processor.

pub mod sphere_shadows;
