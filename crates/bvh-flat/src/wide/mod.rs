//! Wide trees: nodes with eight children, tested at once.

mod arena;
mod box_ray;
mod collapse;
mod queries;
mod traverse;
mod triangle_ray;
mod triangles;

#[cfg(feature = "build")]
pub(crate) use arena::{MAX_LINES, NODE_LINES};
pub(crate) use collapse::{WideTree, collapse};
pub(crate) use queries::{All, Any, Asked, Closest};
pub(crate) use triangles::TriangleBlocks;
