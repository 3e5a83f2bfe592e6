//! The same functions over columns, compiled for every instruction set.
//!
//! A kernel here is a loop over the scalar function of the same name, inlined: one formula, one place. The first output
//! column's length is the number of rows; a shorter column panics, and what a longer one has beyond is left alone.

pub mod fresnel;
pub mod refraction;
