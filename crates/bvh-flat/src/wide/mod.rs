//! Wide trees: nodes with eight children, tested at once.

mod arena;
mod batch;
mod box_ray;
mod collapse;
mod queries;
mod traverse;
mod triangle_ray;
mod triangles;

pub(crate) use arena::{Child, Line};
#[cfg(feature = "build")]
pub(crate) use arena::{MAX_LINES, NODE_LINES};
pub(crate) use batch::{LARGE_FOR_ANY, LARGE_FOR_CLOSEST, Many};
pub(crate) use collapse::{LeafWriter, WideTree, collapse};
pub(crate) use queries::{All, Answered, AnyQuery, ClosestQuery, One};
pub(crate) use traverse::{Query, traverse};
pub(crate) use triangles::TriangleBlocks;
