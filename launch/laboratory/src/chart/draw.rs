//! The drawings, made of rows of the table alone.

mod bars;
mod curves;
mod map;
pub mod style;

pub use bars::{models, steps};
pub use curves::precision;
pub use map::failures;
