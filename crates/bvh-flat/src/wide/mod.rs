//! Wide trees: nodes with eight children, tested at once.

mod arena;
mod box_ray;
mod collapse;
mod traverse;
mod triangle_ray;
mod triangles;

pub(crate) use arena::Child;
pub(crate) use collapse::{WideTree, collapse};
pub(crate) use traverse::{Query, Traversal};
pub(crate) use triangle_ray::{Candidates, TriangleRay};
pub(crate) use triangles::{TriangleBlocks, TriangleLeaf};
