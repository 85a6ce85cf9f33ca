//! Wide trees: nodes with eight children, tested at once.

mod arena;
mod batch;
mod box_ray;
mod boxes;
mod collapse;
mod node;
mod packet;
mod progress;
mod queries;
mod refit;
mod traverse;
mod triangle_ray;
mod triangles;
#[cfg(feature = "cache")]
mod validate;

#[cfg(feature = "cache")]
pub(crate) use arena::Arena;
#[cfg(feature = "cache")]
pub(crate) use arena::LEAF_LINES;
pub(crate) use arena::{Child, Line, MAX_LINES};
pub(crate) use batch::{LARGE, answer_many};
pub(crate) use boxes::boxes;
pub(crate) use collapse::{BinaryTree, LeafWriter, WideTree, collapse, with_small_leaves};
pub(crate) use node::{CompactNode, FullNode};
pub(crate) use progress::{NoWideTree, Watch};
pub(crate) use queries::{All, Answered, AnyQuery, ClosestQuery, answer};
pub(crate) use refit::refit;
pub(crate) use traverse::{Query, traverse};
pub(crate) use triangles::{Blocks, Compact, TriangleWriter, Triangles, leaf_cost};
#[cfg(feature = "build")]
pub(crate) use triangles::{LEAF_COST, TRIANGLE_COST, prefetch_vertices};
#[cfg(feature = "cache")]
pub use validate::InvalidWideTree;
#[cfg(feature = "cache")]
pub(crate) use validate::{WideCounts, validate, validate_alone};
