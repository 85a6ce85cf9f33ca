//! Wide trees: nodes with eight children, tested at once.

mod arena;
mod box_ray;
mod collapse;
mod traverse;
mod triangle_ray;
mod triangles;

pub(crate) use arena::{Arena, Child, Line, MAX_LINES, NODE_LINES, Node};
pub(crate) use box_ray::BoxRay;
pub(crate) use collapse::{LeafWriter, WideTree, collapse};
pub(crate) use traverse::{Query, Traversal};
pub(crate) use triangle_ray::{Candidates, TriangleRay};
pub(crate) use triangles::{TriangleBlocks, TriangleLeaf};
